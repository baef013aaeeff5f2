"""The estimator of lux maps: its values against closed forms and other estimators, and its errors against the truth."""

import gc
import weakref
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from baking_rooms import bake, error_ratio, furnished_room, lamp, lumel_places, moved
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import UniformWorld
from lumenray.engine.scene.material import (
    Black,
    Coated,
    Diffuse,
    Emission,
    Glossy,
    Material,
    ThinGlass,
)
from lumenray.engine.scene.spectrum import Constant, Illuminant, Tabulated

pytestmark = pytest.mark.mitsuba

LAMP = lamp((0.6, 0.7, 1.5))
ROOM = furnished_room()
OBJECTS = ("room", "block")


def whole(result):
    """Values of all lumels of a bake."""
    parts = [result.lumels(made.number) for made in result.maps]
    return type(parts[0])(
        *(
            np.concatenate([getattr(part, name) for part in parts])
            for name in ("illuminance", "standard_error", "area")
        )
    )


def assert_alike(one, other):
    """Two bakes of the same lumels agree within their errors, lumel by lumel and on the whole."""
    a, b = whole(one), whole(other)
    spread = np.hypot(a.standard_error.astype(float), b.standard_error)
    # Under the block it is dark, without any error.
    lit = spread > 0.0
    assert lit.mean() > 0.95
    np.testing.assert_array_equal(a.illuminance[~lit], b.illuminance[~lit])
    z = (a.illuminance.astype(float) - b.illuminance)[lit] / spread[lit]
    # Few degrees of freedom widen this a little beyond 1.
    assert 0.85 < np.sqrt(np.mean(np.clip(z, -5.0, 5.0) ** 2)) < 1.2
    for left, right in zip(one.maps, other.maps, strict=True):
        gap = left.mean - left.bias - right.mean + right.bias
        errors = (m.mean_standard_error for m in (left, right))
        biases = (m.bias_error for m in (left, right))
        assert abs(gap) < 4.5 * np.sqrt(sum(e**2 for e in (*errors, *biases)))


# ---- kernels ----


@pytest.mark.slow
def test_bakes_with_other_points_make_no_new_large_kernels():
    """How many rays go on differs from pass to pass; a kernel that depended on it would be compiled again each time."""
    import drjit as dr

    def baked_kernels(seed):
        dr.kernel_history()
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            pane = quad("pane", (0.2, 0.2, 0.9), (0.4, 0.0, 0.0), (0.0, 0.4, 0.0), "pane")
            glass = Material("pane", "pane", ThinGlass(1.5, Constant(0.9)))
            bake([*ROOM, LAMP, paint(0.6), pane, glass], OBJECTS, samples=64, seed=seed)
            history = dr.kernel_history()
        large = [made for made in history if made.get("operation_count", 0) > 1000]
        return {made["hash"] for made in large}, len(large)

    before, _ = baked_kernels(1)
    after, launches = baked_kernels(2)
    assert launches > 2 * len(after) > 0
    assert after <= before


def test_nothing_of_a_bake_lives_on(monkeypatch):
    """Kernels know what lives: a scene that waits for the collector of cycles would have the next one compile them anew."""
    # A bake of its own first: the engine chooses what it computes with.
    bake([*ROOM, LAMP, paint(0.6)], OBJECTS, samples=4)
    from lumenray.engine.transport.compiled.compile import CompiledScene

    made, begin = [], CompiledScene.__init__

    def remember(self, *values, **named):
        made.append(weakref.ref(self))
        begin(self, *values, **named)

    monkeypatch.setattr(CompiledScene, "__init__", remember)
    pane = quad("pane", (0.2, 0.2, 0.9), (0.4, 0.0, 0.0), (0.0, 0.4, 0.0), "pane")
    glass = Material("pane", "pane", ThinGlass(1.5, Constant(0.9)))
    gc.disable()
    try:
        bake([*ROOM, LAMP, paint(0.6), pane, glass], OBJECTS, samples=16)
        assert made
        assert not any(scene() for scene in made)
    finally:
        gc.enable()


# ---- values ----


@pytest.mark.slow
def test_a_pipe_and_a_block_in_a_box_that_all_glow_have_the_closed_form_everywhere(transport):
    """Where all surfaces glow and reflect alike the light is even, whatever their shape."""
    luminance, reflectance = 30.0, 0.6
    walls = paint(reflectance, emission=Emission(Constant(1.0), luminance, two_sided=True))
    room, block = furnished_room()
    turn = np.pi * (np.arange(40) / 20.0)
    # A bent surface of many triangles, smaller than cells.
    rings = np.linspace(0.0, 1.0, 31)
    x, y = 0.4 + 0.25 * np.cos(turn), 0.4 + 0.25 * np.sin(turn)
    vertices = np.stack(
        [np.tile(x, 31), np.tile(y, 31), np.repeat(0.3 + rings, 40)], axis=1
    )  # fmt: skip
    i, j = (c.ravel() for c in np.mgrid[0:30, 0:40])
    a, b = 40 * i + j, 40 * i + (j + 1) % 40
    triangles = np.concatenate(
        [np.stack([a, b, b + 40], axis=1), np.stack([a, b + 40, a + 40], axis=1)]
    )
    pipe = replace(
        block, id="pipe", name="pipe", vertices=vertices, triangles=triangles.astype(np.int32),
        material_index=np.zeros(len(triangles), np.int32),
    )  # fmt: skip
    result = bake(
        (room, block, pipe, walls), ("room", "block", "pipe"), 64, transport=transport, method="cells"
    )  # fmt: skip
    expected = np.pi * luminance / (1.0 - reflectance)
    # The block stands on the floor, so its sixth side is dark.
    shares = {"room": 1.0, "block": 1.0 - 0.25 / 2.1, "pipe": 1.0}
    for made in result.maps:
        assert made.mean == pytest.approx(expected * shares[made.id], rel=0.006)
        values = result.lumels(made.number).illuminance
        assert np.abs(values[values > 0.0] / expected - 1.0).max() < 0.15


@pytest.mark.parametrize("method", ["cells", "paths"])
def test_a_closed_room_takes_in_all_the_light_of_its_lamp(method):
    """What is absorbed is what is emitted, so the mean is flux / ((1 - rho) area) in a room of any shape."""
    room, block = ROOM
    # Off the floor, so that nothing is covered in part.
    block = moved(block, "block", (0, 0, 0.3))
    result = bake((room, block, paint(0.6), LAMP), OBJECTS, 256, method=method)
    total = sum(made.mean * made.area for made in result.maps)
    errors = sum((made.mean_standard_error + made.bias_error) * made.area for made in result.maps)
    bias = sum(made.bias * made.area for made in result.maps)
    expected = 1000.0 / (1.0 - 0.6)
    assert abs(total - bias - expected) < 4.0 * errors
    assert total == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("levels", [(3, 5, 0), (3, 0, 5)], ids=["few over mirrors", "many"])
def test_samples_over_mirrors_may_be_as_many_or_as_few_as_a_plan_wants(monkeypatch, levels):
    """A ball over a black floor beside a mirror: both it and its image act like points; rays find them as well."""
    from lumenray.engine.transport.lux_maps.levels import KINDS, NO_SAMPLES, Levels

    direct, gathered, mirrored = levels

    def uneven(cls, count, samples, kinds):
        assert KINDS.index("mirrored") in kinds
        columns = np.full((len(KINDS), count), NO_SAMPLES, dtype=np.uint8)
        for kind, level in (("direct", direct), ("gathered", gathered), ("mirrored", mirrored)):
            columns[KINDS.index(kind)] = level
        return cls(columns)

    monkeypatch.setattr(Levels, "even", classmethod(uneven))
    share, place = 0.9, np.array([0.6, 0.0, 1.0])
    floor = quad("floor", (-1.0, -1.0, 0.0), (2.0, 0, 0), (0, 2.0, 0), "black")
    items = (
        floor,
        quad("mirror", (1.2, -6.0, 0.0), (0, 0, 6.0), (0, 12.0, 0), "mirror"),
        Material("black", "black", Black()),
        Material("mirror", "mirror", Glossy(Constant(share), 0.0)),
        lamp(place, radius=0.25),
    )
    result = bake(items, ("floor",), 32, density=16.0)
    values = result.lumels(0)
    points, _ = lumel_places(result, result.maps[0], floor)

    def from_point(source):
        away = source - points
        return 1000.0 / (4.0 * np.pi) * away[:, 2] / np.linalg.norm(away, axis=1) ** 3

    image = place * [-1.0, 1.0, 1.0] + [2.4, 0.0, 0.0]
    straight, over = from_point(place), share * from_point(image)
    assert over.mean() > 0.1 * straight.mean()
    # The middle of a lumel stands for its mean within 0.1 %: curvature times the square of a lumel over 24.
    off = (values.illuminance - straight - over).mean()
    error = np.sqrt((values.standard_error.astype(float) ** 2).mean() / len(points))
    assert error < 0.01 * over.mean()
    assert abs(off) < 4.0 * error + 0.001 * straight.mean()


@pytest.mark.slow
def test_lumels_have_the_illuminance_of_their_centres():
    room, block = ROOM
    items = (room, block, paint(0.6), LAMP)
    result = bake(items, ("room",), 512, density=10.0)
    made, values = result.maps[0], result.lumels(0)
    places, normals = lumel_places(result, made, room)
    # Away from edges, shadows and the lamp light is nearly linear over a lumel.
    rng = np.random.default_rng(1)
    inner = ((places > 0.3) & (places < 1.7)).sum(axis=1) >= 2
    away = np.linalg.norm(places - LAMP.position, axis=1) > 0.7
    clear = (
        ~((places[:, 0] > 0.9) & (places[:, 1] > 0.8)) & (places[:, 0] < 1.9) & (places[:, 1] < 1.9)
    )
    rows = rng.choice(np.flatnonzero(inner & away & clear), 60, replace=False)
    points = session_of(*items).measure(places[rows], normals[rows], StopRule(samples=1 << 15))
    spread = np.hypot(points.standard_error, values.standard_error[rows])
    # Half a per cent for what is not linear: curvature times the square of a lumel over 24.
    z = (values.illuminance[rows] - points.illuminance) / np.hypot(
        spread, 0.005 * points.illuminance
    )
    assert 0.6 < np.sqrt(np.mean(z**2)) < 1.3
    assert abs(z.mean()) < 4.0 / np.sqrt(len(rows)) + 0.2


COLOURS = np.arange(380.0, 781.0, 20.0)
RED = Material("paint", "paint", Diffuse(Tabulated(COLOURS, np.where(COLOURS > 590, 0.85, 0.05))))
GREEN = Material(
    "green",
    "green",
    Diffuse(Tabulated(COLOURS, 0.1 + 0.7 * np.exp(-(((COLOURS - 530) / 40) ** 2)))),
)


@pytest.mark.slow
def test_cells_agree_with_full_paths_in_grey_and_in_saturated_colours(transport):
    if transport == "mono":
        items = (*ROOM, paint(0.7), LAMP)
    else:
        daylight = replace(LAMP, output=replace(LAMP.output, spectrum=Illuminant("D65")))
        room, block = ROOM
        items = (room, replace(block, materials=("green",)), RED, GREEN, daylight)
    made = [
        bake(items, OBJECTS, 256, transport=transport, method=method, seed=seed)
        for seed, method in enumerate(("cells", "paths"))
    ]
    assert "cells" in " ".join(made[0].maps[0].provenance.decisions)
    assert_alike(*made)


@pytest.mark.parametrize(("roughness", "specular"), [(0.15, 1.0), (0.6, 0.5)])
@pytest.mark.slow
def test_what_coats_mirror_is_added_to_what_cells_under_them_hold(roughness, specular):
    """Half of the light at grazing angles is mirrored: lamps shine in the walls; a coat on a bright and on a dark base."""
    walls = Material("paint", "paint", Coated(Constant(0.7), 1.7, roughness, specular))
    dark = Material("dark", "dark", Coated(Constant(0.02), 1.7, roughness, specular))
    room, block = ROOM
    items = (room, replace(block, materials=("dark",)), walls, dark, LAMP)
    made = [
        bake(items, OBJECTS, 256, method=method, seed=seed)
        for seed, method in enumerate(("cells", "paths"))
    ]
    assert_alike(*made)


def test_a_coat_that_a_room_does_not_see_takes_none_of_its_light():
    """All flux of a lamp in a closed matt room falls on its walls, 1 / (1 - reflectance) times."""
    room, block = furnished_room()
    away = moved(block, "away", (20.0, 0.0, 0.0))
    coated = Material("coated", "coated", Coated(Constant(0.8)))
    items = (room, LAMP, paint(0.6), replace(away, materials=("coated",)), coated)
    (made,) = bake(items, ("room",), 64, method="cells").maps
    expected = 1000.0 / (1.0 - 0.6) / 24.0
    assert made.mean == pytest.approx(expected, rel=0.02)
    assert abs(made.bias) < 0.01 * expected


@pytest.mark.slow
def test_rooms_with_coats_are_as_bright_with_cells_as_without():
    """Seed by seed the error of a mean is half of what coats bring, 5 % of the light; so the mean of six."""
    walls = Material("paint", "paint", Coated(Constant(0.7), 1.7, 0.15, 1.0))
    dark = Material("dark", "dark", Coated(Constant(0.02), 1.7, 0.15, 1.0))
    room, block = ROOM
    items = (room, replace(block, materials=("dark",)), walls, dark, LAMP)

    def flux(method, seed):
        maps = bake(items, OBJECTS, 256, method=method, seed=seed).maps
        return sum(m.area * (m.mean - m.bias) for m in maps)

    found = np.array([[flux(m, seed) for seed in range(6)] for m in ("cells", "paths")])
    mean, error = found.mean(axis=1), found.std(axis=1, ddof=1) / np.sqrt(6.0)
    assert np.hypot(*error) < 0.01 * mean[1]
    assert abs(mean[0] - mean[1]) < 4.0 * np.hypot(*error) + 0.002 * mean[1]


# ---- errors ----


@pytest.mark.slow
def test_stated_errors_are_the_distances_from_a_long_reference():
    items = (*ROOM, paint(0.5), LAMP)
    reference = whole(bake(items, OBJECTS, 1280, method="paths", seed=99))
    ratios, covered = [], []
    for seed in range(3):
        made = whole(bake(items, OBJECTS, 128, seed=seed))
        ratios.append(error_ratio(made, reference))
        spread = np.hypot(made.standard_error.astype(float), reference.standard_error)
        # 2.13: 97.5 % quantile of Student's distribution with 15 degrees of freedom.
        covered.append(np.mean(np.abs(made.illuminance - reference.illuminance) < 2.13 * spread))
    assert 0.9 < np.mean(ratios) < 1.1
    assert 0.93 < np.mean(covered) < 0.97


@pytest.mark.slow
def test_means_of_other_seeds_scatter_as_their_errors_say():
    """The light of the cells is common to all lumels, so what it is wrong by shows in means first of all."""
    made = [
        bake((box(2, 2, 2), paint(0.8), LAMP), ("box",), 64, density=4.0, method="cells", seed=seed)
        for seed in range(8)
    ]
    made = [each.maps[0] for each in made]
    stated = np.sqrt(np.mean([m.mean_standard_error**2 for m in made]))
    # The mean is known: flux / ((1 - rho) area). Seven or eight in chi square: 0.5 to 1.6 is beyond 99 %.
    expected = 1000.0 / (0.2 * 24.0)
    true = np.sqrt(np.mean([(m.mean - expected) ** 2 for m in made]))
    assert 0.4 < true / stated < 1.7


@pytest.mark.slow
def test_the_same_seed_gives_the_same_bits_and_another_the_same_light():
    items = (*ROOM, paint(0.5), LAMP)
    one, again, other = (bake(items, OBJECTS, 64, seed=seed) for seed in (3, 3, 4))
    for a, b in zip(one.pages, again.pages, strict=True):
        np.testing.assert_array_equal(a.illuminance, b.illuminance)
        np.testing.assert_array_equal(a.standard_error, b.standard_error)
    assert one.maps[0].bias == again.maps[0].bias
    assert not np.array_equal(one.pages[0].illuminance, other.pages[0].illuminance)
    assert_alike(one, other)


@pytest.mark.slow
def test_lumels_that_do_not_fit_the_memory_get_the_same_light(monkeypatch):
    from lumenray.engine.atlas import lumels
    from lumenray.engine.baking import surfaces
    from lumenray.engine.transport.lux_maps import lumel_places

    items = (*ROOM, paint(0.5), LAMP)
    one = bake(items, OBJECTS, 128, seed=1)
    monkeypatch.setattr(surfaces, "LumelTable", partial(lumels.LumelTable, memory=1 << 14))
    # Many blocks and lots of them, which are made anew for every pass.
    monkeypatch.setattr(lumels, "BLOCK_PLACES", 1 << 10)
    monkeypatch.setattr(lumel_places, "SPAN_PLACES", 1 << 11)
    other = bake(items, OBJECTS, 128, seed=2)
    assert_alike(one, other)
    again = bake(items, OBJECTS, 128, seed=2)
    np.testing.assert_array_equal(whole(other).illuminance, whole(again).illuminance)


def test_names_of_objects_decide_nothing():
    """Neither the ids nor the order in which objects are sent; they stand in the order's order on the pages."""
    room, block = ROOM
    first = bake((room, block, paint(0.5), LAMP), OBJECTS, 16)
    renamed = moved(block, "a", (0, 0, 0)), moved(room, "z", (0, 0, 0))
    second = bake((LAMP, *renamed, paint(0.5)), ("z", "a"), 16)
    for name in ("object", "illuminance", "standard_error"):
        np.testing.assert_array_equal(getattr(first.pages[0], name), getattr(second.pages[0], name))


def test_the_error_falls_with_the_samples():
    items = (*ROOM, paint(0.5), LAMP, UniformWorld(0.0))
    few, many = (bake(items, ("room",), samples, method="paths") for samples in (32, 512))
    gain = few.relative_standard_error / many.relative_standard_error
    # Four by plain random numbers; low-discrepancy points do better.
    assert 3.6 < gain < 16.0
    assert many.maps[0].samples == pytest.approx(512, rel=0.3)


def test_light_does_not_come_through_edges_of_a_closed_box():
    """Outside it is a million times as bright."""
    floor = quad("floor", (0.2, 0.2, 0.5), (1.5, 0, 0), (0, 1.3, 0), "paint")
    items = (box(4.0, 4.0, 3.0), floor, paint(0.9), UniformWorld(1e6))
    assert bake(items, ("box", "floor"), 64, method="cells").mean == 0.0
