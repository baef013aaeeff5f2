"""Whether the engine can run, asked in a process of its own.

A faulty LLVM can end the process that loads it, and loading takes seconds: neither may happen to the window.
"""

import json
import subprocess
import sys
import time
from pathlib import Path

from ...engine.transport.backend import BackendStatus

ROOT = Path(__file__).resolve().parents[2]
"""Folder of the package, which has other names inside Blender."""

PATIENCE = 120.0
"""How long the answer may take; a first start reads some hundred megabytes. [s]"""

REINSTALL = "reinstall Lumenray with the zip made for this platform and Blender version"

SCRIPT = """
import dataclasses, importlib.util, json, sys
root, sys.path[:] = sys.argv[1], json.loads(sys.argv[2])
spec = importlib.util.spec_from_file_location(
    "lumenray", root + "/__init__.py", submodule_search_locations=[root]
)
sys.modules["lumenray"] = importlib.util.module_from_spec(spec)
from lumenray.engine.transport import backend
print("status=" + json.dumps(dataclasses.asdict(backend.status())))
"""


class Probe:
    """A running question; ask `poll` until it answers. Owns the process and ends it when given up."""

    def __init__(self):
        self._start = time.monotonic()
        self._answer = None
        self._process = None
        try:
            self._process = subprocess.Popen(  # noqa: S603 - Blender's own Python and our own text
                [sys.executable, "-I", "-c", SCRIPT, str(ROOT), json.dumps(sys.path)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                encoding="utf-8",
                errors="replace",
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
            )
        except OSError as error:
            self._answer = BackendStatus(
                False, f"Blender's Python cannot be started: {error}", "reinstall Blender"
            )

    def poll(self) -> BackendStatus | None:
        """Return the answer, None while there is none."""
        if self._answer is not None:
            return self._answer
        if self._process.poll() is None and time.monotonic() - self._start < PATIENCE:
            return None
        return self.wait(0.0)

    def wait(self, seconds: float = PATIENCE) -> BackendStatus:
        """Wait for the answer, no longer than this. [s]"""
        if self._answer is None:
            self._answer = self._collect(seconds)
        return self._answer

    def close(self) -> None:
        """Give up."""
        if self._process is not None and self._process.poll() is None:
            self._process.kill()
            self._process.communicate()

    def _collect(self, seconds) -> BackendStatus:
        try:
            # An ended process still has to hand over what it said.
            answer, complaint = self._process.communicate(timeout=max(seconds, 1.0))
        except subprocess.TimeoutExpired:
            self.close()
            return BackendStatus(
                False,
                f"the engine's libraries did not load within {PATIENCE:.0f} s",
                "check again when the computer is less busy",
            )
        return read_answer(self._process.returncode, answer, complaint)


def read_answer(code: int, answer: str, complaint: str) -> BackendStatus:
    """Turn what the process left behind into a status.

    Parameters
    ----------
    code : int    Its exit code; a negative one is the signal that ended it.
    answer, complaint : str    What it wrote on standard output and on standard error.
    """
    for line in answer.splitlines():
        if line.startswith("status="):
            return BackendStatus(**json.loads(line.removeprefix("status=")))
    said = (complaint.strip().splitlines() or ["without a word"])[-1]
    if code < 0 or code > 2:
        cause = f"the engine's libraries ended the process that loaded them ({code}: {said})"
        return BackendStatus(False, cause, "install another LLVM, 17 or newer, then restart")
    return BackendStatus(False, f"the engine cannot be loaded: {said}", REINSTALL)
