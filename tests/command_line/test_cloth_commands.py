"""The commands for cloths, on few rays."""

import json

import pytest

pytest.importorskip("mitsuba")

from lumenray.command_line.main import main
from lumenray.engine.scattering.readers.reader import read_scattering

pytestmark = [pytest.mark.mitsuba, pytest.mark.slow]


def test_compute_writes_a_measured_material(tmp_path, capsys):
    path = tmp_path / "voile.lumbsdf"
    assert main(["cloth", "compute", "voile", "--rays", "300", "-o", str(path), "--json"]) == 0
    row = json.loads(capsys.readouterr().out)
    # (1 - 0.11 / 0.26) (1 - 0.11 / 0.28), by 600 rays.
    assert row["openness"] == pytest.approx(0.350, abs=0.08)
    assert row["transmittance"] + row["reflectance"] < 1.0
    assert set(read_scattering(path).sides) == {
        "front_reflection", "back_reflection", "front_transmission", "back_transmission",
    }  # fmt: skip


def test_a_missing_file_is_said(tmp_path, capsys):
    assert main(["cloth", "compute", str(tmp_path / "none.json")]) != 0
    assert "none.json" in capsys.readouterr().err
