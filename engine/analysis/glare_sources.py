"""Sources of glare in a luminance picture: which bright pixels belong together."""

from dataclasses import dataclass

import numpy as np

from .picture_view import PictureView

THRESHOLD = 2000.0
"""Luminance above which a pixel is part of a source. [cd/m2] (Pierson, Wienold and Bodart, Buildings 8, 2018, 94)"""

PEAK = 50_000.0
"""Luminance from which on pixels of a source are sources of their own, as the sun in a bright window. [cd/m2]"""

REACH = 0.1
"""Angle between pixels up to which they belong together. [rad]"""


@dataclass(frozen=True, eq=False)
class GlareSources:
    """Sources in a picture.

    Parameters
    ----------
    luminances : (n,) float64 array    Mean over the solid angle. [cd/m2]
    solid_angles : (n,) float64 array    [sr]
    illuminances : (n,) float64 array    At the eye, on the plane across the line of sight. [lx]
    directions : (n, 3) float64 array
        Of the centres, in the picture's axes: means of places on the picture, weighed by luminance and solid angle.
    """

    luminances: np.ndarray
    solid_angles: np.ndarray
    illuminances: np.ndarray
    directions: np.ndarray


def find_sources(
    luminance: np.ndarray,
    view: PictureView,
    directions: np.ndarray,
    solid_angles: np.ndarray,
    threshold: float = THRESHOLD,
    undimmed: np.ndarray | None = None,
) -> GlareSources:
    """Find the sources of glare in a picture.

    Parameters
    ----------
    luminance : (h, w) array    Row 0 is the bottom row. [cd/m2]
    view : PictureView
    directions, solid_angles : array    Of `PictureView.pixels`; pixels of 0 sr do not count.
    threshold : float    [cd/m2]
    undimmed : (c, h, w) array or None
        What the picture would show were no lamp dimmed, in parts that are dimmed alike: which pixels are sources is told by
        their sum, and those in which different parts prevail belong to different ones. None: as the picture. [cd/m2]

    Returns
    -------
    GlareSources    In order of what they give to the illuminance.
    """
    parts = luminance[None] if undimmed is None else undimmed
    full = parts.sum(axis=0, dtype=np.float64)
    rows, columns = np.nonzero((full > threshold) & (solid_angles > 0.0))
    bright = luminance[rows, columns].astype(np.float64)
    full, part = full[rows, columns], parts[:, rows, columns].argmax(axis=0)
    towards, solid = directions[rows, columns], solid_angles[rows, columns]
    labels = np.zeros(len(rows), dtype=np.int64)
    for number in np.unique(part):
        # A dimmed lamp beside a window would else dilute it.
        members = np.flatnonzero(part == number)
        labels[members] = labels.max() + 1 + link(towards[members], REACH)
    is_peak = full >= PEAK
    if is_peak.any() and _is_fine(view):
        # Peaks are linked within their own source alone.
        for source in np.unique(labels[is_peak]):
            members = np.flatnonzero(is_peak & (labels == source))
            labels[members] = labels.max() + 1 + link(towards[members], REACH)
    _, labels = np.unique(labels, return_inverse=True)
    total = np.bincount(labels, solid)
    power = np.bincount(labels, solid * bright)
    weight = solid * full
    x, y = (
        np.bincount(labels, weight * (each + 0.5)) / np.bincount(labels, weight)
        for each in (columns, rows)
    )
    received = np.bincount(labels, -solid * bright * towards[:, 2])
    centres, _ = view.directions(x, y)
    order = np.argsort(-received, kind="stable")
    found = power / np.where(total > 0.0, total, 1.0), total, received, centres
    return GlareSources(*(each[order] for each in found))


def _is_fine(view: PictureView) -> bool:
    """Whether pixels are small against the reach."""
    around, _ = view.directions(
        0.5 * view.width + np.array([0.0, 1.0]), 0.5 * view.height + np.array([0.0, 1.0])
    )
    return float(np.arccos(np.clip(around[0] @ around[1], -1.0, 1.0))) < REACH


def link(towards: np.ndarray, reach: float) -> np.ndarray:
    """Number directions so that those have the same number which a chain of steps up to ``reach`` joins.

    Parameters
    ----------
    towards : (n, 3) array    Of unit length.
    reach : float    [rad]

    Returns
    -------
    (n,) int64 array    From 0 on.
    """
    if not len(towards):
        return np.zeros(0, dtype=np.int64)
    chord = 2.0 * np.sin(0.5 * reach)
    # All directions in a cell are within reach of each other.
    size = chord / np.sqrt(3.0)
    keys = np.floor(towards / size).astype(np.int64)
    cells, cell = np.unique(keys, axis=0, return_inverse=True)
    cell = cell.reshape(-1)
    order = np.argsort(cell, kind="stable")
    starts = np.searchsorted(cell[order], np.arange(len(cells) + 1))
    members = [towards[order[a:b]] for a, b in zip(starts, starts[1:], strict=False)]
    number = {tuple(key): k for k, key in enumerate(cells.tolist())}
    parent = np.arange(len(cells))

    def root(k):
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    least = np.cos(reach)
    span = range(-2, 3)
    steps = sorted(
        ((i, j, k) for i in span for j in span for k in span if (i, j, k) > (0, 0, 0)),
        key=lambda step: sum(each * each for each in step),
    )
    for step in steps:
        for k, key in enumerate(cells.tolist()):
            other = number.get(tuple(a + b for a, b in zip(key, step, strict=True)))
            if other is None or root(k) == root(other):
                continue
            if (members[k] @ members[other].T).max() >= least:
                parent[root(other)] = root(k)
    roots = np.array([root(k) for k in range(len(cells))])
    _, labels = np.unique(roots, return_inverse=True)
    return labels[cell].astype(np.int64)
