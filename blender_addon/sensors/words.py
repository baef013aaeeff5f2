"""What sensors told, in words for panels and tables."""

import functools
import math

import numpy as np

from ...engine.accuracy.readings import Figures, judge_readings
from ...engine.analysis.sensor_colours import find_colours
from ...engine.light_mix import NEUTRAL, LightMix
from ...engine.photometry.alpha_opic import MELANOPIC
from ...engine.requirements.budget import tell_parts
from .. import readout
from .goniometers import WHOLE, describe_intensities
from .judging import lacks_of
from .readings import Readings, readings_of
from .results import why_outdated
from .settings import QUANTITIES

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
    if readings.is_rating:
        lines += _describe_ratings(readings, figures, levels)
        lacks = lacks_of(readings, levels)
        if lacks:
            lines.append(("not in it", lacks))
    elif readings.is_distribution:
        lines = [lines[0], *describe_intensities(readings)]
    else:
        lines += describe_figures(figures, count, readings.unit)
        parts = tell_parts(readings.mean_error(levels), readings.simplified)
        lines += [("error of the mean", parts)] if parts else []
    lines += describe_light(readings, levels)
    words = levels.text()
    if words and readings.is_rating and not readings.is_told(levels):
        words = "glare is of all light as in the scene; measure again for these levels"
    elif words and readings.is_distribution:
        words = WHOLE
    elif words and not readings.is_told(levels):
        words = "measure again to have light groups apart"
    if words:
        lines.append(("light mix", words))
    lines.append(("samples", f"{readings.samples} each, seed {readings.seed}"))
    changed = why_outdated(empty)
    if changed:
        lines.append(("out of date", f"changed since: {changed}"))
    return tuple(lines)


def brief(readings: Readings, levels: LightMix = NEUTRAL) -> str:
    """What sensors told, in few words."""
    figures = readings.figures(levels)
    if readings.is_rating:
        if math.isnan(figures.mean):
            return "no glare"
        return f"UGR {'up to ' * (len(readings.positions) > 1)}{figures.largest.value:.1f}"
    if readings.is_distribution:
        found = dict(describe_intensities(readings))
        return f"{found['luminous flux']}, {found.get('largest intensity', 'dark')}"
    text = f"{figures.mean:.4g} {readings.unit}"
    if len(readings.positions) > 1:
        text += f", U0 {figures.overall.value:.2f}"
    return text


def describe_light(readings: Readings, levels: LightMix = NEUTRAL) -> tuple[tuple[str, str], ...]:
    """Labels and values of what the light at sensors does to the eye, and of its colour; nothing where it is not known."""
    return _describe_light(readings, levels) if readings.has_spectrum else ()


# Panels draw often, and indices take a while.
@functools.lru_cache(maxsize=32)
def _describe_light(readings: Readings, levels: LightMix) -> tuple[tuple[str, str], ...]:
    spectra = readings.mixed_spectra(levels)
    doses, errors = (
        each[:, MELANOPIC]
        for each in (spectra.equivalent_daylight, spectra.equivalent_daylight_error)
    )
    found = judge_readings(doses, errors, readings.has_common)
    lines = [("melanopic EDI", f"{readout.format_estimate(found.mean, found.mean_error)} lx")]
    if len(doses) > 1:
        lines.append(("least melanopic", _range(found.least, " lx")))
    colours = find_colours(spectra.edges, spectra.bands.mean(axis=0)[None])
    if np.isnan(colours.temperature[0]):
        return (*lines, ("colour", "none: too far from white"))
    lines.append(("colour", f"{colours.temperature[0]:.0f} K, Duv {colours.duv[0]:+.4f}"))
    indices = zip(
        ("Ra", "Rf", "Rg"), (colours.rendering, colours.fidelity, colours.gamut), strict=True
    )
    lines.append(("indices", ", ".join(f"{name} {value[0]:.0f}" for name, value in indices)))
    return tuple(lines)


def _describe_ratings(
    readings: Readings, figures: Figures, levels: LightMix
) -> list[tuple[str, str]]:
    """Labels and values of the glare of observers."""
    values, errors = readings.mixed(levels)
    if len(values) == 1:
        if math.isnan(values[0]):
            return [("UGR", "none: no glare source")]
        return [("UGR", readout.format_estimate(values[0], errors[0]))]
    dark = int(np.isnan(values).sum())
    if dark == len(values):
        return [("UGR", "none: no glare source")]
    lines = [("UGR", f"{figures.least.value:.1f} to {figures.largest.value:.1f}")]
    if dark:
        lines.append(("no glare source", f"{dark} of {len(values)}"))
    return lines


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
