"""UV maps of meshes."""

import numpy as np

from lumenray.engine.scene.mesh import CHART_MAP, find_uv_map

FIRST, SECOND, CHARTS = (np.full((1, 3, 2), value) for value in (0.1, 0.2, 0.3))


def test_a_map_is_found_by_its_name_or_else_the_first_is_taken():
    maps = {"First": FIRST, "Second": SECOND, CHART_MAP: CHARTS}
    assert find_uv_map(maps, "Second") is SECOND
    assert find_uv_map(maps, "") is find_uv_map(maps, "None such") is FIRST


def test_charts_of_pictures_are_found_by_their_name_alone():
    assert find_uv_map({CHART_MAP: CHARTS}, CHART_MAP) is CHARTS
    assert find_uv_map({CHART_MAP: CHARTS}, "") is None
    assert find_uv_map({CHART_MAP: CHARTS, "First": FIRST}, "") is FIRST
