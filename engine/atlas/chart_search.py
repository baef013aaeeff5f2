"""Charts by xatlas, which runs in a process of its own so that it can be stopped and may crash."""

import importlib.util
import io
import json
import logging
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import Cancelled
from .chart_worker import LENGTH

SECONDS = 60.0
"""How long the charts of one mesh may take. [s]"""

TICK = 0.05
"""Time between two looks at the process. [s]"""


@dataclass(frozen=True)
class Found:
    """Charts of a batch.

    Parameters
    ----------
    uv : (f, 3, 2) float64 array    In the points' unit; charts lie apart.
    chart : (f,) int64 array    -1: none.
    """

    uv: np.ndarray
    chart: np.ndarray


@dataclass(frozen=True)
class Failed:
    """Why there are no charts, as the rest of a sentence."""

    reason: str


class ChartSearch:
    """Hold on the process, which starts with the first batch and serves many; close it, or use it in a ``with``.

    Parameters
    ----------
    seconds : float    How long the charts of one mesh may take at most. [s]
    """

    def __init__(self, seconds: float = SECONDS):
        self.seconds = seconds
        self.faces = 0
        """Triangles that it was asked about so far."""
        self._process = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process.stdout.close()
            # What it had not read yet is of no use to anyone.
            with suppress(BrokenPipeError):
                self._process.stdin.close()
            self._process = None

    def find(
        self,
        points: np.ndarray,
        triangles: np.ndarray,
        faces: np.ndarray,
        seconds: float,
        cancelled: Callable[[], bool] | None = None,
    ) -> Found | Failed:
        """Find the charts of several groups of triangles.

        Parameters
        ----------
        points : (v, 3) float32 array    Group by group.
        triangles : (f, 3) uint32 array    Group by group.
        faces : (g,) int64 array    How many triangles each group has.
        seconds : float    After which the process is killed. [s]
        cancelled : callable or None    Tells whether the user wants no more.

        Raises
        ------
        Cancelled
        """
        if importlib.util.find_spec("xatlas") is None:
            return Failed("is left out, for xatlas does not come with this version of Python")
        self.faces += len(triangles)
        request = io.BytesIO()
        np.savez(request, points=points, triangles=triangles, faces=faces)
        deadline = time.monotonic() + seconds
        try:
            process = self._start()
        except OSError as error:
            return Failed(f"could not be started ({error})")
        answer = []
        exchange = threading.Thread(
            target=_exchange, args=(process, request.getvalue(), answer), daemon=True
        )
        exchange.start()
        is_searching = True
        while is_searching:
            exchange.join(TICK)
            # The user is asked at least once, however soon there is an answer.
            if cancelled is not None and cancelled():
                self._abandon(exchange)
                raise Cancelled("cancelled")
            is_searching = exchange.is_alive()
            if is_searching and time.monotonic() > deadline:
                self._abandon(exchange)
                return Failed(f"took longer than {seconds:.3g} s")
        if not answer:
            self.close()
            return Failed("ended before it had an answer")
        with np.load(io.BytesIO(answer[0]), allow_pickle=False) as held:
            uv, chart = held["uv"].astype(np.float64), held["chart"].astype(np.int64)
        if uv.shape != (len(triangles), 3, 2) or not np.isfinite(uv).all():
            return Failed("gave an answer that cannot be used")
        return Found(uv, chart)

    def _abandon(self, exchange: threading.Thread) -> None:
        self._process.kill()
        exchange.join()
        self.close()

    def _start(self) -> subprocess.Popen:
        if self._process is not None and self._process.poll() is None:
            return self._process
        self.close()
        self._process = subprocess.Popen(  # noqa: S603 - this very Python and our own module
            [sys.executable, "-I", "-X", "utf8", str(Path(__file__).with_name("chart_worker.py"))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
        order = {"search_path": sys.path, "seconds": self.seconds}
        self._process.stdin.write(json.dumps(order).encode() + b"\n")
        return self._process


def _exchange(process: subprocess.Popen, request: bytes, answer: list) -> None:
    """Send a request and wait for its answer; an empty list says that the process ended."""
    try:
        process.stdin.write(LENGTH.pack(len(request)))
        process.stdin.write(request)
        process.stdin.flush()
        head = process.stdout.read(LENGTH.size)
        if len(head) == LENGTH.size:
            length = LENGTH.unpack(head)[0]
            blob = process.stdout.read(length)
            if len(blob) == length:
                answer.append(blob)
    except OSError as error:
        # The process is gone; the caller reports it.
        logging.getLogger(__name__).debug("no answer from the search for charts: %s", error)
