"""Files of spectra: what cannot be a spectrum is refused, what is odd is said, and the commands that tell and draw them."""

import json
import re

import colour
import numpy as np
import pytest
from lumenray.command_line.main import main
from lumenray.engine.analysis.spectrum_figures import find_figures
from lumenray.engine.errors import FileFormatError
from lumenray.engine.formats.spd import read_spectrum
from lumenray.engine.photometry.colour_temperature import colour_temperature
from lumenray.engine.photometry.spectra import GRID, daylight, illuminant, observer, planck
from lumenray.engine.scene.spectrum import Tabulated
from PIL import Image

NM = np.arange(380, 781, 5)
POWER = planck(NM, 3000.0)
ROWS = [f"{nm} {value:.6g}" for nm, value in zip(NM, POWER, strict=True)]


def written(tmp_path, rows, name="lamp.txt"):
    path = tmp_path / name
    path.write_text("\n".join(rows) + "\n")
    return path


def changed(place, row):
    rows = list(ROWS)
    rows[place] = row
    return rows


@pytest.mark.parametrize(
    ("rows", "line", "words"),
    [
        (changed(7, "415 1e308"), 8, "at most 1e\\+30, found 1e\\+308"),
        (changed(7, "1e308 1"), 8, "1e\\+308 nm stands beside 410 and 420"),
        (changed(64, "7000 1"), 65, "7000 nm stands beside 695 and 705"),
        (changed(64, "70 1"), 65, "70 nm stands beside 695 and 705"),
        (changed(-1, "7800 1"), 81, "is a digit too many or few"),
        (changed(0, "38 1"), 1, "is a digit too many or few"),
        (changed(-1, "2e8 1"), 81, "from 10 to 100000 nm, found 2e\\+08"),
        (changed(9, "425 -0.5"), 10, "at least 0, found -0.5"),
        (changed(9, "425 inf"), 10, "finite"),
        (ROWS[:8], None, "ends at 415 nm with 100% of its largest value, and covers 0.0% of what the eye"),
        ([f"{n} 0.1 0.2 0.3" for n in range(1, 25)], None, "from 1 to 24: .* in the first row"),
        (["400 1 2", "500 1 2", "600 1"], 3, "nothing in column 2"),
        (["400,1,2", "500,,2"], 2, "nothing in column"),
    ],
)  # fmt: skip
def test_what_can_be_no_spectrum_is_refused_with_its_line(tmp_path, rows, line, words):
    path = written(tmp_path, rows)
    column = 2 if "column 2" in words else None
    with pytest.raises(FileFormatError, match=words) as caught:
        read_spectrum(path, column)
    assert caught.value.line == line
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (ROWS, ""),
        (ROWS[::-1], ""),
        (changed(9, "425 -1e-4"), "1 of 81 values are negative, down to -0.0001; taken as 0"),
        (ROWS[:60], "ends at 675 nm with"),
        ([*ROWS[:20], *ROWS[40:]], "no value between 475 and 580 nm"),
        ([f"{nm} 0" for nm in NM], "is zero at all wavelengths"),
        (
            [f"{row} 0.5" for row in ROWS],
            "has 2 columns of values, of which the first one is taken",
        ),
        (["nm A B", *(f"{row} 0.5" for row in ROWS)], r"the first one \('A'\) is taken"),
        # A line of the ultraviolet that has fallen to nothing where the table ends.
        (["220 0", "222 1", "224 0", "300 0"], ""),
        # Optical constants far into the infrared, ever coarser.
        ([f"{nm:.0f} 1.5" for nm in np.geomspace(300, 12_000, 60)], ""),
    ],
)
def test_what_is_odd_is_read_and_said(tmp_path, rows, words):
    file = read_spectrum(written(tmp_path, rows))
    told = " ".join(map(str, file.remarks))
    assert re.search(words, told)
    assert bool(words) == bool(told)
    assert (file.table.values >= 0.0).all()
    assert (np.diff(file.table.wavelengths) > 0.0).all()


def test_a_column_is_chosen_by_its_number(tmp_path):
    path = written(tmp_path, ["nm;A;B", "400;1,5;3", "500;2;4", "600;2,5;5"])
    second = read_spectrum(path, 2)
    assert second.table.values.tolist() == [3, 4, 5]
    assert second.names == ("A", "B")
    assert "B" in second.table.name
    assert not any("columns" in str(remark) for remark in second.remarks)
    assert read_spectrum(path, 1).table.values.tolist() == [1.5, 2, 2.5]
    with pytest.raises(FileFormatError, match="from 1 to 2, not 3"):
        read_spectrum(path, 3)


@pytest.mark.parametrize(
    "row", ["{} 1,5", "{}\t1,5", "{};1,5", "{},1.5", "{}, 1.5", "{} , 1.5 ", "{} 1.5", "{},1.5,"]
)
def test_signs_between_columns_and_decimal_signs_are_told_apart(tmp_path, row):
    file = read_spectrum(written(tmp_path, [row.format(nm) for nm in (400, 500, 600)]))
    assert file.columns == 1
    assert file.table.values.tolist() == [1.5] * 3


# ---- figures, against colour-science ----


@pytest.mark.parametrize(
    "power",
    [planck(GRID, 2700.0), daylight(GRID, 6500.0), illuminant(GRID, "FL2"), illuminant(GRID, "LED-B3")],
)  # fmt: skip
def test_colour_temperatures_are_those_of_an_independent_program(power):
    found, duv = colour_temperature(power @ observer())
    x, y, z = power @ observer()
    uv = np.array([4.0 * x, 6.0 * y]) / (x + 15.0 * y + 3.0 * z)
    expected, expected_duv = colour.temperature.uv_to_CCT_Ohno2013(uv)
    assert found == pytest.approx(expected, rel=2e-3)
    assert duv == pytest.approx(expected_duv, abs=2e-4)


def test_colours_far_from_white_have_no_colour_temperature():
    assert colour_temperature(observer()[550 - 360]) is None
    assert colour_temperature(np.zeros(3)) is None


def test_figures_have_their_closed_forms():
    # Twice as much at 555 nm as at 300 nm: two thirds of the watts at 683 lm/W.
    nm = np.array([299.0, 300.0, 301.0, 554.0, 555.0, 556.0])
    made = find_figures(Tabulated(nm, np.array([0.0, 1.0, 0.0, 0.0, 2.0, 0.0])))
    assert made.ultraviolet == pytest.approx(1.0 / 3.0)
    assert made.visible == pytest.approx(2.0 / 3.0)
    assert made.centroid == pytest.approx(470.0)
    assert made.peak == 555.0
    assert made.efficacy == pytest.approx(683.0 * 2.0 / 3.0, rel=1e-3)
    grey = find_figures(Tabulated(np.array([300.0, 900.0]), np.array([0.25, 0.25])))
    assert grey.reflectance == pytest.approx(0.25)
    assert grey.infrared == pytest.approx(0.2)
    dark = find_figures(Tabulated(np.array([400.0, 700.0]), np.zeros(2)))
    assert (dark.peak, dark.chromaticity, dark.efficacy) == (None, None, 0.0)


# ---- commands ----


def run(capsys, *arguments):
    code = main(["spectrum", *map(str, arguments)])
    printed = capsys.readouterr()
    return code, printed.out, printed.err


def test_info_tells_people_and_programs(capsys, tmp_path):
    lamp = written(tmp_path, [f"{row} 1" for row in ROWS])
    code, out, _ = run(capsys, "info", lamp)
    assert code == 0
    assert "3000 K" in out
    assert "has 2 columns" in out
    assert "1 of 2" in out
    code, out, _ = run(capsys, "info", "--column", "2", lamp)
    assert "has 2 columns" not in out
    broken = written(tmp_path, changed(64, "7000 1"), "typo.txt")
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
        code, _, _ = run(capsys, "plot", written(tmp_path, rows), "-o", tmp_path / "x.png")
        assert code == 0
    code, _, err = run(capsys, "plot", written(tmp_path, ROWS), "-o", tmp_path / "x.unknown")
    assert code == 1
    assert ".png" in err
