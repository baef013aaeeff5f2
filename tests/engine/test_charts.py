"""Charts of meshes: true to scale, in the cone, whole polygons, nothing upon each other, whatever the mesh is like."""

import numpy as np
import pytest
from lumenray.engine.atlas.arrange import lay_out
from lumenray.engine.atlas.chart_search import ChartSearch, Failed, Found
from lumenray.engine.atlas.charts import ChartLimits, find_charts
from lumenray.engine.atlas.outline import find_overlapping
from lumenray.engine.atlas.topology import find_components, weld
from lumenray.engine.errors import Cancelled, SceneError
from lumenray.engine.scene.mesh import Mesh
from small_scenes import box

NO_SEARCH = ChartLimits(faces=0)
"""Everything is cut by its normals."""


def mesh_of(vertices, triangles, polygon=None):
    triangles = np.array(triangles, np.int32).reshape(-1, 3)
    return Mesh(
        "m", "m", np.array(vertices, float), triangles, ("p",), np.zeros(len(triangles), np.int32),
        polygon=None if polygon is None else np.asarray(polygon, np.int32),
    )  # fmt: skip


def sheet(columns, rows, place, closed=(False, False)):
    """Quads over the unit square, laid out in space by a function of (u, v); polygons are the quads."""
    u = np.arange(columns + (not closed[0])) / columns
    v = np.arange(rows + (not closed[1])) / rows
    points = np.stack(place(*np.meshgrid(u, v, indexing="ij")), axis=-1).reshape(-1, 3)
    i, j = (
        each.ravel() for each in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    )
    right, up = (i + 1) % len(u), (j + 1) % len(v)
    a, b, c, d = i * len(v) + j, right * len(v) + j, right * len(v) + up, i * len(v) + up
    triangles = np.stack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)], axis=1)
    return mesh_of(points, triangles, np.repeat(np.arange(len(i)), 2))


def torus(columns=32, rows=16):
    def place(u, v):
        ring = 3.0 + np.cos(2 * np.pi * v)
        return ring * np.cos(2 * np.pi * u), ring * np.sin(2 * np.pi * u), np.sin(2 * np.pi * v)

    return sheet(columns, rows, place, (True, True))


def globe(columns=24, rows=12):
    """Its poles are many vertices in one place, and its triangles there have no area."""

    def place(u, v):
        ring = np.sin(np.pi * (1 - v))
        return (
            ring * np.cos(2 * np.pi * u),
            ring * np.sin(2 * np.pi * u),
            np.cos(np.pi * (1 - v)),
        )

    return sheet(columns, rows, place, (True, False))


def tube(columns=32, rows=4):
    return sheet(
        columns,
        rows,
        lambda u, v: (np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), 3.0 * v),
        (True, False),
    )


def ramp(turns=5, steps=24):
    """A winding ramp: seen from above all its turns lie upon each other."""
    return sheet(
        turns * steps,
        1,
        lambda u, v: (
            (1 + v) * np.cos(-2 * np.pi * turns * u),
            (1 + v) * np.sin(-2 * np.pi * turns * u),
            0.5 * turns * u,
        ),
    )


def rough_ground(size=20, height=1.0):
    heights = np.random.default_rng(5).normal(size=(size + 1, size + 1)) * height
    return sheet(size, size, lambda u, v: (size * u, size * v, heights))


def knot():
    """A bumpy closed surface with bent quads, which neither projection nor xatlas finds easy."""
    rng = np.random.default_rng(8)
    whole = torus(40, 20)
    return mesh_of(
        whole.vertices + rng.normal(size=whole.vertices.shape) * 0.06,
        whole.triangles,
        whole.polygon,
    )


def signed_areas(uv):
    a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    return 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def normals(mesh):
    corners = mesh.vertices[mesh.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-300)


def count_sheets(uv, rng, points=6):
    """Most triangles over any of some places inside the triangles of one chart, their very edges apart."""
    weight = rng.dirichlet((1.0, 1.0, 1.0), (len(uv), points))
    places = np.einsum("tkc,tcx->tkx", weight, uv).reshape(-1, 2)
    area = signed_areas(uv)
    most = 0
    for part in np.array_split(places, max(len(places) // 500, 1)):
        over = np.ones((len(part), len(uv)), bool)
        for i in range(3):
            start, edge = uv[:, i], uv[:, (i + 1) % 3] - uv[:, i]
            away = part[:, None] - start
            side = edge[:, 0] * away[..., 1] - edge[:, 1] * away[..., 0]
            over &= side > 1e-4 * np.maximum(area, 1e-12)
        most = max(most, over.sum(axis=1).max())
    return most


def check(mesh, charts, cone=None):
    """Rules that hold for every mesh."""
    assert np.isfinite(charts.uv).all()
    assert np.isfinite(charts.size).all()
    shown = charts.chart >= 0
    area = mesh.areas()
    assert np.array_equal(np.unique(charts.chart[shown]), np.arange(len(charts.size)))
    if not shown.any():
        return
    # Area is kept, of every chart and of all.
    flat = signed_areas(charts.uv)
    assert (flat[shown] >= -1e-4 * area[shown].max()).all()
    both = [
        np.bincount(charts.chart[shown], each[shown], minlength=len(charts.size))
        for each in (area, flat)
    ]
    assert np.allclose(both[0], both[1], rtol=1e-4, atol=1e-9 * area.sum())
    # Charts begin at 0 and are as large as said, long side first.
    for corner, size in ((charts.uv.min(axis=1), None), (charts.uv.max(axis=1), charts.size)):
        for k in range(2):
            limit = np.full(len(charts.size), np.inf if size is None else -np.inf)
            reduce = np.minimum if size is None else np.maximum
            reduce.at(limit, charts.chart[shown], corner[shown, k])
            assert np.allclose(
                limit, 0.0 if size is None else size[:, k], atol=1e-9 + 1e-9 * charts.size.max()
            )
    assert (charts.size[:, 0] >= charts.size[:, 1] * (1 - 1e-6)).all()
    rng = np.random.default_rng(0)
    direction = normals(mesh)
    for number in range(min(len(charts.size), 200)):
        rows = np.flatnonzero(charts.chart == number)
        assert count_sheets(charts.uv[rows], rng) <= 1
        if cone is not None:
            mean = (direction[rows] * area[rows][:, None]).sum(axis=0)
            angle = np.arccos(np.clip(direction[rows] @ mean / np.linalg.norm(mean), -1, 1))
            one_polygon = mesh.polygon is not None and len(np.unique(mesh.polygon[rows])) == 1
            assert angle.max() <= cone + 1e-6 or one_polygon


def check_polygons(mesh, charts):
    """All triangles of a polygon lie in one chart, and each of its vertices in one place."""
    shown = charts.chart >= 0
    chart = np.full(mesh.polygon.max() + 1, -1)
    chart[mesh.polygon[shown]] = charts.chart[shown]
    assert (charts.chart[shown] == chart[mesh.polygon[shown]]).all()
    placed = np.repeat(chart[mesh.polygon] >= 0, 3)
    key = (mesh.polygon[:, None].astype(int) * len(mesh.vertices) + mesh.triangles).ravel()
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    flat = charts.uv.reshape(-1, 2)
    apart = np.abs(flat - flat[first[inverse.reshape(-1)]]).max(axis=1)
    assert apart[placed].max() < 1e-6 * charts.size.max()


def test_a_box_has_six_charts_of_its_exact_sides():
    charts = find_charts(box(4.0, 3.0, 2.5))
    check(box(4.0, 3.0, 2.5), charts)
    sides = sorted(tuple(side) for side in charts.size.round(12).tolist())
    assert sides == [(3.0, 2.5)] * 2 + [(4.0, 2.5)] * 2 + [(4.0, 3.0)] * 2
    assert charts.notes == ()


@pytest.mark.parametrize("limits", [ChartLimits(), NO_SEARCH], ids=["search", "normals"])
@pytest.mark.parametrize("cone", [1.0, 0.4])
@pytest.mark.parametrize(
    "make", [torus, globe, tube, ramp, rough_ground, knot], ids=lambda make: make.__name__
)
def test_bent_surfaces_keep_the_rules(make, cone, limits):
    mesh = make()
    charts = find_charts(mesh, cone=cone, limits=limits)
    check(mesh, charts, cone)
    check_polygons(mesh, charts)


def test_bent_surfaces_have_few_charts():
    # Six sides of a box round a ball; a tube's four quarters; a ground whose slopes fit in the cone.
    for limits in (ChartLimits(), NO_SEARCH):
        assert len(find_charts(globe(), limits=limits).size) <= 6
        assert len(find_charts(tube(), limits=limits).size) <= 4
        assert len(find_charts(rough_ground(height=0.1), limits=limits).size) == 1


def test_scale_is_even_within_charts():
    # Each normal is within 1 rad of its chart's: foreshortening is at most cos(1), and its mean is taken out.
    for make in (torus, globe, tube, rough_ground):
        mesh = make()
        charts = find_charts(mesh)
        shown = charts.chart >= 0
        ratio = signed_areas(charts.uv)[shown] / mesh.areas()[shown]
        assert np.quantile(ratio, 0.02) > np.cos(1.0)
        assert np.quantile(ratio, 0.98) < 1.0 / np.cos(1.0)


def test_flat_parts_are_exact_however_they_are_turned_or_moved():
    rng = np.random.default_rng(2)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    for scale, shift in ((1.0, 0.0), (1e-3, 0.0), (1.0, 1e4), (1e3, 0.0)):
        room = box(4.0 * scale, 3.0 * scale, 2.5 * scale)
        mesh = mesh_of(room.vertices @ turn.T + shift, room.triangles)
        charts = find_charts(mesh)
        sides = np.sort(charts.size, axis=0) / scale
        expected = np.sort([(3.0, 2.5)] * 2 + [(4.0, 2.5)] * 2 + [(4.0, 3.0)] * 2, axis=0)
        assert np.abs(sides - expected).max() < 1e-6 / min(scale, 1.0) * 1e-2
        check(mesh, charts)


def test_an_oblique_wall_lies_along_its_sides():
    corners = np.array([(0, 0, 0), (3, 1, 0), (3, 1, 2), (0, 0, 2)], float)
    charts = find_charts(mesh_of(corners, [(0, 1, 2), (0, 2, 3)]))
    assert charts.size.tolist() == [pytest.approx([np.sqrt(10.0), 2.0])]
    assert np.unique(charts.uv.reshape(-1, 2).round(9), axis=0).shape == (4, 2)


def test_corners_in_one_place_connect_whatever_their_numbers_are():
    whole = rough_ground(12, 0.1)
    soup = mesh_of(
        whole.vertices[whole.triangles].reshape(-1, 3), np.arange(3 * len(whole.triangles))
    )
    jitter = np.random.default_rng(1).normal(size=soup.vertices.shape) * 1e-7
    for mesh in (soup, mesh_of(soup.vertices + jitter, soup.triangles)):
        charts = find_charts(mesh)
        assert len(charts.size) == 1
        check(mesh, charts)


def test_a_frame_is_cut_instead_of_wasting_its_inside():
    outer = np.array([(0, 0, 0), (40, 0, 0), (40, 40, 0), (0, 40, 0)], float)
    inner = np.array([(2, 2, 0), (38, 2, 0), (38, 38, 0), (2, 38, 0)], float)
    triangles, polygon = [], []
    for i in range(4):
        j = (i + 1) % 4
        triangles += [(i, j, 4 + j), (i, 4 + j, 4 + i)]
        polygon += [i, i]
    mesh = mesh_of(np.concatenate([outer, inner]), triangles, polygon)
    charts = find_charts(mesh)
    check(mesh, charts)
    check_polygons(mesh, charts)
    # 304 m2 of corridor in a court of 1600 m2.
    assert charts.size.prod(axis=1).sum() < 2.0 * 304.0


def test_a_polygon_bent_beyond_the_cone_stays_in_one_piece():
    # One polygon of four triangles that rolls up by 60 degrees at each of its inner edges.
    angle = np.radians(60.0) * np.arange(5)
    x, z = (
        np.concatenate([[0.0], np.cumsum(np.cos(angle))]),
        np.concatenate([[0.0], np.cumsum(np.sin(angle))]),
    )
    low = np.stack([x, 0 * x, z], axis=1)[:4]
    high = low + np.array([0.0, 1.0, 0.0])
    vertices = np.concatenate([low, high])
    triangles = [t for i in range(3) for t in ((i, i + 1, 5 + i), (i, 5 + i, 4 + i))]
    mesh = mesh_of(vertices, triangles, np.zeros(6))
    charts = find_charts(mesh)
    check_polygons(mesh, charts)
    # Unrolled it is a strip of 3 x 1.
    assert charts.size.tolist() == [pytest.approx([3.0, 1.0])]
    assert signed_areas(charts.uv) == pytest.approx(np.full(6, 0.5))


def test_a_polygon_that_is_none_is_taken_apart_and_noted():
    room = box(1.0, 1.0, 1.0)
    charts = find_charts(mesh_of(room.vertices, room.triangles, np.zeros(12)))
    assert len(charts.size) == 12
    assert any("in one piece" in note for note in charts.notes)


PATHOLOGIES = {
    "an edge of three": (
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)],
        [(0, 1, 2), (1, 0, 3), (0, 1, 4)],
    ),
    "a triangle twice": ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2), (0, 1, 2)]),
    "both sides of one": ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 1)]),
    "a line": ([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0)], [(0, 1, 2), (0, 1, 3)]),
    "a vertex twice": ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 0, 1), (0, 1, 2), (2, 2, 2)]),
    "a sliver": (
        [(0, 0, 0), (1, 0, 0), (0.5, 1e-6, 0), (0, 1, 0), (1, -1, 0)],
        [(0, 1, 2), (0, 2, 3), (0, 4, 1)],
    ),
    "a T": (
        [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0), (1, 0, 0), (1, -1, 0), (0, -1, 0), (2, -1, 0)],
        [(0, 1, 2), (0, 2, 3), (4, 0, 6), (4, 6, 5), (1, 4, 5), (1, 5, 7)],
    ),
    "a flipped neighbour": (
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
        [(0, 1, 2), (0, 3, 2)],
    ),
    "faces upon each other": (
        [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (1, 1, 0), (3, 1, 0), (3, 3, 0), (1, 3, 0)],
        [(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7)],
    ),
    "a vertex that nobody uses": (
        [(0, 0, 0), (1e9, 1e9, 1e9), (1, 0, 0), (0, 1, 0)],
        [(0, 2, 3)],
    ),
    "a far triangle": (
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (1e7, 0, 0), (1e7, 1, 0), (1e7, 0, 1)],
        [(0, 1, 2), (1, 3, 2), (4, 5, 6)],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PATHOLOGIES)
@pytest.mark.parametrize("scale", [1.0, 1e-3])
def test_hard_geometry_keeps_the_rules(name, scale):
    vertices, triangles = PATHOLOGIES[name]
    mesh = mesh_of(np.array(vertices, float) * scale, triangles)
    charts = find_charts(mesh, density=8.0 / scale)
    check(mesh, charts)
    # Triangles with area have a chart, the others none.
    assert np.array_equal(charts.chart >= 0, mesh.areas() > 1e-12 * scale**2)


def test_doubled_surfaces_stay_two_surfaces():
    ground = rough_ground(12, 0.1)
    mesh = mesh_of(
        np.concatenate([ground.vertices, ground.vertices]),
        np.concatenate([ground.triangles, ground.triangles + len(ground.vertices)]),
    )
    charts = find_charts(mesh)
    check(mesh, charts)
    assert len(charts.size) == 2


def test_triangles_without_area_keep_the_places_of_their_polygon():
    # A pentagon with a corner in the middle of a side, cut so that one of its triangles is a line.
    vertices = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)]
    mesh = mesh_of(vertices, [(0, 1, 2), (0, 2, 3), (0, 3, 4)], np.zeros(3))
    charts = find_charts(mesh)
    assert charts.chart.tolist() == [-1, 0, 0]
    check_polygons(mesh, charts)
    # The middle of the side lies in the middle of its ends.
    assert np.allclose(charts.uv[0, 1], 0.5 * (charts.uv[0, 0] + charts.uv[0, 2]))
    atlas = lay_out([mesh], [8.0], margin=2)
    uv = atlas.layouts[0].uv
    assert np.allclose(uv[0, 1], 0.5 * (uv[1, 0] + uv[1, 1]))
    assert atlas.layouts[0].page.tolist() == [-1, 0, 0]


def test_a_mesh_without_area_has_no_charts():
    charts = find_charts(mesh_of(np.zeros((3, 3)), [(0, 1, 2)]))
    assert charts.chart.tolist() == [-1]
    assert len(charts.size) == 0
    assert len(find_charts(mesh_of(np.zeros((0, 3)), np.zeros((0, 3)))).size) == 0


def test_meshes_that_cannot_be_read_are_refused_in_words():
    with pytest.raises(SceneError, match="vertices which it does not hold"):
        find_charts(mesh_of(np.eye(3), [(0, 1, 3)]))
    with pytest.raises(SceneError, match="not at a finite place"):
        find_charts(mesh_of([(0, 0, np.nan), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]))


def test_the_same_mesh_has_the_same_charts():
    one, other = (find_charts(knot()) for _ in range(2))
    assert np.array_equal(one.uv, other.uv)
    assert np.array_equal(one.chart, other.chart)


def test_a_search_that_takes_too_long_is_stopped_and_replaced():
    mesh = torus(60, 30)
    charts = find_charts(mesh, limits=ChartLimits(seconds=0.01))
    check(mesh, charts, 1.0)
    check_polygons(mesh, charts)
    assert any("took longer than 0.01 s" in note for note in charts.notes)
    plain = find_charts(mesh, limits=NO_SEARCH)
    assert np.array_equal(charts.uv, plain.uv)


def test_too_many_triangles_are_not_asked_about_and_it_is_said():
    charts = find_charts(torus(), limits=ChartLimits(faces=100))
    assert any("1024 triangles are more than" in note for note in charts.notes)


def test_the_search_survives_its_process_and_ends_with_its_user():
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], np.float32)
    good, bad = np.array([[0, 1, 2]], np.uint32), np.array([[0, 1, 7]], np.uint32)
    with ChartSearch() as search:
        failed = search.find(points, bad, np.array([1]), 60.0)
        assert isinstance(failed, Failed)
        assert "ended before" in failed.reason
        found = search.find(points, good, np.array([1]), 60.0)
        assert isinstance(found, Found)
        assert found.chart.tolist() == [0]
        process = search._process
        with pytest.raises(Cancelled):
            search.find(points, good, np.array([1]), 60.0, cancelled=lambda: True)
        assert process.poll() is not None


def squares(*corners, size=1.0):
    """Two triangles for each square with these lower left corners, every vertex for itself."""
    places = np.array([(0, 0), (1, 0), (1, 1), (0, 0), (1, 1), (0, 1)], float) * size
    uv = np.concatenate([places + corner for corner in np.array(corners, float)]).reshape(-1, 3, 2)
    _, vertex = np.unique(uv.reshape(-1, 2).round(9), axis=0, return_inverse=True)
    return uv, vertex.reshape(-1, 3)


def test_overlaps_are_found_and_touching_is_none():
    uv, vertex = squares((0, 0), (1, 0), (1, 1))
    own = np.zeros(len(uv), int)
    assert not find_overlapping(uv, vertex, own, 1).any()
    # The same place twice, once with the corners' own numbers and once with others.
    double, count = np.concatenate([uv, uv[:2]]), np.zeros(len(uv) + 2, int)
    assert find_overlapping(double, np.concatenate([vertex, vertex[:2]]), count, 1).all()
    assert find_overlapping(double, np.concatenate([vertex, vertex[:2] + 99]), count, 1).all()
    # A corner that reaches a little into the neighbour; one that only touches it; a triangle that lies face down.
    for shift, expected in ((-0.02, True), (0.0, False)):
        tip = np.array([[(2.0 + shift, 0.5), (3.0, 0.4), (3.0, 0.6)]])
        found = find_overlapping(
            np.concatenate([uv, tip]),
            np.concatenate([vertex, [[90, 91, 92]]]),
            np.zeros(len(uv) + 1, int),
            1,
        )
        assert found.tolist() == [expected]
    assert find_overlapping(uv[:, ::-1], vertex[:, ::-1], own, 1).all()


def test_a_spiral_that_winds_over_itself_overlaps():
    for turns, expected in ((0.9, False), (1.2, True)):
        flat = sheet(
            40,
            1,
            lambda u, v, t=turns: (
                (1 + v) * np.cos(-2 * np.pi * t * u),
                (1 + v) * np.sin(-2 * np.pi * t * u),
                0 * u,
            ),
        )
        uv = flat.vertices[flat.triangles][:, :, :2]
        found = find_overlapping(uv, flat.triangles.astype(int), np.zeros(len(uv), int), 1)
        assert found.tolist() == [expected]


def test_connected_parts_are_those_of_a_plain_search():
    rng = np.random.default_rng(3)
    ends = rng.integers(0, 300, (220, 2))
    found = find_components(300, ends)
    parent = list(range(300))

    def root(node):
        while parent[node] != node:
            node = parent[node]
        return node

    for a, b in ends:
        parent[root(int(a))] = root(int(b))
    plain = np.array([root(node) for node in range(300)])
    same = found[:, None] == found[None]
    assert np.array_equal(same, plain[:, None] == plain[None])
    # A long chain in bad order takes few rounds, not one per link.
    order = rng.permutation(100_000)
    assert find_components(100_000, np.stack([order[:-1], order[1:]], axis=1)).max() == 0


def test_points_are_welded_by_distance_and_not_by_chains_along_one_axis():
    grid = np.stack(np.meshgrid(*[np.arange(20) * 1.0] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    near = np.concatenate([grid, grid + 1e-7])
    label = weld(near, 1e-6)
    assert np.array_equal(label[: len(grid)], label[len(grid) :])
    assert len(np.unique(label)) == len(grid)
    # Points of a slanted plane, whose heights alone lie closer than the distance.
    slanted = np.stack([np.arange(2000.0), np.arange(2000.0)[::-1], np.arange(2000) * 5e-7], axis=1)
    assert len(np.unique(weld(slanted, 1e-6))) == 2000
