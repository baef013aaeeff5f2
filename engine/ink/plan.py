"""How a pigment layer is solved: the cell, its grid, bands, angles, and what memory that takes; said before it is done."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..errors import SceneError
from .composition import Ink
from .packing import count_spheres
from .relief import CREST
from .voxels import SAMPLES, SLAB
from .waves import kept_directions

FIRST, LAST = 390.0, 710.0
"""Bands, which begin and end here. [nm]"""

STEP = 20.0
"""From band to band where the description does not say. [nm]"""

STEPS_PER_DIAMETER = 3.0
"""Of the grid sideways; along the depth it is 4/3 as fine."""

STEPS_PER_WAVE = 7.0
"""Least steps of the shortest wave in the densest matter, sideways; along the depth 4/3 as many."""

FINER_DOWN = 4.0 / 3.0

NARROWEST, DIAMETERS = 2.0, 6.0
"""Least width of the cell, and over the largest diameter. [um], [-]"""

REALISATIONS, INCIDENCES = 4, 5

TOLERANCE, DRAFT_TOLERANCE = 1e-4, 1e-3
"""Residuals; a draft's is still far below what its few realisations differ by."""

LOWEST, HIGHEST = 6.0, 77.0
"""First and last angle of incidence; the normal itself is the one that all modes of the cell share. [deg]"""

MOST_MEMORY = 8 << 30
"""Of one process. [byte]"""

BASE_MEMORY = 60 << 20
"""Of a process that does nothing yet. [byte]"""

MOST_CELLS = 1 << 27

FIELDS = 12
"""Complex numbers for each cell of the grid while waves are solved, beside the directions that are kept."""

SPHERE_MEMORY = 3000
"""While particles push each other. [byte]"""


@dataclass(frozen=True)
class Plan:
    """What is solved.

    Parameters
    ----------
    width : float    Of the cell. [um]
    columns, layers : int    Of the grid sideways, each way, and along the depth.
    wavelengths : tuple of float    [nm]
    sines : tuple of float    Of the angles of incidence in air or, from below, over the index there.
    realisations : int    Even; each has particles of its own.
    tolerance : float    Of the equation's residual.
    seed : int
    """

    width: float
    columns: int
    layers: int
    wavelengths: tuple[float, ...]
    sines: tuple[float, ...]
    realisations: int
    tolerance: float
    seed: int

    def halved(self) -> Plan:
        """The same on a grid of twice the step."""
        return replace(self, columns=self.columns // 2, layers=self.layers // 2)


def make_plan(ink: Ink, *, draft: bool = False, realisations: int | None = None) -> Plan:
    """Choose how an ink is solved.

    Parameters
    ----------
    draft : bool    Half as many bands and realisations, on a coarser grid, where the description does not say otherwise.
    realisations : int or None    In place of what the description says.

    Raises
    ------
    SceneError    It would need more memory, or more cells, than `MOST_MEMORY` and `MOST_CELLS`.
    """
    stated = ink.solving
    step = stated.band_step or STEP * (2.0 if draft else 1.0)
    bands = max(1, round((LAST - FIRST) / step))
    wavelengths = tuple(np.linspace(FIRST, LAST, bands + 1).tolist())
    sizes = [each.population.diameter for each in ink.particles]
    per_diameter = stated.steps_per_diameter or (2.0 if draft else STEPS_PER_DIAMETER)
    per_wave = STEPS_PER_WAVE * (0.75 if draft else 1.0)
    finest = FIRST * 1e-3 / ink.largest_index(np.array(wavelengths)) / per_wave
    if sizes:
        finest = min(finest, min(sizes) / per_diameter)
    if ink.relief:
        finest = min(finest, ink.relief.length / per_diameter)
    largest = max([*sizes, ink.relief.length if ink.relief else 0.0], default=0.0)
    width = stated.cell or max(NARROWEST, DIAMETERS * largest) * (0.75 if draft else 1.0)
    columns = _smooth(width / finest) if sizes or ink.relief else 2
    layers = 2 * math.ceil(0.5 * _height(ink) * FINER_DOWN / finest)
    count = stated.incidences or (4 if draft else INCIDENCES)
    angles = np.radians(np.linspace(LOWEST, HIGHEST, count))
    runs = realisations or stated.realisations or (2 if draft else REALISATIONS)
    plan = Plan(
        float(width),
        columns,
        layers,
        wavelengths,
        tuple(np.sin(angles).tolist()),
        2 * math.ceil(0.5 * runs),
        float(stated.tolerance or (DRAFT_TOLERANCE if draft else TOLERANCE)),
        stated.seed,
    )
    cells = columns**2 * layers
    if cells > MOST_CELLS or memory_of(ink, plan) > MOST_MEMORY:
        raise SceneError(
            f"'{ink.name}' needs a grid of {columns} x {columns} x {layers} cells and "
            f"{memory_of(ink, plan) / 2**30:.3g} GB, expected {MOST_MEMORY / 2**30:g} GB at most; "
            "take a narrower cell or fewer steps per diameter"
        )
    return plan


def memory_of(ink: Ink, plan: Plan) -> int:
    """Most memory that one process takes. [byte]"""
    cells = plan.columns**2 * plan.layers
    particles = [each.population for each in ink.particles]
    spheres = count_spheres(particles, plan.width, ink.thickness * (1.0 + ink.thickness_spread))
    points = min(SLAB + (plan.columns * SAMPLES) ** 2 * SAMPLES, cells * SAMPLES**3) * (
        3 + len(particles)
    )
    packing = SPHERE_MEMORY * spheres + (100 << 20 if particles else 0)
    grid = 8 * cells * (len(particles) + 2)
    return (
        BASE_MEMORY
        + grid
        + max(packing, points + (64 << 20), 16 * cells * (FIELDS + kept_directions(cells)))
    )


def solves_of(ink: Ink, plan: Plan) -> int:
    """How many times waves are solved."""
    sides = 1 if ink.is_alike_from_both_sides else 2
    return len(plan.wavelengths) * len(plan.sines) * plan.realisations * sides


def _height(ink: Ink) -> float:
    """Largest height of the grid. [um]"""
    crest = CREST * ink.relief.height if ink.relief else 0.0
    return ink.thickness * (1.0 + ink.thickness_spread) + crest


def _smooth(least: float) -> int:
    """The next multiple of 4 that has no prime factors beyond 5, which FFT like."""
    count = 4 * math.ceil(0.25 * least)
    while True:
        rest = count
        for prime in (2, 3, 5):
            while rest % prime == 0:
                rest //= prime
        if rest == 1:
            return count
        count += 4
