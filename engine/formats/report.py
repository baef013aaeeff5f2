"""The machine-readable report that goes with pictures and lux maps."""

import json
import math
from pathlib import Path

from ..errors import FileFormatError


def quantity_of_map(made) -> dict:
    """Row of a `baking.order.LuxMap`. Errors that are not known are null: JSON has no infinity."""
    return {
        "name": made.name,
        "quantity": "illuminance",
        "unit": "lx",
        "mean": made.mean,
        "minimum": made.minimum,
        "maximum": made.maximum,
        "relative_standard_error": _known(made.relative_standard_error),
        "mean_standard_error": _known(made.mean_standard_error),
        "bias": made.bias,
        "bias_error": _known(made.bias_error),
        "samples": made.samples,
        "lumels": made.lumels,
        "invalid": made.invalid,
        "area": made.area,
        "lumels_per_metre": made.density,
        "smoothed": made.smoothed,
    }


def _known(error: float) -> float | None:
    return error if math.isfinite(error) else None


def compose(
    file: str, provenance, seconds: float, quantities: list[dict], conversion=(), shortfall=""
) -> dict:
    """Put a report together from a `session.Provenance`, rows and the conversion report's rows.

    ``shortfall``: what is said of a wanted error that was not reached (see `StopRule.shortfall`), empty if it was.
    """
    return {
        "engine": {"version": provenance.engine_version, "variant": provenance.variant},
        "scene": {"file": file, "hash": provenance.scene_hash},
        "seed": provenance.seed,
        "seconds": seconds,
        "goal": {"reached": not shortfall, "shortfall": shortfall},
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
