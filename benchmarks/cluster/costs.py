"""What jobs and the carrying of their errands cost, measured on a cluster of this machine."""

import itertools
import time
from dataclasses import dataclass, field

import numpy as np

from ...engine import VERSION
from ...engine.accuracy.stopping import StopRule
from ...engine.cluster.chunks import OF_ONE_SIZE, Grain
from ...engine.cluster.crew import Crew, Reply
from ...engine.cluster.dask_crew import DaskCrew
from ...engine.cluster.hosts import LocalCluster
from ...engine.cluster.parcels import pack
from ...engine.cluster.session import ClusterSession
from ...engine.scene.scene import SceneDelta
from .kinds import LONG, Kind

TRIPS, ERRANDS, PARCELS = 100, 400, 20
"""Errands without work: one after the other, all at once, and with parcels."""

PARCEL = 8 << 20
"""Numbers of one byte in a parcel."""


@dataclass(frozen=True)
class Post:
    """What carrying an errand there and its answer back costs, beside the line.

    Parameters
    ----------
    round_trip : float    Of an errand without work, alone. [s]
    here, scheduler : float    Processor time of this process and of the scheduler's for an errand. [s]
    here_byte, scheduler_byte : float    The same for each byte. [s]
    """

    round_trip: float
    here: float
    scheduler: float
    here_byte: float
    scheduler_byte: float

    def of_bytes(self, count: int) -> float:
        """Time that bytes take, one way. [s]"""
        return count * (self.here_byte + self.scheduler_byte)


@dataclass(frozen=True)
class JobCosts:
    """What a kind of job costs.

    Parameters
    ----------
    name : str
    scene_bytes, task_bytes, answer_bytes : int    Of parcels.
    grain : Grain    How it is cut.
    begin : float    What a worker takes for its first chunk of a job beyond others: it builds the scene. [s]
    fixed, pace : float    What a chunk takes, and what each sample of every value adds. [s]
    spread : tuple of float    Times of equal chunks over their mean.
    take : float    Processor time here for unpacking and merging an answer. [s]
    end : float    Here, once all chunks are there. [s]
    cold : float    What the first chunk of a new worker takes beyond `begin`: it makes kernels. [s]
    """

    name: str
    scene_bytes: int
    task_bytes: int
    answer_bytes: int
    grain: Grain
    begin: float
    fixed: float
    pace: float
    spread: tuple[float, ...]
    take: float
    end: float
    cold: float

    def work(self, samples: int) -> float:
        """What a chunk takes a worker that has begun. [s]"""
        return self.fixed + self.pace * samples


@dataclass
class _Trip:
    scene: int
    task: int
    begun: float
    ended: float = 0.0
    answer: int = 0


@dataclass
class TimedCrew:
    """A crew whose errands are timed.

    Attributes
    ----------
    trips : dict    By errand, in the order in which they were sent.
    taking : list of (int, float)    Answers that came together, and the processor time until workers were looked for
        again. [s]
    """

    crew: Crew
    trips: dict[str, _Trip] = field(default_factory=dict)
    taking: list[tuple[int, float]] = field(default_factory=list)
    _taken: tuple[int, float] | None = None

    def workers(self) -> dict[str, float]:
        """As of `Crew`."""
        if self._taken is not None:
            count, begun = self._taken
            self.taking.append((count, time.thread_time() - begun))
            self._taken = None
        return self.crew.workers()

    def send(self, errand: str, worker: str, scene: bytes, task: bytes) -> None:
        """As of `Crew`."""
        self.trips[errand] = _Trip(len(scene), len(task), time.perf_counter())
        self.crew.send(errand, worker, scene, task)

    def replies(self, seconds: float) -> list[Reply]:
        """As of `Crew`."""
        found = self.crew.replies(seconds)
        for reply in found:
            trip = self.trips[reply.errand]
            trip.ended, trip.answer = time.perf_counter(), len(reply.parcel)
        if found:
            self._taken = len(found), time.thread_time()
        return found

    def recall(self, errand: str) -> None:
        """As of `Crew`."""
        self.crew.recall(errand)

    def drop(self, errand: str) -> None:
        """As of `Crew`."""
        self.crew.drop(errand)


def measure_post(cluster: LocalCluster) -> Post:
    """Send errands about a scene that nobody has, so that workers answer at once."""
    import psutil

    scheduler = psutil.Process(cluster.scheduler.pid)
    crew = DaskCrew(cluster.address, None)
    names = map("nothing-{}".format, itertools.count())

    def busy() -> np.ndarray:
        """Processor time of this process and of the scheduler's. [s]"""
        return np.array([time.process_time(), sum(scheduler.cpu_times()[:2])])

    def send(count: int, size: int) -> np.ndarray:
        before, left = busy(), count
        workers = sorted(crew.workers())
        task = {"method": "measure", "scene": "none", "revision": 0, "version": VERSION}
        parcel = pack(task | {"arguments": (np.zeros(size, dtype=np.uint8),)})
        for number in range(count):
            crew.send(next(names), workers[number % len(workers)], b"", parcel)
        while left:
            left -= len(crew.replies(1.0))
        return busy() - before

    try:
        send(1, 0)
        trips = []
        for _ in range(TRIPS):
            begin = time.perf_counter()
            send(1, 0)
            trips.append(time.perf_counter() - begin)
        each = send(ERRANDS, 0) / ERRANDS
        byte = np.maximum(send(PARCELS, PARCEL) - PARCELS * each, 0.0) / (PARCELS * PARCEL)
    finally:
        crew.close()
    return Post(float(np.median(trips)), *map(float, each), *map(float, byte))


def run_job(cluster: LocalCluster, kind: Kind, samples: int) -> tuple[TimedCrew, float, float]:
    """Have a job done; return its crew, what it took, and what of it after the last answer. [s]"""
    dask = DaskCrew(cluster.address, None)
    try:
        crew = TimedCrew(dask)
        door = ClusterSession(crew)
        door.apply(SceneDelta(changed=kind.build()))
        begin = time.perf_counter()
        kind.run(door, StopRule(samples=samples))
        end = time.perf_counter()
    finally:
        dask.close()
    last = max(trip.ended for trip in crew.trips.values())
    return crew, end - begin, end - last


def measure_costs(cluster: LocalCluster, kind: Kind, post: Post) -> tuple[JobCosts, float]:
    """Costs of a kind of job by the only worker of a cluster, and what the measured job took. [s]"""
    least = kind.grain.least
    first, _, _ = run_job(cluster, kind, least)
    crew, seconds, end = run_job(cluster, kind, kind.length * least)
    trips = list(crew.trips.values())
    times = [_computing(trip, post) for trip in trips]
    equal = np.array(times[1:OF_ONE_SIZE])
    mean = float(equal.mean())
    # Where no chunk is longer than others, all is laid on its samples.
    more = times[-1] - mean if kind.length == LONG else mean
    pace = min(max(more / least, 0.0), mean / least)
    begin = max(times[0] - mean, 0.0)
    taken = np.array(crew.taking)
    take = float(taken[:, 1].sum() / taken[:, 0].sum())
    cold = _computing(next(iter(first.trips.values())), post) - times[0]
    costs = JobCosts(
        kind.name,
        trips[0].scene,
        trips[0].task,
        trips[-1].answer,
        kind.grain,
        begin,
        mean - pace * least,
        pace,
        tuple((equal / mean).tolist()),
        take,
        max(end - take, 0.0),
        max(cold, 0.0),
    )
    return costs, seconds


def _computing(trip: _Trip, post: Post) -> float:
    """What a worker took for an errand. [s]"""
    carried = post.of_bytes(trip.scene + trip.task + trip.answer)
    return max(trip.ended - trip.begun - post.round_trip - carried, 1e-6)
