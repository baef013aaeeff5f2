"""What receivers tell of the spectrum of light: how it acts on the eye's receptors, and bands of its power."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...photometry.alpha_opic import RECEPTORS, action_spectra, daylight_ratios
from ...photometry.spectra import GRID, luminous_efficiency
from ...photometry.units import LUMINOUS_EFFICACY, MINIMUM_WAVELENGTH, VISIBLE

BANDS = 80
"""Bands of 5 nm over the visible range, as spectroradiometers have them."""

CHANNELS = len(RECEPTORS) + BANDS
"""Equivalent daylight illuminances [lx], then irradiance by band times K_m [lx/nm]: alike in size, so that errors in lux,
which all channels get in common, are not too small for any."""


def band_edges() -> np.ndarray:
    """Edges of the bands, (81,). [nm]"""
    return np.linspace(*VISIBLE, BANDS + 1)


def _weights() -> np.ndarray:
    """What spectral irradiance at each wavelength of `GRID` adds to the channels. (471, 85)"""
    width = (VISIBLE[1] - VISIBLE[0]) / BANDS
    low, high = GRID[:, None] - 0.5, GRID[:, None] + 0.5
    edges = band_edges()
    within = np.clip(np.minimum(high, edges[1:]) - np.maximum(low, edges[:-1]), 0.0, None)
    return np.hstack([action_spectra() / daylight_ratios(), within * (LUMINOUS_EFFICACY / width)])


class SpectralMeter:
    """Sums of the channels.

    Parameters
    ----------
    light : (471,) array    Mean spectral power of the lights, which photometric transport stands for.
    sampler : WavelengthSampler or None    None in photometric variants.
    """

    def __init__(self, light: np.ndarray, sampler):
        self._sampler, self._weights = sampler, _weights()
        # A wavelength adds to the receptors and to two bands at most.
        self._of_receptors = self._weights[:, : len(RECEPTORS)]
        self._of_bands = self._weights[:, len(RECEPTORS) :]
        luminous = LUMINOUS_EFFICACY * float(light @ luminous_efficiency())
        self._of_lux = light @ self._weights / luminous if luminous > 0.0 else np.zeros(CHANNELS)

    def arrays(self, value, wavelengths) -> list:
        """What of samples has to be evaluated: irradiance by wavelength, and which wavelengths."""
        if self._sampler is None:
            return []
        each = value / (4.0 * self._sampler.density(wavelengths))
        each = [dr.select(dr.isfinite(each[k]), each[k], 0.0) for k in range(4)]
        cells = [mi.UInt32(wavelengths[k] - (MINIMUM_WAVELENGTH - 0.5)) for k in range(4)]
        return [*each, *cells]

    def sums(self, arrays: list, illuminance: np.ndarray, rows: int) -> np.ndarray:
        """Sums of samples, as many neighbours to each of ``rows``. (rows, channels) [lx]

        ``arrays``: of `arrays`, evaluated; ``illuminance``: sums of the rows, (rows,). [lx]
        """
        if self._sampler is None:
            return illuminance[:, None] * self._of_lux
        made = np.zeros((rows, CHANNELS))
        first = len(RECEPTORS)
        for each, cell in zip(arrays[:4], arrays[4:], strict=True):
            values = np.array(each, dtype=np.float64).reshape(rows, -1)
            cells = np.minimum(np.array(cell), len(GRID) - 1).reshape(rows, -1)
            for k in range(first):
                made[:, k] += (values * self._of_receptors[cells, k]).sum(axis=1)
            by_wavelength = _histogram(values, cells)
            made[:, first:] += by_wavelength @ self._of_bands
        return made


def _histogram(values: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Sums by row and wavelength. (rows, 471)"""
    rows = np.arange(len(values))[:, None] * len(GRID)
    count = len(values) * len(GRID)
    return np.bincount((rows + cells).ravel(), values.ravel(), count).reshape(-1, len(GRID))
