"""Charts of faulty meshes: the rules hold, or the fault is told."""

import numpy as np
import pytest
from chart_meshes import check, check_polygons, mesh_of, rough_ground
from layouts import lay_out

from lumenray.engine.atlas.charts import find_charts
from lumenray.engine.errors import SceneError

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
