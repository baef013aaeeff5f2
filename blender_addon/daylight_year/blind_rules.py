"""When blinds are closed, from what the panel says to the engine's rules."""

import math

import bpy

from ...engine.daylight.blinds import (
    FixedTimes,
    PlaneBound,
    Rule,
    SensorBound,
    SunBound,
    read_state_tables,
)
from ...engine.daylight.occupancy import EVERY_DAY, WORKDAYS
from ...engine.errors import SceneError
from ...engine.sky.clock_range import ClockRange


def find_rules(settings, north: float) -> tuple[Rule, ...]:
    """Return the rules for the blinds of all groups of windows; none: LM-83.

    Parameters
    ----------
    settings : LumenrayYearSettings
    north : float    Compass direction of the scene's +y axis. [degree]

    Raises
    ------
    LumenrayError    The table of states cannot be read, or the hours are none.
    """
    if settings.blinds is None:
        return ()
    match settings.blinds_rule:
        case "TIMES":
            months = settings.blinds_first_month, settings.blinds_last_month
            days = WORKDAYS if settings.blinds_workdays else EVERY_DAY
            hours = settings.blinds_start, settings.blinds_end
            return (FixedTimes(ClockRange(months, hours), days),)
        case "TABLE":
            if not settings.blinds_file:
                raise SceneError("no file with the states of the blinds is chosen")
            return read_state_tables(bpy.path.abspath(settings.blinds_file))
        case "SUN":
            return (SunBound(settings.blinds_irradiance),)
        case "HORIZONTAL":
            return (PlaneBound(settings.blinds_irradiance),)
        case "FACADE":
            turn = settings.blinds_azimuth - math.radians(north)
            facing = math.sin(turn), math.cos(turn), 0.0
            return (PlaneBound(settings.blinds_irradiance, facing),)
        case "SENSORS":
            return (SensorBound(settings.blinds_illuminance),)
    return ()
