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


def test_threads_are_drawn_and_made_as_bodies(tmp_path, capsys):
    from PIL import Image

    picture, body = tmp_path / "threads.png", tmp_path / "threads.obj"
    few = ["--size", "16", "--samples", "3", "--repeats", "2"]
    assert main(["cloth", "close-up", "voile", *few, "-o", str(picture)]) == 0
    with Image.open(picture) as image:
        # Whole pixels for each end and pick: 8 of 0.26 mm, and 9 of 0.28 mm, the nearest to as many for a length.
        assert image.size == (2 * 2 * 8, 2 * 2 * 9)
    assert main(["cloth", "mesh", "voile", "-o", str(body)]) == 0
    # Two ends of 0.26 mm, two picks of 0.28 mm.
    assert "0.52 x 0.56 mm" in capsys.readouterr().out
    assert body.read_text().count("\no ") == 2


def test_a_sheet_that_cannot_be_is_refused(tmp_path, capsys):
    sheet = ["--openness", "10%", "--transmittance", "5%", "--reflectance", "40%"]
    path = tmp_path / "screen.json"
    assert main(["cloth", "fit", *sheet, "-o", str(path)]) != 0
    assert "expected the openness at least: 10 %" in capsys.readouterr().err
    assert not path.exists()
