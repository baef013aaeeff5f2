"""Tables of sky models that ship: the coefficients of Hosek and Wilkie, and a clear atmosphere by wavelength.

``hosek_wilkie_xyz.csv`` has the numbers that Lukas Hosek and Alexander Wilkie published with their model (version 1.4a of
2013, its fit of X, Y and Z) under the licence in ``hosek_wilkie_licence.txt``. ``atmosphere.csv`` has the irradiance by the
sun outside the atmosphere [W/(m2 nm)] and the coefficients of scattering by air at sea level and of absorption by ozone in
the middle of its layer [1/m], with which Blender computes its sky (copyright 2011-2020 Blender Authors, Apache-2.0).
``hosek_wilkie_spectral.csv`` has the model's spectral fit of 2012, as Mitsuba 3.9 ships it for its ``sunsky``, under the
same licence; ``tools.libraries.skies`` makes it.
"""

import csv
from functools import lru_cache
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent

TURBIDITIES, POINTS, NUMBERS = 10, 6, 9
"""Of the table of Hosek and Wilkie: turbidities 1 to 10, control points over the sun's elevation, coefficients."""

WAVELENGTHS = tuple(range(320, 721, 40))
"""Of the spectral model. [nm]"""


@lru_cache
def hosek_wilkie() -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients (3, 2, 10, 6, 9) and radiances (3, 2, 10, 6) of X, Y and Z by albedo, turbidity and point."""
    return _read("hosek_wilkie_xyz.csv", 3)


@lru_cache
def spectral_hosek_wilkie() -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients (11, 2, 10, 6, 9) and radiances (11, 2, 10, 6) [W/(m2 sr nm)] at `WAVELENGTHS`."""
    return _read("hosek_wilkie_spectral.csv", len(WAVELENGTHS))


def _read(name: str, channels: int) -> tuple[np.ndarray, np.ndarray]:
    with (FOLDER / name).open(newline="") as file:
        rows = [row[4:] for row in csv.reader(file)][1:]
    table = np.array(rows, dtype=np.float64).reshape(channels, 2, TURBIDITIES, POINTS, NUMBERS + 1)
    table.flags.writeable = False
    return table[..., :-1], table[..., -1]


@lru_cache
def atmosphere() -> np.ndarray:
    """Return wavelengths [nm], solar irradiance [W/(m2 nm)], scattering by air and absorption by ozone [1/m]. (21, 4)"""
    with (FOLDER / "atmosphere.csv").open(newline="") as file:
        table = np.array(list(csv.reader(file))[1:], dtype=np.float64)
    table.flags.writeable = False
    return table
