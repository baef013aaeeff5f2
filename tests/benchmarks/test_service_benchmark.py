"""How the benchmark of the service counts and judges."""

from pathlib import Path

from lumenray.benchmarks.service import run as service


def row(state):
    return {"state": state, "attempts": 1}


def count(orders, jobs, results):
    seen = {Path("jobs") / key: "digest" for key in results}
    return service.count_faults([orders], [jobs], seen)


def test_orders_with_one_done_job_each_are_sound():
    jobs = {"1": row("done"), "2": row("done")}
    assert count({"a": "1", "b": "2"}, jobs, ["1", "2"]) == (0, 0)


def test_a_job_without_results_or_that_failed_is_lost():
    orders = {"a": "1", "b": "2", "c": "3"}
    jobs = {"1": row("done"), "2": row("failed")}
    assert count(orders, jobs, ["2"]) == (3, 0)


def test_jobs_and_results_that_nobody_ordered_are_doubles():
    jobs = {"1": row("done"), "2": row("done")}
    assert count({"a": "1"}, jobs, ["1", "2", "4"]) == (0, 2)
    assert count({"a": "1", "b": "1"}, {"1": row("done")}, ["1"]) == (0, 1)


def test_results_that_change_are_seen(tmp_path):
    folder = tmp_path / "users" / "u" / "jobs" / "1"
    folder.mkdir(parents=True)
    (folder / "readings.json").write_text("first")
    seen = {}
    assert service.look_at_results(tmp_path, seen) == 0
    assert service.look_at_results(tmp_path, seen) == 0
    (folder / "readings.json").write_text("second")
    assert service.look_at_results(tmp_path, seen) == 1


def test_demands_are_judged(tmp_path):
    result = {
        "machine": {"cpu": "x", "cores": 2},
        "users": 20, "kills": 10, "jobs": 500, "lost": 0, "doubled": 1, "begun_anew": 3, "seconds": 9.0, "reads": 5,
        "p50_ms": 3.0, "p95_ms": 199.0, "p99_ms": 400.0,
    }  # fmt: skip
    assert [bar.passed for bar in service.check_bars(result)] == [True, True, False]
    service.write_results(result, tmp_path, None)
    assert "Not met: jobs with two results: 1." in (tmp_path / "service.md").read_text()
