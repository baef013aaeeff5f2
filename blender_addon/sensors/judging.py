"""Verdicts on the readings of a scene's sensors by one requirement, whose limits they share."""

import functools
import math
from dataclasses import dataclass, replace

from ...engine.accuracy.readings import FREEDOM
from ...engine.analysis.glare_sources import THRESHOLD
from ...engine.analysis.sensor_colours import rendering_range
from ...engine.judgement.assessment import Assessment, assess, count_limits, describe_limit
from ...engine.judgement.assessment import describe as describe_assessment
from ...engine.judgement.assessment import tell as tell_assessment
from ...engine.judgement.figures import find_figures
from ...engine.judgement.observers import judge_observers
from ...engine.judgement.requirement import LIGHT, Requirement
from ...engine.judgement.verdict import Range, State, Verdict, overall, reach, tail
from ...engine.light_mix import NEUTRAL, LightMix
from ...engine.observers import FREEDOM as OBSERVER_FREEDOM
from ...engine.photometry.alpha_opic import MELANOPIC
from .readings import Readings

DIMMED = f"it was rated by an older version, to which lamps dimmed below {THRESHOLD:g} cd/m² are no sources: measure again"

RENDERING = "ra"
"""Of `LIGHT`."""

MELANOPIC_AREA = "melanopic"
"""Area whose illuminances are melanopic equivalent daylight ones."""

MEASURE_DIRECT = "measure again, so that it is known apart"

UNMIXED = "its light groups were not measured apart; measure again with light groups"

ALL_LIGHT = "ratings of glare do not add up: it was not rated with the light groups at these levels; measure again"

BY_QUANTITY = {"PLANAR": "task", "CYLINDRICAL": "cylindrical"}
"""Areas of sensors that state none, by what they measure."""


@dataclass(frozen=True)
class Judged:
    """Verdicts on a scene's sensors.

    Parameters
    ----------
    requirement : Requirement
    areas : dict of str to Assessment    By the name of the object.
    observers : dict of str to tuple of Verdict    On the UGR of each observer, likewise.
    skipped : dict of str to str    Objects that are not judged, and why.
    """

    requirement: Requirement
    areas: dict[str, Assessment]
    observers: dict[str, tuple[Verdict, ...]]
    skipped: dict[str, str]

    @property
    def verdicts(self) -> list[Verdict]:
        """All of them."""
        made = [each for judged in self.areas.values() for each in judged.verdicts]
        return made + [each for judged in self.observers.values() for each in judged]

    @property
    def state(self) -> State:
        """Of all that was measured."""
        return overall(self.verdicts)

    @property
    def missing(self) -> list[str]:
        """What the requirement asks for that no sensor tells, in words."""
        known = {judged.area for judged in self.areas.values()}
        seen = [each for judged in self.observers.values() for each in judged]
        is_known = any(each.state is not State.UNKNOWN for each in seen)
        told = {LIGHT["ugr"]} if is_known else set()
        judged = [each for made in self.areas.values() for each in made.verdicts]
        told |= {each.name for each in judged if each.state is not State.UNKNOWN}
        return [area for area in self.requirement.areas if area not in known] + [
            LIGHT[name] for name in self.requirement.light if LIGHT[name] not in told
        ]


def area_of(readings: Readings, stated: str) -> str | None:
    """Area that sensors are judged as; ``stated``: one of `settings.JUDGED_AREAS`. None: they are not."""
    if stated == "AUTO":
        return BY_QUANTITY.get(readings.quantity)
    return None if stated == "NONE" or readings.unit != "lx" else stated.lower()


def judge_sensors(
    named,
    requirement: Requirement,
    levels: LightMix = NEUTRAL,
    maintenance: float = 1.0,
    is_modified: bool = False,
) -> Judged:
    """Judge readings.

    Parameters
    ----------
    named : list of (str, Readings, str or None)    Name of the object, its readings and their area, see `area_of`.
    requirement : Requirement
    levels : LightMix    Of the light groups; glare counts where it was rated with them.
    maintenance : float    Factor on illuminances. [-]
    is_modified : bool    Whether the modified mean is asked for.

    Raises
    ------
    SceneError    The maintenance factor is not usable.

    Notes
    -----
    All limits of all objects share the probability of a wrong verdict, so that it holds for what is said of the whole.
    """
    skipped, chosen, seen = {}, [], []
    for name, readings, area in named:
        why = _why_skipped(requirement, readings, area, levels)
        if why:
            skipped[name] = why
        elif readings.is_rating:
            seen.append((name, readings))
        else:
            chosen.append((name, readings, area))
    asked = {name: _asked_of(requirement, readings) for name, readings, _ in chosen}
    count = sum(count_limits(asked[name], area, is_modified) for name, _, area in chosen)
    count += sum(len(readings.positions) for _, readings in seen)
    areas, observers = {}, {}
    for name, readings, area in chosen:
        values, errors = _values_of(readings, area, requirement.is_direct, levels)
        figures = find_figures(values, errors, tail(count), FREEDOM, readings.has_common)
        areas[name] = assess(
            asked[name],
            area,
            figures,
            readings.seconds,
            maintenance,
            light=_light_of(asked[name], readings, levels, count),
            is_modified=is_modified,
            count=count,
        )
    for name, readings in seen:
        ratings = zip(*readings.mixed(levels), strict=True)
        limit = requirement.light["ugr"]
        verdicts = judge_observers(limit, list(ratings), OBSERVER_FREEDOM, count)
        lacks = lacks_of(readings, levels)
        if lacks:
            # More glare could only be worse.
            verdicts = [
                each if each.state is State.NOT_MET else replace(each, state=State.UNKNOWN)
                for each in verdicts
            ]
            skipped[name] = lacks
        observers[name] = tuple(verdicts)
    return Judged(requirement, areas, observers, skipped)


def lacks_of(readings: Readings, levels: LightMix) -> str:
    """What ratings lack with the groups at some levels, in words; empty: nothing."""
    is_low = levels.is_dimmed and not readings.keeps_sources
    return "; ".join(filter(None, [readings.lacks, DIMMED if is_low else ""]))


def _asked_of(requirement: Requirement, readings: Readings) -> Requirement:
    """Return what a requirement asks that sensors can tell: of the light as a whole its colour rendering, by spectra."""
    has_rendering = readings.has_spectrum and RENDERING in requirement.light
    light = {RENDERING: requirement.light[RENDERING]} if has_rendering else {}
    return replace(requirement, light=light)


def _light_of(asked: Requirement, readings: Readings, levels: LightMix, count: int):
    """What is known of the light as a whole and asked for, by names of `LIGHT`."""
    found = _rendering_of(readings, levels, count) if asked.light else None
    return {} if found is None else {RENDERING: found}


# Panels judge whenever they are drawn, and the index takes a while.
@functools.lru_cache(maxsize=64)
def _rendering_of(readings: Readings, levels: LightMix, count: int) -> Range | None:
    """Range of the general colour rendering index of the mean light; ``count``: of limits."""
    spectra = readings.mixed_spectra(levels)
    share = 1.0 if readings.has_common else len(spectra.bands) ** 0.5
    noise = spectra.bands_error[0] / share
    found = rendering_range(spectra.edges, spectra.bands.mean(axis=0), noise, reach(count))
    return None if found is None else Range(*found)


def _values_of(readings: Readings, area: str, is_direct: bool, levels: LightMix):
    """Values of an area that count, and their standard errors. (n,), (n,) [lx]"""
    if area == MELANOPIC_AREA:
        spectra = readings.mixed_spectra(levels)
        both = spectra.equivalent_daylight, spectra.equivalent_daylight_error
        return tuple(each[:, MELANOPIC] for each in both)
    return readings.mixed_direct(levels) if is_direct else readings.mixed(levels)


def _why_skipped(requirement: Requirement, readings: Readings, area, levels: LightMix) -> str:
    """Why sensors are not judged; empty: they are."""
    if readings.is_rating:
        if not readings.is_told(levels):
            return ALL_LIGHT
        has_limit = "ugr" in requirement.light
        return "" if has_limit else f"{requirement.key} asks nothing of {LIGHT['ugr']}"
    if area is None:
        return "stands for no area"
    if area not in requirement.areas:
        return f"{requirement.key} asks nothing of the area '{area}'"
    if area == MELANOPIC_AREA and not readings.has_spectrum:
        return "its spectrum was not asked for; switch Spectrum on and measure again"
    if requirement.is_direct and not readings.has_direct:
        return f"{requirement.key} counts light that was not reflected; {MEASURE_DIRECT}"
    return "" if readings.is_told(levels) else UNMIXED


def tell(judged: Judged) -> list[str]:
    """Lines for people: the verdict of all, then of each object."""
    requirement = judged.requirement
    words = judged.state.value
    missing = judged.missing
    if missing and judged.state is not State.UNKNOWN:
        words += f" (without {', '.join(missing)}, not measured)"
    lines = [f"{requirement.key} ({requirement.standard}: {requirement.title}): {words}"]
    for name, assessment in judged.areas.items():
        first, *rest = tell_assessment(assessment)
        # The requirement has been named.
        lines.append(f"{name}, {assessment.area}: {first.rpartition('): ')[2]}")
        lines += rest
    for name, verdicts in judged.observers.items():
        lines.append(
            f"{name}, {verdicts[0].name} at most {verdicts[0].limit:g}: {overall(verdicts).value}"
        )
        for number, verdict in enumerate(verdicts, start=1):
            if len(verdicts) > 1 or verdict.state is not State.MET:
                lines.append(
                    f"  observer {number}: {verdict.state.value}, {tell_rating(verdict.found)}"
                )
            else:
                lines[-1] += f", {tell_rating(verdict.found)}"
    for name, why in judged.skipped.items():
        lines.append(f"{name}: {why}" if name in judged.observers else f"{name}: not judged, {why}")
    return lines


def tell_rating(found: Range) -> str:
    """A UGR with its range in words."""
    if not math.isfinite(found.value):
        return "no glare source"
    return f"{found.value:.1f} ({found.low:.1f} to {found.high:.1f})"


def describe(judged: Judged) -> dict:
    """Verdicts as plain data for JSON."""
    return {
        "key": judged.requirement.key,
        "title": judged.requirement.title,
        "standard": judged.requirement.standard,
        "state": judged.state.value,
        "not_measured": judged.missing,
        "areas": [
            {"object": name, **describe_assessment(assessment)}
            for name, assessment in judged.areas.items()
        ],
        "observers": [
            {
                "object": name,
                "state": overall(verdicts).value,
                "limits": [describe_limit(each) for each in verdicts],
            }
            for name, verdicts in judged.observers.items()
        ],
        "not_judged": judged.skipped,
    }
