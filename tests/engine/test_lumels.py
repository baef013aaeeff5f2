"""Lumels: coverage, areas, places, blocks; and which of them light can reach."""

from dataclasses import replace

import numpy as np
import pytest
from lumenray.engine.atlas import coverage, lumels
from lumenray.engine.atlas.layout import Atlas, SurfaceLayout
from lumenray.engine.atlas.lumels import LumelTable
from lumenray.engine.errors import Cancelled, SceneError
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.mesh import Mesh
from small_scenes import box, paint, quad, session_of


def mesh_of(vertices, triangles, **more):
    triangles = np.asarray(triangles, np.int32)
    return Mesh(
        "m", "m", np.asarray(vertices, float), triangles, ("paint",),
        np.zeros(len(triangles), np.int32), **more,
    )  # fmt: skip


def atlas_of(uv, density, size=64, chart=None, page=None, is_back=False):
    count = len(uv)
    layout = SurfaceLayout(
        np.asarray(uv, float),
        np.zeros(count, np.int32) if page is None else page,
        np.zeros(count, np.int32) if chart is None else chart,
        density,
        density,
        is_back,
    )
    pages = int(layout.page.max()) + 1
    return Atlas(np.full((pages, 2), size), (layout,), int(layout.chart.max()) + 1, 1.0)


def flat_atlas(mesh, density, size=64, offset=(2.0, 2.0), drop=2, **more):
    """Layout of a plane mesh by its own coordinates but one."""
    kept = [axis for axis in range(3) if axis != drop]
    corners = mesh.vertices[mesh.triangles][..., kept]
    corners = corners - corners.reshape(-1, 2).min(axis=0)
    return atlas_of(corners * density + np.asarray(offset), density, size, **more)


def square_of_random_triangles(seed, count=60, side=3.0):
    """Square cut into triangles by inserting random points, some close together and some on edges. (v, 3), (t, 3)"""
    rng = np.random.default_rng(seed)
    points = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)]
    triangles = [(0, 1, 2), (0, 2, 3)]
    for _ in range(count):
        number = rng.integers(len(triangles))
        a, b, c = triangles.pop(number)
        weight = rng.dirichlet(np.full(3, rng.choice([0.05, 1.0])))
        points.append(tuple(weight @ np.array([points[a], points[b], points[c]])))
        new = len(points) - 1
        triangles += [(a, b, new), (b, c, new), (c, a, new)]
    return np.column_stack([points, np.zeros(len(points))]), np.array(triangles)


def all_blocks(table):
    return [table.block(number) for number in range(len(table.counts))]


def place_uv(mesh, atlas, block):
    """Places on the page, from their positions in the world and the triangles that they are said to lie in."""
    points = mesh.vertices[mesh.triangles[block.triangle]]
    a, b, c = points[:, 0], points[:, 1], points[:, 2]
    normal = np.cross(b - a, c - a)
    square = np.maximum(np.einsum("kx,kx->k", normal, normal), 1e-300)
    away = block.receivers.positions - a
    v = np.einsum("kx,kx->k", np.cross(away, c - a), normal) / square
    w = np.einsum("kx,kx->k", np.cross(b - a, away), normal) / square
    bary = np.stack([1.0 - v - w, v, w], axis=1)
    uv = atlas.layouts[block.layout].uv[block.triangle]
    return bary, np.einsum("kc,kcx->kx", bary, uv)


@pytest.mark.parametrize("seed", range(4))
def test_areas_of_lumels_add_up_to_the_mesh(seed):
    mesh = mesh_of(*square_of_random_triangles(seed))
    table = LumelTable([mesh], flat_atlas(mesh, 9.7))
    area = np.concatenate([block.area for block in all_blocks(table)])
    assert area.sum() == pytest.approx(9.0, rel=1e-9)
    # And each lumel has what the square has there.
    block = table.block(0)
    y, x = np.divmod(block.index, 64)
    low = np.stack([x, y], axis=1)
    overlap = np.clip(np.minimum(low + 1, 2.0 + 3.0 * 9.7) - np.maximum(low, 2.0), 0.0, 1.0)
    # Corners are put on borders of lumels that they nearly lie on, so to 2^-12 of a lumel along both sides.
    assert np.abs(block.area * 9.7**2 - overlap.prod(axis=1)).max() < 2 * coverage.SNAP


@pytest.mark.parametrize("seed", range(4))
def test_places_lie_in_their_lumel_and_in_their_triangle(seed):
    mesh = mesh_of(*square_of_random_triangles(seed))
    atlas = flat_atlas(mesh, 7.3)
    block = LumelTable([mesh], atlas).block(0)
    areas = mesh.areas()[block.triangle]
    bary, uv = place_uv(mesh, atlas, block)
    # What the slivers among them do to the inversion above is left out.
    sound = areas > 1e-6
    assert sound.mean() > 0.9
    assert bary[sound].min() > -1e-6
    lumel = np.repeat(np.arange(len(block.index)), block.receivers.count)
    y, x = np.divmod(block.index[lumel], 64)
    within = uv - np.stack([x, y], axis=1)
    assert within[sound].min() > -2 * coverage.SNAP
    assert within[sound].max() < 1.0 + 2 * coverage.SNAP
    assert block.receivers.count.min() >= 1
    assert (np.diff(block.index) > 0).all()
    assert np.array_equal(
        block.receivers.start, np.cumsum(block.receivers.count) - block.receivers.count
    )


def test_a_whole_lumel_has_places_spread_evenly():
    floor = quad("floor", (0, 0, 0), (2, 0, 0), (0, 2, 0), "paint")
    atlas = flat_atlas(floor, 4.0)
    block = LumelTable([floor], atlas).block(0)
    assert len(block.index) == 64
    assert (block.receivers.count == 16).all()
    places = block.receivers.positions.reshape(64, 16, 3)[..., :2] * 4.0 % 1.0
    for axis in (0, 1):
        # One place in every sixteenth, each way.
        assert np.array_equal(
            np.sort((places[..., axis] * 16).astype(int), axis=1), np.tile(np.arange(16), (64, 1))
        )


def test_the_share_of_places_follows_a_slanted_edge():
    # Half plane below y = 0.37 x + 5: of a lumel's 16 places as many lie below as of its area, to one in sixteen.
    width = 40.0
    corners = np.array(
        [[2, 2.0, 0], [2 + width, 2.0, 0], [2 + width, 5 + 0.37 * width, 0], [2, 5.0, 0]]
    )
    mesh = mesh_of(corners, [(0, 1, 2), (0, 2, 3)])
    uv = mesh.vertices[mesh.triangles][..., :2]
    block = LumelTable([mesh], atlas_of(uv, 1.0)).block(0)
    count = block.receivers.count
    cut = (block.area < 0.999) & (count > 1)
    assert cut.sum() > 30
    assert np.abs(count / 16.0 - block.area)[cut].max() < 2.5 / 16.0
    assert abs((count[cut] / 16.0 - block.area[cut]).mean()) < 0.01


def test_slivers_thinner_than_a_lumel_are_covered_without_gaps():
    # A strip 1e-6 lumels thin, across lumels at a slant: every lumel that it passes counts, and holds its area.
    length, thin = 37.3, 1e-6
    way = np.array([np.cos(0.4), np.sin(0.4)])
    across = np.array([-way[1], way[0]]) * thin
    flat = np.array(
        [
            [3.2, 4.1],
            [3.2, 4.1] + way * length,
            [3.2, 4.1] + way * length + across,
            [3.2 + across[0], 4.1 + across[1]],
        ]
    )
    mesh = mesh_of(np.column_stack([flat, np.zeros(4)]), [(0, 1, 2), (0, 2, 3)])
    block = LumelTable([mesh], atlas_of(mesh.vertices[mesh.triangles][..., :2], 1.0)).block(0)
    steps = np.linspace(0.0, 1.0, 200_001)[1:-1, None]
    passed = np.floor(flat[0] + way * length * steps).astype(int)
    expected = np.unique(passed[:, 1] * 64 + passed[:, 0])
    assert np.isin(expected, block.index).all()
    assert len(block.index) <= len(expected) + 2
    assert block.area.sum() == pytest.approx(length * thin, rel=1e-6)
    y, x = np.divmod(block.index, 64)
    within = block.receivers.positions[:, :2] - np.stack([x, y], axis=1)
    assert (block.receivers.count == 1).all()
    assert within.min() > -1e-6
    assert within.max() < 1.0 + 1e-6


def test_triangles_that_are_points_on_the_page_keep_their_area():
    # A wall seen edge-on by its layout: no area on the page, but 2 m2 on the surface.
    mesh = mesh_of([[0, 0, 0], [2, 0, 0], [2, 0, 2]], [(0, 1, 2)])
    block = LumelTable([mesh], atlas_of([[[3.5, 4.5]] * 3], 1.0)).block(0)
    assert block.index.tolist() == [4 * 64 + 3]
    assert block.area.sum() == pytest.approx(2.0)
    assert np.isfinite(block.receivers.positions).all()


def test_two_triangles_share_their_common_edge_without_doubles():
    floor = quad("floor", (0, 0, 0), (3, 0, 0), (0, 3, 0), "paint")
    block = LumelTable([floor], flat_atlas(floor, 5.0)).block(0)
    places = np.round(block.receivers.positions, 9)
    assert len(np.unique(places, axis=0)) == len(places)
    assert (block.receivers.count == 16).all()


def test_a_lumel_of_two_charts_goes_to_the_larger_part():
    # Two strips side by side that meet at x = 5.3 within a lumel.
    vertices = [[2, 2, 0], [5.3, 2, 0], [5.3, 6, 0], [2, 6, 0], [8, 2, 0], [8, 6, 0]]
    mesh = mesh_of(vertices, [(0, 1, 2), (0, 2, 3), (1, 4, 5), (1, 5, 2)])
    uv = mesh.vertices[mesh.triangles][..., :2]
    block = LumelTable([mesh], atlas_of(uv, 1.0, chart=np.array([0, 0, 1, 1], np.int32))).block(0)
    column = block.index % 64
    assert (block.chart[column < 5] == 0).all()
    assert (block.chart[column >= 5] == 1).all()
    assert block.area.sum() == pytest.approx(24.0)
    lumel = np.repeat(np.arange(len(block.index)), block.receivers.count)
    assert ((block.triangle >= 2) == (block.chart[lumel] == 1)).all()


def globe(rings=24, sectors=48, smooth=True):
    """Sphere of radius 1 with its chart of longitude and the sine of the latitude, which keeps areas."""
    sine = np.linspace(-0.98, 0.98, rings + 1)
    turn = np.linspace(0.0, 2 * np.pi, sectors + 1)
    s, t = (x.ravel() for x in np.meshgrid(sine, turn, indexing="ij"))
    vertices = np.stack([np.sqrt(1 - s**2) * np.cos(t), np.sqrt(1 - s**2) * np.sin(t), s], axis=1)
    i, j = (x.ravel() for x in np.meshgrid(np.arange(rings), np.arange(sectors), indexing="ij"))
    a = i * (sectors + 1) + j
    b, c, d = a + 1, a + sectors + 2, a + sectors + 1
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    mesh = mesh_of(vertices, triangles)
    if smooth:
        mesh = replace(mesh, corner_normals=vertices[triangles].astype(np.float32))
    uv = np.stack([t, s], axis=1)[triangles]
    return mesh, (uv - [0.0, -0.98]) * 9.0 + 2.0


def test_the_areas_of_a_sphere_s_chart_add_up_and_its_normals_are_smooth():
    mesh, uv = globe()
    block = LumelTable([mesh], atlas_of(uv, 9.0)).block(0)
    assert block.area.sum() == pytest.approx(mesh.areas().sum(), rel=1e-9)
    held = block.receivers
    outwards = held.positions / np.linalg.norm(held.positions, axis=1, keepdims=True)
    assert np.abs(np.linalg.norm(held.normals, axis=1) - 1.0).max() < 1e-5
    smooth = np.einsum("kx,kx->k", held.normals, outwards)
    facets = np.einsum("kx,kx->k", held.geometric_normals, outwards)
    # Interpolation is of second order in the size of the facets, the facets themselves are of first.
    assert smooth.min() > 0.9999
    assert facets.min() < 0.999


def test_back_sides_look_the_other_way():
    mesh, uv = globe()
    front = LumelTable([mesh], atlas_of(uv, 9.0)).block(0).receivers
    back = LumelTable([mesh], atlas_of(uv, 9.0, is_back=True)).block(0).receivers
    assert np.array_equal(back.normals, -front.normals)
    assert np.array_equal(back.geometric_normals, -front.geometric_normals)
    assert np.array_equal(back.positions, front.positions)


def test_normals_that_look_into_the_surface_are_not_used():
    mesh, uv = globe()
    turned = replace(mesh, corner_normals=-mesh.corner_normals)
    held = LumelTable([turned], atlas_of(uv, 9.0)).block(0).receivers
    assert np.einsum("kx,kx->k", held.normals, held.geometric_normals).min() > 0.0


def same_blocks(a, b):
    names = ("index", "chart", "area", "valid", "triangle")
    held = ("positions", "normals", "geometric_normals", "start", "count", "weights")
    return all(np.array_equal(getattr(a, n), getattr(b, n)) for n in names) and all(
        np.array_equal(getattr(a.receivers, n), getattr(b.receivers, n)) for n in held
    )


def test_blocks_do_not_depend_on_memory_but_for_the_places(monkeypatch):
    from lumenray.engine.atlas import lumels

    monkeypatch.setattr(lumels, "BLOCK_PLACES", 16 * 300)
    mesh, uv = globe()
    rich = LumelTable([mesh], atlas_of(uv, 9.0))
    assert len(rich.counts) > 3
    assert [len(block.index) for block in all_blocks(rich)] == list(rich.counts)
    one = LumelTable([mesh], atlas_of(uv, 9.0))
    first = one.block(2)
    assert same_blocks(first, one._make(2))
    assert one.block(2) is first
    monkeypatch.setattr(lumels, "BLOCK_PLACES", 1 << 21)
    whole = LumelTable([mesh], atlas_of(uv, 9.0)).block(0)
    assert np.array_equal(whole.index, np.concatenate([b.index for b in all_blocks(rich)]))
    assert whole.area == pytest.approx(
        np.concatenate([b.area for b in all_blocks(rich)]), rel=1e-12
    )
    poor = LumelTable([mesh], atlas_of(uv, 9.0), memory=1 << 10)
    assert poor.places == 4
    assert poor.block(0) is not poor.block(0)
    assert same_blocks(poor.block(0), poor.block(0))
    assert np.array_equal(poor.block(0).index, whole.index)


def test_layouts_on_several_pages_come_in_blocks_of_their_own():
    mesh = mesh_of(*square_of_random_triangles(1))
    atlas = flat_atlas(mesh, 9.0, page=(np.arange(len(mesh.triangles)) % 3 - 1).astype(np.int32))
    table = LumelTable([mesh], atlas)
    blocks = all_blocks(table)
    assert [(b.layout, b.page) for b in blocks] == [(0, 0), (0, 1)]
    assert all(table.width(number) == 64 for number in range(2))
    assert [table.page(number) for number in range(2)] == [0, 1]
    kept = mesh.areas()[atlas.layouts[0].page >= 0].sum()
    assert sum(b.area.sum() for b in blocks) == pytest.approx(kept, rel=1e-9)


def test_a_layout_that_does_not_fit_its_mesh_is_refused():
    mesh = mesh_of(*square_of_random_triangles(1))
    atlas = flat_atlas(mesh, 9.0)
    with pytest.raises(SceneError, match="one each"):
        LumelTable([mesh, mesh], atlas)
    with pytest.raises(SceneError, match="its layout has"):
        LumelTable([box(1, 1, 1)], atlas)
    broken = replace(atlas.layouts[0], uv=np.full_like(atlas.layouts[0].uv, np.nan))
    with pytest.raises(SceneError, match="not finite"):
        LumelTable([mesh], replace(atlas, layouts=(broken,)))


# ---- validity ----

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
    facts = lumels._Facts(replace(block, valid=valid)).unpack()
    assert (facts.layout, facts.page) == (block.layout, block.page)
    np.testing.assert_array_equal(facts.index, block.index)
    np.testing.assert_array_equal(facts.chart, block.chart)
    np.testing.assert_array_equal(facts.valid, valid)
    np.testing.assert_allclose(facts.area, block.area, rtol=1e-6)


# ---- samples between places ----


def test_boxes_part_a_lumel_and_each_holds_its_place():
    for count in (4, 8, 16):
        boxes = lumels.Boxes.around(lumels._net(count))
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
