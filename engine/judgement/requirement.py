"""What an activity asks of its lighting, as pure data."""

from dataclasses import dataclass, field
from pathlib import Path

AREAS = {
    "task": "lx",
    "cylindrical": "lx",
    "walls": "lx",
    "ceiling": "lx",
    "surroundings": "lx",
    "background": "lx",
    "melanopic": "lx",
    "road": "cd/m2",
}
"""Areas that values may be asked of, with the unit of their means and minima; melanopic: equivalent daylight at the eye."""

LIMITS = {
    "mean": "mean",
    "modified": "mean, modified",
    "minimum": "minimum",
    "uniformity": "uniformity Uo",
    "diversity": "uniformity Ud",
    "longitudinal": "longitudinal uniformity Ul",
    "edge": "edge illuminance ratio EIR",
}
"""What may be asked of an area, as its least value, with the words for people: Uo is least over mean, Ud least over largest,
Ul the worst along a lane, EIR that of the light beside the carriageway to that on its strips along the edges."""

RATIOS = frozenset({"uniformity", "diversity", "longitudinal", "edge"})
"""Those without a unit, which maintenance does not change."""

LIGHT = {"ugr": "UGR", "ra": "Ra", "threshold_increment": "threshold increment"}
"""What may be asked of the light as a whole, with the words for people."""

MOST = frozenset({"ugr", "threshold_increment"})
"""Those that are largest values."""


@dataclass(frozen=True)
class Requirement:
    """What an activity asks for.

    Parameters
    ----------
    key : str    Such as ``office.writing``.
    title, standard, source : str    For people; the source says where the values are from.
    areas : dict of str to dict    Limits of areas, by `AREAS` and `LIMITS`. [lx, cd/m2, -]
    light : dict    By `LIGHT`. [-], [%]
    path : Path    File.
    is_direct : bool    Whether only light counts that was not reflected.
    """

    key: str
    title: str
    standard: str
    source: str
    areas: dict[str, dict[str, float]]
    light: dict[str, float] = field(default_factory=dict)
    path: Path = Path()
    is_direct: bool = False
