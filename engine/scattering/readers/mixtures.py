"""Surfaces described by shares of light: as by a mirror, matt, and in a lobe about the mirror direction."""

from dataclasses import dataclass, replace

import numpy as np

from ...scene.scattering import ScatterTable
from ..data.resampling import resample
from ..data.table import coordinates_of, direction_of

NARROWEST = np.radians(0.2)
"""Lobes of less full width are taken as those of a mirror. [rad]"""

SIGMAS = 4.0 * np.log(2.0)
"""Factor in the exponent of a lobe over its full width at half maximum."""

RADIAL_POINTS, AZIMUTH_POINTS = 48, 96
"""Of the integral over a lobe."""


@dataclass(frozen=True, eq=False)
class Mixture:
    """Shares of light by angle of incidence and wavelength.

    The lobe is a Gaussian curve of the BRDF over the angle from the mirror direction, of its own full widths at half maximum
    in the plane of incidence and across it, and scaled so that its part above the horizon carries its share.

    Parameters
    ----------
    incidences : (s,) float64 array    Strictly ascending. [rad]
    wavelengths : (w,) float64 array    Strictly ascending. [nm]
    direct, lambert, gauss : (s, w) float64 array    Shares. [-]
    along, across : (s, w) float64 array    Widths of the lobe. [rad]
    """

    incidences: np.ndarray
    wavelengths: np.ndarray
    direct: np.ndarray
    lambert: np.ndarray
    gauss: np.ndarray
    along: np.ndarray
    across: np.ndarray

    def to_table(self, tolerance: float = 0.02) -> ScatterTable:
        """The table of it on its angles of incidence."""
        is_narrow = np.minimum(self.along, self.across) < NARROWEST
        mixture = replace(
            self,
            direct=self.direct + np.where(is_narrow, self.gauss, 0.0),
            gauss=np.where(is_narrow, 0.0, self.gauss),
        )
        if not (mixture.lambert.any() or mixture.gauss.any()):
            return direct_table(self.incidences, self.wavelengths, mixture.direct)
        peaks = mixture._peaks()
        used = mixture.gauss > 0.0
        widths = np.unique(np.concatenate([self.along[used], self.across[used]]).round(3))[:8]
        hints = np.outer(widths, (0.25, 0.5, 0.75, 1.0, 1.5)).ravel()
        table = resample(
            lambda wi, wo: mixture._evaluate(wi, wo, peaks),
            self.wavelengths,
            incidences=self.incidences,
            hints=hints[hints < 3.0],
            tolerance=tolerance,
        )
        return add_direct(table, self.wavelengths, mixture.direct)

    def _peaks(self) -> np.ndarray:
        """BRDF at the tops of the lobes. (s, w) [1/sr]"""
        peaks = np.zeros_like(self.gauss)
        known = {}
        for s, w in np.argwhere(self.gauss > 0.0):
            key = s, self.along[s, w], self.across[s, w]
            if key not in known:
                known[key] = _integrate_lobe(self.incidences[s], *key[1:])
            peaks[s, w] = self.gauss[s, w] / known[key]
        return peaks

    def _evaluate(self, wi, wo, peaks: np.ndarray) -> np.ndarray:
        """BRDF of pairs of directions, light coming at one of the angles of incidence. (n, 3), (n, 3) -> (n, w)"""
        _, incidence, radial, azimuth = coordinates_of(wi, wo)
        middle = 0.5 * (self.incidences[1:] + self.incidences[:-1])
        places = np.searchsorted(middle, incidence)
        found = self.lambert[places] / np.pi
        for s in np.unique(places):
            used = places == s
            for w in np.flatnonzero(peaks[s]):
                shape = _lobe(radial[used], azimuth[used], self.along[s, w], self.across[s, w])
                found[used, w] += peaks[s, w] * shape
        return found


def _lobe(radial, azimuth, along: float, across: float) -> np.ndarray:
    square = (np.cos(azimuth) / along) ** 2 + (np.sin(azimuth) / across) ** 2
    return np.exp(-SIGMAS * square * radial**2)


def _integrate_lobe(incidence: float, along: float, across: float) -> float:
    """Integral of a lobe of height 1 times the cosine. [sr]"""
    nodes, weights = np.polynomial.legendre.leggauss(RADIAL_POINTS)
    # Beyond it nothing is left of a Gaussian curve.
    reach = min(np.pi, 2.5 * max(along, across))
    azimuth = (np.arange(AZIMUTH_POINTS) + 0.5) * 2.0 * np.pi / AZIMUTH_POINTS
    # In each direction up to the horizon, so that no step is integrated over.
    horizon = np.arctan2(np.cos(incidence), np.cos(azimuth) * np.sin(incidence))
    end = np.minimum(reach, horizon)
    radial = 0.5 * end * (nodes[:, None] + 1.0)
    cosine = direction_of(incidence, radial, azimuth)[..., 2]
    shape = _lobe(radial, azimuth, along, across) * np.maximum(cosine, 0.0) * np.sin(radial)
    return float((weights @ (0.5 * end * shape)).sum() * 2.0 * np.pi / AZIMUTH_POINTS)


def direct_table(incidences, wavelengths, direct) -> ScatterTable:
    """A table that only reflects as a mirror, or lets light pass straight. ``direct`` (s, w) [-]"""
    values = np.zeros((1, len(incidences), 2, 2, len(wavelengths)), dtype=np.float32)
    ends = np.array([0.0, np.pi])
    return ScatterTable(
        np.zeros(1),
        incidences,
        ends,
        ends,
        wavelengths,
        values,
        np.asarray(direct, dtype=np.float32)[None],
    )


def add_direct(table: ScatterTable, wavelengths, direct) -> ScatterTable:
    """A table with shares of direct light, on as many wavelengths as these need.

    Parameters
    ----------
    table : ScatterTable    Of one rotation.
    wavelengths : (w,) array    Among them are those of the table. [nm]
    direct : (s, w) array    At the table's angles of incidence. [-]
    """
    if not np.any(direct):
        return table
    bands = table.wavelengths
    kept = np.stack([np.interp(bands, wavelengths, row) for row in direct])
    again = np.stack([np.interp(wavelengths, bands, row) for row in kept])
    if np.allclose(again, direct, atol=1e-3):
        return replace(table, direct=kept[None].astype(np.float32))
    share = np.stack([np.interp(wavelengths, bands, row) for row in np.eye(len(bands))])
    return replace(
        table,
        wavelengths=np.asarray(wavelengths, dtype=np.float64),
        values=(table.values @ share).astype(np.float32),
        direct=np.asarray(direct, dtype=np.float32)[None],
    )
