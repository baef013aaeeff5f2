"""Every kind of light gives the illuminance that its unit promises, in both transports.

The tests of 100 lm are the ones that BlendLuxCore/LuxCore users asked for (LuxCore #580). Sensors lie 0.1 mm above their
point, so distances are that much shorter; the expected values say so.
"""

import math

import numpy as np
import pytest
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.checks import check_item
from lumenray.engine.scene.light import (
    AreaLight,
    Output,
    PointLight,
    Quantity,
    SpotLight,
    SunLight,
    UniformWorld,
)
from lumenray.engine.scene.material import Black, Emission, Material
from lumenray.engine.scene.spectrum import Blackbody, Constant, Illuminant, Rgb

FLUX = Quantity.LUMINOUS_FLUX
SPECTRA = [
    Illuminant("D65"),
    Blackbody(2700.0),
    Illuminant("FL11"),
    Rgb(1.0, 0.2, 0.1),
    Constant(1.0),
]


def read(items, transport, position=(0, 0, 0), normal=(0, 0, 1), samples=1 << 15):
    """Illuminance at one sensor and its standard error."""
    made = session_of(*items).measure(
        [position], [normal], StopRule(samples=samples), seed=3, transport=transport
    )
    return made.illuminance[0], made.standard_error[0]


def assert_agrees(found, expected, bound=0.002):
    """Within three standard errors, which must themselves be small, and rounding of single precision."""
    value, error = found
    assert error < bound * expected, f"the error {error} lx is too large to tell anything"
    assert abs(value - expected) < 3.0 * error + 1e-4 * expected, (
        f"{value} ± {error}, expected {expected}"
    )


def point(output, radius=0.0):
    return PointLight("light", "light", output, np.array([0.0, 0.0, 1.0]), radius)


def frame_at(height):
    frame = np.eye(4)
    frame[2, 3] = height
    return frame


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("spectrum", SPECTRA, ids=lambda s: str(s)[:30])
def test_a_point_of_100_lm_gives_7_96_lx_at_1_m_whatever_its_spectrum(transport, spectrum):
    expected = 100.0 / (4.0 * np.pi)
    assert_agrees(read([point(Output(FLUX, 100.0, spectrum))], transport), expected)


def test_a_sphere_of_100_lm_obeys_the_inverse_square_law_outside(transport):
    # A uniform sphere acts on a plane that faces it exactly like a point at its centre.
    expected = 100.0 / (4.0 * np.pi)
    assert_agrees(read([point(Output(FLUX, 100.0), radius=0.2)], transport), expected)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("shape", ["rectangle", "ellipse"])
def test_a_small_lambertian_area_of_100_lm_gives_31_83_lx_on_its_axis_at_1_m(transport, shape):
    light = AreaLight("a", "a", Output(FLUX, 100.0), frame_at(1.0), 0.004, 0.004, shape)
    expected = 100.0 / np.pi
    assert_agrees(read([light], transport), expected)


def test_a_disk_of_given_luminance_follows_its_closed_form(transport):
    # On the axis: E = pi L r^2 / (r^2 + d^2).
    light = AreaLight(
        "a", "a", Output(Quantity.LUMINANCE, 1000.0), frame_at(1.0), 2.0, 2.0, "ellipse"
    )
    expected = np.pi * 1000.0 / 2.0
    assert_agrees(read([light], transport), expected)


def test_a_spread_area_light_keeps_its_flux(transport):
    # The flux through a black sphere around the light must be the stated one: mean illuminance times area.
    light = AreaLight(
        "a", "a", Output(FLUX, 100.0), np.eye(4), 0.01, 0.01, "rectangle", np.radians(70)
    )
    rng = np.random.default_rng(5)
    z = -rng.random(4000)
    phi = 2 * np.pi * rng.random(4000)
    places = np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=1)
    made = session_of(light).measure(places, -places, StopRule(samples=64), transport=transport)
    flux = made.illuminance.mean() * 2 * np.pi
    assert abs(flux - 100.0) < 3.0 * made.illuminance.std() / np.sqrt(4000) * 2 * np.pi


def test_a_spot_spreads_its_flux_over_its_cone(transport):
    half = np.radians(30.0)
    light = SpotLight(
        "s", "s", Output(FLUX, 100.0), np.array([0, 0, 1.0]), np.array([0, 0, -1.0]), half, 0.0
    )
    expected = 100.0 / (2 * np.pi * (1 - np.cos(half)))
    assert_agrees(read([light], transport), expected)
    assert read([light], transport, position=(0.7, 0, 0))[0] == 0.0


def test_a_blended_spot_keeps_its_flux():
    half = np.radians(40.0)
    light = SpotLight("s", "s", Output(FLUX, 100.0), np.zeros(3), np.array([0, 0, -1.0]), half, 0.6)
    # Quadrature over the cap: E at unit distance times area, evenly in the cosine.
    cosine = np.cos(half) + (1 - np.cos(half)) * (np.arange(400) + 0.5) / 400
    places = np.stack([np.sqrt(1 - cosine**2), 0 * cosine, -cosine], axis=1)
    made = session_of(light).measure(places, -places, StopRule(samples=32))
    flux = made.illuminance.mean() * 2 * np.pi * (1 - np.cos(half))
    assert abs(flux - 100.0) < 0.05


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("angle", [0.0, math.radians(0.53), math.radians(20.0)])
def test_a_sun_gives_the_stated_illuminance_of_a_facing_plane(transport, angle):
    light = SunLight("s", "s", Output(Quantity.ILLUMINANCE, 10000.0), np.array([0, 0, -1.0]), angle)
    value, error = read([light], transport)
    # The disk's own foreshortening is part of the definition, so any angle gives the same.
    assert abs(value - 10000.0) < 3.0 * error + 2.0


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("limb", [0.0, 0.6, 1.0])
@pytest.mark.parametrize("part", [None, -0.6, 0.0, 0.7])
def test_a_sun_darkened_at_its_limb_gives_all_its_light_and_less_from_its_edge(
    limb, part, transport
):
    """Behind a straight edge that covers what lies beyond a part of the radius, by an integral over the disk."""
    half, height = math.radians(4.0), 100.0
    output = Output(Quantity.ILLUMINANCE, 10000.0)
    sun = SunLight("s", "s", output, np.array([0, 0, -1.0]), 2.0 * half, limb)
    items, expected = [sun], 10000.0
    if part is not None:
        x, y = np.meshgrid(*2 * [(np.arange(1000) + 0.5) / 500 - 1.0])
        square = x**2 + y**2
        profile = np.where(
            square < 1.0, 1.0 - limb + limb * np.sqrt(np.maximum(1.0 - square, 0)), 0
        )
        expected *= profile[x < part].sum() / profile.sum()
        edge = height * math.tan(part * half)
        items += [quad("screen", (edge, -50, height), (50, 0, 0), (0, 100, 0), "black")]
        items += [paint(0.0, "black")]
    value, error = read(items, transport)
    # Chords and tangents are told apart by half a part of a thousand at 4 degrees.
    assert abs(value - expected) < 3.5 * error + 2e-3 * 10000.0


def test_limb_darkening_beyond_all_light_is_refused():
    output = Output(Quantity.ILLUMINANCE, 1.0)
    for limb in (-0.1, 1.1):
        with pytest.raises(SceneError, match="limb darkening"):
            check_item(SunLight("s", "s", output, np.array([0, 0, -1.0]), 0.1, limb))


def test_a_uniform_world_gives_pi_times_its_luminance(transport):
    assert_agrees(read([UniformWorld(100.0)], transport), 100.0 * np.pi)


def test_an_emitting_mesh_has_the_stated_luminance(transport):
    # A square of side 2 a at height h over its middle; closed form of the configuration factor.
    a, h = 0.5, 1.0
    side = a / np.sqrt(a**2 + h**2)
    factor = 4.0 * side / np.pi * np.arctan(side)
    panel = quad("panel", (-a, a, 1.0), (2 * a, 0, 0), (0, -2 * a, 0), "glow")
    glow = Material("glow", "glow", Black(), Emission(Constant(1.0), 2000.0, two_sided=False))
    assert_agrees(read([panel, glow], transport), np.pi * 2000.0 * factor)


def test_a_two_sided_mesh_emits_upwards_as_well(transport):
    panel = quad("panel", (-50, 50, 0.0), (100, 0, 0), (0, -100, 0), "glow")
    for two_sided, expected in ((True, np.pi * 100.0), (False, 0.0)):
        glow = Material(
            "glow", "glow", Black(), Emission(Constant(1.0), 100.0, two_sided=two_sided)
        )
        up = read([panel, glow], transport, position=(0, 0, 0.5), normal=(0, 0, -1))
        assert up[0] == pytest.approx(expected, rel=0.003)


def test_watts_become_lumens_by_the_efficacy_of_the_spectrum(transport):
    # Equal energy over 360..830 nm: K_m * 106.857 nm / 471 nm = 154.95 lm/W (1 nm sums).
    watts = Output(Quantity.RADIANT_FLUX, 1.0, Constant(1.0))
    expected = 683.002 * 106.856917 / 471.0 / (4 * np.pi)
    assert_agrees(read([point(watts)], transport), expected)


def test_a_luminance_of_an_ideal_point_is_refused_with_the_remedy():
    with pytest.raises(SceneError, match="intensity"):
        read([point(Output(Quantity.LUMINANCE, 100.0))], "mono")


def test_negative_output_is_refused():
    with pytest.raises(SceneError, match="at least 0"):
        read([point(Output(FLUX, float("nan")))], "mono")


def test_every_kind_of_light_that_stands_somewhere_can_be_computed():
    from lumenray.engine.scene.light import PlacedLight
    from lumenray.engine.transport.compiled.compiled_light import MAKERS

    kinds = {kind for shared in PlacedLight.__subclasses__() for kind in shared.__subclasses__()}
    assert kinds == set(MAKERS)
