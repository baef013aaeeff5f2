"""The machine-readable report that goes with pictures and lux maps."""

import csv
import json
import math
from pathlib import Path

from ..reading.printable import printable
from ..reading.whole_file import write_whole

TOLD = ("error", "warning")
"""Severities of the conversion report that stand beside numbers, the worst first; the others change little."""


def quantity_of_map(made) -> dict:
    """Row of a `baking.order.LuxMap`. Errors that are not known are null: JSON has no infinity.

    Extremes are freed of noise; ``…_range`` is the interval that holds the true one in 95 % of cases at least.
    """
    return {
        "name": made.name,
        "quantity": "illuminance",
        "unit": "lx",
        "mean": made.mean,
        "minimum": made.least.value,
        "minimum_range": _range(made.least),
        "maximum": made.largest.value,
        "maximum_range": _range(made.largest),
        "uniformity": made.uniformity.value,
        "uniformity_range": _range(made.uniformity),
        "relative_standard_error": known(made.relative_standard_error),
        "mean_standard_error": known(made.mean_standard_error),
        "bias": made.bias,
        "bias_error": known(made.bias_error),
        "samples": made.samples,
        "lumels": made.lumels,
        "invalid": made.invalid,
        "area": made.area,
        "lumels_per_metre": made.density,
    }


def quantity_of_picture(made) -> dict:
    """Row of a `views.Picture`; the error is that of its pixels, as of `Picture.relative_error`."""
    return {
        "name": "picture",
        "quantity": "luminance",
        "unit": "cd/m2",
        "mean": float(made.tristimulus[..., 1].mean()),
        "relative_standard_error": known(made.relative_error),
        "samples": made.provenance.samples,
    }


def _range(extreme) -> list[float | None]:
    return [extreme.low, known(extreme.high)]


def known(value: float) -> float | None:
    """A number as JSON can hold it: what is not known is infinite, and stated as null."""
    return float(value) if math.isfinite(value) else None


COLUMNS = (
    "name", "unit", "mean", "mean_standard_error", "minimum", "minimum_low", "minimum_high", "maximum", "maximum_low",
    "maximum_high", "uniformity", "uniformity_low", "uniformity_high", "relative_standard_error", "bias", "bias_error",
    "samples", "lumels", "invalid", "area", "lumels_per_metre",
)  # fmt: skip
"""Of the table of lux maps; ``_low`` and ``_high`` are the ends of ranges."""


def find_remarks(conversion=(), notes=(), shortfall: str = "") -> list[str]:
    """Say in lines all that a reader of numbers has to know, the worst first.

    Parameters
    ----------
    conversion : iterable of dict    The conversion report's rows.
    notes : iterable of str    Of a `session.Provenance`.
    shortfall : str    As in `compose`; a row that says the same is not said again.
    """
    rows = [row for row in conversion if row["severity"] in TOLD and row["message"] != shortfall]
    rows.sort(key=lambda row: TOLD.index(row["severity"]))
    lines = [f"goal: {shortfall}"] if shortfall else []
    for row in rows:
        where = f"{row['object']} / {row['node']}" if row["node"] else row["object"]
        times = f" ({row['count']} times)" if row["count"] > 1 else ""
        lines.append(f"{row['severity']}: {where}: {row['message']}; {row['instead']}{times}")
    lines += [f"note: {note}" for note in notes]
    # A name may hold the end of a line, behind which no # would stand.
    return [" ".join(printable(line).splitlines()) for line in lines]


def write_table(path, quantities: list[dict], remarks=()) -> Path:
    """Write rows of `quantity_of_map` as comma-separated text; what is not known stays empty.

    ``remarks`` are lines of text that a reader of the numbers has to know; they stand before them, each behind a ``#``.

    Raises
    ------
    FileFormatError    The file cannot be written.
    """
    rows = []
    for quantity in quantities:
        row = dict(quantity)
        for name in ("minimum", "maximum", "uniformity"):
            row[f"{name}_low"], row[f"{name}_high"] = row.pop(f"{name}_range")
        rows.append({name: "" if row[name] is None else row[name] for name in COLUMNS})
    with write_whole(path, "utf-8") as file:
        file.writelines(f"# {remark}\n" for remark in remarks)
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return Path(path)


def compose(
    file: str, provenance, seconds: float, quantities: list[dict], conversion=(), shortfall=""
) -> dict:
    """Put a report together from a `session.Provenance`, rows and the conversion report's rows.

    ``shortfall``: what is said of a wanted error that was not reached (see `StopRule.shortfall`, and of lux maps
    `baking.files.find_shortfall`), empty if it was.
    """
    return {
        "engine": {"version": provenance.engine_version, "variant": provenance.variant},
        "scene": {"file": file, "hash": provenance.scene_hash},
        "seed": provenance.seed,
        "seconds": seconds,
        "goal": {"reached": not shortfall, "shortfall": shortfall},
        "simplifications_at_most": provenance.simplified,
        "quantities": quantities,
        "decisions": list(provenance.decisions),
        "notes": list(provenance.notes),
        "conversion": list(conversion),
    }


def write_json(path, content: dict) -> Path:
    """Write a report, making its folder if need be.

    Raises
    ------
    FileFormatError    The file cannot be written.
    """
    with write_whole(path, "utf-8") as file:
        file.write(json.dumps(content, indent=2, ensure_ascii=False) + "\n")
    return Path(path)
