"""Counts of an instrument made into a BRDF by a white sample whose BRDF is certified."""

from dataclasses import dataclass

import numpy as np

from ..data.table import direction_of
from .raw_measurement import Instrument, RawMeasurement, RawSlice


@dataclass(frozen=True, eq=False)
class CalibratedSlice:
    """BRDF for one angle of incidence, as noisy as it was measured.

    Parameters
    ----------
    incidence : float    [rad]
    radial, azimuth : (d,) float64 arrays    Directions about the mirror direction, above the horizon. [rad]
    values : (d, w) float64 array    BRDF; nan where nothing valid was measured. [1/sr]
    variance : (d, w) float64 array    Relative, without the calibration's own error that all directions share. [-]
    """

    incidence: float
    radial: np.ndarray
    azimuth: np.ndarray
    values: np.ndarray
    variance: np.ndarray


def calibrate(raw: RawMeasurement) -> tuple[CalibratedSlice, ...]:
    """Make counts into a BRDF, direction by direction and band by band.

    Every count is taken over that of the reference channel, which sees the lamp, so that a lamp that drifts does no harm.
    What is dark, saturated, shadowed or lacks one of its four counts is no data.
    """
    return tuple(_calibrate(piece, raw) for piece in raw.slices)


def _calibrate(piece: RawSlice, raw: RawMeasurement) -> CalibratedSlice:
    device = raw.instrument
    sample = piece.sample - raw.dark
    white = piece.white - raw.dark
    references = [
        each - raw.reference_dark for each in (piece.sample_reference, piece.white_reference)
    ]
    channels = (sample, references[0], white, references[1])
    with np.errstate(invalid="ignore", divide="ignore"):
        valid = np.ones(sample.shape, dtype=bool)
        for counts in channels:
            valid &= (counts > max(device.lowest, 0.0)) & (counts <= device.highest)
        values = raw.white_brdf * (sample / references[0]) / (white / references[1])
        variance = device.repeatability**2 + sum(_relative_variance(c, device) for c in channels)
    above = direction_of(piece.incidence, piece.radial, piece.azimuth)[:, 2] > 1e-3
    valid &= np.isfinite(values) & above[:, None]
    return CalibratedSlice(
        piece.incidence,
        piece.radial,
        piece.azimuth,
        np.where(valid, values, np.nan),
        np.where(valid, variance, np.nan),
    )


def _relative_variance(counts: np.ndarray, device: Instrument) -> np.ndarray:
    """Variance of counts that the detector itself adds, over their square."""
    return (device.readout**2 + device.shot * np.maximum(counts, 0.0)) / counts**2
