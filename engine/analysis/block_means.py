"""Mean luminance of blocks of a picture, kept by what a filter of noise made of it.

A network need not keep means, as it works on tone-mapped light. The filtered picture is multiplied by a factor that changes
smoothly over the picture: it is found at the middles of the blocks, linear between, such that every block has its mean.
Where no such factor is, beside blocks that the filter made nearly black, the rest is one factor for a whole block.
"""

import numpy as np

from ..photometry.colour import REC709_LUMINANCE

BLOCK = 32
"""Side of a block; the last ones may be smaller. [pixel]"""

CLOSE = 1e-3
"""Means that agree to this are left. [-]"""

ROUNDS = 100
"""Corrections at most; some ten are enough for pictures."""


def block_means(values: np.ndarray) -> np.ndarray:
    """Means of blocks. (h, w) -> (ceil(h / 32), ceil(w / 32))"""
    rows, columns = (np.arange(0, size, BLOCK) for size in values.shape)
    sums = np.add.reduceat(np.add.reduceat(values.astype(np.float64), rows, 0), columns, 1)
    height, width = (
        np.diff([*first, size]) for first, size in zip((rows, columns), values.shape, strict=True)
    )
    return sums / (height[:, None] * width)


def keep_means(filtered: np.ndarray, raw: np.ndarray) -> np.ndarray:
    """Return a filtered picture whose blocks have the mean luminance of the raw one's.

    Parameters
    ----------
    filtered, raw : (h, w, 3) array    Linear Rec. 709.

    Returns
    -------
    (h, w, 3) float32 array    Blocks that the filter made black stay so.
    """
    wanted = np.maximum(block_means(raw @ REC709_LUMINANCE), 0.0)
    luminance = filtered @ REC709_LUMINANCE
    places = [_places(size) for size in luminance.shape]
    ratio = np.ones_like(wanted)
    for _ in range(ROUNDS):
        factor = _between(ratio, places)
        made = block_means(luminance * factor)
        change = np.divide(wanted, made, out=np.ones_like(made), where=made > 0.0)
        if np.abs(change - 1.0).max() < CLOSE:
            break
        ratio *= change
    rest = change.repeat(BLOCK, axis=0).repeat(BLOCK, axis=1)
    factor *= rest[: len(factor), : factor.shape[1]]
    return (filtered * factor[..., None]).astype(np.float32)


def _places(size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Blocks before and behind each pixel of a row, and how far it is from the first to the second."""
    edges = np.minimum(np.arange(0, size + BLOCK, BLOCK), size)
    middles = 0.5 * (edges[:-1] + edges[1:])
    place = np.interp(np.arange(size) + 0.5, middles, np.arange(len(middles)))
    before = np.minimum(place.astype(int), max(len(middles) - 2, 0))
    return before, np.minimum(before + 1, len(middles) - 1), place - before


def _between(values: np.ndarray, places: list) -> np.ndarray:
    """Values at the middles of blocks, linear between."""
    (low, high, share), (left, right, part) = places
    rows = values[low] * (1.0 - share)[:, None] + values[high] * share[:, None]
    return rows[:, left] * (1.0 - part) + rows[:, right] * part
