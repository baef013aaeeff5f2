"""Readings of sensors as files: rows of comma-separated text, and a JSON document with figures."""

import csv
from pathlib import Path

import numpy as np

from ...engine.analysis.sensor_colours import tell_columns
from ...engine.formats.report import known, write_json
from ...engine.light_mix import LightMix
from ...engine.luminaires.distribution import flux
from ...engine.reading.whole_file import write_whole
from .goniometers import error_of, measured_of
from .places import GLARE, INTENSITY, LUMINANCE
from .readings import Readings

COLUMNS = (
    "object", "quantity", "x", "y", "z", "nx", "ny", "nz", "value", "standard_error", "unit",
)  # fmt: skip
"""Of the rows; light groups that were kept apart follow, at the flux of the scene, and what spectra tell."""


def write_rows(path, named, levels: LightMix, remarks=()) -> Path:
    """Write a row for every sensor.

    Parameters
    ----------
    path : str or Path
    named : list of (str, Readings)    With the names of their objects.
    levels : LightMix    Of the light groups.
    remarks : iterable of str    Lines that a reader of the numbers has to know, each behind a ``#``.

    Raises
    ------
    FileFormatError    The file cannot be written.
    """
    groups = list(dict.fromkeys(g for _, readings in named for g in readings.groups if g))
    spectral = {
        name: tell_columns(readings.mixed_spectra(levels))
        for name, readings in named
        if readings.has_spectrum
    }
    titles = list(next(iter(spectral.values()), ()))
    with write_whole(path, "utf-8") as file:
        file.writelines(f"# {remark}\n" for remark in remarks)
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*COLUMNS, *(f"value_{group}" for group in groups), *titles])
        for name, readings in named:
            values, errors = readings.mixed(levels)
            for k, (value, error) in enumerate(zip(values, errors, strict=True)):
                place = [*readings.positions[k], *readings.normals[k]]
                parts = [
                    f"{readings.values[readings.groups.index(group)][k]:.7g}"
                    if group in readings.groups
                    else ""
                    for group in groups
                ]
                writer.writerow(
                    [
                        name,
                        readings.quantity.lower(),
                        *(f"{v:.7g}" for v in place),
                        "" if np.isnan(value) else f"{value:.7g}",
                        "" if np.isnan(error) else f"{error:.3g}",
                        readings.unit,
                        *parts,
                        *(_cell(spectral[name][title][k]) for title in titles if name in spectral),
                    ]
                )
    return Path(path)


def write_document(
    path,
    file: str,
    named,
    levels: LightMix,
    conversion=(),
    notes=(),
    shortfall: str = "",
    requirement: dict | None = None,
    decisions=(),
) -> Path:
    """Write figures of every object and all readings as JSON; parameters as of `write_rows`.

    ``requirement``: verdicts as of `judging.describe`; ``decisions``: how it was computed, and what was simplified.

    Raises
    ------
    FileFormatError    The file cannot be written.
    """
    first = named[0][1]
    is_mixed = any(readings.groups != ("",) for _, readings in named)
    content = {
        "scene": {"file": file, "hash": first.scene_hash},
        "seed": first.seed,
        "goal": {"reached": not shortfall, "shortfall": shortfall},
        "light_mix": levels.text() if is_mixed else "",
        "requirement": requirement,
        "sensors": [describe_readings(name, readings, levels) for name, readings in named],
        "decisions": list(decisions),
        "notes": list(notes),
        "conversion": list(conversion),
    }
    return write_json(path, content)


def describe_readings(name: str, readings: Readings, levels: LightMix) -> dict:
    """Figures and readings of an object as plain data."""
    values, errors = readings.mixed(levels)
    row = {"name": name, "quantity": _name(readings.quantity), "unit": readings.unit}
    row |= _luminaire(readings) if readings.is_distribution else _figures(readings, levels)
    return row | {
        "lacks": readings.lacks,
        "simplifications_at_most": readings.simplified,
        "spectral": _spectral(readings, levels),
        "samples": readings.samples,
        "method": readings.method,
        "grid": list(readings.shape),
        "positions": _numbers(readings.positions),
        "normals": _numbers(readings.normals),
        "values": _numbers(values),
        "standard_error": _numbers(errors),
        "light_groups": {
            group: _numbers(part)
            for group, part in zip(readings.groups, readings.values, strict=True)
            if group
        },
    }


def _figures(readings: Readings, levels: LightMix) -> dict:
    figures = readings.figures(levels)
    row = {"mean": known(figures.mean), "mean_standard_error": known(figures.mean_error)}
    for key, extreme in (
        ("minimum", figures.least),
        ("maximum", figures.largest),
        ("uniformity_u0", figures.overall),
        ("diversity_ud", figures.diversity),
    ):
        row[key] = known(extreme.value)
        row[f"{key}_range"] = [known(extreme.low), known(extreme.high)]
    return row


def _spectral(readings: Readings, levels: LightMix) -> dict | None:
    """Action on the eye and colours by sensor; None where the spectrum was not asked for."""
    if not readings.has_spectrum:
        return None
    columns = tell_columns(readings.mixed_spectra(levels))
    return {title: _numbers(values) for title, values in columns.items()}


def _cell(value) -> str:
    return "" if np.isnan(value) else f"{value:.7g}"


def _luminaire(readings: Readings) -> dict:
    measured = measured_of(readings)
    return {
        "luminous_flux_lm": known(flux(measured.distribution)),
        "maximum": known(float(measured.distribution.intensity.max())),
        "standard_error_of_maximum": known(error_of(measured)),
    }


def _name(quantity: str) -> str:
    plain = {LUMINANCE: "luminance", GLARE: "unified glare rating", INTENSITY: "luminous intensity"}
    return plain.get(quantity, f"{quantity.lower()} illuminance")


def _numbers(values) -> list:
    """Nested lists of numbers of seven digits, None for what is none."""
    values = np.asarray(values, dtype=np.float64)
    return [_numbers(each) if each.ndim else known(float(f"{each:.7g}")) for each in values]
