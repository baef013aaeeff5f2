"""How long it takes to start: what is not needed is not loaded."""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from ...libraries import scenes

REPEATS = 5
"""Starts of each kind; the median counts."""

IMPORT = "import time; t = time.perf_counter(); import lumenray; print(time.perf_counter() - t)"


def measure(say) -> dict:
    """Time importing the package, and explaining the office by the command."""
    office = Path(scenes.__file__).with_name("office.blend")
    command = [sys.executable, "-m", "lumenray.command_line.main", "explain", str(office)]
    imports = [float(_run([sys.executable, "-c", IMPORT])) for _ in range(REPEATS)]
    explained = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        _run(command)
        explained.append(time.perf_counter() - begin)
    made = {
        "import_seconds": float(np.median(imports)),
        "explain_seconds": float(np.median(explained)),
    }
    say(f"import {1e3 * made['import_seconds']:.1f} ms, explain {made['explain_seconds']:.2f} s")
    return made


def tell(made: dict) -> str:
    """The chapter of the document."""
    return (
        f"## Starting\n\nMedians of {REPEATS}: `import lumenray` {1e3 * made['import_seconds']:.1f} ms, `lumenray explain` "
        f"of the bundled office {made['explain_seconds']:.2f} s, Blender's own start included.\n\n"
    )


def _run(command: list[str]) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout
