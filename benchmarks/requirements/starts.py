"""How long it takes to start: what is not needed is not loaded."""

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from ...libraries import scenes

REPEATS = 5
"""Starts of each kind; the median counts."""

MARK = "enabling="
"""What the lines begin with that tell of a start of a real Blender."""

ENABLE = Path(__file__).parents[2] / "tests" / "real_blender" / "run_enabling.sh"
"""Enables the extension in a real Blender, again and again."""

IMPORT = "import time; t = time.perf_counter(); import lumenray; print(time.perf_counter() - t)"


def measure(say) -> dict:
    """Time importing the package, explaining the office by the command, and enabling the extension in a real Blender."""
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
    made |= _enable(say)
    say(f"import {1e3 * made['import_seconds']:.1f} ms, explain {made['explain_seconds']:.2f} s")
    return made


def tell(made: dict) -> str:
    """The chapter of the document."""
    told = (
        f"## Starting\n\nMedians of {REPEATS}: `import lumenray` {1e3 * made['import_seconds']:.1f} ms, `lumenray explain` "
        f"of the bundled office {made['explain_seconds']:.2f} s, Blender's own start included.\n\n"
    )
    if "enabling_seconds" in made:
        told += (
            f"Enabling the extension in a real Blender {made['blender']}: {made['enabling_seconds']:.2f} s of the "
            f"processor, {made['enabling_clock']:.2f} s by the clock, {made['enabling_modules']} modules of its own; the "
            f"first time after it was installed, when Python compiles them, {made['first_enabling_seconds']:.2f} s.\n\n"
        )
    return told


def _enable(say) -> dict:
    """Numbers of a real Blender; none where there is none, which is said."""
    done = subprocess.run([ENABLE], check=False, capture_output=True, text=True)
    if done.returncode:
        why = (done.stderr.strip() or done.stdout.strip() or "no reason told").splitlines()[-1]
        say(f"enabling was not measured: {why}")
        return {}
    lines = [line.removeprefix(MARK) for line in done.stdout.splitlines() if line.startswith(MARK)]
    first, *others = map(json.loads, lines)
    made = {
        "blender": first["blender"],
        "first_enabling_seconds": first["processor_seconds"],
        "enabling_seconds": float(np.median([each["processor_seconds"] for each in others])),
        "enabling_clock": float(np.median([each["clock_seconds"] for each in others])),
        "enabling_modules": first["own_modules"],
    }
    say(
        f"enabling {made['enabling_seconds']:.2f} s, the first time {made['first_enabling_seconds']:.2f} s"
    )
    return made


def _run(command: list[str]) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout
