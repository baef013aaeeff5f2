"""The first thing in a job's process: it confines itself, then becomes the program that it was started for.

It is started by `processes`, with what it has to do as JSON in its only argument. What it says of its progress it writes as
lines of JSON to its standard output; everything else, the program's own lines and Blender's among them, goes to its log.
"""

import ctypes
import json
import os
import runpy
import signal
import sys
from pathlib import Path

from .confinement import Limits, confine

NICENESS = 10
"""How much jobs stand back for the service's answers."""

_DIE_WITH_PARENT = 1


def main() -> None:
    """Confine this process, and run the module that was asked for as the main program."""
    order = json.loads(sys.argv[1])
    # A job has no sense without the service that waits for it, which may be killed at any moment.
    ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
    if os.getppid() != order["parent"]:
        return
    os.nice(NICENESS)
    confine(
        [Path(each) for each in order["readable"]],
        [Path(each) for each in order["writable"]],
        Limits(**order["limits"]),
    )
    sys.argv = [order["module"], *order["arguments"]]
    runpy.run_module(order["module"], run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
