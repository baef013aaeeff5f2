"""Hands out the chunks of a job to workers, and out again where a worker dies, stalls or fails."""

import itertools
import secrets
import statistics
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from .. import VERSION
from ..errors import EngineFault, EngineLost
from ..worker import faults
from .chunks import Chunk, Tally
from .crew import Crew, Reply
from .parcels import pack, unpack

TICK = 0.2
"""Between two looks of whoever waits. [s]"""

SILENCE = 15.0
"""Time without a sign of life after which a worker is not counted on: it beats twice a second, among a thousand others every
11 s, and later where a machine is overloaded. [s]"""

SLOWNESS, LEAST_PATIENCE = 4.0, 20.0
"""Times the usual that a chunk may take before somebody else does it too, and the shortest time that is too long. [s]"""

FIRST_PATIENCE = 900.0
"""The same while nobody knows what chunks take: kernels are made, and large scenes sent and built. [s]"""

AHEAD = 2
"""Chunks for each worker that are handed out beyond the first that is not done."""

COPIES = 3
"""Workers that may be at the same chunk at once."""

MOST_OF_ONE = 2
"""Failures in a job after which a worker gets nothing more of it, as long as there are others."""

MOST_FAILURES = 4
"""Failures of the same chunk, of whichever workers, after which it is to blame itself."""

ALONE = 120.0
"""How long to wait where no worker is there. [s]"""


@dataclass
class _Errand:
    """A worker on its way with a chunk."""

    worker: str
    chunk: Chunk
    begun: float
    # Whether the scene went with it.
    is_first: bool


@dataclass
class Job:
    """What is to be done for every chunk.

    Parameters
    ----------
    scene_of : callable    ``scene_of(known)`` gives the parcel that brings a worker's scene up to date from the revision
        ``known``, None for none; empty where it is.
    revision : int    Of the scene that the job is about.
    task_of : callable    ``task_of(chunk)`` gives what `workplace.work` needs to know, as plain data.
    """

    scene_of: Callable[[int | None], bytes]
    revision: int
    task_of: Callable[[Chunk], dict]


@dataclass
class Dispatcher:
    """Has workers do the chunks of jobs, one job at a time.

    Parameters
    ----------
    crew : Crew
    clock : callable    Gives the time. [s]

    Attributes
    ----------
    known : dict    Revision of the scene that each worker holds.
    makes : set of str    What workers are that have done chunks of the last job, as of `workplace.describe`.
    """

    crew: Crew
    clock: Callable[[], float] = time.monotonic
    known: dict[str, int] = field(default_factory=dict)
    makes: set[str] = field(default_factory=set)
    names: Iterator[str] = field(
        default_factory=lambda: map(f"{secrets.token_hex(8)}-{{}}".format, itertools.count())
    )

    def run(self, job: Job, chunks: Iterator[Chunk]) -> Iterator:
        """Answers of chunks in their order; closing the iterator ends the job.

        Yields
        ------
        (Chunk, value)    Of the next chunk in order; None where nothing was for a while.

        Raises
        ------
        LumenrayError    What a worker says of the scene or the order.
        EngineFault    A chunk cannot be computed by anybody.
        EngineLost    The cluster is gone, or has had no worker for too long.
        """
        self.makes.clear()
        work = _Work(self, job, chunks)
        try:
            yield from work.run()
        finally:
            for name in list(work.errands):
                self.crew.drop(name)


class _Work:
    def __init__(self, host: Dispatcher, job: Job, chunks: Iterator[Chunk]):
        self.host, self.crew, self.job = host, host.crew, job
        self.source, self.tally = iter(chunks), Tally()
        # Chunks that were cut so far; of those that are done nothing but their number is kept.
        self.cut, self.is_cut_up = 0, False
        self.chunks: dict[int, Chunk] = {}
        self.failures: dict[int, list[str]] = {}
        self.failed: Counter = Counter()
        self.errands: dict[str, _Errand] = {}
        # Seconds of a sample, of chunks that came without a scene.
        self.paces: list[float] = []
        self.alone_since: float | None = None

    def run(self) -> Iterator:
        while True:
            workers = self.crew.workers()
            self._forget(workers)
            self._hand_out(workers)
            replies = self.crew.replies(TICK)
            for reply in replies:
                self._take(reply)
            yield from self.tally.give()
            if self.is_cut_up and self.tally.next >= self.cut:
                return
            if not replies:
                yield None

    def _forget(self, workers: dict[str, float]) -> None:
        """Give up what workers were at that are gone, and wait for others no longer than `ALONE`."""
        for name, errand in list(self.errands.items()):
            if errand.worker not in workers:
                self._take(Reply(name, trouble="it is gone", is_lost=True))
        for worker in [name for name in self.host.known if name not in workers]:
            del self.host.known[worker]
        now = self.host.clock()
        if any(silence < SILENCE for silence in workers.values()):
            self.alone_since = None
            return
        self.alone_since = now if self.alone_since is None else self.alone_since
        if now - self.alone_since > ALONE:
            raise EngineLost(
                f"the cluster has had no worker that answers for {ALONE:g} s; start some with 'lumenray cluster worker'"
            )

    def _hand_out(self, workers: dict[str, float]) -> None:
        busy = {errand.worker for errand in self.errands.values()}
        free = [name for name in sorted(workers) if name not in busy and workers[name] < SILENCE]
        # Who fails where others do not lacks something.
        able = [name for name in workers if self.failed[name] < MOST_OF_ONE]
        for worker in free:
            if able and worker not in able:
                continue
            chunk = self._next_chunk(workers)
            if chunk is None:
                # Nor is there anything for others.
                return
            self._send(worker, chunk)

    def _next_chunk(self, workers: dict[str, float]) -> Chunk | None:
        """What a free worker does next: what nobody is at, else what others take too long for."""
        at = {}
        for errand in self.errands.values():
            at.setdefault(errand.chunk.number, []).append(errand)
        waiting = [number for number in self.chunks if number not in at]
        if waiting:
            return self.chunks[min(waiting)]
        if not self.is_cut_up and self.cut < self.tally.next + AHEAD * len(workers):
            chunk = next(self.source, None)
            if chunk is not None:
                self.cut += 1
                self.chunks[chunk.number] = chunk
                return chunk
            self.is_cut_up = True
        late = [
            number
            for number, errands in at.items()
            if number in self.chunks
            and len(errands) < COPIES
            and all(self._is_late(each, workers) for each in errands)
        ]
        return self.chunks[min(late)] if late else None

    def _is_late(self, errand: _Errand, workers: dict[str, float]) -> bool:
        if workers.get(errand.worker, SILENCE) >= SILENCE:
            return True
        usual = statistics.median(self.paces) * errand.chunk.samples if self.paces else None
        patience = FIRST_PATIENCE if usual is None else max(SLOWNESS * usual, LEAST_PATIENCE)
        if usual is not None and errand.is_first:
            # It has to build the scene, and maybe to make kernels.
            patience += max(self.paces) * errand.chunk.samples + LEAST_PATIENCE
        return self.host.clock() - errand.begun > patience

    def _send(self, worker: str, chunk: Chunk) -> None:
        known = self.host.known.get(worker)
        scene = self.job.scene_of(known)
        name = next(self.host.names)
        self.errands[name] = _Errand(worker, chunk, self.host.clock(), bool(scene))
        self.crew.send(
            name,
            worker,
            scene,
            pack(self.job.task_of(chunk) | {"errand": name, "version": VERSION}),
        )

    def _take(self, reply: Reply) -> None:
        """Take note of what came of an errand."""
        errand = self.errands.pop(reply.errand, None)
        if errand is None:
            return
        chunk = errand.chunk
        if reply.is_lost:
            # The worker is to blame, not the chunk; and its scene is gone with it.
            self.host.known.pop(errand.worker, None)
            self.crew.drop(reply.errand)
            return
        answer = {"state": "failed", "text": reply.trouble}
        if not reply.trouble:
            answer = unpack(reply.parcel)
        if answer["state"] == "lacks":
            # Another process has taken its place, or it had too many scenes to keep.
            self.host.known.pop(errand.worker, None)
            return
        self.host.known[errand.worker] = self.job.revision
        if answer["state"] == "refused":
            raise faults.rebuild(*answer["fault"])
        if answer["state"] == "failed":
            self._note_failure(errand, answer["text"])
        if answer["state"] != "done":
            return
        if not errand.is_first and chunk.samples:
            self.paces.append((self.host.clock() - errand.begun) / chunk.samples)
        self.host.makes.add(answer["make"])
        self.tally.take(chunk.number, (chunk, answer["value"]))
        self.chunks.pop(chunk.number, None)
        for name, other in self.errands.items():
            if other.chunk.number == chunk.number:
                # Its worker is busy until it says that it has left it.
                self.crew.recall(name)

    def _note_failure(self, errand: _Errand, text: str) -> None:
        self.failed[errand.worker] += 1
        said = self.failures.setdefault(errand.chunk.number, [])
        said.append(f"{errand.worker}: {text}")
        if len(said) >= MOST_FAILURES:
            raise EngineFault(
                f"chunk {errand.chunk.number} of the job failed {len(said)} times; the last time at {said[-1]}"
            )
