"""Bands of wavelengths in which cells know what they have of the sky, so that paths of coloured light can end at them.

In a band reflectances are taken for even. What that loses of the light of two reflections one after the other is how much
both vary together within the bands, so there are as many bands as the scene's surfaces need: one, where they are grey.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...photometry.spectra import GRID, luminous_efficiency
from ...photometry.units import MINIMUM_WAVELENGTH

COUNTS = (1, 2, 4, 8)
"""Of bands. Paths have four wavelengths, equally far apart in light, and bands have equal light."""

ENOUGH = 1e-3
"""Light that may be lost or won within bands by one reflection after another, relative. [-]"""

SAMPLES = 32
"""Wavelengths at which surfaces are looked at, equally far apart in light."""


@dataclass(frozen=True, eq=False)
class SkyBands:
    """Bands of wavelengths.

    Parameters
    ----------
    numbers : (471,) uint32 array    Band of every wavelength of the 1 nm grid.
    shares : (b,) array    Of the light, by band; sum 1. [-]
    within : float    What reflectances that vary within bands may change of light that is reflected once more. [-]
    """

    numbers: np.ndarray
    shares: np.ndarray
    within: float = 0.0

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.shares)

    @staticmethod
    def one() -> "SkyBands":
        """All wavelengths together."""
        return SkyBands(np.zeros(len(GRID), dtype=np.uint32), np.ones(1))

    def on_device(self) -> "DeviceBands":
        """For kernels."""
        return DeviceBands(upload(mi.UInt32, self.numbers), self.count)


class DeviceBands:
    """Bands in the device's memory."""

    def __init__(self, numbers, count: int):
        self._numbers, self.count = numbers, count
        dr.eval(numbers)

    def divide(self, amounts, wavelengths) -> list[tuple]:
        """Return amounts of single wavelengths (Spectrum) with their bands, or all together where there is one band."""
        if self.count == 1:
            return [(mi.UInt32(0), dr.sum(amounts))]
        last = len(GRID) - 1
        made = []
        for k in range(len(amounts)):
            cell = dr.clip(wavelengths[k] - (MINIMUM_WAVELENGTH - 0.5), 0, last)
            band = dr.gather(mi.UInt32, self._numbers, mi.UInt32(cell))
            made.append((band, amounts[k]))
        return made


def find_samples(light: np.ndarray) -> np.ndarray:
    """Return wavelengths equally far apart in the light of a spectrum (471,). (SAMPLES,) [nm]"""
    return GRID[np.searchsorted(_cumulate(light), (np.arange(SAMPLES) + 0.5) / SAMPLES)]


def choose_bands(light: np.ndarray, reflectances: np.ndarray, looks: np.ndarray) -> SkyBands:
    """Return as few bands as surfaces need.

    Parameters
    ----------
    light : (471,) array    Spectrum of the lamp on the 1 nm grid, any scale.
    reflectances : (s, SAMPLES) array    At the wavelengths of `find_samples`. [-]
    looks : (s,) array    How often each is met.
    """
    for count in COUNTS:
        within = _find_within(reflectances, looks, count)
        if within <= ENOUGH:
            break
    # A wavelength belongs where its middle lies.
    total = _cumulate(light)
    middle = total - 0.5 * np.diff(np.concatenate([[0.0], total]))
    numbers = np.minimum(middle * count, count - 1).astype(np.uint32)
    weights = np.diff(np.concatenate([[0.0], total]))
    return SkyBands(numbers, np.bincount(numbers, weights, minlength=count), within)


def _find_within(reflectances, looks, count: int) -> float:
    """How much two surfaces that are met by chance may vary together within bands, relative to their light. [-]"""
    bands = reflectances.reshape(len(reflectances), count, SAMPLES // count)
    mean = np.maximum(reflectances.mean(axis=1), 1e-9)
    spread = bands.var(axis=2).mean(axis=1) / mean**2
    # The square of the mean of roots is at most the mean, so no pairs vary more.
    return float(np.average(spread, weights=looks)) if looks.sum() > 0.0 else 0.0


def _cumulate(light: np.ndarray) -> np.ndarray:
    """Share of the light up to and with each wavelength. (471,)"""
    weight = np.asarray(light, dtype=np.float64) * luminous_efficiency()
    total = np.cumsum(weight)
    return total / total[-1]
