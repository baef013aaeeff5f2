"""Photometric coordinate systems as polar grids: all three types are one grid about different polar axes.

The luminaire's own axes are x, y, z; it shines along -z, and +y is up when it is aimed at a wall. With beam f = -z,
up u = +y and right r = +x (IES LM-75, CIE 121):

- type C: d = (sin V cos H, sin V sin H, -cos V); polar axis -z.
- type A: d = cos V cos H f + cos V sin H r + sin V u; polar axis vertical, gamma = 90 deg + V, C = H.
- type B: d = cos H cos V f + sin H r + cos H sin V u; polar axis horizontal, gamma = 90 deg + H, C = V.
"""

import numpy as np

_F, _U, _R = np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])

FRAMES = {
    "C": np.eye(3),
    "A": np.stack([_F, _R, _U], axis=1),
    "B": np.stack([_F, _U, _R], axis=1),
}
"""Axes of the grid of each photometric type, as columns, in the luminaire's axes."""


def directions(azimuth, polar, frame=None) -> np.ndarray:
    """Directions of grid angles [rad], in the luminaire's axes. (..., 3)"""
    azimuth, polar = np.broadcast_arrays(
        np.asarray(azimuth, dtype=np.float64), np.asarray(polar, dtype=np.float64)
    )
    sine = np.sin(polar)
    grid = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), -np.cos(polar)], axis=-1)
    return grid if frame is None else grid @ np.asarray(frame).T


def angles(direction, frame=None) -> tuple[np.ndarray, np.ndarray]:
    """Azimuth in 0..2 pi and polar angle of directions (..., 3), which need not be of unit length. [rad]"""
    d = np.asarray(direction, dtype=np.float64)
    if frame is not None:
        d = d @ np.asarray(frame)
    azimuth = np.mod(np.arctan2(d[..., 1], d[..., 0]), 2.0 * np.pi)
    return azimuth, np.arctan2(np.hypot(d[..., 0], d[..., 1]), -d[..., 2])
