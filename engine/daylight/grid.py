"""Sensors in an even grid above floors."""

import numpy as np

from ..errors import SceneError
from ..scene.mesh import Mesh

MOST_SENSORS = 200_000
"""More are refused: a typing error of the spacing must not take hours."""

LEVEL = 0.95
"""Least upward part of the normal of a floor's triangle. [-]"""


def lay_grid(floors: list[Mesh], spacing: float, height: float, margin: float = 0.0) -> np.ndarray:
    """Return sensors that look upwards, in the middles of the squares of a grid over floors.

    Parameters
    ----------
    floors : list of Mesh
    spacing : float    Side of a square, each of which its sensor stands for. [m]
    height : float    Above the floor. [m]
    margin : float    From the sides of the box around each floor. [m]

    Returns
    -------
    (n, 3) float64 array    Positions, row by row. [m]

    Raises
    ------
    SceneError    Nothing of a floor is level, no square's middle lies on it, or there are too many.
    """
    made = []
    for floor in floors:
        corners = floor.vertices[floor.triangles].astype(np.float64)
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(cross, axis=1)
        level = (length > 0.0) & (np.abs(cross[:, 2]) >= LEVEL * length)
        if not level.any():
            raise SceneError(
                f"nothing of '{floor.name}' is level, so that it is no floor for sensors"
            )
        corners = corners[level]
        low = corners[..., :2].min(axis=(0, 1)) + margin
        high = corners[..., :2].max(axis=(0, 1)) - margin
        counts = np.maximum(np.floor((high - low) / spacing + 1e-6), 0.0)
        if counts.prod() > MOST_SENSORS:
            raise SceneError(
                f"a grid of {spacing:g} m on '{floor.name}' has {counts.prod():.0f} sensors, at most {MOST_SENSORS} are made"
            )
        # Centred: what is left over is shared by both sides.
        start = 0.5 * (low + high - counts * spacing)
        x, y = (s + spacing * (np.arange(int(n)) + 0.5) for s, n in zip(start, counts, strict=True))
        places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        heights = _heights(places, corners)
        is_on = np.isfinite(heights)
        made.append(np.column_stack([places[is_on], heights[is_on] + height]))
        if not is_on.any():
            raise SceneError(
                f"no sensor of a grid of {spacing:g} m lies on '{floor.name}'; take a smaller one"
            )
    return np.concatenate(made) if made else np.zeros((0, 3))


def _heights(places: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Height of the uppermost triangle at places, NaN beside all. (n, 2), (t, 3, 3) -> (n,)"""
    made = np.full(len(places), -np.inf)
    for a, b, c in corners:
        u, v = b[:2] - a[:2], c[:2] - a[:2]
        area = u[0] * v[1] - u[1] * v[0]
        away = places - a[:2]
        s = (away[:, 0] * v[1] - away[:, 1] * v[0]) / area
        t = (u[0] * away[:, 1] - u[1] * away[:, 0]) / area
        inside = (s >= -1e-9) & (t >= -1e-9) & (s + t <= 1.0 + 1e-9)
        height = a[2] + s * (b[2] - a[2]) + t * (c[2] - a[2])
        made = np.where(inside, np.maximum(made, height), made)
    return np.where(np.isfinite(made), made, np.nan)
