"""Prints of more and more pigment: waves beside radiative transfer, sphere by sphere, and beside Kubelka and Munk.

Light passes between layer and substrate without a face, so that nothing but the layer's own model differs.

References
----------
P. Kubelka, F. Munk: Ein Beitrag zur Optik der Farbanstriche, Z. techn. Phys. 12, 1931, 593-601. J. L. Saunderson:
Calculation of the color of pigmented plastics, J. Opt. Soc. Am. 32, 1942, 727-736 (faces).
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ...engine.ink.composition import Ink
from ...engine.ink.computed import INCIDENCE, compute
from ...engine.ink.plan import make_plan
from ...engine.ink.reader import parse_ink
from ...engine.ink.scalar_sphere import partial_waves
from ...engine.paint.fresnel import face_reflectance
from ...engine.paint.reader import parse_paint
from ...engine.paint.readings import reflectances
from ...engine.paint.solution import Resolution, solve
from ...libraries import inks
from ...libraries.plain_files import read_object

REALISATIONS = 4

NORMAL = (45.0,)
"""Aspecular angle of the normal, of light at 45 degrees. [deg]"""

WRONG = 0.01
"""Difference of reflectances from which models are said to be apart, besides two standard errors. [-]"""

RESOLUTION = Resolution(16, 4)
"""Of radiative transfer: spheres as small as these have no sharp lobes."""

LARGEST_FILE = 1 << 20


@dataclass(frozen=True)
class Series:
    """One pigment in several amounts.

    Parameters
    ----------
    pigment : str
    index : object    As descriptions have it.
    binder : float    Index.
    diameter : float    [um]
    substrate : float    Reflectance.
    wavelengths : tuple of float    [nm]
    shares : tuple of float    Of the layer's volume.
    """

    pigment: str
    index: object
    binder: float
    diameter: float
    substrate: float
    wavelengths: tuple[float, ...]
    shares: tuple[float, ...]


def list_series() -> tuple[Series, ...]:
    """Give what is measured."""
    (cyan,) = read_object(inks.presets()["cyan_medium"], LARGEST_FILE)["pigments"]
    amounts = (0.02, 0.05, 0.1, 0.2, 0.3, 0.45)
    bands = (450.0, 550.0, 650.0)
    return (Series("cyan 0.2 um", cyan["index"], 1.558, 0.2, 0.9, bands, amounts),)


def measure_series(say) -> list[dict]:
    """Solve layers of a micrometre in all amounts, by waves and by the others."""
    rows = []
    for series in list_series():
        made = []
        for share in series.shares:
            say(f"{series.pigment} {100 * share:g} %")
            made.append(_solve(series, share))
        for band, wavelength in enumerate(series.wavelengths):
            waves = [each.readings[band] for each in made]
            munk = _calibrate_munk(series, band, waves[0])
            for share, each in zip(series.shares, made, strict=True):
                rows.append(
                    {
                        "pigment": series.pigment,
                        "wavelength_nm": wavelength,
                        "share": share,
                        "waves": each.readings[band],
                        "standard_error": each.standard_errors[band],
                        "grid_error": each.grid_error,
                        "transfer": _transfer(series, band, _one_by_one(series, share, band)),
                        "transfer_mie": _transfer(series, band, _grains(series, share)),
                        "kubelka_munk": munk(share),
                    }
                )
    return rows


def find_departures(rows) -> list[dict]:
    """Tell for each pigment and wavelength at which amounts each model is apart from waves.

    A difference counts from `WRONG`, or the grid's error if that is more, and two standard errors on.
    """
    found = []
    for pigment, nm in dict.fromkeys((row["pigment"], row["wavelength_nm"]) for row in rows):
        own = [row for row in rows if (row["pigment"], row["wavelength_nm"]) == (pigment, nm)]
        entry = {"pigment": pigment, "wavelength_nm": nm}
        for name in ("transfer", "transfer_mie", "kubelka_munk"):
            entry[name] = [
                row["share"]
                for row in own
                if abs(row[name] - row["waves"])
                > max(WRONG, row["grid_error"]) + 2.0 * row["standard_error"]
            ]
        found.append(entry)
    return found


def munk_reflectance(absorption, scattering, thickness, substrate, index) -> float:
    """Reflectance factor at 45:0 of a layer by Kubelka and Munk, under a face by Saunderson.

    Parameters
    ----------
    absorption, scattering : float    K and S. [1/um]
    thickness : float    [um]
    substrate : float    Reflectance, from within the layer.
    index : float    Of the binder.
    """
    if scattering * thickness < 1e-12:
        within = substrate * np.exp(-2.0 * absorption * thickness)
    else:
        a = 1.0 + absorption / scattering
        b = np.sqrt(max(a * a - 1.0, 1e-16))
        turn = b / np.tanh(b * scattering * thickness)
        within = (1.0 - substrate * (a - turn)) / (a - substrate + turn)
    back = _face_from_within(index)
    sines = np.sin(np.radians([INCIDENCE, 0.0]))
    enter, leave = 1.0 - face_reflectance(sines, 1.0, index)
    return float(enter * leave / index**2 * within / (1.0 - back * within))


@lru_cache
def _face_from_within(index: float) -> float:
    """Reflectance of the face for diffuse light from within, of which the squared sine is even."""
    nodes, weights = np.polynomial.legendre.leggauss(400)
    sines = index * np.sqrt(0.5 * (nodes + 1.0))
    return float(0.5 * weights @ face_reflectance(sines, 1.0, index))


def _ink(series: Series, share: float) -> Ink:
    return parse_ink(
        {
            "lumenray_ink": 1,
            "name": series.pigment,
            "thickness_um": 1.0,
            "binder": {"index": series.binder},
            "pigments": [
                {
                    "index": series.index,
                    "volume_fraction": share,
                    "median_um": series.diameter,
                }
            ],
            "substrate": {"reflectance": series.substrate, "contact_index": series.binder},
        }
    )


def _solve(series: Series, share: float):
    ink = _ink(series, share)
    plan = make_plan(ink, draft=True, realisations=REALISATIONS)
    return compute(ink, replace(plan, wavelengths=series.wavelengths))


def _spheres(series: Series) -> list[tuple[float, float, float]]:
    """Extinction and scattering by volume of spheres, and the mean cosine, by the scalar equation. [1/um], [1/um], [-]"""
    found = []
    (pigment,) = _ink(series, series.shares[0]).pigments
    for nm in series.wavelengths:
        parameter = np.pi * series.diameter * series.binder / (1e-3 * nm)
        waves = partial_waves(parameter, complex(pigment.index.at([nm])[0]) / series.binder)
        order = np.arange(len(waves))
        power = float((2.0 * order + 1.0) @ np.abs(waves) ** 2)
        pairs = float((order[1:]) @ (waves[:-1] * waves[1:].conj()).real)
        # Q face / volume = 3/2 Q / d.
        scale = 1.5 / series.diameter * 4.0 / parameter**2
        extinction = -scale * float((2.0 * order + 1.0) @ waves.real)
        found.append((extinction, scale * power, 2.0 * pairs / power))
    return found


def _calibrate_munk(series: Series, band: int, weakest: float):
    """Reflectance over the amount, K and S by one factor so that the weakest print is that of waves."""
    extinction, scattering, cosine = _spheres(series)[band]

    def reflect(amount: float) -> float:
        return munk_reflectance(
            2.0 * (extinction - scattering) * amount,
            0.75 * scattering * (1.0 - cosine) * amount,
            1.0,
            series.substrate,
            series.binder,
        )

    factors = np.geomspace(0.05, 20.0, 2001)
    errors = [abs(reflect(each * series.shares[0]) - weakest) for each in factors]
    factor = float(factors[int(np.argmin(errors))])
    return lambda share: reflect(factor * share)


def _one_by_one(series: Series, share: float, band: int) -> dict:
    extinction, scattering, cosine = _spheres(series)[band]
    return {
        "medium": {
            "extinction_per_um": share * extinction,
            "albedo": min(scattering / extinction, 1.0),
            "asymmetry": cosine,
        }
    }


def _grains(series: Series, share: float) -> dict:
    return {
        "grains": {"index": series.index, "diameter": {"median_um": series.diameter}},
        "amount": {"volume_fraction": share},
    }


def _transfer(series: Series, band: int, pigment: dict) -> float:
    """Reflectance factor at 45:0 by adding and doubling."""
    layer = {"thickness_um": 1.0, "binder": {"index": series.binder}, "pigments": [pigment]}
    content = {
        "lumenray_paint": 1,
        "name": series.pigment,
        "layers": [layer],
        "substrate": {"reflectance": series.substrate},
    }
    solution = solve(
        parse_paint(content), series.wavelengths[band : band + 1], resolution=RESOLUTION
    )
    return float(reflectances(solution, NORMAL)[0, 0])
