"""The search for charts: stopped, replaced, missing, and in a process of its own."""

import numpy as np
import pytest
from chart_meshes import NO_SEARCH, check, check_polygons, torus

from lumenray.engine.atlas.chart_search import ChartSearch, Failed, Found
from lumenray.engine.atlas.charts import ChartLimits, find_charts
from lumenray.engine.errors import Cancelled


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


def test_without_xatlas_surfaces_are_cut_by_their_normals_and_it_is_said(monkeypatch):
    """As with Pythons that xatlas was not made for."""
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    charts = find_charts(torus())
    assert any("1024 triangles were cut by their normals" in note for note in charts.notes)
    assert (charts.chart >= 0).all()


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
