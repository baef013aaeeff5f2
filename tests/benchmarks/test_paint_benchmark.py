"""How the benchmark of paints judges: reference values, and the demands."""

import copy

import pytest

from lumenray.benchmarks.paint import run as paint
from lumenray.benchmarks.paint.reference import entries


def verdicts(changed=None):
    """Verdicts on values that are those of the list, but for some."""
    found = {name: entry["value"] for name, entry in entries().items()} | (changed or {})
    return {row["id"]: row["verdict"] for row in paint.judge(found)}


def test_values_of_the_list_agree_and_each_that_is_off_or_missing_is_told():
    # A bound, and values of a program that is known to lose light, judge otherwise.
    assert {verdict for name, verdict in verdicts().items()} == {"pass"}
    entry = entries()["A1.UR1.a0.5"]
    inside, outside = (entry["value"] + k * entry["tolerance"] for k in (0.9, 1.1))
    assert verdicts({"A1.UR1.a0.5": inside})["A1.UR1.a0.5"] == "pass"
    assert verdicts({"A1.UR1.a0.5": outside})["A1.UR1.a0.5"] == "FAIL"
    found = {name: entry["value"] for name, entry in entries().items() if name != "A1.UR1.a0.5"}
    missing = [row["id"] for row in paint.judge(found) if row["verdict"] == "missing"]
    assert missing == ["A1.UR1.a0.5"]


def test_four_standard_errors_of_a_walk_are_allowed():
    value, error = entries()["A1.UR1.a0.5"]["value"], 1e-3
    assert verdicts({"A1.UR1.a0.5": (value + 3.9 * error, error)})["A1.UR1.a0.5"] == "pass"
    assert verdicts({"A1.UR1.a0.5": (value + 4.1 * error, error)})["A1.UR1.a0.5"] == "FAIL"


def test_reciprocity_is_a_bound():
    assert verdicts({"A9.reciprocity": 0.9e-10})["A9.reciprocity"] == "pass"
    assert verdicts({"A9.reciprocity": 1.1e-10})["A9.reciprocity"] == "FAIL"


def test_values_of_the_program_that_loses_light_are_told_and_not_judged():
    name = next(name for name in entries() if name.startswith(paint.CROSS_CHECKS))
    assert verdicts({name: [5.0]})[name] == "apart"


@pytest.fixture
def good():
    """Results that meet every demand, just."""
    walks = [{"sigmas": 4.0}, {"sigmas": 0.1}]
    table = {"clamped": 1e-4, "reciprocity": 0.02, "energy": 1.0, "furnace": 1e-3}
    return {
        "reference_failed": [],
        "spectral_seconds": 0.5,
        "rgb_seconds": 0.1,
        "speedup_monte_carlo": 100.0,
        "fit_recovered": 9,
        "parts": {
            "walks": {"continuum": walks, "discs": copy.deepcopy(walks)},
            "tables": [table, dict.fromkeys(table, 0.0)],
            "speed": {"sphere": {"processor_seconds": 0.2}},
            "fit": [{"processor_seconds": 120.0}],
        },
    }


def test_demands_that_are_just_met_pass(good):
    assert all(bar.passed for bar in paint.check_bars(good))


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (("reference_failed",), ["A1"], "reference values"),
        (("spectral_seconds",), 0.51, "33 bands"),
        (("rgb_seconds",), 0.11, "RGB"),
        (("speedup_monte_carlo",), 99.0, "walks"),
        (("fit_recovered",), 8, "fits within"),
        (("parts", "walks", "discs", 1, "sigmas"), 4.1, "discs"),
        (("parts", "tables", 1, "reciprocity"), 0.021, "T3"),
        (("parts", "tables", 1, "energy"), 1.01, "T1"),
        (("parts", "speed", "sphere", "processor_seconds"), 0.21, "sphere"),
        (("parts", "fit", 0, "processor_seconds"), 121.0, "slowest"),
    ],
)
def test_each_demand_can_be_missed(good, place, value, words):
    at = good
    for key in place[:-1]:
        at = at[key]
    at[place[-1]] = value
    missed = [bar.demand for bar in paint.check_bars(good) if not bar.passed]
    assert len(missed) == 1 and words in missed[0]


def test_what_was_not_measured_is_neither_met_nor_missed():
    result = dict.fromkeys(
        (
            "reference_failed",
            "spectral_seconds",
            "rgb_seconds",
            "speedup_monte_carlo",
            "fit_recovered",
        )
    )
    assert {bar.passed for bar in paint.check_bars(result | {"parts": {}})} == {None}
