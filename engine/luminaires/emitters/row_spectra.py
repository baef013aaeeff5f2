"""Spectra of lights that share an emitter and are told apart by rows: each an amount times one of few spectral densities."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...photometry.units import MAXIMUM_WAVELENGTH, MINIMUM_WAVELENGTH

COUNT = MAXIMUM_WAVELENGTH - MINIMUM_WAVELENGTH + 1
"""Numbers of a density, one for each nanometre."""


class RowSpectra:
    """Amounts and spectral densities on the device.

    Parameters
    ----------
    amounts : sequence of float    Of every row.
    densities : sequence of (471,) arrays    Spectral density per unit of it, on the 1 nm grid. [1/nm]
    """

    def __init__(self, amounts, densities):
        known: dict[bytes, int] = {}
        kept, numbers = [], []
        for density in densities:
            key = density.tobytes()
            if key not in known:
                known[key] = len(kept)
                kept.append(density)
            numbers.append(known[key])
        self._amounts = upload(mi.Float, amounts if len(amounts) else [0.0])
        self._numbers = upload(mi.UInt32, np.array(numbers or [0]))
        self._densities = upload(mi.Float, np.concatenate(kept) if kept else np.zeros(4))

    def eval(self, row, wavelengths, active):
        """Amount by wavelength, or the amount itself in photometric variants. Spectrum"""
        amount = dr.gather(mi.Float, self._amounts, row, active)
        if "spectral" not in mi.variant():
            return mi.Spectrum(amount)
        base = dr.gather(mi.UInt32, self._numbers, row, active) * mi.UInt32(COUNT)
        place = dr.clip(wavelengths - float(MINIMUM_WAVELENGTH), 0.0, COUNT - 1.001)
        values = []
        for position in place:
            low = mi.UInt32(position)
            first = dr.gather(mi.Float, self._densities, base + low, active)
            second = dr.gather(mi.Float, self._densities, base + low + 1, active)
            values.append(dr.lerp(first, second, position - mi.Float(low)))
        return mi.Spectrum(*values) * amount
