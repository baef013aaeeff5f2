"""The benchmark of clusters: what it demands and tells, and the harm that it does to workers."""

import subprocess
import sys
import time

import pytest

pytest.importorskip("distributed")

from lumenray.benchmarks.cluster import harm, run
from lumenray.benchmarks.cluster.harm import Harm
from lumenray.engine.cluster.hosts import Host


def made(equal=True, efficiency=0.95):
    rows = [{"harm": ["killed", "slowed"], "seconds": 3.0, "is_equal": equal}] * 2
    return {
        "machine": {"cpu": "some processor", "cores": 2}, "samples": 1024, "pairs": 1, "rows": rows,
        "plain_equal": True, "one_seconds": [2.0], "two_seconds": [1.0], "efficiency_2": efficiency,
        "runs": 2, "equal": 2 * equal,
    }  # fmt: skip


def test_demands_are_met_or_not():
    assert all(bar.passed for bar in run.check_bars(made()))
    assert [bar.passed for bar in run.check_bars(made(equal=False, efficiency=0.8))] == [
        False,
        False,
    ]
    # Without harm they have to be equal, too.
    assert not run.check_bars(made() | {"plain_equal": False})[0].passed


def test_the_document_tells_what_befell_workers(tmp_path):
    run.write_results(made(), tmp_path, tmp_path / "cluster.json")
    text = (tmp_path / "cluster.md").read_text()
    assert "| killed | 2 | 2 |" in text
    assert "| stopped | 0 | 0 |" in text
    assert "0.95" in text


class Sleepers:
    """Stands for a cluster: processes that sleep."""

    def __init__(self, count):
        self.workers = []
        for _ in range(count):
            self.add_worker()

    def add_worker(self):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        code = "import time; time.sleep(60)"
        self.workers.append(Host(subprocess.Popen([sys.executable, "-S", "-c", code], **pipes), ""))


@pytest.fixture
def sleepers():
    cluster = Sleepers(2)
    yield cluster
    for worker in cluster.workers:
        worker.end()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_harm_befalls_workers_and_leaves_as_many(sleepers, seed, monkeypatch):
    monkeypatch.setattr(harm, "SLOW_SECONDS", 0.1)
    monkeypatch.setattr(harm, "BEAT", 0.01)
    with Harm(sleepers, seed, 0.02) as done:
        time.sleep(0.3)
    assert done.done
    assert set(done.done) <= set(harm.KINDS)
    assert sum(worker.is_running for worker in sleepers.workers) == 2
