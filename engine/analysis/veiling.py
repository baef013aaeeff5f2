"""Light that an eye scatters within itself, which veils what it looks at, and what parts of a picture adapt it to."""

import functools
from dataclasses import replace

import numpy as np

from .picture_view import PictureView

AGE, PIGMENT = 30.0, 0.5
"""Of the observer [year], and how much the iris lets pass: 0 black, 0.5 brown, 1 light blue."""

FOVEA = np.deg2rad(1.0)
"""Width of what an eye adapts to at a time. [rad]"""

MOST_CELLS = 2048
"""Parts of a picture at most; of wide views they are larger than the fovea."""

NARROWEST, WIDEST = 0.1, 100.0
"""Angles to the line of sight for which the veil is known; beyond, that of the nearest one is taken. [degree]"""


def veil_of_glare(angle, age: float = AGE, pigment: float = PIGMENT) -> np.ndarray:
    """Return veiling luminance over the illuminance at the eye of a source at an angle. (CIE 146:2002, general equation)

    Parameters
    ----------
    angle : array    Between source and line of sight. [rad]
    age : float    [year]
    pigment : float    Of the eye: 0 black, 0.5 brown, 1 light blue.

    Returns
    -------
    array    [1/sr]
    """
    t = np.clip(np.rad2deg(np.asarray(angle, dtype=np.float64)), NARROWEST, WIDEST)
    old = 1.0 + (age / 62.5) ** 4
    return 10.0 / t**3 + (5.0 / t**2 + 0.1 * pigment / t) * old + 0.0025 * pigment


class Eye:
    """An eye that looks at every part of a picture in turn.

    Parameters
    ----------
    view : PictureView or None    How the picture was taken; None: from no place that an eye could have.
    shape : (int, int)    Rows and columns of the picture.
    """

    def __init__(self, view: PictureView | None, shape: tuple[int, int]):
        rows, columns = shape
        ratio = columns / rows
        count = MOST_CELLS
        if view is not None:
            coarse = replace(view, width=16, height=16)
            count = min(count, coarse.pixels()[1].sum() / (0.25 * np.pi * FOVEA**2))
        self.rows = int(np.clip(round(np.sqrt(count / ratio)), 1, rows))
        self.columns = int(np.clip(round(np.sqrt(count * ratio)), 1, columns))
        self._edges = [
            np.linspace(0, whole, parts + 1).round().astype(int)
            for whole, parts in ((rows, self.rows), (columns, self.columns))
        ]
        self.has_veil = view is not None
        if view is not None:
            self._scatter, self._kept = _scatter(
                replace(view, width=self.columns, height=self.rows)
            )

    def means(self, values: np.ndarray) -> np.ndarray:
        """Means of a picture (h, w, c) over its parts. (rows, columns, c)"""
        total = np.asarray(values, dtype=np.float64)
        for axis, edges in enumerate(self._edges):
            total = np.add.reduceat(total, edges[:-1], axis=axis)
        counts = [np.diff(edges) for edges in self._edges]
        return total / (counts[0][:, None] * counts[1])[..., None]

    def veil(self, means: np.ndarray) -> np.ndarray:
        """What the eye adds to each part that it looks at, by light of the others. (rows, columns, c)"""
        if not self.has_veil:
            return np.zeros_like(means)
        flat = means.reshape(-1, means.shape[-1]).astype(np.float32)
        return (self._scatter @ flat).reshape(means.shape).astype(np.float64)

    @property
    def kept(self) -> np.ndarray | float:
        """Share of the light of a part that arrives where it belongs. (rows, columns, 1) [-]"""
        return self._kept.reshape(self.rows, self.columns, 1) if self.has_veil else 1.0

    def spread(self, parts: np.ndarray) -> np.ndarray:
        """Values of parts (rows, columns, c) at all pixels, evenly between the parts' middles. (h, w, c)"""
        made = np.asarray(parts, dtype=np.float32)
        for axis, edges in enumerate(self._edges):
            middles = 0.5 * (edges[:-1] + edges[1:])
            place = np.interp(np.arange(edges[-1]) + 0.5, middles, np.arange(len(middles)))
            low = np.minimum(place.astype(int), max(len(middles) - 2, 0))
            high = np.minimum(low + 1, len(middles) - 1)
            share = np.expand_dims((place - low).astype(np.float32), tuple({0, 1, 2} - {axis}))
            made = np.take(made, low, axis) * (1.0 - share) + np.take(made, high, axis) * share
        return made


@functools.lru_cache(maxsize=2)
def _scatter(parts: PictureView) -> tuple[np.ndarray, np.ndarray]:
    """What of the luminance of every part veils every other one (n, n), and the shares that are not scattered (n,). [-]

    The share is that of an even field, so that one stays as bright as it is.
    """
    ways, solid = (each.reshape(-1, *each.shape[2:]) for each in parts.pixels())
    cosine = np.clip(ways @ ways.T, 0.0, 1.0).astype(np.float32)
    radius = np.sqrt(np.maximum(solid, 1e-12) / np.pi)
    angle = np.maximum(np.arccos(cosine), radius.astype(np.float32))
    made = (veil_of_glare(angle) * cosine * solid).astype(np.float32)
    np.fill_diagonal(made, 0.0)
    # Nobody looks at what the picture does not show.
    made[solid <= 0.0] = 0.0
    inner = np.linspace(0.0, 1.0, 4001)[1:]
    known = np.deg2rad(NARROWEST) * (0.5 * np.pi / np.deg2rad(NARROWEST)) ** inner
    density = veil_of_glare(known) * np.cos(known) * np.sin(known) * 2.0 * np.pi * known
    steps = np.log(known[1] / known[0]) * density
    beyond = np.cumsum(steps[::-1])[::-1]
    return made, 1.0 - np.interp(radius, known, beyond)
