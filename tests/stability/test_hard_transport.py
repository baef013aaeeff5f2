"""Light that is scattered very often, trapped, or turned as sharply as numbers allow: against closed forms."""

import numpy as np
import pytest
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import (
    AreaLight,
    Output,
    PointLight,
    Quantity,
    SunLight,
    UniformWorld,
)
from lumenray.engine.scene.material import (
    Black,
    Cauchy,
    Coated,
    Conductor,
    Dielectric,
    Emission,
    Glossy,
    Material,
    ThinGlass,
)
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.session import Session

pytestmark = pytest.mark.mitsuba

UP = np.array([0.0, 0.0, 1.0])
INDEX = 1.5
GLASS = Material("glass", "glass", Dielectric(Cauchy(INDEX)))
BLACK = Material("black", "black", Black())


def assert_agrees(made, expected, relative=1e-3, error=0.01):
    """Within 3.5 standard errors and a share of the value, the standard error being within a share of it."""
    expected = np.broadcast_to(expected, made.illuminance.shape)
    assert (made.standard_error <= error * expected).all(), made.standard_error / expected
    difference = np.abs(made.illuminance - expected)
    allowed = 3.5 * made.standard_error + relative * expected
    assert (difference <= allowed).all(), (made.illuminance, expected, made.standard_error)


# ---- a hundred reflections ----


@pytest.mark.parametrize("reflectance", [0.95, 0.99])
@pytest.mark.slow
def test_a_furnace_that_reflects_ninety_nine_percent(transport, reflectance):
    # Owed: pi L / (1 - rho) within 3.5 errors and 0.1 %, noise of 1 %. The mean path has 100 scatterings, so a share of 1e-5
    # that is lost at each would show, and roulette must not make the variance infinite.
    walls = paint(reflectance, emission=Emission(Constant(1.0), 100.0))
    places = np.array([[1.0, 1.0, 0.0], [0.3, 0.2, 0.0], [0.9, 0.2, 1.0], [1.5, 1.6, 0.4]])
    made = session_of(box(2.0, 2.0, 2.0), walls).measure(
        places, np.tile(UP, (4, 1)), StopRule(samples=1 << 14), transport=transport
    )
    assert_agrees(made, np.pi * 100.0 / (1.0 - reflectance))


# ---- glass ----


def fresnel(cosine, index):
    """Unpolarised reflectance of a boundary, light from outside. [-]"""
    inside = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    s = ((cosine - index * inside) / (cosine + index * inside)) ** 2
    p = ((index * cosine - inside) / (index * cosine + inside)) ** 2
    return s, p


def stack_transmittance(kind, count):
    """Share of an even hemisphere's light that a stack without absorption lets pass, all reflections between counted.

    Of layers in a row that absorb nothing the ratios of what is reflected to what is transmitted add up.
    """
    edges = np.linspace(0.0, 1.0, 200001)
    square = 0.5 * (edges[1:] + edges[:-1])
    s, p = fresnel(np.sqrt(square), INDEX)
    if kind == "panes":
        # Panes of two boundaries each, by each polarisation.
        ratios = [2 * count * each / (1.0 - each) for each in (s, p)]
    else:
        reflected = 0.5 * (s + p)
        ratios = [2 * count * reflected / (1.0 - reflected)]
    # Cosine-weighted: 2 sin cos dtheta is -d(cos^2).
    return float(np.mean([1.0 / (1.0 + ratio) for ratio in ratios]))


def stack(kind, count):
    """Panes or slabs one above the other from 1 m upwards, 400 m wide."""
    made = []
    for i in range(count):
        z = 1.0 + i
        if kind == "panes":
            made.append(quad(f"pane {i}", (-200, -200, z), (400, 0, 0), (0, 400, 0), "pane"))
        else:
            slab = box(400.0, 400.0, 0.5, "glass", inwards=False)
            vertices = slab.vertices + np.array([-200.0, -200.0, z])
            made.append(
                Mesh(f"s{i}", "s", vertices, slab.triangles, ("glass",), slab.material_index)
            )
    return [*made, GLASS, Material("pane", "pane", ThinGlass(INDEX, Constant(1.0)))]


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("count", [1, 5])
@pytest.mark.parametrize("kind", ["panes", "slabs"])
def test_a_stack_of_glass_keeps_all_light(kind, count):
    # Owed: what passes within 3.5 errors and 0.2 % (1 / 400 of the sky is seen past the rims), and what passes and what
    # comes back together all of it.
    sky = 100.0
    floor = quad("floor", (-2000, -2000, -1), (4000, 0, 0), (0, 4000, 0), "black")
    made = session_of(*stack(kind, count), floor, BLACK, UniformWorld(sky)).measure(
        [[0, 0, 0.9], [0, 0, count + 1.1]], [UP, -UP], StopRule(samples=1 << 16)
    )
    share = stack_transmittance(kind, count)
    assert_agrees(made, np.pi * sky * np.array([share, 1.0 - share]), 2e-3)
    whole, error = made.illuminance.sum(), np.hypot(*made.standard_error)
    assert abs(whole - np.pi * sky) < 3.5 * error + 1e-3 * np.pi * sky


@pytest.mark.parametrize("kind", ["panes", "slabs"])
def test_glass_in_an_even_world_cannot_be_seen(kind):
    # Owed: pi L within 3.5 errors and 0.05 %, noise of 0.1 %: what a lossless stack does not pass it reflects, and both are
    # the same. A path weighs 1 / n^2 inside glass and 1 outside, which roulette must not take for a loss.
    made = session_of(*stack(kind, 3), UniformWorld(100.0)).measure(
        [[0, 0, 0.5], [0, 0, 1.8], [0, 0, 9.0]], [UP, UP, -UP], StopRule(samples=1 << 18)
    )
    assert_agrees(made, 100.0 * np.pi, 5e-4, 1e-3)


GAP = 2e-4
"""From glass to sensors that look at it: beyond the distance below which they count as lying on it. [m]"""


def face(z, half, count, normal):
    """Places in a regular pattern on a square, and their normals; each stands for an equal area."""
    steps = ((np.arange(count) + 0.5) / count * 2.0 - 1.0) * half
    x, y = np.meshgrid(steps, steps)
    places = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)])
    return places, np.tile(normal, (len(places), 1))


def assert_flux(made, area, expected):
    """Mean over a face times its area: 0.5 % and 3.5 errors, of which at most 0.5 %."""
    flux = made.illuminance.mean() * area
    error = np.sqrt((made.standard_error**2).sum()) / len(made.illuminance) * area
    assert error < 5e-3 * expected, (error, expected)
    assert abs(flux - expected) < 3.5 * error + 5e-3 * expected, (flux, error, expected)


def glass_block(half):
    """Block around the origin."""
    block = box(2.0 * half, 2.0 * half, 2.0 * half, "glass", inwards=False)
    return Mesh("b", "b", block.vertices - half, block.triangles, ("glass",), block.material_index)


def test_a_lamp_in_a_clear_block_loses_what_is_reflected_for_ever():
    # Owed: 0.5 % of the flux that leaves. In a block without absorption a ray keeps the sizes of its direction's components,
    # so it leaves at last if one of them is above the cosine of the critical angle, and never otherwise: of a lamp's light
    # 3 (1 - sqrt(1 - 1 / n^2)) leaves, a sixth of it by each face.
    lumens = 600.0
    ball = PointLight("l", "l", Output(Quantity.LUMINOUS_FLUX, lumens), np.zeros(3), 0.25)
    places, normals = face(0.5 + GAP, 0.5, 40, -UP)
    made = session_of(glass_block(0.5), GLASS, ball).measure(
        places, normals, StopRule(samples=1 << 9)
    )
    leaves = 3.0 * (1.0 - np.sqrt(1.0 - 1.0 / INDEX**2))
    assert_flux(made, 1.0, lumens * leaves / 6.0)


def test_a_lamp_under_a_glass_surface_sends_out_what_its_cone_lets_pass():
    # Owed: 0.5 %. All but the upper face absorbs: half of the lamp's light times the integral of the transmittance over
    # the directions within the critical angle.
    lumens = 600.0
    ball = PointLight("l", "l", Output(Quantity.LUMINOUS_FLUX, lumens), np.array([0, 0, -0.4]), 0.2)
    block = glass_block(1.0)
    corners = block.vertices[block.triangles][..., 2]
    is_top = (corners > 0.99).all(axis=1)
    half_block = Mesh(
        "b",
        "b",
        block.vertices - UP,
        block.triangles,
        ("black", "glass"),
        is_top.astype(np.int32),
    )
    # By the sine outside, whose square is n^2 times that inside.
    edges = np.linspace(0.0, 1.0, 200001)
    outside = 0.5 * (edges[1:] + edges[:-1])
    s, p = fresnel(np.sqrt(1.0 - outside**2), INDEX)
    inside = outside / INDEX
    passing = (1.0 - 0.5 * (s + p)) * inside / np.sqrt(1.0 - inside**2) / INDEX
    places, normals = face(GAP, 1.0, 40, -UP)
    made = session_of(half_block, GLASS, BLACK, ball).measure(
        places, normals, StopRule(samples=1 << 9)
    )
    assert_flux(made, 4.0, 0.5 * lumens * passing.mean())


def prism():
    """Right-angled prism: its short faces at x = 0 and z = 0, the long one between, 2 m long in y."""
    vertices = np.array([[x, y, z] for y in (-1, 1) for x, z in ((0, 0), (1, 0), (0, 1))], float)
    triangles = np.array(
        [[0, 1, 2], [3, 5, 4], [0, 3, 4], [0, 4, 1], [0, 2, 5], [0, 5, 3], [1, 4, 5], [1, 5, 2]],
        np.int32,
    )
    return Mesh("p", "p", vertices, triangles, ("glass",), np.zeros(8, np.int32))


@pytest.mark.slow
def test_a_prism_beyond_the_critical_angle_turns_all_light():
    # Owed: exactly 0 behind the long face, which light meets at 45 degrees and glass of 1.5 reflects from 41.8 on; below the
    # other short face the sun times (1 - R)^2 at nearly normal incidence, to 0.5 %.
    lux = 1e4
    towards = np.array([-1.0, 0.0, 0.0])
    sun = SunLight("s", "s", Output(Quantity.ILLUMINANCE, lux), -towards, np.radians(8.0))
    # What would shine along under the prism.
    skirt = quad("skirt", (-1e-3, -3, -2), (0, 6, 0), (0, 0, 2), "black")
    places = np.array([[0.6, 0.0, 0.6], [0.52, 0.1, 0.5], [0.4, 0.0, -1e-3], [0.5, 0.1, -1e-3]])
    slope = np.array([-1.0, 0.0, -1.0]) / np.sqrt(2.0)
    made = session_of(prism(), GLASS, skirt, BLACK, sun).measure(
        places, [slope, towards, UP, UP], StopRule(samples=1 << 19)
    )
    assert (made.illuminance[:2] == 0.0).all()
    assert (made.standard_error[:2] == 0.0).all()
    single = ((INDEX - 1.0) / (INDEX + 1.0)) ** 2
    # Light of the disk meets the faces at up to 4 degrees: there R is that of 0 to 1e-5, and the mean cosine 0.9988.
    expected = lux * (1.0 - single) ** 2
    found, error = made.illuminance[2:], made.standard_error[2:]
    assert (error < 0.03 * expected).all()
    assert (np.abs(found - expected) < 3.5 * error + 5e-3 * expected).all(), (found, error)


# ---- almost mirrors ----

JUST_BELOW, JUST_ABOVE = 0.0299, 0.0301
"""Roughnesses on both sides of the one from which a surface is no ideal mirror."""


@pytest.mark.parametrize("roughness", [0.0, JUST_BELOW, JUST_ABOVE, 0.05])
@pytest.mark.slow
def test_an_almost_perfect_mirror_shows_the_image_of_the_lamp(roughness):
    # Owed: the illuminance by the lamp's image times the reflectance, within 3.5 errors and 0.3 %: a lobe of a tenth of a
    # degree cannot show at a disk of 28 degrees, and no step must show where the model changes.
    frame = np.eye(4)
    frame[2, 3] = 2.0
    lamp = AreaLight("l", "l", Output(Quantity.LUMINANCE, 1000.0), frame, 2.0, 2.0, "ellipse")
    mirror = Material("m", "m", Glossy(Constant(0.8), roughness))
    sheet = quad("sheet", (-50, -50, 0), (100, 0, 0), (0, 100, 0), "m")
    made = session_of(lamp, mirror, sheet).measure(
        [[0, 0, 2.0 + 1e-3]], [-UP], StopRule(samples=1 << 16)
    )
    # The image's disk, 4 m away, of 1 m radius.
    assert_agrees(made, 0.8 * np.pi * 1000.0 / (1.0 + (4.001) ** 2), 3e-3)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("roughness", [0.0, 0.01, JUST_BELOW, JUST_ABOVE, 0.04, 0.1])
@pytest.mark.parametrize(
    "surface",
    [
        lambda r: Glossy(Constant(1.0), r),
        lambda r: Coated(Constant(1.0), 1.5, r),
        lambda r: Conductor("Ag", r),
    ],
    ids=["glossy", "coated", "conductor"],
)
def test_smooth_surfaces_make_no_light(surface, roughness):
    # Owed: never more than all, to 0.05 % of even light and 0.2 % of light from one direction, as grazing as it may be; a
    # white mirror's lobe gives all of it back but for what masking takes, which is 0.1 % up to 80 degrees.
    angles = [0.0, 30.0, 60.0, 80.0, 88.0, 89.0, 89.5, 89.9]
    made = Session(witness=False).probe(surface(roughness), angles, 1 << 14)
    assert np.isfinite(made.reflectance).all()
    assert (made.reflectance <= 1.0 + 3.5 * made.reflectance_error + 2e-3).all(), made.reflectance
    even = Session(witness=False).probe(surface(roughness), samples=1 << 16)
    assert even.reflectance[0] <= 1.0 + 3.5 * even.reflectance_error[0] + 5e-4
    if isinstance(surface(roughness), Glossy) and roughness <= 0.04:
        np.testing.assert_allclose(made.reflectance[:4], 1.0, atol=1e-3)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("roughness", [JUST_BELOW, JUST_ABOVE])
@pytest.mark.parametrize(
    "surface",
    [lambda r: Glossy(Constant(1.0), r), lambda r: Coated(Constant(1.0), 1.5, r)],
    ids=["glossy", "coated"],
)
def test_a_white_floor_that_shines_is_no_brighter_than_the_sky(surface, roughness):
    # Owed: at most pi L (to 0.1 %), and of the mirror all of it.
    floor = quad("floor", (-500, -500, 0), (1000, 0, 0), (0, 1000, 0), "m")
    made = session_of(floor, Material("m", "m", surface(roughness)), UniformWorld(100.0)).measure(
        [[0, 0, 1.0]], [-UP], StopRule(samples=1 << 14)
    )
    share = made.illuminance[0] / (100.0 * np.pi)
    error = made.standard_error[0] / (100.0 * np.pi)
    assert error < 5e-3
    assert share < 1.0 + 3.5 * error + 1e-3
    assert share > (0.995 if isinstance(surface(roughness), Glossy) else 0.9)
