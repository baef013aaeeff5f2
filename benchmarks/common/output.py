"""What benchmarks tell while they run, and where their numbers go."""

import json
import sys
from pathlib import Path


def report_progress(line: str) -> None:
    """Tell whoever watches what was done."""
    print(line, file=sys.stderr, flush=True)


def write_numbers(result: dict, path: Path | None) -> None:
    """Write all numbers to a JSON file, if one is named."""
    if path is None:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
