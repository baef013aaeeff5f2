"""The benchmark of accuracy on little: what it measures and how it tells it, not how good that is."""

import json

import numpy as np
import pytest

pytestmark = pytest.mark.mitsuba

SCENE = "C14.2x1.sky12"

WORK = [16, 64, 256, 1024, 4096]


@pytest.fixture(scope="module")
def result():
    """Return the results of a quick run on one scene without other programs."""
    from lumenray.benchmarks.accuracy import run as accuracy

    return accuracy.run(is_quick=True, with_peers=False, scenes=[SCENE], longest=0.1)


def made_up(constant: float, slope: float = -0.5, speed: float = 1e-5, seed: int = 0) -> dict:
    """Row of a program whose error follows a power of its work, with a little noise."""
    rng = np.random.default_rng(seed)
    work = np.array(WORK)
    noise = np.exp(0.1 * rng.standard_normal((5, len(work))))
    slow = np.exp(0.03 * rng.standard_normal((5, len(work))))
    return {
        "unit": "samples per sensor",
        "is_ours": True,
        "work": WORK,
        "first_seconds": 1.0,
        "seconds": (speed * work * slow).tolist(),
        "errors": (constant * work**slope * noise).tolist(),
    }


def made_up_result(factor: float, seed: int) -> dict:
    """Result with two programs of which the second takes ``factor`` times as long."""
    programs = {
        "Lumenray mono": made_up(0.2, seed=seed),
        "Cycles": made_up(0.2, speed=1e-5 * factor, seed=seed + 1),
    }
    return {"scenes": [{"key": SCENE, "programs": programs}]}


def test_scenes_and_exact_values_are_those_of_the_validation_cases():
    from lumenray.benchmarks.accuracy.scenes import TITLES, load_scene
    from lumenray.validation.reference import load_groups

    for key, (_, ids) in TITLES.items():
        scene = load_scene(key)
        groups = [load_groups()[name] for name in ids]
        expected = np.concatenate([group.values for group in groups])
        # All of these cases have readings in the unit of their values.
        assert scene.exact == pytest.approx(expected[expected > 0.0])
        assert len(scene.positions) == len(scene.normals) == len(scene.exact)


@pytest.mark.slow
def test_the_error_falls_with_time(result):
    from lumenray.benchmarks.accuracy.programs import OURS
    from lumenray.benchmarks.accuracy.statistics import slope_of

    (scene,) = result["scenes"]
    for name in OURS:
        assert slope_of(scene["programs"][name]).value < -0.3


@pytest.mark.slow
def test_the_stated_error_is_the_true_one(result):
    (scene,) = result["scenes"]
    for row in scene["honesty"]:
        assert 1.0 / 1.5 < row["share"] < 1.5


@pytest.mark.slow
def test_the_forecast_is_compared_with_what_it_took(result):
    (scene,) = result["scenes"]
    for row in scene["forecasts"]:
        assert row["seconds"] > 0.0
        assert row["forecast"] is None or row["left"] > 0.0


def test_forecasts_are_judged_by_the_typical_one():
    from lumenray.benchmarks.accuracy.bars import _check_typical_forecast

    def judge(*forecasts, left=8.0):
        # Two seconds of ten have passed; the rest is foretold.
        rows = [{"seconds": 10.0, "left": left, "forecast": each} for each in forecasts]
        return _check_typical_forecast({"scenes": [{"forecasts": rows}]})

    assert judge(8.0, 7.0, 80.0).passed is True
    assert judge(8.0, 7.0, 80.0).measured == "10 %"
    assert judge(4.0, 12.0, 8.0).passed is False
    assert judge().passed is None
    # No forecast, or one when most of the time has passed, helps nobody.
    assert judge(8.0, None, None).passed is False
    assert judge(2.0, 2.0, left=2.0).passed is False


@pytest.mark.slow
def test_pixels_state_their_error(result):
    from lumenray.benchmarks.accuracy.statistics import honesty_of

    assert honesty_of(result["views"]["picture"]).value == pytest.approx(1.0, abs=0.1)
    # Sensors add what few large samples may hide, so they state a little too much after so short a run.
    assert 0.8 < honesty_of(result["views"]["sensors"]).value < 1.1


@pytest.mark.slow
def test_the_document_and_its_pictures_are_written(result, tmp_path):
    from lumenray.benchmarks.accuracy import run as accuracy

    accuracy.write_results(result, tmp_path, tmp_path / "all.json")
    text = (tmp_path / "accuracy.md").read_text(encoding="utf-8")
    assert f"`{SCENE}`" in text
    assert "This was a quick run" in text
    for name in ("accuracy.png", "accuracy_views.png"):
        assert (tmp_path / name).stat().st_size > 1000
        assert f"({name})" in text
    assert accuracy.read_results(tmp_path / "all.json") == json.loads(json.dumps(result))


def test_a_power_law_is_read_off_its_runs():
    from lumenray.benchmarks.accuracy.statistics import make_curve, seconds_to, slope_of

    row = made_up(0.2)
    slope = slope_of(row)
    assert slope.value == pytest.approx(-0.5, abs=slope.spread)
    # An error of 0.01 takes (0.2 / 0.01)^2 samples of 10 us.
    assert seconds_to(make_curve(row), 0.01).value == pytest.approx(4e-3, rel=0.2)


@pytest.mark.parametrize(("target", "bound"), [(0.5, "<"), (0.01, ""), (1e-4, ">")])
def test_an_error_beyond_the_runs_gives_a_bound(target, bound):
    from lumenray.benchmarks.accuracy.statistics import make_curve, seconds_to

    assert seconds_to(make_curve(made_up(0.2)), target).bound == bound


def test_start_up_of_others_is_no_time():
    from lumenray.benchmarks.accuracy.statistics import make_curve, start_up

    row = made_up(0.2) | {"is_ours": False}
    row["seconds"] = (np.array(row["seconds"]) + 2.0).tolist()
    curve = make_curve(row)
    assert start_up(row) == pytest.approx(2.0, abs=0.01)
    assert curve.work.tolist() == WORK[1:]
    assert curve.seconds[-1] == pytest.approx(1e-5 * (WORK[-1] - WORK[0]), rel=0.1)


def test_two_runs_of_the_same_agree_within_their_spreads():
    from lumenray.benchmarks.accuracy.statistics import compare_results

    rows = compare_results(made_up_result(3.0, seed=1), made_up_result(3.0, seed=11))
    assert len(rows) >= 1
    assert all(row.passes for row in rows)


def test_a_ratio_that_became_four_times_as_large_is_told():
    from lumenray.benchmarks.accuracy.statistics import compare_results

    rows = compare_results(made_up_result(3.0, seed=1), made_up_result(12.0, seed=11))
    assert any(not row.passes for row in rows)
