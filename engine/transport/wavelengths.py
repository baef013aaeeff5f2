"""Choice of the four wavelengths of a path and the weights that turn spectral radiance into answers."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ..arrays import upload
from ..photometry.spectra import GRID, observer
from ..photometry.units import LUMINOUS_EFFICACY, MINIMUM_WAVELENGTH

DEFENSIVE_SHARE = 0.1
"""Share of wavelengths drawn without regard to the lamps, so that no wavelength has zero density."""


CELL_RIM = 2e-4
"""Rim of a cell that wavelengths keep off; some units in the last place of a wavelength. [nm]"""


def _cell_means(values: np.ndarray) -> np.ndarray:
    """Means over cells of 1 nm about the grid's points of what is linear between them. (471,)"""
    padded = np.pad(values, 1, mode="edge")
    return (padded[:-2] + 6.0 * padded[1:-1] + padded[2:]) / 8.0


def _cell_weights(function: np.ndarray) -> np.ndarray:
    """Constants per cell whose integrals with spectra, linear between the grid's points, are the 1 nm sums. (471,)

    The inverse of `_cell_means` up to fourth differences, by which 0.3 % at the violet end become 0.001 %.
    """
    return np.maximum(2.0 * function - _cell_means(function), 0.0)


class WavelengthSampler:
    """Draws wavelengths in proportion to response times the scene's mean light.

    With one lamp spectrum and neutral surfaces the weight of every path is then nearly the same, and spectral transport
    costs no extra noise. The four wavelengths of a path are equally spaced in the cumulative distribution.

    Parameters
    ----------
    light : (471,) array    Mean spectral power of the scene's lights on the 1 nm grid, any scale.
    response : str    ``luminance`` when only V(lambda) matters, ``colour`` for x-bar + y-bar + z-bar,
        ``bands`` when spectral bands are wanted too.
    """

    def __init__(self, light: np.ndarray, response: str):
        functions = observer()
        base = {"luminance": functions[:, 1], "colour": functions.sum(axis=1)}.get(response)
        if base is None:
            base = functions.sum(axis=1) + 0.5 * ((GRID >= 380.0) & (GRID <= 780.0))
        # Spectra are linear between full nanometres, so a cell's mean is not the value in its middle; for the density of a
        # line the difference is large.
        wanted = base * _cell_means(light)
        density = wanted if np.any(wanted > 0.0) else base
        density = (
            1.0 - DEFENSIVE_SHARE
        ) * density / density.sum() + DEFENSIVE_SHARE * base / base.sum()
        # Piecewise constant over cells of 1 nm centred on the grid, so that weights can be tabulated exactly.
        density = np.maximum(density, 1e-7)
        density /= density.sum()
        self._cdf = upload(mi.Float, np.concatenate([[0.0], np.cumsum(density)]))
        self._density = upload(mi.Float, density)
        self._response = [
            upload(mi.Float, LUMINOUS_EFFICACY * _cell_weights(functions[:, i]) / density / 4.0)
            for i in range(3)
        ]
        dr.eval(self._cdf, self._density, *self._response)

    def sample(self, u):
        """Return the four wavelengths of a path from one number in [0, 1). [nm]"""
        wavelengths = mi.Spectrum(0.0)
        for k in range(4):
            v = u + 0.25 * k
            v = dr.select(v >= 1.0, v - 1.0, v)
            cell = dr.binary_search(
                0, len(GRID), lambda i, v=v: dr.gather(mi.Float, self._cdf, i) <= v
            )
            cell = dr.clip(mi.Int32(cell) - 1, 0, len(GRID) - 1)
            cell = mi.UInt32(cell)
            low = dr.gather(mi.Float, self._cdf, cell)
            width = dr.gather(mi.Float, self._density, cell)
            # Not to the very ends: rounded into the next cell, whose weight may be thousands of times as large, a rare
            # wavelength would count for a line.
            inside = dr.clip((v - low) / width, CELL_RIM, 1.0 - CELL_RIM)
            # Half a cell hangs over each end of the range; it is drawn to the end, whose weight it has.
            nm = MINIMUM_WAVELENGTH - 0.5 + mi.Float(cell) + inside
            wavelengths[k] = dr.clip(nm, GRID[0], GRID[-1])
        return wavelengths

    def _weight(self, table, wavelengths):
        weights = mi.Spectrum(0.0)
        for k in range(4):
            cell = mi.UInt32(dr.clip(wavelengths[k] - (MINIMUM_WAVELENGTH - 0.5), 0, len(GRID) - 1))
            weights[k] = dr.gather(mi.Float, table, cell)
        return weights

    def luminance(self, radiance, wavelengths):
        """Estimate of K_m * integral of radiance times V. [W/m2/sr/nm -> cd/m2, or W/m2/nm -> lx]"""
        return dr.sum(radiance * self._weight(self._response[1], wavelengths))

    def tristimulus(self, radiance, wavelengths):
        """Estimate of X, Y, Z in photometric units (Y is the luminance). [W/m2/sr/nm -> cd/m2]"""
        return mi.Color3f(
            *(dr.sum(radiance * self._weight(table, wavelengths)) for table in self._response)
        )

    def density(self, wavelengths):
        """Probability density of each wavelength. [1/nm]"""
        return self._weight(self._density, wavelengths)
