"""Pictures of the surroundings as light: parts that can be run alone, and what they come to."""

from pathlib import Path

from ...engine.reading.whole_file import write_whole
from ..common.machine import describe_machine
from ..common.output import read_numbers, write_numbers
from ..common.parts import choose_parts
from .document import check_bars, describe
from .files import describe_maps, try_files
from .noise import measure_noise
from .shadows import measure_shadows
from .suns import LOW_SUN, NEAR_NOON, measure_maps, measure_repair, measure_shadow

PARTS = ("maps", "shadow", "repair", "noise", "shadows", "files", "collection")

__all__ = ["PARTS", "check_bars", "read_results", "run", "write_results"]


def run(
    parts=None, folder: Path | None = None, say=lambda text: None, earlier: dict | None = None
) -> dict:
    """Measure.

    Parameters
    ----------
    parts : iterable of str or None    Which of `PARTS`; None: all.
    folder : Path or None    A collection of pictures that is analysed; None: none.
    say : callable    Told of every step.
    earlier : dict or None    Results that are gone on with: without ``parts`` those that they lack are measured.

    Returns
    -------
    dict    Plain data, for JSON: ``machine``, ``parts``, and the figures that demands are made on, None where they were not
        measured: ``illuminance_error_percent``, ``direction_error_deg``, ``repair_minutes``, ``shadow_error_percent``,
        ``variance_gain`` and ``rebuilt_error_percent``.

    Raises
    ------
    LumenrayError    There is no such part.
    """
    measures = {
        "maps": measure_maps,
        "shadow": measure_shadow,
        "repair": measure_repair,
        "noise": measure_noise,
        "shadows": measure_shadows,
        "files": try_files,
    }
    kept = {} if earlier is None else earlier["parts"]
    wanted = choose_parts(parts, PARTS, kept)
    made = {name: measure(say) for name, measure in measures.items() if name in wanted}
    if folder is not None and "collection" in wanted:
        made["collection"] = describe_maps(folder, say)
    return _sum_up({"machine": describe_machine(), "parts": {**kept, **made}})


def _sum_up(result: dict) -> dict:
    """Return results with the figures that demands are made on."""
    parts = result["parts"]
    maps, repair, noise = (parts.get(name) for name in ("maps", "repair", "noise"))
    shadows = parts.get("shadows")
    away = [row for row in repair or () if row["from_noon_s"] >= NEAR_NOON]
    found = [row for row in maps or () if row["expected"]]
    return {
        **result,
        "illuminance_error_percent": maps and max(row["error_percent"] for row in maps),
        "direction_error_deg": maps and max(row["direction_deg"] for row in found),
        "repair_minutes": repair and max(row["minutes"] for row in away),
        "rebuilt_error_percent": repair
        and max(row["sun_percent"] for row in repair if row["elevation_deg"] >= LOW_SUN),
        "shadow_error_percent": shadows and shadows["shadow_error_percent"],
        "variance_gain": noise and noise["gain"],
    }


def read_results(path: Path) -> dict:
    """Read the numbers of an earlier run; as `read_numbers`."""
    return read_numbers(path, {"machine", "parts", "variance_gain"})


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document to a folder, and all numbers to a JSON file if one is named."""
    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    with write_whole(folder / "environment.md", "utf-8") as file:
        file.write(describe(result))
