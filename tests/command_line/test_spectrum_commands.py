"""The commands ``lumenray spectrum``: what they tell and draw."""

import json
from functools import partial

import numpy as np
import pytest
from commands import run_command
from PIL import Image
from spectra import NM, ROWS, changed_rows
from text_files import written

run = partial(run_command, "spectrum")


def test_info_tells_people_and_programs(capsys, tmp_path):
    lamp = written(tmp_path, [f"{row} 1" for row in ROWS])
    code, out, _ = run(capsys, "info", lamp)
    assert code == 0
    assert "3000 K" in out
    assert "has 2 columns" in out
    assert "1 of 2" in out
    code, out, _ = run(capsys, "info", "--column", "2", lamp)
    assert "has 2 columns" not in out
    broken = written(tmp_path, changed_rows(64, "7000 1"), "typo.txt")
    code, out, _ = run(capsys, "info", "--json", lamp, broken, "/dev/null")
    assert code == 1
    good, bad, empty = json.loads(out)
    assert good["colour_temperature_k"] == pytest.approx(3000.0, rel=1e-3)
    assert good["wavelength_nm"] == [380.0, 780.0]
    assert good["columns"] == 2
    assert "7000 nm" in bad["error"]
    assert "is a device" in empty["error"]


@pytest.mark.parametrize("more", [(), ("--dark", "--size", "320x240"), ("--column", "2")])
def test_plot_draws_the_curve_in_its_colours(capsys, tmp_path, more):
    lamp = written(tmp_path, [f"{row} 1" for row in ROWS])
    target = tmp_path / "out" / "lamp.png"
    code, out, _ = run(capsys, "plot", lamp, "-o", target, *more)
    assert code == 0
    assert ("has 2 columns" in out) == ("--column" not in more)
    picture = np.asarray(Image.open(target).convert("RGB")).astype(int)
    assert picture.shape[:2] == ((240, 320) if "--size" in more else (480, 640))
    assert (picture.mean() < 128) == ("--dark" in more)
    low = picture[int(0.75 * picture.shape[0])]
    red, _, blue = low.T
    # Blue on the left, red on the right.
    third = len(low) // 3
    assert (blue - red)[:third].max() > 100
    assert (red - blue)[-third:].max() > 100


def test_plot_of_darkness_or_of_a_few_nanometres_is_a_picture_too(capsys, tmp_path):
    for rows in ([f"{nm} 0" for nm in NM], ["555 0", "555.1 1", "555.2 0"]):
        code, _, _ = run(
            capsys, "plot", "--force", written(tmp_path, rows), "-o", tmp_path / "x.png"
        )
        assert code == 0
    code, _, err = run(capsys, "plot", written(tmp_path, ROWS), "-o", tmp_path / "x.unknown")
    assert code == 1
    assert ".png" in err
