"""IES LM-63 as it is read: every edition, tilt and lamp, and the fluxes that others published."""

import math
import re

import numpy as np
import pytest
from folders import WILD
from lm63_files import FIRST_LINES, HEAD_2002, candela, made, parsed, words

from lumenray.engine.errors import FileFormatError
from lumenray.engine.luminaires.distribution import flux, intensity, turned
from lumenray.engine.luminaires.formats.lm63.reader import GENERATION_TYPE
from lumenray.engine.luminaires.formats.reader import read_luminaire
from lumenray.engine.scene.distribution import Opening

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


def test_a_tilt_file_is_read_only_inside_the_folder(tmp_path):
    folder = tmp_path / "luminaires"
    folder.mkdir()
    for path in (folder / "lamp.tlt", tmp_path / "secret.tlt"):
        path.write_text("2\n2\n0 90\n1 0.5\n")
    (folder / "link.tlt").symlink_to(tmp_path / "secret.tlt")
    named = made(FIRST_LINES[1995], "TILT=lamp.tlt")
    path = folder / "lamp.ies"
    path.write_text(named)
    file = read_luminaire(path)
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


def shared_ies(name):
    path = WILD / "ies" / name
    if not path.exists():
        pytest.skip(f"needs the test file {name} in ../shared/data/ies")
    return path


def published_lumens():
    path = WILD / "cal" / "cu_ies_summary.md"
    if not path.exists():
        return []
    rows = re.findall(r"^\| (\d)\.ies +\|(?:[^|]*\|){6} +([\d.]+) ", path.read_text(), re.MULTILINE)
    return [(f"cu_{number}.IES", float(lumens)) for number, lumens in rows]


@pytest.mark.skipif(not published_lumens(), reason="needs ../shared/data/cal/cu_ies_summary.md")
@pytest.mark.validation
def test_fluxes_agree_with_the_published_ones():
    assert len(published_lumens()) == 8
    for name, lumens in published_lumens():
        file = read_luminaire(shared_ies(name))
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
    first, second = read_luminaire(shared_ies(first)), read_luminaire(shared_ies(second))
    directions = np.random.default_rng(2).normal(size=(5000, 3))
    expected = intensity(first.distribution, directions)
    found = intensity(turned(second.distribution, math.radians(turn)), directions)
    assert found == pytest.approx(expected, abs=1e-4 * expected.max())
