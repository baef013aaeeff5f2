"""Workers in virtual time, by thousands, whom the engine's own dispatcher sends about.

One queue each stands for what does one thing at a time: this process, the scheduler, and either direction of the line. The
dispatcher's own processor time is that which it takes here while it is simulated, so what grows in it with the number of
workers is in the result.
"""

import heapq
import random
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from ...engine.cluster.chunks import Chunk
from ...engine.cluster.crew import Reply
from ...engine.cluster.dispatch import Dispatcher, Job
from ...engine.cluster.parcels import pack, unpack
from .costs import JobCosts, Post

SCENE = b"scene"
"""Stands for a parcel, whose size is among the costs."""

DONE = pack({"state": "done", "make": "simulated", "value": None})

LEFT = pack({"state": "left"})


@dataclass(frozen=True)
class Line:
    """A line between the scheduler's machine and all workers. ``rate`` [bit/s], ``delay`` [s]"""

    rate: float
    delay: float

    def seconds(self, count: int) -> float:
        """For how long bytes fill it. [s]"""
        return 8.0 * count / self.rate


LOOPBACK = Line(float("inf"), 0.0)
"""Of one machine, where what carrying costs is processor time."""


@dataclass(frozen=True)
class Tail:
    """Chunks that are late beyond what was measured: a ``share`` of them by a factor of Pareto's distribution."""

    share: float = 0.0
    least: float = 2.0
    exponent: float = 1.5


@dataclass
class SimulatedCrew:
    """A crew on a clock of its own.

    Parameters
    ----------
    names : tuple of str
    costs : JobCosts
    post : Post
    line : Line
    tail : Tail
    seed : int    Says how long which chunk takes.
    is_cold : bool    Whether workers have no kernels yet.
    own_time : callable    Processor time of this thread. [s]

    Attributes
    ----------
    most_held : int    Answers that have come and were not taken yet, at most.
    """

    names: tuple[str, ...]
    costs: JobCosts
    post: Post
    line: Line = LOOPBACK
    tail: Tail = Tail()
    seed: int = 0
    is_cold: bool = False
    own_time: Callable[[], float] = time.thread_time
    most_held: int = 0
    _now: float = 0.0
    _free: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(("scheduler", "out", "in"), 0.0)
    )
    _begun: set = field(default_factory=set)
    # When what happens, by errand: "done" at its worker, "here" when its answer has arrived.
    _events: list = field(default_factory=list)
    _at: dict[str, str] = field(default_factory=dict)
    _left: set = field(default_factory=set)
    _held: int = 0

    def __post_init__(self):
        self._draw = random.Random(self.seed)  # noqa: S311
        self._seen = self.own_time()
        self._present = dict.fromkeys(self.names, 0.0)

    def clock(self) -> float:
        """Virtual time. [s]"""
        now = self.own_time()
        self._now += now - self._seen
        self._seen = now
        return self._now

    def spend(self, seconds: float) -> None:
        """Be busy here. [s]"""
        self._now += seconds

    def take(self, seconds: float) -> None:
        """Unpack and merge the next answer. [s]"""
        self.spend(seconds)
        self._held -= 1

    def workers(self) -> dict[str, float]:
        """As of `Crew`; nobody is silent."""
        return self._present

    def send(self, errand: str, worker: str, scene: bytes, task: bytes) -> None:
        """As of `Crew`."""
        self.clock()
        size = self.costs.task_bytes + (self.costs.scene_bytes if scene else 0)
        self.spend(0.5 * self.post.here + self.post.here_byte * size)
        there = self._use("scheduler", self._now, self._service(size))
        there = self._use("out", there, self.line.seconds(size)) + self.line.delay
        self._at[errand] = worker
        work = self._work(worker, unpack(task)["samples"])
        heapq.heappush(self._events, (there + self._idle() + work, "done", errand))
        self._seen = self.own_time()

    def replies(self, seconds: float) -> list[Reply]:
        """As of `Crew`."""
        end = self.clock() + seconds
        found = []
        while self._events and self._events[0][0] <= (self._now if found else end):
            at, what, errand = heapq.heappop(self._events)
            if what == "done":
                if errand in self._at:
                    self._answer(at, errand)
                continue
            self._now = max(self._now, at)
            if self._at.pop(errand, None) is None:
                continue
            is_left = errand in self._left
            self._left.discard(errand)
            size = len(LEFT) if is_left else self.costs.answer_bytes
            self.spend(0.5 * self.post.here + self.post.here_byte * size)
            self._held += not is_left
            found.append(Reply(errand, LEFT if is_left else DONE))
        if not found:
            self._now = max(self._now, end)
        self.most_held = max(self.most_held, self._held)
        self._seen = self.own_time()
        return found

    def recall(self, errand: str) -> None:
        """As of `Crew`; its worker leaves the errand as soon as it hears of it."""
        if errand in self._at and errand not in self._left:
            self._left.add(errand)
            heapq.heappush(self._events, (self.clock() + self.line.delay, "done", errand))

    def drop(self, errand: str) -> None:
        """As of `Crew`."""
        self._at.pop(errand, None)

    def _answer(self, at: float, errand: str) -> None:
        """Have an answer set out."""
        size = len(LEFT) if errand in self._left else self.costs.answer_bytes
        here = self._use("in", at + self.line.delay, self.line.seconds(size))
        here = self._use("scheduler", here, self._service(size))
        heapq.heappush(self._events, (here, "here", errand))

    def _use(self, what: str, since: float, seconds: float) -> float:
        """When something that does one thing at a time has done this."""
        self._free[what] = max(self._free[what], since) + seconds
        return self._free[what]

    def _service(self, size: int) -> float:
        return 0.5 * self.post.scheduler + self.post.scheduler_byte * size

    def _idle(self) -> float:
        """What of a round trip nobody is busy with. [s]"""
        return max(self.post.round_trip - self.post.here - self.post.scheduler, 0.0)

    def _work(self, worker: str, samples: int) -> float:
        seconds = self.costs.work(samples) * self._draw.choice(self.costs.spread)
        if self._draw.random() < self.tail.share:
            seconds *= self.tail.least * self._draw.paretovariate(self.tail.exponent)
        if worker not in self._begun:
            self._begun.add(worker)
            seconds += self.costs.begin + (self.costs.cold if self.is_cold else 0.0)
        return seconds


def run_chunks(crew: SimulatedCrew, chunks: list[Chunk]) -> float:
    """Have a crew do a job, and return what it took. [s]"""
    job = Job(
        lambda known: b"" if known == 1 else SCENE, 1, lambda chunk: {"samples": chunk.samples}
    )
    begin, left = crew.clock(), len(chunks)
    running = Dispatcher(crew, crew.clock).run(job, iter(chunks))
    # As sessions do, which end a job as soon as it has its samples.
    while left:
        if next(running) is not None:
            crew.take(crew.costs.take)
            left -= 1
    running.close()
    crew.spend(crew.costs.end)
    return crew.clock() - begin
