"""Workers of a Dask cluster: each errand is a task for one worker, so that Dask moves nothing by itself."""

import logging
import queue
import threading
import time
from functools import partial

from ..errors import EngineLost, LumenrayError
from . import workplace
from .crew import Reply
from .security import Address, Certificates, check_address, make_security

log = logging.getLogger(__name__)

PATIENCE = 20.0
"""How long a scheduler may take to answer. [s]"""

WORD_PATIENCE = 3.0
"""How long whoever ends waits for workers that have to hear so. [s]"""

LOOK_INTERVAL = 1.0
"""Time between two questions who is there. [s]"""

SETTINGS = {
    # A scene goes with the first errand of each worker.
    "distributed.admin.large-graph-warning-threshold": "1TB",
    # A worker that is stopped is ours to give up; Dask would only wait.
    "distributed.scheduler.worker-ttl": None,
    "distributed.comm.timeouts.connect": f"{PATIENCE:g}s",
    "distributed.comm.retry.count": 0,
    "distributed.scheduler.work-stealing": False,
}
"""Of Dask, in the processes of commands, schedulers and workers."""


def load_dask():
    """Return Dask's `distributed`, set up.

    Raises
    ------
    LumenrayError    It is not installed.
    """
    try:
        import dask
        import distributed
    except ImportError as error:
        raise LumenrayError(
            f"clusters need Dask, which is not installed ({error}): install the zip lumenray-cluster for this Blender as "
            "you did Lumenray's, or without Blender 'pip install lumenray[cluster]'"
        ) from None
    dask.config.set(SETTINGS)
    # It tells at length what is told here in one sentence.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    return distributed


class DaskCrew:
    """The workers of a scheduler. Threads of Dask put what comes into a queue, from which `replies` takes it.

    Parameters
    ----------
    address : Address
    certificates : Certificates or None

    Raises
    ------
    LumenrayError    The address may not be used, Dask is not installed, or nobody answers.
    """

    def __init__(self, address: Address, certificates: Certificates | None):
        check_address(address, certificates)
        distributed = load_dask()
        self.address = address
        try:
            self._client = distributed.Client(
                str(address),
                security=make_security(address, certificates),
                timeout=PATIENCE,
                set_as_default=False,
            )
        except (OSError, TimeoutError, ValueError) as error:
            raise LumenrayError(
                f"no scheduler answers at {address} ({_first_line(error)}); start one with 'lumenray cluster local' or "
                "'lumenray cluster scheduler', and check address and certificates"
            ) from None
        self._replies: queue.SimpleQueue = queue.SimpleQueue()
        self._words: list[threading.Thread] = []
        self._futures: dict[str, object] = {}
        self._at: dict[str, str] = {}
        self._seen: dict[str, tuple[float, float]] = {}
        self._looked = -LOOK_INTERVAL

    def workers(self) -> dict[str, float]:
        """Workers that are there, as of `Crew`."""
        now = time.monotonic()
        if now - self._looked >= LOOK_INTERVAL:
            try:
                told = self._client.sync(
                    self._client.scheduler.identity, n_workers=-1, callback_timeout=PATIENCE
                )
            except Exception as error:
                raise EngineLost(
                    f"the cluster's scheduler at {self.address} does not answer any more ({_first_line(error)}); start it "
                    "and the command again"
                ) from None
            seen = {}
            for worker, facts in told["workers"].items():
                beat = facts["last_seen"]
                known = self._seen.get(worker)
                # Clocks of machines differ, so only whether it has changed counts.
                seen[worker] = (beat, now) if known is None or known[0] != beat else known
            self._seen, self._looked = seen, now
        return {worker: now - since for worker, (_, since) in self._seen.items()}

    def send(self, errand: str, worker: str, scene: bytes, task: bytes) -> None:
        """Send a worker to work, as of `Crew`."""
        future = self._client.submit(
            workplace.work,
            scene,
            task,
            key=errand,
            workers=[worker],
            allow_other_workers=False,
            pure=False,
        )
        self._futures[errand], self._at[errand] = future, worker
        future.add_done_callback(partial(self._take, errand))

    def replies(self, seconds: float) -> list[Reply]:
        """What has come, as of `Crew`."""
        found = []
        try:
            found.append(self._replies.get(timeout=seconds))
            while True:
                found.append(self._replies.get_nowait())
        except queue.Empty:
            pass
        for reply in found:
            self._futures.pop(reply.errand, None)
            self._at.pop(reply.errand, None)
        return found

    def recall(self, errand: str) -> None:
        """Tell a worker to leave an errand, as of `Crew`."""
        worker = self._at.get(errand)
        if worker is not None:
            # Dask waits for an answer; nobody here does, as the worker may be stopped.
            word = threading.Thread(target=self._tell, args=(worker, errand), daemon=True)
            word.start()
            self._words = [each for each in self._words if each.is_alive()] + [word]

    def drop(self, errand: str) -> None:
        """Recall an errand and forget it."""
        self.recall(errand)
        self._at.pop(errand, None)
        future = self._futures.pop(errand, None)
        if future is not None:
            future.cancel()

    def close(self) -> None:
        """Let go of the scheduler, once workers that listen have been told what to leave."""
        for word in self._words:
            word.join(WORD_PATIENCE / len(self._words))
        self._client.close(timeout=PATIENCE)

    def _tell(self, worker: str, errand: str) -> None:
        try:
            self._client.run(workplace.recall, errand, workers=[worker])
        except Exception as error:
            log.info("%s was not told to leave errand %s: %s", worker, errand, error)

    def _take(self, errand: str, future) -> None:
        """Called on a thread of Dask when a task has come to its end."""
        if errand not in self._futures:
            return
        reply = Reply(errand, trouble=f"the task was {future.status}", is_lost=True)
        try:
            if future.status == "finished":
                reply = Reply(errand, future.result(timeout=PATIENCE))
            elif future.status == "error":
                error = future.exception(timeout=PATIENCE)
                is_lost = type(error).__name__ == "KilledWorker"
                reply = Reply(errand, trouble=_first_line(error), is_lost=is_lost)
        except Exception as error:
            reply = Reply(errand, trouble=_first_line(error), is_lost=True)
        self._replies.put(reply)


def _first_line(error) -> str:
    lines = str(error).strip().splitlines()
    return lines[0] if lines else type(error).__name__
