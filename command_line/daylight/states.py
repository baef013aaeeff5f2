"""States of the blinds: their objects, when they are closed, and what an earlier run has traced of them."""

import argparse
import math
import re

from ...blender_addon.daylight_year.job import YearJob, find_keys, meshes_of
from ...engine.errors import SceneError
from ..options import real, stretch

RULES = """when the blinds of a group are closed, once for all groups or as often as --blinds:
  lm83                       where the sun lights more than 2 % of the area with more than 1000 lx (default)
  closed                     always
  months=4-9,hours=9-17      by the clock; add ",workdays" for Monday to Friday
  table=STATES.csv           0 or 1 for every record of the weather file, a column for each group or one for all
  sun=200                    while the direct normal irradiance is above so many W/m2
  horizontal=400             while that of a horizontal plane in the open is, by sun and sky
  facade=180:250             while that of a vertical plane in the open is, which faces so many degrees of the compass
  sensors=3000               while the mean illuminance of the sensors, blinds open, is above so many lx"""

WORKDAYS = "workdays"
"""Word for Monday to Friday."""

_BOUND = re.compile(r"(sun|horizontal|sensors|facade)=(?:([^:]+):)?([^:]+)")


def find_blinds(options, objects: dict[str, str]) -> list[tuple[str, ...]]:
    """Return the ids of the closed blinds of each group of windows; ``objects``: ids of the scene's by name."""
    import bpy

    made = []
    for name in options.blinds:
        collection = bpy.data.collections.get(name)
        if collection is None:
            raise SceneError(f"{options.file}: there is no collection named '{name}'")
        made.append(find_keys(objects, meshes_of(collection), f"{options.file}: the scene"))
    return made


def read_rule(text: str):
    """Read a rule for blinds; return a function that makes `blinds.Rule` objects of it, given --north. [degree]"""
    found = _BOUND.fullmatch(text)
    if found is not None:
        kind, azimuth, bound = found.groups()
        if (kind == "facade") != (azimuth is not None):
            raise argparse.ArgumentTypeError(f"expected facade=AZIMUTH:BOUND, found '{text}'")
        return _of_bound(kind, real(-360.0, 360.0)(azimuth or "0"), real(0.0)(bound))
    if text in {"lm83", "closed"}:
        return _of_word(text)
    name, _, path = text.partition("=")
    if name == "table" and path:
        return _of_table(path)
    return _of_clock(text)


def _of_bound(kind: str, azimuth: float, bound: float):
    def make(north: float):
        from ...engine.daylight.blinds import PlaneBound, SensorBound, SunBound

        if kind == "horizontal":
            return (PlaneBound(bound),)
        if kind == "sun":
            return (SunBound(bound),)
        if kind == "sensors":
            return (SensorBound(bound),)
        turn = math.radians(azimuth - north)
        return (PlaneBound(bound, (math.sin(turn), math.cos(turn), 0.0)),)

    return make


def _of_word(word: str):
    def make(north: float):
        from ...engine.daylight.blinds import FixedTimes, StandardRule

        return (StandardRule() if word == "lm83" else FixedTimes(),)

    return make


def _of_table(path: str):
    def make(north: float):
        from ...engine.daylight.blinds import read_state_tables

        return read_state_tables(path)

    return make


def _of_clock(text: str):
    parts = [part.strip() for part in text.split(",")]
    is_workdays = WORKDAYS in parts
    parts = [part for part in parts if part != WORKDAYS]
    given = stretch(",".join(parts)) if parts else {}

    def make(north: float):
        from ...engine.daylight import occupancy
        from ...engine.daylight.blinds import FixedTimes
        from ...engine.sky.clock_range import ClockRange

        days = occupancy.WORKDAYS if is_workdays else occupancy.EVERY_DAY
        return (FixedTimes(ClockRange(**given), days),)

    return make


def find_rules(options) -> tuple:
    """Return the rules for blinds that were asked for, in the order of their groups."""
    return tuple(rule for make in options.blinds_when for rule in make(options.north))


def keep_states(options, job: YearJob):
    """Return what traces a state for a job, and keeps it in a file, or finds it there if ``options.resume`` is on."""
    from ...engine.daylight.kept import read_coefficients, write_coefficients
    from ...engine.formats.checkpoint import digest

    def find(number: int, scene: str, sensors, trace):
        order = digest((job.order, sensors, job.transport))
        path = options.output / f"traced_{number}.lumenray"
        if options.resume and path.exists():
            return read_coefficients(path, scene, order)
        made = trace()
        options.output.mkdir(parents=True, exist_ok=True)
        write_coefficients(path, made, scene, order)
        return made

    return find
