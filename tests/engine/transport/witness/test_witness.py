"""The second witness: light of every kind of light, where it lands and where it goes, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import lamp, moved
from glass_scenes import ball
from luminaires import luminaire
from ray_lamps import lamp_at
from small_scenes import box, paint, quad, session_of

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
from lumenray.engine.scene.material import (
    Black,
    Cauchy,
    Coated,
    Dielectric,
    Emission,
    Glossy,
    Material,
    ThinGlass,
    Transparent,
)
from lumenray.engine.scene.spectrum import Constant, Illuminant
from lumenray.engine.scene.texture import ImageTexture

pytestmark = pytest.mark.mitsuba

LUMENS = Output(Quantity.LUMINOUS_FLUX, 100.0, Illuminant("A"))
BLACK = paint(0.0, "black")
ROOM = box(2.0, 2.0, 2.0, "black")
MIDDLE = (1.0, 1.0, 1.0)


def report_of(*items, paths=1 << 16, transport="mono", seed=1, **more):
    from lumenray.engine.transport.witness.pilot import Witness

    session = session_of(*items)
    scene = session._prepare(transport, False)
    scene.settle()
    witness = Witness(scene, seed, **more)
    made = witness.run(paths)
    witness.session = session
    return made, witness


def test_the_same_seed_gives_the_same_sums_whatever_the_threads_do():
    """Sums of floating-point numbers differ in their last digits by the order in which rays come."""
    light = PointLight("lamp", "lamp", LUMENS, np.array([1.0, 1.0, 1.5]))
    one, other = (report_of(ROOM, paint(0.7, "black"), light)[0] for _ in range(2))
    assert one.flux.max() > 0.0
    np.testing.assert_array_equal(one.flux, other.flux)
    np.testing.assert_array_equal(one.flux_error, other.flux_error)
    assert one.balance() == other.balance()


def test_sums_lose_nothing_and_need_no_order():
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.transport.witness.sums import Sums

    report_of(ROOM, BLACK, PointLight("lamp", "lamp", LUMENS, np.array(MIDDLE)), paths=64)
    draw = np.random.default_rng(3)
    amounts = (10.0 ** draw.uniform(-6.0, 0.0, 100_000)).astype(np.float32)
    places = draw.integers(0, 3, len(amounts))
    found = []
    for order in (np.arange(len(amounts)), draw.permutation(len(amounts))):
        sums = Sums(3, 100.0)
        sums.add(mi.Float(amounts[order]), mi.UInt32(places[order]), mi.Bool(True))
        dr.eval(sums.counts)
        found.append(sums.values())
    np.testing.assert_array_equal(*found)
    expected = np.bincount(places, amounts.astype(np.float64))
    np.testing.assert_allclose(found[0], expected, rtol=1e-9)


def test_sums_of_faint_light_beside_a_whole_that_is_far_brighter_are_right():
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.transport.witness.sums import Sums

    report_of(ROOM, BLACK, PointLight("lamp", "lamp", LUMENS, np.array(MIDDLE)), paths=64)
    chance = np.random.default_rng(4).random(1 << 20).astype(np.float32)
    for amount in (1e-4, 3e-3):
        # As of a sun over kilometres of land: a quantum of 2 mlm.
        sums = Sums(1, 1e12)
        sums.add(mi.Float(amount), mi.UInt32(0), mi.Bool(True), mi.Float(chance))
        dr.eval(sums.counts)
        np.testing.assert_allclose(sums.values(), amount * len(chance), rtol=0.02)


def flux_of(report, key, is_back=False):
    row = report.objects.index((key, is_back))
    return report.flux[row], report.flux_error[row]


def assert_within(value, error, expected, systematic=1e-3):
    assert abs(value - expected) < 4.5 * error + systematic * abs(expected), (
        f"{value} ± {error} against {expected}"
    )


def placed(light_frame=MIDDLE):
    frame = np.eye(4)
    frame[:3, 3] = light_frame
    return frame


def glowing(two_sided):
    return Material("glow", "glow", Black(), Emission(Illuminant("A"), 1000.0, None, two_sided))


BOX = replace(moved(box(0.2, 0.2, 0.2, "glow", inwards=False), "lit", MIDDLE), materials=("glow",))

LIGHTS = {
    "point": [PointLight("a", "a", LUMENS, np.array(MIDDLE))],
    "sphere": [PointLight("a", "a", LUMENS, np.array(MIDDLE), 0.2)],
    "spot": [SpotLight("a", "a", LUMENS, np.array(MIDDLE), np.array([0.6, 0.0, -0.8]), 0.4, 0.5, 0.02)],
    "rectangle": [AreaLight("a", "a", LUMENS, placed(), 0.5, 0.2)],
    "ellipse": [AreaLight("a", "a", LUMENS, placed(), 0.5, 0.2, "ellipse")],
    "spread": [AreaLight("a", "a", LUMENS, placed(), 0.5, 0.2, "rectangle", 0.4)],
    "luminaire": [luminaire("batwing", place=MIDDLE, lumens=100.0)],
    "wide luminaire": [luminaire("batwing", Opening("rectangle", (0.3, 0.2, 0.0)), MIDDLE, lumens=100.0)],
    "mesh": [glowing(False), BOX],
}  # fmt: skip
EMITTED = {"mesh": 1000.0 * np.pi * 6 * 0.04}


# ---- every kind of light gives its flux ----


def lights_of(kind):
    """Rays take seconds to be made ready, and are so for the test that asks for them."""
    return [lamp_at(MIDDLE, spectrum=LUMENS.spectrum)] if kind == "ray set" else LIGHTS[kind]


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("kind", [*LIGHTS, "ray set"])
def test_all_light_of_a_light_lands_in_a_black_room(kind, transport):
    made, _ = report_of(BLACK, ROOM, *lights_of(kind), transport=transport)
    expected = EMITTED.get(kind, 100.0)
    assert_within(made.emitted.value, made.emitted.error, expected)
    assert_within(*flux_of(made, "box"), expected)
    assert made.left.value < 1e-3 * expected
    assert abs(made.rest.value) < 5 * made.rest.error + 1e-3 * expected


def test_a_two_sided_mesh_shines_to_both_sides():
    made, _ = report_of(BLACK, ROOM, glowing(True), BOX)
    assert_within(*flux_of(made, "box"), EMITTED["mesh"])
    assert_within(*flux_of(made, "lit", True), EMITTED["mesh"])


def test_a_pattern_weighs_the_places_of_a_glowing_mesh():
    pixels = np.array([[[0.0], [1.0]], [[0.0], [1.0]]], np.float32)
    pattern = ImageTexture(pixels, "UV", interpolation="closest")
    glow = Material("glow", "glow", Black(), Emission(Constant(1.0), 500.0, pattern, False))
    panel = quad("panel", (0.5, 0.5, 1.9), (0, 1, 0), (1, 0, 0), "glow")
    made, _ = report_of(BLACK, ROOM, glow, panel)
    assert_within(*flux_of(made, "box"), 500.0 * np.pi * 0.5)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize(("angle", "limb"), [(0.0, 0.0), (0.1, 0.0), (0.1, 0.8)])
def test_a_sun_lights_a_plane_by_the_cosine(angle, limb, transport):
    towards = np.array([0.0, np.sin(0.7), np.cos(0.7)])
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1000.0), -towards, angle, limb)
    floor = quad("floor", (0, 0, 0), (2, 0, 0), (0, 3, 0), "black")
    made, _ = report_of(BLACK, floor, sun, transport=transport)
    assert_within(*flux_of(made, "floor"), 6000.0 * np.cos(0.7))
    assert flux_of(made, "floor", True)[0] == 0.0


PICTURE = np.full((16, 32, 3), 1.0, np.float32)
WORLDS = {
    "even": (UniformWorld(100.0), 100.0 * np.pi),
    "sky": (CieSky(16, np.array([0.0, 0.0, 1.0]), 5000.0), 5000.0),
    "picture": (ImageWorld(ImageTexture(PICTURE), 100.0), 100.0 * np.pi),
}


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("name", WORLDS)
def test_a_world_lights_a_plane(name, transport):
    world, expected = WORLDS[name]
    floor = quad("floor", (0, 0, 0), (2, 0, 0), (0, 3, 0), "black")
    made, _ = report_of(BLACK, floor, world, transport=transport)
    assert_within(*flux_of(made, "floor"), 6.0 * expected)


def test_the_sky_comes_through_an_opening_in_full():
    """An opening of area a in a thin shell lets pi L a through, whatever is behind it."""
    opening = Material("open", "open", Transparent())
    walls = [
        quad("floor", (0, 0, 0), (2, 0, 0), (0, 2, 0), "black"),
        quad("left", (0, 0, 0), (0, 2, 0), (0, 0, 2), "black"),
        quad("right", (2, 0, 0), (0, 0, 2), (0, 2, 0), "black"),
        quad("front", (0, 0, 0), (0, 0, 2), (2, 0, 0), "black"),
        quad("back", (0, 2, 0), (2, 0, 0), (0, 0, 2), "black"),
        quad("roof", (0, 0, 2), (0, 2, 0), (1.8, 0, 0), "black"),
        quad("pane", (1.8, 0, 2), (0, 2, 0), (0.2, 0, 0), "open"),
    ]
    made, _ = report_of(BLACK, opening, *walls, UniformWorld(100.0))
    total = sum(flux_of(made, wall.id)[0] for wall in walls[:6])
    error = np.sqrt(sum(flux_of(made, wall.id)[1] ** 2 for wall in walls[:6]))
    assert error < 0.01 * total
    assert_within(total, error, 100.0 * np.pi * 0.4, 3e-3)


@pytest.mark.parametrize("name", ["sky", "sun"])
def test_light_from_infinity_is_led_to_what_is_asked_about(name):
    """Two square metres beside a field of a square kilometre get their light within a fiftieth."""
    light = {
        "sky": CieSky(16, np.array([0.0, 0.0, 1.0]), 5000.0),
        "sun": SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 5000.0), np.array([0, 0, -1.0])),
    }[name]
    field = quad("field", (-500, -500, 0), (1000, 0, 0), (0, 1000, 0), "black")
    floor = quad("floor", (300, 200, 1), (2, 0, 0), (0, 1, 0), "black")
    made, _ = report_of(BLACK, field, floor, light, wanted={("floor", False)})
    flux, error = flux_of(made, "floor")
    assert error < 0.02 * flux
    assert_within(flux, error, 10_000.0)


# ---- where it lands ----


def test_a_lamp_lights_a_square_by_its_solid_angle():
    """A face of a cube about the lamp takes a sixth."""
    floor = quad("floor", (-1, -1, -1), (2, 0, 0), (0, 2, 0), "black")
    made, _ = report_of(BLACK, floor, PointLight("a", "a", LUMENS, np.zeros(3)))
    assert_within(*flux_of(made, "floor"), 100.0 / 6.0)
    assert_within(made.left.value, made.left.error, 500.0 / 6.0)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("reflectance", [0.3, 0.9])
def test_a_closed_room_keeps_all_light(reflectance, transport):
    """Light falls on it 1 / (1 - rho) times, and all is absorbed."""
    made, _ = report_of(
        paint(reflectance), box(2, 3, 4), lamp((1, 1, 2), 100.0), transport=transport
    )
    assert_within(*flux_of(made, "box"), 100.0 / (1.0 - reflectance))
    assert_within(made.taken.value, made.taken.error, 100.0)
    # A path in a million finds its way through an edge.
    assert made.left.value + made.cut.value < 5e-3


@pytest.mark.parametrize("smooth", [False, True])
def test_a_glossy_coarse_ball_keeps_energy_whatever_its_normals(smooth):
    """What comes to the facets goes on from them; nothing gets inside."""
    coat = Material("coat", "coat", Coated(Constant(0.6), 1.5, 0.4))
    body = ball("ball", 0.5, MIDDLE, "coat", rings=6)
    if not smooth:
        body = replace(body, corner_normals=None)
    made, _ = report_of(coat, BLACK, ROOM, body, PointLight("a", "a", LUMENS, np.array([0.2, 0.2, 0.2])))  # fmt: skip
    assert flux_of(made, "ball", True)[0] == 0.0
    assert_within(made.taken.value, made.taken.error, 100.0)
    row = made.objects.index(("ball", False))
    assert 0.0 < made.absorbed[row] < 0.5 * made.flux[row]


def test_a_lamp_in_a_glass_ball_lights_the_room_in_full():
    glass = Material("glass", "glass", Dielectric(Cauchy(1.5)))
    room = box(2, 2, 2)
    items = (glass, paint(0.5), room, ball("ball", 0.1, MIDDLE, "glass", rings=24))
    made, witness = report_of(*items, lamp(MIDDLE, 100.0, 0.001))
    assert_within(*flux_of(made, "box"), 200.0)
    cause = witness.explain(row=made.objects.index(("box", False)))
    assert cause.light == "lamp"
    assert "through 'ball'" in cause.way


def test_a_keyhole_lets_the_sun_in_by_its_area():
    """5 mm in a roof of 1 m: a hundred thousandth of what shines on it."""
    side = 5e-3
    a = 0.5 - 0.5 * side
    b = a + side
    roof = [
        quad("r1", (0, 0, 1), (0, 1, 0), (a, 0, 0), "paint"),
        quad("r2", (b, 0, 1), (0, 1, 0), (1 - b, 0, 0), "paint"),
        quad("r3", (a, 0, 1), (0, a, 0), (side, 0, 0), "paint"),
        quad("r4", (a, b, 1), (0, 1 - b, 0), (side, 0, 0), "paint"),
    ]
    floor = quad("floor", (0, 0, 0), (1, 0, 0), (0, 1, 0), "black")
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1e5), np.array([0.0, 0.0, -1.0]), 0.0)
    made, _ = report_of(paint(0.5), BLACK, *roof, floor, sun, wanted={("floor", False)})
    flux, error = flux_of(made, "floor")
    assert error < 0.05 * flux
    # What the roof's lower side sends back is black's to keep.
    assert_within(flux, error, 1e5 * side**2, 1e-2)


def test_mirrors_and_panes_on_the_way_are_named():
    mirror = Material("silver", "silver", Glossy(Constant(0.9), 0.0))
    pane = Material("pane", "pane", ThinGlass())
    plate = quad("plate", (0.3, 0.3, 0.01), (1.4, 0, 0), (0, 1.4, 0), "silver")
    spot = SpotLight("spot", "spot", LUMENS, np.array(MIDDLE), np.array([0.0, 0.0, -1.0]), 0.3)
    made, witness = report_of(mirror, BLACK, ROOM, plate, spot)
    assert "by way of 'plate'" in witness.explain(made.objects.index(("box", False))).text()
    sheet = quad("sheet", (0.0, 0.0, 0.5), (2, 0, 0), (0, 2, 0), "pane")
    made, witness = report_of(pane, BLACK, ROOM, sheet, spot)
    assert "straight through 'sheet'" in witness.explain(made.objects.index(("box", False))).text()


def test_the_same_seed_gives_the_same_report():
    items = (paint(0.7), box(2, 2, 2), lamp((1, 1, 1.5)))
    first, second = (report_of(*items)[0] for _ in range(2))
    np.testing.assert_allclose(first.flux, second.flux, rtol=1e-6)
    assert first.flux[0] != report_of(*items, seed=2)[0].flux[0]


def test_a_dark_scene_has_nothing_to_tell():
    made, _ = report_of(BLACK, ROOM)
    assert made.flux.sum() == 0.0
    assert made.emitted.value == 0.0
