"""The states of a bake's layers, kept in a file from which it goes on."""

import time
from dataclasses import fields
from pathlib import Path

import numpy as np

from ..accuracy.stopping import StopRule
from ..errors import FileFormatError, SceneError
from ..formats.checkpoint import digest, read_checkpoint, write_checkpoint
from ..scene.scene import Scene
from .layer_state import LayerState
from .order import BakeOrder

SAVE_INTERVAL = 20.0
"""Shortest time between two states that are written. [s]"""

COARSE_ERROR, MOST_FINE = 0.02, 4.0
"""Relative error from which there are more cells in proportion, and how many times more. [-]"""

WITHOUT = (
    "folder",
    "keep_pages",
    "witness",
    "checkpoint",
    "file",
    "scene",
    "conversion",
    "denoise",
    "isolux",
    "arrays",
    "rule",
)
"""Fields of an order with which a bake may go on that was begun with others."""

SETTINGS = {
    "density": "lumels per metre", "densities": "lumels per metre of single objects", "from_textures": "as fine as textures",
    "largest": "page size", "pages": "most pages", "cone": "cone angle", "detail": "detail threshold",
    "two_sided": "both sides", "groups": "layers",
}  # fmt: skip
"""What people call the fields whose names do not say it."""

MOST_TOLD = 5_000
"""Objects up to which a checkpoint knows them one by one, to tell what of the scene has changed."""


class Saver:
    """Keeps the states of layers, and writes them from time to time.

    ``fineness``: factor on the number of cells, which a bake that goes on keeps, whatever its rule says now. [-]
    """

    def __init__(self, order: BakeOrder, scene: Scene):
        self._path = None if order.checkpoint is None else Path(order.checkpoint)
        settings = {
            entry.name: digest(getattr(order, entry.name))
            for entry in fields(order)
            if entry.name not in WITHOUT
        }
        self._facts = {
            "scene": scene.hash(),
            "order": digest(settings),
            "settings": {SETTINGS.get(name, name): value for name, value in settings.items()},
            "items": scene.digests() if len(scene.meshes) <= MOST_TOLD else {},
            "rule": digest(order.rule),
            "fineness": _fineness(order.rule),
        }
        self._states: dict[int, LayerState] = {}
        self._finished: set[int] = set()
        self._late: set[int] = set()
        self._written = time.perf_counter()
        self._arrays: dict[str, np.ndarray] = {}
        self._has_same_rule = True
        if self._path is not None and self._path.exists():
            self._arrays, known = read_checkpoint(
                self._path, self._facts["scene"], self._facts["order"], self._facts
            )
            self._has_same_rule = known.get("rule") == self._facts["rule"]
            if 1.0 <= float(known.get("fineness", 0.0)) <= MOST_FINE:
                self._facts["fineness"] = float(known["fineness"])

    @property
    def fineness(self) -> float:
        """Factor on the number of cells. [-]"""
        return self._facts["fineness"]

    def read_states(self, rule: StopRule, layers: int, count: int) -> None:
        """Take over the states of the layers that the file holds.

        Raises
        ------
        FileFormatError    They are of maps with another number of lumels, or do not fit together.
        """
        for number in range(layers):
            head = f"{number}."
            own = {key[len(head) :]: v for key, v in self._arrays.items() if key.startswith(head)}
            if not own:
                continue
            try:
                state = LayerState.from_arrays(rule, own)
            except (SceneError, KeyError) as error:
                raise FileFormatError(
                    self._path, f"{error}: delete the checkpoint and start anew"
                ) from error
            if state.sums.count != count:
                raise FileFormatError(
                    self._path,
                    f"the checkpoint is of {state.sums.count} lumels, the bake has {count}: delete it and start anew",
                )
            if not self._has_same_rule:
                state.review()
            self._states[number] = state
            if state.is_done:
                self._finished.add(number)
        self._arrays = {}

    def state(self, number: int) -> LayerState | None:
        """State of a layer, None when it has not begun."""
        return self._states.get(number)

    def is_finished(self, number: int) -> bool:
        """Whether a layer has met its rule."""
        return number in self._finished

    def saving(self, number: int):
        """Return a function that takes note of a layer's state."""

        def save(state: LayerState) -> None:
            self._states[number] = state
            if time.perf_counter() - self._written > SAVE_INTERVAL:
                self.write()

        return save

    def finish(self, number: int, state: LayerState, is_late: bool) -> None:
        """Take note of a layer that has come to its end; one that came too late is not worth going on from."""
        self._states[number] = state
        if is_late:
            self._late.add(number)
        self._finished.add(number)

    def write(self) -> None:
        """Write what is known, if the order names a file."""
        if self._path is None or not self._states:
            return
        arrays = {
            f"{number}.{name}": value
            for number, state in self._states.items()
            if number not in self._late
            for name, value in state.arrays().items()
        }
        write_checkpoint(self._path, arrays, self._facts)
        self._written = time.perf_counter()


def _fineness(rule: StopRule) -> float:
    """Factor on the number of cells: the smaller the error that is asked for, the less the cells may add to it. [-]"""
    return 1.0 if rule.error is None else float(np.clip(COARSE_ERROR / rule.error, 1.0, MOST_FINE))
