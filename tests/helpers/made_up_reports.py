"""A report whose numbers are made up, with names that a file may hold."""

import numpy as np
from PIL import Image

from lumenray.engine.accuracy.readings import judge_readings
from lumenray.engine.analysis.value_plan import draw_grid
from lumenray.engine.judgement.assessment import assess
from lumenray.engine.judgement.figures import find_figures
from lumenray.engine.judgement.requirement import Requirement
from lumenray.engine.judgement.schedule import Fitting, Schedule
from lumenray.engine.judgement.verdict import tail
from lumenray.engine.reporting.results import (
    Floor,
    Grid,
    LightingScene,
    LuminaireSheet,
    OtherLight,
    Report,
    SensorArea,
    Shown,
)

HOSTILE = "<script>alert('1')</script> & \"Büro\" \x1b[2J\u202e\nLager ł"
"""A name with what browsers, terminals and CSV files take for more than letters."""

WRITING = Requirement(
    "office.writing", "Writing", "EN 12464-1:2021", "made up", {"task": {"mean": 500.0, "uniformity": 0.6}}
)  # fmt: skip

SECONDS = 100.0


def new_area(name: str, factor: float = 1.0, error: float = 2.0) -> SensorArea:
    """Return an area of 5 x 3 sensors, about 520 lx times a factor."""
    x, y = np.linspace(0.5, 2.5, 5), np.linspace(0.5, 1.5, 3)
    field = factor * (520.0 + 40.0 * np.sin(x) * np.cos(y[:, None]))
    values, errors = field.ravel(), np.full(15, error)
    plane = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    made = find_figures(values, errors, tail(2), 15, has_common=True)
    return SensorArea(
        name,
        "planar illuminance",
        "lx",
        judge_readings(values, errors),
        np.column_stack([plane, np.full(15, 0.75)]),
        np.tile([0.0, 0.0, 1.0], (15, 1)),
        values,
        errors,
        samples=1024,
        seed=7,
        method="full paths",
        scene_hash="0123456789abcdef",
        grid=Grid(x, y, field, errors.reshape(3, 5)),
        plan=draw_grid("Planar", x, y, field),
        assessment=assess(WRITING, "task", made, SECONDS),
    )


def new_report(name: str = "Desk") -> Report:
    """Return a report of two lighting scenes: one meets what is required, the other does not."""
    shown = Shown("What the camera sees", Image.new("RGB", (24, 16), "#406080"))
    fitting = Fitting(f"{name} panel", 3600.0, 30.0, 4)
    return Report(
        title=name,
        file="room.blend",
        version="0.1.0",
        transport="auto",
        scenes=(
            LightingScene("Day", "Light groups: all as in the scene.", (new_area(name),), (shown,)),
            LightingScene(f"Evening {name}", "Light groups: Sky off.", (new_area(name, 0.5),)),
        ),
        schedule=Schedule((fitting,)),
        luminaires=(LuminaireSheet(fitting, (("Maker", name),), problem="no opening"),),
        others=(OtherLight(name, 2, 700.0, "lm"),),
        floor=Floor(f"Floor {name}", 20.0, 520.0),
        settings=(("Light groups", "groups"),),
        remarks=(f"warning: {name}: taken for grey",),
        client=name,
        date="2026-01-31",
    )
