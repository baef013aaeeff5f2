"""Random small rooms against long runs of paths from the lights: no value may be off by more than it says.

Every room is baked and measured as a user would, and compared with 2^22 paths from the lights, an estimator of other code
that fails in other places (`engine/transport/witness`). Compared are the mean of the lux map, and the illuminance of small
squares about four places on which sensors gather, with the errors that the second witness gives these. A value is off by
so many stated errors: of its own and of the reference, joined, and one per cent more.
"""

from pathlib import Path

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.baking.order import BakeOrder
from ...engine.scene.scene import SceneDelta
from ...engine.session import Session
from ..common.machine import describe_machine
from ..common.output import write_numbers
from ..common.processes import spread
from .random_rooms import make_room

COUNT, FIRST = 300, 0
"""Rooms, and the number of the first."""

PATHS = 1 << 22
"""Of the reference."""

SEED = 9_001
"""Of the reference; those of the rooms are their numbers."""

SAMPLES, SENSOR_SAMPLES, DENSITY = 64, 1 << 13, 6.0
"""Of lumels and of sensors, and lumels per metre."""

ALLOWED, MARGIN = 4.0, 0.01
"""Errors by which a value may be off, and the share of it that is allowed besides. [-]"""

WORST = 10
"""Values that the document lists."""


def run(count: int = COUNT, first: int = FIRST, jobs: int = 1, say=lambda text: None) -> dict:
    """Compare rooms.

    Parameters
    ----------
    count, first : int    How many, and the number of the first.
    jobs : int    Processes that share them.
    say : callable    Told of every room.
    """
    result = {"machine": describe_machine(), "rows": [], "first": first}
    numbers = range(first, first + count)
    for number, rows in zip(numbers, spread(compare_room, numbers, jobs), strict=True):
        result["rows"] += rows
        result["count"] = number - first + 1
        worst = max((row["off"] for row in rows), default=0.0)
        say(f"room {number}: {worst:.2f} of what is allowed")
    return result


def compare_room(number: int) -> list[dict]:
    """Rows of one room: what was found, the reference, and how far they lie apart."""
    room = make_room(number)
    session = Session()
    session.apply(SceneDelta(changed=room.items))
    order = BakeOrder(("room",), StopRule(samples=SAMPLES), density=DENSITY, seed=number)
    made = session.bake_objects(order).maps[0]
    mean, error, sensors, sensor_errors, area = _reference(session, room, number)
    rows = [
        _row(
            number,
            room.words,
            "map",
            made.mean,
            made.mean_standard_error,
            mean / area,
            error / area,
        )
    ]
    for k, (value, stated, true, true_error) in enumerate(
        zip(*sensors, *sensor_errors, strict=True)
    ):
        rows.append(_row(number, room.words, f"sensor {k + 1}", value, stated, true, true_error))
    return rows


def _reference(session, room, number: int):
    """Flux on the room and its error [lm]; gathered values and errors of squares; those of paths; the room's area [m2]."""
    from ...engine.scene.sensor import SensorKind
    from ...engine.transport.light_tracing.bent_lights import bent_lights
    from ...engine.transport.light_tracing.bright_spots import bright_spots
    from ...engine.transport.paths.illuminance import compute
    from ...engine.transport.witness.pilot import Witness
    from ...engine.transport.witness.sensors import hear_sensors
    from ...engine.transport.witness.sheets import Sheets

    with session._engine("auto") as scene:
        sheets = Sheets(scene, room.places, room.normals)
        witness = Witness(scene, SEED + number, {("room", False)}, sheets if len(sheets) else None)
        report = witness.run(PATHS)
        place = report.objects.index(("room", False))
        area = float(session.scene.mesh("room").areas().sum())
        values = np.zeros((2, 0))
        if len(sheets):
            receivers = sheets.receivers(number)
            seen = scene.local(receivers.positions), receivers.normals
            with bent_lights(scene), bright_spots(scene, *seen):
                rule = StopRule(samples=SENSOR_SAMPLES)
                found = compute(scene, receivers, rule, number, 16)
                heard = hear_sensors(
                    scene, room.places, room.normals, SensorKind.PLANAR, found, number
                )
            values = np.stack([found.mean, np.hypot(found.standard_error, heard.floors)])
    truth = (report.sheets, report.sheet_errors)
    return report.flux[place], report.flux_error[place], values, truth, area


def _row(number, words, what, value, stated, true, true_error) -> dict:
    allowed = ALLOWED * float(np.hypot(stated, true_error)) + MARGIN * abs(true)
    off = abs(value - true) / allowed if allowed > 0.0 else float(value != true)
    return {"room": number, "words": words, "what": what, "value": float(value), "error": float(stated),
            "reference": float(true), "reference_error": float(true_error), "off": float(off)}  # fmt: skip


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document to a folder, and all numbers to a JSON file if one is named."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rooms.md").write_text(describe(result), encoding="utf-8")
    write_numbers(result, path)


def describe(result: dict) -> str:
    """The document."""
    rows = sorted(result["rows"], key=lambda row: -row["off"])
    bad = [row for row in rows if row["off"] > 1.0]
    machine = result["machine"]
    lines = [
        "# Random rooms",
        "",
        "*Made by `lumenray benchmark rooms`; do not edit by hand.*",
        "",
        f"{result['count']} small rooms made by chance (panes, bulbs, mirrors, gaps, keyholes, small lamps, lamps at walls, "
        f"coloured walls), each baked with {SAMPLES} samples a lumel and measured on squares about four places, against "
        f"2^{PATHS.bit_length() - 1} paths from the lights, an estimator of other code. *Off* is the distance over what is "
        f"allowed: {ALLOWED:.0f} times the stated errors of both, joined, and {100 * MARGIN:.0f} % of the value.",
        "",
        f"**{len(bad)} of {len(rows)} values are off by more than that.** Median of *off*: "
        f"{np.median([row['off'] for row in rows]):.2f}; maps whose stated error is above 5 %: "
        f"{100 * _uncertain(rows):.0f} %.",
        "",
        f"{machine['cpu']}, {machine['cores']} cores; Mitsuba {machine['mitsuba']}, Lumenray {machine['lumenray']}.",
        "",
        f"## The worst {WORST}",
        "",
        "| room | value | found [lx] | reference [lx] | off | what is in it |",
        "|--:|---|--:|--:|--:|---|",
    ]
    lines += [
        f"| {row['room']} | {row['what']} | {row['value']:.4g} ± {row['error']:.2g} | "
        f"{row['reference']:.4g} ± {row['reference_error']:.2g} | {row['off']:.2f} | {row['words']} |"
        for row in rows[:WORST]
    ]
    return "\n".join(lines) + "\n"


def _uncertain(rows: list[dict]) -> float:
    """Share of the maps whose stated error is above a twentieth."""
    maps = [row for row in rows if row["what"] == "map"]
    return float(np.mean([row["error"] > 0.05 * row["value"] for row in maps])) if maps else 0.0
