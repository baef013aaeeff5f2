"""Whether sensors do what is required of them, with the light groups at given levels, from what they told."""

from dataclasses import dataclass

from ...engine.accuracy.readings import FREEDOM
from ...engine.errors import LumenrayError, SceneError
from ...engine.judgement.assessment import Assessment, assess, count_limits
from ...engine.judgement.figures import find_figures
from ...engine.judgement.requirement import AREAS, Requirement
from ...engine.judgement.verdict import tail
from ...engine.light_mix import NEUTRAL, LightMix
from .places import LUMINANCE
from .readings import Readings
from .required import read_own

UNMIXED = "its light groups were not measured apart; measure again with light groups"


@dataclass(frozen=True)
class Judged:
    """How sensors stand: an assessment, or why there is none; neither: nothing is required."""

    assessment: Assessment | None = None
    problem: str = ""


def judge_sensors(
    empty, readings: Readings, settings, levels: LightMix = NEUTRAL, scene: str = ""
) -> Judged:
    """Judge the sensors of an empty.

    Parameters
    ----------
    empty : bpy.types.Object
    readings : Readings
    settings : LumenraySensorsSettings    Of the scene.
    levels : LightMix    Of the light groups.
    scene : str    Name of the lighting scene that has these levels, if any.
    """
    key = requirement_key(empty, scene)
    if not key:
        return Judged()
    try:
        return Judged(_judge(empty, readings, settings, levels, key))
    except LumenrayError as error:
        return Judged(problem=str(error))


def requirement_key(empty, scene: str = "") -> str:
    """Return the key of what is required of sensors in a lighting scene; empty: nothing."""
    settings = empty.lumenray.sensor
    wanted = {name.strip() for name in settings.lighting_scenes.split(",") if name.strip()}
    return settings.requirement.strip() if not (wanted and scene) or scene in wanted else ""


def area_of(empty, requirement: Requirement) -> str:
    """Return the area of a requirement that sensors are judged by."""
    settings = empty.lumenray.sensor
    if settings.area != "AUTO":
        return settings.area.lower()
    if settings.quantity == "CYLINDRICAL":
        return "cylindrical"
    return next(iter(requirement.areas), "task")


def _judge(empty, readings: Readings, settings, levels: LightMix, key: str) -> Assessment:
    known = read_own(settings)
    if key not in known:
        raise SceneError(f"there is no requirement '{key}'; 'lumenray requirements' lists them")
    requirement = known[key]
    area = area_of(empty, requirement)
    if (AREAS[area] == "cd/m2") != (readings.quantity == LUMINANCE):
        raise SceneError(f"{key} asks for {AREAS[area]}, but the sensors measure {readings.unit}")
    if not levels.is_neutral and readings.groups == ("",):
        raise SceneError(UNMIXED)
    limits = count_limits(requirement, area, settings.use_modified)
    if requirement.is_direct and not readings.has_direct:
        raise SceneError(f"{key} counts light that was not reflected, which was not measured; measure again")
    values, errors = (readings.mixed_direct if requirement.is_direct else readings.mixed)(levels)
    # Sensors may read the same cells, so that their errors do not cancel in the mean.
    figures = find_figures(values, errors, tail(limits), FREEDOM, has_common=True)
    return assess(
        requirement,
        area,
        figures,
        readings.seconds,
        settings.maintenance,
        is_modified=settings.use_modified,
    )
