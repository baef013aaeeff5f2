"""Lamps close to walls and suns through keyholes: closed rooms take in all the light that enters."""

from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake, bake_in, lamp, lumel_places, pierced_box
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import AreaLight, Output, Quantity, SpotLight, SunLight
from lumenray.engine.scene.material import Glossy, Material, ThinGlass
from lumenray.engine.scene.spectrum import Constant

pytestmark = pytest.mark.mitsuba


def room(**more):
    return replace(box(3, 3, 3, **more), id="room", name="room")


def assert_mean(made, expected, systematic=0.02, largest=0.05):
    told = made.maps[0]
    apart = abs(told.mean - expected)
    assert apart < 4.5 * told.mean_standard_error + systematic * expected, (told.mean, expected)
    assert told.mean_standard_error < largest * expected


@pytest.mark.slow
@pytest.mark.parametrize("radius", [0.0, 5e-5])
@pytest.mark.parametrize("transport", ["mono", "spectral"])
def test_a_lamp_close_to_a_wall_gives_all_its_light(radius, transport):
    """Half of it falls on a spot of a fraction of a millimetre, in one of 13 000 lumels."""
    near = lamp((1e-4, 1.4, 1.3), 1000.0, radius)
    made = bake((paint(0.5), room(), near), ("room",), 64, transport=transport)
    assert_mean(made, 2000.0 / 54.0)


@pytest.mark.slow
def test_a_small_panel_that_faces_a_wall_from_close_by():
    frame = np.eye(4)
    frame[:3, :3] = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])
    frame[:3, 3] = (2e-4, 1.4, 1.3)
    panel = AreaLight(
        "panel", "panel", Output(Quantity.LUMINOUS_FLUX, 1000.0), frame, 1e-4, 1e-4, "rectangle"
    )
    made = bake((paint(0.5), room(), panel), ("room",), 64)
    assert_mean(made, 2000.0 / 54.0)


@pytest.mark.slow
def test_a_narrow_spot_gives_all_its_light():
    spot = SpotLight("spot", "spot", Output(Quantity.LUMINOUS_FLUX, 1000.0), np.array([1.5, 1.5, 2.0]),
                     np.array([0.1, 0.2, -1.0]), np.radians(0.05), 0.5)  # fmt: skip
    assert_mean(bake((paint(0.5), room(), spot), ("room",), 64), 2000.0 / 54.0)


@pytest.mark.parametrize("towards", [(0.0, 0.0, -1.0), (0.1, 0.2, -1.0), (0.3, -0.2, -0.6)])
@pytest.mark.parametrize("degrees", [0.05, 0.5, 5.0])
@pytest.mark.slow
def test_no_part_of_a_narrow_beam_is_lost_or_too_much(degrees, towards):
    """Cosines of such cones have few digits, and next-event sees nothing of what lies beyond a limit in its midst."""
    towards = np.array(towards) / np.linalg.norm(towards)
    spot = SpotLight("spot", "spot", Output(Quantity.LUMINOUS_FLUX, 1000.0), np.array([1.5, 1.5, 2.0]),
                     towards, np.radians(degrees), 0.5)  # fmt: skip
    made = bake((paint(0.0), room(), spot), ("room",), 16, density=4.0)
    assert_mean(made, 1000.0 / 54.0, 1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("degrees", "density"), [(0.5, 4.0), (0.5, 12.0), (5.0, 4.0)])
def test_a_bright_room_has_all_that_its_small_spot_sends_on(degrees, density):
    """Paths that go on near corners find one cell of thousands, which holds all light, by asking it and not by chance."""
    spot = SpotLight("spot", "spot", Output(Quantity.LUMINOUS_FLUX, 1000.0), np.array([1.5, 1.5, 2.0]),
                     np.array([0.1, 0.2, -1.0]), np.radians(degrees), 0.5)  # fmt: skip
    expected, means, errors = 5000.0 / 54.0, [], []
    for seed in (1, 2, 3):
        told = bake((paint(0.8), room(), spot), ("room",), 64, density=density, seed=seed).maps[0]
        assert abs(told.mean - expected) < 4.0 * told.mean_standard_error + 1e-3 * expected
        means.append(told.mean)
        errors.append(told.mean_standard_error)
    # So short a bake leaves half a percent; by chance alone it was five, or two where none was met.
    assert max(errors) < 0.012 * expected, errors
    assert abs(np.mean(means) - expected) < 0.006 * expected, means


@pytest.mark.parametrize("distance", [0.05, 0.15])
@pytest.mark.slow
def test_a_wall_gets_the_light_of_a_small_spot_from_where_it_lies(distance):
    """From a point on the floor first, in closed form, and a few percent more over further reflections."""
    spot = SpotLight("spot", "spot", Output(Quantity.LUMINOUS_FLUX, 1000.0), np.array([distance, 1.53, 2.0]),
                     np.array([0.0, 0.0, -1.0]), np.radians(0.5), 0.5)  # fmt: skip
    inside = room()
    made = bake((paint(0.5), inside, spot), ("room",), 192, density=12.0)
    places, normals = lumel_places(made, made.maps[0], inside)
    wall = (np.abs(normals[:, 0]) > 0.9) & (places[:, 0] < 0.01)
    steps = ((np.arange(16) + 0.5) / 16.0 - 0.5) / 12.0
    y = places[wall, 1, None, None] + steps[:, None] - 1.53
    z = places[wall, 2, None, None] + steps
    first = (500.0 / np.pi * z * distance / (distance**2 + y**2 + z**2) ** 2).mean(axis=(1, 2))
    told = made.lumels(made.maps[0].number)
    light, error = told.illuminance[wall], told.standard_error[wall]
    bright = np.argsort(-first)[:30]
    apart = light[bright] - first[bright]
    assert (apart > -4.5 * error[bright]).all()
    assert (apart < 4.5 * error[bright] + 20.0 + 0.1 * first[bright]).all()
    assert np.median(error[bright] / first[bright]) < 0.2
    # Spread over its cell, the light of the spot was off by a third here; later reflections add a few per cent.
    share = light[bright].sum() / first[bright].sum()
    assert 0.95 < share < 1.15, share


def room_with_fine_floor(steps):
    """The room, its floor of triangles so small that many share a cell."""
    whole = room()
    kept = whole.triangles[~(whole.vertices[whole.triangles][:, :, 2] == 0).all(axis=1)]
    x, y = (each.ravel() for each in np.meshgrid(*2 * [np.linspace(0.0, 3.0, steps + 1)]))
    number = np.arange(len(x)).reshape(steps + 1, steps + 1) + len(whole.vertices)
    a, b, c, d = (
        each.ravel()
        for each in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    )
    triangles = np.concatenate([kept, np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return replace(
        whole,
        vertices=np.concatenate([whole.vertices, np.stack([x, y, 0.0 * x], axis=1)]),
        triangles=triangles.astype(np.int32),
        material_index=np.zeros(len(triangles), np.int32),
    )


@pytest.mark.slow
def test_a_spot_on_small_triangles_lights_the_room_too():
    """Points are drawn on cells that triangles share as on others; by chance alone the error was a tenth."""
    spot = SpotLight("spot", "spot", Output(Quantity.LUMINOUS_FLUX, 1000.0), np.array([1.5, 1.5, 2.0]),
                     np.array([0.1, 0.2, -1.0]), np.radians(0.5), 0.5)  # fmt: skip
    made = bake((paint(0.8), room_with_fine_floor(150), spot), ("room",), 64, density=4.0)
    assert_mean(made, 5000.0 / 54.0, 1e-3, largest=0.012)


@pytest.mark.parametrize("height", [1e-4, 1e-3])
@pytest.mark.slow
def test_what_falls_around_the_spot_of_a_close_lamp_is_found(height):
    near = lamp((height, 1.4, 1.3), 1000.0, 0.0)
    made = bake((paint(0.0), room(), near), ("room",), 64, density=4.0)
    assert_mean(made, 1000.0 / 54.0, 1e-3)


@pytest.mark.parametrize(
    ("width", "limb"),
    [
        (0.005, 0.0),
        pytest.param(0.03, 0.0, marks=pytest.mark.slow),
        pytest.param(0.03, 0.6, marks=pytest.mark.slow),
    ],
)
def test_a_sun_through_a_keyhole_lights_the_whole_box(width, limb):
    direction = np.array([0.2, 0.1, -1.0]) / np.linalg.norm([0.2, 0.1, -1.0])
    output = Output(Quantity.ILLUMINANCE, 1e5)
    sun = SunLight("sun", "sun", output, direction, np.radians(0.53), limb)
    made = bake((paint(0.5), pierced_box(width), sun), ("room",), 256)
    entered = -1e5 * direction[2] * width**2
    assert_mean(made, 2.0 * entered / (6.0 - width**2), 0.03)


def half_room():
    """Half of the room, open where a mirror closes it."""
    whole = box(1.5, 3, 3)
    kept = [k for k, t in enumerate(whole.triangles) if not (whole.vertices[t][:, 0] == 1.5).all()]
    return replace(
        whole,
        id="room",
        name="room",
        triangles=whole.triangles[kept],
        material_index=whole.material_index[kept],
    )


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.slow
def test_what_was_traced_is_not_counted_twice_in_a_mirror(seed):
    """The lamp's image in a mirror wall: the room's other half, with as much light again."""
    silver = Material("silver", "silver", Glossy(Constant(1.0), 0.0))
    mirror = quad("mirror", (1.5, 0, 0), (0, 0, 3), (0, 3, 0), "silver")
    near = lamp((1e-4, 1.4, 1.3), 500.0, 0.0)
    session = session_of(paint(0.5), silver, half_room(), mirror, near)
    # The bright spot behind the mirror is found by chance, so this one is noisy.
    assert_mean(bake_in(session, ("room",), 64, seed=seed), 2000.0 / 54.0, largest=0.1)


@pytest.mark.parametrize("distance", [0.5, 1.2])
@pytest.mark.slow
def test_bright_cells_that_a_mirror_shows_count_in_full(distance):
    """Half a room before a perfect mirror is as bright as the whole one with two lamps."""
    silver = Material("silver", "silver", Glossy(Constant(1.0), 0.0))
    mirror = quad("mirror", (1.5, 0, 0), (0, 0, 3), (0, 3, 0), "silver")
    half = half_room()
    session = session_of(paint(0.5), silver, half, mirror, lamp((distance, 1.4, 1.3), 500.0, 0.0))
    assert_mean(bake_in(session, ("room",), 64), 2000.0 / 54.0, 0.01)


def test_next_event_is_whole_again_after_a_bake():
    near = lamp((0.2, 1.4, 1.3), 1000.0, 0.0)
    session = session_of(paint(0.5), room(), near)
    place, normal = np.array([[3e-3, 1.4, 1.3]]), np.array([[1.0, 0.0, 0.0]])
    before = session.measure(place, normal, _few()).illuminance
    bake_in(session, ("room",), 16)
    assert session.measure(place, normal, _few()).illuminance == pytest.approx(before, rel=1e-6)


def _few():
    from lumenray.engine.accuracy.stopping import StopRule

    return StopRule(samples=1 << 12)


def test_an_ordinary_room_needs_no_such_tracing():
    from lumenray.engine.transport.light_tracing import straight_lights

    asked = []
    original = straight_lights.StraightLights._learn

    def learn(self, most):
        original(self, most)
        asked.append(bool(self._limits))

    straight_lights.StraightLights._learn = learn
    try:
        bake((paint(0.5), room(), lamp((1.5, 1.4, 2.0), 1000.0, 0.05)), ("room",), 16)
    finally:
        straight_lights.StraightLights._learn = original
    assert asked == [False]


# ---- sensors ----


def first_reflection(lamp_at, flux, reflectance, side, places, paths=1_000_000):
    """Illuminance of the floor of a box by a point lamp, straight and over one wall, by rays from the lamp. (n,) [lx]"""
    draw = np.random.default_rng(1)
    z, phi = draw.uniform(-1.0, 1.0, paths), draw.uniform(0.0, 2.0 * np.pi, paths)
    sine = np.sqrt(1.0 - z * z)
    way = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1)
    to_walls = np.where(way > 0.0, (side - lamp_at) / way, -lamp_at / way)
    wall = to_walls.argmin(axis=1)
    rows = np.arange(paths)
    met = lamp_at + way * to_walls[rows, wall][:, None]
    made = []
    for place in places:
        straight = lamp_at - place
        direct = flux / (4.0 * np.pi) * straight[2] / np.linalg.norm(straight) ** 3
        back = place - met
        square = np.einsum("kx,kx->k", back, back)
        leaving = -back[rows, wall] * np.sign(way[rows, wall]) / np.sqrt(square)
        arriving = np.maximum(-back[:, 2], 0.0) / np.sqrt(square)
        lit = np.maximum(leaving, 0.0) * arriving / square
        made.append(direct + flux * reflectance / np.pi * lit.mean())
    return np.array(made)


@pytest.mark.parametrize("radius", [0.0, 0.0012])
@pytest.mark.parametrize("away", [0.0024, 0.02])
@pytest.mark.slow
def test_sensors_get_what_a_lamp_close_to_a_wall_makes_of_it(away, radius):
    """Next-event alone leaves a third of it to chance, and states a tenth of that as error, or as much as there is."""
    at = np.array([away, 2.2, 1.7])
    places = np.array([[1.5, 1.5, 0.0], [0.5, 0.4, 0.0], [2.9, 0.2, 0.0]])
    session = session_of(paint(0.5), box(3, 3, 3), lamp(at, 1000.0, radius))
    made = session.measure(
        places + np.array([0.0, 0.0, 1e-4]),
        np.tile([0.0, 0.0, 1.0], (3, 1)),
        StopRule(samples=1 << 16),
        reflections=1,
    )
    true = first_reflection(at, 1000.0, 0.5, 3.0, places)
    error = np.array(made.standard_error)
    assert (error < 0.01 * true).all()
    assert (np.abs(made.illuminance - true) < 4.0 * error + 0.004 * true).all()


ACROSS = {
    "nothing": None,
    "a pane that does nothing": ThinGlass(1.0, Constant(1.0)),
    "a mirror": Glossy(Constant(1.0), 0.0),
}
"""What stands in the middle of a sphere and leaves its light even: a mirror makes a whole one of a half."""


@pytest.mark.parametrize("name", ACROSS)
@pytest.mark.slow
def test_sensors_of_a_bright_room_get_all_reflections_of_a_lamp_at_a_wall(name):
    """A sphere's inside is lit evenly by what it reflects, wherever the lamp is, also where spots lie behind mirrors."""
    from glass_scenes import ball

    radius, reflectance, away = 2.0, 0.8, 0.005
    shell = ball("room", radius, np.zeros(3), "paint", 96)
    triangles = np.ascontiguousarray(shell.triangles[:, ::-1])
    is_half = name == "a mirror"
    if is_half:
        triangles = triangles[shell.vertices[triangles][:, :, 2].mean(axis=1) > 0.0]
    # Flat faces: what smooth shading makes of grazing light is not even.
    inside = replace(shell, triangles=triangles, corner_normals=None,
                     material_index=np.zeros(len(triangles), np.int32))  # fmt: skip
    at = np.array([0.0, 0.0, radius - away])
    items = [paint(reflectance), inside, lamp(at, 1000.0, 0.0)]
    if ACROSS[name] is not None:
        items += [
            quad("across", (-2.2, -2.2, 0.0), (4.4, 0.0, 0.0), (0.0, 4.4, 0.0), "across"),
            Material("across", "across", ACROSS[name]),
        ]
    away = 0.998 * radius
    places = away * np.array([[np.cos(0.3), 0.0, np.sin(0.3)], [0.0, 0.0, -1.0]])
    if is_half:
        places = places[:1]
    made = session_of(*items).measure(places, -places / away, StopRule(samples=1 << 16))
    lamps = np.array([at, -at] if is_half else [at])
    ways = lamps - places[:, None]
    cosines = np.maximum(np.einsum("kli,ki->kl", ways, -places / away), 0.0)
    straight = (cosines / np.linalg.norm(ways, axis=2) ** 3).sum(axis=1) / (4.0 * np.pi)
    reflected = len(lamps) / (4.0 * np.pi * radius**2) * reflectance / (1.0 - reflectance)
    true = 1000.0 * (straight + reflected)
    error = np.array(made.standard_error)
    assert (error < 0.005 * true).all()
    assert (np.abs(made.illuminance - true) < 4.0 * error + 0.001 * true).all()


@pytest.mark.parametrize("width", [0.005, pytest.param(0.03, marks=pytest.mark.slow)])
def test_sensors_get_what_a_sunlit_spot_behind_a_keyhole_sends_on(width):
    """The outside in the sun is as large as the box; what counts is what sensors see."""
    towards, patch = np.array([0.2, 0.1, -1.0]), np.array([0.7, 0.6, 0.0])
    normal = 1e5 * float(np.linalg.norm(towards))
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, normal),
                   towards / np.linalg.norm(towards), np.radians(0.53))  # fmt: skip
    places = np.array([[1e-4, 0.5, 0.5], [0.5, 1e-4, 0.3], [0.9, 0.9, 0.9999]])
    facing = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]])
    session = session_of(paint(0.7), pierced_box(width), sun)
    made = session.measure(places, facing, StopRule(samples=1 << 16), reflections=1)
    way = patch - places
    square = (way**2).sum(axis=1)
    cosines = (way * facing).sum(axis=1) * -way[:, 2]
    expected = 0.7 * 1e5 * width**2 / np.pi * cosines / square**2
    error = np.array(made.standard_error)
    # The penumbra and the width of the patch change it by less than a hundredth.
    assert (error < 0.02 * expected).all()
    assert (np.abs(made.illuminance - expected) < 4.0 * error + 0.005 * expected).all()


def keyhole_sun():
    towards = np.array([0.2, 0.1, -1.0]) / np.linalg.norm([0.2, 0.1, -1.0])
    return SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1e5), towards, np.radians(0.53))


def test_a_job_that_cannot_begin_leaves_its_suns_to_the_next_one(monkeypatch):
    from lumenray.engine.transport.lux_maps import job as lux_job

    def fail(*_):
        raise MemoryError("no room for cells")

    session = session_of(paint(0.5), pierced_box(0.005), keyhole_sun())
    monkeypatch.setattr(lux_job, "Sweeper", fail)
    with pytest.raises(MemoryError):
        bake_in(session, ("room",), 8)
    with session._engine("auto") as scene:
        assert scene.near is None
        assert scene.surroundings.sun_value(*looks_at(keyhole_sun()))[0][0] > 0.0


def test_rays_that_slip_between_lid_and_wall_are_known_from_those_through_the_hole():
    """The lid's edge runs along the wall's, but they share no corners. Processors may let none slip."""
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.arrays import upload
    from lumenray.engine.transport.light_tracing.deposits import (
        fetch_deposits,
        follow,
        lands_beside,
    )
    from lumenray.engine.transport.paths.sampler import random_stream

    draw, count = np.random.default_rng(2), 1 << 19
    towards = keyhole_sun().direction
    along = draw.uniform(0.0, 1.0, count)
    near_edge = np.stack([along, 1.0 + draw.uniform(-2e-7, 2e-7, count), np.ones(count)], axis=1)
    in_hole = np.array([0.5, 0.5, 1.0]) + draw.uniform(-0.0025, 0.0025, (count, 3)) * [1, 1, 0]
    with session_of(paint(0.5), pierced_box(0.005), keyhole_sun())._engine("auto") as scene:
        for aims, through, least in ((near_edge, 0.0, 0), (in_hole, 1.0, count // 2)):
            starts = scene.local(aims) - 1.7 * towards
            columns = [upload(mi.Float, starts[:, k].astype(np.float32)) for k in range(3)]
            ray = mi.Ray3f(mi.Point3f(*columns), mi.Vector3f(*towards.astype(np.float32).tolist()))
            ray.d += dr.zeros(mi.Vector3f, count)
            everyone = dr.full(mi.Bool, True, count)
            stream = random_stream(dr.arange(mi.UInt32, count), mi.UInt32(1))
            end = follow(scene, ray, stream, everyone, lambda _: mi.Bool(True))
            told = [end["length"], *ray.o, *ray.d]
            made, ways = fetch_deposits(end, dr.full(mi.Float, 1.0, count), None, None, told)
            inside = np.flatnonzero(~made.back)
            assert len(inside) >= least
            held = lands_beside(scene, ways[inside], made.only(inside))
            assert held.sum() == pytest.approx(through * len(inside), abs=0.01 * len(inside))


def looks_at(sun):
    import drjit as dr
    import mitsuba as mi

    none = dr.zeros(mi.SurfaceInteraction3f).wavelengths
    return -mi.Vector3f(*sun.direction.tolist()), none, mi.Bool(True)


def test_suns_that_are_left_out_have_all_that_the_others_have_not():
    session = session_of(paint(0.5), pierced_box(0.005), keyhole_sun())
    with session._engine("auto") as scene:
        sky, looks = scene.surroundings, looks_at(keyhole_sun())
        whole = sky.sun_value(*looks)[0][0]
        sky.leave_out((0,))
        try:
            assert sky.sun_value(*looks)[0][0] == 0.0
            assert sky.left_out_value(*looks)[0][0] == whole > 0.0
        finally:
            sky.leave_out(())
        assert sky.left_out_value(*looks)[0][0] == 0.0


def test_limits_near_luminaires_are_those_of_their_rows():
    from types import SimpleNamespace

    session = session_of(paint(0.5), room(), lamp((1.5, 1.5, 1.5)))
    with session._engine("auto"):
        import mitsuba as mi

        from lumenray.engine.transport.light_tracing.straight_lights import NearLimits

        # All luminaires have the number of the first one, to which their row is added.
        lights = SimpleNamespace(
            count=3, index=lambda pointer, active, row: mi.UInt32(1) + mi.UInt32(row)
        )
        source = SimpleNamespace(centre=np.zeros(3))
        near = NearLimits(lights, {1: (source, 0.5)})
        place = mi.Point3f(0.1, 0.0, 0.0)
        found = [near.has_emitter(None, mi.Float(row), place, mi.Bool(True))[0] for row in (0, 1)]
    assert found == [True, False]
