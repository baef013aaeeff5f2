"""TM-33 documents that are refused, with their line."""

import pytest
from tm33_files import FINE, FLAT, UNIFORM, document, emitter, grid, luminous, refused, spectral

from lumenray.engine.errors import FileFormatError
from lumenray.engine.luminaires.formats.tm33.reader import parse_tm33

ROWS = grid({0: 10, 45: 20, 90: 30})


def with_row(at, row):
    return [row if i == at else r for i, r in enumerate(ROWS)]


REFUSED = {
    "a value too few": (
        luminous(ROWS[:-1]),
        0,
        "1 of 9 intensities are missing, the first at h=90, v=90",
    ),
    "a plane too few": (
        luminous(ROWS, "<NumberHorz>4</NumberHorz>"),
        0,
        "NumberHorz says 4, but there are 3 angles h",
    ),
    "a wrong count": (
        luminous(ROWS).replace("<NumberMeasured>9", "<NumberMeasured>12"),
        0,
        "NumberMeasured says 12, but there are 9",
    ),
    "two values": (luminous([*ROWS, (45, 45, 21)]), 10, "two different intensities at h=45, v=45"),
    "negative": (luminous(with_row(4, (45, 45, -2))), 5, "a negative intensity (-2) at h=45, v=45"),
    "NaN": (
        luminous(with_row(4, (45, 45, "NaN"))),
        5,
        "expected an intensity, a number, found 'NaN'",
    ),
    "infinite": (luminous(with_row(4, (45, 45, "INF"))), 5, "found 'INF'"),
    "no number": (luminous(with_row(4, (45, "x", 1))), 5, "expected a number as v of IntData"),
    "an angle too far": (luminous(with_row(4, (45, 200, 1))), 0, "are missing"),
    "all dark": (luminous([(0, 0, 0), (0, 90, 0)]), 0, "all intensities are 0"),
    "no data": (luminous([]), 0, "holds no IntData"),
    "nothing": ("", 0, "holds no luminous, radiant or photon intensities"),
    "too bright": (luminous([(0, 0, 1e15), (0, 90, 0)]), 0, "largest intensity of 1e+15 cd"),
    "much too bright": (
        luminous([(0, 0, "1e300"), (0, 90, 0)], "<Multiplier>1e11</Multiplier>"),
        0,
        "too large",
    ),
    "multiplier of 0": (luminous(UNIFORM, "<Multiplier>0</Multiplier>"), 0, "0 as Multiplier"),
    "a third": (luminous(grid({0: 1, 60: 2, 120: 3})), 0, "angles h go from 0 to 120"),
    "too little for Symm": (
        luminous(ROWS, "<Symm>Symm_None</Symm>"),
        0,
        "not enough for the stated symmetry (none)",
    ),
    "one polar angle": (luminous([(0, 0, 1)]), 0, "a single angle v"),
    "a short spectrum": (luminous(UNIFORM) + spectral([(500, 1)]), 3, "a spectrum of 1 values"),
    "a doubled wavelength": (
        luminous(UNIFORM) + spectral([(500, 1), (500, 1)]),
        3,
        "two spectral powers at 500 nm",
    ),
    "a negative power": (
        luminous(UNIFORM) + spectral([(500, 1), (600, -1)]),
        3,
        "a negative spectral power",
    ),
    "a digit too many": (
        luminous(UNIFORM) + spectral([*FINE[:40], (5850, 1.0)]),
        3,
        "the spectrum: wavelength 5850 nm, while the others lie 5 nm apart",
    ),
    "micrometres": (luminous(UNIFORM) + spectral([(0.5, 1), (0.6, 1)]), 3, "expected nanometres"),
    "a wrong number of powers": (
        luminous(UNIFORM) + spectral(FLAT).replace("<NumberWavelength>4", "<NumberWavelength>5"),
        3,
        "NumberWavelength says 5",
    ),
}
"""Content, lines that the place lies behind the emitter's first, words."""


@pytest.mark.parametrize("what", REFUSED)
def test_what_cannot_be_read_safely_is_refused_with_its_line(what):
    content, behind, words = REFUSED[what]
    error = refused(emitter(content))
    assert words in str(error)
    first = document(emitter("")).decode().split("<Emitter>")[0].count("\n") + 1
    assert error.line == first + behind


@pytest.mark.parametrize("kind", ["CIE_A", "CIE _ B", "CUSTOM"])
def test_goniometers_whose_axes_are_not_settled_are_refused(kind):
    error = refused(emitter(luminous(UNIFORM)), goniometer=kind)
    assert "convert the file" in str(error)
    assert error.line == 9


def test_another_root_is_refused_by_name():
    with pytest.raises(FileFormatError, match="root element svg, expected IESTM33"):
        parse_tm33(b"<svg/>", "a.xml")
