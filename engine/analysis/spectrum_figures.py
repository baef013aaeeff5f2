"""What a lighting engineer reads off a spectrum: peak, efficacy, colour; and of a reflectance its luminous mean."""

from dataclasses import dataclass

import numpy as np

from ..photometry.alpha_opic import alpha_opic, equivalent_daylight
from ..photometry.colour import chromaticity
from ..photometry.colour_fidelity import fidelity_and_gamut
from ..photometry.colour_rendering import general_index
from ..photometry.colour_temperature import colour_temperature
from ..photometry.spectra import GRID, efficacy_of_table, illuminant, observer
from ..photometry.units import LUMINOUS_EFFICACY, VISIBLE
from ..scene.spectrum import Tabulated


@dataclass(frozen=True)
class SpectrumFigures:
    """Figures of a table, each None where it has no meaning: of darkness, or of what cannot be seen.

    Parameters
    ----------
    peak, centroid : float or None    Wavelength of the largest value, and mean weighed by the values. [nm]
    ultraviolet, visible, infrared : float or None    Shares of the table's power below, within and above `VISIBLE`. [-]
    efficacy : float    Luminous efficacy of all radiation in the table. [lm/W]
    chromaticity : (float, float) or None    x, y of the light. [-]
    temperature, duv : float or None    See `colour_temperature`. [K], [-]
    reflectance : float or None    As a reflectance: its luminous mean under D65; None of values above 1. [-]
    rendering : float or None    General colour rendering index Ra. [-]
    fidelity, gamut : float or None    Rf and Rg. [-]
    daylight_ratios : (5,) tuple of float or None
        Alpha-opic daylight (D65) efficacy ratios in the order of `alpha_opic.RECEPTORS`: what a lux of the light acts as, in
        lux of D65. [-]
    """

    peak: float | None
    centroid: float | None
    ultraviolet: float | None
    visible: float | None
    infrared: float | None
    efficacy: float
    chromaticity: tuple[float, float] | None
    temperature: float | None
    duv: float | None
    reflectance: float | None
    rendering: float | None
    fidelity: float | None
    gamut: float | None
    daylight_ratios: tuple[float, ...] | None


def find_figures(table: Tabulated) -> SpectrumFigures:
    """Find the figures of a table."""
    nm, values = table.wavelengths, table.values
    seen = np.interp(GRID, nm, values, left=0.0, right=0.0)
    tristimulus = seen @ observer()
    is_visible = tristimulus[1] > 0.0
    shares = _shares(nm, values)
    found = colour_temperature(tristimulus) if is_visible else None
    fidelity = fidelity_and_gamut(seen) if is_visible else None
    return SpectrumFigures(
        peak=float(nm[np.argmax(values)]) if values.any() else None,
        centroid=float((values * nm) @ _weights(nm) / (values @ _weights(nm)))
        if values.any()
        else None,
        ultraviolet=shares[0],
        visible=shares[1],
        infrared=shares[2],
        efficacy=efficacy_of_table(nm, values),
        chromaticity=tuple(map(float, chromaticity(tristimulus))) if is_visible else None,
        temperature=found[0] if found else None,
        duv=found[1] if found else None,
        reflectance=_luminous_mean(table) if values.max() <= 1.0 else None,
        rendering=general_index(seen) if is_visible else None,
        fidelity=fidelity[0] if fidelity else None,
        gamut=fidelity[1] if fidelity else None,
        daylight_ratios=_daylight_ratios(seen, tristimulus[1]) if is_visible else None,
    )


def _weights(nm: np.ndarray) -> np.ndarray:
    """Weights of the values of a table in the integral of its straight lines. [nm]"""
    steps = np.diff(nm)
    return 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))


def _shares(nm: np.ndarray, values: np.ndarray) -> tuple[float | None, float | None, float | None]:
    """Shares of the power below, within and above the visible range."""
    edges = [edge for edge in VISIBLE if nm[0] < edge < nm[-1]]
    finer = np.unique(np.concatenate([nm, edges]))
    power = (
        0.5
        * np.diff(finer)
        * (np.interp(finer[1:], nm, values) + np.interp(finer[:-1], nm, values))
    )
    whole = power.sum()
    if whole <= 0.0:
        return None, None, None
    below, above = finer[1:] <= VISIBLE[0], finer[:-1] >= VISIBLE[1]
    parts = (below, ~below & ~above, above)
    return tuple(float(power[part].sum() / whole) for part in parts)


def _daylight_ratios(power: np.ndarray, luminous: float) -> tuple[float, ...]:
    """Equivalent daylight illuminances of power on `GRID` over its illuminance, which is ``luminous`` in the same unit."""
    return tuple(
        map(float, equivalent_daylight(alpha_opic(power)) / (LUMINOUS_EFFICACY * luminous))
    )


def _luminous_mean(table: Tabulated) -> float:
    weight = illuminant(GRID, "D65") * observer()[:, 1]
    return float(np.interp(GRID, table.wavelengths, table.values) @ weight / weight.sum())
