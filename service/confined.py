"""The first thing in a job's process: it confines itself, then becomes the program that it was started for.

It is started by `processes`, with what it has to do as JSON in its only argument.
"""

import ctypes
import json
import os
import resource
import runpy
import signal
import sys
from pathlib import Path

from .confinement import Limits, confine, leave_others

NICENESS = 10
"""How much jobs stand back for the service's answers."""

_DIE_WITH_PARENT = 1

_BY_SIGNAL = 128
"""Exit codes above this tell by which signal a process ended, as those of shells do."""


def main() -> None:
    """Confine this process, and run the module that was asked for as the main program."""
    order = json.loads(sys.argv[1])
    os.nice(NICENESS)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    has_tree = leave_others()
    # A job has no sense without the service that waits for it, which may be killed at any moment.
    _die_with_parent()
    if os.getppid() != order["parent"]:
        return
    if has_tree:
        _plant_tree()
    confine(
        [Path(each) for each in order["readable"]],
        [Path(each) for each in order["writable"]],
        Limits(**order["limits"]),
    )
    sys.argv = [order["module"], *order["arguments"]]
    runpy.run_module(order["module"], run_name="__main__", alter_sys=True)


def _plant_tree() -> None:
    """Go on as a process with which all that it ever starts ends, whatever sessions and groups these have.

    This process waits for the first of the tree, which waits for the program; when the first one ends, the kernel ends all
    others. The program is not the first itself, as signals have other meanings there.
    """
    # Interrupts are for the program.
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    first = os.fork()
    if first:
        code = _wait_for(first)
        if code > _BY_SIGNAL:
            signal.signal(code - _BY_SIGNAL, signal.SIG_DFL)
            os.kill(os.getpid(), code - _BY_SIGNAL)
        os._exit(code)
    _die_with_parent()
    program = os.fork()
    if program:
        os._exit(_wait_for(program))
    signal.signal(signal.SIGINT, handler)


def _wait_for(child: int) -> int:
    """Exit code of a process, above `_BY_SIGNAL` if a signal has ended it."""
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return code if code >= 0 else _BY_SIGNAL - code


def _die_with_parent() -> None:
    ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)


if __name__ == "__main__":
    main()
