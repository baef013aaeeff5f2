"""The benchmark of luminaires on little: what it tells, not how good it is."""

import json

import numpy as np
import pytest

from lumenray.benchmarks.common import radiance

pytestmark = [
    pytest.mark.mitsuba,
    pytest.mark.skipif(
        not radiance.is_installed(), reason="pyradiance is not installed (run 'make setup')"
    ),
]

PLAIN = """IESNA:LM-63-2002
[TEST] made for this test
TILT=NONE
1 -1 1 4 2 1 2 0.4 0.2 0
1 1 0
0 30 60 90
0 90
900 700 300 0
900 500 100 0
"""

HALF_TURN = """IESNA91
TILT=NONE
1 -1 1 4 3 1 2 0 0 0
1 1 0
0 30 60 90
90 180 270
900 700 300 0
900 500 100 0
900 300 50 0
"""
"""Planes from 90 to 270 degrees, which Radiance turns by half a turn."""


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """Return the results of a run on two good files and a broken one."""
    from lumenray.benchmarks.luminaires import run as luminaires
    from lumenray.benchmarks.luminaires import speed as luminaire_speed
    from lumenray.benchmarks.luminaires import variance as luminaire_variance

    folder = tmp_path_factory.mktemp("files")
    (folder / "plain.ies").write_text(PLAIN, encoding="ascii")
    (folder / "half.ies").write_text(HALF_TURN, encoding="ascii")
    (folder / "broken.ies").write_text("IESNA91\nTILT=NONE\n1 -1\n", encoding="ascii")
    with pytest.MonkeyPatch.context() as patch:
        cases = luminaire_variance.cases()
        patch.setattr(luminaire_variance, "cases", lambda: [cases[0], cases[2]])
        patch.setattr(luminaire_variance, "LANES", 1 << 14)
        patch.setattr(luminaire_speed, "MANY", 1 << 14)
        patch.setattr(luminaire_speed, "ROUNDS", 2)
        return luminaires.run(folder)


@pytest.mark.slow
def test_a_file_that_radiance_turns_is_told_apart_from_one_that_agrees(result):
    rows = {row["file"]: row for row in result["agreement"]["files"]}
    assert rows["plain.ies"]["max"] < 0.005
    assert rows["plain.ies"]["reason"] == ""
    assert rows["half.ies"]["max"] > 0.1
    assert rows["half.ies"]["reason"] == "90 to 270"
    assert rows["half.ies"]["without_reason"] < 0.005


@pytest.mark.slow
def test_a_broken_file_is_named_and_the_others_are_compared(result):
    (refused,) = result["agreement"]["refused"]
    assert refused["file"] == "broken.ies"
    assert "line 3" in refused["message"]


@pytest.mark.slow
def test_an_opening_is_compared_with_its_sum_over_small_parts(result):
    (row,) = result["agreement"]["openings"]
    assert row["file"] == "plain.ies"
    assert row["ours"]["max"] < 0.005
    assert row["point"] > 0.02, "too far away to tell an opening from a point"


@pytest.mark.slow
def test_all_ways_of_looking_up_are_timed_and_right(result):
    for row in result["speed"]:
        rates = {way: rate for way, rate in row["rates"].items() if way != "one lane"}
        assert all(rate > 0.0 for rate in rates.values()), rates
        assert row["deviation"] < 1e-5


@pytest.mark.slow
def test_a_point_adds_no_noise(result):
    ratio = {row["opening"]: row["ratio"] for row in result["noise"]}
    assert ratio["point"] == pytest.approx(1.0, abs=1e-4)
    assert ratio["disk 0.1 m"] > 1.0


@pytest.mark.slow
def test_the_document_says_what_falls_short(result, tmp_path):
    from lumenray.benchmarks.luminaires import run as luminaires

    told = json.loads(json.dumps(result))
    told["noise"][1]["ratio"] = 2.5
    luminaires.write_results(told, tmp_path, tmp_path / "all.json")
    text = (tmp_path / "luminaires.md").read_text(encoding="utf-8")
    assert "| files compared with Radiance | 20 | 2 | FAIL |" in text
    assert "2.500" in text.split("Not met: ")[1].split("\n")[0]
    assert "Radiance turns files" in text
    assert json.loads((tmp_path / "all.json").read_text(encoding="utf-8")) == told
    assert (tmp_path / "luminaires_agreement.png").exists()
    assert (tmp_path / "luminaires_speed.png").exists()


def test_noise_of_a_choice_is_measured_by_what_is_known():
    # Two receivers' estimates 0 or 2 with equal chance around a mean of 1 or 3: variance 1 over the ideal's 1.
    from lumenray.benchmarks.luminaires.variance import _ratio

    rng = np.random.default_rng(0)
    exact = rng.choice([1.0, 3.0], 400_000)
    first, second = (exact + rng.choice([-1.0, 1.0], exact.size) for _ in range(2))
    sums = np.array(
        [first.sum() + second.sum(), (first**2 + second**2).sum(), (first * second).sum()]
    )
    ratio, ideal = _ratio(sums, exact.size)
    assert ratio == pytest.approx(2.0, rel=0.02)
    assert ideal == pytest.approx(1.0 / 4.0, rel=0.02)
