"""From the description of a pigment layer to its table, its colours, and how far they may be trusted."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..paint.composition import Diameters
from ..paint.mie import scatter_spheres
from ..photometry.colour import cie_lab
from ..reading.remarks import Remark
from ..scattering.data.record import ScatteringFile
from ..scattering.data.resampling import resample
from ..scattering.data.tristimulus import tristimulus, weights_of
from ..scene.scattering import ScatterTable
from .composition import Ink
from .crew import run_tasks
from .ensemble import Ensemble, Progress, probed_bands, solve_ensemble
from .film import analyse
from .plan import Plan, make_plan
from .printed import Printed
from .scalar_sphere import scalar_efficiencies

ILLUMINANT = "D50"
"""Of the colours of prints, with the observer of 2 degrees (ISO 13655)."""

INCIDENCE = 45.0
"""Angle of the light of their readings, seen along the normal. [deg]"""

_DIRECTIONS = (
    np.array([[np.sin(np.radians(INCIDENCE)), 0.0, np.cos(np.radians(INCIDENCE))]]),
    np.array([[0.0, 0.0, 1.0]]),
)

TOLERANCE = 0.02
"""Wanted error of a table."""

VALIDITY = 0.55
"""Wavelength at which the scalar equation is held against Mie's series. [um]"""


@dataclass(frozen=True, eq=False)
class Computed:
    """What a pigment layer on its substrate comes to.

    Parameters
    ----------
    printed : Printed
    plan : Plan
    readings : (w,) float64 array    Reflectance factors, light at 45 degrees, seen along the normal. [-]
    standard_errors : (w,) float64 array    Of them, by even and odd realisations or by the speckle in all of them, whichever
        is more; of all bands together in root mean square the error is better known than of one. [-]
    grid_error : float
        Largest change of what the film reflects and lets pass that the grid's step is thought to make, by the grid of twice
        the step: a third of the difference, as errors go with its square. [-]
    lab : (3,) float64 array    L*, a*, b* under D50, 2 degrees.
    lab_error : float    Standard error as a colour difference, by the same two.
    scalar_ratios : dict of str to float    Scattering cross section by Maxwell's over that by the scalar equation, a ball
        of each pigment alone at 550 nm. [-]
    iterations : float    Mean for each solve.
    solved : int    Units that were solved now; others were kept from before.
    """

    printed: Printed
    plan: Plan
    readings: np.ndarray
    standard_errors: np.ndarray
    grid_error: float
    lab: np.ndarray
    lab_error: float
    scalar_ratios: dict[str, float]
    iterations: float
    solved: int

    @property
    def error(self) -> float:
        """Standard error of the readings, root mean square over bands, relative to their mean. [-]"""
        mean = max(float(self.readings.mean()), 1e-9)
        return float(np.sqrt((self.standard_errors**2).mean())) / mean

    def table(self) -> ScatterTable:
        """Its scattering as a table, with the mirror as its direct part."""
        wavelengths = self.printed.wavelengths
        made = resample(self.printed.evaluate, wavelengths, tolerance=TOLERANCE)
        mirror = self.printed.mirror(np.sin(made.incidences))
        direct = np.stack([np.interp(made.wavelengths, wavelengths, row) for row in mirror]).astype(
            np.float32
        )
        return replace(made, direct=np.clip(direct, 0.0, 1.0)[None])

    def file(self, table: ScatterTable) -> ScatteringFile:
        """The table as a file of ours holds it."""
        ink = self.printed.ink
        return ScatteringFile(
            Path(f"{ink.name}.lumbsdf"),
            "Lumenray scattering",
            {"front_reflection": table},
            ink.name,
            ink.description,
            ink.source,
            table.incidences,
            remarks=tuple(Remark(text) for text in self.notes()),
        )

    def notes(self) -> list[str]:
        """What the numbers leave out or assume."""
        plan, ink = self.plan, self.printed.ink
        said = [
            f"mean of {plan.realisations} realisations of a cell of {plan.width:g} um on a grid of {plan.columns} x "
            f"{plan.columns} x {plan.layers}, seed {plan.seed}: 45:0 reflectance within {100 * self.error:.2g} % "
            f"(standard error), colour within {self.lab_error:.2g}; the grid's step may change totals by "
            f"{self.grid_error:.2g}",
            "the wave equation is scalar: coherent light is corrected for both polarisations, scattered light is not",
        ]
        for name, ratio in self.scalar_ratios.items():
            said.append(
                f"{name}: a ball alone scatters {ratio:.2f} times what the scalar equation has (Mie, 550 nm)"
            )
        if ink.relief:
            said.append("particles are cut where the upper face is low, and lack where it is high")
        if isinstance(ink.substrate, ScatterTable):
            said.append(
                "light that is scattered between film and substrate follows a table of few azimuthal modes"
            )
        return said


def compute(
    ink: Ink,
    plan: Plan | None = None,
    folder: Path | None = None,
    processes: int = 1,
    report: Callable[[Progress], None] = lambda progress: None,
    do_tasks: Callable = run_tasks,
) -> Computed:
    """Solve a pigment layer, or take what was solved before; parameters as of `make_plan` and `solve_ensemble`.

    Raises
    ------
    SceneError, EngineLost, FileFormatError    As of `make_plan` and `solve_ensemble`.
    """
    plan = plan or make_plan(ink)
    ensemble = solve_ensemble(ink, plan, folder, processes, report, do_tasks)
    runs = range(plan.realisations)
    whole, even, odd = (
        Printed(ink, plan.wavelengths, analyse(ink, plan, ensemble, part), plan.realisations)
        for part in (runs, runs[::2], runs[1::2])
    )
    readings = [read_45_0(each) for each in (whole, even, odd)]
    labs = [lab_of(each, plan.wavelengths) for each in readings]
    speckle = speckle_of_45_0(whole)
    return Computed(
        whole,
        plan,
        readings[0],
        np.maximum(0.5 * np.abs(readings[1] - readings[2]), speckle),
        _grid_error(ensemble, plan),
        labs[0],
        max(
            0.5 * float(np.linalg.norm(labs[1] - labs[2])),
            _lab_error(readings[0], speckle, plan.wavelengths),
        ),
        _scalar_ratios(ink),
        float(np.mean([unit["iterations"].mean() for unit in ensemble.units.values()])),
        ensemble.solved,
    )


def read_45_0(printed: Printed) -> np.ndarray:
    """Reflectance factors of light at 45 degrees, seen along the normal. (w,)"""
    return np.pi * printed.evaluate(*_DIRECTIONS)[0]


def speckle_of_45_0(printed: Printed) -> np.ndarray:
    """Standard errors of these by the speckle of the film. (w,)"""
    return np.pi * printed.evaluate_error(*_DIRECTIONS)[0]


def _lab_error(readings, errors, wavelengths) -> float:
    """Standard error of a colour by those of its bands, each for itself."""
    square = 0.0
    for band, error in enumerate(errors):
        if error == 0.0:
            continue
        high, low = readings.copy(), readings.copy()
        # Nothing reflects less than nothing, so the slope may be one-sided.
        high[band], low[band] = readings[band] + error, max(readings[band] - error, 0.0)
        change = lab_of(high, wavelengths) - lab_of(low, wavelengths)
        square += float(((change * error / (high[band] - low[band])) ** 2).sum())
    return float(np.sqrt(square))


def lab_of(reflectances, wavelengths) -> np.ndarray:
    """L*, a*, b* under D50 for the observer of 2 degrees. (..., w) -> (..., 3)"""
    white = weights_of(wavelengths, ILLUMINANT).sum(axis=0)
    return cie_lab(tristimulus(reflectances, wavelengths, ILLUMINANT), white)


def further_realisations(made: Computed, wanted: float) -> int:
    """Realisations in all that a relative standard error takes, which falls with the square root of their number; even."""
    count = made.plan.realisations * max((made.error / wanted) ** 2, 1.0)
    return 2 * int(np.ceil(0.5 * min(count, 1e6)))


def _grid_error(ensemble: Ensemble, plan: Plan) -> float:
    changes = [0.0]
    for band in probed_bands(plan) if ensemble.coarse else []:
        fine, coarse = ensemble.units[0, band], ensemble.coarse[band]
        for name in fine:
            if name == "iterations":
                continue
            # Orders are the same on both grids, but for their order.
            for part in (slice(0, 1), slice(1, None)):
                changes.append(abs(fine[name][part, 2].sum() - coarse[name][part, 2].sum()) / 3.0)
    return float(max(changes))


def _scalar_ratios(ink: Ink) -> dict[str, float]:
    found = {}
    nanometres = 1e3 * VALIDITY
    binder = np.sqrt(ink.matrix(nanometres)).real
    for number, each in enumerate(ink.particles):
        diameter = each.population.diameter
        index = complex(each.index.at([nanometres])[0])
        size = np.pi * diameter * binder / VALIDITY
        scattered = scalar_efficiencies(size, index / binder)[1]
        sphere = scatter_spheres([index], Diameters(diameter), np.array([binder]), [nanometres])
        # A cross section by volume, over the face's: Q = 2/3 d sigma.
        vector = float(sphere.scattering[0]) * diameter * 2.0 / 3.0
        name = each.name or f"pigment {number + 1}"
        found[name] = vector / scattered if scattered > 0.0 else 1.0
    return found
