"""How many lumels a chart needs: charts whose light is even get fewer."""

from collections.abc import Sequence

import numpy as np

from .layout import Atlas
from .topology import largest_by, sum_by


def halve_even_charts(
    atlas: Atlas,
    values: Sequence[np.ndarray],
    covered: Sequence[np.ndarray],
    charts: Sequence[np.ndarray],
    threshold: float,
) -> np.ndarray:
    """Find how often every chart can be halved along both sides without losing detail, as a factor on its density.

    A chart can be halved as long as every mean of 2 x 2 lumels differs from these by less than the threshold; then the same
    is asked of the means. Blocks at the rim have fewer lumels. Noise counts as detail, so the values must be known better
    than the threshold.

    Parameters
    ----------
    atlas : Atlas
    values : sequence of (h, w) float array    Illuminance of each page. [lx]
    covered : sequence of (h, w) bool array    Lumels that count.
    charts : sequence of (h, w) int array    Number of the chart over all pages.
    threshold : float    [lx]

    Returns
    -------
    (c,) float64 array    1, 1/2, 1/4 ... for every chart of the atlas; charts without lumels keep 1.
    """
    count = atlas.chart_count
    factor = np.ones(count)
    chart, x, y, value = _gather(values, covered, charts)
    going = np.zeros(count, dtype=bool)
    going[chart] = True
    # Blocks are counted from each chart's own lower left corner.
    x, y = (axis - _find_lowest(chart, axis, count)[chart] for axis in (x, y))
    while True:
        # A chart of a single lumel cannot be halved.
        sides = np.maximum(*(largest_by(chart, axis, count, 0.0) for axis in (x, y)))
        going &= sides > 0.0
        kept = going[chart]
        chart, x, y, value = chart[kept], x[kept], y[kept], value[kept]
        if len(chart) == 0:
            return factor
        x, y = x // 2, y // 2
        span = int(max(x.max(), y.max())) + 1
        key, block = np.unique((chart * span + y) * span + x, return_inverse=True)
        block = block.reshape(-1)
        mean = sum_by(block, value, len(key)) / np.bincount(block)
        apart = largest_by(chart, np.abs(value - mean[block]), count, 0.0)
        going &= apart < threshold
        factor[going] *= 0.5
        rest, x = np.divmod(key, span)
        chart, y = np.divmod(rest, span)
        value = mean


def _gather(values, covered, charts):
    """Put the covered lumels of all pages in a row: chart, column, row, value."""
    parts = []
    for page, mask, owner in zip(values, covered, charts, strict=True):
        y, x = np.nonzero(mask & (owner >= 0))
        parts.append((owner[y, x].astype(np.int64), x, y, page[y, x].astype(np.float64)))
    if not parts:
        none = np.zeros(0, dtype=np.int64)
        return none, none, none.copy(), np.zeros(0)
    chart, x, y, value = (np.concatenate(part) for part in zip(*parts, strict=True))
    return chart, x, y, value


def _find_lowest(chart: np.ndarray, axis: np.ndarray, count: int) -> np.ndarray:
    """Lowest column or row of every chart. (count,)"""
    return -largest_by(chart, -axis.astype(np.float64), count, 0.0 - axis.max(initial=0)).astype(
        np.int64
    )
