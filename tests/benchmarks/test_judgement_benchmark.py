"""The benchmark of judgement on little: what it tells, not how good it is."""

import json

import pytest

from lumenray.benchmarks.judgement import run as judgement
from lumenray.benchmarks.judgement import verdicts


@pytest.fixture
def result():
    """Return numbers such as a run gives, where some could not be measured."""
    return {
        "machine": {"cpu": "a processor", "cores": 2},
        "ugr_cie190_max": 0.7,
        "ugr_cie190_mean": 0.01,
        "evalglare_max_percent": None,
        "melanopic_max_percent": 0.2,
        "isolux_lumels": None,
        "wrong_verdicts": 0.02,
        "slider_ms": None,
        "tables": None,
        "pictures": None,
        "indices": None,
        "eye": {
            "toolbox_percent": 0.001,
            "rooms": [
                {"lamp": "A", "paint": "red", "sensor": 50.0, "error": 0.1, "quadrature": 50.1}
            ],
        },
        "verdicts": {
            "worst_wrong": 0.02,
            "wrong": 3,
            "open": 1,
            "runs": 300,
            "kinds": 2,
            "looks": 8,
            "time_ratio": 1.3,
        },
    }


def test_demands_that_were_not_measured_do_not_count_as_met(result):
    bars = {bar.demand: bar.passed for bar in judgement.check_bars(result)}
    assert bars["table of CIE 190, of 190 values the worst"] is False
    assert bars["table of CIE 190, on the mean"] is True
    assert bars["five pictures beside evalglare"] is None
    assert bars["wrong verdicts"] is True
    assert bars["time that an open verdict foretells"] is False


def test_numbers_and_document_are_written(result, tmp_path):
    judgement.write_results(result, tmp_path, tmp_path / "out.json")
    assert json.loads((tmp_path / "out.json").read_text())["wrong_verdicts"] == 0.02
    text = (tmp_path / "judgement.md").read_text(encoding="utf-8")
    assert "| A | red | 50.00" in text
    assert "not measured" in text


def test_noisy_areas_are_judged_until_decided(monkeypatch):
    monkeypatch.setattr(verdicts, "RUNS", 5)
    monkeypatch.setattr(verdicts, "FORECASTS", 200)
    made = verdicts.measure(lambda line: None)
    json.dumps(made)
    assert made["runs"] == 5 * made["kinds"]
    assert 0.0 <= made["worst_wrong"] <= 1.0
