"""Smoothing of maps within charts, for looking at: what it returns is biased.

An edge-avoiding wavelet filter (H. Dammertz et al., HPG 2010) whose yardstick is the maps' own standard error, so that it
takes out what may be noise and keeps what cannot be.
"""

import numpy as np

KERNEL = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0
"""Cubic B-spline."""

LEVELS = 3
"""Steps of 1, 2 and 4 lumels."""

TOLERANCE = 3.0
"""Differences of so many standard errors of a difference count half."""


def smooth_maps(values: np.ndarray, error: np.ndarray, known: np.ndarray, chart: np.ndarray):
    """Smooth maps alike, led by the first.

    Parameters
    ----------
    values : (k, h, w) array    Maps; the first is the illuminance.
    error : (h, w) array    Standard error of the first.
    known : (h, w) bool array    Lumels that were computed; others neither give nor get.
    chart : (h, w) int array    Nothing passes from chart to chart.

    Returns
    -------
    (k, h, w) float32 array
    """
    made = np.array(values, dtype=np.float32)
    variance = np.where(known, error.astype(np.float64) ** 2, 0.0)
    for level in range(LEVELS):
        step = 1 << level
        total = np.zeros(made.shape)
        weights = np.zeros(known.shape)
        noise = np.zeros(known.shape)
        for dy in range(-2, 3):
            for dx in range(-2, 3):
                here, there = _overlap(known.shape, dy * step, dx * step)
                alike = known[here] & known[there] & (chart[here] == chart[there])
                spread = variance[here] + variance[there]
                square = (made[0][here] - made[0][there]).astype(np.float64) ** 2
                close = np.exp2(-square / (TOLERANCE**2 * np.maximum(spread, 1e-300)))
                weight = np.where(alike, KERNEL[dy + 2] * KERNEL[dx + 2] * close, 0.0)
                total[(slice(None), *here)] += weight * made[(slice(None), *there)]
                weights[here] += weight
                noise[here] += weight**2 * variance[there]
        filled = weights > 0.0
        made[:, filled] = (total[:, filled] / weights[filled]).astype(np.float32)
        variance[filled] = noise[filled] / weights[filled] ** 2
    return made


def _overlap(shape, dy: int, dx: int):
    """Windows of an array and of itself shifted."""

    def windows(size: int, shift: int):
        return slice(max(-shift, 0), size - max(shift, 0)), slice(
            max(shift, 0), size - max(-shift, 0)
        )

    (y, other_y), (x, other_x) = windows(shape[0], dy), windows(shape[1], dx)
    return (y, x), (other_y, other_x)
