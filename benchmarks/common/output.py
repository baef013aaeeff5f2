"""What benchmarks tell while they run, and where their numbers go."""

import json
import sys
from pathlib import Path

from ...engine.errors import LumenrayError
from ...engine.reading.whole_file import write_whole


def report_progress(line: str) -> None:
    """Tell whoever watches what was done."""
    print(line, file=sys.stderr, flush=True)


def write_numbers(result: dict, path: Path | None) -> None:
    """Write all numbers to a JSON file, if one is named."""
    if path is None:
        return
    with write_whole(path, "utf-8") as file:
        file.write(json.dumps(result, indent=1) + "\n")


def read_numbers(path: Path, keys: set[str]) -> dict:
    """Read the numbers of an earlier run, which has these keys.

    Raises
    ------
    LumenrayError    The file is not there or not one of that benchmark.
    """
    try:
        result = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise LumenrayError(f"{path}: cannot be read ({error})") from None
    if not isinstance(result, dict) or not keys <= result.keys():
        raise LumenrayError(f"{path}: holds no results of this benchmark")
    return result
