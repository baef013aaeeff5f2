"""What the particles of a layer do to light, band by band: extinction and scattering in modes of the azimuth."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .composition import Flakes, Grains, Layer, Medium, face_densities, volume_fractions
from .flake_optics import FlakeCurves, find_curves
from .mie import scatter_spheres
from .orientation import interception, scattering_modes, slope_with_diffraction

PHASE_POINTS = 256
"""Angles by which a stated phase function is integrated."""

SMALLEST_TERM = 1e-6
"""Terms of a phase function that are smaller are left out at its end. [-]"""


@dataclass(frozen=True, eq=False)
class FlakeMatter:
    """Flakes of a layer.

    Parameters
    ----------
    area : float    Of faces by volume. [1/um]
    slope : float    With diffraction. [-]
    curves : FlakeCurves
    flakes : Flakes
    """

    area: float
    slope: float
    curves: FlakeCurves
    flakes: Flakes


@dataclass(frozen=True, eq=False)
class PigmentMatter:
    """A pigment of a layer.

    Parameters
    ----------
    extinction, scattering : (w,) float64 arrays    [1/um]
    series : (w, l) float64 array    As of `mie.Spheres`.
    """

    extinction: np.ndarray
    scattering: np.ndarray
    series: np.ndarray

    def cut(self, terms: int) -> "PigmentMatter":
        """The same with a series of so many terms at most: what is narrower counts as not scattered (delta-M)."""
        series = self.series
        if series.shape[1] <= terms:
            return self
        forward = series[:, terms : terms + 1]
        scattered = self.scattering * forward[:, 0]
        series = (series[:, :terms] - forward) / (1.0 - forward)
        return PigmentMatter(self.extinction - scattered, self.scattering - scattered, series)


@dataclass(frozen=True, eq=False)
class LayerMatter:
    """A layer at wavelengths.

    Parameters
    ----------
    thickness : float    [um]
    index : (w,) float64 array    Real, of its binder.
    mean_index : float    Which directions in it go by.
    absorption : (w,) float64 array    Of the binder's share of the volume. [1/um]
    flakes : tuple of FlakeMatter
    pigments : tuple of PigmentMatter
    """

    thickness: float
    index: np.ndarray
    mean_index: float
    absorption: np.ndarray
    flakes: tuple[FlakeMatter, ...]
    pigments: tuple[PigmentMatter, ...]

    @property
    def face_index(self) -> np.ndarray:
        """The index by which faces reflect: one where all bands share it. (w,) or (1,)"""
        return self.index[:1] if np.ptp(self.index) == 0.0 else self.index

    @property
    def has_particles(self) -> bool:
        """Whether anything scatters in it."""
        return bool(self.flakes or self.pigments)

    def extinction(self, cosines) -> np.ndarray:
        """Exact extinction of light at cosines to the normal. (n,) -> (w, n) [1/um]"""
        along = sum((each.extinction for each in self.pigments), self.absorption)
        total = np.broadcast_to(along[:, None], (len(along), len(cosines))).copy()
        for each in self.flakes:
            stopped = -each.curves.passed
            stopped[:, 0] += 1.0
            total += each.area * (stopped @ interception(cosines, each.slope, each.curves.terms).T)
        return total

    def absorbed(self, cosines) -> np.ndarray:
        """The part of `extinction` that is absorbed. (n,) -> (w, n) [1/um]"""
        along = sum((each.extinction - each.scattering for each in self.pigments), self.absorption)
        total = np.broadcast_to(along[:, None], (len(along), len(cosines))).copy()
        for each in self.flakes:
            lost = -each.curves.passed - each.curves.reflected
            lost[:, 0] += 1.0
            total += each.area * (lost @ interception(cosines, each.slope, each.curves.terms).T)
        return total


def find_matter(layer: Layer, wavelengths) -> LayerMatter:
    """Optics of a layer's particles. (w,) [nm]"""
    wavelengths = np.asarray(wavelengths, np.float64)
    index = np.real(layer.binder.index.at(wavelengths)).astype(np.float64)
    shares = volume_fractions(layer)
    binder = 1.0 - sum(shares)
    mean = float(index.mean())
    flakes = tuple(
        FlakeMatter(
            area,
            slope_with_diffraction(
                each.slope, each.diameters.moment_um(1.0) if each.diameters else None, mean
            ),
            find_curves(each, index, wavelengths),
            each,
        )
        for area, each in zip(face_densities(layer), layer.flakes, strict=True)
        if area > 0.0
    )
    pigments = tuple(
        _grains(each, share, index, wavelengths)
        if isinstance(each, Grains)
        else _medium(each, wavelengths)
        for share, each in zip(shares[len(layer.flakes) :], layer.pigments, strict=True)
    )
    absorption = binder * layer.binder.absorption_at(wavelengths)
    return LayerMatter(layer.thickness_um, index, mean, absorption, flakes, pigments)


def _grains(grains: Grains, share: float, index, wavelengths) -> PigmentMatter:
    spheres = scatter_spheres(grains.index.at(wavelengths), grains.diameters, index, wavelengths)
    return PigmentMatter(
        share * spheres.extinction, share * spheres.scattering, _without_tail(spheres.series)
    )


def _medium(medium: Medium, wavelengths) -> PigmentMatter:
    extinction = medium.extinction.at(wavelengths)
    if medium.phase is None:
        g = abs(medium.asymmetry)
        count = 1 if g == 0.0 else int(np.ceil(np.log(SMALLEST_TERM) / np.log(g)))
        series = medium.asymmetry ** np.arange(max(count, 2))
    else:
        cosines, weights = np.polynomial.legendre.leggauss(PHASE_POINTS)
        values = medium.phase.at(np.arccos(cosines))
        values = values / (0.5 * (values * weights).sum())
        legendre = np.polynomial.legendre.legvander(cosines, PHASE_POINTS // 2)
        series = 0.5 * (values * weights) @ legendre
    series = np.broadcast_to(series, (len(extinction), len(series)))
    return PigmentMatter(
        extinction, extinction * medium.albedo.at(wavelengths), _without_tail(series)
    )


def _without_tail(series: np.ndarray) -> np.ndarray:
    is_large = np.abs(series).max(axis=0) > SMALLEST_TERM
    return series[:, : max(2, int(np.flatnonzero(is_large)[-1]) + 1)]


def scattering(matter: LayerMatter, cosines, modes: int) -> tuple[np.ndarray, np.ndarray]:
    """Modes of pi times scattering by length and solid angle.

    Parameters
    ----------
    cosines : (n,) array
    modes : int

    Returns
    -------
    two (w, m, n, n) float64 arrays    Into the other half, and into the same one. [1/um]
    """
    count = len(cosines)
    pairs = np.zeros((len(matter.index), 2, modes, count * (count + 1) // 2))
    for each in matter.flakes:
        unit = scattering_modes(tuple(cosines), each.slope, modes, each.curves.terms)
        made = (each.area * each.curves.reflected) @ unit.reshape(len(unit), -1)
        pairs += made.reshape(pairs.shape)
    for each in matter.pigments:
        own = each.cut(count)
        terms = own.series.shape[1]
        unit = _legendre_modes(tuple(cosines), modes, terms)
        weight = 0.25 * own.scattering[:, None] * own.series * (2 * np.arange(terms) + 1)
        made = weight @ unit.reshape(terms, -1)
        pairs[:, :, : unit.shape[2]] += made.reshape(len(made), *unit.shape[1:])
    place = np.zeros((count, count), np.int64)
    place[np.triu_indices(count)] = np.arange(pairs.shape[-1])
    place = np.maximum(place, place.T)
    return pairs[:, 0][..., place], pairs[:, 1][..., place]


@lru_cache(maxsize=16)
def _legendre_modes(cosines: tuple, modes: int, terms: int) -> np.ndarray:
    """Modes of each P_l of the angle between directions: (l, back and forth, m, pairs)."""
    x = np.array(cosines)
    i, j = np.triu_indices(len(x))
    sine = np.sqrt(1.0 - x**2)
    made = np.zeros((terms, 2, min(modes, terms), len(i)))
    first = np.ones_like(x)
    for m in range(made.shape[2]):
        # Associated functions, normalised so that the addition theorem has no factors.
        before, now = np.zeros_like(x), first
        for degree in range(m, terms):
            product = now[i] * now[j]
            made[degree, 1, m] = product
            made[degree, 0, m] = product if (degree + m) % 2 == 0 else -product
            rise = np.sqrt((degree + 1.0) ** 2 - m**2)
            before, now = (
                now,
                ((2 * degree + 1) * x * now - np.sqrt(float(degree**2 - m**2)) * before) / rise,
            )
        first = first * sine * np.sqrt((2.0 * m + 1.0) / (2.0 * m + 2.0))
    return made
