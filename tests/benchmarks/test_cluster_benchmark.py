"""The benchmark of clusters: what it demands and tells, the harm that it does to workers, and simulated ones."""

import subprocess
import sys
import time

import pytest

pytest.importorskip("distributed")

from lumenray.benchmarks.cluster import equality, harm, run, scaling
from lumenray.benchmarks.cluster.costs import JobCosts, Post
from lumenray.benchmarks.cluster.harm import Harm
from lumenray.benchmarks.cluster.simulation import LOOPBACK, Line, SimulatedCrew, Tail, run_chunks
from lumenray.engine.cluster.chunks import Chunk, Grain
from lumenray.engine.cluster.hosts import Host
from lumenray.engine.errors import LumenrayError

MACHINE = {"cpu": "some processor", "cores": 2}

FREE = Post(0.0, 0.0, 0.0, 0.0, 0.0)

GRAIN = Grain(100, 800, 10)


def costs(**changes):
    values = {
        "name": "sensors", "scene_bytes": 0, "task_bytes": 0, "answer_bytes": 0, "grain": GRAIN,
        "begin": 0.0, "fixed": 0.0, "pace": 0.01, "spread": (1.0,), "take": 0.0, "end": 0.0, "cold": 0.0,
    }  # fmt: skip
    return JobCosts(**values | changes)


def crew(workers, own=None, post=FREE, line=LOOPBACK, **options):
    names = tuple(f"{number:04}" for number in range(workers))
    return SimulatedCrew(names, own or costs(), post, line, own_time=lambda: 0.0, **options)


def alike(count, samples=100):
    return [Chunk(number, number, samples) for number in range(count)]


def made(equal=True, efficiency=0.95):
    rows = [{"harm": ["killed", "slowed"], "seconds": 3.0, "is_equal": equal}] * 2
    own = [
        {"workers": 1, "seconds": [2.0], "efficiency": 1.0},
        {"workers": 2, "seconds": [1.0], "efficiency": efficiency},
    ]
    parts = {
        "harm": {"samples": 1024, "rows": rows},
        "efficiency": {
            "machine": MACHINE, "others": 0.0, "samples": 1024, "is_equal": True, "rows": own
        },
    }  # fmt: skip
    return {
        "machine": MACHINE, "parts": parts, "elsewhere": None, "runs": 2, "equal": 2 * equal,
        "efficiency_2": efficiency,
    }  # fmt: skip


def test_demands_are_met_or_not():
    assert [bar.passed for bar in run.check_bars(made())] == [True, True, True, None]
    bad = run.check_bars(made(equal=False, efficiency=0.8))
    assert [bar.passed for bar in bad] == [False, True, False, None]
    # Without harm they have to be equal, too.
    unlike = made()
    unlike["parts"]["efficiency"]["is_equal"] = False
    assert run.check_bars(unlike)[1].passed is False


def test_the_document_tells_what_befell_workers(tmp_path):
    run.write_results(made(), tmp_path, tmp_path / "cluster.json")
    text = (tmp_path / "cluster.md").read_text()
    assert "| killed | 2 | 2 |" in text
    assert "| stopped | 0 | 0 |" in text
    assert "0.95" in text
    assert run.read_results(tmp_path / "cluster.json") == made()


def test_more_workers_than_processors_are_refused():
    with pytest.raises(LumenrayError, match="1000000 workers need as many processors"):
        equality.measure_efficiency((1, 1_000_000), 1, 1024, print)


@pytest.mark.parametrize(("workers", "rounds"), [(1, 12), (5, 3), (12, 1), (100, 1)])
def test_workers_that_cost_nothing_take_as_many_rounds_as_there_have_to_be(workers, rounds):
    assert run_chunks(crew(workers), alike(12)) == pytest.approx(rounds * 1.0)


def test_each_worker_begins_once_and_the_end_comes_once():
    own = costs(begin=2.0, end=3.0, fixed=0.5, take=0.25)
    # Two rounds of a chunk each; the last answers are merged one after the other.
    taken = run_chunks(crew(2, own), alike(4))
    assert taken == pytest.approx(2.0 + 2 * 1.5 + 3.0 + 4 * 0.25)


def test_scenes_leave_one_after_the_other_by_the_line():
    line = Line(8e6, 0.1)
    own = costs(scene_bytes=500_000)
    # Half a second each, which the last of four waits for; delays there and back.
    assert run_chunks(crew(4, own, line=line), alike(4)) == pytest.approx(4 * 0.5 + 2 * 0.1 + 1.0)


def test_the_scheduler_bounds_how_many_chunks_are_done_in_a_time():
    post = Post(0.02, 0.0, 0.02, 0.0, 0.0)
    taken = run_chunks(crew(50, costs(pace=0.001)), alike(200, 100))
    held_up = run_chunks(crew(50, costs(pace=0.001), post), alike(200, 100))
    assert taken == pytest.approx(200 / 50 * 0.1)
    assert held_up == pytest.approx(200 * 0.02, rel=0.1)


def test_late_chunks_are_done_by_others_too():
    tail = Tail(1.0, 1000.0, 50.0)
    patient = crew(2, tail=tail)
    # All are late alike, so nobody knows better; no answer is lost or counted twice.
    assert run_chunks(patient, alike(4)) >= 1000.0
    assert patient.most_held >= 1


def test_levers_change_what_they_name():
    own = costs(answer_bytes=1_000_000, scene_bytes=1000)
    rows = scaling.try_levers(own, FREE, 20, 0.2)
    table = {row["lever"]: row["efficiency"] for row in rows}
    assert 0.0 < min(table.values()) <= max(table.values()) <= 1.0 + 1e-9
    assert table["scene of 500 MB"] < table["as it is"]
    assert table["one chunk of 100 is late"] < table["as it is"]
    assert table["longest chunks a quarter"] > table["longest chunks four times"]


def test_jobs_are_as_long_as_said_and_saturate_somewhere():
    own = costs()
    assert own.work(scaling.samples_of(own, 1)) == pytest.approx(3600.0, rel=1e-3)
    curve = [{"workers": 10, "efficiency": 0.9}, {"workers": 20, "efficiency": 0.6}]
    assert [scaling.reaches(curve, share) for share in (0.95, 0.8, 0.5)] == [None, 10, 20]


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


def test_where_all_are_stopped_another_one_joins(sleepers):
    made = Harm(sleepers, 1, 0.0)
    for worker in list(sleepers.workers):
        made._stopped(worker)
    assert len(sleepers.workers) == 3
