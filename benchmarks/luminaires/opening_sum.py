"""Illuminance from a luminous opening as a plain sum over many small parts of it: an arbiter between two programs.

A part of the opening sends the luminance I(direction) / projected area(direction), as the engine's own definition says;
nothing of the engine's sampling is used. Double precision, midpoints of even parts.
"""

import numpy as np

from ...engine.luminaires.distribution import intensity
from ...engine.luminaires.formats.record import LuminaireFile

FINENESS = 160
"""Parts along each of the two parameters of a face."""

ORDER = {"x": (1, 2, 0), "y": (2, 0, 1), "z": (0, 1, 2)}
"""The luminaire's axes as the opening's, whose last is the normal or the cylinder's axis."""


def sum_over_opening(file: LuminaireFile, rotation, place, positions, normals) -> np.ndarray:
    """Illuminance of planes by the opening of a file, in empty space.

    Parameters
    ----------
    rotation : (3, 3) array    Turns the luminaire's axes into the world's.
    place : (3,) array    Of the luminaire. [m]
    positions, normals : (n, 3) array    [m]

    Returns
    -------
    (n,) float64 array    [lx]
    """
    order = list(ORDER[file.opening.axis])
    axes = rotation[:, order]
    half = 0.5 * np.asarray(file.opening.size)[order]
    faces = _faces(file.opening.shape, half)
    made = np.zeros(len(positions))
    for i, (position, normal) in enumerate(zip(positions, normals, strict=True)):
        local = (position - place) @ axes
        # Flat faces that are turned away need no sum.
        seen = [face for face in faces if np.any((face[1] * (local - face[0])).sum(axis=1) > 0.0)]
        if not seen:
            continue
        points, areas = (np.concatenate([face[k] for face in seen]) for k in range(2))
        away = local - points
        distance = np.linalg.norm(away, axis=1)
        direction = away / distance[:, None]
        seen = (areas * direction).sum(axis=1)
        cosine = -direction @ (axes.T @ normal)
        lit = (seen > 0.0) & (cosine > 0.0)
        outwards = np.zeros_like(direction)
        outwards[:, order] = direction
        luminance = intensity(file.distribution, outwards[lit]) / _projected_area(
            file.opening.shape, half, direction[lit]
        )
        made[i] = np.sum(luminance * seen[lit] * cosine[lit] / distance[lit] ** 2)
    return made


def _projected_area(shape: str, half, direction) -> np.ndarray:
    """Area that the opening shows towards directions (n, 3) in its axes. [m2]"""
    (a, b, c), (x, y, z) = half, np.abs(direction).T
    return {
        "rectangle": lambda: 4.0 * a * b * z,
        "ellipse": lambda: np.pi * a * b * z,
        "box": lambda: 4.0 * (b * c * x + a * c * y + a * b * z),
        "ellipsoid": lambda: (
            np.pi * np.sqrt((b * c * x) ** 2 + (a * c * y) ** 2 + (a * b * z) ** 2)
        ),
        "cylinder": lambda: np.pi * a * b * z + 4.0 * c * np.sqrt((a * y) ** 2 + (b * x) ** 2),
    }[shape]()


def _faces(shape: str, half) -> list[tuple[np.ndarray, np.ndarray]]:
    """Parts of each face: middles (n, 3) [m] and areas along their outward normals (n, 3) [m2]."""
    return {
        "rectangle": lambda: [_rectangle(half, 2, side) for side in (-1.0, 1.0)],
        "ellipse": lambda: [_disk(half, 0.0, side) for side in (-1.0, 1.0)],
        "box": lambda: [_rectangle(half, axis, side) for axis in range(3) for side in (-1.0, 1.0)],
        "ellipsoid": lambda: [_ellipsoid(half)],
        "cylinder": lambda: [
            _wall(half), *(_disk(half, side * half[2], side) for side in (-1.0, 1.0))
        ],
    }[shape]()  # fmt: skip


def _parameters() -> tuple[np.ndarray, np.ndarray, float]:
    """Two parameters within 0..1 at the middles of parts, and the share of one part."""
    even = (np.arange(FINENESS) + 0.5) / FINENESS
    u, v = np.meshgrid(even, even)
    return u.ravel(), v.ravel(), 1.0 / FINENESS**2


def _rectangle(half, axis: int, side: float):
    u, v, share = _parameters()
    first, second = ((axis + 1) % 3, (axis + 2) % 3)
    points, areas = np.zeros((2, len(u), 3))
    points[:, first], points[:, second] = half[first] * (2 * u - 1), half[second] * (2 * v - 1)
    points[:, axis] = side * half[axis]
    areas[:, axis] = side * 4.0 * half[first] * half[second] * share
    return points, areas


def _disk(half, height: float, side: float):
    u, v, share = _parameters()
    radius, angle = np.sqrt(u), 2.0 * np.pi * v
    points, areas = np.zeros((2, len(u), 3))
    points[:, 0] = half[0] * radius * np.cos(angle)
    points[:, 1] = half[1] * radius * np.sin(angle)
    points[:, 2] = height
    areas[:, 2] = side * np.pi * half[0] * half[1] * share
    return points, areas


def _wall(half):
    u, v, share = _parameters()
    c, s = np.cos(2.0 * np.pi * u), np.sin(2.0 * np.pi * u)
    points = np.stack([half[0] * c, half[1] * s, half[2] * (2.0 * v - 1.0)], axis=1)
    areas = np.stack([half[1] * c, half[0] * s, np.zeros_like(u)], axis=1)
    return points, areas * (4.0 * np.pi * half[2] * share)


def _ellipsoid(half):
    u, v, share = _parameters()
    z, angle = 2.0 * u - 1.0, 2.0 * np.pi * v
    flat = np.sqrt(1.0 - z**2)
    unit = np.stack([flat * np.cos(angle), flat * np.sin(angle), z], axis=1)
    return unit * half, unit / half * (np.prod(half) * 4.0 * np.pi * share)
