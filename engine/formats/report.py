"""The machine-readable report that goes with pictures and lux maps."""

import json
from pathlib import Path

from ..errors import FileFormatError


def quantity_of_map(made) -> dict:
    """Row of a `session.LuxMap`."""
    return {
        "name": made.name,
        "quantity": "illuminance",
        "unit": "lx",
        "mean": made.mean,
        "minimum": made.minimum,
        "maximum": made.maximum,
        "relative_standard_error": made.relative_standard_error,
        "mean_standard_error": made.mean_standard_error,
        "samples": made.samples,
        "lumels_per_metre": made.density,
    }


def compose(file: str, provenance, seconds: float, quantities: list[dict], conversion=()) -> dict:
    """Put a report together from a `session.Provenance`, rows and the conversion report's rows."""
    return {
        "engine": {"version": provenance.engine_version, "variant": provenance.variant},
        "scene": {"file": file, "hash": provenance.scene_hash},
        "seed": provenance.seed,
        "seconds": seconds,
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
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    except OSError as error:
        raise FileFormatError(path, f"cannot be written ({error.strerror})") from None
    return path
