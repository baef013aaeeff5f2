"""Verdicts on a scene's sensors as its panel tells them."""

from dataclasses import dataclass

from ...engine.errors import LumenrayError
from ...engine.judgement.requirement import Requirement
from ...engine.light_mix import LightMix
from ..rendering.light_mix import levels_of
from . import judging, results
from .readings import read_readings
from .requirements import requirements_of


def texts_of(scene, empties) -> tuple[str, ...]:
    """Return lines on what the sensors of a scene say of its requirement, the verdict on all of it first.

    Sensors that were not measured, or are out of date, are told and not judged.
    """
    settings = scene.lumenray.sensors
    try:
        requirement = requirements_of(scene).get(settings.requirement)
    except LumenrayError as error:
        return (f"No verdict: {error}",)
    if requirement is None:
        return (f"There is no requirement '{settings.requirement}'",)
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
    state = (named, levels_of(scene), settings.maintenance, settings.modified)
    if _cache.state != state or _cache.requirement is not requirement:
        _cache.texts = _judge(requirement, *state)
        _cache.state, _cache.requirement = state, requirement
    return (*_cache.texts, *notes)


@dataclass
class _Cache:
    """Verdicts that a panel drew last, for it draws often."""

    state: tuple = ()
    requirement: Requirement | None = None
    texts: tuple[str, ...] = ()


_cache = _Cache()


def _judge(
    requirement: Requirement, named: tuple, levels: LightMix, maintenance: float, is_modified: bool
) -> tuple[str, ...]:
    found = [(name, read_readings(text), stated) for name, text, stated in named]
    areas = [
        (name, readings, judging.area_of(readings, stated))
        for name, readings, stated in found
        if readings is not None
    ]
    return tuple(
        judging.tell(judging.judge_sensors(areas, requirement, levels, maintenance, is_modified))
    )
