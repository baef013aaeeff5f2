"""Fabrics: straight light by the law of roller blinds, all shares together, and light behind them."""

import numpy as np
import pytest
from baking_rooms import bake_in
from scipy.integrate import quad as integrate
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.materials.fabric import cutoff, mean_open_share, open_share
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, Quantity, SunLight, UniformWorld
from lumenray.engine.scene.material import Diffuse, Fabric, Material, Mix, Transparent
from lumenray.engine.scene.spectrum import Constant, Rgb
from lumenray.engine.sensitivity import measure_sensitivities
from lumenray.engine.transport import backend
from lumenray.engine.views import ViewSettings


def fabric(openness, reflectance, transmittance):
    return Fabric(openness, Constant(reflectance), Constant(transmittance))


def test_straight_light_follows_the_measured_law():
    # o = 0.05: c = 90 - 25 cos 4.5 deg = 65.077 deg, b = 0.6 cos(4.5 deg) ** 0.3 = 0.59944.
    end, exponent = cutoff(0.05)
    assert np.degrees(end) == pytest.approx(65.0771, abs=1e-4)
    assert exponent == pytest.approx(0.599444, abs=1e-5)
    shares = open_share(0.05, np.radians([0.0, 30.0, 65.0, 66.0]))
    # cos(90 deg * 30 / 65.0771) = 0.749135, to the power b 0.841059; at 65 deg 0.001861, 0.023071.
    assert shares == pytest.approx([0.05, 0.0420530, 0.0011535, 0.0], rel=2e-3)


@pytest.mark.parametrize("openness", [0.0, 0.03, 0.3, 0.9])
def test_the_mean_is_the_integral_of_the_law(openness):
    end = cutoff(openness)[0]
    expected = integrate(
        lambda angle: float(open_share(openness, angle)) * np.sin(2.0 * angle), 0.0, end
    )[0]
    assert mean_open_share(openness) == pytest.approx(expected, abs=2e-6)


def test_all_openings_are_no_fabric():
    assert open_share(1.0, np.radians([0.0, 45.0, 89.0])) == pytest.approx(1.0, abs=1e-4)
    assert mean_open_share(1.0) == pytest.approx(1.0, abs=1e-4)


def draw(surface, angle, count=1 << 17):
    """Directions, weights and straight ones of light that comes at an angle [degree]."""
    import mitsuba as mi

    from lumenray.engine.materials import plugins
    from lumenray.engine.transport.compiled.surfaces import bsdf
    from lumenray.engine.transport.compiled.textures import TextureMaker

    backend.start(spectral=True)
    plugins.register()
    plugin = mi.load_dict(bsdf(surface, TextureMaker(np.ones(471))))
    stream = mi.PCG32(size=count, initstate=3)
    si = view(angle, count)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    bs, weight = plugin.sample(mi.BSDFContext(), si, stream.next_float32(), sample, True)
    straight = np.array(mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null))
    return plugin, np.array(bs.wo.z), np.array(weight)[0], straight


def view(angle, count):
    import drjit as dr
    import mitsuba as mi

    si = dr.zeros(mi.SurfaceInteraction3f, count)
    si.wi = mi.Vector3f(float(np.sin(np.radians(angle))), 0.0, float(np.cos(np.radians(angle))))
    si.n, si.sh_frame = mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Normal3f(0, 0, 1))
    si.wavelengths = mi.Spectrum(450.0, 550.0, 600.0, 650.0)
    return si


@pytest.mark.parametrize("angle", [0.0, 40.0, 80.0, 130.0])
def test_each_share_of_light_is_what_is_stated(angle):
    _, height, weight, straight = draw(fabric(0.2, 0.5, 0.3), angle)
    passed = float(open_share(0.2, np.radians(min(angle, 180.0 - angle))))
    back = height * np.cos(np.radians(angle)) > 0.0
    count = len(weight)
    assert weight[straight].sum() / count == pytest.approx(passed, abs=0.005)
    assert weight[back].sum() / count == pytest.approx(0.5 * (1.0 - passed) / 0.8, abs=0.005)
    # 0.2 + 0.5 + 0.3: nothing is lost at any angle.
    assert weight.sum() / count == pytest.approx(1.0, abs=0.002)


def test_a_fabric_is_reciprocal():
    import mitsuba as mi

    plugin, *_ = draw(fabric(0.3, 0.4, 0.2), 0.0, 1)
    for there, back in ((20.0, 60.0), (50.0, 110.0), (5.0, 175.0)):
        values = []
        for start, end in ((there, back), (back, there)):
            wo = mi.Vector3f(float(np.sin(np.radians(end))), 0.0, float(np.cos(np.radians(end))))
            value = plugin.eval(mi.BSDFContext(), view(start, 1), wo, True)
            values.append(np.array(value)[0, 0] / abs(np.cos(np.radians(end))))
        assert values[0] == pytest.approx(values[1], rel=1e-4)
        assert values[0] > 0.0


def blind(surface):
    """A fabric of 400 x 400 m above the origin."""
    screen = quad("blind", (-200.0, -200.0, 0.05), (400.0, 0.0, 0.0), (0.0, 400.0, 0.0), "cloth")
    return screen, Material("cloth", "cloth", surface)


def below(*items, transport="mono", samples=1 << 15):
    made = session_of(*items).measure(
        [(0.3, 0.2, 0.0)], [(0.0, 0.0, 1.0)], StopRule(samples=samples), seed=4, transport=transport
    )
    return made.illuminance[0], made.standard_error[0]


@pytest.mark.parametrize("angle", [0.0, 40.0, 75.0])
def test_behind_a_blind_there_is_what_passes_straight_and_what_is_spread(angle):
    direction = np.array([np.sin(np.radians(angle)), 0.0, -np.cos(np.radians(angle))])
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 50000.0), direction, 0.0093)
    value, error = below(*blind(fabric(0.1, 0.4, 0.2)), sun)
    passed = float(open_share(0.1, np.radians(angle)))
    level = 50000.0 * np.cos(np.radians(angle))
    # What meets the yarns is spread over a plane that sees nothing but the blind.
    expected = level * (passed + 0.2 * (1.0 - passed) / 0.9)
    assert value == pytest.approx(expected, abs=4.0 * error + 2e-3 * expected)


def test_a_map_behind_a_blind_has_the_same_mean():
    direction = np.array([0.5, 0.0, -np.cos(np.radians(30.0))])
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 50000.0), direction, 0.0093)
    floor = quad("floor", (-0.5, -0.5, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), "paint")
    session = session_of(*blind(fabric(0.1, 0.4, 0.2)), floor, paint(0.0), sun)
    result = bake_in(session, ("floor",), 64)
    passed = float(open_share(0.1, np.radians(30.0)))
    expected = 50000.0 * np.cos(np.radians(30.0)) * (passed + 0.2 * (1.0 - passed) / 0.9)
    assert result.mean == pytest.approx(expected, rel=1e-3)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize(("way", "share"), [(-1.0, 0.4), (1.0, 0.3)])
def test_a_picture_shows_a_fabric_by_light_from_behind_and_from_the_front(transport, way, share):
    tilt = np.radians(40.0)
    direction = np.array([np.sin(tilt), 0.0, way * np.cos(tilt)])
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 50000.0), direction, 0.0093)
    # From below along the normal.
    camera = Camera(np.diag([1.0, -1.0, -1.0, 1.0]), Projection.PERSPECTIVE, 4, 4, 0.01, 0.01)
    session = session_of(*blind(fabric(0.2, 0.3, 0.4)), sun)
    picture = session.render(camera, ViewSettings(StopRule(samples=256), transport=transport))
    met = 50000.0 * np.cos(tilt) * (1.0 - float(open_share(0.2, tilt)))
    expected = share / np.pi * met / (1.0 - mean_open_share(0.2))
    assert picture.tristimulus[..., 1].mean() == pytest.approx(expected, rel=2e-3)


def exitance_over_illuminance(surface):
    """What a fabric under an even sky sends back of the light that it gets: Y over illuminance."""
    screen = quad("blind", (-0.5, -0.5, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), "cloth")
    session = session_of(screen, Material("cloth", "cloth", surface), UniformWorld(100.0))
    (page,) = bake_in(session, ("blind",), 16, exitance=True).pages
    own = page.covered & (page.illuminance > 0.0)
    return page.exitance[own][:, 1] / page.illuminance[own]


def test_a_surface_with_openings_has_an_exitance():
    grey = Mix(Transparent(), Diffuse(Constant(0.5)), 0.8)
    assert exitance_over_illuminance(grey) == pytest.approx(0.4, rel=1e-3)


@pytest.mark.parametrize("openness", [0.0, 0.05, 0.4])
def test_the_exitance_is_what_a_fabric_sends_back_of_even_light(openness):
    expected = 0.4 * (1.0 - mean_open_share(openness)) / (1.0 - openness)
    assert exitance_over_illuminance(fabric(openness, 0.4, 0.2)) == pytest.approx(
        expected, rel=1e-4
    )


@pytest.mark.parametrize("transport", ["mono", "spectral"])
def test_a_white_fabric_cannot_be_seen_in_an_even_world(transport):
    """Its own samples of the sky must not be aimed at itself."""
    value, error = below(
        *blind(fabric(0.2, 0.5, 0.3)), UniformWorld(100.0), transport=transport, samples=1 << 16
    )
    assert value == pytest.approx(100.0 * np.pi, abs=4.0 * error + 0.3)


@pytest.mark.parametrize(
    "surface", [fabric(0.1, 0.3, 0.0), fabric(0.1, 0.3, 0.2), fabric(0.3, 0.4, 0.3)]
)
def test_light_behind_a_blind_grows_with_all_that_passes_it(surface):
    """Straight light too: at normal incidence o + tau passes, 1 % more of 1 % more."""
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 5e4), np.array([0.0, 0.0, -1.0]), 0.0)
    made = measure_sensitivities(
        session_of(*blind(surface), sun),
        [(0.3, 0.2, 0.0)],
        [(0.0, 0.0, 1.0)],
        StopRule(samples=1 << 12),
        transport="mono",
    )
    assert made[0].mean == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize(
    ("surface", "message"),
    [
        (fabric(-0.1, 0.5, 0.0), "openness is -0.1, expected 0 to 1"),
        (fabric(0.3, 0.5, 0.3), "reflects 1.1 of the light"),
        (Fabric(0.3, Rgb(0.5, 0.8, 0.5)), "more than all of it"),
    ],
)
def test_a_fabric_that_makes_light_is_refused(surface, message):
    with pytest.raises(SceneError, match=message):
        below(*blind(surface), UniformWorld(100.0))
