"""Charts of meshes: true to scale, in the cone, whole polygons, nothing upon each other."""

import numpy as np
import pytest
from chart_meshes import (
    NO_SEARCH,
    check,
    check_polygons,
    knot,
    mesh_of,
    rough_ground,
    sheet,
    signed_areas,
    torus,
)
from small_scenes import box

from lumenray.engine.atlas.charts import ChartLimits, find_charts


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


def test_a_box_has_six_charts_of_its_exact_sides():
    charts = find_charts(box(4.0, 3.0, 2.5))
    check(box(4.0, 3.0, 2.5), charts)
    sides = sorted(tuple(side) for side in charts.size.round(12).tolist())
    assert sides == [(3.0, 2.5)] * 2 + [(4.0, 2.5)] * 2 + [(4.0, 3.0)] * 2
    assert charts.notes == ()


@pytest.mark.one_at_a_time
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


def test_the_same_mesh_has_the_same_charts():
    one, other = (find_charts(knot()) for _ in range(2))
    assert np.array_equal(one.uv, other.uv)
    assert np.array_equal(one.chart, other.chart)
