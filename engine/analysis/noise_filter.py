"""Smoothing of noisy pictures for looking at: an edge-avoiding wavelet filter steered by the picture's own error.

It never touches the linear data: what it returns is biased, and whoever shows it has to say so.

References
----------
H. Dammertz et al.: Edge-Avoiding A-Trous Wavelet Transform for fast Global Illumination Filtering, HPG 2010; the use of
the variance as the yardstick for differences of luminance follows C. Schied et al.: Spatiotemporal Variance-Guided
Filtering, HPG 2017.
"""

import numpy as np

from ..photometry.colour import REC709_LUMINANCE as WEIGHTS

KERNEL = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0
"""Cubic B-spline."""

LEVELS = 4
"""Steps of 1, 2, 4 and 8 pixels."""

LUMINANCE_TOLERANCE = 6.0
"""Differences of luminance up to this many standard errors are taken for noise."""

NORMAL_EXPONENT = 64.0
"""How sharply a change of direction of the surface stops the filter."""

DEPTH_TOLERANCE = 0.05
"""Relative step of depth per pixel that stops the filter beyond the slope of the surface."""

SMALLEST_ALBEDO = 0.04
"""Darker surfaces are not divided by their reflectance."""

OUTLIER = 1.6
"""Pixels brighter than this many times the second brightest of their neighbours are brought down to it."""


def smooth(colour, luminance_error, normal, depth, albedo) -> np.ndarray:
    """Return a smoothed copy of a picture.

    Parameters
    ----------
    colour : (h, w, 3) array    Linear Rec. 709.
    luminance_error : (h, w) array    Standard error of its luminance, same unit.
    normal : (h, w, 3), depth : (h, w), albedo : (h, w, 3)    Of the surface seen at the pixels' centres.

    Returns
    -------
    (h, w, 3) float32 array
    """
    albedo = np.maximum(albedo, SMALLEST_ALBEDO)
    light = _without_outliers(np.nan_to_num(colour).astype(np.float32)) / albedo
    deviation = luminance_error / (albedo @ WEIGHTS)
    # A half-difference is a noisy measure of one pixel's error: average it over neighbours.
    variance = _blur(_blur(deviation.astype(np.float32) ** 2))
    slope = np.maximum(*(np.abs(np.gradient(depth, axis=axis)) for axis in (0, 1)))
    slope = np.minimum(slope, DEPTH_TOLERANCE * depth)
    for level in range(LEVELS):
        light, variance = _pass(light, variance, normal, depth, slope, 1 << level)
    return (light * albedo).astype(np.float32)


def _without_outliers(colour: np.ndarray) -> np.ndarray:
    """Bring single bright pixels down to their neighbourhood."""
    luminance = colour @ WEIGHTS
    around = np.stack(
        [_shift(luminance, dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dy or dx]
    )
    second = np.partition(around, -2, axis=0)[-2]
    limit = np.maximum(OUTLIER * second, 1e-6)
    return colour * np.minimum(1.0, limit / np.maximum(luminance, 1e-9))[..., None]


def _shift(values: np.ndarray, dy: int, dx: int) -> np.ndarray:
    """Values of the neighbour (y + dy, x + dx); edges repeat."""
    height, width = values.shape[:2]
    rows = np.clip(np.arange(height) + dy, 0, height - 1)
    columns = np.clip(np.arange(width) + dx, 0, width - 1)
    return values[rows[:, None], columns]


def _blur(values: np.ndarray) -> np.ndarray:
    for axis in (0, 1):
        shifts = [(-1, 0), (0, 0), (1, 0)] if axis == 0 else [(0, -1), (0, 0), (0, 1)]
        values = sum(w * _shift(values, *s) for w, s in zip((0.25, 0.5, 0.25), shifts, strict=True))
    return values


def _pass(light, variance, normal, depth, slope, step):
    """One level of the transform, with the variance carried along."""
    luminance = light @ WEIGHTS
    tolerance = LUMINANCE_TOLERANCE * np.sqrt(_blur(variance)) + 1e-6
    total, total_variance = np.zeros_like(light), np.zeros_like(variance)
    weight_sum = np.zeros_like(luminance)
    for i, dy in enumerate((-2, -1, 0, 1, 2)):
        for j, dx in enumerate((-2, -1, 0, 1, 2)):
            y, x = dy * step, dx * step
            other = _shift(light, y, x)
            weight = np.full_like(luminance, KERNEL[i] * KERNEL[j])
            if dy or dx:
                distance = step * np.hypot(dy, dx)
                aligned = np.clip((normal * _shift(normal, y, x)).sum(axis=2), 0.0, 1.0)
                apart = np.abs(depth - _shift(depth, y, x)) / (slope * distance + 1e-3 * depth)
                change = np.abs(luminance - other @ WEIGHTS) / tolerance
                nothing = (depth > 1e9) & (_shift(depth, y, x) > 1e9)
                weight *= np.where(nothing, 1.0, aligned**NORMAL_EXPONENT) * np.exp(-apart - change)
            total += weight[..., None] * other
            total_variance += weight**2 * _shift(variance, y, x)
            weight_sum += weight
    return total / weight_sum[..., None], total_variance / weight_sum**2
