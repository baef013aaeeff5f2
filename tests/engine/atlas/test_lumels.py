"""Lumels: coverage, areas, places, blocks."""

from dataclasses import replace

import numpy as np
import pytest
from lumel_meshes import (
    atlas_of,
    flat_atlas,
    mesh_of,
    place_uv,
    same_blocks,
    square_of_random_triangles,
)
from small_scenes import box, quad

from lumenray.engine.atlas import coverage
from lumenray.engine.atlas.lumels import LumelTable
from lumenray.engine.errors import SceneError


def all_blocks(table):
    return [table.block(number) for number in range(len(table.counts))]


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
