"""Roads on the command line."""

import json
from functools import partial
from pathlib import Path

import pytest
from commands import run_command

from lumenray.libraries.luminaires import __file__ as luminaires

run = partial(run_command, "road")
STREET = Path(luminaires).parent / "photometry" / "street_type_2.ldt"
ROAD = ("--width", 7, "--lanes", 2, "--spacing", 30, "--height", 8)


def test_a_road_class_is_judged_by_luminances_and_glare(capsys):
    code, text, _ = run(capsys, STREET, *ROAD, "--require", "road.m4", "--json")
    row = json.loads(text)
    assert code == 0
    states = {each["name"]: each["state"] for each in row["requirement"]["limits"]}
    assert set(states) == {
        "mean",
        "uniformity Uo",
        "longitudinal uniformity Ul",
        "threshold increment",
    }
    assert row["requirement"]["state"] == "not met"
    assert states["threshold increment"] == "not met"
    assert row["threshold_increment_percent"] > 15.0
    assert states["mean"] == "met"
    points = len(row["along_m"]) * len(row["across_m"])
    assert points == 60 == sum(map(len, row["drivers"][1]["luminances"]))
    # Lower luminances after a while, the same glare.
    code, text, _ = run(capsys, STREET, *ROAD, "--maintenance", "0.5", "--json")
    later = json.loads(text)
    assert later["mean_luminance"] == pytest.approx(0.5 * row["mean_luminance"])
    assert later["threshold_increment_percent"] == row["threshold_increment_percent"]


def test_a_road_is_told_and_drawn(tmp_path, capsys):
    plan = tmp_path / "road.svg"
    code, text, _ = run(capsys, STREET, *ROAD, "--require", "road.p3", "--plan", plan)
    assert code == 0
    assert "road.p3, task" in text and "met: " in text
    assert "only light straight from the luminaires" in text
    assert "cd/m" in plan.read_text(encoding="utf-8")
    code, _, complaint = run(capsys, STREET, *ROAD, "--plan", plan)
    assert code == 1 and "is there already" in complaint


def test_users_may_ask_for_an_edge_ratio(tmp_path, capsys):
    own = tmp_path / "own.toml"
    own.write_text('standard = "ours"\n[road.ours]\ntitle = "Our road"\nroad = { edge = 0.9 }\n')
    given = ("--require", "road.ours", "--requirements", own)
    code, text, _ = run(capsys, STREET, *ROAD, *given)
    assert code == 0 and "edge illuminance ratio EIR: not met" in text
    code, _, complaint = run(capsys, STREET, *ROAD, "--require", "office.writting")
    assert code == 1 and "no requirement" in complaint


def test_numbers_of_a_surface_that_were_corrected_are_told(capsys):
    _, text, _ = run(capsys, STREET, *ROAD, "--json")
    assert any("surface C2: three numbers" in each for each in json.loads(text)["warnings"])
    _, text, _ = run(capsys, STREET, *ROAD, "--surface", "R3")
    assert "three numbers" not in text
