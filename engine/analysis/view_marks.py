"""Lines of equal value with labels, and values at points, of what a live view shows in false colours."""

from dataclasses import dataclass

import numpy as np

from .contours import choose_levels, find_contours, path_length, place_label
from .line_smoothing import (
    average,
    choose_passes,
    keep_certain,
    mean_width,
    noise_left,
    sample_points,
    scatter_of_neighbours,
    smooth,
)

LARGEST = 480
"""Longer side of what lines are found on: a view is averaged over whole pixels to it, which takes noise off as well."""

LEAST_PASSES = 2

LOWEST = 1e-3
"""Least level over the largest value."""

ACROSS, UP = 110.0, 70.0
"""Distances of the points whose values are told. [pixel of the view]"""

SHORTEST, LABELLED = 0.02, 0.08
"""Lengths from which a line is drawn and has a label, over the view's width. [-]"""


@dataclass(frozen=True, eq=False)
class ViewMarks:
    """Lines and values of a view; places are shares of its width and height, from the lower left corner.

    Parameters
    ----------
    lines : (m, 2, 2) float32 array    Both ends of straight pieces.
    labels : (k, 3) float32 array    Places of the lines' labels, and their levels, in the unit of the view.
    values : (n, 3) float32 array    Places and values.
    words : str    What they are of, for people.
    """

    lines: np.ndarray
    labels: np.ndarray
    values: np.ndarray
    words: str


def find_marks(
    field, noise: float, size: tuple[int, int], with_lines: bool, with_values: bool
) -> ViewMarks:
    """Find the marks of a picture.

    Parameters
    ----------
    field : (h, w) array    Row 0 is the bottom row.
    noise : float    Relative standard error of its pixels; infinite while unknown. What the pixels themselves show counts
        where it is more: the error of a view is that of its luminance, and illuminance has another. [-]
    size : (int, int)    Width and height of the view. [pixel]
    """
    step = max(int(np.ceil(max(field.shape) / LARGEST)), 1)
    field = average(np.asarray(field, dtype=np.float64), step)
    height, width = field.shape
    noise = max(noise / step if np.isfinite(noise) else 1.0, scatter_of_neighbours(field))
    passes = choose_passes(noise, LEAST_PASSES, min(height, width))
    left = noise * noise_left(passes)
    field = _hide_nothing(field)
    for _ in range(passes):
        field = smooth(field)
    pieces, labels = [np.zeros((0, 2, 2))], []
    extent = np.array([width, height], dtype=np.float64)
    known = field[np.isfinite(field)]
    if with_lines and known.size:
        shortest = SHORTEST * width + 3.0 * (mean_width(passes) - mean_width(LEAST_PASSES))
        low, high = np.percentile(known, [0.5, 99.5])
        levels = choose_levels([max(low, LOWEST * high), high])
        x, y = np.arange(width) + 0.5, np.arange(height) + 0.5
        for level, paths in find_contours(x, y, field, levels):
            drawn = keep_certain(paths, field, passes, left)
            drawn = [path for path in drawn if path_length(path) >= shortest]
            pieces += [np.stack([path[:-1], path[1:]], axis=1) / extent for path in drawn]
            longest = max(map(path_length, drawn), default=0.0)
            labels += [
                (*(place_label(path) / extent), level)
                for path in drawn
                if path_length(path) >= min(LABELLED * width, longest)
            ]
    points = np.zeros((0, 3))
    if with_values:
        points = sample_points(field, *(size[k] / each for k, each in enumerate((ACROSS, UP))))
        points[:, :2] /= extent
    told = f"lines and values of means over about {step * mean_width(passes):.0f} pixels"
    return ViewMarks(
        np.concatenate(pieces).astype(np.float32),
        np.array(labels, dtype=np.float32).reshape(-1, 3),
        points.astype(np.float32),
        f"{told} (noise {100.0 * left:.2g} %)",
    )


def _hide_nothing(field: np.ndarray) -> np.ndarray:
    """Return the field with NaN where it and most around it is 0: nothing is seen there, and lines would follow its edge."""
    is_lit = (field != 0.0).astype(np.float64)
    around = smooth(smooth(is_lit))
    return np.where((is_lit == 0.0) & (around < 0.5) & (is_lit.max() > 0.0), np.nan, field)
