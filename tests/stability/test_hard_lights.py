"""Lights of extreme number, strength and size: many, far apart in brightness, narrow, dark, or none."""

from dataclasses import replace

import numpy as np
import pytest
from luminaires import flux as flux_of
from luminaires import intensity, luminaire, turn
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.distribution import Opening
from lumenray.engine.scene.light import (
    AreaLight,
    CieSky,
    ImageWorld,
    Output,
    PointLight,
    Quantity,
    SpotLight,
    SunLight,
    UniformWorld,
)
from lumenray.engine.scene.material import Black, Emission, Material
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.spectrum import Constant, Illuminant
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

UP = np.array([0.0, 0.0, 1.0])
BLACK = Material("black", "black", Black())


# ---- many ----


@pytest.mark.slow
def test_a_thousand_lights_add_up():
    # Owed: the sum of all, within 5 of the stated errors at each of 32 places and 0.5 % on their mean, from 128
    # samples for each light: a light that were chosen too seldom or twice would show.
    rng = np.random.default_rng(1)
    names = ["batwing", "spot", "lambertian", "type A", "asymmetric"]
    places = np.column_stack([rng.uniform(2, 60, 32), rng.uniform(2, 44, 32), np.zeros(32)])
    expected, items = np.zeros(32), []
    for i in range(1000):
        at = np.array([2.0 * (i % 32), 1.5 * (i // 32), 4.0 + 0.3 * rng.random()])
        if i % 10 == 9:
            items.append(PointLight(f"p{i}", "p", Output(Quantity.LUMINOUS_FLUX, 300.0), at))
            candela = np.full(32, 300.0 / (4.0 * np.pi))
        else:
            items.append(luminaire(names[i % 5], Opening(), at, turn(i % 7), 500.0, key=f"l{i}"))
            light = items[-1]
            towards = (places - at) @ light.frame[:3, :3]
            candela = intensity(light.distribution, towards)
            candela *= 500.0 / flux_of(light.distribution)
        away = at - places
        expected += candela * away[:, 2] / np.linalg.norm(away, axis=1) ** 3
    made = session_of(*items).measure(places, np.tile(UP, (32, 1)), StopRule(samples=1 << 17))
    assert (made.standard_error < 0.05 * expected).all()
    assert (np.abs(made.illuminance - expected) <= 5.0 * made.standard_error).all()
    assert made.illuminance.mean() == pytest.approx(expected.mean(), rel=5e-3)


# ---- a thousand million to one ----


def screened(lamp_candela, luminance):
    """Lamp above a black screen of 2 x 2 m, a dim dome around; places below the screen and beside it."""
    lamp = PointLight("l", "l", Output(Quantity.LUMINOUS_INTENSITY, lamp_candela), 2.0 * UP, 0.05)
    screen = quad("screen", (-1, -1, 1), (2, 0, 0), (0, 2, 0), "black")
    return session_of(lamp, screen, BLACK, UniformWorld(luminance))


def test_a_dim_dome_beside_a_hidden_lamp_that_is_a_thousand_million_times_as_bright():
    # Owed: 0.1 % and noise of 1 % in the lamp's shadow, as if there were no lamp: not one of its 1e9 shares may leak, and
    # choosing it in vain must not cost the dome its samples. Beside the shadow the lamp, to 0.1 %.
    luminance = 1e-3
    dome = np.pi * luminance
    lamp = 4.0 * 1e9 * dome
    places = np.array([[0.0, 0.0, 0.0], [0.3, -0.2, 0.5], [6.0, 0.0, 0.0]])
    made = screened(lamp, luminance).measure(places, np.tile(UP, (3, 1)), StopRule(samples=1 << 17))
    # Share of the sky that a rectangle takes, by the corners' sum.
    shadows = []
    for x, y, z in places[:2]:
        share = 0.0
        for a in (1.0 - x, 1.0 + x):
            for b in (1.0 - y, 1.0 + y):
                u, v = a / (1.0 - z), b / (1.0 - z)
                p, q = np.hypot(1.0, u), np.hypot(1.0, v)
                share += (u / p * np.arctan(v / p) + v / q * np.arctan(u / q)) / (2.0 * np.pi)
        shadows.append(dome * (1.0 - share))
    assert (made.standard_error[:2] < 0.01 * np.array(shadows)).all()
    difference = np.abs(made.illuminance[:2] - shadows)
    assert (difference <= 3.5 * made.standard_error[:2] + 1e-3 * np.array(shadows)).all()
    lit = lamp * 2.0 / np.hypot(6.0, 2.0) ** 3
    assert abs(made.illuminance[2] - lit) <= 3.5 * made.standard_error[2] + 1e-3 * lit
    assert made.standard_error[2] < 0.01 * lit


# ---- a sun through a pinhole ----

HALF_SUN = np.radians(0.53 / 2)


def pinhole(side, height):
    """Plate of 1 m with a square hole in its middle."""
    h, e = 0.5 * side, 0.5
    strips = [
        quad("left", (-e, -e, height), (e - h, 0, 0), (0, 2 * e, 0), "black"),
        quad("right", (h, -e, height), (e - h, 0, 0), (0, 2 * e, 0), "black"),
        quad("near", (-h, -e, height), (side, 0, 0), (0, e - h, 0), "black"),
        quad("far", (-h, h, height), (side, 0, 0), (0, e - h, 0), "black"),
    ]
    return [*strips, BLACK]


@pytest.mark.slow
def test_the_sun_s_disk_through_a_pinhole():
    # Owed: the patch is the sun's disk folded with the hole. At each of 21 x 21 places within 3.5 errors (and 1 % of the
    # brightest, for the rim), the flux of all to 0.5 %, and darkness where the fold is 0: so flux, size and shape.
    side, height, lux = 2e-3, 1.0, 1e5
    sun = SunLight("s", "s", Output(Quantity.ILLUMINANCE, lux), -UP, 2.0 * HALF_SUN)
    reach = height * np.tan(HALF_SUN) + 0.5 * side
    step = 2.0 * reach / 20.0
    axis = np.linspace(-reach, reach, 21)
    x, y = np.meshgrid(axis, axis)
    places = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    # Sum over the hole of what lies on the sun's disk as seen from the place.
    cells = ((np.arange(400) + 0.5) / 400 - 0.5) * side
    u, v = np.meshgrid(cells, cells)
    luminance = lux / (np.pi * np.sin(HALF_SUN) ** 2)
    expected = np.empty(len(places))
    for i, (a, b, _) in enumerate(places):
        square = (u - a) ** 2 + (v - b) ** 2
        weight = (square <= (height * np.tan(HALF_SUN)) ** 2) * (height / (square + height**2)) ** 2
        expected[i] = luminance * weight.sum() * (side / 400) ** 2
    made = session_of(sun, *pinhole(side, height)).measure(
        places, np.tile(UP, (len(places), 1)), StopRule(samples=1 << 13)
    )
    allowed = 3.5 * made.standard_error + 0.01 * expected.max()
    assert (np.abs(made.illuminance - expected) <= allowed).all()
    assert (made.illuminance[expected == 0.0] == 0.0).all()
    assert (expected == 0.0).sum() > 40
    flux = made.illuminance.sum() * step**2
    assert flux == pytest.approx(expected.sum() * step**2, rel=5e-3)
    # And what is expected is itself the sun's flux through the hole.
    assert flux == pytest.approx(lux * side**2, rel=0.02)


# ---- nothing ----


def dark_things():
    """Lights and worlds of every kind that give nothing, each with what it needs."""
    none = Output(Quantity.LUMINOUS_FLUX, 0.0)
    frame = np.eye(4)
    frame[:3, 3] = (0.5, 0.5, 1.5)
    place = frame[:3, 3]
    dark = Material("dark", "dark", Black(), Emission(Constant(1.0), 0.0))
    picture = ImageTexture(np.random.default_rng(1).random((4, 8, 3)).astype(np.float32))
    glow = Emission(Constant(1.0), 0.0, picture)
    shelf = [quad("z", (0.3, 0.3, 0.5), (0.2, 0, 0), (0, 0.2, 0), "dark")]
    return {
        "point": [PointLight("z", "z", none, place)],
        "sphere": [PointLight("z", "z", none, place, 0.1)],
        "spot": [SpotLight("z", "z", none, place, -UP, 0.5)],
        "sun": [SunLight("z", "z", Output(Quantity.ILLUMINANCE, 0.0), -UP, 0.01)],
        "area": [AreaLight("z", "z", none, frame, 0.4, 0.4)],
        "area of 0 cd/m2": [AreaLight("z", "z", Output(Quantity.LUMINANCE, 0.0), frame, 0.4, 0.4)],
        "area of no size": [AreaLight("z", "z", none, frame, 0.0, 0.0)],
        "point of 0 W": [PointLight("z", "z", Output(Quantity.RADIANT_FLUX, 0.0), place)],
        "other spectrum": [PointLight("z", "z", replace(none, spectrum=Illuminant("A")), place)],
        "luminaire": [luminaire("batwing", place=place, lumens=0.0, key="z")],
        "luminaire with a body": [
            luminaire("batwing", Opening("box", (0.3, 0.3, 0.1)), place, lumens=0.0, key="z")
        ],
        "mesh": [*shelf, dark],
        "mesh with a picture": [*shelf, replace(dark, emission=glow)],
        "world": [UniformWorld(0.0)],
        "sky": [CieSky(12, np.array([0.3, 0.2, 0.9]), 0.0, 0.2)],
        "picture": [ImageWorld(picture, 0.0)],
    }


PLACES = np.array([[0.7, 0.8, 0.0], [0.5, 0.5, 1.0]])
RULE = StopRule(samples=1 << 10)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("name", dark_things())
def test_what_gives_no_light_gives_exactly_none(name, transport):
    # Owed: exactly 0 lx with an error of 0, not a share of rounding or a number that is none.
    made = session_of(
        *dark_things()[name], paint(0.5), quad("f", (0, 0, -1), (1, 0, 0), (0, 1, 0), "paint")
    ).measure(PLACES, np.tile(UP, (2, 1)), RULE, transport=transport)
    assert (made.illuminance == 0.0).all()
    assert (made.standard_error == 0.0).all()


@pytest.mark.parametrize("name", dark_things())
def test_what_gives_no_light_leaves_the_other_lights_as_they_are(name):
    # Owed: the same numbers to the last digit, because nothing may be spent on lights that are off.
    room = [box(2, 2, 2), paint(0.5)]
    frame = np.eye(4)
    frame[:3, 3] = (1.0, 1.0, 1.9)
    lamps = [
        PointLight("a", "a", Output(Quantity.LUMINOUS_INTENSITY, 100.0), np.ones(3)),
        AreaLight("b", "b", Output(Quantity.LUMINOUS_FLUX, 500.0), frame, 0.3, 0.2),
    ]
    items = [*room, *lamps, *dark_things()[name]]
    # The dark mesh hides something, whether it is a light or not.
    plain = [replace(x, emission=None) if isinstance(x, Material) else x for x in items]
    objects = Mesh | Material | PointLight | AreaLight
    plain = [x for x in plain if isinstance(x, objects) and (x.id != "z" or isinstance(x, Mesh))]
    both = session_of(*items).measure(PLACES, np.tile(UP, (2, 1)), RULE)
    alone = session_of(*plain).measure(PLACES, np.tile(UP, (2, 1)), RULE)
    assert (alone.illuminance > 0.0).all()
    np.testing.assert_array_equal(both.illuminance, alone.illuminance)


def test_a_scene_with_nothing_in_it_is_black():
    # Owed: exactly 0, everywhere, of everything that is measured.
    frame = np.eye(4)
    frame[2, 3] = 3.0
    session = session_of()
    for kind in ("mono", "spectral"):
        made = session.measure(PLACES, np.tile(UP, (2, 1)), RULE, transport=kind, colour=True)
        assert (made.tristimulus == 0.0).all()
        assert (made.standard_error == 0.0).all()
    camera = Camera(frame, Projection.PERSPECTIVE, 16, 12, 1.0, 0.75)
    picture = session.render(camera, ViewSettings(StopRule(samples=8), illuminance=True))
    assert (picture.tristimulus == 0.0).all()
    assert (picture.illuminance == 0.0).all()
    assert (picture.luminance_error == 0.0).all()
    assert (picture.normal == 0.0).all()
