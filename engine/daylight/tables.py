"""Figures of a daylight year as tables and as data for JSON."""

import csv
from pathlib import Path

import numpy as np

from ..reading.whole_file import write_whole
from ..sky.place import to_local
from .light import Light
from .study import Figures

COLUMNS = ("x", "y", "z", "nx", "ny", "nz")


def write_sensors(path, sensors: np.ndarray, areas: np.ndarray, figures: Figures, remarks=()):
    """Write every sensor's figures with their standard errors. ``sensors``: (n, 6) [m, -]; ``areas``: (n,) [m2]"""
    names = list(figures.sensors)
    heads = [head for name in names for head in (name, f"{name}_standard_error")]
    table = [each for name in names for each in _columns(figures.sensors[name])]
    with write_whole(path, "utf-8") as file:
        file.writelines(f"# {remark}\n" for remark in remarks)
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*COLUMNS, "area_m2", *heads])
        for place, area, *values in zip(sensors, areas, *table, strict=True):
            writer.writerow(
                [*(f"{v:.9g}" for v in place), f"{area:.6g}", *(f"{v:.6g}" for v in values)]
            )
    return Path(path)


def _columns(estimate) -> tuple[np.ndarray, np.ndarray]:
    return estimate.value, estimate.standard_error


def write_hours(path, light: Light, figures: Figures, zone: str, remarks=()):
    """Write the mean illuminance over the area of every lit hour, and which blinds are closed then."""
    year = light.year
    groups = range(1, len(figures.is_closed) + 1)
    with write_whole(path, "utf-8") as file:
        file.writelines(f"# {remark}\n" for remark in remarks)
        writer = csv.writer(file, lineterminator="\n")
        names = (
            "clock",
            "direct_normal_lx",
            "diffuse_horizontal_lx",
            "mean_lx",
            "standard_error_lx",
        )
        writer.writerow([*names, *(f"blinds_{group}" for group in groups)])
        for number, time in enumerate(year.middles[year.lit]):
            clock = to_local(time, zone)
            values = (
                year.direct_normal[number],
                year.diffuse_horizontal[number],
                figures.hourly.value[number],
                figures.hourly.standard_error[number],
            )
            closed = ("closed" if each[number] else "open" for each in figures.is_closed)
            writer.writerow(
                [clock.isoformat(timespec="minutes"), *(f"{v:.6g}" for v in values), *closed]
            )
    return Path(path)


def write_matrix(path, light: Light, zone: str, remarks=()):
    """Write the illuminance of every sensor at every lit hour, an hour a line, each followed by its standard error."""
    year = light.year
    values, errors = light.illuminance()
    heads = [head for k in range(1, light.sensors + 1) for head in (f"s{k}_lx", f"s{k}_error_lx")]
    with write_whole(path, "utf-8") as file:
        file.writelines(f"# {remark}\n" for remark in remarks)
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["clock", *heads])
        for number, time in enumerate(year.middles[year.lit]):
            row = np.stack([values[:, number], errors[:, number]], axis=1).reshape(-1)
            clock = to_local(time, zone).isoformat(timespec="minutes")
            writer.writerow([clock, *(f"{v:.5g}" for v in row)])
    return Path(path)


def summarise(figures: Figures) -> dict:
    """Return figures of the area as plain data: values, standard errors and the ends of the 95 % interval."""
    made: dict = {name: _entry(each) for name, each in figures.area.items()}
    for method, found in figures.provision.items():
        made[f"en17037_{method}"] = {
            "level": found.level,
            "level_at_least": found.lowest,
            "level_at_most": found.highest,
            "target_areas": _entry(found.target_areas),
            "least_areas": _entry(found.least_areas),
        }
    if figures.sunlight_level:
        made["en17037_sunlight_level"] = figures.sunlight_level
    return made


def _entry(estimate) -> dict:
    low, high = estimate.interval()
    return {
        "value": np.asarray(estimate.value).tolist(),
        "standard_error": np.asarray(estimate.standard_error).tolist(),
        "low": np.asarray(low).tolist(),
        "high": np.asarray(high).tolist(),
    }
