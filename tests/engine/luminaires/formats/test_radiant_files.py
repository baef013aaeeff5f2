"""Photometric files in watts per steradian, as those of germicidal lamps: they keep their unit and are never white light."""

import json

import numpy as np
import pytest
from folders import WILD
from photometric_files import write_ies

from lumenray.command_line import main as command_line
from lumenray.engine.errors import FileFormatError, LumenrayError
from lumenray.engine.luminaires.distribution import flux
from lumenray.engine.luminaires.formats.reader import (
    parse_luminaire,
    read_luminaire,
    write_luminaire,
)
from lumenray.engine.luminaires.formats.record import LUMINOUS, RADIANT
from lumenray.engine.luminaires.lamp_spectrum import choose_spectrum
from lumenray.engine.photometry.spectra import efficacy_of_all, efficacy_of_table
from lumenray.engine.scene.spectrum import Constant, Tabulated

DATA = WILD / "ies"

UNIT = "[_INTENSITYUNITS] mW/sr"


def even(*keywords, value=100.0, lumens=-1):
    """The same in all directions, so its flux is 4 pi times the value."""
    text = write_ies([[value, value]], [0, 180], [0], keywords=keywords, lumens=lumens)
    return parse_luminaire(text.encode(), "even.ies")


@pytest.mark.parametrize(
    ("words", "size"),
    [
        (UNIT, 1e-3),
        ("[TEST] Lumens-> mW, lux-> mW/m^2, candela-> mW/sr", 1e-3),
        ("[OTHER] Intensity values are expressed in mW/sr (200-280nm).", 1e-3),
        ("[OTHER] values in µW/sr", 1e-6),
        ("[OTHER] all in milliwatts per steradian", 1e-3),
        ("[OTHER] unit: W / sr", 1.0),
    ],
)
def test_a_unit_that_the_text_tells_makes_watts_of_the_values(words, size):
    file = even(words)
    assert file.quantity == RADIANT
    assert flux(file.distribution) == pytest.approx(400.0 * np.pi * size)
    assert "lights nothing visible" in str(file.remarks[-1])


@pytest.mark.parametrize(
    "words",
    [
        "[OTHER] cd",
        "[OTHER] blue light hazard 0.2 mW/sr at 1 m",
        "[LAMP] 12 W/sr2",
        "[OTHER] 5W srt",
    ],
)
def test_other_words_leave_candelas_what_they_are(words):
    file = even(words)
    assert file.quantity == LUMINOUS
    assert flux(file.distribution) == pytest.approx(400.0 * np.pi)


def test_photons_are_refused_rather_than_taken_for_candelas():
    with pytest.raises(FileFormatError, match=r"count photons \(umol/s/sr\)"):
        even("[OTHER] intensities in umol/s/sr")


def test_a_stated_flux_is_watts_as_well():
    file = even(UNIT, lumens=2000)
    assert file.stated_flux == pytest.approx(2.0)
    assert file.lamps[0].luminous_flux is None


def test_nothing_is_assumed_of_its_spectrum():
    for words in ("[LAMP] Excimer 222 nm", "[LAMP] LED 4000 K", "[LAMP] unknown"):
        made = choose_spectrum(even(UNIT, words))
        assert made.spectrum is None
        assert made.is_ultraviolet == ("Excimer" in words)
        assert "lights nothing visible" in made.reason


def test_writing_keeps_the_unit_and_eulumdat_which_has_none_is_refused(tmp_path):
    for words in (UNIT, "[OTHER] values in µW/sr"):
        file = even(words, lumens=2000)
        write_luminaire(file, tmp_path / "again.ies")
        again = read_luminaire(tmp_path / "again.ies")
        assert again.quantity == RADIANT
        assert flux(again.distribution) == pytest.approx(flux(file.distribution))
        assert again.stated_flux == pytest.approx(file.stated_flux)
    with pytest.raises(LumenrayError, match="no place in EULUMDAT"):
        write_luminaire(file, tmp_path / "again.ldt")


def test_the_command_line_tells_watts_and_no_lumens(tmp_path, capsys):
    path = tmp_path / "uv.ies"
    path.write_text(write_ies([[100.0, 100.0]], [0, 180], [0], keywords=(UNIT,)))
    assert command_line.main(["luminaire", "info", str(path)]) == 0
    out = capsys.readouterr().out
    assert "radiant flux        1.257 W" in out
    assert "visible light       none" in out
    assert "0.1 W/sr at" in out
    assert " cd" not in out.split("warnings")[0]
    assert command_line.main(["luminaire", "info", "--json", str(path)]) == 0
    row = json.loads(capsys.readouterr().out)[0]
    assert row["quantity"] == "radiant"
    assert row["radiant_flux_w"] == pytest.approx(0.4 * np.pi, rel=1e-6)
    assert row["luminous_flux_lm"] == 0.0
    assert row["peak_w_per_sr"] == pytest.approx(0.1)


def test_the_efficacy_of_a_table_counts_all_of_its_radiation():
    # Half of the watts at 555 nm, half of them at 222 nm: 683 / 2 lm/W.
    nm = np.array([200.0, 221.0, 222.0, 223.0, 554.0, 555.0, 556.0, 800.0])
    values = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    assert efficacy_of_table(nm, values) == pytest.approx(341.4, rel=1e-3)
    assert efficacy_of_all(Tabulated(nm, values)) == pytest.approx(341.4, rel=1e-3)
    # An equal-energy spectrum: the mean of V(lambda) over 360 to 830 nm.
    assert efficacy_of_all(Constant(1.0)) == pytest.approx(683.002 * 106.857 / 471, rel=1e-4)


@pytest.mark.parametrize("path", sorted(DATA.glob("uv_*.ies")), ids=lambda path: path.stem)
def test_real_germicidal_lamps_are_radiant(path):
    file = read_luminaire(path)
    assert file.quantity == RADIANT
    # None of them gives more than half a watt.
    assert 0.01 < flux(file.distribution) < 0.5
    assert choose_spectrum(file).is_ultraviolet
