"""A scheduler and workers in processes of their own: the same bits while workers are killed, stopped and join."""

import os
import signal
import threading
import time

import numpy as np
import pytest
from workers import is_running, room

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import EngineLost, LumenrayError
from lumenray.engine.scene.scene import SceneDelta

distributed = pytest.importorskip("distributed")

from lumenray.engine.cluster import session as cluster  # noqa: E402
from lumenray.engine.cluster.dask_crew import DaskCrew  # noqa: E402
from lumenray.engine.cluster.hosts import LocalCluster  # noqa: E402
from lumenray.engine.cluster.security import read_address  # noqa: E402

pytestmark = [pytest.mark.slow, pytest.mark.mitsuba]

PLACES = np.array([[0.5, 0.5, 0.4], [1.5, 0.5, 0.4], [1.0, 1.5, 0.4]])
UP = np.tile([0.0, 0.0, 1.0], (3, 1))


@pytest.fixture(scope="module")
def local():
    with LocalCluster(2, threads=1) as made:
        yield made


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    monkeypatch.setattr(cluster, "LEAST_PATHS", 1)
    monkeypatch.setattr(cluster, "MOST_PATHS", 1)


def measure(local, progress=None):
    crew = DaskCrew(local.address, None)
    try:
        session = cluster.ClusterSession(crew)
        session.apply(SceneDelta(changed=room()))
        rule = StopRule(samples=16 * 1024)
        return session.measure(
            PLACES, UP, rule, 3, progress=progress, method="paths", witness=False
        )
    finally:
        crew.close()


def test_results_have_the_same_bits_whatever_befalls_workers(local):
    plain = measure(local)
    harmed = []

    def harm(state):
        if state.samples >= 2048 and not harmed:
            harmed.append(local.workers.pop(0))
            harmed[0].end()
            threading.Thread(target=local.add_worker).start()
        if state.samples >= 8192 and len(harmed) == 1:
            harmed.append(local.workers[0])
            os.kill(harmed[1].pid, signal.SIGSTOP)

    made = measure(local, harm)
    os.kill(harmed[1].pid, signal.SIGCONT)
    np.testing.assert_array_equal(made.illuminance, plain.illuminance)
    np.testing.assert_array_equal(made.standard_error, plain.standard_error)


def test_nothing_is_left_of_a_cluster():
    with LocalCluster(1, threads=1) as made:
        processes = [made.scheduler.pid, made.workers[0].pid]
    assert not any(map(is_running, processes))


def test_a_scheduler_that_ends_is_told():
    with LocalCluster(0) as made:
        crew = DaskCrew(made.address, None)
        made.scheduler.end()
        with pytest.raises(EngineLost, match="does not answer any more"):
            for _ in range(60):
                crew.workers()
                time.sleep(0.5)
        crew.close()


def test_where_nobody_answers_somebody_is_told():
    with pytest.raises(LumenrayError, match=r"no scheduler answers at tcp://127\.0\.0\.1:9"):
        DaskCrew(read_address("tcp://127.0.0.1:9"), None)
