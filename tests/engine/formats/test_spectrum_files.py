"""Files of spectra: every layout, what cannot be a spectrum is refused, and what is odd is said."""

import re

import numpy as np
import pytest
from spectra import NM, ROWS, changed_rows
from text_files import written

from lumenray.engine.errors import FileFormatError
from lumenray.engine.formats.spd import read_spectrum


@pytest.mark.parametrize(
    ("rows", "line", "words"),
    [
        (changed_rows(7, "415 1e308"), 8, "at most 1e\\+30, found 1e\\+308"),
        (changed_rows(7, "1e308 1"), 8, "1e\\+308 nm stands beside 410 and 420"),
        (changed_rows(64, "7000 1"), 65, "7000 nm stands beside 695 and 705"),
        (changed_rows(64, "70 1"), 65, "70 nm stands beside 695 and 705"),
        (changed_rows(-1, "7800 1"), 81, "is a digit too many or few"),
        (changed_rows(0, "38 1"), 1, "is a digit too many or few"),
        (changed_rows(-1, "2e8 1"), 81, "from 10 to 100000 nm, found 2e\\+08"),
        (changed_rows(9, "425 -0.5"), 10, "at least 0, found -0.5"),
        (changed_rows(9, "425 inf"), 10, "finite"),
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
        (changed_rows(9, "425 -1e-4"), "1 of 81 values are negative, down to -0.0001; taken as 0"),
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


@pytest.mark.parametrize(
    "text",
    [
        "400 1\n500 2\n600 3\n",
        "nm,value\n400,1.0\n500,2.0\n600,3.0\n",
        "# heading\n600;3,0\r\n500;2,0\r\n400;1,0\r\n",
        "\ufeffwavelength\tpower\n400\t1e0\n500\t2.0D0\n600\t3\n",
        "Wellenlänge\tStärke – relativ\n400\t1\n500\t2\n600\t3\n".encode("cp1252"),
        "λ\tpower\n400\t1\n500\t2\n600\t3\n".encode("utf-16"),
        '<?xml version="1.0"?><IESTM2714 xmlns="iestm2714"><SpectralDistribution>'
        '<SpectralData wavelength="400">1</SpectralData><SpectralData wavelength="500">2</SpectralData>'
        '<SpectralData wavelength="600">3</SpectralData></SpectralDistribution></IESTM2714>',
    ],
)
def test_spectra_are_read_in_all_common_layouts(tmp_path, text):
    made = read_spectrum(written(tmp_path, text)).table
    assert made.wavelengths.tolist() == [400, 500, 600]
    assert made.values.tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("400 1\n500 x\n", 2, "expected wavelength and value"),
        ("400 1\n400 2\n", 2, "stands twice"),
        ("400 1\n500 nan\n", 2, "finite"),
        ("400 1\n500 -1\n", 2, "at least 0"),
        ("0.4 1\n0.5 2\n", None, "nanometres"),
        ("only words\n", None, "at least two rows"),
        ("", None, "at least two rows"),
        ("<?xml version='1.0'?><!DOCTYPE a [<!ENTITY b 'c'>]><IESTM2714/>", 1, "refused"),
        ("<?xml version='1.0'?><IESTM2714>", 1, "well-formed"),
    ],
)
def test_a_bad_spectrum_is_refused_with_file_line_and_expectation(tmp_path, text, line, words):
    path = written(tmp_path, text)
    with pytest.raises(FileFormatError, match=words) as caught:
        read_spectrum(path)
    assert caught.value.line == line
    assert str(path) in str(caught.value)
