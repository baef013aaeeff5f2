"""Verdicts on the sensors of a scene as labels and values of panels and tables."""

from ...engine.accuracy.stopping import format_seconds
from ...engine.judgement.assessment import Assessment
from ...engine.judgement.verdict import State
from ..rendering.lighting_scenes import Chosen
from .places import find_sensors
from .readings import readings_of
from .verdicts import judge_sensors, requirement_key


def tell_all(scene, chosen: Chosen) -> list[tuple[str, str]]:
    """Verdicts in a lighting scene on all sensors that something is required of, by their names."""
    lines = []
    for empty in find_sensors(scene):
        readings = readings_of(empty)
        if readings is None:
            if requirement_key(empty, chosen.name):
                lines.append((empty.name, "not measured"))
            continue
        made = judge_sensors(empty, readings, scene.lumenray.sensors, chosen.levels, chosen.name)
        if made.assessment is not None:
            lines.append((empty.name, tell_state(made.assessment)))
        elif made.problem:
            lines.append((empty.name, f"not judged: {made.problem}"))
    return lines


def tell_state(made: Assessment) -> str:
    """The verdict of a requirement in words."""
    if made.state is State.UNDECIDED and made.seconds is not None:
        return f"{made.state.value}: about {format_seconds(made.seconds)} more"
    return made.state.value


def tell_limits(made: Assessment) -> list[tuple[str, str]]:
    """The verdict of every limit that was measured, with the value and its range."""
    lines = []
    for each in made.verdicts:
        if each.found is not None:
            found = each.found
            words = f"{found.value:.3g} ({found.low:.3g} to {found.high:.3g})"
            asked = f"{'at most' if each.is_most else 'at least'} {each.limit:g}"
            lines.append((each.name, f"{each.state.value}: {words}, {asked}"))
    return lines
