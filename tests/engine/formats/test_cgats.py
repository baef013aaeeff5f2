"""Spectra of instruments: what CGATS text and files of ArgyllCMS hold is read, and what is wrong is told with its line."""

import json

import numpy as np
import pytest
from cgats_files import NM, argyll, grey, pairs, samples, table
from text_files import written

from lumenray.command_line.main import main
from lumenray.engine.errors import FileFormatError
from lumenray.engine.formats.spd import read_spectrum
from lumenray.engine.photometry.spectra import planck

LAMP = planck(np.linspace(380.0, 730.0, 106), 3000.0)


def told(file) -> str:
    return " ".join(map(str, file.remarks))


@pytest.mark.parametrize(
    "text",
    [
        samples(),
        samples("SPECTRAL_NM_{}"),
        samples("nm{}"),
        samples("NM_{}"),
        samples("R_{}"),
        samples("SPECTRAL_{}"),
        samples("SPEC_{}"),
        samples("SPECTRAL_DEC_{}"),
        samples("SPECTRAL_PCT_{}", 100.0),
        samples("SPEC_{}", 100.0, more=['SPECTRAL_NORM "100.000000"']),
        samples("SPEC_{}", 100.0, first="CTI3   "),
        samples(first="LGOROWLENGTH 3"),
        samples(first="# measured in the cellar\nISO28178", between="  "),
        samples().replace("\n", "\r\n"),
        samples().replace("\n", "\r"),
        samples().replace(".17", "").replace("0.", "0,"),
    ],
)
def test_samples_are_read_by_any_of_the_names_that_programs_give_to_wavelengths(tmp_path, text):
    path = written(tmp_path, text)
    file = read_spectrum(path, 2)
    assert (file.format, file.columns, file.names) == ("CGATS", 3, ("A 1", "A 2", "A 3"))
    assert file.table.wavelengths.tolist() == NM.tolist()
    assert file.table.values == pytest.approx(grey(0.5), rel=1e-5)
    first = read_spectrum(path)
    assert "has 3 samples, of which the first one ('A 1') is taken" in told(first)
    assert first.table.values == pytest.approx(grey(0.2), rel=1e-5)
    with pytest.raises(FileFormatError, match="has 3 samples, expected a column from 1 to 3"):
        read_spectrum(path, 4)


@pytest.mark.parametrize(
    "text", [pairs(), pairs("SPECTRAL_DEC", 1.0), pairs("spectral_pct", wrap=100)]
)
def test_pairs_of_wavelength_and_value_may_go_over_many_lines(tmp_path, text):
    file = read_spectrum(written(tmp_path, text))
    assert file.table.wavelengths.tolist() == NM.tolist()
    assert file.table.values == pytest.approx(grey(0.5), rel=1e-5)
    assert ("per cent" in told(file)) == ("pct" in text.lower())


def test_one_pair_in_a_set_makes_one_spectrum_of_all_sets(tmp_path):
    rows = [[k, nm, value] for k, (nm, value) in enumerate(zip(NM, grey(0.5), strict=True))]
    text = table(["SAMPLE_ID", "SPECTRAL_NM", "SPECTRAL_DEC"], rows)
    file = read_spectrum(written(tmp_path, text))
    assert file.columns == 1
    assert file.table.values == pytest.approx(grey(0.5), rel=1e-5)


def test_files_of_argyllcms_have_the_wavelengths_of_their_keywords(tmp_path):
    file = read_spectrum(written(tmp_path, argyll(LAMP), "lamp.sp"))
    assert file.format == "ArgyllCMS spectrum (CGATS)"
    assert file.table.wavelengths == pytest.approx(np.linspace(380.0, 730.0, 106))
    assert file.table.values == pytest.approx(LAMP, rel=1e-5)
    assert "ends at 730 nm" in told(file)
    assert file.columns == 1


def test_the_norm_of_a_file_stands_for_1_and_is_told(tmp_path):
    file = read_spectrum(written(tmp_path, argyll(100.0 * grey(0.5), norm=100.0), "paint.sp"))
    assert file.table.values == pytest.approx(grey(0.5), rel=1e-5)
    assert "SPECTRAL_NORM 100, by which its values are divided" in told(file)


def test_per_cent_that_no_word_tells_stay_as_they_are(tmp_path):
    file = read_spectrum(written(tmp_path, samples(factor=100.0)), 1)
    assert file.table.values.max() > 1.0


def test_tables_without_spectra_are_passed_over_and_further_ones_told(tmp_path):
    colours = table(["SAMPLE_ID", "LAB_L"], [[1, 50.0], [2, 60.0]])
    again = "\n".join(["BEGIN_DATA", *["1 A 50 " + "0.5 " * len(NM)] * 2, "END_DATA"])
    file = read_spectrum(written(tmp_path, colours + samples() + again), 1)
    assert file.table.values == pytest.approx(grey(0.2), rel=1e-5)
    assert "has 2 tables of data" in told(file)


def test_counts_that_are_not_the_stated_ones_are_told(tmp_path):
    text = samples().replace("SETS 3", "SETS 4").replace("FIELDS 39", "FIELDS 40")
    words = told(read_spectrum(written(tmp_path, text), 1))
    assert "states 4 sets, but has 3" in words
    assert "line 6: states 40 fields, but has 39" in words


def changed(old, new, text=None):
    text = samples() if text is None else text
    assert old in text
    return text.replace(old, new, 1)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (changed("END_DATA\n", ""), 14, "ends before END_DATA; it is cut short"),
        (samples()[:300], 8, "ends before END_DATA_FORMAT; it is cut short"),
        (changed("0.18\t", ""), 12, "has 77 values for the 39 fields of a set"),
        (changed("0.18\t", "0.18\t0.18\t"), 12, "has 40 values for the 39 fields"),
        (changed("0.18\t", "0.1B\t"), 12, "has '0.1B' as SPECTRAL_NM380, expected a number"),
        (changed("0.18\t", "-0.18\t"), 12, "at least 0, found -0.18"),
        (changed("0.18\t", "1e308\t"), 12, "at most 1e\\+30"),
        (changed("NM390", "NM380"), 12, "wavelength 380 nm stands twice"),
        (changed("NM390", "NM3900"), 12, "wavelength 3900 nm stands beside"),
        (table(["SAMPLE_ID", "LAB_L"], [[1, 50.0]]), None, "without spectral values, expected fields such as"),
        (changed("A 3", 'A "3'), 14, "has 4. values for the 39 fields"),
        (table([f"NM{nm}" for nm in NM], []), None, "expected at least two rows"),
        (pairs().replace("SPECTRAL_PCT", "SPECTRAL_DEC", 1), 11, "both SPECTRAL_PCT and SPECTRAL_DEC"),
        (changed('BANDS "106"', 'BANDS "107"', argyll(LAMP)), 8, "states 107 SPECTRAL_BANDS, but has 106 such fields"),
        (changed('BANDS "106"', 'BANDS "1e99"', argyll(LAMP)), 8, "states '1e99' as SPECTRAL_BANDS, expected 1 to 2000"),
        (changed('NM "730.000000"', 'NM "780.000000"', argyll(LAMP)), 10, "a field SPEC_390 that .* put at 391.*nm"),
        (changed('NORM "1.000000"', 'NORM "0"', argyll(LAMP)), 14, "states '0' as SPECTRAL_NORM"),
        (changed("1\t\"A 1\"", "1\t\"A 1\"" + " " * (1 << 17)), 12, "more than 131072 characters"),
        (table([f"F{k}" for k in range(2001)], []), 8, "has more than 2000 fields"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_refused_with_its_line(tmp_path, text, line, words):
    path = written(tmp_path, text)
    with pytest.raises(FileFormatError, match=words) as caught:
        read_spectrum(path)
    assert caught.value.line == line
    assert "\n" not in str(caught.value)


def test_the_command_tells_samples_and_chooses_one(capsys, tmp_path):
    path = written(tmp_path, samples())
    assert main(["spectrum", "info", str(path)]) == 0
    out = capsys.readouterr().out
    assert "1 of 3 ('A 1')" in out
    assert "has 3 samples" in out
    assert main(["spectrum", "info", "--json", "--column", "3", str(path)]) == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert row["column_names"] == ["A 1", "A 2", "A 3"]
    assert 0.78 < row["luminous_reflectance_d65"] < 0.82
