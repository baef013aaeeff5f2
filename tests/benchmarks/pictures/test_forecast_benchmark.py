"""The benchmark of forecasts: what it takes, how it judges, and that it runs on a real scene."""

import pytest


def test_a_forecast_is_taken_after_a_tenth_of_the_time():
    from lumenray.benchmarks.pictures.forecasts.jobs import judge_forecast

    states = [(0.5, 30.0), (1.2, 9.8), (6.0, 4.0)]
    assert judge_forecast(states, 10.0) == pytest.approx(
        {"seconds": 10.0, "at": 0.12, "share": 1.1}
    )
    assert judge_forecast(states[:1], 10.0)["share"] is None


def made_up_result() -> dict:
    from lumenray.benchmarks.pictures.forecasts.run import summarise

    def jobs(*shares):
        return [
            {"target": 0.01, "seconds": 9.0, "at": share and 0.1, "share": share}
            for share in shares
        ]

    scenes = [
        {
            "key": "hall",
            "title": "Hall",
            "picture": jobs(1.04, None, 0.97),
            "sensors": jobs(1.5, 0.7, 1.2),
        }
    ]
    names = ("cpu", "cores", "memory_gib", "system", "python", "mitsuba", "lumenray")
    return {
        "median_error": summarise(scenes),
        "machine": dict.fromkeys(names, "-"),
        "seconds": 9.0,
        "rounds": 3,
        "scenes": scenes,
    }


def test_forecasts_are_judged_by_their_medians():
    from lumenray.benchmarks.pictures.forecasts.run import check_bars

    result = made_up_result()
    # Of the errors 0.04, 1 and 0.03; of 0.5, 0.3 and 0.2; and of all.
    assert result["median_error"] == pytest.approx({"picture": 0.04, "sensors": 0.3, "all": 0.25})
    assert [bar.passed for bar in check_bars(result)] == [False, True, False]


def test_the_document_tells_every_forecast(tmp_path):
    from lumenray.benchmarks.pictures.forecasts.run import write_results

    write_results(made_up_result(), tmp_path, tmp_path / "forecasts.json")
    text = (tmp_path / "forecasts.md").read_text(encoding="utf-8")
    assert "| Hall | picture | 1 | 9 | 1.04 (at 10 %), none, 0.97 (at 10 %) | 4 % |" in text
    assert (
        "Not met: forecast after a tenth of the time, median error, pictures and sensors: 25 %"
        in text
    )
    assert (tmp_path / "forecasts.json").exists()


@pytest.mark.slow
@pytest.mark.mitsuba
def test_a_real_scene_is_measured():
    from lumenray.benchmarks.pictures.forecasts.run import measure

    told = []
    result = measure(("hall",), 2.0, 1, told.append)
    (scene,) = result["scenes"]
    for kind in ("picture", "sensors"):
        (row,) = scene[kind]
        assert row["seconds"] > 0.0
        assert 0.0 < row["target"] < 1.0
    assert len(told) == 2
