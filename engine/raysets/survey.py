"""What a ray file holds as a whole, found in one reading: flux, extents, centroid, spectrum, and what is wrong with it."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..errors import FileFormatError
from ..photometry.spectra import GRID, efficacy_of_table, luminous_efficiency
from ..photometry.units import LUMINOUS_EFFICACY
from ..reading.remarks import Remark
from .reader import Faults, read_rays
from .record import LUMINOUS, RADIANT, RayFile, Rays

FLUX_TOLERANCE = 0.01
"""Relative difference between the sum of the rays and the stated flux that is not worth a remark. [-]"""

EFFICACY_TOLERANCE = 0.1
"""Relative difference between stated lumens and those of the watts by their spectrum that is not worth a remark. [-]"""

UNIT_NAMES = {RADIANT: "W", LUMINOUS: "lm"}


@dataclass(frozen=True, eq=False)
class Survey:
    """A ray file as a whole.

    Parameters
    ----------
    rays : int    Of use.
    weight : float    Sum of theirs.
    factor : float    Flux of a ray with the weight 1, in the file's quantity. [lm or W]
    bounds : (2, 3) float64 array    Lowest and highest starting points. [m]
    centroid : (3,) float64 array    Of the starting points, weighted by flux. [m]
    axis : (3,) float64 array    Mean direction, weighted by flux; its length is below 1 the more, the wider the light goes.
    wavelengths : (2,) or None    Shortest and longest of all rays. [nm]
    spectrum : ((k,), (k,)) arrays or None    Wavelengths [nm] and relative spectral power, where the file knows it.
    luminous_flux, radiant_flux : float or None    Of everything, where it is stated or follows. [lm], [W]
    remarks : tuple of Remark
    """

    rays: int
    weight: float
    factor: float
    bounds: np.ndarray
    centroid: np.ndarray
    axis: np.ndarray
    wavelengths: tuple[float, float] | None
    spectrum: tuple[np.ndarray, np.ndarray] | None
    luminous_flux: float | None
    radiant_flux: float | None
    remarks: tuple[Remark, ...]


def survey_rays(
    file: RayFile,
    progress: Callable[[float], None] | None = None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Survey:
    """Read all rays of a file once. Memory does not depend on their number.

    Raises
    ------
    FileFormatError    No ray carries light, or the file breaks the rules of its format.
    Cancelled
    """
    faults = Faults()
    number, weight = 0, 0.0
    moment, axis = np.zeros(3), np.zeros(3)
    bounds = np.array([[np.inf] * 3, [-np.inf] * 3])
    span = [np.inf, -np.inf]
    by_wavelength = np.zeros(len(GRID))
    by_table = np.zeros(max(len(file.spectra), 1))
    for rays in read_rays(file, faults, progress, cancelled):
        if not len(rays):
            continue
        each = rays.weight.astype(np.float64)
        number += len(rays)
        weight += float(each.sum())
        moment += each @ rays.position
        axis += each @ rays.direction
        bounds[0] = np.minimum(bounds[0], rays.position.min(axis=0))
        bounds[1] = np.maximum(bounds[1], rays.position.max(axis=0))
        if rays.wavelength is not None:
            span = [
                min(span[0], float(rays.wavelength.min())),
                max(span[1], float(rays.wavelength.max())),
            ]
            place = np.round(rays.wavelength - GRID[0]).astype(np.int64)
            seen = (place >= 0) & (place < len(GRID))
            by_wavelength += np.bincount(place[seen], each[seen], len(GRID))
        if rays.spectrum is not None:
            by_table += np.bincount(rays.spectrum, each, len(by_table))
    if number == 0:
        raise FileFormatError(
            file.path, f"none of its {faults.rays} rays carries light, expected one at least"
        )
    factor, told = _scale(file, weight)
    wavelengths = tuple(span) if span[0] <= span[1] else None
    spectrum = _spectrum(file, by_wavelength, by_table)
    luminous, radiant, odd = _fluxes(file, weight * factor, by_wavelength / weight, spectrum)
    return Survey(
        number,
        weight,
        factor,
        bounds,
        moment / weight,
        axis / weight,
        wavelengths,
        spectrum,
        luminous,
        radiant,
        (*file.remarks, *faults.remarks(), *told, *odd),
    )


def _scale(file: RayFile, weight: float) -> tuple[float, tuple[Remark, ...]]:
    """Flux of a ray with the weight 1, and what has to be said of it."""
    stated = file.stated_flux
    unit = UNIT_NAMES[file.quantity]
    if file.is_relative:
        if stated is None:
            raise FileFormatError(
                file.path, "states no flux, which its relative rays need; give the flux yourself"
            )
        return stated / weight, ()
    if stated is None:
        return 1.0, ()
    if abs(weight / stated - 1.0) <= FLUX_TOLERANCE:
        return 1.0, ()
    text = f"its rays sum up to {weight:.6g} {unit}, but it states {stated:.6g} {unit}; they are scaled to that"
    return stated / weight, (Remark(text),)


def _spectrum(file: RayFile, by_wavelength: np.ndarray, by_table: np.ndarray):
    """Wavelengths and relative spectral power of everything; None where the file does not know them."""
    if file.wavelength is not None:
        return np.array([file.wavelength]), np.array([1.0])
    if by_wavelength.any():
        return GRID, by_wavelength / by_wavelength.max()
    if not file.spectra:
        return None
    if len(file.spectra) == 1:
        return file.spectra[0]
    mixed = np.zeros(len(GRID))
    for share, (wavelengths, values) in zip(by_table, file.spectra, strict=True):
        own = np.interp(GRID, wavelengths, values, left=0.0, right=0.0)
        total = own.sum()
        mixed += share / total * own if total > 0.0 else 0.0
    return (GRID, mixed / mixed.max()) if mixed.any() else None


def _fluxes(file: RayFile, flux: float, by_wavelength: np.ndarray, spectrum):
    """Luminous and radiant flux of everything [lm], [W], and what has to be said of them."""
    luminous = flux if file.quantity == LUMINOUS else file.luminous_flux
    radiant = flux if file.quantity == RADIANT else file.radiant_flux
    if spectrum is None or (luminous is None and radiant is None):
        return luminous, radiant, ()
    efficacy = _efficacy(by_wavelength, spectrum)
    if luminous is None:
        return radiant * efficacy, radiant, ()
    if radiant is None:
        return luminous, luminous / efficacy if efficacy > 0.0 else None, ()
    if abs(luminous - radiant * efficacy) <= EFFICACY_TOLERANCE * luminous:
        return luminous, radiant, ()
    text = (
        f"states {luminous:.4g} lm, but its {radiant:.4g} W are {radiant * efficacy:.4g} lm by its own spectrum; "
        "the stated lumens are taken"
    )
    return luminous, radiant, (Remark(text),)


def luminous_rays(file: RayFile, survey: Survey, rays: Rays) -> Rays:
    """Return rays with lumens for weights.

    Raises
    ------
    FileFormatError    They carry watts, and neither they nor the file tell of which wavelengths.
    """
    scale = survey.factor
    if file.quantity == RADIANT:
        if rays.wavelength is not None:
            scale *= LUMINOUS_EFFICACY * np.interp(
                rays.wavelength, GRID, luminous_efficiency(), left=0.0, right=0.0
            )
        elif rays.spectrum is not None:
            scale *= np.array([efficacy_of_table(*table) for table in file.spectra])[rays.spectrum]
        elif survey.luminous_flux is not None:
            scale = survey.luminous_flux / survey.weight
        else:
            raise FileFormatError(
                file.path, "has rays in watts without wavelengths; give the luminous flux yourself"
            )
    return replace(rays, weight=(rays.weight * scale).astype(np.float32))


def hold_luminous(file: RayFile, survey: Survey, held: Rays) -> tuple[Rays, float]:
    """Return held rays with lumens for weights, and the luminous flux of all rays.

    Raises
    ------
    FileFormatError    As of `luminous_rays`, or none of their light is visible.
    """
    held = luminous_rays(file, survey, held)
    if not held.weight.any():
        raise FileFormatError(
            file.path, "has no visible light, expected wavelengths within 360 to 830 nm"
        )
    flux = survey.luminous_flux
    return held, float(held.weight.sum(dtype=np.float64)) if flux is None else flux


def _efficacy(by_wavelength: np.ndarray, spectrum) -> float:
    """Luminous efficacy of radiation. ``by_wavelength``: shares of the whole flux, where rays have wavelengths. [lm/W]"""
    if by_wavelength.any():
        return LUMINOUS_EFFICACY * float(by_wavelength @ luminous_efficiency())
    return efficacy_of_table(*spectrum)
