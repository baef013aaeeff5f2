"""The commands for pigment layers: what they say before and after, and what they write."""

import json

import pytest

from lumenray.command_line.main import main
from lumenray.engine.ink.reader import read_ink
from lumenray.libraries import inks

SMALL = {
    "lumenray_ink": 1,
    "name": "Small",
    "thickness_um": 0.5,
    "binder": {"index": 1.558},
    "pigments": [{"name": "red", "index": 1.4, "volume_fraction": 0.2, "median_um": 0.3}],
    "substrate": {"reflectance": 0.9},
    "solution": {"cell_um": 0.8, "band_step_nm": 80, "incidences": 2, "realisations": 2},
}


def test_presets_can_be_read():
    for path in inks.presets().values():
        assert read_ink(path).name


def test_compute_says_the_errors_and_what_it_will_take(tmp_path, capsys):
    file = tmp_path / "small.json"
    file.write_text(json.dumps(SMALL))
    command = ["ink", "compute", str(file), "--draft", "--jobs", "1", "--json"]
    command += ["--cache", str(tmp_path / "kept"), "-o", str(tmp_path / "small.lumbsdf")]
    assert main(command) == 0
    said = capsys.readouterr()
    made = json.loads(said.out)
    assert "solves of" in said.err
    assert "MB at most" in said.err
    assert made["units_solved"] > 0
    assert 0.5 < made["reflectance_45_0"][2] < 1.0
    assert made["realisations_for_wanted"] >= 2
    assert (tmp_path / "small.lumbsdf").stat().st_size > 1000
    assert main([*command, "--force"]) == 0
    assert json.loads(capsys.readouterr().out)["units_solved"] == 0


def test_a_damaged_description_is_refused(tmp_path, capsys):
    file = tmp_path / "bad.json"
    file.write_text(json.dumps(SMALL | {"thickness_um": "thin"}))
    with pytest.raises(SystemExit):
        raise SystemExit(main(["ink", "compute", str(file)]))
    assert "thickness_um" in capsys.readouterr().err
