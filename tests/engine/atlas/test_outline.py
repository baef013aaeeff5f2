"""Outlines of charts that lie upon each other."""

import numpy as np
from chart_meshes import sheet

from lumenray.engine.atlas.outline import find_overlapping


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
