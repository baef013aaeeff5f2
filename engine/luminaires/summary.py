"""What a lighting engineer reads off a photometric file: fluxes, ratios, peak, beam, flux codes, luminances."""

from dataclasses import dataclass

import numpy as np

from .coordinates import angles, directions
from .distribution import flux, intensity, peak
from .formats.record import LuminaireFile
from .openings import projected_area
from .sections import section, spread
from .zones import flux_within

ZONES = np.deg2rad(np.arange(0.0, 181.0, 10.0))
"""Boundaries of the zones about the vertical. [rad]"""

CODE_ANGLES = np.arccos([0.75, 0.5, 0.25, 0.0])
"""Cones of pi/2, pi, 3 pi/2 and 2 pi sr (41.4, 60, 75.5 and 90 degrees), whose fluxes make up the flux code. [rad]"""

PLANES = (0.0, 90.0)
"""Planes C for which angles of the beam and luminances are given. [degree]"""

GLARE_ANGLES = (65.0, 75.0, 85.0)
"""Gamma at which the average luminance is given. [degree] (EN 12464-1)"""

ROUNDING = 1e-9
"""Share of the flux under which a zone counts as dark."""

BEAM, FIELD = 0.5, 0.1
"""Shares of the largest intensity at the edge of the beam and of the field."""


@dataclass(frozen=True, eq=False)
class Summary:
    """Numbers of a photometric file; None where the file does not say enough, or nothing is emitted.

    Units are those of candelas; of a radiant file lm stands for W and cd for W/sr, see `LuminaireFile.units`.
    Angles C and gamma are the luminaire's own for all photometric types: gamma from its -z, C counter-clockwise from +x.

    Parameters
    ----------
    total_flux : float    Of the distribution, integrated exactly. [lm]
    downward_flux, upward_flux : float    Below and above the horizontal. [lm]
    downward_fraction : float or None    Downward share of the flux (DFF). [-]
    light_output_ratio : float or None    Flux over the rated flux of the lamps; None in absolute photometry. [-]
    efficacy : float or None    Flux over the electrical power. [lm/W]
    peak : float    Largest intensity. [cd]
    peak_direction : (float, float)    C in 0..360 and gamma of the peak, the first of several. [degree]
    peak_angles : (float, float) or None    Of types A and B: horizontal and vertical angle H, V of the peak. [degree]
    beam_angles, field_angles : (float or None, float or None)    Full angle between the outermost directions with 50 %
        (10 %) of the largest intensity in the plane, in the planes C0-C180 and C90-C270; see `sections.spread`. [degree]
    flux_codes : (5,) float64 array    CIE flux code N1 to N5 as shares, 0 to 1: flux within pi/2, pi and 3 pi/2 sr about the
        nadir over the downward flux (0 without any), downward fraction, light output ratio (1 in absolute photometry).
    zonal_flux : (18,) float64 array    In the zones of `ZONES`. [lm]
    luminance : (2, 3) float64 array or None    Average over the opening at `PLANES` by `GLARE_ANGLES`; NaN where the opening
        is seen edge on; None for a point. [cd/m2]

    References
    ----------
    Flux code: CIE 52:1982, EN 13032-2:2017 (CEN flux code).
    """

    total_flux: float
    downward_flux: float
    upward_flux: float
    downward_fraction: float | None
    light_output_ratio: float | None
    efficacy: float | None
    peak: float
    peak_direction: tuple[float, float]
    peak_angles: tuple[float, float] | None
    beam_angles: tuple[float | None, float | None]
    field_angles: tuple[float | None, float | None]
    flux_codes: np.ndarray
    zonal_flux: np.ndarray
    luminance: np.ndarray | None


def summarise(file: LuminaireFile) -> Summary:
    """Return the numbers of a photometric file, without its tilt factor."""
    distribution = file.distribution
    total = flux(distribution)
    cones = flux_within(distribution, np.concatenate([CODE_ANGLES, ZONES[1:-1]]))
    # Rounding must not show as a trace of light where there is none.
    cones = np.where(cones > (1.0 - ROUNDING) * total, total, cones)
    zones = np.diff(np.concatenate([[0.0], cones[4:], [total]]))
    downward = float(cones[3]) if cones[3] > ROUNDING * total else 0.0
    fraction = downward / total if total > 0.0 else None
    ratio = None if file.is_absolute else _over(total, file.stated_flux)
    largest, direction, grid_angles = _peak(file)
    sections = [section(distribution, np.deg2rad(plane)) for plane in PLANES]
    return Summary(
        total_flux=total,
        downward_flux=downward,
        upward_flux=total - downward,
        downward_fraction=fraction,
        light_output_ratio=ratio,
        efficacy=_over(total, file.watts),
        peak=largest,
        peak_direction=direction,
        peak_angles=grid_angles,
        beam_angles=tuple(_degrees(spread(*cut, BEAM)) for cut in sections),
        field_angles=tuple(_degrees(spread(*cut, FIELD)) for cut in sections),
        flux_codes=_flux_codes(cones[:3], downward, fraction, ratio),
        zonal_flux=np.where(zones > ROUNDING * total, zones, 0.0),
        luminance=_luminance(file),
    )


def _over(flux_of_all: float, stated: float | None) -> float | None:
    """Flux over a stated number; None where there is none, or it is so small that the ratio is no number."""
    if not stated or stated < 0.0:
        return None
    with np.errstate(over="ignore"):
        ratio = float(np.divide(flux_of_all, stated))
    return ratio if np.isfinite(ratio) else None


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else float(np.rad2deg(angle))


def _flux_codes(cones, downward, fraction, ratio) -> np.ndarray:
    inner = cones / downward if downward > 0.0 else np.zeros(3)
    return np.array([*inner, fraction or 0.0, 1.0 if ratio is None else ratio])


def _peak(file) -> tuple[float, tuple[float, float], tuple[float, float] | None]:
    """Largest intensity, its C and gamma, and of types A and B its H and V. [cd], [degree]"""
    distribution = file.distribution
    largest, azimuth, polar = peak(distribution)
    around, gamma = np.rad2deg(angles(directions(azimuth, polar, distribution.frame)))
    # Rounding may leave C a hair below 360, or anywhere at a pole, where C has no meaning.
    at_pole = gamma < 1e-9 or gamma > 180.0 - 1e-9
    around = 0.0 if at_pole else round(float(around), 9) % 360.0
    across, along = float(np.rad2deg(azimuth)), float(np.rad2deg(polar)) - 90.0
    grid_angles = {"A": (across, along), "B": (along, across)}.get(file.photometric_type)
    return largest, (around, round(float(gamma), 9)), grid_angles


def _luminance(file) -> np.ndarray | None:
    if file.opening.shape == "point":
        return None
    plane, gamma = np.deg2rad(np.meshgrid(PLANES, GLARE_ANGLES, indexing="ij"))
    towards = directions(plane, gamma)
    area = projected_area(file.opening, towards)
    seen = area > 1e-9 * max(file.opening.size) ** 2
    value = intensity(file.distribution, towards)
    return np.divide(value, area, out=np.full_like(value, np.nan), where=seen)
