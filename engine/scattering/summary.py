"""Figures of a scattering file that tell people what it is and how far it can be trusted."""

from dataclasses import dataclass

import numpy as np

from ..scene.scattering import Scatter
from .data.evaluation import incidences_of, measure_reciprocity, symmetry_of, total
from .data.record import SIDES, ScatteringFile
from .data.tristimulus import tristimulus
from .readers.checks import shares_of

NEAR_NORMAL = np.radians(8.0)
"""Incidence that totals are usually measured at, so that what a mirror reflects leaves the sphere or stays in it. [rad]"""


@dataclass(frozen=True, eq=False)
class SideSummary:
    """Figures of one side.

    Parameters
    ----------
    symmetry : str    For people.
    incidences : (s,) array    Angles of incidence that there are data for. [rad]
    wavelengths : (w,) array    One: the same at all. [nm]
    error : float    As of `ScatterTable`; 0: none is stated. [-]
    near_normal : (w,) array    Share of light from `NEAR_NORMAL` that is scattered, direct part included. [-]
    largest : float    Largest such share of all incidences and wavelengths. [-]
    steepest : float    Incidence of the largest. [rad]
    reciprocity : float or None    The worse figure of `Reciprocity`; None: sides of other wavelengths, not compared. [-]
    """

    symmetry: str
    incidences: np.ndarray
    wavelengths: np.ndarray
    error: float
    near_normal: np.ndarray
    largest: float
    steepest: float
    reciprocity: float | None

    def tristimulus(self, illuminant: str = "D65") -> np.ndarray:
        """X, Y, Z of all light near the normal under an illuminant; Y of the perfect diffuser is 1. (3,)"""
        return tristimulus(self.near_normal, self.wavelengths, illuminant)


def summarise(file: ScatteringFile) -> dict[str, SideSummary]:
    """Find the figures of all sides of a file, by the names of `SIDES`; sides that share data share them."""
    made, known = {}, {}
    for side in SIDES:
        scatter = file.sides.get(side)
        if scatter is None:
            continue
        other = file.sides.get(_other_way(side))
        if (scatter, other) not in known:
            known[scatter, other] = _summarise(file, scatter, other)
        made[side] = known[scatter, other]
    return made


def _other_way(side: str) -> str:
    """Name of the side that light on the way back meets: of reflection the same one."""
    if side.endswith("_reflection"):
        return side
    return "back_transmission" if side.startswith("front") else "front_transmission"


def _summarise(file: ScatteringFile, scatter: Scatter, back: Scatter | None) -> SideSummary:
    steepest, largest = max(shares_of(scatter), key=lambda each: each[1])
    reciprocity = None
    if back is not None and len(back.wavelengths) == len(scatter.wavelengths):
        reciprocity = measure_reciprocity(scatter, back).worst
    return SideSummary(
        symmetry_of(scatter),
        file.incidences if len(file.incidences) else incidences_of(scatter),
        scatter.wavelengths,
        float(getattr(scatter, "error", 0.0)),
        total(scatter, NEAR_NORMAL),
        float(largest),
        float(steepest),
        reciprocity,
    )
