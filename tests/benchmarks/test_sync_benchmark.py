"""The benchmark of edits on a tiny scene: what it tells, not how fast it is."""

import json

import pytest

from lumenray.benchmarks.common.bars import tell_bars
from lumenray.benchmarks.sync import edits
from lumenray.benchmarks.sync import run as sync
from lumenray.benchmarks.sync.bars import COLUMNS, check_bars
from lumenray.benchmarks.sync.figures import PARTS
from lumenray.command_line import main as command_line

pytestmark = [
    pytest.mark.mitsuba,
    pytest.mark.slow,
    pytest.mark.usefixtures("empty_file"),
]

SCENES = {"tiny": 480}


@pytest.fixture(scope="module")
def result(registered):
    """Results of two rounds over a scene of 24 objects."""
    return sync.run(SCENES, [24], rounds=2, triangles=SCENES)


def test_every_edit_is_there_each_time(result):
    found = [(row["edit"], row["nth"]) for row in result["edits"]]
    assert sorted(found) == sorted((name, nth) for name in edits.NAMES for nth in (1, 2))
    assert len(result["full"]) == len(edits.GROUPS)
    assert [(row["scene"], row["objects"]) for row in result["scenes"]] == [("tiny", 24)]


def test_rows_tell_scene_times_and_parts(result):
    for row in result["edits"] + result["full"]:
        assert (row["scene"], row["objects"]) == ("tiny", 24)
        assert set(row["parts"]) == set(PARTS)
        assert row["seconds"] > 0.0
        assert sum(row["parts"].values()) == pytest.approx(row["seconds"], rel=0.05, abs=2e-3)
    whole = sync.median(row["seconds"] for row in result["full"])
    for row in result["edits"]:
        assert row["ratio"] == pytest.approx(row["seconds"] / whole)


def test_selecting_and_renaming_send_nothing_and_all_else_something(result):
    silent = {row["edit"] for row in result["edits"] if not row["sent"]}
    assert silent == {"camera", "rename", "select"}


def test_an_edit_of_one_thing_sends_few_items(result):
    assert max(row["sent"] for row in result["edits"]) <= 2


def test_the_document_and_the_bars_hold_what_was_measured(result, tmp_path):
    sync.write_results(result, tmp_path / "docs", tmp_path / "sync.json")
    text = (tmp_path / "docs" / "sync.md").read_text(encoding="utf-8")
    assert "### tiny triangles, 24 objects" in text
    assert all(f"\n| {name} |" in text for name in edits.NAMES)
    assert (tmp_path / "docs" / "sync.png").stat().st_size
    assert json.loads((tmp_path / "sync.json").read_text(encoding="utf-8")) == result
    bars = check_bars(result)
    assert {bar.passed for bar in bars if bar.demand == "nothing is sent"} == {True}
    assert {bar.passed for bar in bars if "3M" in bar.edit} == {None}
    assert "nothing is sent" in tell_bars(bars, COLUMNS)


def test_an_unknown_scene_is_named(capsys):
    assert command_line.main(["benchmark", "sync", "--scenes", "5k"]) == 1
    assert "there is no scene 5k" in capsys.readouterr().err
