"""Lamps and suns in panes and between them: against images and sums over layers, both polarisations apart."""

from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake, lumel_places
from panes import send_on, share, stack_share, tilted_pane, unit, unpolarised
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import Output, PointLight, Quantity, SunLight, UniformWorld
from lumenray.engine.scene.material import (
    Black,
    Conductor,
    Diffuse,
    Glossy,
    Material,
    Mix,
    TabulatedPane,
    ThinGlass,
    Transparent,
)
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Constant

pytestmark = pytest.mark.mitsuba

INDEX, INTERNAL = 1.52, 0.9584
GLASS = Material("glass", "glass", ThinGlass(INDEX, Constant(INTERNAL)))
BLACK = Material("black", "black", Black())
UP = np.array([0.0, 0.0, 1.0])
DISK = np.radians(0.53)


def sun(degrees, angle=0.0, amount=10000.0):
    tilt = np.radians(degrees)
    towards = np.array([np.sin(tilt), 0.0, -np.cos(tilt)])
    return SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, amount), towards, angle)


def candela(place, radius=0.0, name="lamp", amount=1000.0):
    output = Output(Quantity.LUMINOUS_INTENSITY, amount)
    return PointLight(name, name, output, np.asarray(place, float), radius)


def pane(name, height, material="glass", half=200.0):
    return quad(name, (-half, -half, height), (2 * half, 0, 0), (0, 2 * half, 0), material)


def image_light(place, normal, source, mirror_height, is_reflected=True, amount=1000.0):
    """Illuminance by a lamp's image in an endless horizontal pane, or through it."""
    source = np.array(source, float)
    if is_reflected:
        source[2] = 2.0 * mirror_height - source[2]
    away = source - np.asarray(place, float)
    distance = np.linalg.norm(away)
    degrees = np.degrees(np.arccos(abs(away[2]) / distance))
    cosine = max(float(np.asarray(normal) @ away) / distance, 0.0)
    return amount * share(degrees, INDEX, INTERNAL, is_reflected) * cosine / distance**2


def assert_near(made, expected, relative=1e-3, error=5e-3):
    expected = np.asarray(expected, float)
    assert (made.standard_error <= error * expected + 1e-12).all(), made.standard_error / expected
    gap = np.abs(made.illuminance - expected)
    assert (gap <= 4.0 * made.standard_error + relative * expected).all(), (
        made.illuminance,
        expected,
        made.standard_error,
    )


# ---- suns ----


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("angle", [0.0, DISK], ids=["point", "disk"])
@pytest.mark.parametrize("degrees", [35.0, 65.0, 82.0])
def test_light_of_a_sun_goes_to_and_fro_between_parallel_panes(transport, degrees, angle, count):
    panes = [pane(f"pane {i}", 1.0 + 0.5 * i) for i in range(count)]
    made = session_of(GLASS, *panes, sun(degrees, angle)).measure(
        [[0, 0, 0]], [UP], StopRule(samples=1 << 16), transport=transport
    )
    expected = 10000.0 * np.cos(np.radians(degrees)) * stack_share(degrees, INDEX, INTERNAL, count)
    # The angle varies over the disk, which counts where the curve bends.
    assert_near(made, [expected], 2e-3 if angle and degrees > 80.0 else 4e-4, 0.03)


def test_panes_of_a_double_window_stay_apart_in_a_wide_scene():
    """Sixteen millimetres between panes on a ground of two kilometres."""
    ground = quad("ground", (-1000, -1000, -1), (2000, 0, 0), (0, 2000, 0), "black")
    panes = [pane("outer", 1.016, half=6.0), pane("inner", 1.0, half=6.0)]
    made = session_of(GLASS, BLACK, ground, *panes, sun(65.0)).measure(
        [[0, 0, 0]], [UP], StopRule(samples=1 << 14)
    )
    expected = 10000.0 * np.cos(np.radians(65.0)) * stack_share(65.0, INDEX, INTERNAL, 2)
    assert_near(made, [expected], 2e-3)


def test_a_sun_shines_by_a_pane_that_leans(transport):
    """A pane at 45 degrees turns the light of a sun overhead onto a wall; behind it the rest arrives."""
    leaning = tilted_pane("pane", (0, 0, 0), unit([-1, 0, 1]), 1.0, "glass")
    normals = [unit([1.0, 0.0, -0.1]), UP]
    made = session_of(GLASS, leaning, sun(0.0, DISK)).measure(
        [[-2, 0, 0], [0, 0, -2]], normals, StopRule(samples=1 << 14), transport=transport
    )
    expected = [10000.0 * share(45.0, INDEX, INTERNAL, flag) for flag in (True, False)]
    assert_near(made, np.array(expected) * [normals[0][0], 1.0])


@pytest.mark.parametrize("metal", [Glossy(Constant(0.8), 0.0), Conductor("Al", 0.0)], ids=str)
@pytest.mark.slow
def test_a_window_is_seen_in_a_mirror(metal):
    """Sun through a pane onto a mirror, and from there to a sensor that the sun does not see."""
    window = quad("window", (-2, -1, 2), (2, 0, 0), (0, 2, 0), "glass")
    # So short that no light comes to and fro between both.
    mirror = quad("mirror", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "mirror")
    place = [0.5 * np.tan(np.radians(30.0)), 0.0, 0.5]
    items = [GLASS, Material("mirror", "mirror", metal), mirror, sun(30.0)]
    alone, behind = (
        session_of(*items, *more).measure([place], [-UP], StopRule(samples=1 << 14))
        for more in ((), (window,))
    )
    expected = alone.illuminance * share(30.0, INDEX, INTERNAL, False)
    assert expected[0] > 5000.0
    assert_near(behind, expected, 1e-3, 0.02)


# ---- lamps ----


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("radius", [0.0, 0.002])
def test_a_lamp_shines_by_its_image_in_a_pane_and_through_it(transport, radius):
    places = np.array([[0.3, 0.1, 1.5], [2.0, -1.0, 0.2], [1.0, 0.0, -1.0], [0.0, 2.0, -2.0]])
    normals = np.array([-UP, -UP, UP, UP])
    lamp = candela([0, 0, 1], radius)
    made = session_of(GLASS, pane("pane", 0.0), lamp).measure(
        places, normals, StopRule(samples=1 << 15), transport=transport
    )
    expected = [
        image_light(p, n, lamp.position, 0.0, p[2] > 0.0)
        for p, n in zip(places, normals, strict=True)
    ]
    # What comes straight to sensors that look down from above the lamp.
    for k in np.flatnonzero(places[:, 2] > 1.0):
        away = lamp.position - places[k]
        expected[k] += 1000.0 * max(normals[k] @ away, 0.0) / np.linalg.norm(away) ** 3
    assert_near(made, expected, 1e-3, 0.02)


def test_tabulated_panes_reflect_lamps_too():
    table = TabulatedPane(np.array([0.0, 90.0]), np.array([0.6, 0.6]), np.array([0.3, 0.3]))
    items = [Material("sheet", "sheet", table), pane("pane", 0.0, "sheet"), candela([0, 0, 1])]
    made = session_of(*items).measure([[1.0, 0.0, 0.5]], [-UP], StopRule(samples=1 << 12))
    away = np.array([-1.0, 0.0, -1.5])
    assert_near(made, [300.0 * 1.5 / np.linalg.norm(away) ** 3])


@pytest.mark.parametrize("caustics", [pytest.param("off", marks=pytest.mark.slow), "on"])
def test_the_image_of_a_lamp_in_a_pane_is_in_a_lux_map(caustics):
    """A ceiling lit by a lamp's image in a pane below, and straight; a black room keeps all else away."""
    ceiling = quad("ceiling", (-2, -2, 3), (0, 4, 0), (4, 0, 0), "black")
    lamp = candela([0.2, 0.1, 1.2])
    items = [GLASS, BLACK, pane("pane", 0.0), ceiling, lamp]
    made = bake(items, ("ceiling",), 256, density=4.0, caustics=caustics)
    places, _ = lumel_places(made, made.maps[0], ceiling)
    away = lamp.position - places
    expected = 1000.0 * -away[:, 2] / np.linalg.norm(away, axis=1) ** 3
    expected += [image_light(place, -UP, lamp.position, 0.0) for place in places]
    values = made.lumels(0)
    z = (values.illuminance - expected) / np.hypot(values.standard_error, 0.002 * expected)
    assert np.sqrt(np.mean(z**2)) < 1.4
    assert made.maps[0].mean == pytest.approx(expected.mean(), rel=0.004)


@pytest.mark.slow
def test_a_lamp_in_a_pane_lights_a_room_by_the_way_of_its_walls():
    """Maps of a room with a pane before a wall agree whether light is traced or not, cells or full paths."""
    room = box(2.0, 2.0, 2.0)
    window = quad("window", (0.01, 0.2, 0.2), (0, 1.6, 0), (0, 0, 1.6), "glass")
    items = [paint(0.5), GLASS, room, window, candela([0.6, 1.0, 1.0], amount=100.0)]
    means = []
    for caustics in ("on", "off"):
        made = bake(items, ("box",), 128, density=4.0, caustics=caustics).maps[0]
        means.append((made.mean - made.bias, np.hypot(made.mean_standard_error, made.bias_error)))
    difference = abs(means[0][0] - means[1][0])
    assert difference < 4.0 * np.hypot(means[0][1], means[1][1])
    # All of it is absorbed: the walls' mean is the flux over their area and over what is not reflected, but for the pane's
    # own body, which takes a little.
    assert means[0][0] == pytest.approx(100.0 * 4.0 * np.pi / 24.0 / 0.5, rel=0.05)


def test_panes_at_all_angles_carry_polarisation_from_one_to_the_next():
    """By two panes and through a third, each in a plane of incidence of its own."""
    rng = np.random.default_rng(4)
    for _ in range(3):
        lamp, first, second = np.array([[0, 0, 3.0], [0, 0, 0], [2.0, 0.5, 1.0]])
        end = np.array([1.5, 3.5, 0.6]) + 0.3 * rng.normal(size=3)
        ways = [first - lamp, second - first, end - second]
        d = [unit(way) for way in ways]
        normals = [unit(d[1] - d[0]), unit(d[2] - d[1])]
        normals.append(unit(d[2] + 1.5 * unit(np.cross(d[2], rng.normal(size=3)))))
        panes = [
            tilted_pane(f"pane {i}", place, normal, 0.2, "glass")
            for i, (place, normal) in enumerate(
                zip((first, second, second + 0.6 * ways[2]), normals, strict=True)
            )
        ]
        made = session_of(GLASS, *panes, candela(lamp)).measure(
            [end], [-d[2]], StopRule(samples=1 << 18)
        )
        light, ways_on = unpolarised(d[0]), d[0]
        for normal, flag in zip(normals, (True, True, False), strict=True):
            light, ways_on = send_on(light, ways_on, normal, INDEX, INTERNAL, flag)
        length = sum(np.linalg.norm(way) for way in ways)
        straight = session_of(GLASS, panes[2], candela(lamp)).measure(
            [end], [-d[2]], StopRule(samples=64)
        )
        expected = 1000.0 * np.trace(light) / length**2 + straight.illuminance
        assert_near(made, expected, 2e-3, 0.01)


# ---- how it is done ----


def lit_room(radius):
    """A room with two windows and a lamp with a body."""
    return [
        paint(0.5),
        GLASS,
        box(4.0, 3.0, 2.5),
        quad("window", (0.05, 0.3, 0.6), (0, 1.2, 0), (0, 0, 1.5), "glass"),
        quad("shelf", (1.0, 2.8, 0.2), (2.0, 0.1, 0), (0, 0, 1.8), "glass"),
        candela([1.0, 1.2, 1.4], radius),
    ]


@pytest.mark.slow
def test_aiming_over_panes_does_not_change_the_mean(monkeypatch):
    """A lamp that scattered rays find well, with chains and without."""
    places = np.array([[0.5, 0.6, 0.3], [2.0, 2.0, 1.0], [3.5, 0.5, 0.5]])
    normals = np.array([[-0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    made = []
    for limit in (0.0, 1.0):
        monkeypatch.setattr("lumenray.engine.transport.compiled.known_mirrors.SMALL_LIGHT", limit)
        made.append(session_of(*lit_room(0.15)).measure(places, normals, StopRule(samples=1 << 18)))
    found, aimed = made
    assert not np.array_equal(found.illuminance, aimed.illuminance)
    spread = np.hypot(found.standard_error, aimed.standard_error)
    assert (spread < 7e-3 * found.illuminance).all()
    assert (np.abs(found.illuminance - aimed.illuminance) < 4.0 * spread).all()


def test_reflections_in_panes_count_as_reflections():
    """A sensor that looks down from under the lamp sees it below once, and behind the pane above after two reflections."""
    place, lamp = np.array([0.4, 0.0, 0.3]), np.array([0.0, 0.0, 0.5])
    session = session_of(GLASS, pane("low", 0.0), pane("high", 1.0), candela(lamp))
    low = image_light(place, -UP, lamp, 0.0)
    away = np.array([-0.4, 0.0, -1.8])
    distance = np.linalg.norm(away)
    degrees = np.degrees(np.arccos(1.8 / distance))
    both = np.mean([share(degrees, INDEX, INTERNAL, True, k) ** 2 for k in (0, 1)])
    twice = 1000.0 * both * 1.8 / distance**3
    assert twice > 0.005 * low
    for few, expected in ((0, 0.0), (1, low), (2, low + twice)):
        rule = StopRule(samples=1 << 18)
        assert_near(session.measure([place], [-UP], rule, reflections=few), [expected])


def test_a_limit_of_reflections_takes_no_light_from_sensors_that_see_no_mirror(transport):
    """Even sky above and a mirror below the horizon: nothing that the sensor receives is reflected."""
    mirror = Material("mirror", "mirror", Glossy(Constant(0.9), 0.0))
    items = (UniformWorld(100.0), mirror, quad("low", (5, -1, -3), (0, 2, 0), (0, 0, 2), "mirror"))
    for few in (0, 1, None):
        made = session_of(*items).measure(
            [[0, 0, 0]], [UP], StopRule(samples=1 << 12), transport=transport, reflections=few
        )
        assert_near(made, [100.0 * np.pi])


def test_both_faces_of_a_thin_box_of_glass_are_mirrors_and_its_edges_are_not():
    from lumenray.engine.transport.compiled.mirrors import find_planes

    body = box(1.0, 1.5, 0.006, "glass", inwards=False)
    planes, member = find_planes(body.vertices, body.triangles, is_pane=True)
    assert sorted(round(plane.distance, 6) for plane in planes) == [0.0, 0.006]
    assert (np.bincount(member + 1) == [8, 2, 2]).all()
    made = session_of(GLASS, body, candela([0.5, 0.7, 1.0])).measure(
        [[0.5, 0.7, 0.5]], [-UP], StopRule(samples=1 << 15)
    )
    r, t = (share(0.0, INDEX, INTERNAL, flag) for flag in (True, False))
    # Of the series of images all but the first are weak and as far away within 1 %.
    assert_near(made, [1000.0 * (r + t * t * r / (1.0 - r * r)) / 1.5**2], 0.01, 0.01)


def test_true_mirrors_come_before_panes_where_there_are_too_many():
    from lumenray.engine.transport.compiled.mirrors import MAXIMUM_MIRRORS, Plane, choose_planes

    def plane(distance, area, is_pane):
        low, high = np.array([0, 0, distance]), np.array([1, 1, distance])
        return Plane(UP, distance, area, low, high, is_pane)

    panes = [plane(float(k), 100.0 + k, True) for k in range(MAXIMUM_MIRRORS)]
    mirrors = [plane(-1.0, 0.5, False), plane(-2.0, 1.0, False)]
    chosen, known = choose_planes([*panes, *mirrors])
    assert [p.distance for p in chosen[:3]] == [-2.0, -1.0, MAXIMUM_MIRRORS - 1.0]
    assert len(chosen) == MAXIMUM_MIRRORS
    assert id(panes[0]) not in known
    assert id(panes[1]) not in known


@pytest.mark.slow
def test_edits_that_make_panes_matter_end_at_the_scene_compiled_at_once():
    """Panes become mirrors when a sun rises, and none when it sets; and by another material."""
    wide = candela([0.5, 0.0, 2.5], 0.5, amount=100.0)
    panes = [pane("low", 1.0, half=2.0), pane("high", 1.5, half=2.0)]
    floor = quad("floor", (-2, -2, -0.5), (4, 0, 0), (0, 4, 0), "paint")
    plain = Material("glass", "glass", Diffuse(Constant(0.3)))
    start = [paint(0.5), GLASS, floor, *panes, UniformWorld(10.0), wide]
    session = session_of(*start)

    def read(made):
        rule = StopRule(samples=1 << 10)
        return made.measure([[0, 0, 0], [0.1, 0, 1.2]], [UP, -UP], rule).illuminance

    read(session)
    for changed, removed, items in (
        ((sun(65.0),), (), [*start, sun(65.0)]),
        ((plain,), (), [*start, plain, sun(65.0)]),
        ((GLASS,), ("sun",), start),
    ):  # fmt: skip
        session.apply(SceneDelta(changed=changed, removed=removed))
        np.testing.assert_array_equal(read(session), read(session_of(*items)))


def test_lamps_in_panes_that_no_plane_stands_for_are_looked_for_and_told():
    """A pane that stands for a curved one by its normals, and one in a mixture, bend light; a flat one is a known plane."""
    flat = tilted_pane("pane", (0, 0, 0), UP, 1.0, "glass")
    bent = np.tile(np.array([[0.3, 0, 1.0], [0, 0.3, 1.0], [-0.3, 0, 1.0]], np.float32), (2, 1, 1))
    bent /= np.linalg.norm(bent, axis=2, keepdims=True)
    mixed = Material("glass", "glass", Mix(GLASS.surface, Transparent(), 0.5))
    found = {}
    for name, items, is_said in (
        ("flat", (GLASS, flat), False),
        ("bent", (GLASS, replace(flat, corner_normals=bent)), True),
        ("mixed", (mixed, flat), True),
    ):
        made = session_of(*items, candela([0, 0, 1])).measure(
            [[0.2, 0, 0.5]], [-UP], StopRule(samples=1 << 16)
        )
        notes = [note for note in made.provenance.notes if "'glass' bends" in note]
        assert bool(notes) is is_said
        found[name] = made.illuminance[0], made.standard_error[0]
    # Half of the mixture is the pane, and its other half lets all light pass.
    (whole, _), (half, error) = found["flat"], found["mixed"]
    assert abs(half - 0.5 * whole) < 4.5 * error + 5e-3 * whole
    assert error < 0.1 * whole
