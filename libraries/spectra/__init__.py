"""Spectral tables that ship: CIE observers, illuminants, daylight, actions on the eye, test colours; metals' names."""

import csv
from functools import lru_cache
from pathlib import Path

from ...imports import loaded_when_used

with loaded_when_used():
    import numpy as np

FOLDER = Path(__file__).parent

ANALYTIC_ILLUMINANTS = ("A", "D50", "D55", "D65", "D75")
"""Illuminants defined by a formula rather than a table (CIE 15:2018, 3.1)."""

METALS = ("Ag", "Al", "Au", "Cr", "Cu", "Hg", "Ir", "Li", "Mo", "Ni_palik", "Rh", "Ta", "W")
"""Metals whose complex refractive index comes with Mitsuba."""


@lru_cache
def _table(name: str) -> "tuple[tuple[str, ...], np.ndarray]":
    with (FOLDER / name).open(newline="") as file:
        header, *rows = csv.reader(file)
    return tuple(header), np.array(rows, dtype=np.float64)


def observer() -> "tuple[np.ndarray, np.ndarray]":
    """Return wavelengths (471,) [nm] and colour-matching functions (471, 3) of the CIE 1931 2-degree observer. [-]"""
    _, rows = _table("observer_1931.csv")
    return rows[:, 0], rows[:, 1:]


def daylight_components() -> "tuple[np.ndarray, np.ndarray]":
    """Return wavelengths (n,) [nm] and the components S0, S1, S2 (n, 3) of CIE daylight."""
    _, rows = _table("daylight_components.csv")
    return rows[:, 0], rows[:, 1:]


def illuminant_names() -> tuple[str, ...]:
    """Return the names of all illuminants that `engine.scene.spectrum.Illuminant` may have."""
    # By the first line alone: Blender asks for names when the extension is enabled.
    with (FOLDER / "illuminants.csv").open(newline="") as file:
        header = next(csv.reader(file))
    return (*ANALYTIC_ILLUMINANTS, *header[1:])


def tabulated_illuminant(name: str) -> "tuple[np.ndarray, np.ndarray]":
    """Return wavelengths (n,) [nm] and relative power (n,) of a tabulated illuminant.

    Raises
    ------
    KeyError    The name is not in the table.
    """
    header, rows = _table("illuminants.csv")
    if name not in header[1:]:
        raise KeyError(name)
    return rows[:, 0], rows[:, header.index(name)]


def conductor_names() -> tuple[str, ...]:
    """Return the names of the metals."""
    return METALS


def observer_1964() -> "tuple[np.ndarray, np.ndarray]":
    """Return wavelengths (471,) [nm] and colour-matching functions (471, 3) of the CIE 1964 10-degree observer. [-]"""
    _, rows = _table("observer_1964.csv")
    return rows[:, 0], rows[:, 1:]


def action_spectra() -> "tuple[tuple[str, ...], np.ndarray, np.ndarray]":
    """Return names, wavelengths (401,) [nm] and the alpha-opic action spectra (401, 5) of CIE S 026:2018. [-]"""
    header, rows = _table("alpha_opic.csv")
    return header[1:], rows[:, 0], rows[:, 1:]


def colour_samples(year: int) -> "tuple[np.ndarray, np.ndarray]":
    """Return wavelengths (n,) [nm] and spectral radiance factors (n, samples) of test colours. [-]

    Parameters
    ----------
    year : int    1995: the 14 of CIE 13.3; 2017: the 99 of CIE 224 and ANSI/IES TM-30.
    """
    _, rows = _table(f"colour_samples_{year}.csv")
    return rows[:, 0], rows[:, 1:]
