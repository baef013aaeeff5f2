"""Verdicts and spectra on the command line."""

import csv
import json
from functools import partial

import pytest
from commands import run_command

from lumenray.libraries.scenes import __file__ as scenes

run = partial(run_command, "requirements")


def test_requirements_are_listed_with_their_source(capsys):
    code, text, _ = run(capsys, "office")
    assert code == 0
    assert "office.writing: Offices: writing" in text
    assert "mean 500, mean, modified 1000, uniformity Uo 0.6" in text
    assert "source: glamox.com" in text
    code, text, _ = run(capsys, "--json", "road.p4")
    (row,) = json.loads(text)
    assert code == 0 and row["areas"] == {"task": {"mean": 5.0, "minimum": 1.0}}


def test_a_group_that_is_not_there_is_refused(capsys):
    code, _, complaint = run(capsys, "cellar")
    assert code == 1 and "groups are" in complaint


def test_a_requirement_is_looked_for_before_anything_is_computed(tmp_path, capsys):
    sensors = tmp_path / "in.csv"
    sensors.write_text("0,0,1,0,0,1\n")
    out = tmp_path / "out.csv"
    given = ("none.blend", "--sensors", sensors, "-o", out)
    code, _, complaint = run_command("measure", capsys, *given, "--require", "office.writting")
    assert code == 1 and "no requirement 'office.writting'" in complaint
    with pytest.raises(SystemExit):
        run_command("measure", capsys, *given, "--require", "office.writing:roof")


@pytest.mark.slow
@pytest.mark.blender
@pytest.mark.mitsuba
def test_measured_sensors_are_judged_and_have_spectra(tmp_path, capsys):
    from pathlib import Path

    office = Path(scenes).parent / "office.blend"
    sensors, out = tmp_path / "in.csv", tmp_path / "out.csv"
    sensors.write_text("1,1,0.75,0,0,1\n2,2,0.75,0,0,1\n")
    given = (office, "--sensors", sensors, "-o", out, "--samples", "1024", "--spectrum")
    code, text, _ = run_command("measure", capsys, *given, "--require", "office.writing")
    assert code == 0
    assert "office.writing, task (EN 12464-1:2021" in text
    lines = out.read_text().splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert any("office.writing" in line for line in lines if line.startswith("#"))
    for row in rows:
        ratio = float(row["melanopic_edi_lx"]) / float(row["illuminance_lx"])
        assert 0.6 < ratio < 0.85
        assert 4500.0 < float(row["cct_k"]) < 5500.0
        assert 75.0 < float(row["ra"]) <= 100.0
