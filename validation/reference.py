"""Reference values of the validation cases: groups of points with their tolerances."""

import json
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent / "reference"
"""Holds ``groups.json``, ``published.json`` and the photometric files in ``ies``."""


@dataclass(frozen=True, eq=False)
class Group:
    """Reference values of one kind in one set-up.

    Parameters
    ----------
    id, case : str    Such as ``C05.axis`` and ``C05``.
    quantity, unit : str
    tolerance_class : str    X, A, B, C, D or Z, that of the group.
    labels : tuple of str    One per value.
    values : (n,) float64
    allowed : (n,) float64    Largest difference from the value that passes.
    positions, normals : (n, 3) float64    NaN where the group has none.
    classes : tuple of str    Tolerance class of each value.
    extras : tuple of dict    What else the reference says about each point, such as a sphere's radius.
    is_informative : bool    Reported, not scored.
    tables : dict    Tables that belong to the set-up.
    """

    id: str
    case: str
    quantity: str
    unit: str
    tolerance_class: str
    labels: tuple[str, ...]
    values: np.ndarray
    allowed: np.ndarray
    positions: np.ndarray
    normals: np.ndarray
    classes: tuple[str, ...]
    extras: tuple[dict, ...]
    is_informative: bool = False
    tables: dict = field(default_factory=dict)


@lru_cache
def load_groups() -> dict[str, Group]:
    """Return all groups by id, in the order of the cases."""
    data = json.loads((FOLDER / "groups.json").read_text(encoding="utf-8"))
    return {entry["id"]: _group(entry, data["classes"]) for entry in data["groups"]}


def groups_of(case: str) -> dict[str, Group]:
    """Return the groups of a case by id."""
    return {key: group for key, group in load_groups().items() if group.case == case}


def _group(entry: dict, classes: dict) -> Group:
    rows = entry["points"]
    special = entry.get("point_classes", {})
    values = np.array([row[1] for row in rows], dtype=np.float64)
    own = tuple(special.get(row[0], entry["class"]) for row in rows)
    relative = np.array(
        [
            classes[special[row[0]]]["relative"] if row[0] in special else entry["relative"]
            for row in rows
        ]
    )
    return Group(
        id=entry["id"],
        case=entry["case"],
        quantity=entry["quantity"],
        unit=entry["unit"],
        tolerance_class=entry["class"],
        labels=tuple(row[0] for row in rows),
        values=values,
        allowed=np.maximum(relative * np.abs(values), entry["absolute"]),
        positions=_vectors(rows, 2),
        normals=_vectors(rows, 3),
        classes=own,
        extras=tuple(row[4] if len(row) > 4 else {} for row in rows),
        is_informative=entry.get("informative", False),
        tables=entry.get("tables", {}),
    )


def _vectors(rows, column: int) -> np.ndarray:
    return np.array(
        [row[column] if row[column] is not None else (np.nan,) * 3 for row in rows],
        dtype=np.float64,
    )
