"""The commands ``lumenray paint``: tables, pictures, compositions from readings."""

import json
from functools import partial

import numpy as np
import pytest
from commands import run_command
from paints import mirrors, one_layer
from PIL import Image

from lumenray.engine.paint.readings import SIX, read_lab
from lumenray.engine.paint.solution import solve
from lumenray.engine.scattering.readers.reader import read_scattering

run = partial(run_command, "paint")


@pytest.fixture(scope="module")
def grey(tmp_path_factory):
    """A file of a paint without colour and fringes."""
    file = tmp_path_factory.mktemp("paint") / "grey.json"
    file.write_text(json.dumps(one_layer([mirrors(0.7, 9.0, area=0.06)], 0.2).content))
    return file


def test_compute_writes_a_measured_material(capsys, tmp_path, grey):
    target = tmp_path / "grey.lumbsdf"
    code, out, _ = run(capsys, "compute", grey, "-o", target)
    assert code == 0
    assert "assumed: light reflected by more than one flake" in out
    assert "45 deg" in out
    table = read_scattering(target).sides["front_reflection"]
    assert table.is_isotropic and table.has_direct
    code, out, _ = run(capsys, "compute", grey, "--json", "--unpolarised")
    row = json.loads(out)
    assert row["total_reflectance_normal"] < row["largest_total_reflectance"] <= 1.0
    assert row["convergence"] < 0.01
    assert len(row["lab_d65_10deg"]) == len(row["aspecular_deg"])
    code, _, err = run(capsys, "compute", grey, "-o", target)
    assert code != 0 and "is there already" in err


def test_plot_draws_colours(capsys, tmp_path):
    target = tmp_path / "violet.png"
    assert run(capsys, "plot", "violet_pearl", "-o", target)[0] == 0
    picture = np.asarray(Image.open(target)).astype(int)
    height, width, _ = picture.shape
    gloss = picture[int(0.18 * height), int(0.45 * width)]
    assert gloss[0] > gloss[1] + 50 and gloss[2] > gloss[1] + 50


@pytest.mark.slow
def test_fit_finds_what_colours_came_of(capsys, tmp_path, grey):
    lab = read_lab(solve(one_layer([mirrors(0.7, 9.0, area=0.06)], 0.2)), SIX)
    file = tmp_path / "readings.csv"
    rows = [
        f"{angle};{' '.join(f'{value:.3f}' for value in row)}"
        for angle, row in zip(SIX, lab, strict=True)
    ]
    file.write_text("\n".join(["aspecular L a b", *rows]))
    target = tmp_path / "found.json"
    place = "layers/0/flakes/0/tilt_deg"
    code, out, _ = run(
        capsys, "fit", grey, "--lab", file, "--look-for", f"{place}:5:15", "-o", target, "--json"
    )
    assert code == 0
    found = json.loads(out)
    assert found["values"][place] == pytest.approx(9.0, abs=0.02)
    assert json.loads(target.read_text())["layers"][0]["flakes"][0]["tilt_deg"] == pytest.approx(
        9.0, abs=0.02
    )


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("15 1 2\n", "line 1: found '15 1 2', expected four numbers"),
        ("angle\n15 50 1 1\n25 x 1 1\n", "line 3"),
        ("200 50 1 1\n", "within -45 to 135"),
        ("angle\n", "has no colours"),
    ],
)
def test_faults_of_colours_are_told(capsys, tmp_path, grey, content, words):
    file = tmp_path / "readings.csv"
    file.write_text(content)
    code, _, err = run(capsys, "fit", grey, "--lab", file, "-o", tmp_path / "x.json")
    assert code != 0
    assert words in err


def test_bounds_are_checked(capsys, tmp_path, grey):
    with pytest.raises(SystemExit):
        run(
            capsys,
            "fit",
            grey,
            "--lab",
            "x",
            "--look-for",
            "layers/0:3:1",
            "-o",
            tmp_path / "x.json",
        )
    assert "bounds above 0" in capsys.readouterr().err
