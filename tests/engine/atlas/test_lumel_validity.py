"""Lumels that light can reach, and samples between their places."""

from dataclasses import replace

import numpy as np
import pytest
from lumel_meshes import flat_atlas, mesh_of, place_uv, same_blocks, square_of_random_triangles
from small_scenes import box, paint, quad, session_of

from lumenray.engine.atlas.boxes import Boxes, net
from lumenray.engine.atlas.lumel_blocks import PackedFacts
from lumenray.engine.atlas.lumels import LumelTable
from lumenray.engine.errors import Cancelled
from lumenray.engine.scene.light import Output, PointLight, Quantity

LAMP = PointLight("l", "l", Output(Quantity.LUMINOUS_FLUX, 1000.0), np.array([0.5, 0.5, 2.5]))


def moved(mesh, offset, key="solid", scale=1.0):
    return replace(mesh, id=key, name=key, vertices=(mesh.vertices + np.asarray(offset)) * scale)


def validated(target, *others, density=8.0, scale=1.0, offset=(0.0, 0.0, 0.0), lamp=LAMP, **more):
    """Table of a mesh that lies level, in a scene that is scaled and then moved."""
    placed = [
        replace(m, vertices=m.vertices * scale + np.asarray(offset)) for m in (target, *others)
    ]
    lamp = replace(lamp, position=lamp.position * scale + np.asarray(offset))
    session = session_of(*placed, paint(0.5), lamp)
    table = LumelTable(placed[:1], flat_atlas(placed[0], density / scale, **more))
    with session._engine("auto") as compiled:
        table.validate(compiled)
    return table


FLOOR = quad("floor", (-2, -2, 0), (4, 0, 0), (0, 4, 0), "paint")


def lumel_grid(block, density=8.0):
    """Low corners of lumels of `FLOOR` in metres."""
    y, x = np.divmod(block.index, 64)
    return np.stack([x, y], axis=1) / density - 2.0 - 2.0 / density


@pytest.mark.mitsuba
@pytest.mark.parametrize(
    ("scale", "offset"),
    [(1.0, (0, 0, 0)), (1e-3, (0, 0, 0)), (1.0, (1e4, -1e4, 1e4)), (300.0, (0, 0, 0))],
)
@pytest.mark.parametrize("depth", [0.005, 0.0, 0.4])
def test_lumels_under_a_box_are_found_and_no_others(scale, offset, depth):
    # Box over x -1..0, y -0.8..0.45, sunk into the floor or standing on it.
    solid = moved(box(1.0, 1.25, 1.0, inwards=False), (-1.0, -0.8, -depth))
    block = validated(FLOOR, solid, scale=scale, offset=offset).block(0)
    low = lumel_grid(block)
    high = low + 1 / 8
    eps = 1e-6
    under = (low >= np.array([-1.0, -0.8]) - eps).all(axis=1) & (
        high <= np.array([0.0, 0.45]) + eps
    ).all(axis=1)
    beside = (low >= np.array([0.0, 0.45]) - eps).any(axis=1) | (
        high <= np.array([-1.0, -0.8]) + eps
    ).any(axis=1)
    assert under.sum() == 8 * 9
    assert not block.valid[under].any()
    assert block.valid[~under].all()
    assert (block.receivers.count[beside] == 16).all()
    # Half covered lumels keep the places in the open only, and all of those.
    held = block.receivers
    place = (held.positions - np.asarray(offset)) / scale
    hidden = ((place[:, :2] > [-1.0, -0.8]) & (place[:, :2] < [0.0, 0.45])).all(axis=1)
    lumel = np.repeat(np.arange(len(block.index)), held.count)
    assert not hidden[block.valid[lumel]].any()
    half = block.valid & ~beside
    share = (
        np.clip(np.minimum(high, [0.0, 0.45]) - np.maximum(low, [-1.0, -0.8]), 0, None).prod(axis=1)
        * 64
    )
    assert np.abs(held.count / 16 - (1 - share))[half].max() < 1.5 / 16


@pytest.mark.mitsuba
def test_no_place_stays_next_to_a_wall():
    # A sheet that stands on the floor exactly where places lie.
    wall = quad("wall", (-2, -2 + 1 / 8 * 4 + 1 / 256, 0), (4, 0, 0), (0, 0, 1), "paint")
    before = LumelTable([FLOOR], flat_atlas(FLOOR, 8.0)).block(0).receivers.positions
    after = validated(FLOOR, wall).block(0)
    line = wall.vertices[0, 1]
    assert np.abs(before[:, 1] - line).min() < 1e-9
    gap = np.abs(after.receivers.positions[:, 1] - line)
    assert gap.min() > 0.9e-3 / 8
    assert after.valid.all()
    # And all others are where they were.
    assert len(before) == len(after.receivers.positions)
    still = np.abs(before[:, 1] - line) > 2e-3 / 8
    assert np.array_equal(before[still], after.receivers.positions[still])


@pytest.mark.mitsuba
def test_thin_sheets_and_open_boxes_hide_nothing():
    tent = box(1.0, 1.0, 1.0, inwards=False)
    open_box = moved(
        replace(tent, triangles=tent.triangles[:-2], material_index=tent.material_index[:-2]),
        (-1.5, 0, -0.1),
    )
    sheet = quad("sheet", (0.2, 0.2, 0.3), (1, 0, 0), (0, 1, 0), "paint")
    down = quad("down", (0.2, -1.5, 0.3), (0, 1, 0), (1, 0, 0), "paint")
    assert validated(FLOOR, open_box, sheet, down).block(0).valid.all()


@pytest.mark.mitsuba
@pytest.mark.parametrize("inwards", [True, False])
def test_a_room_is_no_solid_whichever_way_it_looks(inwards):
    # The lamp is in the room, as is the floor's upper side.
    room = moved(box(5.0, 5.0, 3.0, inwards=inwards), (-2.5, -2.5, -0.5), "room")
    assert validated(FLOOR, room).block(0).valid.all()
    # A lamp that ends flush with the ceiling counts as inside.
    flush = replace(LAMP, position=np.array([0.5, 0.5, 2.5 + 1e-4]))
    assert validated(FLOOR, room, lamp=flush).block(0).valid.all()


@pytest.mark.mitsuba
def test_a_solid_of_glass_is_not_dark():
    from lumenray.engine.scene.material import Dielectric, Material

    solid = replace(
        moved(box(1.0, 1.0, 1.0, inwards=False), (-1.0, -0.5, -0.1)), materials=("glass",)
    )
    session = session_of(FLOOR, solid, paint(0.5), LAMP, Material("glass", "glass", Dielectric()))
    table = LumelTable([FLOOR], flat_atlas(FLOOR, 8.0))
    with session._engine("auto") as compiled:
        table.validate(compiled)
    assert table.block(0).valid.all()


@pytest.mark.mitsuba
def test_a_glowing_box_inside_a_shell_lights_the_shell():
    from lumenray.engine.scene.material import Emission, Material
    from lumenray.engine.scene.spectrum import Constant

    glow = paint(0.0, "glow", emission=Emission(Constant(1.0), 50.0))
    assert isinstance(glow, Material)
    shell = moved(box(5.0, 5.0, 3.0, inwards=False), (-2.5, -2.5, -0.5), "shell")
    lamp = replace(moved(box(0.2, 0.2, 0.2, inwards=False), (1, 1, 1), "lamp"), materials=("glow",))
    session = session_of(FLOOR, shell, lamp, paint(0.5), glow)
    table = LumelTable([FLOOR], flat_atlas(FLOOR, 8.0))
    with session._engine("auto") as compiled:
        table.validate(compiled)
    assert table.block(0).valid.all()


@pytest.mark.mitsuba
def test_boxes_face_to_face_are_dark_between_and_lit_beside():
    # A box of 1 m on a box of 4 m: their common face is one square metre.
    under = moved(box(4.0, 4.0, 1.0, inwards=False), (-2, -2, -1), "under")
    above = moved(box(1.0, 1.25, 1.0, inwards=False), (-1.0, -0.5, 0.0), "above")
    top = np.abs(under.vertices[under.triangles][..., 2]).max(axis=1) < 1e-9
    page = np.where(top, 0, -1).astype(np.int32)
    block = validated(under, above, page=page).block(0)
    low = lumel_grid(block)
    eps = 1e-6
    between = (low >= np.array([-1.0, -0.5]) - eps).all(axis=1) & (
        low + 1 / 8 <= np.array([0.0, 0.75]) + eps
    ).all(axis=1)
    assert between.sum() == 8 * 10
    assert np.array_equal(block.valid, ~between)


@pytest.mark.mitsuba
def test_a_sheet_that_lies_on_the_surface_is_no_lottery():
    # 1e-6 m above the floor: less than rays step off it, more than rounding.
    for height in (0.0, 1e-7, 1e-6, 1e-5):
        sheet = quad("sheet", (-1.0, -0.5, height), (1, 0, 0), (0, 1.25, 0), "paint")
        block = validated(FLOOR, sheet).block(0)
        low = lumel_grid(block)
        between = (low > [-1.01, -0.51]).all(axis=1) & (low < [-0.1, 0.65]).all(axis=1)
        beside = ~((low > [-1.2, -0.7]) & (low < [0.1, 0.8])).all(axis=1)
        assert block.valid[beside].all()
        # All alike: seen from above both, or all of them covered.
        assert len(set(block.valid[between].tolist())) == 1
        assert (block.receivers.count[between] == 16).all()


@pytest.mark.mitsuba
def test_corrections_outlive_the_blocks():
    solid = moved(box(1.0, 1.25, 1.0, inwards=False), (-1.0, -0.83, -0.01))
    table = validated(FLOOR, solid)
    first = table.block(0)
    table._kept.clear()
    again = table.block(0)
    assert again is not first
    assert same_blocks(first, again)
    assert not first.valid.all()


@pytest.mark.mitsuba
def test_looking_over_can_be_cancelled():
    session = session_of(FLOOR, paint(0.5), LAMP)
    table = LumelTable([FLOOR], flat_atlas(FLOOR, 8.0))
    with session._engine("auto") as compiled, pytest.raises(Cancelled):
        table.validate(compiled, lambda: True)


def test_facts_that_are_kept_in_little_memory_are_those_of_the_lumels():
    mesh = box(1.0, 0.7, 0.4)
    table = LumelTable([mesh], flat_atlas(mesh, 9.7))
    block = table.block(0)
    valid = np.arange(len(block.index)) % 3 > 0
    facts = PackedFacts(replace(block, valid=valid)).unpack()
    assert (facts.layout, facts.page) == (block.layout, block.page)
    np.testing.assert_array_equal(facts.index, block.index)
    np.testing.assert_array_equal(facts.chart, block.chart)
    np.testing.assert_array_equal(facts.valid, valid)
    np.testing.assert_allclose(facts.area, block.area, rtol=1e-6)


def test_boxes_part_a_lumel_and_each_holds_its_place():
    for count in (4, 8, 16):
        boxes = Boxes.around(net(count))
        assert len(np.unique(boxes.corners, axis=0)) == count
        assert boxes.size.prod() * count == 1.0
        within = (boxes.points - boxes.corners) / boxes.size
        assert (within > 0.0).all() and (within < 1.0).all()


@pytest.mark.parametrize("seed", range(3))
def test_samples_anywhere_in_a_box_lie_in_the_triangle_of_its_place(seed):
    vertices, triangles = square_of_random_triangles(seed)
    flat = mesh_of(vertices, triangles)
    atlas = flat_atlas(flat, 40.0, 256)
    # However one plane is divided, all of it is boxes.
    assert (LumelTable([flat], atlas).block(0).box > 0).mean() > 0.99
    # Triangles that lean apart have their own.
    vertices[:, 2] = np.random.default_rng(seed).normal(0.0, 0.1, len(vertices))
    mesh = mesh_of(vertices, triangles)
    table = LumelTable([mesh], atlas)
    block = table.block(0)
    used = np.flatnonzero(block.box)
    assert 0.3 < len(used) / len(block.box) < 1.0
    boxes, draw = table.boxes, np.random.default_rng(seed)
    number = block.box[used] - 1
    at = boxes.corners[number] + boxes.size * draw.random((len(used), 2))
    aside = np.clip(at, *boxes.ends) - boxes.points[number]
    lumel = np.repeat(np.arange(len(block.index)), block.receivers.count)[used]
    shift = np.einsum("ka,kax->kx", aside, block.steps[lumel].astype(float))
    moved = replace(
        block,
        triangle=block.triangle[used],
        receivers=replace(block.receivers, positions=block.receivers.positions[used] + shift),
    )
    bary, uv = place_uv(mesh, atlas, moved)
    sound = mesh.areas()[moved.triangle] > 1e-6
    assert bary[sound].min() > -1e-3
    y, x = np.divmod(block.index[lumel], 256)
    within = uv - np.stack([x, y], axis=1)
    assert np.abs(within - np.clip(at, *boxes.ends))[sound].max() < 1e-3


@pytest.mark.mitsuba
@pytest.mark.slow
def test_shadows_that_end_anywhere_in_a_lumel_are_taken_in_full():
    """Sixteen places would see the same part of a lumel in all passes, and state no error."""
    from baking_rooms import bake_in

    from lumenray.engine.scene.light import SunLight

    floor = quad("floor", (0, 0, 0), (2, 0, 0), (0, 2, 0), "paint")
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1000.0), np.array([0, 0, -1.0]), 0.0)
    off = []
    for edge in np.linspace(0.9, 1.05, 7):
        lid = quad("lid", (-1, -1, 1), (1 + edge, 0, 0), (0, 4, 0), "paint")
        session = session_of(paint(0.0), floor, lid, sun)
        made = bake_in(session, ("floor",), 256, witness=False).maps[0]
        true = 1000.0 * (2.0 - edge) / 2.0
        assert abs(made.mean - true) < 4.0 * made.mean_standard_error + 1e-4 * true
        off.append(made.mean / true - 1.0)
    assert np.abs(off).max() < 5e-4


@pytest.mark.mitsuba
def test_samples_stay_off_what_stands_on_a_lumel():
    """A wall that cuts lumels takes their hidden part away, and no sample of the rest lies in it."""
    from lumenray.engine.scene.light import UniformWorld

    floor = quad("floor", (0, 0, 0), (2, 0, 0), (0, 2, 0), "paint")
    wall = box(0.31, 3.0, 2.0, inwards=False)
    wall = replace(
        wall, id="wall", name="wall", vertices=wall.vertices + np.array([0.9, -0.5, -0.1])
    )
    session = session_of(paint(0.0), floor, wall, UniformWorld(100.0))
    with session._engine("auto") as compiled:
        table = LumelTable([floor], flat_atlas(floor, 6.0))
        table.validate(compiled)
        block = table.block(0)
        lumel = np.repeat(np.arange(len(block.index)), block.receivers.count)
        x = block.receivers.positions[:, 0]
        low = np.full(len(block.index), np.inf)
        high = -low
        np.minimum.at(low, lumel, x)
        np.maximum.at(high, lumel, x)
        cut = ((low < 1.22) & (high > 0.89))[lumel]
        assert not block.box[cut].any()
        assert block.box[~cut].all()
