"""What a worker does: keeps scenes, computes chunks of jobs on them, and leaves them when it is told to.

It runs in a process of its own, whose only thread that computes calls `work`; another one listens and calls `recall`.
"""

import json
import platform
import sys
import threading
from collections import OrderedDict
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from .. import VERSION, llvm
from ..errors import BackendError, Cancelled, CodecError, EngineFault, EngineLost, FileFormatError
from ..ink.crew import Solver
from ..scene.scene import Scene
from ..session import Session
from ..worker import faults
from .parcels import pack, unpack

MOST_SCENES = 4
"""Scenes that are kept; who asks for one that is no longer there is told so, and sends it again."""

METHODS = frozenset(
    {
        "confirm", "explain", "find_daylight", "find_lumels", "measure", "render", "sum_lux",
    }
)  # fmt: skip
"""Methods of a session that may be asked for."""

_OF_THE_MACHINE = (BackendError, CodecError, EngineFault, EngineLost, MemoryError)
"""Errors that another worker may not have; one of another version may not even understand what is asked."""


@dataclass
class _Held:
    """A scene that is kept, and the session that computes on it."""

    scene: Scene = field(default_factory=Scene)
    revision: int = -1
    session: Session | None = None
    # Job that the session was made for.
    job: str = ""


@dataclass
class _Bench:
    """State of this process."""

    scenes: OrderedDict = field(default_factory=OrderedDict)
    lock: threading.Lock = field(default_factory=threading.Lock)
    recalled: OrderedDict = field(default_factory=OrderedDict)
    running: "tuple[str, _Recallable] | None" = None


_bench = _Bench()


def work(scene: bytes, task: bytes) -> bytes:
    """Do an errand.

    Parameters
    ----------
    scene : bytes    Parcel of what brings a scene up to date: ``name``, ``base`` (revision, None: it is a whole one),
        ``revision`` and ``deltas``; empty where nothing has changed.
    task : bytes    Parcel of ``errand``, ``version``, ``scene`` and ``revision`` that it is about, ``job``, ``method``,
        ``arguments`` and ``options``.

    Returns
    -------
    bytes    Parcel of ``state``: ``done`` with ``value`` and ``make``, as of `describe`; ``lacks`` the scene; ``refused``
        with ``fault``, as of `worker.faults.describe`; ``failed`` with ``text``; ``left`` as it was recalled.
    """
    try:
        order = unpack(task)
        if order["version"] != VERSION:
            told = f"it has Lumenray {VERSION}, expected {order['version']}"
            return pack({"state": "failed", "text": told})
        if scene:
            _update(unpack(scene))
        return pack(_do(order))
    except Cancelled:
        return pack({"state": "left"})
    except _OF_THE_MACHINE as error:
        return pack({"state": "failed", "text": str(error) or "memory is short"})
    except Exception as error:
        told = faults.describe(error, "chunk")
        if told[0] == "EngineFault":
            return pack({"state": "failed", "text": told[1]})
        return pack({"state": "refused", "fault": list(told)})


def recall(key: str) -> None:
    """Leave an errand, also one that has not come yet; from any thread."""
    with _bench.lock:
        _bench.recalled[key] = None
        while len(_bench.recalled) > 1000:
            _bench.recalled.popitem(last=False)
        if _bench.running is not None and _bench.running[0] == key:
            _bench.running[1].cancel()


@lru_cache(maxsize=1)
def describe() -> str:
    """What the bits of this worker's results depend on, beside the version of the engine: its processor and LLVM."""
    processor = platform.processor() or platform.machine()
    if sys.platform == "linux":
        rows = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
        named = (row.partition(":")[2].strip() for row in rows if row.startswith("model name"))
        processor = next(named, processor)
    return f"{processor}, {Path(llvm.find_library() or 'no LLVM').name}"


def _update(news: dict) -> None:
    held = _bench.scenes.setdefault(news["name"], _Held())
    if news["base"] is None:
        held = _bench.scenes[news["name"]] = _Held()
    elif news["base"] != held.revision:
        # Who sent it learns so from the answer, and sends all of it.
        del _bench.scenes[news["name"]]
        return
    for delta in news["deltas"]:
        held.scene.apply(delta)
    held.revision, held.session = news["revision"], None
    while len(_bench.scenes) > MOST_SCENES:
        _bench.scenes.popitem(last=False)


def _do(order: dict) -> dict:
    if order["method"] == "solve_ink":
        return {
            "state": "done",
            "make": describe(),
            "value": _solver_of(*order["arguments"][:2]).solve(order["arguments"][2]),
        }
    held = _bench.scenes.get(order["scene"])
    if held is None or held.revision != order["revision"]:
        return {"state": "lacks"}
    if order["method"] not in METHODS:
        raise FileFormatError("the cluster's task", f"there is no job called {order['method']!r}")
    _bench.scenes.move_to_end(order["scene"])
    key = order["errand"]
    with _bench.lock:
        if key in _bench.recalled:
            return {"state": "left"}
        if held.session is None or held.job != order["job"]:
            # A scene that was changed step by step has other bits than one that was built at once, as workers that came
            # later do: so every job builds its own.
            held.session, held.job = session_of(held.scene), order["job"]
        _bench.running = key, _Recallable(held.session, key)
    try:
        method = getattr(held.session, order["method"])
        value = method(*order["arguments"], **order["options"], progress=_bench.running[1].look)
    finally:
        with _bench.lock:
            _bench.running = None
    return {"state": "done", "value": value, "make": describe()}


@lru_cache(maxsize=1)
def _solver_of(content: str, plan: str) -> Solver:
    """What solves a pigment layer; kept, as it keeps its particles. ``content``, ``plan``: JSON."""
    return Solver({"content": json.loads(content), "plan": json.loads(plan)})


class _Recallable:
    """A session that is told to cancel also where its job has not begun to listen yet."""

    def __init__(self, session: Session, key):
        self._session, self._key = session, key

    def cancel(self) -> None:
        self._session.cancel()

    def look(self, *_) -> None:
        """Called by the job as it goes on: a word that came while it began is heard then."""
        if self._key in _bench.recalled:
            self._session.cancel()


def session_of(scene: Scene) -> Session:
    """A session with a scene, as if it had been sent at once."""
    session = Session(keeps_cells=False)
    session.apply(scene.snapshot())
    return session
