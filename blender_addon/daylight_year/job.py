"""The job of a year: a scene with its blinds in every state, sensors, weather, and the figures that come out."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ...engine.baking.order import BakeOrder
from ...engine.baking.year_maps import YearMaps, make_year_maps
from ...engine.daylight.blinds import check_rules
from ...engine.daylight.coefficients import DaylightCoefficients, DaylightOrder
from ...engine.daylight.light import Light
from ...engine.daylight.other_sensors import take_sensors
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
    maps: YearMaps | None = None


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
    maps : BakeOrder or None    Whose objects' lumels are sensors beside the places; they move no blinds, and no figure of
        the area counts them.
    names : dict of str    Of the objects of these maps, by their ids.
    """

    scene: Scene
    blinds: list[tuple[str, ...]]
    places: Places
    year: Year
    question: Question
    order: DaylightOrder
    transport: str = "auto"
    maps: BakeOrder | None = None
    names: dict[str, str] = field(default_factory=dict)
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
            Given the number of a state, its scene's hash, all sensors and a function that traces it, returns the
            coefficients; None: traces.

        Raises
        ------
        Cancelled    After `cancel`.
        LumenrayError    The scene or the machine does not allow it.
        """
        check_rules(self.question.blinds, len(self.blinds), self.year)
        self._session = session
        session.apply(self.scene.snapshot())
        own = Scene()
        own.apply(self.scene.snapshot())
        blinds = {key for keys in self.blinds for key in keys}
        there, found, sheet = set(blinds), [], None
        sensors = self.places.sensors
        for number, shown in enumerate([(), *self.blinds]):
            delta = SceneDelta(
                changed=tuple(self.scene.meshes[key] for key in shown if key not in there),
                removed=tuple(sorted(there - set(shown))),
            )
            there = set(shown)
            session.apply(delta)
            own.apply(delta)
            if self.maps is not None and sheet is None:
                sheet = session.find_lumels(self.maps, self.transport, progress)
                sensors = np.concatenate([sensors, sheet.sensors[sheet.is_valid]])
            if self._is_cancelled:
                raise Cancelled("cancelled")

            def trace(at=sensors) -> DaylightCoefficients:
                return session.find_daylight(
                    at[:, :3], at[:, 3:], self.order, self.transport, progress
                )

            found.append(trace() if find is None else find(number, own.hash(), sensors, trace))
        self.answer = self._judge(tuple(found), sheet)

    def _judge(self, found: tuple[DaylightCoefficients, ...], sheet) -> Answer:
        first = len(self.places.sensors)
        opened, *closed = (take_sensors(each, slice(0, first)) for each in found)
        areas = self.places.areas
        light = shade(self.year, opened, tuple(closed), areas, self.question)
        figures = judge(light, self.question, areas)
        notes = (*map(str, self.year.remarks), *opened.provenance.notes, *figures.notes)
        if sheet is None:
            return Answer(light, figures, notes)
        maps = make_year_maps(sheet, found, first, light, self.question, self.maps.margin)
        departures = [
            f"{self.names.get(each.name, each.name)}: {each.message}; it has no map"
            if each.is_error
            else f"{self.names.get(each.name, each.name)}: {each.message}; {each.remedy}"
            for each in maps.departures
        ]
        return Answer(light, figures, (*notes, *departures), maps)

    def cancel(self) -> None:
        """End it; may be called from any thread."""
        self._is_cancelled = True
        if self._session is not None:
            self._session.cancel()


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


def meshes_of(collection, use: str = "be a blind") -> list[str]:
    """Return the names of a collection's meshes; ``use``: what they are for.

    Raises
    ------
    SceneError    It holds none.
    """
    names = [item.name_full for item in collection.all_objects if item.type == "MESH"]
    if not names:
        raise SceneError(f"the collection '{collection.name}' holds no mesh that could {use}")
    return names
