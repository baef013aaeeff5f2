"""All values of a report as JSON and as rows of comma-separated text."""

import csv
from pathlib import Path

import numpy as np

from ..formats.report import known, write_json
from ..judgement.assessment import Assessment
from ..judgement.verdict import State, Verdict
from ..reading.whole_file import write_whole
from .results import LightingScene, LuminaireSheet, Report, SensorArea

COLUMNS = (
    "lighting_scene", "area", "quantity", "x", "y", "z", "nx", "ny", "nz", "value", "standard_error", "unit",
)  # fmt: skip


def write_values(path, report: Report) -> Path:
    """Write a row for every sensor and lighting scene.

    Raises
    ------
    FileFormatError    The file cannot be written.
    """
    with write_whole(path, "utf-8") as file:
        file.writelines(f"# {' '.join(remark.split())}\n" for remark in report.remarks)
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for scene in report.scenes:
            for area in scene.areas:
                for place, normal, value, error in zip(
                    area.positions, area.normals, area.values, area.errors, strict=True
                ):
                    numbers = [f"{each:.7g}" for each in (*place, *normal)]
                    told = [f"{value:.7g}", f"{error:.3g}"] if np.isfinite(value) else ["", ""]
                    head = (scene.name, area.name, area.quantity)
                    writer.writerow([*head, *numbers, *told, area.unit])
    return Path(path)


def write_document(path, report: Report) -> Path:
    """Write all of a report but its pictures as JSON.

    Raises
    ------
    FileFormatError    The file cannot be written.
    """
    return write_json(path, describe(report))


def describe(report: Report) -> dict:
    """Return a report as plain data; what is not known is None."""
    schedule, floor = report.schedule, report.floor
    watts = schedule.watts if schedule.fittings else None
    return {
        "title": report.title,
        "client": report.client,
        "author": report.author,
        "date": report.date,
        "file": report.file,
        "engine": {"version": report.version, "transport": report.transport},
        "maintenance_factor": report.maintenance,
        "lighting_scenes": [_describe_scene(scene) for scene in report.scenes],
        "luminaires": [_describe_luminaire(each) for each in report.luminaires],
        "count": schedule.count,
        "luminous_flux_lm": schedule.luminous_flux,
        "watts": watts,
        "floor": None if floor is None else {"name": floor.name, "area_m2": floor.area},
        "watts_per_m2": None if floor is None or watts is None else watts / floor.area,
        "other_lights": [vars(each) for each in report.others],
        "settings": dict(report.settings),
        "remarks": list(report.remarks),
    }


def _describe_scene(scene: LightingScene) -> dict:
    return {
        "name": scene.name,
        "levels": scene.levels,
        "state": None if scene.state is State.UNKNOWN else scene.state.value,
        "areas": [_describe_area(area) for area in scene.areas],
    }


def _describe_area(area: SensorArea) -> dict:
    figures = area.figures
    row = {
        "name": area.name,
        "quantity": area.quantity,
        "unit": area.unit,
        "mean": known(figures.mean),
        "mean_standard_error": known(figures.mean_error),
    }
    for key, extreme in (
        ("minimum", figures.least),
        ("maximum", figures.largest),
        ("uniformity_u0", figures.overall),
        ("diversity_ud", figures.diversity),
    ):
        row[key], row[f"{key}_range"] = (
            known(extreme.value),
            [known(extreme.low), known(extreme.high)],
        )
    return row | {
        "verdict": None if area.assessment is None else _describe_assessment(area.assessment),
        "observers": [_describe_limit(each) for each in area.observers],
        "not_judged": area.problem,
        "out_of_date": area.changed,
        "samples": area.samples,
        "seed": area.seed,
        "scene_hash": area.scene_hash,
        "simplifications_at_most": area.simplified,
        "method": area.method,
        "positions": _numbers(area.positions),
        "normals": _numbers(area.normals),
        "values": _numbers(area.values),
        "standard_error": _numbers(area.errors),
    }


def _describe_assessment(made: Assessment) -> dict:
    return {
        "requirement": made.requirement.key,
        "standard": made.requirement.standard,
        "title": made.requirement.title,
        "area": made.area,
        "maintenance_factor": made.maintenance,
        "state": made.state.value,
        "seconds_more": made.seconds,
        "limits": [_describe_limit(each) for each in made.verdicts],
    }


def _describe_limit(made: Verdict) -> dict:
    found = made.found
    return {
        "name": made.name,
        "limit": made.limit,
        "is_most": made.is_most,
        "state": made.state.value,
        "value": None if found is None else known(found.value),
        "range": None if found is None else [known(found.low), known(found.high)],
    }


def _describe_luminaire(sheet: LuminaireSheet) -> dict:
    fitting = sheet.fitting
    return {
        "name": fitting.name,
        "count": fitting.count,
        "luminous_flux_lm": fitting.luminous_flux,
        "watts": fitting.watts,
        "facts": dict(sheet.facts),
        "ugr_table": None if sheet.ugr is None else _numbers(sheet.ugr.values),
        "no_ugr_table": sheet.problem,
    }


def _numbers(values) -> list:
    """Nested lists of numbers of seven digits; what is no number is None."""
    values = np.asarray(values, dtype=np.float64)
    return [
        _numbers(each) if each.ndim else (float(f"{each:.7g}") if np.isfinite(each) else None)
        for each in values
    ]
