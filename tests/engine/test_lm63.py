"""IES LM-63 in and out: every edition, type, symmetry, opening and defect."""

import math
import re
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lumenray.engine.errors import FileFormatError, LumenrayError
from lumenray.engine.luminaires.distribution import flux, intensity, mirrored, turned
from lumenray.engine.luminaires.formats.lm63.reader import GENERATION_TYPE, parse_lm63, read_lm63
from lumenray.engine.luminaires.formats.lm63.writer import write_lm63
from lumenray.engine.luminaires.formats.record import LuminaireFile
from lumenray.engine.scene.distribution import IntensityDistribution, Opening

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"

HEAD_2002 = (
    "IESNA:LM-63-2002",
    "[TEST] 1",
    "[TESTLAB] Hand made",
    "[ISSUEDATE] 2024-01-01",
    "[MANUFAC] Example",
)
FIRST_LINES = {
    1986: ("A downlight of 1986",),
    1991: ("IESNA91",),
    1995: ("IESNA:LM-63-1995",),
    2002: HEAD_2002,
    2019: ("IES:LM-63-2019", *HEAD_2002[1:]),
}


def made(
    head=HEAD_2002,
    tilt="TILT=NONE",
    lamps="1 2000 1",
    counts=None,
    kind=1,
    unit=2,
    size="0 0 0",
    factors="1 1 10",
    vertical="0 45 90",
    horizontal="0",
    candela=("300 200 100",),
    tail=(),
):
    """Text of a file; by default line 6 is TILT, 7 and 8 the counts and factors, 9 and 10 the angles."""
    counts = counts or f"{len(vertical.split())} {len(horizontal.split())}"
    numbers = f"{lamps} {counts} {kind} {unit} {size}"
    return "\n".join([*head, tilt, numbers, factors, vertical, horizontal, *candela, *tail]) + "\n"


def parsed(text, folder=None) -> LuminaireFile:
    return parse_lm63(text if isinstance(text, bytes) else text.encode(), "sample.ies", folder)


def toward(polar, azimuth=0.0):
    """Direction of type C angles. [degree]"""
    gamma, c = math.radians(polar), math.radians(azimuth)
    return (math.sin(gamma) * math.cos(c), math.sin(gamma) * math.sin(c), -math.cos(gamma))


def candela(file, polar, azimuth=0.0) -> float:
    return float(intensity(file.distribution, np.array(toward(polar, azimuth))))


def words(file) -> str:
    return "\n".join(map(str, file.remarks))


QUADRANT = made(
    (*HEAD_2002, "[LUMINAIRE] Quadrant", "[MORE] second line"),
    lamps="2 1000 1.0",
    size="0.30 1.20 0",
    factors="0.9 1 40",
    vertical="0 22.5 45 67.5 90",
    horizontal="0 45 90",
    candela=("300 280 220 120 0", "300 270 200 100 0", "300 260 180 80 0"),
)


def test_a_relative_quadrant_file_means_what_it_says():
    file = parsed(QUADRANT)
    assert file.remarks == ()
    assert (file.format, file.photometric_type, file.symmetry) == ("LM-63-2002", "C", "quadrant")
    assert candela(file, 0) == pytest.approx(270.0)
    for azimuth in (90, 270):
        assert candela(file, 45, azimuth) == pytest.approx(162.0)
    for azimuth in (0, 180):
        assert candela(file, 45, azimuth) == pytest.approx(198.0)
    # Bilinear: half way between the planes at 0 and 45, and between 45 and 67.5 degrees.
    assert candela(file, 56.25, 22.5) == pytest.approx(0.9 * (220 + 120 + 200 + 100) / 4)
    assert candela(file, 91) == 0.0
    # Linear in azimuth: the mean over it is a sum of planes; along the polar angle by a fine midpoint rule.
    mean = (
        0.9
        * np.array([[0.25, 0.5, 0.25]])
        @ [
            [300, 280, 220, 120, 0],
            [300, 270, 200, 100, 0],
            [300, 260, 180, 80, 0],
        ]
    )
    polar = (np.arange(100_000) + 0.5) * 90 / 100_000
    rows = np.interp(polar, [0, 22.5, 45, 67.5, 90], mean[0]) * np.sin(np.radians(polar))
    assert flux(file.distribution) == pytest.approx(math.pi**2 * rows.mean(), rel=1e-8)
    # The formula by the means of corners, within its own error on so coarse a grid.
    assert flux(file.distribution) == pytest.approx(794.1, rel=0.02)
    assert file.stated_flux == 2000.0
    assert not file.is_absolute
    assert file.watts == 40.0
    assert file.opening == Opening("rectangle", (1.2, 0.3, 0.0), "z")
    assert file.length_axis == "x"
    assert file.metadata["LUMINAIRE"] == "Quadrant\nsecond line"
    assert list(file.metadata) == ["TEST", "TESTLAB", "ISSUEDATE", "MANUFAC", "LUMINAIRE"]
    assert file.stored_azimuths.tolist() == [0, 45, 90]
    assert file.stored_polars.tolist() == [0, 22.5, 45, 67.5, 90]


def test_a_uniform_hemisphere_has_the_flux_of_the_closed_form():
    file = parsed(made(lamps="1 -1 1", candela=("100 100 100",)))
    assert flux(file.distribution) == pytest.approx(2.0 * math.pi * 100.0, rel=1e-12)
    assert file.is_absolute
    assert file.stated_flux is None


def test_the_file_generation_type_of_2019_is_told_and_never_multiplied():
    file = parsed(
        made(
            FIRST_LINES[2019],
            lamps="1 -1 1",
            size="-0.10 -0.10 0",
            factors="1 1.11000 10",
            candela=("1000 500 0",),
        )
    )
    assert file.remarks == ()
    assert candela(file, 0) == pytest.approx(1000.0)
    assert flux(file.distribution) == pytest.approx(2490.9, rel=0.15)
    assert file.metadata[GENERATION_TYPE] == "accredited laboratory, interpolated angles"
    assert file.opening == Opening("ellipse", (0.1, 0.1, 0.0), "z")


@pytest.mark.parametrize(
    ("code", "meaning"),
    [
        ("1.00001", "undefined"),
        ("1.00010", "computer simulation"),
        ("1.00000", "laboratory without accreditation"),
        ("1.00100", "laboratory without accreditation, scaled lumens"),
        ("1.01100", "laboratory without accreditation, interpolated angles, scaled lumens"),
        ("1.10000", "accredited laboratory"),
    ],
)
def test_file_generation_types_have_words(code, meaning):
    file = parsed(made(FIRST_LINES[2019], factors=f"1 {code} 10"))
    assert file.metadata[GENERATION_TYPE] == meaning


def test_an_included_tilt_table_is_kept_and_not_applied():
    text = made(
        FIRST_LINES[1991],
        "TILT=INCLUDE\n1\n3\n0 45 90\n1.0 0.95 0.90",
        lamps="1 2000 1",
        unit=1,
        size="-0.5 0 0",
        factors="1 0.97 250",
        candela=("400 300 0",),
        tail=("\x1anothing from here on is text",),
    )
    file = parsed(text)
    assert file.remarks == ()
    assert candela(file, 0) == pytest.approx(388.0)
    assert file.opening == Opening("ellipse", (0.1524, 0.1524, 0.0), "z")
    assert file.tilt.geometry == 1
    assert file.tilt.factor(45.0) == pytest.approx(0.95)
    assert file.tilt.factor(-22.5) == pytest.approx(0.975)


@pytest.mark.parametrize(("year", "factor"), [(1986, 0.5), (1991, 0.5), (1995, 1), (2002, 1)])
def test_the_second_factor_counts_until_1991(year, factor):
    file = parsed(made(FIRST_LINES[year], factors="0.8 0.5 10"))
    assert file.format == f"LM-63-{year}"
    assert candela(file, 0) == pytest.approx(300 * 0.8 * factor)
    assert ("0.5 behind the ballast factor" in words(file)) == (year >= 1995)


@pytest.mark.parametrize(
    ("line", "year", "is_remarked"),
    [
        ("IESNA:LM-63-1986", 1986, True),
        ("IESNA86", 1986, True),
        ("IESNA:LM-63-1991", 1991, True),
        ("IESNA95", 1995, True),
        ("IESNA:LM-63-95", 1995, True),
        ("iesna:lm-63-2002", 2002, True),
        ("IESNA:LM-63-2002   ", 2002, False),
        ("IESNA:LM-63-2002 by Some Program 3.19", 2002, True),
        ("\n\nIESNA:LM-63-2002", 2002, True),
        ("IESNA:LM-63-2019", 2019, True),
        ("IESNA:LM-63-2031", 2002, True),
        ("[LUMCAT] no line of the edition", 2002, True),
        ("IES REPORT 1234, free text", 1986, False),
        ("ERCO Leuchten GmbH", 1986, False),
    ],
)
def test_the_edition_is_found_in_every_spelling(line, year, is_remarked):
    file = parsed(made((line, *(HEAD_2002[1:] if "LM-63-20" in line or "[" in line else ()))))
    assert file.format == f"LM-63-{year}"
    assert ("LM-63-2" in words(file) or "read as" in words(file)) == is_remarked


def test_labels_of_1986_are_kept_and_a_file_may_begin_with_tilt():
    file = parsed(made(("REPORT NUMBER: 12", "", "  LAMPS: two")))
    assert file.metadata == {"label": "REPORT NUMBER: 12\nLAMPS: two"}
    assert file.remarks == ()
    assert parsed(made(())).format == "LM-63-1986"


def lobe(azimuth):
    """Intensity at 45 degrees that tells all azimuths apart, and not linear."""
    return 300 + azimuth + azimuth**2 / 100


def lobed(azimuths):
    return tuple(f"500 {lobe(azimuth):.9g} 0" for azimuth in azimuths)


@pytest.mark.parametrize(
    ("year", "stored", "symmetry", "image"),
    [
        (2002, [0], "rotational", lambda _: 0),
        (2002, [0, 45, 90], "quadrant", lambda c: min(c % 180, 180 - c % 180)),
        (2002, [0, 90, 180], "C0-C180", lambda c: min(c, 360 - c)),
        (1995, [90, 180, 270], "C90-C270", lambda c: c if 90 <= c <= 270 else (180 - c) % 360),
        (2002, [0, 90, 180, 270, 360], "none", lambda c: c),
    ],
)
def test_symmetric_planes_are_expanded_all_around(year, stored, symmetry, image):
    planes = lobed([0 if c == 360 else c for c in stored])
    horizontal = " ".join(map(str, stored))
    file = parsed(made(FIRST_LINES[year], lamps="2 2000 1", horizontal=horizontal, candela=planes))
    assert file.remarks == ()
    assert file.symmetry == symmetry
    for azimuth in range(0, 360, 45):
        expected = np.interp(image(azimuth), stored, [lobe(c % 360) for c in stored])
        if symmetry == "none" and azimuth > 270:
            expected = (lobe(270) + lobe(0)) / 2
        assert candela(file, 45, azimuth) == pytest.approx(expected), azimuth
    around = file.distribution.azimuth
    assert len(around) == 1 or (around[0] == 0.0 and around[-1] == pytest.approx(2 * math.pi))


@pytest.mark.parametrize(
    ("stored", "symmetry", "remark"),
    [
        ([0, 120, 240], "none", "0 to 240; the 120 degrees"),
        ([0, 90, 180, 270], "none", "0 to 270; the 90 degrees"),
        ([-90, 0, 90], "C90-C270", "-90 to 90, which LM-63-2002 does not know"),
        ([90, 180, 270], "C90-C270", "90 to 270, which LM-63-2002 does not know"),
        ([180, 270, 360], "C0-C180", "180 to 360"),
        ([-180, -90, 0, 90, 180], "none", "-180 to 180"),
        ([60, 180, 300], "none", "60 to 300; the 120 degrees"),
        ([45], "rotational", "a single plane at 45"),
    ],
)
def test_unusual_planes_are_taken_with_a_remark(stored, symmetry, remark):
    text = made(horizontal=" ".join(map(str, stored)), candela=lobed(stored))
    file = parsed(text)
    assert file.symmetry == symmetry
    assert remark in words(file)
    assert "line 10:" in words(file)
    for azimuth in stored[:-1]:
        assert candela(file, 45, azimuth) == pytest.approx(lobe(azimuth))
    if symmetry != "rotational":
        # The planes go all around, from 0 on, and close.
        assert file.distribution.azimuth[[0, -1]].tolist() == [0.0, 2.0 * math.pi]
        assert np.array_equal(file.distribution.intensity[0], file.distribution.intensity[-1])
    if stored[0] == 60:
        assert candela(file, 45, 0) == pytest.approx((lobe(60) + lobe(300)) / 2)


def test_planes_that_differ_at_the_pole_meet_in_their_mean_by_width():
    file = parsed(
        made(horizontal="0 90 180 270 360", candela=["100 0 0"] * 2 + ["140 0 0"] * 2 + ["100 0 0"])
    )
    assert candela(file, 0) == pytest.approx(120.0)
    assert "at a pole the planes differ by up to 16.7%" in words(file)
    uneven = parsed(made(horizontal="0 30 90", candela=("60 0 0", "60 0 0", "120 0 0")))
    # Between 30 and 90 degrees the mean is 90, over two thirds of the quarter.
    assert candela(uneven, 0) == pytest.approx(80.0)


def test_a_seam_that_does_not_close_is_remarked_on():
    file = parsed(made(horizontal="0 180 360", candela=("300 200 0", "300 100 0", "300 150 0")))
    assert "first and the last plane differ by up to 16.7%" in words(file)
    assert candela(file, 45, 0.0) == candela(file, 45, 360.0) == pytest.approx(200.0)


OPENINGS = {
    1991: [
        ("0 0 0", Opening()),
        (".2 .5 0", Opening("rectangle", (0.5, 0.2, 0.0))),
        (".2 .5 .1", Opening("box", (0.5, 0.2, 0.1))),
        ("-.2 0 0", Opening("ellipse", (0.2, 0.2, 0.0))),
        ("-.2 0 .1", Opening("cylinder", (0.2, 0.2, 0.1))),
        ("-.2 .5 0", Opening("ellipse", (0.5, 0.2, 0.0))),
        ("-.2 .5 .1", Opening("cylinder", (0.5, 0.2, 0.1))),
    ],
    1995: [
        ("-.2 0 -.2", Opening("ellipsoid", (0.2, 0.2, 0.2))),
        ("0 .5 -.1", Opening("cylinder", (0.5, 0.1, 0.1), "x")),
        (".5 0 -.1", Opening("cylinder", (0.1, 0.5, 0.1), "y")),
        ("-.2 .5 .1", Opening("cylinder", (0.5, 0.2, 0.1))),
        (".2 -.5 .1", Opening("cylinder", (0.5, 0.2, 0.1))),
        ("-.2 .5 -.1", Opening("ellipsoid", (0.5, 0.2, 0.1))),
        (".2 -.5 -.1", Opening("ellipsoid", (0.5, 0.2, 0.1))),
    ],
    2002: [
        ("0 0 0", Opening()),
        (".2 .5 0", Opening("rectangle", (0.5, 0.2, 0.0))),
        (".2 .5 .1", Opening("box", (0.5, 0.2, 0.1))),
        ("-.2 -.5 0", Opening("ellipse", (0.5, 0.2, 0.0))),
        ("-.2 -.5 .1", Opening("cylinder", (0.5, 0.2, 0.1))),
        ("-.2 -.5 -.1", Opening("ellipsoid", (0.5, 0.2, 0.1))),
        ("-.2 .5 -.1", Opening("cylinder", (0.5, 0.2, 0.1), "x")),
        (".2 -.5 -.1", Opening("cylinder", (0.5, 0.2, 0.1), "y")),
        ("-.2 0 -.1", Opening("ellipse", (0.0, 0.2, 0.1), "x")),
    ],
}


@pytest.mark.parametrize(
    ("year", "size", "expected"),
    [(year, *case) for year, cases in OPENINGS.items() for case in cases],
)
def test_openings_follow_the_table_of_their_edition(year, size, expected):
    file = parsed(made(FIRST_LINES[year], size=size))
    assert file.opening.shape == expected.shape
    assert file.opening.axis == expected.axis
    assert file.opening.size == pytest.approx(expected.size)
    assert file.remarks == ()


@pytest.mark.parametrize(
    ("size", "expected"),
    [
        ("-.2 0 0", Opening("ellipse", (0.2, 0.2, 0.0))),
        ("0 -.2 0", Opening("ellipse", (0.2, 0.2, 0.0))),
        ("-.2 0 .1", Opening("cylinder", (0.2, 0.2, 0.1))),
        ("0 .5 .1", Opening("rectangle", (0.5, 0.0, 0.1), "y")),
        (".5 0 .1", Opening("rectangle", (0.0, 0.5, 0.1), "x")),
        ("0 .5 -.1", Opening("cylinder", (0.5, 0.1, 0.1), "x")),
        ("0 -.5 -.1", Opening("ellipse", (0.5, 0.0, 0.1), "y")),
        ("0 .5 0", Opening()),
    ],
)
def test_openings_that_2002_does_not_list_are_read_with_a_remark(size, expected):
    file = parsed(made(size=size))
    assert file.opening.shape == expected.shape
    assert file.opening.axis == expected.axis
    assert file.opening.size == pytest.approx(expected.size)
    assert re.search(r"line 7: LM-63-2002 has no opening of", words(file))


def test_every_combination_of_signs_has_an_opening():
    for year, head in FIRST_LINES.items():
        for width, length, height in np.ndindex(3, 3, 3):
            size = f"{width - 1} {2 * length - 2} {3 * height - 3}"
            opening = parsed(made(head, size=size)).opening
            assert min(opening.size) >= 0.0, (year, size)
            flat = opening.shape in {"rectangle", "ellipse"}
            assert opening.size.count(0.0) == (3 if opening.shape == "point" else int(flat))
            if flat:
                assert opening.size["xyz".index(opening.axis)] == 0.0


@pytest.mark.parametrize(("unit", "metres"), [(1, 0.3048), (2, 1.0)])
def test_openings_have_their_unit(unit, metres):
    assert parsed(made(unit=unit, size="1 2 0")).opening.size[:2] == (2 * metres, metres)


FORWARD, RIGHT, UP = np.array([0.0, 0, -1]), np.array([1.0, 0, 0]), np.array([0.0, 1, 0])


def type_b(vertical, horizontal):
    """IES formula of type B: out of the vertical plane by H, about the horizontal axis by V. [degree]"""
    v, h = math.radians(vertical), math.radians(horizontal)
    return (
        math.cos(h) * math.cos(v) * FORWARD + math.sin(h) * RIGHT + math.cos(h) * math.sin(v) * UP
    )


def type_a(vertical, horizontal):
    """IES formula of type A: up by V, to the right by H. [degree]"""
    v, h = math.radians(vertical), math.radians(horizontal)
    return (
        math.cos(v) * math.cos(h) * FORWARD + math.cos(v) * math.sin(h) * RIGHT + math.sin(v) * UP
    )


VERTICAL, HORIZONTAL = [-90, -60, -20, 0, 30, 90], [-90, -45, 0, 10, 90]


def table_ab(kind):
    """Values that tell all angles apart but are one at each pole."""
    rows = []
    for h in HORIZONTAL:
        pole = kind == 2 and abs(h) == 90
        rows.append(
            " ".join(
                str(1000 + h if pole or (kind == 3 and abs(v) == 90) else 1000 + 2 * h + v)
                for v in VERTICAL
            )
        )
    if kind == 3:
        rows = [
            " ".join(
                "700" if abs(v) == 90 else x for x, v in zip(row.split(), VERTICAL, strict=True)
            )
            for row in rows
        ]
    return rows


@pytest.mark.parametrize(("kind", "letter", "direction"), [(3, "A", type_a), (2, "B", type_b)])
def test_types_a_and_b_point_where_their_formulas_say(kind, letter, direction):
    rows = table_ab(kind)
    file = parsed(
        made(
            kind=kind,
            size=".2 .5 0",
            vertical=" ".join(map(str, VERTICAL)),
            horizontal=" ".join(map(str, HORIZONTAL)),
            candela=rows,
        )
    )
    assert (file.photometric_type, file.symmetry) == (letter, "none")
    assert not any("angles" in str(remark) for remark in file.remarks)
    for h, row in zip(HORIZONTAL, rows, strict=True):
        for v, value in zip(VERTICAL, row.split(), strict=True):
            found = float(intensity(file.distribution, direction(v, h)))
            assert found == pytest.approx(float(value)), (v, h)
    # Behind the luminaire nothing was measured.
    assert intensity(file.distribution, np.array([0.1, 0.1, 1.0])) == 0.0
    # Width lies across the beam, along x.
    assert file.opening.size == (0.2, 0.5, 0.0)
    assert file.length_axis == "y"


def test_a_half_given_type_b_is_mirrored_to_the_left():
    file = parsed(
        made(
            FIRST_LINES[1995],
            lamps="1 10000 1",
            kind=2,
            vertical="-90 0 90",
            horizontal="0 90",
            candela=("0 5000 0", "0 0 0"),
        )
    )
    assert file.symmetry == "C90-C270"
    value = [
        float(intensity(file.distribution, type_b(*angles)))
        for angles in ((0, 0), (0, 45), (0, -45), (45, 0), (-45, 45), (89.9, 0))
    ]
    assert value == pytest.approx([5000, 2500, 2500, 2500, 1250, 5000 / 900], rel=1e-9)


@pytest.mark.parametrize(("kind", "direction"), [(3, type_a), (2, type_b)])
def test_vertical_angles_from_0_are_mirrored_with_a_remark(kind, direction):
    file = parsed(
        made(
            kind=kind, vertical="0 30 60", horizontal="0 40 80", candela=["9 8 7", "6 5 4", "3 2 1"]
        )
    )
    assert file.symmetry == "quadrant"
    assert "the lower half mirrors the upper one" in words(file)
    assert "vertical angles from 0 to 60 instead of -90 or 0 to 90" in words(file)
    for v, h in ((30, 40), (-30, 40), (30, -40), (-30, -40)):
        assert intensity(file.distribution, direction(v, h)) == pytest.approx(5.0)
    assert intensity(file.distribution, direction(61, 0)) == 0.0
    assert intensity(file.distribution, direction(0, 81)) == 0.0


def test_a_tilt_file_is_read_only_inside_the_folder(tmp_path):
    folder = tmp_path / "luminaires"
    folder.mkdir()
    for path in (folder / "lamp.tlt", tmp_path / "secret.tlt"):
        path.write_text("2\n2\n0 90\n1 0.5\n")
    (folder / "link.tlt").symlink_to(tmp_path / "secret.tlt")
    named = made(FIRST_LINES[1995], "TILT=lamp.tlt")
    path = folder / "lamp.ies"
    path.write_text(named)
    file = read_lm63(path)
    assert file.tilt.factor(45.0) == pytest.approx(0.75)
    assert file.remarks == ()
    assert parsed(named).tilt is None
    names = ("none.tlt", "../secret.tlt", "link.tlt", str(tmp_path / "secret.tlt"), ".", "x" * 9999)
    for name in names:
        file = parsed(made(FIRST_LINES[1995], f"TILT={name}"), folder)
        assert file.tilt is None, name
        assert "is not beside the file; no factors for tilt" in words(file)
        assert candela(file, 0) == 300.0
    (folder / "bad.tlt").write_text("2\n2\n0 90\n1\n")
    with pytest.raises(
        FileFormatError, match=r"bad\.tlt, line 4: expected 2 tilt factors, found 1"
    ):
        parsed(made(FIRST_LINES[1995], "TILT=bad.tlt"), folder)
    assert "which LM-63-2019 does not know" in words(
        parsed(made(FIRST_LINES[2019], "TILT=lamp.tlt"), folder)
    )


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("", None, "is empty"),
        (made().encode("utf-16"), None, "UTF-16"),
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


PLAIN = made()


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


def test_vertical_angles_that_stop_early_leave_darkness():
    file = parsed(made(vertical="0 40 80"))
    assert "line 9: vertical angles from 0 to 80 instead of 0 or 90 to 90 or 180" in words(file)
    assert candela(file, 80) == pytest.approx(100.0)
    assert candela(file, 80.1) == 0.0


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
    assert time.perf_counter() - start < 5.0


# ---- writing ----------------------------------------------------------------------------------


def test_a_written_file_is_plain_and_complete():
    source = parsed(
        made(
            FIRST_LINES[1991] + ("[TEST] 7", "[LUMINAIRE] " + "grün " * 60, "stray"),
            "TILT=INCLUDE\n1\n2\n0 90\n1 0.5",
            lamps="2 1000 1",
            size="-.2 0 0",
        )
    )
    data = write_lm63(source)
    lines = data.decode("ascii").split("\r\n")
    assert lines[0] == "IESNA:LM-63-2002"
    assert max(map(len, lines)) <= 130
    assert lines[-1] == ""
    assert "2 1000 1 3 1 1 2 -0.2 -0.2 0" in lines
    assert "1 1 10" in lines
    file = parsed(data)
    assert file.remarks == ()
    assert file.metadata["TEST"] == "7"
    assert file.metadata["LUMINAIRE"].replace("\n", " ") == ("grun " * 60).strip()
    assert file.metadata["OTHER"] == "stray"
    assert file.metadata["MANUFAC"] == "not stated"
    assert file.tilt.factors.tolist() == [1, 0.5]
    assert file.stated_flux == 2000.0


def test_keys_of_other_formats_become_keywords_of_the_user():
    file = replace(parsed(PLAIN), format="EULUMDAT", metadata={"report no.": "12", "LUMCAT": "A]1"})
    written = parsed(write_lm63(file)).metadata
    assert written["_REPORT_NO."] == "12"
    assert written["LUMCAT"] == "A]1"


def ring(symmetry):
    """A distribution all around with a symmetry, as a function of the azimuth."""
    azimuth = np.arange(0.0, 361.0, 30.0)
    c = np.radians(azimuth)
    shape = {
        "rotational": np.ones_like(c),
        "quadrant": 2.0 + np.cos(2 * c),
        "C0-C180": 2.0 + np.cos(c),
        "C90-C270": 2.0 + np.sin(c),
        "none": 2.0 + np.cos(c - 0.4),
    }[symmetry]
    polar = np.radians([0.0, 30.0, 60.0, 90.0])
    return IntensityDistribution(c, polar, np.outer(shape, np.sin(2 * polar) + 1e-16) * 100)


@pytest.mark.parametrize(
    ("symmetry", "planes"),
    [("rotational", 1), ("quadrant", 4), ("C0-C180", 7), ("C90-C270", 13), ("none", 13)],
)
def test_no_more_planes_are_written_than_symmetry_asks_for(symmetry, planes):
    file = replace(parsed(PLAIN), distribution=ring(symmetry))
    written = parsed(write_lm63(file))
    assert len(written.stored_azimuths) == planes
    assert written.symmetry == ("none" if symmetry == "C90-C270" else symmetry)
    assert flux(written.distribution) == pytest.approx(flux(file.distribution), rel=1e-8)


@pytest.mark.parametrize("turn", [0.0, 30.0, 90.0, 101.5, -170.0])
@pytest.mark.parametrize("mirror", [False, True])
def test_a_turned_or_mirrored_distribution_is_written_as_it_shines(turn, mirror):
    distribution = turned(ring("none"), math.radians(turn))
    distribution = mirrored(distribution) if mirror else distribution
    written = parsed(write_lm63(replace(parsed(PLAIN), distribution=distribution))).distribution
    assert np.array_equal(written.frame, np.eye(3))
    directions = np.random.default_rng(1).normal(size=(2000, 3))
    expected = intensity(distribution, directions)
    assert intensity(written, directions) == pytest.approx(expected, abs=1e-6 * expected.max())


@pytest.mark.parametrize("kind", [2, 3])
@pytest.mark.parametrize("half", [False, True])
def test_types_a_and_b_are_written_as_such(kind, half):
    rows = table_ab(kind)
    horizontal = HORIZONTAL[2:] if half else HORIZONTAL
    file = parsed(
        made(
            kind=kind,
            size=".2 -.5 -.1",
            vertical=" ".join(map(str, VERTICAL)),
            horizontal=" ".join(map(str, horizontal)),
            candela=rows[2:] if half else rows,
        )
    )
    for change in (lambda d: d, mirrored, lambda d: turned(d, math.pi / 2)):
        source = replace(file, distribution=change(file.distribution))
        written = parsed(write_lm63(source))
        # A quarter turn about the beam makes one of them the other.
        is_same = not np.allclose(
            source.distribution.frame[:, 2] @ file.distribution.frame[:, 2], 0
        )
        assert (written.photometric_type == file.photometric_type) == is_same
        directions = np.random.default_rng(1).normal(size=(2000, 3))
        expected = intensity(source.distribution, directions)
        assert intensity(written.distribution, directions) == pytest.approx(expected, abs=1e-3)
        assert (written.symmetry == "C90-C270") == (half and is_same)
    written = parsed(write_lm63(file))
    assert written.opening == file.opening
    assert written.stored_polars.tolist() == file.stored_polars.tolist()


def test_a_type_that_lm63_cannot_say_is_not_written():
    file = parsed(made(kind=2, vertical="-90 0 90", horizontal="0 90", candela=["1 2 3"] * 2))
    with pytest.raises(LumenrayError, match="turned about another axis"):
        write_lm63(replace(file, distribution=turned(file.distribution, 0.3)))


# ---- files of others --------------------------------------------------------------------------


def shared_ies(name):
    path = DATA / "ies" / name
    if not path.exists():
        pytest.skip(f"needs the test file {name} in ../shared/data/ies")
    return path


def published_lumens():
    path = DATA / "cal" / "cu_ies_summary.md"
    if not path.exists():
        return []
    rows = re.findall(r"^\| (\d)\.ies +\|(?:[^|]*\|){6} +([\d.]+) ", path.read_text(), re.MULTILINE)
    return [(f"cu_{number}.IES", float(lumens)) for number, lumens in rows]


@pytest.mark.skipif(not published_lumens(), reason="needs ../shared/data/cal/cu_ies_summary.md")
@pytest.mark.validation
def test_fluxes_agree_with_the_published_ones():
    assert len(published_lumens()) == 8
    for name, lumens in published_lumens():
        file = read_lm63(shared_ies(name))
        assert flux(file.distribution) == pytest.approx(lumens, rel=0.0015), name


@pytest.mark.parametrize(
    ("first", "second", "turn"),
    [
        ("luxpy_Isym2.ies", "luxpy_Isym2_rot_H90-270.IES", 90.0),
        ("eul_MAXWELL_MEASURED_CIE.IES", "eul_MAXWELL_MEASURED_IESNA.ies", 90.0),
        ("lib_007cfb11e343e2f42e3b476be4ab684e.ies", "luxpy_Isym1_007cfb11.ies", 0.0),
    ],
)
@pytest.mark.validation
def test_twins_are_the_same_luminaire_turned(first, second, turn):
    first, second = read_lm63(shared_ies(first)), read_lm63(shared_ies(second))
    directions = np.random.default_rng(2).normal(size=(5000, 3))
    expected = intensity(first.distribution, directions)
    found = intensity(turned(second.distribution, math.radians(turn)), directions)
    assert found == pytest.approx(expected, abs=1e-4 * expected.max())
