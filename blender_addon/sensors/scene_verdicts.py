"""Verdicts on all sensors of a scene in one of its lighting scenes, each by what is required of it."""

from dataclasses import dataclass, field

from ...engine.accuracy.stopping import format_seconds
from ...engine.judgement.assessment import Assessment
from ...engine.judgement.verdict import State, Verdict, overall
from ..rendering.lighting_scenes import Chosen
from . import judging
from .readings import readings_of
from .requirements import requirements_of
from .settings import find_sensors


@dataclass(frozen=True)
class SceneVerdicts:
    """How the sensors of a scene stand; by the names of their objects.

    Parameters
    ----------
    areas : dict of str to Assessment
    observers : dict of str to tuple of Verdict    On the UGR of each observer.
    problems : dict of str to str    Why sensors are not judged although something is required of them.
    """

    areas: dict[str, Assessment] = field(default_factory=dict)
    observers: dict[str, tuple[Verdict, ...]] = field(default_factory=dict)
    problems: dict[str, str] = field(default_factory=dict)


def required_of(empty, scene, lighting_scene: str = "") -> str:
    """Return the key of what is required of sensors in a lighting scene; empty: nothing."""
    settings = empty.lumenray.sensor
    wanted = {name.strip() for name in settings.lighting_scenes.split(",") if name.strip()}
    if wanted and lighting_scene and lighting_scene not in wanted:
        return ""
    return settings.requirement.strip() or scene.lumenray.sensors.requirement.strip()


def judge_all(scene, chosen: Chosen, files=()) -> SceneVerdicts:
    """Judge all sensors of a scene that were measured, with the light groups as a lighting scene says.

    Sensors of one requirement share the probability of a wrong verdict. ``files``: of further requirements, see
    `requirements.requirements_of`.

    Raises
    ------
    FileFormatError    A file of requirements cannot be read.
    """
    made, settings = SceneVerdicts(), scene.lumenray.sensors
    by_key: dict[str, list] = {}
    for empty in find_sensors(scene):
        readings, key = readings_of(empty), required_of(empty, scene, chosen.name)
        if not key:
            continue
        if readings is None:
            made.problems[empty.name] = "not measured"
            continue
        if readings.is_rating and not readings.is_told(chosen.levels):
            made.problems[empty.name] = judging.ALL_LIGHT
            continue
        own = empty.lumenray.sensor
        area = judging.area_of(readings, own.area)
        if area is None and not readings.is_rating and not own.requirement:
            # Not meant by what is required of all.
            continue
        by_key.setdefault(key, []).append((empty.name, readings, area))
    known = requirements_of(scene, files)
    for key, named in by_key.items():
        if key not in known:
            words = f"there is no requirement '{key}'; 'lumenray requirements' lists them"
            made.problems.update(dict.fromkeys((name for name, *_ in named), words))
            continue
        judged = judging.judge_sensors(
            named, known[key], chosen.levels, settings.maintenance, settings.modified
        )
        made.areas.update(judged.areas)
        made.observers.update(judged.observers)
        made.problems.update(judged.skipped)
    return made


def tell(verdicts: SceneVerdicts) -> list[tuple[str, str]]:
    """Labels and values of verdicts for panels."""
    lines = [(name, tell_state(made)) for name, made in verdicts.areas.items()]
    lines += [(name, overall(made).value) for name, made in verdicts.observers.items()]
    return lines + [(name, f"not judged: {why}") for name, why in verdicts.problems.items()]


def tell_state(made: Assessment) -> str:
    """The verdict of a requirement in words."""
    if made.state is State.UNDECIDED and made.seconds is not None:
        return f"{made.state.value}: about {format_seconds(made.seconds)} more"
    return made.state.value
