"""What an area's figures say of a requirement."""

import math
from dataclasses import dataclass

from ..accuracy.extremes import Extreme
from ..errors import SceneError
from .figures import AreaFigures
from .requirement import AREAS, LIGHT, LIMITS, MOST, RATIOS, Requirement
from .verdict import Range, State, Verdict, judge, more_of, overall, reach

EXTREMES_REACH = 1.959964
"""Half width of ranges of extremes, in standard errors of a normal value. [-]"""


@dataclass(frozen=True)
class Assessment:
    """How an area stands to a requirement.

    Parameters
    ----------
    requirement : Requirement
    area : str    One of `AREAS`.
    maintenance : float    Maintenance factor that the values were multiplied by. [-]
    verdicts : tuple of Verdict
    state : State    Of all that was measured.
    seconds : float or None    How much longer until all is as likely decided as not; None where nothing is open, or it will
        never be. [s]
    """

    requirement: Requirement
    area: str
    maintenance: float
    verdicts: tuple[Verdict, ...]
    state: State
    seconds: float | None


def count_limits(requirement: Requirement, area: str, is_modified: bool = False) -> int:
    """How many limits share the probability of a wrong verdict."""
    return len(_limits(requirement, area, is_modified)) + len(requirement.light)


def assess(
    requirement: Requirement,
    area: str,
    figures: AreaFigures,
    seconds: float,
    maintenance: float = 1.0,
    light: dict[str, Range] | None = None,
    is_modified: bool = False,
    ratios: dict[str, Range] | None = None,
    count: int | None = None,
) -> Assessment:
    """Judge an area by a requirement.

    Parameters
    ----------
    requirement : Requirement
    area : str    One of those that the requirement speaks of.
    figures : AreaFigures    As they are computed, with tails of `verdict.tail` of `count_limits`.
    seconds : float    Time that it took to know them. [s]
    maintenance : float    Factor on mean, least and largest; 1 where luminaires have theirs already. [-]
    light : dict of str to Range    By `requirement.LIGHT`, what is known.
    is_modified : bool    Whether the modified mean is asked for, where there is one.
    ratios : dict of str to Range    What is known of roads besides, by `requirement.RATIOS`.
    count : int or None    How many limits share the probability of a wrong verdict, if more than those of the area.

    Raises
    ------
    SceneError    The requirement does not speak of the area, or the factor is not usable.
    """
    if not 0.0 < maintenance <= 1.0:
        raise SceneError(
            f"the maintenance factor is {maintenance:g}, expected a number above 0 up to 1"
        )
    limits = _limits(requirement, area, is_modified)
    count = count or count_limits(requirement, area, is_modified)
    known = {
        "mean": figures.mean,
        "modified": figures.mean,
        "minimum": figures.minimum,
        "uniformity": figures.uniformity,
        "diversity": figures.diversity,
        **(ratios or {}),
    }
    verdicts = []
    for name, limit in limits.items():
        found = known.get(name)
        if found is not None and name not in RATIOS:
            found = Range(*(maintenance * each for each in (found.value, found.low, found.high)))
        verdicts.append(judge(LIMITS[name], limit, found, count))
    for name, limit in requirement.light.items():
        verdicts.append(judge(LIGHT[name], limit, (light or {}).get(name), count, name in MOST))
    more = more_of(verdicts)
    left = None if more is None else more * seconds
    return Assessment(requirement, area, maintenance, tuple(verdicts), overall(verdicts), left)


def figures_of_map(made, limits: int) -> AreaFigures:
    """Figures of a lux map (`baking.order.LuxMap`), for a requirement with so many limits."""
    width = reach(limits)
    error = width * made.mean_standard_error
    mean = Range(made.mean, max(made.mean - error, 0.0), made.mean + error)
    minimum, maximum, uniformity = (
        _widened(each, width / EXTREMES_REACH)
        for each in (made.least, made.largest, made.uniformity)
    )
    low = minimum.low / maximum.high if maximum.high > 0.0 else 0.0
    high = min(minimum.high / maximum.low, 1.0) if maximum.low > 0.0 else 1.0
    value = minimum.value / maximum.value if maximum.value > 0.0 else 0.0
    return AreaFigures(mean, minimum, maximum, uniformity, Range(value, low, high))


def tell(made: Assessment) -> list[str]:
    """Lines for people: the verdict of all, then of each limit."""
    from ..accuracy.stopping import format_seconds

    requirement = made.requirement
    words = made.state.value
    if made.state is State.UNDECIDED:
        words += (
            ": value and limit are the same as far as can be told"
            if made.seconds is None
            else f": about {format_seconds(made.seconds)} more"
        )
    unknown = [each.name for each in made.verdicts if each.state is State.UNKNOWN]
    if unknown and made.state is not State.UNKNOWN:
        words += f" (without {', '.join(unknown)}, not measured)"
    title = f"{requirement.key}, {made.area} ({requirement.standard}: {requirement.title})"
    lines = [f"{title}: {words}"]
    for verdict in made.verdicts:
        lines.append(f"  {verdict.name}: {_words(verdict, AREAS[made.area])}")
    if made.maintenance != 1.0:
        lines.append(
            f"  illuminances are multiplied by the maintenance factor {made.maintenance:g}"
        )
    return lines


def describe(made: Assessment) -> dict:
    """The same as plain data for JSON."""
    return {
        "area": made.area,
        "state": made.state.value,
        "maintenance": made.maintenance,
        "seconds_more": made.seconds,
        "limits": [describe_limit(each) for each in made.verdicts],
    }


def describe_limit(verdict: Verdict) -> dict:
    """A verdict as plain data for JSON; numbers that are not finite are null."""
    found = verdict.found
    values = [None] * 3
    if found is not None:
        ends = (found.value, found.low, found.high)
        values = [each if math.isfinite(each) else None for each in ends]
    return {
        "name": verdict.name,
        "limit": verdict.limit,
        "is_most": verdict.is_most,
        "value": values[0],
        "range": values[1:],
        "state": verdict.state.value,
    }


def _words(verdict: Verdict, unit: str) -> str:
    is_plain = verdict.name in {LIMITS[name] for name in RATIOS} | set(LIGHT.values())
    unit = "" if is_plain else f" {unit}"
    asked = f"{'at most' if verdict.is_most else 'at least'} {verdict.limit:g}{unit}"
    if verdict.found is None:
        return f"{verdict.state.value} ({asked})"
    found = verdict.found
    held = f"{found.value:.3g}{unit} ({found.low:.3g} to {found.high:.3g}), {asked}"
    return f"{verdict.state.value}: {held}"


def _limits(requirement: Requirement, area: str, is_modified: bool) -> dict[str, float]:
    """Limits of an area: of the two means the one that is asked for."""
    if area not in requirement.areas:
        there = ", ".join(requirement.areas)
        raise SceneError(f"{requirement.key} asks nothing of the area '{area}', but of {there}")
    limits = dict(requirement.areas[area])
    modified = limits.pop("modified", None)
    if is_modified and modified is not None:
        limits.pop("mean", None)
        limits = {"modified": modified, **limits}
    return limits


def _widened(extreme: Extreme, factor: float) -> Range:
    value, low, high = extreme.value, extreme.low, extreme.high
    return Range(value, max(value - factor * (value - low), 0.0), value + factor * (high - value))
