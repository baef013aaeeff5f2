"""Areas of luminous openings."""

import numpy as np
import pytest

from lumenray.engine.luminaires.openings import projected_area
from lumenray.engine.scene.distribution import Opening


def surface(opening):
    """Points all over an opening, (n, 3). [m]"""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 721), np.linspace(-90, 90, 181), indexing="ij")
    u, v = u.ravel(), np.sin(np.deg2rad(v)).ravel()
    axis = "xyz".index(opening.axis)
    others = [i for i in range(3) if i != axis]
    points = np.zeros((len(u), 3))
    if opening.shape in {"box", "rectangle"}:
        points = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    elif opening.shape == "ellipsoid":
        ring = np.sqrt(1.0 - v**2)
        points = np.stack([ring * np.cos(u), ring * np.sin(u), v], axis=1)
    else:
        points[:, others[0]], points[:, others[1]], points[:, axis] = (
            np.cos(u),
            np.sin(u),
            np.sign(v),
        )
    return 0.5 * points * opening.size


@pytest.mark.parametrize(
    "opening",
    [
        Opening("rectangle", (1.2, 0.3, 0.0)),
        Opening("rectangle", (0.0, 0.3, 0.7), "x"),
        Opening("ellipse", (0.4, 0.0, 0.9), "y"),
        Opening("box", (1.2, 0.3, 0.1)),
        Opening("ellipsoid", (0.2, 0.5, 0.9)),
        Opening("cylinder", (0.3, 0.5, 0.8)),
        Opening("cylinder", (1.2, 0.04, 0.1), "x"),
        Opening("cylinder", (0.04, 1.2, 0.1), "y"),
    ],
    ids=lambda o: f"{o.shape}-{o.axis}",
)
def test_projected_areas_are_those_of_the_shadow(opening):
    spatial = pytest.importorskip("scipy.spatial")
    towards = np.array([[0.3, -0.5, -0.8], [-0.9, 0.1, 0.2], [0.02, 0.7, -0.1], [2.0, 3.0, 4.0]])
    for direction in towards:
        n = direction / np.linalg.norm(direction)
        right = np.cross(n, [0.6, 0.8, 0.0])
        right /= np.linalg.norm(right)
        shadow = surface(opening) @ np.stack([right, np.cross(n, right)], axis=1)
        area = spatial.ConvexHull(shadow).volume
        assert projected_area(opening, direction) == pytest.approx(area, rel=2e-4)
    assert projected_area(opening, towards).shape == (4,)


def test_a_point_has_no_area():
    assert projected_area(Opening(), np.ones((2, 5, 3))).tolist() == np.zeros((2, 5)).tolist()
