"""What the benchmark of the atlas makes of its runs: statistics, summary, bars and document."""

import json
from dataclasses import replace

import numpy as np
import pytest

from lumenray.engine.accuracy.history import History, Mark
from lumenray.engine.baking.order import BakeResult, Seams

pytestmark = pytest.mark.mitsuba


def test_times_to_an_error_follow_the_runs():
    from lumenray.benchmarks.common.statistics import seconds_to

    # error = 0.1 / sqrt(seconds)
    points = [(seconds, 0.1 / np.sqrt(seconds)) for seconds in (1.0, 4.0, 16.0, 64.0)]
    within = seconds_to(points, 0.02)
    assert (within.seconds, within.is_thought_on) == (pytest.approx(25.0), False)
    beyond = seconds_to(points, 0.005)
    assert (beyond.seconds, beyond.is_thought_on) == (pytest.approx(400.0), True)
    assert seconds_to(points, 0.5).bound == "<"
    # A biased program comes to an end.
    flat = [(1.0, 0.05), (4.0, 0.031), (16.0, 0.0301), (64.0, 0.03)]
    assert seconds_to(flat, 0.01).bound == ">"


def made_up_reference(values, errors):
    """Reference with lumels of 1 m2."""
    from lumenray.benchmarks.atlas.references import Reference

    return Reference(values, errors, np.ones(len(values)), 1, 1.0)


@pytest.mark.parametrize("honesty", [0.5, 1.0, 2.0])
def test_calibration_finds_how_honest_an_error_is(honesty):
    """Stated errors are the true ones over ``honesty``; the reference has noise of its own."""
    from lumenray.benchmarks.atlas.calibration import covered_share
    from lumenray.engine.accuracy.student import t_quantile

    rng = np.random.default_rng(5)
    count, replicates = 20_000, 8
    truth = rng.uniform(50.0, 150.0, count)
    reference = made_up_reference(truth + 0.4 * rng.standard_normal(count), np.full(count, 0.4))
    samples = truth[:, None] + 2.0 * np.sqrt(replicates) * rng.standard_normal((count, replicates))
    values = samples.mean(axis=1)
    errors = samples.std(axis=1, ddof=1) / np.sqrt(replicates) / honesty
    ratio = reference.error_of(values) / reference.stated(errors)
    assert ratio == pytest.approx(honesty, rel=0.03)
    held = covered_share(values - reference.values, errors, reference.errors, replicates - 1)
    if honesty == 1.0:
        assert held == pytest.approx(0.95, abs=0.01)
        assert t_quantile(0.975, replicates - 1) > 1.96
    else:
        assert (held > 0.97) == (honesty < 1.0)
        assert (held < 0.93) == (honesty > 1.0)


def test_forecasts_are_taken_after_a_twentieth_of_the_time_and_after_two_passes():
    from lumenray.benchmarks.atlas.calibration import judge_forecast

    marks = (
        Mark(0.4, 0.0, 0.1, 8.0),
        Mark(0.9, 3.0, 0.07, 11.0),
        Mark(2.0, 6.0, 0.05, 9.7),
        Mark(10.0, 30.0, 0.02, 10.0),
    )
    row = judge_forecast(replace(empty_result(), history=History(marks)), 0.02)
    assert row["rough"] == pytest.approx({"at": 0.09, "forecast": 11.0, "share": 1.1})
    assert row["settled"] == pytest.approx({"at": 0.2, "forecast": 9.7, "share": 0.97})


def empty_result() -> BakeResult:
    """Return a result of nothing."""
    return BakeResult((), (), (), (), History(), 0.0, 0.0, 0.0, 1.0, Seams(0, 0.0, 0.0, 0.0))


def race_of(factor: float) -> dict:
    """Race in which another program takes ``factor`` times as long as ours."""

    def row(scale):
        points = [(scale * s, 0.05 / np.sqrt(s)) for s in (0.5, 2.0, 8.0, 32.0)]
        return {"points": points, "work": ["-"] * 4, "scaled": 1.0, "mean": 1.0}

    slow = {"ways": {"exact": row(3 * factor), "cached": row(factor)}}
    return {
        "key": "cornell",
        "title": "Box",
        "lumels": 100,
        "judged": 50,
        "reference_error": 0.002,
        "first_seconds": 9.0,
        "programs": {
            "Lumenray": row(1.0),
            "plain_gather": row(factor),
            "cycles": {"refusal": "no Blender"},
            "radiance": slow,
        },
        "switches": {name: row(factor) for name in ("qmc", "direct_apart", "adaptive")},
    }


def made_up_result() -> dict:
    """Whole result with every part."""
    from lumenray.benchmarks.atlas.summary import summarise

    run = {"level": 0.02, "seed": 1, "seconds": 1.0, "stated": 0.02, "stated_here": 0.02}
    run |= {"true": 0.021, "ratio": 1.05, "covered": 0.948, "mean": 1.0, "replicates": 8}
    own = {"at": 0.06, "forecast": 9.8, "share": 0.98}
    forecast = {"target": 0.01, "seconds": 10.0, "rough": own, "settled": own}
    scene = {"key": "cornell", "title": "Box", "lumels": 100, "judged": 50, "cut": 0}
    scene |= {
        "reference_error": 0.002,
        "runs": [run, run | {"level": 0.01}],
        "forecasts": [forecast],
    }
    size = {"triangles": 1_000_000, "charts": 10_000, "pages": 6, "density": 20.0, "setup": 1.0}
    size |= {"tracing": 8.0, "finishing": 1.0, "memory": 3.0, "memory_before": 1.0, "not_finite": 0}
    runs = [size | {"lumels": n, "seconds": n / 1e6} for n in (10_000_000, 40_000_000)]
    leak = {"case": "box", "lit": 100.0, "dark": 1e-5, "largest": 1e-4, "lumels": 9}
    seam = {"error": 0.02, "places": 9, "step": 1.0, "noise": 2.0, "mean": 900.0, "charts": 5}
    hard = {"case": "T-vertices", "triangles": 9, "lumels": 9, "charts": 1, "not_finite": 0}
    races = [race_of(4.0), race_of(9.0)]
    machine = dict.fromkeys(
        ("cpu", "cores", "memory_gib", "system", "python", "mitsuba", "lumenray"), "-"
    )
    return {
        **summarise([scene], races),
        "machine": machine,
        "is_quick": True,
        "scenes": [scene],
        "races": races,
        "geometry": {
            "leaks": [leak],
            "seams": [seam | {"before": 3.0, "after": 1.0, "told_noise": 2.0}],
            "hard": [
                hard | {"area": 1.0, "low": 0.99, "high": 1.01, "reported": ["a; b"]},
                {"case": "slivers", "triangles": 3, "failure": "no lumel"},
            ],
        },
        "scale": {"samples": 4, "runs": runs},
        "seconds": 9.0,
        "unsteadiness": 0.04,
        "other_load": 0.5,
    }


def test_the_summary_is_of_all_runs():
    result = made_up_result()
    assert result["calibration"] == pytest.approx(1.05)
    assert result["coverage_95"] == pytest.approx(0.948)
    assert result["forecast_median_error"] == pytest.approx(0.02)
    # The better way of a program counts; the geometric mean of 4 and 9 is 6.
    assert result["speedup"]["plain_gather"] == pytest.approx(6.0)
    assert result["speedup"]["radiance"] == pytest.approx(6.0)
    assert result["speedup"]["qmc"] == pytest.approx(6.0)
    assert result["speedup"]["cycles"] is None


def test_the_bars_tell_what_is_met_and_what_is_not():
    from lumenray.benchmarks.atlas.bars import check_bars, compare_results

    result = made_up_result()
    bars = {bar.demand: bar.passed for bar in check_bars(result)}
    assert bars["true over stated error, mean"] is True
    assert bars["time of Plain gathering over ours"] is False
    assert bars["time of Cycles over ours"] is None
    assert bars["dark side over lit side"] is True
    assert bars["hard geometry without a number that is none"] is False
    assert bars["exponent of time in lumels"] is True
    # One scene that states too little is told, whatever the mean of all is.
    (scene,) = result["scenes"]
    poor = {**scene, "key": "poor", "runs": [{**run, "ratio": 1.2} for run in scene["runs"]]}
    (bar,) = (
        bar
        for bar in check_bars({**result, "scenes": [scene] * 9 + [poor]})
        if bar.demand == "true over stated error, every scene"
    )
    assert bar.passed is False
    assert bar.measured.startswith("1.20 at worst (poor")
    assert bars[bar.demand] is True
    other = {**result, "calibration": 1.2}
    assert [bar.passed for bar in compare_results(other, result)].count(False) == 1


def test_the_document_and_its_pictures_are_written(tmp_path):
    from lumenray.benchmarks.atlas import run as atlas

    result = made_up_result()
    atlas.write_results(result, tmp_path, tmp_path / "all.json")
    text = (tmp_path / "atlas.md").read_text(encoding="utf-8")
    for name in ("atlas_races.png", "atlas_calibration.png", "atlas_scale.png"):
        assert f"({name})" in text
        assert (tmp_path / name).stat().st_size > 1000
    assert "This was a quick run" in text
    assert "fails: no lumel" in text
    read = atlas.read_results(tmp_path / "all.json")
    assert read["speedup"] == json.loads(json.dumps(result["speedup"]))
