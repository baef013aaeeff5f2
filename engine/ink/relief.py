"""Upper faces with hills and valleys, as part of the grid that waves are solved on."""

import numpy as np

CREST = 3.0
"""Standard deviations of the height that stand above the mean, and below it, at most."""


def random_heights(height: float, length: float, width: float, columns: int, rng) -> np.ndarray:
    """Heights above the mean with Gaussian statistics, correlated as exp(-r^2 / length^2), that repeat with the cell.

    Returns
    -------
    (y, x) float64 array    [um]
    """
    q = 2.0 * np.pi * np.fft.fftfreq(columns, width / columns)
    square = q[None, :] ** 2 + q[:, None] ** 2
    filter_ = np.exp(-(length**2) * square / 8.0)
    filter_[0, 0] = 0.0
    noise = np.fft.fft2(rng.standard_normal((columns, columns)))
    scale = height / np.sqrt((filter_**2).mean())
    return np.clip(scale * np.fft.ifft2(noise * filter_).real, -CREST * height, CREST * height)


def carve(permittivity, heights, thickness: float, mean_depth: float, above: float) -> np.ndarray:
    """Take off what stands above a face.

    Parameters
    ----------
    permittivity : (z, y, x) array    Of the matter, from the highest crest on.
    heights : (y, x) array    Of the face above its mean. [um]
    thickness : float    Of the whole grid. [um]
    mean_depth : float    Of the mean face below the top of the grid. [um]
    above : float    Index above the face.

    Returns
    -------
    (z, y, x) complex128 array    Means over cells, exact along z.
    """
    layers = len(permittivity)
    step = thickness / layers
    bottom = (np.arange(layers) + 1.0)[:, None, None] * step
    share = np.clip((bottom - (mean_depth - heights)) / step, 0.0, 1.0)
    return above**2 + share * (permittivity - above**2)
