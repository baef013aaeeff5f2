"""The job of a year: a scene with its blinds in every state, sensors, weather, and the figures that come out."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ...engine.daylight.blinds import check_rules
from ...engine.daylight.coefficients import DaylightCoefficients, DaylightOrder
from ...engine.daylight.light import Light
from ...engine.daylight.study import Figures, Question, judge, shade
from ...engine.daylight.year import Year
from ...engine.errors import Cancelled, SceneError
from ...engine.scene.scene import Scene, SceneDelta

SUN_ANGLE = np.radians(0.533)
"""Diameter of the sun's disk. [rad]"""


@dataclass(frozen=True, eq=False)
class Places:
    """Sensors (n, 6) and the areas that they stand for (n,). [m, m2]"""

    sensors: np.ndarray
    areas: np.ndarray


@dataclass(frozen=True, eq=False)
class Answer:
    """What a job has found."""

    light: Light
    figures: Figures
    notes: tuple[str, ...]


@dataclass(eq=False)
class YearJob:
    """A year to be computed.

    Parameters
    ----------
    scene : Scene    The whole of it, the blinds with it; it is not changed.
    blinds : list of tuple of str    Ids of the objects that are the closed blinds of each group of windows.
    places : Places
    year : Year
    question : Question
    order : DaylightOrder
    transport : str
    """

    scene: Scene
    blinds: list[tuple[str, ...]]
    places: Places
    year: Year
    question: Question
    order: DaylightOrder
    transport: str = "auto"
    answer: Answer | None = None
    _session: object = field(default=None, repr=False)
    _is_cancelled: bool = False

    @property
    def states(self) -> int:
        """How often everything is traced."""
        return 1 + len(self.blinds)

    def run(self, session, progress=None, find: Callable | None = None) -> None:
        """Trace all states and judge the year; the answer is kept.

        Parameters
        ----------
        session : Session or RemoteSession    An empty one.
        progress : callable or None    Gets a `Progress`.
        find : callable or None
            Given the number of a state, its scene's hash and a function that traces it, returns the coefficients; None:
            traces.

        Raises
        ------
        Cancelled    After `cancel`.
        LumenrayError    The scene or the machine does not allow it.
        """
        check_rules(self.question.blinds, len(self.blinds), self.year)
        self._session = session
        session.apply(SceneDelta(changed=_all_items(self.scene)))
        own = Scene()
        own.apply(SceneDelta(changed=_all_items(self.scene)))
        blinds = {key for keys in self.blinds for key in keys}
        there, found = set(blinds), []
        for number, shown in enumerate([(), *self.blinds]):
            delta = SceneDelta(
                changed=tuple(self.scene.meshes[key] for key in shown if key not in there),
                removed=tuple(sorted(there - set(shown))),
            )
            there = set(shown)
            session.apply(delta)
            own.apply(delta)
            if self._is_cancelled:
                raise Cancelled("cancelled")

            def trace() -> DaylightCoefficients:
                sensors = self.places.sensors
                return session.find_daylight(
                    sensors[:, :3], sensors[:, 3:], self.order, self.transport, progress
                )

            found.append(trace() if find is None else find(number, own.hash(), trace))
        opened, *closed = found
        light = shade(self.year, opened, tuple(closed), self.places.areas, self.question)
        figures = judge(light, self.question, self.places.areas)
        remarks = map(str, self.year.remarks)
        self.answer = Answer(light, figures, (*remarks, *opened.provenance.notes, *figures.notes))

    def cancel(self) -> None:
        """End it; may be called from any thread."""
        self._is_cancelled = True
        if self._session is not None:
            self._session.cancel()


def _all_items(scene: Scene) -> tuple:
    """Everything that a scene holds, pixels first as pictures name them."""
    tables = (scene.pixels, scene.geometries, scene.materials, scene.meshes, scene.lights)
    items = [item for table in tables for item in table.values()]
    return (*items, *([scene.world] if scene.world is not None else []))


def find_keys(objects: dict[str, str], names, where: str) -> tuple[str, ...]:
    """Return the ids of objects by their names; ``objects``: ids by name.

    Raises
    ------
    SceneError    The scene does not show one of them.
    """
    missing = sorted(set(names) - set(objects))
    if missing:
        raise SceneError(f"{where} shows no object named {', '.join(missing)}")
    return tuple(objects[name] for name in names)


def meshes_of(collection) -> list[str]:
    """Return the names of a collection's meshes.

    Raises
    ------
    SceneError    It holds none.
    """
    names = [item.name_full for item in collection.all_objects if item.type == "MESH"]
    if not names:
        raise SceneError(f"the collection '{collection.name}' holds no mesh that could be a blind")
    return names
