"""Whether the engine can run, asked in a process of its own.

A faulty LLVM can end the process that loads it, and loading takes seconds: neither may happen to the window.
"""

import json
import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

from ...imports import loaded_when_used

with loaded_when_used():
    from ...engine.transport import backend, devices

ROOT = Path(__file__).resolve().parents[2]
"""Folder of the package, which has other names inside Blender."""

PATIENCE = 120.0
"""How long the answer may take; a first start reads some hundred megabytes. [s]"""

REINSTALL = "reinstall Lumenray with the zip made for this platform and Blender version"

BOOTSTRAP = """
import dataclasses, importlib.util, json, sys
root, sys.path[:] = sys.argv[1], json.loads(sys.argv[2])
spec = importlib.util.spec_from_file_location(
    "lumenray", root + "/__init__.py", submodule_search_locations=[root]
)
sys.modules["lumenray"] = importlib.util.module_from_spec(spec)
"""

STATUS = """
from lumenray.engine.transport import backend
print("status=" + json.dumps(dataclasses.asdict(backend.status())))
"""


def start_python(script: str, device: str = "") -> subprocess.Popen:
    """Start Blender's own Python with the engine at hand, to run a script of ours.

    Parameters
    ----------
    script : str    Uses ``lumenray``, ``json`` and ``dataclasses``.
    device : str    Key of a device; empty: the one that the environment names, if any.

    Raises
    ------
    OSError    It cannot be started.
    """
    environment = {**os.environ, devices.CHOICE: device} if device else None
    return subprocess.Popen(  # noqa: S603 - Blender's own Python and our own text
        [sys.executable, "-I", "-c", BOOTSTRAP + script, str(ROOT), json.dumps(sys.path)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        errors="replace",
        env=environment,
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
    )


class Probe:
    """A running question; ask `poll` until it answers. Owns the process and ends it when given up.

    A graphics card's driver may end the process. Unless that device was chosen, the processor is asked next.
    """

    def __init__(self, device: str = ""):
        self._device = device
        self._answer = None
        self._process = None
        self._lost = ""
        self._begin(device)

    def poll(self) -> "backend.BackendStatus | None":
        """Return the answer, None while there is none."""
        if self._answer is not None:
            return self._answer
        if self._process.poll() is None and time.monotonic() - self._start < PATIENCE:
            return None
        self._collect(0.0)
        return self._answer

    def wait(self, seconds: float = PATIENCE) -> "backend.BackendStatus":
        """Wait for the answer, no longer than this for each device. [s]"""
        while self._answer is None:
            self._collect(seconds)
        return self._answer

    def close(self) -> None:
        """Give up."""
        if self._process is not None and self._process.poll() is None:
            self._process.kill()
            self._process.communicate()

    def _begin(self, device) -> None:
        self._start = time.monotonic()
        try:
            self._process = start_python(STATUS, device)
        except OSError as error:
            self._answer = backend.BackendStatus(
                False, f"Blender's Python cannot be started: {error}", "reinstall Blender"
            )

    def _collect(self, seconds) -> None:
        try:
            # An ended process still has to hand over what it said.
            answer, complaint = self._process.communicate(timeout=max(seconds, 1.0))
        except subprocess.TimeoutExpired:
            self.close()
            self._answer = backend.BackendStatus(
                False,
                f"the engine's libraries did not load within {PATIENCE:.0f} s",
                "check again when the computer is less busy",
            )
            return
        status = read_answer(self._process.returncode, answer, complaint)
        if not self._device and not self._lost and was_ended(self._process.returncode):
            self._lost = status.cause
            self._begin("cpu")
        elif self._lost:
            self._answer = replace(status, found=(self._lost, *status.found))
        else:
            self._answer = status


def last_line(text: str) -> str:
    """Return the last line of what a process said."""
    return (text.strip().splitlines() or ["without a word"])[-1]


def was_ended(code: int) -> bool:
    """Tell from its exit code whether a process was ended by a fault rather than by itself."""
    return code < 0 or code > 2


def read_answer(code: int, answer: str, complaint: str) -> "backend.BackendStatus":
    """Turn what the process left behind into a status.

    Parameters
    ----------
    code : int    Its exit code; a negative one is the signal that ended it.
    answer, complaint : str    What it wrote on standard output and on standard error.
    """
    for line in answer.splitlines():
        if line.startswith("status="):
            made = json.loads(line.removeprefix("status="))
            return backend.BackendStatus(**{**made, "found": tuple(made["found"])})
    said = last_line(complaint)
    if was_ended(code):
        cause = f"the engine's libraries ended the process that loaded them ({code}: {said})"
        return backend.BackendStatus(
            False,
            cause,
            "choose another device in the preferences, or install another LLVM, then restart",
        )
    return backend.BackendStatus(False, f"the engine cannot be loaded: {said}", REINSTALL)
