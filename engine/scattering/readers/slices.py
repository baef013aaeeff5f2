"""Scattering on grids of angles about the normal, one for each direction of incidence, and tables made of it."""

from dataclasses import dataclass

import numpy as np

from ...scene.scattering import ScatterTable
from ..data.resampling import resample
from ..data.table import corners, place_on

STEEPEST = np.radians(89.0)
"""Intensities are divided by no smaller cosine; farther from the normal the value there holds. [rad]"""

MOST_NODES, MOST_VALUES = 1 << 18, 1 << 22
"""Of tables: more would take minutes to make."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


LEAST_TILT, MOST_TILT = np.radians(15.0), np.radians(80.0)
"""Between them the mirror direction is told from its neighbours and from the horizon."""

FLAT = 1.05
"""Values in the mirror direction must be so many times larger for one reading of azimuths to be better than another."""


@dataclass(frozen=True, eq=False)
class Slice:
    """Values for one direction of incidence, linear between angles; the ends hold.

    Parameters
    ----------
    polars : (t,) float64 array    Angles to the normal, strictly ascending within 0 to pi / 2. [rad]
    azimuths : (a,) float64 array
        Strictly ascending, 0 where light comes from: within 0 to pi where both sides of the plane of incidence are alike,
        else within one turn, on which they close. [rad]
    values : (t, a, w) float64 array    BRDF or BTDF, or intensity by incident flux where ``is_intensity``. [1/sr]
    is_intensity : bool
    """

    polars: np.ndarray
    azimuths: np.ndarray
    values: np.ndarray
    is_intensity: bool = False

    @property
    def is_symmetric(self) -> bool:
        """Whether both sides of the plane of incidence are alike."""
        return bool(self.azimuths[-1] < np.pi + 1e-6)

    def has_mirror(self) -> bool:
        """Whether the plane of incidence is a mirror plane of the values."""
        if self.is_symmetric:
            return True
        polar, azimuth = (m.ravel() for m in np.meshgrid(self.polars, self.azimuths, indexing="ij"))
        mirrored = self._look_up(polar, (2.0 * np.pi - azimuth) % (2.0 * np.pi))
        values = self.values.reshape(mirrored.shape)
        return np.allclose(mirrored, values, rtol=1e-4, atol=1e-6 * np.abs(values).max())

    def evaluate(self, polar: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
        """BRDF or BTDF in directions; azimuths from 0 to 2 pi. (n,), (n,) -> (n, w) [1/sr]"""
        if self.is_intensity:
            polar = np.minimum(polar, STEEPEST)
            return self._look_up(polar, azimuth) / np.cos(polar)[:, None]
        return self._look_up(polar, azimuth)

    def _look_up(self, polar, azimuth) -> np.ndarray:
        axis, values = self.azimuths, self.values
        if self.is_symmetric:
            azimuth = np.where(azimuth > np.pi, 2.0 * np.pi - azimuth, azimuth)
        else:
            axis, values = self._closed()
        a, a_share = place_on(axis, azimuth)
        t, t_share = place_on(self.polars, polar)
        found = 0.0
        for dt, t_weight in corners(t, t_share, len(self.polars)):
            for da, a_weight in corners(a, a_share, len(axis)):
                found = found + (t_weight * a_weight)[:, None] * values[dt, da]
        return found

    def _closed(self) -> tuple[np.ndarray, np.ndarray]:
        """Azimuths and values with a line before the first and one after the last, a turn away."""
        axis, values = self.azimuths, self.values
        if axis[-1] - axis[0] > 2.0 * np.pi - 1e-6:
            return axis, values
        axis = np.concatenate([axis[-1:] - 2.0 * np.pi, axis, axis[:1] + 2.0 * np.pi])
        return axis, np.concatenate([values[:, -1:], values, values[:, :1]], axis=1)

    def on(self, polars, azimuths) -> "Slice":
        """The same on other angles."""
        polar, azimuth = (m.ravel() for m in np.meshgrid(polars, azimuths, indexing="ij"))
        values = self._look_up(polar, azimuth).reshape(len(polars), len(azimuths), -1)
        return Slice(polars, azimuths, values, self.is_intensity)

    def mirrored(self) -> "Slice":
        """The same with the sides of the plane of incidence exchanged."""
        if self.is_symmetric:
            return self
        return slice_about_light(self.polars, -self.azimuths, self.values, self.is_intensity)

    def total(self) -> np.ndarray:
        """Share of light that is sent away, exact for what `evaluate` tells. (w,) [-]"""
        polars = np.unique(np.concatenate([[0.0, STEEPEST, 0.5 * np.pi], self.polars]))
        low, length = polars[:-1, None], np.diff(polars)[:, None]
        polar = (low + 0.5 * length * (_NODES + 1.0)).ravel()
        weight = (0.5 * length * _WEIGHTS).ravel() * np.sin(polar) * np.cos(polar)
        if self.is_symmetric:
            axis, turns = np.concatenate([[0.0], self.azimuths, [np.pi]]), 2.0
        else:
            axis = np.concatenate(
                [[0.0], self.azimuths[self.azimuths < 2.0 * np.pi], [2.0 * np.pi]]
            )
            turns = 1.0
        step = np.diff(axis)
        # The trapezium is exact where values are linear.
        share = turns * 0.5 * (np.append(step, 0.0) + np.append(0.0, step))
        found = 0.0
        for azimuth, width in zip(axis, share, strict=True):
            if width > 0.0:
                found = found + width * (
                    weight @ self.evaluate(polar, np.full_like(polar, azimuth))
                )
        return found


def slice_about_light(polars, azimuths, values, is_intensity=False) -> Slice | None:
    """A slice whose azimuths may begin anywhere and go either way about the light's.

    Parameters
    ----------
    polars : (t,) array    As of `Slice`. [rad]
    azimuths : (a,) array    From the light's, on one side of the plane of incidence or on both. [rad]
    values : (t, a, w) array
    is_intensity : bool

    Returns
    -------
    Slice or None    None: the azimuths leave out a part of a turn, and of the half of it on a side.
    """
    azimuths = np.asarray(azimuths, dtype=np.float64)
    if len(azimuths) == 1:
        return Slice(polars, np.zeros(1), values, is_intensity)
    gap = 1.5 * np.abs(np.diff(azimuths)).max() + 1e-6
    if np.ptp(azimuths) > np.pi + 1e-6:
        turned = np.round(azimuths % (2.0 * np.pi), 9) % (2.0 * np.pi)
        if 2.0 * np.pi - np.ptp(azimuths) > gap:
            return None
    else:
        low = (azimuths.min() + np.pi + 1e-6) % (2.0 * np.pi) - np.pi - 1e-6
        side = azimuths - azimuths.min() + low
        if low < -1e-6:
            side = -side
        if side.min() < -1e-6 or side.max() > np.pi + 1e-6:
            return None
        if side.min() > gap or np.pi - side.max() > gap:
            return None
        turned = np.clip(side, 0.0, np.pi)
    axis, order = np.unique(turned, return_index=True)
    return Slice(polars, axis, values[:, order], is_intensity)


def turn_up(polars, values, is_transmitted: bool):
    """Angles to the normal of the side that light goes to, where they are told from 0 to pi, with their values (t, ...)."""
    if polars[-1] <= 0.5 * np.pi + 1e-6:
        return np.minimum(polars, 0.5 * np.pi), values
    if not is_transmitted:
        kept = polars <= 0.5 * np.pi + 1e-6
        return np.minimum(polars[kept], 0.5 * np.pi), values[kept]
    kept = polars >= 0.5 * np.pi - 1e-6
    return np.pi - np.maximum(polars[kept], 0.5 * np.pi)[::-1], values[kept][::-1]


@dataclass(frozen=True, eq=False)
class SliceFan:
    """Slices for directions of incidence, linear between angles of incidence; the ends hold; the nearest rotation counts.

    Parameters
    ----------
    rotations : (p,) float64 array    Azimuths of incidence, strictly ascending within one turn. [rad]
    incidences : tuple of (s,) float64 array    Of each rotation, strictly ascending. [rad]
    slices : tuple of tuple of Slice    Of each rotation, one for each of its angles of incidence.
    wavelengths : (w,) float64 array    [nm]
    spectrum : (w,) float64 array or None    Factor on all values, where slices have one value for all wavelengths. [-]
    """

    rotations: np.ndarray
    incidences: tuple[np.ndarray, ...]
    slices: tuple[tuple[Slice, ...], ...]
    wavelengths: np.ndarray
    spectrum: np.ndarray | None = None

    def evaluate(self, wi, wo) -> np.ndarray:
        """Values for pairs of directions, light coming at one of the rotations. (n, 3), (n, 3) -> (n, w) [1/sr]"""
        sine = np.hypot(wi[:, 0], wi[:, 1])
        incidence = np.arctan2(sine, wi[:, 2])
        turn = np.where(sine > 1e-12, np.arctan2(wi[:, 1], wi[:, 0]), self.rotations[0])
        polar = np.arctan2(np.hypot(wo[:, 0], wo[:, 1]), wo[:, 2])
        azimuth = (np.arctan2(wo[:, 1], wo[:, 0]) - turn) % (2.0 * np.pi)
        rotation = self._nearest_rotation(turn)
        found = np.zeros((len(wi), self.slices[0][0].values.shape[2]))
        for p, slices in enumerate(self.slices):
            below, share = place_on(self.incidences[p], incidence)
            for s in np.unique(below[rotation == p]):
                for number, weight in corners(s, share, len(slices)):
                    used = (rotation == p) & (below == s) & (weight > 0.0)
                    if used.any():
                        values = slices[number].evaluate(polar[used], azimuth[used])
                        found[used] += weight[used, None] * values
        return found if self.spectrum is None else found * self.spectrum

    def mirrored_light(self) -> float:
        """Mean value in mirror directions, away from the normal and the horizon. [1/sr]"""
        found = []
        for incidences, slices in zip(self.incidences, self.slices, strict=True):
            for incidence, each in zip(incidences, slices, strict=True):
                if LEAST_TILT < incidence < MOST_TILT:
                    value = each.evaluate(np.array([incidence]), np.array([np.pi]))
                    found.append(float(value.mean()))
        return float(np.mean(found)) if found else 0.0

    def _nearest_rotation(self, turn: np.ndarray) -> np.ndarray:
        closed = np.append(self.rotations, self.rotations[0] + 2.0 * np.pi)
        turned = self.rotations[0] + (turn - self.rotations[0]) % (2.0 * np.pi)
        middle = 0.5 * (closed[1:] + closed[:-1])
        return np.searchsorted(middle, turned) % len(self.rotations)

    def to_table(self, colours=None, tolerance: float = 0.02) -> ScatterTable:
        """The table of it, on the angles of incidence of all rotations.

        Parameters
        ----------
        colours : function or None    Makes spectra (n, w) of values (n, 3), where these are colours.
        tolerance : float    Error that is allowed, see `ScatterTable.error`. [-]
        """

        def evaluate(wi, wo):
            values = self.evaluate(wi, wo)
            return values if colours is None else colours(values)

        return resample(
            evaluate,
            self.wavelengths,
            incidences=np.unique(np.concatenate(self.incidences)),
            rotations=tuple(self.rotations),
            tolerance=tolerance,
            is_symmetric=all(each.has_mirror() for row in self.slices for each in row),
            most=min(MOST_NODES * len(self.wavelengths), MOST_VALUES),
        )

    @property
    def steepest(self) -> float:
        """Largest angle to the normal that all slices have values for. [rad]"""
        return float(min(each.polars[-1] for row in self.slices for each in row))

    def brought_to(self, totals) -> "tuple[SliceFan, list[tuple[float, float]]]":
        """The same with each slice scaled to a stated share of light, and the factors by angles of incidence.

        Parameters
        ----------
        totals : rows of float or (w,) array    As ``slices``; 0 leaves a slice as it is. [-]
        """
        rows, factors = [], []
        for incidences, row, told in zip(self.incidences, self.slices, totals, strict=True):
            new = []
            for incidence, each, share in zip(incidences, row, told, strict=True):
                have = each.total()
                is_scaled = (have > 0.0) & (np.asarray(share) > 0.0)
                factor = np.where(is_scaled, share / np.where(is_scaled, have, 1.0), 1.0)
                factors += [(incidence, float(f)) for f in np.broadcast_to(factor, have.shape)]
                new.append(
                    Slice(each.polars, each.azimuths, each.values * factor, each.is_intensity)
                )
            rows.append(tuple(new))
        made = SliceFan(
            self.rotations, self.incidences, tuple(rows), self.wavelengths, self.spectrum
        )
        return made, factors


def choose_fan(fans) -> tuple[SliceFan | None, int]:
    """The fan of several readings that is brightest towards the mirror, and its number; the first if none stands out.

    Readings of None are passed over; if all are, the answer is None.
    """
    best, number, most = None, -1, 0.0
    for k, fan in enumerate(fans):
        if fan is None:
            continue
        light = fan.mirrored_light()
        if best is None or light > FLAT * most:
            best, number, most = fan, k, light
    return best, number
