"""Processes that solve realisations, each on one processor; tied to their parent, and gone with it.

A process is told its order in one line of JSON on standard input, then a task in each line: realisation, band, and whether
on the grid of twice the step. It answers each with a line of JSON, the length of what follows, and that: a numpy archive
without pickled objects. What goes wrong in a way that people can mend is the line's ``fault``.
"""

import io
import json
import os
import queue
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..errors import EngineLost, SceneError

ROOT = Path(__file__).parents[2]

BOOTSTRAP = """
import importlib.util, json, sys
order = json.loads(sys.stdin.buffer.readline())
sys.path[:] = order["search_path"]
spec = importlib.util.spec_from_file_location(
    "lumenray", order["root"] + "/__init__.py", submodule_search_locations=[order["root"]]
)
sys.modules["lumenray"] = importlib.util.module_from_spec(spec)
from lumenray.engine.ink import crew
crew.work(order)
"""
"""Inside Blender the package has another name, so the new process finds it by its folder."""

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Sums of several threads depend on their number; and processes share the processors already."""

TICK = 0.2
"""Between two looks of whoever waits. [s]"""

Task = tuple[int, int, bool]
"""Realisation, band, and whether on the coarse grid."""


class Waiting:
    """Tasks that no process has begun.

    A process stays with a realisation as long as it has tasks: it has packed its particles, which another one would have to
    do once more. So two share a realisation only when there are no others left.
    """

    def __init__(self, tasks: list[Task]):
        self._lock = threading.Lock()
        self._rest: dict[tuple[int, bool], deque[Task]] = {}
        for task in tasks:
            self._rest.setdefault(_structure_of(task), deque()).append(task)
        self._begun: set[tuple[int, bool]] = set()

    def take(self, last: Task | None) -> Task | None:
        """Return the next task of a process that has done the ``last`` one; None when there are none."""
        with self._lock:
            if not self._rest:
                return None
            own = None if last is None else _structure_of(last)
            if own not in self._rest:
                new = (each for each in self._rest if each not in self._begun)
                own = next(new, None) or max(self._rest, key=lambda each: len(self._rest[each]))
                self._begun.add(own)
            task = self._rest[own].popleft()
            if not self._rest[own]:
                del self._rest[own]
            return task


def _structure_of(task: Task) -> tuple[int, bool]:
    """What a process keeps from task to task: the particles of a realisation on a grid."""
    realisation, _, is_coarse = task
    return realisation, is_coarse


class Solver:
    """Does the tasks of an order in this process.

    Parameters
    ----------
    order : dict    As of `run_tasks`.
    """

    def __init__(self, order: dict):
        from .plan import Plan
        from .reader import parse_ink

        self._ink = parse_ink(order["content"])
        stated = order["plan"]
        rows = {name: tuple(stated[name]) for name in ("wavelengths", "sines")}
        plan = Plan(**stated | rows)
        self._plans = {False: plan, True: plan.halved()}

    def solve(self, task: Task) -> dict[str, np.ndarray]:
        """What a task scatters, as of `realisation.solve_unit`.

        Raises
        ------
        SceneError    It cannot be solved.
        """
        from .realisation import solve_unit

        realisation, band, is_coarse = task
        return solve_unit(self._ink, self._plans[is_coarse], realisation, band)


def archive(arrays: dict[str, np.ndarray]) -> bytes:
    """Return arrays as a numpy archive without pickled objects."""
    held = io.BytesIO()
    np.savez(held, **arrays)
    return held.getvalue()


def work(order: dict) -> None:
    """Solve what comes on standard input until it ends."""
    # Whatever a library prints must not get into the answers.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    solver = Solver(order)
    for line in sys.stdin.buffer:
        try:
            data, head = archive(solver.solve(json.loads(line))), {}
        except SceneError as error:
            data, head = b"", {"fault": str(error)}
        answers.write(json.dumps(head | {"length": len(data)}).encode() + b"\n" + data)
        answers.flush()


def run_tasks(
    order: dict, tasks: list[Task], processes: int
) -> Iterator[tuple[Task, bytes] | None]:
    """Let processes do tasks; closing the iterator ends them, in the midst of what they do.

    Parameters
    ----------
    order : dict    ``content`` of an ink and ``plan``, as JSON takes them.
    tasks : list of Task
    processes : int

    Yields
    ------
    (Task, bytes)    In the order in which they are done; None where nothing was for `TICK` seconds.

    Raises
    ------
    SceneError    What a process says cannot be done.
    EngineLost    A process ended by itself.
    """
    waiting = Waiting(tasks)
    done: queue.SimpleQueue = queue.SimpleQueue()
    hands = [_start(order) for _ in range(min(processes, len(tasks)))]
    threads = [
        threading.Thread(target=_lead, args=(hand, waiting, done), daemon=True) for hand in hands
    ]
    try:
        for thread in threads:
            thread.start()
        left = len(tasks)
        while left:
            try:
                task, result = done.get(timeout=TICK)
            except queue.Empty:
                yield None
                continue
            if isinstance(result, Exception):
                raise result
            left -= 1
            yield task, result
    finally:
        for hand in hands:
            hand.kill()
        for thread in threads:
            thread.join()
        for hand in hands:
            hand.wait()
            hand.stdin.close()
            hand.stdout.close()


def _start(order: dict) -> subprocess.Popen:
    whole = order | {"root": str(ROOT), "search_path": list(sys.path)}
    try:
        hand = subprocess.Popen(  # noqa: S603 - this very Python and our own text
            [sys.executable, "-I", "-X", "utf8", "-c", BOOTSTRAP],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=os.environ | ONE_THREAD,
        )
    except OSError as error:
        raise EngineLost(
            f"a process for the pigment layer cannot be started: {error}; free memory"
        ) from error
    hand.stdin.write(json.dumps(whole).encode() + b"\n")
    hand.stdin.flush()
    return hand


def _lead(hand: subprocess.Popen, waiting: Waiting, done) -> None:
    """Hand tasks to one process until there are none."""
    task = None
    try:
        while (task := waiting.take(task)) is not None:
            hand.stdin.write(json.dumps(task).encode() + b"\n")
            hand.stdin.flush()
            line = hand.stdout.readline()
            head = json.loads(line) if line else None
            data = hand.stdout.read(head["length"]) if head else b""
            if head is None or len(data) < head["length"]:
                break
            if "fault" in head:
                done.put((task, SceneError(head["fault"])))
                return
            done.put((task, data))
        else:
            return
    except (OSError, ValueError):
        # It ended while it was written to, or in the midst of an answer.
        pass
    lost = "a process for the pigment layer ended by itself; free memory, or take fewer processes; what was solved is kept"
    done.put((task, EngineLost(lost)))
