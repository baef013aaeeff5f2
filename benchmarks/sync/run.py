"""How long an edit takes until the live view shows it, compared with sending the whole scene.

Blender's module and the engine's worker process run as they do behind the viewport; only the window is missing.
"""

import gc
import itertools
import random
import time
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import bpy

from ...blender_addon import registry
from ...blender_addon.foundation.report import ConversionReport
from ...blender_addon.rendering.feed import SceneFeed
from ...engine.errors import LumenrayError
from ...engine.views import Display, LiveSettings
from ...engine.worker.client import Worker
from ..common.machine import OtherLoad, describe_machine
from ..common.output import write_numbers
from .edits import GROUPS, Answer, Desk, turned
from .figures import PARTS, SCENES
from .grid_scene import build_scene, count_triangles

ROOT = Path(__file__).resolve().parents[2]


OBJECTS = (100, 1000)

ROUNDS = 5
"""How often each edit is made."""

PATIENCE = 180.0
"""Longest wait for a sample. [s]"""

PAUSE = (0.15, 0.35)
"""Rest between two edits, while the view refines as it does while a user thinks. [s]"""


_numbers = itertools.count()

LIVE = LiveSettings(samples=1 << 16)


@dataclass(frozen=True)
class Timing:
    """Times of one edit or full sync, all in seconds.

    Parameters
    ----------
    seconds : float    From just before the edit until the sample is there.
    parts : dict of str to float
        ``edit`` (Blender carries it out), ``depsgraph`` (Blender evaluates, our handlers included), ``walk`` (find and
        convert what changed), ``transfer`` (hand over to the worker), ``commit`` (the engine's objects), ``first
        sample`` (trace it), ``rest`` (the slice of work that the worker was in, messages, making the image).
    sent : int    Items sent, removals included.
    """

    seconds: float
    parts: dict[str, float]
    sent: int = 0


def run(
    scenes=tuple(SCENES), objects=OBJECTS, rounds: int = ROUNDS, say=None, triangles=None
) -> dict:
    """Measure all scenes.

    Parameters
    ----------
    scenes : iterable of str    Names out of `SCENES` or of ``triangles``.
    objects : iterable of int    Numbers of objects.
    rounds : int    How often each edit is made.
    say : callable or None    Told in one line what was done.
    triangles : dict of str to int or None    Triangles of a scene by its name; None: `SCENES`.

    Returns
    -------
    dict    Plain data, for JSON: ``machine``, ``edits``, ``full``, ``scenes``.
    """
    registry.register()
    machine = describe_machine() | {"blender": bpy.app.version_string}
    result = {"machine": machine, "edits": [], "full": [], "scenes": []}
    for name in scenes:
        for count in objects:
            measured = measure_scene((triangles or SCENES)[name], count, rounds, say)
            for key, rows in measured.items():
                result[key] += [{"scene": name, "objects": count, **row} for row in rows]
    return result


def measure_scene(triangles: int, objects: int, rounds: int, say=None) -> dict:
    """Measure one scene; rows of ``edits``, ``full`` and ``scenes``."""
    say = say or (lambda _line: None)
    build_scene(triangles, objects)
    title = f"{count_triangles()} triangles, {objects} objects"
    edits, full = [], []
    with Worker(ROOT) as worker:
        # The first one loads libraries and compiles kernels.
        Bench(worker).close()
        load = OtherLoad(worker.pid)
        for number, group in enumerate(GROUPS):
            bench = Bench(worker)
            full.append({"seconds": bench.full.seconds, "parts": bench.full.parts})
            say(f"{title}: full sync {bench.full.seconds:.2f} s")
            desk = Desk(number, bench.synchronise)
            for nth in range(1, rounds + 1):
                for edit in group:
                    timing = bench.measure(edit, desk, nth)
                    edits.append({"edit": edit.name, "nth": nth, **vars(timing)})
            bench.close()
        share = load.share()
    whole = median(row["seconds"] for row in full)
    for row in edits:
        row["ratio"] = row["seconds"] / whole
        say(f"{title}: {row['edit']} {row['nth']}: {1e3 * row['seconds']:.0f} ms")
    say(f"{title}: other processes took {100 * (share or 0.0):.0f} % of the processors")
    return {"edits": edits, "full": full, "scenes": [{"other_load": share}]}


class Bench:
    """A live view of the open scene, from an engine that knew nothing of it; ``full`` is what that took."""

    def __init__(self, worker: Worker):
        self.worker = worker
        self._random = random.Random(0)  # noqa: S311 - nothing secret
        depsgraph = bpy.context.evaluated_depsgraph_get()
        gc.collect()
        start = time.perf_counter()
        self.session = worker.session(f"benchmark {next(_numbers)}")
        self.feed = SceneFeed(self.session)
        made = self.feed.update(depsgraph)
        self.camera = self.feed.sync.camera(depsgraph, ConversionReport())
        self.session.watch(self.camera, LIVE, Display())
        self._commit = None
        frame = self._wait(self._is_current)
        self.full = _timing(start, {}, made, frame.commit)

    def close(self) -> None:
        """Let the worker forget the scene, and wait until it has."""
        self.session.close()
        self.worker.status()

    def synchronise(self) -> None:
        """Bring the engine up to date and wait for its sample."""
        bpy.context.view_layer.update()
        if self.feed.update(bpy.context.evaluated_depsgraph_get()) is not None:
            self._wait(self._is_current)

    def measure(self, edit, desk: Desk, nth: int) -> Timing:
        """Make an edit and wait for what it leads to."""
        change = edit.prepare(desk, nth)
        self._rest()
        if edit.answer is Answer.VIEW:
            return self._look(nth)
        start = time.perf_counter()
        change()
        changed = time.perf_counter()
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        evaluated = time.perf_counter()
        parts = {"edit": changed - start, "depsgraph": evaluated - changed}
        made = self.feed.update(depsgraph)
        if (made is None) != (edit.answer is Answer.NOTHING):
            sent = "nothing" if made is None else f"'{made.stats.changed}'"
            raise LumenrayError(f"benchmark: '{edit.name}' sent {sent}; a fault of the sync")
        if made is None:
            parts["walk"] = time.perf_counter() - evaluated
            return _timing(start, parts, None, None)
        frame = self._wait(self._is_current)
        return _timing(start, parts, made, frame.commit)

    def _look(self, nth: int) -> Timing:
        """Change the view alone."""
        camera, before = turned(self.camera, nth), self._commit
        start = time.perf_counter()
        self.session.watch(camera, LIVE, Display())
        # Each new view puts the time of its first sample down.
        frame = self._wait(lambda frame: frame.commit != before)
        parts = {"first sample": frame.commit.first_sample_seconds}
        return _timing(start, parts, None, None)

    def _is_current(self, frame) -> bool:
        return frame.revision >= self.feed.last.revision

    def _rest(self) -> None:
        """Let the view refine for a while; at the end no frame is waiting."""
        end = time.perf_counter() + self._random.uniform(*PAUSE)
        while time.perf_counter() < end:
            self._take()
            time.sleep(0.001)

    def _wait(self, is_wanted):
        end = time.perf_counter() + PATIENCE
        while time.perf_counter() < end:
            frame = self._take()
            if frame is not None and is_wanted(frame):
                return frame
            problem = self.session.view_error()
            if problem is not None:
                raise LumenrayError(f"benchmark: {problem}")
            time.sleep(0.001)
        raise LumenrayError(f"benchmark: no sample within {PATIENCE:.0f} s")

    def _take(self):
        frame = self.session.frame()
        if frame is not None:
            self._commit = frame.commit
        return frame


def _timing(start: float, parts: dict, made, commit) -> Timing:
    """Put the times of both processes together; what they do not explain is the rest."""
    seconds = time.perf_counter() - start
    sent = 0
    if made is not None:
        sent = sum(made.stats.sent.values()) + made.stats.removed
        parts |= {"walk": made.stats.walk_seconds, "transfer": made.transfer_seconds}
    if commit is not None:
        parts |= {"commit": commit.seconds, "first sample": commit.first_sample_seconds}
    parts["rest"] = max(seconds - sum(parts.values()), 0.0)
    whole = {name: round(parts.get(name, 0.0), 6) for name in PARTS}
    return Timing(round(seconds, 6), whole, sent)


# ---- files ----


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document and its picture to a folder, and all numbers to a JSON file if one is named."""
    from .chart import draw_chart
    from .document import write_document

    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    draw_chart(result, folder / "sync.png")
    write_document(result, folder / "sync.md")
