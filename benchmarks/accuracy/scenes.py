"""Scenes with exact values for the benchmark of accuracy: those of the validation cases, taken from there."""

from dataclasses import dataclass

import numpy as np

from ...engine.errors import LumenrayError
from ...validation.bench import Bench, Readings
from ...validation.cases import all_cases

_SKY = ".sky12"
"""A clear sky."""

TITLES = {
    "C05.near": ("Near a luminous square", ("C05.near",)),
    f"C12.4x4{_SKY}": ("Open roof, clear sky", (f"C12.4x4{_SKY}",)),
    f"C14.2x1{_SKY}": (
        "Window, clear sky and ground",
        tuple(f"C14.2x1.{face}{_SKY}" for face in ("wall", "floor")),
    ),
    "C10.cube0.8": ("Point in a cube that reflects 0.8", ("C10.cube0.8",)),
    "C18.mirror_total": ("Luminous square and mirror", ("C18.mirror_total",)),
    "C28.thousand": ("A thousand points", ("C28.thousand",)),
}
"""Title and groups of reference values of every scene."""

QUICK = ("C05.near", f"C14.2x1{_SKY}", "C10.cube0.8")
"""Scenes of a quick run."""


@dataclass(frozen=True, eq=False)
class ExactScene:
    """A scene whose illuminances are known.

    Parameters
    ----------
    key, title : str
    groups : tuple of str    Ids of the reference values.
    items : tuple    The scene.
    positions, normals : (n, 3) float64 array    Sensors. [m]
    exact : (n,) float64 array    Above 0. [lx]
    """

    key: str
    title: str
    groups: tuple[str, ...]
    items: tuple
    positions: np.ndarray
    normals: np.ndarray
    exact: np.ndarray


class _Notebook:
    """An instrument that only puts down what it is asked."""

    name = "notebook"

    def __init__(self):
        self.asked = []

    def measure(self, items, query, seed: int) -> Readings:
        self.asked.append((tuple(items), query))
        return Readings(np.ones(len(query.positions)), np.zeros(len(query.positions)))


def load_scene(key: str) -> ExactScene:
    """Return the scene of a name out of `TITLES`.

    Raises
    ------
    LumenrayError    The case asks for its values in another way than by one question.
    """
    title, groups = TITLES[key]
    notebook = _Notebook()
    case = all_cases()[groups[0].partition(".")[0]]
    found = {made.group.id: made for made in case.run(Bench(notebook, frozenset(groups)))}
    if len(notebook.asked) != 1 or len(found) != len(groups):
        raise LumenrayError(f"benchmark: {key} is not one scene")
    items, query = notebook.asked[0]
    # Readings of 1 lx tell what the case makes of a lux.
    exact = np.concatenate([made.group.values / made.values for made in found.values()])
    is_lit = exact > 0.0
    return ExactScene(
        key,
        title,
        groups,
        items,
        query.positions[is_lit],
        query.normals[is_lit],
        exact[is_lit],
    )
