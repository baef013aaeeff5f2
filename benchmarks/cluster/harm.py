"""What befalls workers in a run: at random times they are killed, stopped and slowed."""

import os
import random
import signal
import threading
from dataclasses import dataclass, field

KINDS = ("killed", "stopped", "slowed")

MOST = 3
"""Harms of a run."""

SLOW_SECONDS, BEAT = 8.0, 0.4
"""How long a worker is slowed, and for how long it then runs and stands in turn. [s]"""


@dataclass
class Harm:
    """Harms the workers of a cluster until the end of the block.

    Parameters
    ----------
    cluster : LocalCluster
    seed : int    Says what befalls whom, and when.
    span : float    Time within which it begins. [s]

    Attributes
    ----------
    done : list of str    What has befallen workers.
    """

    cluster: object
    seed: int
    span: float
    done: list = field(default_factory=list)

    def __post_init__(self):
        self._over = threading.Event()
        self._still: set[int] = set()
        self._fault: BaseException | None = None
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> "Harm":
        self._thread.start()
        return self

    def __exit__(self, *_) -> None:
        self._over.set()
        self._thread.join()
        for worker in self.cluster.workers:
            if worker.is_running:
                os.kill(worker.pid, signal.SIGCONT)
        if self._fault is not None:
            raise self._fault

    def _run(self) -> None:
        try:
            draw = random.Random(self.seed)  # noqa: S311
            plan = sorted(
                (draw.uniform(0.0, self.span), draw.choice(KINDS), draw.random())
                for _ in range(draw.randint(1, MOST))
            )
            now = 0.0
            for begin, kind, which in plan:
                if self._over.wait(max(begin - now, 0.0)):
                    return
                now = max(begin, now)
                alive = [worker for worker in self.cluster.workers if worker.is_running]
                worker = alive[int(which * len(alive))]
                self.done.append(kind)
                getattr(self, f"_{kind}")(worker)
        except BaseException as error:
            self._fault = error

    def _killed(self, worker) -> None:
        worker.end()
        self.cluster.workers.remove(worker)
        # Another one joins.
        self.cluster.add_worker()

    def _stopped(self, worker) -> None:
        """Until the end of the run."""
        os.kill(worker.pid, signal.SIGSTOP)
        self._still.add(worker.pid)
        # Of nobody nothing is to be had: where this was the last one, another one joins.
        running = (each.pid for each in self.cluster.workers if each.is_running)
        if self._still.issuperset(running):
            self.cluster.add_worker()

    def _slowed(self, worker) -> None:
        for _ in range(int(SLOW_SECONDS / (2.0 * BEAT))):
            if self._over.is_set() or not worker.is_running:
                return
            os.kill(worker.pid, signal.SIGSTOP)
            self._over.wait(BEAT)
            os.kill(worker.pid, signal.SIGCONT)
            self._over.wait(BEAT)
