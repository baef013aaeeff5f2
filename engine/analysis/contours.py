"""Lines of equal value of a field that is known at the points of a grid: isolux and iso-luminance lines."""

import math

import numpy as np

STEPS = (1.0, 1.5, 2.0, 3.0, 5.0, 7.5)
"""Round numbers of lines, times powers of ten."""

MOST_LEVELS = 8


def find_contours(x, y, values, levels) -> list[tuple[float, list[np.ndarray]]]:
    """Lines of equal value, straight between the edges of the grid's cells.

    Parameters
    ----------
    x : (columns,) array    Ascending places of the columns.
    y : (rows,) array    Those of the rows.
    values : (rows, columns) array    NaN where nothing is known; no line passes a cell with such a corner.
    levels : iterable of float

    Returns
    -------
    list of (float, list of (n, 2) array)    Level, and paths of x and y; a closed one ends where it begins.

    Notes
    -----
    Along the edges of cells the field is taken as linear, so that the lines of one that is bent are off by at most
    h^2 f'' / (8 f'), h the distance of points: far below h wherever f' is not near 0.
    """
    import contourpy

    values = np.ma.masked_invalid(np.asarray(values, dtype=np.float64))
    if min(values.shape) < 2:
        return [(float(level), []) for level in levels]
    found = contourpy.contour_generator(
        np.asarray(x, dtype=np.float64),
        np.asarray(y, dtype=np.float64),
        values,
        name="serial",
        corner_mask=False,
        line_type=contourpy.LineType.Separate,
    )
    return [(float(level), [np.asarray(path) for path in found.lines(level)]) for level in levels]


def choose_levels(values, most: int = MOST_LEVELS) -> list[float]:
    """Round numbers between the least and the largest value, at most so many, ascending.

    Where the values lie within a factor of 3 they are multiples of a round step, else of the series 1, 1.5, 2, 3, 5, 7.5.
    """
    values = np.asarray(values, dtype=np.float64)
    values = values[np.isfinite(values)]
    if not values.size or values.max() <= values.min():
        return []
    low, high = float(values.min()), float(values.max())
    if low <= 0.0 or high <= 3.0 * low:
        return _multiples(low, high, most)
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    levels = [step * 10.0**power for power in powers for step in STEPS]
    levels = [float(f"{level:.12g}") for level in levels if low < level < high]
    every = math.ceil(len(levels) / most)
    # The largest matter most.
    return levels[::-1][::every][::-1] if every > 1 else levels


def _multiples(low: float, high: float, most: int) -> list[float]:
    """Multiples of a round step between two values."""
    rough = (high - low) / most
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(f * power for f in (1.0, 2.0, 2.5, 5.0, 10.0) if f * power >= rough * (1.0 - 1e-9))
    first, last = math.floor(low / step) + 1, math.ceil(high / step) - 1
    return [float(f"{step * k:.12g}") for k in range(first, last + 1) if low < step * k < high]


def place_label(path: np.ndarray) -> np.ndarray:
    """Place of a line's label: half way along it. (n, 2) -> (2,)"""
    step = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    return np.array([np.interp(0.5 * step[-1], step, path[:, k]) for k in (0, 1)])


def path_length(path: np.ndarray) -> float:
    """Length of a path (n, 2), in its unit."""
    return float(np.hypot(*np.diff(path, axis=0).T).sum())
