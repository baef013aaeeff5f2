"""Verdicts on a scene's sensors as its panel tells them."""

import functools

from ...engine.light_mix import LightMix
from ..rendering.light_mix import levels_of
from . import judging, results
from .readings import read_readings
from .shipped import shipped_requirements


def texts_of(scene, empties) -> tuple[str, ...]:
    """Return lines on what the sensors of a scene say of its requirement, the verdict on all of it first.

    Sensors that were not measured, or are out of date, are told and not judged.
    """
    settings = scene.lumenray.sensors
    held = [empty for empty in empties if empty.lumenray.sensor.kept]
    old = [empty.name for empty in held if results.is_outdated(empty)]
    current = [empty for empty in held if empty.name not in old]
    notes = []
    if old:
        notes.append(f"Out of date, not judged: {', '.join(old)}")
    if not current:
        return (*notes, "Measure to have verdicts")
    named = tuple(
        (empty.name, empty.lumenray.sensor.kept, empty.lumenray.sensor.area) for empty in current
    )
    told = _judge(
        named, settings.requirement, levels_of(scene), settings.maintenance, settings.modified
    )
    return (*told, *notes)


@functools.lru_cache(maxsize=8)
def _judge(
    named: tuple, key: str, levels: LightMix, maintenance: float, is_modified: bool
) -> tuple[str, ...]:
    requirement = shipped_requirements().get(key)
    if requirement is None:
        return (f"There is no requirement '{key}'",)
    found = [(name, read_readings(text), stated) for name, text, stated in named]
    areas = [
        (name, readings, judging.area_of(readings, stated))
        for name, readings, stated in found
        if readings is not None
    ]
    return tuple(
        judging.tell(judging.judge_sensors(areas, requirement, levels, maintenance, is_modified))
    )
