"""LM-63 files that depart from the standard: read with a remark, or refused with their line."""

import math
import re
import time

import numpy as np
import pytest
from lm63_files import FIRST_LINES, HEAD_2002, PLAIN, candela, made, parsed, words

from lumenray.engine.errors import FileFormatError
from lumenray.engine.luminaires.distribution import flux
from lumenray.engine.luminaires.formats.lm63.writer import write_lm63


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("", None, "is empty"),
        ("no photometry\nat all\n", 3, "no line TILT="),
        (made(tilt="TILT="), 6, "expected NONE, INCLUDE or a file name"),
        (made(tilt="TILT=INCLUDE\n4\n1\n0\n1"), 7, "geometry 4, expected 1, 2 or 3"),
        (made(tilt="TILT=INCLUDE\n1\n0"), 8, "0 tilt angles"),
        (made(tilt="TILT=INCLUDE\n1\n2\n90 0\n1 1"), 9, "tilt angles do not ascend"),
        (made(tilt="TILT=INCLUDE\n1\n2\n0 90\n1 -1"), 10, "tilt factor of -1"),
        (made(tilt="TILT=NONE\nfile format error"), 7, "number of lamps, found 'file'"),
        (made(lamps="1.5 1000 1"), 7, "whole number for the number of lamps, found '1.5'"),
        (made(lamps="1 nan 1"), 7, "number for the lumens per lamp, found 'nan'"),
        (made(lamps="1 1e13 1"), 7, "lumens per lamp, expected at most"),
        (made(lamps="1 1000 0"), 7, "candela multiplier is 0, expected a positive factor"),
        (made(lamps="1 1000 -2"), 7, "candela multiplier is -2"),
        (made(counts="1 1", vertical="0", candela=("1",)), 7, "1 vertical angles, expected 2 to"),
        (made(counts="3 0"), 7, "0 horizontal angles, expected 1 to"),
        (made(counts="999999999 1"), 7, "999999999 vertical angles"),
        (made(counts="10000 10000"), 7, "at most 4000000"),
        (made(counts="3.5 1"), 7, "whole number for the number of vertical angles"),
        (made(kind=0), 7, r"photometric type 0, expected 1 \(C\)"),
        (made(kind=4), 7, "photometric type 4"),
        (made(kind=2), 7, "type B needs at least 2"),
        (made(size="1 2"), 10, "vertical angle 0 follows 90"),
        (made(size="9999 1 0"), 7, r"opening of 9999 m, expected at most 1000 m \(width\)"),
        (made(size="1 x 0"), 7, "length of the opening, found 'x'"),
        (made(factors="0 1 10"), 8, "ballast factor is 0"),
        (made(FIRST_LINES[1991], factors="1 0 10"), 4, "ballast-lamp photometric factor is 0"),
        (made(factors="1 1 ten"), 8, "input watts, found 'ten'"),
        (made(vertical="0 45 200"), 9, "vertical angle 200 lies outside 0 to 180"),
        (made(vertical="-45 0 45"), 9, "vertical angle -45 lies outside"),
        (made(vertical="90 45 0"), 9, "vertical angle 45 follows 90, expected ascending"),
        (made(vertical="0 45 45"), 9, "vertical angle 45 follows 45"),
        (made(vertical="0 45 1e400"), 9, "vertical angles, found '1e400'"),
        (
            made(horizontal="90 0", candela=["1 2 3"] * 2),
            10,
            "horizontal angle 0 follows 90, expected ascending",
        ),
        (made(horizontal="0 45", candela=["1 2 3"] * 2), 10, "0 to 45, expected 0 to 0, 90, 180"),
        (made(horizontal="0 90 500", candela=["1 2 3"] * 3), 10, "at most a full turn"),
        (
            made(kind=2, vertical="-90 0 90", horizontal="0 100", candela=["1 2 3"] * 2),
            10,
            "100 lies outside -90 to 90, which type B",
        ),
        (
            made(kind=3, vertical="-100 0 90", horizontal="0 90", candela=["1 2 3"] * 2),
            9,
            "-100 lies outside -90 to 90, which type A",
        ),
        (made(candela=("300 200",)), 11, r"intensities \(1 planes of 3\), found 2"),
        (made(horizontal="0 90", candela=("1 2 3", "4 5")), 12, r"expected 6 .*, found 5"),
        (made(horizontal="0 90", candela=("1 2 3", "4 x 6")), 12, "found 'x'"),
        (made(horizontal="0 90", candela=("1 2 3", "4 5 NaN")), 12, "found 'NaN'"),
        (made(horizontal="0 90", candela=("1 2 -3", "4 5 -6")), 11, "2 negative .* down to -6"),
        (made(candela=("0 0 0",)), 11, "all intensities are 0"),
        (
            made(candela=("1 2e13 1",)),
            11,
            r"an intensity of 2e\+13 x 1 cd, expected at most 1e\+12",
        ),
        (made(candela=("300 200 100 50",)), 11, "1 numbers more than the counts"),
        (made(candela=("300 200 100",), tail=("1 2 3",)), 12, "3 numbers more than the counts"),
        (made(candela=("300", "200", "100"), tail=("1",)), 14, "1 numbers more than the counts"),
        (made(tail=("[ENDBLOCK]", *made().split("\n"))), 18, "a second luminaire begins"),
        (made(candela=("1,000 2,000 3,000",)), 11, "3 numbers more than the counts"),
        (made(candela=("1000,5 500,2 0",), tail=("7",)), 12, "1 numbers more than the counts"),
        (made(factors="0,9 1 x", lamps="1 2000,0 1"), 8, "input watts, found 'x'"),
    ],
)
def test_what_cannot_be_read_safely_is_refused_with_its_line(text, line, message):
    with pytest.raises(FileFormatError, match=message) as caught:
        parsed(text)
    assert caught.value.line == line
    assert "sample.ies" in str(caught.value)


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"horizontal": "0 180", "candela": ("100 80 60", "90 70 50")},
        {"horizontal": "0 180", "candela": ("100 80 60 ; a comment", "90 70 50")},
        {"horizontal": "0 180", "candela": ("100 80 60", "90 70")},
        {"vertical": "90 0 45 45", "horizontal": "0 180", "candela": ("4 3 2 1", "4 3 2 1")},
        {
            "kind": 2,
            "vertical": "0 90 180",
            "horizontal": "0 90 180 270",
            "candela": ["9 1 2"] * 4,
        },
    ],
)
def test_missing_ballast_and_watts_are_named_and_never_guessed(change):
    text = made(factors="", **change).replace("\n\n", "\n")
    with pytest.raises(
        FileFormatError, match="ballast factor, second factor and input watts are"
    ) as e:
        parsed(text)
    assert e.value.line == 8


def test_three_missing_intensities_are_not_taken_for_missing_factors():
    text = made(horizontal="0 180", candela=("100 80 60",))
    with pytest.raises(FileFormatError, match="expected 6 intensities"):
        parsed(text)


@pytest.mark.parametrize(
    ("text", "remark"),
    [
        (PLAIN.replace("\n", "\r\n"), ""),
        (PLAIN.replace("\n", "\r"), ""),
        ("\ufeff" + PLAIN, ""),
        (PLAIN + "\x1a\x00", ""),
        (PLAIN.rstrip("\n"), ""),
        (PLAIN.replace(" ", "\t").replace("\tH", " H").replace("]\t", "] "), ""),
        (made(counts="3.0 1.0", lamps="1.0 2000. 1.0D0", unit="2.0"), ""),
        (made(vertical="0,45, 90", counts="3 1", candela=("300,200 ,100",)), ""),
        (made(vertical="0\n45\n90", counts="3 1", candela=("300\n200\n100",)), ""),
        (made(tilt="  tilt = none"), "line 6: found 'tilt = none', read as TILT=NONE"),
        (made(tilt="TILT=NONE always"), "line 6: found 'TILT=NONE always'"),
        (made(tail=("END",)), "line 12: 'END' and what follows the intensities is ignored"),
        (made(tail=("7 8",)), "line 12: 2 numbers behind the intensities are ignored"),
        (made(unit=3), "line 7: unit of length 3 instead of 1 .* taken as metres"),
        (made(lamps="1 -1000 1"), "line 7: -1000 lumens per lamp instead of -1"),
        (made(lamps="0 1000 1"), "line 7: 0 lamps, taken as unknown"),
        (made(lamps="1 100 1"), "do not fit: .* lm by the intensities, 100 lm stated"),
        (made(lamps="1 9000 1"), "do not fit"),
        (made(factors="1 1 -10"), "line 8: -10 input watts, taken as unknown"),
        (made(HEAD_2002[:3]), r"lacks the required keywords \[ISSUEDATE\], \[MANUFAC\]"),
        (made((*HEAD_2002, "stray text")), "line 6: lines that belong to no keyword"),
        (made((*HEAD_2002, "[CCT] 4000")), r"line 6: .* does not know are kept: \[CCT\]"),
        (made((*HEAD_2002, "[_CCT] 4000")), ""),
        (made((HEAD_2002[0], "[MORE] what", *HEAD_2002[1:])), "line 2: lines that belong to no"),
        (made((*HEAD_2002, "[OTHER] Grün")), "line 6: characters that are not ASCII"),
        (made((*HEAD_2002, "[OTHER] " + "x" * 250)), "line 6: a line of 258 characters"),
        (made((*HEAD_2002, "[NEARFIELD] 1 2 3")), "near-field photometry"),
    ],
)
def test_departures_are_read_alike_and_remarked_on_with_their_line(text, remark):
    file, plain = parsed(text), parsed(PLAIN)
    assert np.array_equal(file.distribution.intensity, plain.distribution.intensity)
    assert np.array_equal(file.distribution.polar, plain.distribution.polar)
    assert re.search(remark, words(file))
    assert bool(remark) == bool(file.remarks)


def test_unusual_factors_and_peaks_are_applied_and_remarked_on():
    file = parsed(made(factors="3 1 10", lamps="1 -1 1e6"))
    assert candela(file, 0) == pytest.approx(9e8)
    assert "line 8: an unusual ballast factor of 3" in words(file)
    assert "line 11: a peak of 9e+08 cd" in words(file)


def test_text_in_latin_1_is_kept():
    file = parsed(made((*HEAD_2002, "[LUMINAIRE] für 30°")).encode("latin-1"))
    assert file.metadata["LUMINAIRE"] == "für 30°"


def test_decimal_commas_are_seen_when_separators_cannot_be_meant():
    text = made(lamps="1 1000 1,0", factors="0,5 1 10,5", candela=("300,5 200,25 100",))
    file = parsed(text)
    assert candela(file, 0) == pytest.approx(150.25)
    assert file.watts == 10.5
    assert "line 7: decimal commas instead of points" in words(file)


def test_a_large_file_takes_no_quadratic_time():
    rows = "\n".join("1 " * 2000 for _ in range(500))
    vertical = " ".join(f"{a:.9g}" for a in np.linspace(0, 180, 2000))
    horizontal = " ".join(f"{a:.9g}" for a in np.linspace(0, 360, 500))
    file = parsed(made(lamps="1 -1 1", vertical=vertical, horizontal=horizontal, candela=(rows,)))
    assert flux(file.distribution) == pytest.approx(4.0 * math.pi, rel=1e-9)


@pytest.mark.parametrize(
    "line",
    [
        "[" + " " * 300_000 + "x",
        "[A]" + " " * 300_000 + "]",
        "TILT" + " " * 300_000,
        " " * 300_000 + "x",
        "IESNA" + ":" * 300_000,
        "[A] W" + " W" * 150_000,
        "[A] " + "-" * 300_000,
    ],
)
def test_long_lines_are_read_and_written_without_delay(line):
    start = time.perf_counter()
    file = parsed(made((*HEAD_2002, line), tilt="TILT=a" + " " * 300_000 + "b"))
    write_lm63(file)
    assert time.perf_counter() - start < 30.0
