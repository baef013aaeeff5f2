"""A paint's scattering as the table of a measured material: everything that is done with those is done with paints."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..errors import SceneError
from ..reading.remarks import Remark
from ..scattering.data.record import ScatteringFile
from ..scattering.data.resampling import measure_error
from ..scattering.data.table import albedos_of, direction_of, evaluate_table
from ..scene.scattering import ScatterTable
from .composition import Paint
from .orange_peel import evaluate
from .solution import WAVELENGTHS, Resolution, Solution, solve

PREVIEW, STANDARD, FINE = 3.0, 2.0, 1.0
"""Steps of the angle of incidence for a look, for use, and for measuring. [deg]"""

GRAZING = np.radians([82.0, 84.0, 86.0, 87.5, 88.5, 89.5])
"""Last angles of incidence. [rad]"""

LOBE = 45.0
"""Radial angle up to which the step is even. [deg]"""

BEYOND = (*np.arange(47.5, 90.0, 2.5), *np.arange(90.0, 131.0, 5.0), 140.0, 150.0, 165.0, 180.0)
"""Radial angles farther out, where the horizon cuts through cells. [deg]"""

BEYOND_OF_LOOK = (52.0, 60.0, 75.0, 90.0, 110.0, 130.0, 150.0, 180.0)
"""The same for a look. [deg]"""

STEPS_OF_LOBE = 0.75
"""Step of the radial angle, times the smallest slope, where steps of incidence are those of `FINE`."""

LOWEST = np.cos(np.radians(89.0))
"""Directions below take the value there where a paint is not dark at the horizon."""

LEAST_FACE = 1.2
"""Index from which on a smooth surface lets nothing out towards the horizon."""

RECIPROCAL = 85.0
"""Largest angle to the normal within which reciprocity is told apart. [deg]"""

MOST_CLAMPED, MOST_CHANGE = 1e-4, 0.01
"""Light that may be clamped, and change from a coarser resolution, above which a paint is solved more finely."""

FINER = 1.5
"""Share of directions and modes with which that is."""

COARSER = 0.75
"""Share of directions and modes with which a paint is solved again to see how much they matter."""

PAIRS = 4000
"""Pairs of directions by which that is seen."""

FLOOR = 0.02
"""What is added to values where errors are told relative to them. [1/sr]"""


@dataclass(frozen=True, eq=False)
class Tabulated:
    """A paint's table, and how far it may be trusted.

    Parameters
    ----------
    table : ScatterTable    With the mirror as its direct part, and its error against the solution.
    solution : Solution
    convergence : float
        Root mean square difference from three quarters of the directions and modes, in some bands, relative to the value
        plus `FLOOR`: above the error of the solution itself. [-]
    reciprocity, inner_reciprocity : float
        Largest difference of the table between both ways, by its largest value, anywhere and within `RECIPROCAL`. [-]
    energy : float    Largest share of light that the table reflects. [-]
    clamped : float    As of `Solution`.
    """

    table: ScatterTable
    solution: Solution
    convergence: float
    reciprocity: float
    inner_reciprocity: float
    energy: float
    clamped: float

    def file(self) -> ScatteringFile:
        """The table as a file of ours holds it."""
        paint = self.solution.paint
        size = self.solution.resolution
        remarks = (
            Remark(
                f"computed from its composition with {size.directions} directions and {size.modes} modes; "
                f"{100 * self.convergence:.2g} % off with three quarters of them; table within "
                f"{100 * self.table.error:.2g} % of it"
            ),
            Remark(
                "light reflected by more than one flake counts without polarisation; flakes have no size"
            ),
        )
        return ScatteringFile(
            Path(f"{paint.name}.lumbsdf"),
            "Lumenray scattering",
            {"front_reflection": self.table},
            paint.name,
            paint.description,
            paint.source,
            self.table.incidences,
            remarks=remarks,
        )


def tabulate(solution: Solution, step: float = STANDARD) -> ScatterTable:
    """Table of a solution; its error is not measured. Steps of the angle of incidence in degrees."""
    incidences, radials, azimuths = axes_of(solution, step)
    i, t, a = np.meshgrid(incidences, radials, azimuths, indexing="ij")
    wo = direction_of(i, t, a).reshape(-1, 3)
    if solution.paint.orange_peel or solution.layers[0].index.min() < LEAST_FACE:
        low = wo[:, 2] < LOWEST
        level = np.hypot(wo[:, 0], wo[:, 1])
        scale = np.sqrt(1.0 - LOWEST**2) / np.maximum(level, 1e-12)
        wo[low, :2] *= scale[low, None]
        wo[low, 2] = LOWEST
    wi = np.stack([np.sin(i), np.zeros_like(i), np.cos(i)], axis=-1).reshape(-1, 3)
    values = evaluate(solution, wi, wo).reshape(1, *i.shape, -1).astype(np.float32)
    direct = None
    if not solution.paint.orange_peel:
        direct = solution.mirror(np.sin(incidences))[None].astype(np.float32)
    table = ScatterTable(
        np.zeros(1), incidences, radials, azimuths, solution.wavelengths, values, direct
    )
    # A chord lies above a lobe's flanks; no more may come than went.
    total = albedos_of(table, incidences, [0.0])[0] + (direct[0] if direct is not None else 0.0)
    excess = np.maximum(total, 1.0)
    if excess.max() > 1.0:
        table = replace(table, values=table.values / excess[None, :, None, None].astype(np.float32))
    return table


def axes_of(solution: Solution, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angles of incidence, radial angles and azimuths of a paint's table. [rad]"""
    slopes = [flakes.slope for layer in solution.layers for flakes in layer.flakes]
    smallest = np.degrees(min(slopes)) if slopes else 5.0
    radial = step * np.clip(STEPS_OF_LOBE * 0.5 * smallest, 0.25, 1.5)
    even = np.arange(0.0, LOBE, min(radial, 3.0))
    fine = np.array([])
    if solution.paint.orange_peel:
        fine = (
            2.0
            * np.degrees(solution.paint.orange_peel)
            * np.array([0.0, 0.5, 1, 1.5, 2, 2.5, 3, 4])
        )
    beyond = BEYOND_OF_LOOK if step >= PREVIEW else BEYOND
    radials = np.unique(np.round(np.concatenate([even, fine[fine < LOBE], beyond]), 4))
    incidences = np.concatenate([np.radians(np.arange(0.0, 81.0, step)), GRAZING])
    return (
        incidences,
        np.radians(radials),
        np.linspace(0.0, np.pi, 9 if step >= PREVIEW else 25),
    )


def compute(
    paint: Paint,
    wavelengths=WAVELENGTHS,
    step: float = STANDARD,
    report: Callable[[float], None] = lambda share: None,
    **options,
) -> Tabulated:
    """Solve a paint, make its table, and measure how good both are.

    Parameters
    ----------
    step : float    Of the angle of incidence. [deg]
    report : callable    Told from time to time which share of the work is done; what it raises ends it.
    options : dict    As of `solve`.

    Raises
    ------
    SceneError    As of `solve`.
    """
    solution = solve(paint, wavelengths, **options)
    report(0.2)
    convergence = measure_convergence(solution)
    report(0.3)
    if "resolution" not in options and (
        solution.clamped > MOST_CLAMPED or convergence > MOST_CHANGE
    ):
        size = solution.resolution
        finer = Resolution(2 * int(0.5 * FINER * size.directions), int(FINER * size.modes))
        solution = solve(paint, wavelengths, resolution=finer, **options)
        convergence = measure_convergence(solution)
    if solution.clamped > MOST_CLAMPED:
        raise SceneError(
            f"'{paint.name}' cannot be resolved: {100 * solution.clamped:.2g} % of the light would be negative, expected "
            f"{100 * MOST_CLAMPED:g} % at most; let its flakes tilt more, or its binders differ less"
        )
    table = tabulate(solution, step)
    report(0.7)

    def read(wi, wo):
        return evaluate_table(table, wi, wo)

    largest = float(solution.albedo(np.sin(table.incidences)).max())
    error = measure_error(lambda wi, wo: evaluate(solution, wi, wo), read, max(largest, 1e-6))
    table = replace(table, error=error)
    report(0.9)
    rng = np.random.default_rng(1)
    wi, wo = (random_directions(rng, PAIRS) for _ in range(2))
    there, back = read(wi, wo), read(wo, wi)
    away = np.abs(there - back).max(axis=1) / max(there.max(), 1e-12)
    is_inner = np.minimum(wi[:, 2], wo[:, 2]) > np.cos(np.radians(RECIPROCAL))
    total = albedos_of(table, table.incidences, [0.0])[0]
    if table.direct is not None:
        total = total + table.direct[0]
    return Tabulated(
        table,
        solution,
        convergence,
        float(away.max()),
        float(away[is_inner].max()),
        float(total.max()),
        solution.clamped,
    )


def measure_convergence(solution: Solution) -> float:
    """Difference of a solution from a coarser one, as of `Tabulated`. [-]"""
    bands = np.unique(np.linspace(0, len(solution.wavelengths) - 1, 3).round().astype(int))
    size = solution.resolution
    coarse = Resolution(
        max(4, 2 * int(0.5 * COARSER * size.directions)), max(2, int(COARSER * size.modes))
    )
    other = solve(
        solution.paint,
        solution.wavelengths[bands],
        resolution=coarse,
        is_polarised=solution.is_polarised,
    )
    rng = np.random.default_rng(2)
    wi, wo = (random_directions(rng, PAIRS) for _ in range(2))
    # Half of the pairs about the mirror's direction, where the lobe is.
    near = slice(None, PAIRS // 2)
    wo[near] = wi[near] * [-1.0, -1.0, 1.0] + 0.2 * rng.normal(size=(PAIRS // 2, 3))
    wo[:, 2] = np.abs(wo[:, 2])
    wo /= np.linalg.norm(wo, axis=1, keepdims=True)
    one, two = solution.evaluate(wi, wo)[:, bands], other.evaluate(wi, wo)
    return float(np.sqrt((((one - two) / (one + FLOOR)) ** 2).mean()))


def random_directions(rng, count: int) -> np.ndarray:
    """Directions of light from everywhere onto a surface. (n, 3)"""
    cosine, azimuth = np.sqrt(1.0 - rng.random(count)), 2.0 * np.pi * rng.random(count)
    sine = np.sqrt(1.0 - cosine**2)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine], axis=1)
