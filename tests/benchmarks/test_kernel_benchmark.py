"""The benchmark of kernels: its demands and its document, from numbers that are known."""

from lumenray.benchmarks.kernels import run


def step(built: int, seconds: float) -> dict:
    """Numbers of one step."""
    return {
        "built": built,
        "seconds": 2.0 * seconds,
        "build_seconds": seconds,
        "largest": 1000,
        "functions": 3,
    }


def result(seconds: float, by_edit: int, again: int) -> dict:
    """Numbers of a run."""
    edits = {name: step(by_edit, 0.5) for name in run.EDITS}
    cold = {"full paths": step(9, seconds)} | edits
    warm = {name: step(again, 0.0) for name in cold}
    trial = {"lanes": 8, "seconds": 2.0, "beside": 0.1, "functions": 12, "build_seconds": 3.0}
    orders = {"as they come": 1.0, "by what they meet": 0.9}
    trials = {
        "as it is": trial | {"orders": orders, "sorting": 0.004},
        "16 lanes": trial | {"lanes": 16, "seconds": 3.0},
        "calls not optimised": {"refusal": "Dr.Jit does not tell its lanes here"},
    }
    machine = {"cpu": "a processor", "cores": 2}
    made = {"size": [16, 10], "samples": 2, "machine": machine, "trials": trials}
    return {"cold": cold, "warm": warm} | made


def test_the_demands_are_judged():
    assert [bar.passed for bar in run.check_bars(result(1.5, 0, 0))] == [True] * 3
    assert [bar.passed for bar in run.check_bars(result(30.0, 1, 2))] == [False] * 3


def test_the_document_tells_every_step_and_what_is_not_met(tmp_path):
    run.write_results(result(30.0, 1, 0), tmp_path, tmp_path / "numbers.json")
    text = (tmp_path / "kernels.md").read_text()
    assert text.count("| the walls painted |") == 2
    assert "| 16 lanes | 16 | 12 | 3.0 s | 3.00 s | 1.50 | 10 % |" in text
    assert "| calls not optimised | Dr.Jit does not tell its lanes here |" in text
    assert "| by what they meet | 0.90 s | 0.90 |" in text
    assert "Not met: building for the first pictures: 30.0 s" in text
    assert (tmp_path / "numbers.json").exists()
