"""Means of neighbouring pixels, of which lines of equal value are drawn: as wide as the noise of the pixels asks for."""

import math

import numpy as np

LINE_NOISE = 0.02
"""Relative standard error of means whose lines do not show it: series of levels have steps of 30 % or more. [-]"""

MOST_PASSES = 50
"""Of smoothing: means over about 17 pixels, whose error is a 18th of that of pixels."""

SHARE = 0.9
"""Share of pixels whose noise is to be as low."""


def smooth(field: np.ndarray) -> np.ndarray:
    """Means of neighbours with the weights 1, 2, 1 along both axes, NaN left out and kept. (h, w)"""
    known = np.isfinite(field)
    total, weight = np.where(known, field, 0.0), known.astype(np.float64)
    for axis in (0, 1):
        total, weight = (_spread(each, axis) for each in (total, weight))
    return np.where(known, total / np.where(weight > 0.0, weight, 1.0), np.nan)


def _spread(values: np.ndarray, axis: int) -> np.ndarray:
    padded = np.pad(values, [(1, 1) if k == axis else (0, 0) for k in (0, 1)])
    size = values.shape[axis]
    parts = [np.take(padded, np.arange(size) + k, axis) for k in range(3)]
    return parts[0] + 2.0 * parts[1] + parts[2]


def noise_left(passes: int) -> float:
    """Standard error of what was smoothed so often over that of pixels with independent noise. [-]

    The weights along an axis are those of the binomial distribution of 2 n; their squares sum to C(4 n, 2 n) / 16^n, and a
    picture has two axes.
    """
    return math.comb(4 * passes, 2 * passes) / 16**passes


def mean_width(passes: int) -> float:
    """Side of the square whose plain mean spreads a pixel as far: sqrt(6 n + 1), as a pass has the variance 1/2. [pixel]"""
    return math.sqrt(6.0 * passes + 1.0)


def relative_noise(values, error) -> float:
    """Relative error that most pixels do not exceed, darker ones than the mean over the mean; NaN left out. [-]"""
    values, error = (np.asarray(each, dtype=np.float64).ravel() for each in (values, error))
    known = np.isfinite(values) & np.isfinite(error)
    values, error = values[known], error[known]
    scale = np.maximum(np.abs(values), abs(values.mean())) if values.size else values
    if not (scale > 0.0).any():
        return 0.0
    return float(np.quantile(error[scale > 0.0] / scale[scale > 0.0], SHARE))


def scatter_of_neighbours(field: np.ndarray) -> float:
    """Relative noise of most pixels by how they differ from the mean of the four beside them; NaN and 0 left out. [-]

    It is that of independent pixels, and what the picture holds of edges hardly counts, as these are few.
    """
    beside = field[:-2, 1:-1] + field[2:, 1:-1] + field[1:-1, :-2] + field[1:-1, 2:]
    middle = field[1:-1, 1:-1]
    known = np.isfinite(beside) & (middle > 0.0)
    if not known.any():
        return 0.0
    apart = np.abs(middle - 0.25 * beside)[known] / np.maximum(middle, np.nanmean(middle))[known]
    # The median of the size is 0.6745 of the standard deviation; the mean of four adds a quarter to the variance.
    return float(np.median(apart)) / (0.6745 * math.sqrt(1.25))


def choose_passes(noise: float, least: int, side: int) -> int:
    """How often to smooth, so that lines do not show the noise, if that can be had.

    Parameters
    ----------
    noise : float    Of pixels, see `relative_noise`. [-]
    least : int    Passes in any case.
    side : int    Shorter one of the picture; means are at most an eighth as wide. [pixel]
    """
    passes, most = least, MOST_PASSES
    while passes < most and noise * noise_left(passes) > LINE_NOISE:
        if mean_width(passes + 1) > side / 8.0:
            break
        passes += 1
    return passes


def sample_points(field: np.ndarray, columns: float, rows: float) -> np.ndarray:
    """Middles of pixels at an even grid of about so many points, and the values there. (n, 3)"""
    height, width = field.shape
    columns, rows = max(int(columns), 1), max(int(rows), 1)
    row = ((np.arange(rows) + 0.5) * height / rows).astype(int)
    column = ((np.arange(columns) + 0.5) * width / columns).astype(int)
    row, column = (each.ravel() for each in np.meshgrid(row, column, indexing="ij"))
    made = np.stack([column + 0.5, row + 0.5, field[row, column]], axis=1)
    return made[np.isfinite(made[:, 2])]


def average(field: np.ndarray, step: int) -> np.ndarray:
    """Means of squares of so many pixels; those at the upper and right edges may be smaller."""
    if step == 1:
        return field
    rows, columns = (np.arange(0, side, step) for side in field.shape)
    sums = np.add.reduceat(np.add.reduceat(field, rows, 0), columns, 1)
    counts = [
        np.diff([*first, side]) for first, side in zip((rows, columns), field.shape, strict=True)
    ]
    return sums / (counts[0][:, None] * counts[1])


SLOPE_PASSES = 16
"""Of smoothing, on pixels of the means' width, before slopes are found: those of noise are a ninth of what it was."""

CERTAIN = 3.0
"""Standard error of a line's place up to which it is drawn, over the width of the means that it is of. [-]"""


def keep_certain(paths, field: np.ndarray, passes: int, noise: float) -> list[np.ndarray]:
    """Return the parts of paths (n, 2) whose places the noise leaves known: where the field is even, it alone makes lines.

    The error of a place is that of the value over the field's slope, which is found on means of about three times the width.

    Parameters
    ----------
    field : (h, w) array    That the paths are of, smoothed by so many passes; its pixels have their middles at 0.5, 1.5, ...
    noise : float    Relative error that is left. [-]
    """
    if noise <= 0.0:
        return list(paths)
    width = math.sqrt(0.5 * max(passes, 1))
    step = max(round(width), 1)
    coarse = average(field, step)
    if min(coarse.shape) < 2:
        return list(paths)
    for _ in range(SLOPE_PASSES):
        coarse = smooth(coarse)
    slope = np.hypot(*np.gradient(coarse, step))
    with np.errstate(divide="ignore", invalid="ignore"):
        doubt = noise * np.abs(coarse) / slope
    kept = []
    for path in paths:
        column, row = (path / step).astype(int).T
        row, column = (
            np.clip(e, 0, n - 1) for e, n in zip((row, column), doubt.shape, strict=True)
        )
        is_known = doubt[row, column] <= CERTAIN * width
        ends = np.flatnonzero(np.diff(is_known)) + 1
        parts = zip(np.split(path, ends), np.split(is_known, ends), strict=True)
        kept += [part for part, known in parts if known[0] and len(part) > 1]
    return kept
