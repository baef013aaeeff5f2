"""From what the panel says to the job of a year."""

import math
from datetime import date

import bpy
import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.baking.order import BakeOrder
from ...engine.daylight.coefficients import DaylightOrder
from ...engine.daylight.grid import lay_grid
from ...engine.daylight.study import Question
from ...engine.daylight.sunlight import make_day
from ...engine.daylight.year import GROUND_REFLECTANCE, make_year
from ...engine.errors import SceneError
from ...engine.scene.scene import Scene
from ...engine.sky.weather_file import read_weather
from .. import assumptions
from ..foundation.report import ConversionReport
from ..sync.scene import convert_scene
from ..sync.walk import NO_LIGHT
from .blind_rules import find_rules
from .job import SUN_ANGLE, Places, YearJob, find_keys, meshes_of

NEAR = 1.5
"""Degrees of latitude and longitude within which the world's place is taken for that of the weather."""

EQUINOX = date(2001, 3, 21)
"""Day whose sunlight is judged."""

LEAST_SUN, STEP = 10.0, 300.0
"""Elevation from which on the sun counts on that day [degree], and time between its moments [s]."""


def prepare(context) -> tuple[YearJob, ConversionReport, list[str]]:
    """Return the job of the scene's year, what could not be taken over, and what was assumed.

    Raises
    ------
    LumenrayError    The weather cannot be read, or the scene does not fit.
    """
    scene, world = context.scene, context.scene.world
    settings = scene.lumenray.year
    weather = read_weather(_weather_path(settings, world))
    north = math.degrees(world.lumenray.place.north) if world is not None else 0.0
    ground = GROUND_REFLECTANCE if world is None else world.lumenray.sky.ground_reflectance
    year = make_year(weather, north, ground)
    if not len(year.lit):
        raise SceneError("no hour of the weather has any daylight")
    notes = [
        f"the sun of {EQUINOX:%d %B} counts from {LEAST_SUN:g} degrees on, where EN 17037 has a number for every place"
    ]
    zone = _zone_of(world, weather.place, notes)
    depsgraph = context.evaluated_depsgraph_get()
    converted = convert_scene(depsgraph)
    converted.report.forget(NO_LIGHT)
    assumptions.refuse_missing(converted.report, False)
    assumptions.refuse_media(converted.report)
    own = Scene()
    own.apply(converted.delta)
    day = make_day(EQUINOX, weather.place, LEAST_SUN, STEP)
    order = DaylightOrder(
        np.concatenate([year.suns, day.sun.directions(north)]),
        SUN_ANGLE,
        StopRule(samples=settings.samples),
        year.steps,
        seed=scene.lumenray.seed,
    )
    job = YearJob(
        own,
        _blinds_of(settings, converted.objects),
        _places_of(settings, own, converted.objects),
        year,
        Question(
            zone,
            target=settings.target,
            ground_reflectance=ground,
            day=day,
            blinds=find_rules(settings, north),
        ),
        order,
        scene.lumenray.transport.lower(),
        *_maps_of(settings, converted.objects),
    )
    return job, converted.report, notes


def _weather_path(settings, world) -> str:
    path = settings.weather_file
    if not path and world is not None:
        path = world.lumenray.sky.weather_file
    if not path:
        raise SceneError("no weather file is chosen; take an EPW or WEA file of the place")
    return bpy.path.abspath(path)


def _zone_of(world, place, notes: list[str]) -> str | None:
    """Clocks that people live by: those of the world's place where that is near the weather's."""
    if world is not None:
        own = world.lumenray.place
        away = (
            abs(math.degrees(own.latitude) - place.latitude),
            abs((math.degrees(own.longitude) - place.longitude + 180.0) % 360.0 - 180.0),
        )
        if max(away) < NEAR:
            return own.zone
    notes.append(
        f"the world's place is not the weather's, so that hours are those of {place.zone}, without daylight saving time"
    )
    return None


def _places_of(settings, scene: Scene, objects: dict[str, str]) -> Places:
    if settings.floor is None:
        raise SceneError("no floor is chosen; take the mesh above which the sensors are to stand")
    (key,) = find_keys(objects, [settings.floor.name_full], "the scene")
    grid = lay_grid([scene.mesh(key)], settings.spacing, settings.height)
    up = np.tile([0.0, 0.0, 1.0], (len(grid), 1))
    return Places(np.column_stack([grid, up]), np.full(len(grid), settings.spacing**2))


def _blinds_of(settings, objects: dict[str, str]) -> list[tuple[str, ...]]:
    if settings.blinds is None:
        return []
    groups = list(settings.blinds.children) or [settings.blinds]
    return [find_keys(objects, meshes_of(group), "the scene") for group in groups]


def _maps_of(settings, objects: dict[str, str]) -> tuple[BakeOrder | None, dict[str, str]]:
    """Maps that are asked for, and the names of their objects by ids."""
    if settings.maps is None:
        return None, {}
    names = meshes_of(settings.maps, "have a map")
    keys = find_keys(objects, names, "the scene")
    order = BakeOrder(keys, StopRule(samples=1), density=settings.map_density)
    return order, dict(zip(keys, names, strict=True))
