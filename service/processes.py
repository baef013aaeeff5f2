"""Starts the processes of jobs, watches what they take, and ends them."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from .confinement import Limits
from .folders import size

PROGRESS = "LUMENRAY_PROGRESS"
"""Variable that names the descriptor to which a command writes its progress, a line of JSON each."""

INTERVAL = 0.5
"""Between looks at what a process takes. [s]"""

PATIENCE = 20.0
"""How long a process may take to end by itself after it was asked to. [s]"""

LOG = 200
"""Last lines that are kept of what a process writes."""

LONGEST_LINE = 2000
"""Of them. [character]"""


@dataclass(frozen=True)
class Outcome:
    """How a process ended.

    Parameters
    ----------
    code : int    Exit code; negative: the signal that ended it.
    log : tuple of str    The last lines that it wrote.
    reason : str    Why it was ended from outside; empty if it was not.
    """

    code: int
    log: tuple[str, ...]
    reason: str


class Confined:
    """A program in a process of its own that can reach its own folders only.

    Parameters
    ----------
    module : str    Module that is run as the main program.
    arguments : list of str    Of it.
    work : Path    Folder that it may write to, with ``tmp`` in it for what it needs on the way.
    cache : Path    What it keeps for later.
    readable : list of Path    What it may read beside the programs.
    limits : Limits
    most_disk : int    What ``work`` may hold. [byte]
    seconds : float    After which it is ended. [s]
    """

    def __init__(
        self,
        module: str,
        arguments: list[str],
        work: Path,
        cache: Path,
        readable: list[Path],
        limits: Limits,
        most_disk: int,
        seconds: float,
    ):
        self._work = work
        self._most_disk = most_disk
        self._end = time.monotonic() + seconds
        self._seconds = seconds
        self._reason = ""
        self._asked: float | None = None
        # The innermost first.
        self._folders = sorted(
            {work, cache, *readable, *(path.parent for path in readable)}, reverse=True
        )
        temporary = work / "tmp"
        temporary.mkdir()
        search = [str(Path(each).absolute()) for each in sys.path if each]
        programs = [sys.prefix, sys.base_prefix, sys.exec_prefix, *search, str(_package())]
        order = {
            "parent": os.getpid(),
            "module": module,
            "arguments": arguments,
            "readable": [*programs, *map(str, readable)],
            "writable": [str(work), str(cache)],
            "limits": asdict(limits),
        }
        ours, theirs = os.pipe()
        try:
            self._process = subprocess.Popen(  # noqa: S603 - our own Python and our own module
                [sys.executable, "-m", f"{__package__}.confined", json.dumps(order)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                cwd=temporary,
                env=_environment(search, temporary, cache, theirs),
                pass_fds=(theirs,),
                start_new_session=True,
            )
        except BaseException:
            os.close(ours)
            raise
        finally:
            os.close(theirs)
        self._told = os.fdopen(ours, "rb")

    def stop(self, reason: str) -> None:
        """Ask the process to end, and make it end if it does not; from any thread."""
        if not self._reason:
            self._reason = reason

    def wait(self, told: Callable[[dict], None]) -> Outcome:
        """Wait until the process has ended.

        Parameters
        ----------
        told : callable    Given what the process says of its progress, on a thread of its own.
        """
        log: deque[str] = deque(maxlen=LOG)
        readers = [
            threading.Thread(target=_read_log, args=(self._process.stdout, log), daemon=True),
            threading.Thread(target=_read_progress, args=(self._told, told), daemon=True),
        ]
        for reader in readers:
            reader.start()
        while True:
            try:
                code = self._process.wait(INTERVAL)
                break
            except subprocess.TimeoutExpired:
                self._look()
        # Whatever it has started ends with it.
        self._signal(signal.SIGKILL)
        for reader in readers:
            reader.join()
        self._process.stdout.close()
        self._told.close()
        return Outcome(code, tuple(map(self._without_folders, log)), self._reason)

    def _without_folders(self, line: str) -> str:
        """A line with files by their names alone: where they lie here is nobody's business."""
        for folder in self._folders:
            line = line.replace(f"{folder}/", "")
        return line

    def _look(self) -> None:
        now = time.monotonic()
        if now > self._end:
            self.stop(f"it took longer than {self._seconds:g} s")
        elif size(self._work) > self._most_disk:
            self.stop("its files take more room than you have left; remove scenes or results")
        if not self._reason:
            return
        if self._asked is None:
            self._asked = now
            self._signal(signal.SIGINT)
        elif now - self._asked > PATIENCE:
            self._signal(signal.SIGKILL)

    def _signal(self, number: int) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, number)


def _package() -> Path:
    """Folder of the whole package."""
    return Path(__file__).resolve().parent.parent


def _environment(search: list[str], temporary: Path, cache: Path, progress: int) -> dict[str, str]:
    """Nothing of the service's own variables, some of which may be secret."""
    return {
        "PATH": "/usr/bin:/bin",
        "PYTHONPATH": os.pathsep.join(search),
        "PYTHONSAFEPATH": "1",
        "PYTHONUTF8": "1",
        "PYTHONDONTWRITEBYTECODE": "1",
        "HOME": str(cache),
        "XDG_CACHE_HOME": str(cache),
        "TMPDIR": str(temporary),
        "CI": "true",
        PROGRESS: str(progress),
    }


def _read_log(stream, log: deque) -> None:
    while line := stream.readline(LONGEST_LINE):
        log.append(line.decode("utf-8", "replace").rstrip())


def _read_progress(stream, told) -> None:
    while line := stream.readline(LONGEST_LINE):
        try:
            state = json.loads(line)
        except ValueError:
            # It comes from a process that other people's files may rule.
            continue
        if isinstance(state, dict):
            told(state)
