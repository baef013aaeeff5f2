"""What the spectra at sensors say of colour: temperature, rendering, fidelity."""

from dataclasses import dataclass

import numpy as np

from ..photometry.alpha_opic import RECEPTORS
from ..photometry.colour_fidelity import fidelity_and_gamut
from ..photometry.colour_rendering import general_index
from ..photometry.colour_temperature import colour_temperature
from ..photometry.spectra import GRID, observer

DRAWS = 64
"""Spectra that are drawn to tell what noise does to an index."""


@dataclass(frozen=True, eq=False)
class SensorColours:
    """Figures of the light at sensors, NaN where one has no meaning.

    Parameters
    ----------
    temperature, duv : (n,) float64    Correlated colour temperature [K] and distance from the Planckian locus. [-]
    rendering, fidelity, gamut : (n,) float64    Ra, Rf and Rg. [-]
    """

    temperature: np.ndarray
    duv: np.ndarray
    rendering: np.ndarray
    fidelity: np.ndarray
    gamut: np.ndarray


def find_colours(edges: np.ndarray, bands: np.ndarray) -> SensorColours:
    """Find the figures of spectra in bands.

    Parameters
    ----------
    edges : (b + 1,) array    [nm]
    bands : (n, b) array    Mean spectral irradiance. [W/(m2 nm)]

    Notes
    -----
    Within a band the spectrum is taken for even, as that of a spectroradiometer with as wide a band. Noise of single bands
    lowers Ra and Rf a little.
    """
    rows = np.full((len(bands), 5), np.nan)
    for row, power in zip(rows, _on_grid(edges, bands), strict=True):
        white = power @ observer()
        found = colour_temperature(white) if white[1] > 0.0 else None
        if found is not None:
            row[:] = (*found, general_index(power), *fidelity_and_gamut(power))
    return SensorColours(*rows.T)


def tell_columns(spectra) -> dict[str, np.ndarray]:
    """Action on the eye and colour of the light at sensors, by names with units as tables have them. (n,) each

    ``spectra``: `measurements.SensorSpectra`.
    """
    columns = {}
    for number in reversed(range(len(RECEPTORS))):
        name = f"{RECEPTORS[number]}_edi"
        columns[f"{name}_lx"] = spectra.equivalent_daylight[:, number]
        columns[f"{name}_error_lx"] = spectra.equivalent_daylight_error[:, number]
    found = find_colours(spectra.edges, spectra.bands)
    return columns | {
        "cct_k": found.temperature,
        "duv": found.duv,
        "ra": found.rendering,
        "rf": found.fidelity,
        "rg": found.gamut,
    }


def rendering_range(edges, bands, errors, reach: float) -> tuple[float, float, float] | None:
    """General colour rendering index of a spectrum in noisy bands, and the range that holds that of the true one.

    Parameters
    ----------
    edges : (b + 1,) array    [nm]
    bands, errors : (b,) array    Mean spectral irradiance and its standard errors. [W/(m2 nm)]
    reach : float    Half width of the range, in standard errors. [-]

    Returns
    -------
    (float, float, float) or None    Value, low and high; None where the light has no colour temperature. [-]

    Notes
    -----
    Errors of bands are taken for independent, which makes them change the colour most. As noise lowers the index, the range
    reaches higher by what as much noise again lowers it.
    """
    value = general_index(_on_grid(edges, bands[None])[0])
    if value is None:
        return None
    draws = bands + errors * np.random.default_rng(0).standard_normal((DRAWS, len(bands)))
    made = [general_index(each) for each in _on_grid(edges, draws)]
    made = np.array([each for each in made if each is not None])
    if len(made) < DRAWS:
        return value, -np.inf, 100.0
    half = reach * float(made.std(ddof=1))
    lowered = max(value - float(made.mean()), 0.0)
    return value, value - half, min(value + half + lowered, 100.0)


def _on_grid(edges: np.ndarray, bands: np.ndarray) -> np.ndarray:
    """Power on `GRID` of spectra in bands, none below 0. (n, 471)"""
    band = np.clip(np.searchsorted(edges, GRID, side="right") - 1, 0, bands.shape[1] - 1)
    inside = (edges[0] <= GRID) & (edges[-1] >= GRID)
    return np.where(inside, np.maximum(bands, 0.0)[:, band], 0.0)
