"""Programs that make pictures: ours by a method, and Cycles."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Protocol

import numpy as np

from ...engine.accuracy import stopping
from ...engine.accuracy.stopping import StopRule
from ...engine.photometry.colour import REC709_LUMINANCE, scene_linear
from ...engine.scene.scene import SceneDelta
from ...engine.session import Session
from ...engine.views import ViewSettings
from ..common.cycles_process import CyclesProcess
from .cycles_scene import describe
from .scenes import PictureScene, resize

OURS, BEFORE, CYCLES = "Lumenray", "before", "cycles"
"""Names in results."""

METHODS = {OURS: "auto", BEFORE: "paths"}
"""What stands for the light beyond the first bounces."""

TASK = Path(__file__).with_name("cycles_picture.py")

PATIENCE = 3600.0
"""Longest that Cycles may take for one picture. [s]"""

FEWEST = 16
"""Samples by which one gets it compiled before sensors' time counts."""

GLANCE = (8, 5)
"""Size of the picture by which a session gets its scene compiled before the time counts. [pixel]"""


@dataclass(frozen=True, eq=False)
class Made:
    """A picture.

    Parameters
    ----------
    linear : (h, w, 3) float array    Linear Rec. 709, whose luminance is in cd/m2. Row 0 is the bottom row.
    luminance : (h, w) float array    [cd/m2]
    seconds : float    That it took.
    stated : float or None    Relative error that the program states itself. [-]
    """

    linear: np.ndarray
    luminance: np.ndarray
    seconds: float
    stated: float | None = None


class Program(Protocol):
    """What races.

    Parameters
    ----------
    name : str
    least : int    Fewest samples per pixel.
    """

    name: str
    least: int

    def render(self, samples: int, seed: int) -> Made:
        """Render with so many samples per pixel."""

    def refer(self, samples: int, seed: int) -> Made:
        """As `render`, but with nothing that pixels have in common: what that changes is to be found as an error."""

    def close(self) -> None:
        """End what it leaves running."""


class Lumenray:
    """Our engine in this process. What a picture learns of its scene is learned anew for each."""

    least = 2

    def __init__(self, scene: PictureScene, name: str = OURS):
        self.name, self._scene = name, scene

    def render(self, samples: int, seed: int) -> Made:
        """Render with so many samples per pixel."""
        return self.follow(StopRule(samples=samples), seed)

    def refer(self, samples: int, seed: int) -> Made:
        """As `render`; pixels share no light."""
        return self.follow(StopRule(samples=samples), seed, shares=False)

    def follow(
        self, rule: StopRule, seed: int, progress: Callable | None = None, shares: bool = True
    ) -> Made:
        """Render by a rule. ``progress(seconds, seconds_left)``: told of every state with a forecast."""
        session = Session(witness=False)
        session.apply(SceneDelta(changed=self._scene.items))
        # Compiles the scene; cells and the like belong to the picture and are none of it.
        glance = resize(self._scene.camera, GLANCE)
        session.render(glance, _settings(StopRule(samples=self.least), seed, METHODS[BEFORE]))
        settings = replace(_settings(rule, seed, METHODS[self.name]), shares=shares)
        begin = stopping.read_clock()

        def tell(state, _preview):
            if progress is not None and state.seconds_left is not None:
                progress(stopping.read_clock() - begin, state.seconds_left)

        picture = session.render(self._scene.camera, settings, tell)
        seconds = stopping.read_clock() - begin
        linear = scene_linear(picture.tristimulus, 1.0)
        luminance = picture.tristimulus[..., 1]
        return Made(linear, luminance, seconds, float(picture.relative_error))

    def measure(self, rule: StopRule, seed: int, progress: Callable) -> tuple[float, float]:
        """Measure at the scene's sensors by a rule; ``progress`` as of `follow`.

        Returns
        -------
        (float, float)    Relative error by which the rule stops, and the seconds.
        """
        places, normals = self._scene.sensors
        session = Session()
        session.apply(SceneDelta(changed=self._scene.items))
        # Compiles the scene for what is asked.
        session.measure(places, normals, replace(rule, samples=FEWEST), seed)
        begin = stopping.read_clock()

        errors = []

        def tell(state):
            errors.append(state.relative_error)
            if state.seconds_left is not None:
                progress(stopping.read_clock() - begin, state.seconds_left)

        session.measure(places, normals, rule, seed, progress=tell)
        return errors[-1], stopping.read_clock() - begin

    def close(self) -> None:
        """Nothing is left running."""


@contextmanager
def processor_time() -> Iterator[None]:
    """Follow all pictures, and make the forecasts of ours, by the processor time of the process that makes them.

    Where other programs share the machine, the time of day tells of them too, and no forecast knows of these.
    """
    kept, stopping.read_clock = stopping.read_clock, time.process_time
    try:
        yield
    finally:
        stopping.read_clock = kept


def has_methods() -> bool:
    """Whether pictures can be made by another method than plain paths."""
    return "method" in {field.name for field in fields(ViewSettings)}


def _settings(rule: StopRule, seed: int, method: str) -> ViewSettings:
    settings = ViewSettings(rule, seed)
    return replace(settings, method=method) if has_methods() else settings


class Cycles:
    """Cycles in its own process, with all its limits at their most accurate.

    Raises
    ------
    CannotStateError    The package `bpy` is missing, or Cycles has nothing for a part of the scene.
    """

    name, least = CYCLES, 1

    def __init__(self, scene: PictureScene):
        request = describe(scene.known_items, scene.camera)
        self._process = CyclesProcess(TASK, PATIENCE)
        try:
            self._process.ask(request)
        except BaseException:
            self.close()
            raise

    @property
    def pid(self) -> int:
        """Of its process."""
        return self._process.pid

    def render(self, samples: int, seed: int) -> Made:
        """Render with so many samples per pixel."""
        by_processor = stopping.read_clock is time.process_time
        asked = {"samples": samples, "seed": seed, "by_processor": by_processor}
        linear, seconds = self._process.ask(asked)
        return Made(linear, linear @ REC709_LUMINANCE, seconds)

    def refer(self, samples: int, seed: int) -> Made:
        """As `render`, which has nothing in common."""
        return self.render(samples, seed)

    def close(self) -> None:
        """End the process."""
        self._process.close()
