"""Daylight coefficients against closed forms, the validation cases' daylight factors, and runs of single hours."""

import numpy as np
import pytest
from small_scenes import paint, quad, session_of

from lumenray.benchmarks.accuracy.scenes import load_scene
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.daylight.coefficients import DaylightOrder
from lumenray.engine.errors import Cancelled, SceneError
from lumenray.engine.scene.light import (
    CieSky,
    Output,
    PointLight,
    Quantity,
    SunLight,
    UniformWorld,
)
from lumenray.engine.scene.material import Black, Coated, Diffuse, Glossy, Material, ThinGlass
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Constant, Illuminant, Rgb
from lumenray.engine.sky.cie import pattern_of_type
from lumenray.engine.sky.nodes import find_projection, unit_vectors
from lumenray.engine.sky.pattern import evaluate, integrate

pytestmark = pytest.mark.mitsuba

BLACK = Material("black", "black", Black())

GREY = Constant(0.6)

SUN_ANGLE = np.radians(0.533)


def sun_at(elevation, azimuth=0.0):
    return unit_vectors(np.radians(elevation), np.radians(azimuth))


def find(
    session, positions, normals, suns=((0.0, 0.0, 1.0),), samples=2200, transport="auto", **more
):
    order = DaylightOrder(np.array(suns, float), SUN_ANGLE, StopRule(samples=samples), **more)
    places = (np.array(each, float) for each in (positions, normals))
    return session.find_daylight(*places, order, transport=transport)


def error_of(groups):
    return groups.std(axis=0, ddof=1) / np.sqrt(len(groups))


def of_even_sky(made):
    """Mean and standard error of the light of an even sky of 1 cd/m2, without the ground."""
    light = made.sky[..., :-1].sum(axis=2, dtype=float)
    return light.mean(axis=0), error_of(light)


def sky_values(kind, towards, steps=15):
    """Luminances of nodes of a sky that gives 1 lx to an open horizontal plane."""
    projection, pattern = find_projection(steps), pattern_of_type(kind, towards)
    values = evaluate(pattern, projection.directions) / integrate(pattern, weigh=True)
    return projection.project(values[None])[0][0]


def agree(values, errors, expected, bias=0.0, most=4.5):
    deviation = np.abs(values - expected) - bias * np.abs(expected)
    assert (deviation <= most * errors + 1e-9).all(), (values, errors, expected)


def test_open_sensors_have_the_sky_by_closed_forms():
    suns = [sun_at(90.0), sun_at(30.0), sun_at(30.0, 180.0), sun_at(-10.0)]
    made = find(session_of(), [[0, 0, 0]] * 2, [[0, 0, 1], [1, 0, 0]], suns)
    light, errors = of_even_sky(made)
    agree(light, errors, [np.pi, 0.5 * np.pi])
    ground = made.sky[..., -1]
    agree(ground.mean(axis=0), error_of(ground), [0.0, 0.5 * np.pi])
    expected = [[1.0, 0.5, 0.5, 0.0], [0.0, np.sqrt(0.75), 0.0, np.cos(np.radians(10.0))]]
    # At grazing incidence half of the disk is seen.
    np.testing.assert_allclose(made.direct, expected, rtol=1e-3, atol=1.5e-3)
    assert (made.direct_error < 1e-3).all()
    assert not made.reflected.any()


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.6, 0, 0.8)])
def test_light_comes_from_where_it_is_put_down(normal):
    towards = sun_at(40.0, 20.0)
    made = find(session_of(), [[0, 0, 0]], [normal], samples=22_000)
    found = made.sky[:, 0, :-1] @ sky_values(12, towards)
    projection, pattern = find_projection(30), pattern_of_type(12, towards)
    facing = np.maximum(projection.directions @ np.array(normal), 0.0) * projection.areas
    exact = facing @ evaluate(pattern, projection.directions) / integrate(pattern, weigh=True)
    agree(found.mean(), error_of(found), exact, bias=2e-3)


def test_half_of_a_sun_behind_an_edge():
    # The edge of a black wall stands just where the sun's middle is.
    wall = quad(
        "wall", [1.0, -5.0, -5.0], [0, 10, 0], [0, 0, 5.0 + np.tan(np.radians(30.0))], "black"
    )
    made = find(session_of(BLACK, wall), [[0, 0, 0]], [[0, 0, 1]], [sun_at(30.0)])
    assert made.direct[0, 0] == pytest.approx(0.25, abs=3.0 * made.direct_error[0, 0])
    assert 0.01 < made.direct_error[0, 0] < 0.1
    for elevation, seen in ((29.5, 0.0), (30.5, np.sin(np.radians(30.5)))):
        made = find(session_of(BLACK, wall), [[0, 0, 0]], [[0, 0, 1]], [sun_at(elevation)])
        assert made.direct[0, 0] == pytest.approx(seen, rel=1e-3)
        assert made.direct_error[0, 0] < 1e-3


def test_a_pane_takes_from_the_sun_what_it_takes_at_that_angle():
    pane = quad("pane", [-50, -50, 1.0], [100, 0, 0], [0, 100, 0], "pane")
    glass = Material("pane", "pane", ThinGlass(1.52, Constant(0.9)))
    suns = [sun_at(70.0), sun_at(25.0)]
    made = find(session_of(glass, pane), [[0, 0, 0]], [[0, 0, 1]], suns)
    session = session_of(glass, pane)
    for k, sun in enumerate(suns):
        light = SunLight(
            "sun", "sun", Output(Quantity.ILLUMINANCE, 1000.0, Illuminant("D65")), -sun, SUN_ANGLE
        )
        session.apply(SceneDelta(changed=(light,)))
        read = session.measure([[0, 0, 0]], [[0, 0, 1]], StopRule(samples=4096), reflections=0)
        assert 1000.0 * made.direct[0, k] == pytest.approx(read.illuminance[0], rel=2e-3)


def test_the_sun_over_a_matt_wall_by_closed_form():
    # A long wall in the sun beside a sensor that looks at it: half of what it sees sends rho E / pi.
    wall = quad("wall", [3.0, -400, -400], [0, 0, 800], [0, 800, 0], "paint")
    sun = sun_at(40.0, 180.0)
    made = find(session_of(paint(0.5), wall), [[0, 0, 0]], [[1, 0, 0]], [sun], cells=2000)
    reflected = made.reflected[:, 0, 0]
    expected = 0.5 * np.cos(np.radians(40.0))
    agree(reflected.mean(), error_of(reflected), expected, bias=0.01)
    assert abs(made.doubts[:, 0]).max() < 0.02 * expected


def test_the_sun_in_a_mirror_is_put_down_by_the_sky():
    mirror = quad("mirror", [3.0, -400, -400], [0, 0, 800], [0, 800, 0], "mirror")
    silver = Material("mirror", "mirror", Glossy(Constant(0.8), 0.0))
    sun = sun_at(30.0, 180.0)
    made = find(
        session_of(silver, mirror), [[0, 0, 0]], [[1, 0, 0]], [sun], samples=88_000, spacing=1.0
    )
    reflected = made.reflected[:, 0, 0]
    expected = 0.8 * np.cos(np.radians(30.0))
    # As exact as the nodes are fine, and the doubt says so.
    error = np.hypot(error_of(reflected), np.abs(made.doubts[0, 0, 0]) + 0.02)
    assert reflected.mean() == pytest.approx(expected, abs=4.0 * error)


def test_the_sky_in_a_mirror_counts_whole():
    mirror = quad("mirror", [3.0, -4000, -4000], [0, 0, 8000], [0, 8000, 0], "mirror")
    silver = Material("mirror", "mirror", Glossy(Constant(0.8), 0.0))
    made = find(session_of(silver, mirror), [[0, 0, 0]], [[1, 0, 0]], samples=22_000)
    light, errors = of_even_sky(made)
    # The mirror shows the other half of the sky and of the ground.
    agree(light, errors, 0.8 * 0.5 * np.pi, bias=2e-3)
    ground = made.sky[..., -1]
    agree(ground.mean(axis=0), error_of(ground), 0.8 * 0.5 * np.pi, bias=2e-3)


def test_the_sun_on_a_coated_floor_is_that_of_its_hour():
    floor = quad("floor", [-4, -4, 0], [8, 0, 0], [0, 8, 0], "lacquer")
    lacquer = Material("lacquer", "lacquer", Coated(Constant(0.5), 1.5, 1.0, 0.3))
    sun = sun_at(35.0, 60.0)
    place, down = [[0.0, 0.0, 1.0]], [[0, 0, -1]]
    made = find(session_of(lacquer, floor), place, down, [sun], samples=44_000)
    light = SunLight(
        "sun", "sun", Output(Quantity.ILLUMINANCE, 1.0, Illuminant("D65")), -sun, SUN_ANGLE
    )
    session = session_of(lacquer, floor, light)
    read = session.measure(place, down, StopRule(samples=1 << 17), method="paths")
    reflected = made.reflected[:, 0, 0]
    error = np.sqrt(
        error_of(reflected) ** 2 + (made.doubts[:, 0, 0] ** 2).sum() + read.standard_error[0] ** 2
    )
    assert abs(reflected.mean() - read.illuminance[0]) < 4.0 * error
    assert error < 0.05 * read.illuminance[0]


def room(*more, colour=GREY):
    """Room of 4 m with a window to the south (-y) and an overhang; +y is north."""
    faces = (
        quad("floor", [0, 0, 0], [4, 0, 0], [0, 4, 0], "paint"),
        quad("ceiling", [0, 0, 3], [0, 4, 0], [4, 0, 0], "paint"),
        quad("north", [0, 4, 0], [4, 0, 0], [0, 0, 3], "paint"),
        quad("west", [0, 0, 0], [0, 4, 0], [0, 0, 3], "paint"),
        quad("east", [4, 0, 0], [0, 0, 3], [0, 4, 0], "paint"),
        quad("below", [0, 0, 0], [0, 0, 1], [4, 0, 0], "paint"),
        quad("above", [0, 0, 2.5], [0, 0, 0.5], [4, 0, 0], "paint"),
        quad("overhang", [0, -0.8, 2.6], [4, 0, 0], [0, 0.8, 0], "paint"),
        quad("pane", [0, 0, 1], [4, 0, 0], [0, 0, 1.5], "pane"),
    )
    glass = Material("pane", "pane", ThinGlass(1.52, Constant(0.9)))
    walls = Material("paint", "paint", Diffuse(colour))
    return session_of(walls, glass, *faces, *more)


PLACES = np.array([[1.0, 1.0, 0.8], [2.0, 2.0, 0.8], [3.0, 3.5, 0.8], [3.8, 0.3, 0.8]])
UP = np.tile([0.0, 0.0, 1.0], (4, 1))


@pytest.mark.slow
def test_a_room_has_in_every_hour_what_a_run_of_that_hour_gives():
    suns = [sun_at(25.0, -60.0), sun_at(50.0, -90.0), sun_at(12.0, -120.0)]
    made = find(room(), PLACES, UP, suns, samples=22_000, spacing=0.5)
    session, squares = room(), []
    for k, sun in enumerate(suns):
        sky = CieSky(12, sun, 8000.0, 0.2, Illuminant("D65"))
        light = SunLight(
            "sun", "sun", Output(Quantity.ILLUMINANCE, 40_000.0, Illuminant("D65")), -sun, SUN_ANGLE
        )
        session.apply(SceneDelta(changed=(sky, light)))
        read = session.measure(PLACES, UP, StopRule(samples=1 << 14), method="paths")
        values = np.append(8000.0 * sky_values(12, sun), 0.2 / np.pi * 8000.0)
        groups = made.sky @ values + 40_000.0 * made.reflected[..., made.neighbours[k, 0]]
        ours = groups.mean(axis=0) + 40_000.0 * made.direct[:, k]
        error = np.sqrt(
            groups.var(axis=0, ddof=1) / len(groups)
            + (40_000.0 * made.direct_error[:, k]) ** 2
            + 40_000.0**2 * (made.doubts[..., made.neighbours[k, 0]] ** 2).sum(axis=0)
            # What nodes and cells cannot tell, as measured by `benchmark daylight`.
            + (0.005 * ours) ** 2
        )
        squares.append(((ours - read.illuminance) / np.hypot(error, read.standard_error)) ** 2)
        assert ours.sum() == pytest.approx(read.illuminance.sum(), rel=0.02)
    # Twelve squares of about standard normal numbers: 32.9 is exceeded once in a thousand.
    assert np.sum(squares) < 32.9


@pytest.mark.parametrize("transport", ["mono", "spectral"])
def test_the_sun_on_ground_that_goes_on_under_a_building_is_that_of_its_hour(transport):
    # Cells of the ground are wider than the room, and half of that before the window lies under a terrace: the mean of all
    # of it, which nobody sees, is too little by 28 % of the light.
    around = (
        quad("ground", [-90, -94, -0.5], [180, 0, 0], [0, 180, 0], "paint"),
        quad("terrace", [-90, 0, -0.45], [180, 0, 0], [0, 86, 0], "paint"),
    )
    sun = sun_at(65.0, -90.0)
    made = find(room(*around), PLACES, UP, [sun], samples=22_000, transport=transport, cells=400)
    light = SunLight(
        "sun", "sun", Output(Quantity.ILLUMINANCE, 1.0, Illuminant("D65")), -sun, SUN_ANGLE
    )
    session = room(*around, light)
    read = session.measure(PLACES, UP, StopRule(samples=1 << 14), transport="mono", method="paths")
    ours = made.reflected[:, :, 0].mean(axis=0) + made.direct[:, 0]
    error = error_of(made.reflected[..., 0])
    doubts = (made.doubts[..., 0] ** 2).sum(axis=0) + (made.reading * ours) ** 2
    errors = np.sqrt(error**2 + doubts + read.standard_error**2)
    agree(ours, errors, read.illuminance, most=4.0)
    assert (errors < 0.06 * read.illuminance).all()
    assert ours.sum() == pytest.approx(read.illuminance.sum(), rel=0.03)


@pytest.mark.parametrize("colour", [GREY, Rgb(0.8, 0.25, 0.1)], ids=["grey", "red"])
def test_paths_that_end_at_cells_find_what_full_paths_find(colour):
    sun = sun_at(50.0, -90.0)
    made = find(room(colour=colour), PLACES, UP, [sun], samples=22_000, spacing=0.5, cells=600)
    assert made.reading.any()
    lights = (
        UniformWorld(1.0, Illuminant("D65")),
        SunLight(
            "sun", "sun", Output(Quantity.ILLUMINANCE, 1.0, Illuminant("D65")), -sun, SUN_ANGLE
        ),
    )
    straight = np.zeros_like(made.direct[:, 0]), made.direct[:, 0]
    lost = np.zeros_like(made.doubts[..., 0]), made.doubts[..., 0]
    for light, own, groups, doubts in zip(
        lights,
        straight,
        (made.sky.sum(axis=2, dtype=float), made.reflected[..., 0]),
        lost,
        strict=True,
    ):
        session = room(colour=colour)
        session.apply(SceneDelta(changed=(light,)))
        read = session.measure(PLACES, UP, StopRule(samples=1 << 15), method="paths")
        ours = groups.mean(axis=0) + own
        doubt = (doubts**2).sum(axis=0) + (made.reading * ours) ** 2
        errors = np.sqrt(error_of(groups) ** 2 + doubt + read.standard_error**2)
        agree(ours, errors, read.illuminance, bias=2e-3)
        assert ours.sum() == pytest.approx(read.illuminance.sum(), rel=0.03)


@pytest.mark.parametrize("key", ["C12.4x4.sky12", "C14.2x1.sky12"])
def test_openings_of_the_validation_cases(key):
    scene = load_scene(key)
    sky = next(item for item in scene.items if isinstance(item, CieSky))
    session = session_of(*(item for item in scene.items if item is not sky))
    made = find(session, scene.positions, scene.normals, samples=44_000)
    ground = sky.ground_reflectance / np.pi * sky.illuminance
    values = np.append(sky.illuminance * sky_values(sky.type, sky.towards_sun), ground)
    found = made.sky @ values
    # Values where hardly anything is seen of the sky are as exact as the nodes are fine.
    agree(found.mean(axis=0), error_of(found), scene.exact, bias=5e-3)


def test_lamps_do_not_count_and_the_scene_stays_as_it_was():
    lamp = PointLight(
        "lamp", "lamp", Output(Quantity.LUMINOUS_FLUX, 1e6), np.array([2.0, 2.0, 2.0])
    )
    own = CieSky(1, np.array([0.0, 0.0, 1.0]), 5000.0)
    session = room(lamp, own)
    before = session.scene.hash()
    made = find(session, PLACES, UP)
    assert session.scene.hash() == before
    assert session.scene.world is own
    (light, errors), (alone, own_errors) = map(of_even_sky, (made, find(room(), PLACES, UP)))
    agree(light, np.hypot(errors, own_errors), alone)


def test_the_same_seed_gives_the_same_in_blocks_of_any_size(monkeypatch):
    from lumenray.engine.transport.sensors import sky_job

    whole = find(room(), PLACES, UP, seed=7)
    monkeypatch.setattr(sky_job, "TABLE_BYTES", 1)
    parts = find(room(), PLACES, UP, seed=7)
    # But for how products of matrices are rounded.
    np.testing.assert_allclose(whole.sky, parts.sky, rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(whole.reflected, parts.reflected, rtol=1e-5, atol=1e-7)
    other = find(room(), PLACES, UP, seed=8)
    assert not np.array_equal(whole.sky, other.sky)


def test_an_error_ends_the_job_when_it_is_met():
    order = DaylightOrder(np.zeros((0, 3)), SUN_ANGLE, StopRule(error=0.02))
    seen = []
    made = room().find_daylight(PLACES, UP, order, progress=seen.append)
    assert made.error_of_even_world() <= 0.02
    assert made.reflected.shape[2] == made.direct.shape[1] == 0
    assert seen[-1].done == pytest.approx(1.0)
    assert seen[-1].relative_error == pytest.approx(made.error_of_even_world())


def test_a_cancelled_job_leaves_the_scene_as_it_was():
    session = room()
    before = session.scene.hash()
    with pytest.raises(Cancelled):
        order = DaylightOrder(np.array([sun_at(40.0)]), SUN_ANGLE)
        session.find_daylight(PLACES, UP, order, progress=lambda state: session.cancel())
    assert session.scene.hash() == before


def test_few_paths_are_told():
    few, enough = (find(session_of(), [[0, 0, 0]], [[0, 0, 1]], samples=n) for n in (500, 4400))
    assert any("are few" in note for note in few.provenance.notes)
    assert not any("are few" in note for note in enough.provenance.notes)


def test_bad_sensors_are_named():
    with pytest.raises(SceneError, match="sensor 2"):
        find(session_of(), [[0, 0, 0], [np.nan, 0, 0]], [[0, 0, 1], [0, 0, 1]])
