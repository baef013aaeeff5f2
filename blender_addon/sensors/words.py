"""What sensors told, in words for panels and tables."""

from ...engine.accuracy.readings import Figures
from ...engine.light_mix import NEUTRAL, LightMix
from .. import readout
from ..rendering.light_mix import levels_of
from .readings import readings_of
from .results import why_outdated
from .settings import QUANTITIES
from .verdict_lines import tell_limits, tell_state
from .verdicts import judge_sensors

TITLES = {key: title for key, title, *_ in QUANTITIES}
"""Names of quantities."""


def describe(empty, levels: LightMix = NEUTRAL) -> tuple[tuple[str, str], ...]:
    """Labels and values of what the sensors of an empty told; nothing before they were measured."""
    readings = readings_of(empty)
    if readings is None:
        return ()
    figures = readings.figures(levels)
    count = len(readings.positions)
    lines = [("quantity", TITLES[readings.quantity].lower()), ("sensors", f"{count}")]
    lines += describe_figures(figures, count, readings.unit)
    words = levels.text()
    if words and readings.groups == ("",):
        words = "measure again to have light groups apart"
    if words:
        lines.append(("light mix", words))
    lines.append(("samples", f"{readings.samples} each, seed {readings.seed}"))
    changed = why_outdated(empty)
    if changed:
        lines.append(("out of date", f"changed since: {changed}"))
    return tuple(lines)


def describe_verdict(empty, scene) -> tuple[tuple[str, str], ...]:
    """Labels and values of how the sensors of an empty stand to what is required of them, with the light mix as it is."""
    readings = readings_of(empty)
    if readings is None:
        return ()
    made = judge_sensors(empty, readings, scene.lumenray.sensors, levels_of(scene))
    if made.problem:
        return (("verdict", f"not judged: {made.problem}"),)
    if made.assessment is None:
        return ()
    return (("verdict", tell_state(made.assessment)), *tell_limits(made.assessment))


def describe_figures(figures: Figures, count: int, unit: str = "lx") -> list[tuple[str, str]]:
    """Labels and values of figures of so many sensors."""
    mean = readout.format_estimate(figures.mean, figures.mean_error)
    if count == 1:
        return [("value", f"{mean} {unit}")]
    return [
        ("mean", f"{mean} {unit}"),
        ("minimum", _range(figures.least, f" {unit}")),
        ("maximum", _range(figures.largest, f" {unit}")),
        ("uniformity U0", _range(figures.overall, "")),
        ("diversity Ud", _range(figures.diversity, "")),
    ]


def _range(extreme, unit: str) -> str:
    if unit:
        value, low, high = (
            readout.format_number(x) for x in (extreme.value, extreme.low, extreme.high)
        )
    else:
        value, low, high = (f"{x:.3f}" for x in (extreme.value, extreme.low, extreme.high))
    return f"{value}{unit} ({low} to {high})"
