"""The one door to all formats of luminaires: known by content, refused by name, written whole or not at all."""

import zipfile
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from folders import WILD

from lumenray.engine.errors import FileFormatError, LumenrayError
from lumenray.engine.luminaires.coordinates import directions
from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.luminaires.formats.reader import (
    parse_luminaire,
    read_luminaire,
    write_luminaire,
)

IES = b"IESNA:LM-63-2002\r\n[TEST] 1\r\nTILT=NONE\r\n1 -1 1 3 1 1 2 0 0 0\r\n1 1 10\r\n0 45 90\r\n0\r\n9 8 0\r\n"

LDT = "\r\n".join(
    (
        "A 1 1 1 0 3 45 R N L F D 100 0 50 80 0 0 0 0 0 100 3.2 1 0 1 -1 LED 1000 840 80 9"
        + 10 * " 0.5"
        + " 0 0 45 90 9 8 0"
    ).split()
).encode()

XML = (
    b"<IESTM33><Emitter><LuminousData><LuminousIntensity><AbsolutePhotometry>1</AbsolutePhotometry>"
    b'<IntData h="0" v="0">9</IntData><IntData h="0" v="45">8</IntData><IntData h="0" v="90">0</IntData>'
    b"</LuminousIntensity></LuminousData></Emitter></IESTM33>"
)


@pytest.mark.parametrize(
    ("data", "form"),
    [
        (IES, "LM-63-2002"),
        (b"\r\n" + IES.lower(), "LM-63-2002"),
        (IES[28:], "LM-63-1986"),
        (LDT, "EULUMDAT"),
        (b"\xef\xbb\xbf" + LDT, "EULUMDAT"),
        (LDT.replace(b"\r\n", b"\r\r\n"), "EULUMDAT"),
        (b"Company, TILT" + LDT, "EULUMDAT"),
        (XML, "TM-33-18"),
        (b"\n <!-- a -->" + XML, "TM-33-18"),
        (b"\xef\xbb\xbf" + XML, "TM-33-18"),
        (XML.decode().encode("utf-16"), "TM-33-18"),
        (LDT.decode().encode("utf-16"), "EULUMDAT"),
        (IES.decode().encode("utf-16-le"), "LM-63-2002"),
        (IES.decode().encode("utf-16-be"), "LM-63-2002"),
    ],
)
@pytest.mark.parametrize("name", ["a.ies", "a.ldt", "a.xml", "a"])
def test_the_format_is_told_by_the_content(data, form, name):
    file = parse_luminaire(data, name)
    assert file.format == form
    assert intensity(file.distribution, [1.0, 0.0, -1.0]) == pytest.approx(8.0)


def archive(name):
    content = BytesIO()
    with zipfile.ZipFile(content, "w") as file:
        file.writestr(name, "x")
    return content.getvalue()


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "is empty"),
        (b"\xef\xbb\xbf \r\n\x1a", "is empty"),
        (b"\0" * 999, "is empty"),
        (archive("product.xml"), "is a GLDF container"),
        (archive("lamp.ldt"), "is a zip archive"),
        (b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 9, "is a binary file"),
        (b"<!DOCTYPE html><html>", "is a web page"),
        (b"\n<HTML><body>404", "is a web page"),
        (b"<gltf/>", "root element gltf"),
        (b"CIEF=1\nIDNM=x", "CIE 102"),
        (b"CENF=1\nIDNM=x", "CIE 102"),
        (b"CIBSE TM14\n1", "CIBSE TM14"),
        (b"Dear Sir,\nplease find no luminaire\n", "is no luminaire, expected IES LM-63"),
        (b'{"intensity": 1}', "is no luminaire"),
    ],
)
def test_what_is_no_luminaire_is_refused_by_its_name(data, words):
    with pytest.raises(FileFormatError, match=words) as caught:
        parse_luminaire(data, "a.dat")
    assert str(caught.value).startswith("a.dat")


@pytest.mark.parametrize(("name", "words", "line"), [("a.ldt", "Isym", 3), ("a.ies", "TILT", None)])
def test_a_broken_head_is_explained_in_the_terms_of_the_ending(name, words, line):
    lines = LDT.split(b"\r\n")
    lines[2:6] = [b"x", b"y", b"z", b"u"]
    with pytest.raises(FileFormatError, match=words) as caught:
        parse_luminaire(b"\r\n".join(lines), name)
    assert line is None or caught.value.line == line


def test_files_that_cannot_be_opened_or_are_huge_are_refused(tmp_path):
    with pytest.raises(FileFormatError, match="cannot be opened"):
        read_luminaire(tmp_path / "none.ies")
    huge = tmp_path / "huge.ies"
    with huge.open("wb") as file:
        file.truncate(1 << 30)
    with pytest.raises(FileFormatError, match="has 1024 MiB"):
        read_luminaire(huge)


# ---- writing ----


@pytest.mark.parametrize("data", [IES, LDT, XML])
@pytest.mark.parametrize("ending", [".ies", ".ldt", ".LDT"])
def test_each_format_converts_to_each(tmp_path, data, ending):
    file = parse_luminaire(data, "a")
    path = tmp_path / f"b{ending}"
    write_luminaire(file, path)
    back = read_luminaire(path)
    assert intensity(back.distribution, [1.0, 0.0, -1.0]) == pytest.approx(8.0, rel=1e-5)
    assert back.opening.shape == file.opening.shape
    assert back.opening.size == pytest.approx(file.opening.size, abs=1e-6)
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_what_a_format_cannot_keep_is_said(tmp_path):
    file = parse_luminaire(XML, "a")
    file = replace(file, spectrum=(np.array([400.0, 700.0]), np.ones(2)))
    (remark,) = write_luminaire(file, tmp_path / "a.ldt")
    assert "spectrum" in remark.text


def test_another_ending_is_refused(tmp_path):
    with pytest.raises(FileFormatError, match=r"'\.xml' is no format, expected \.ies or \.ldt"):
        write_luminaire(parse_luminaire(IES, "a"), tmp_path / "a.xml")


def test_a_luminaire_that_a_format_refuses_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.ldt"
    path.write_bytes(b"old")
    file = parse_luminaire(IES, "a")
    dark = replace(file.distribution, intensity=0.0 * file.distribution.intensity)
    with pytest.raises(LumenrayError):
        write_luminaire(replace(file, distribution=dark), path)
    assert path.read_bytes() == b"old"


# ---- real files ----


@pytest.mark.parametrize(
    "name", ["luxpy_Isym1_007cfb11", "luxpy_Isym2", "luxpy_Isym4_43cef5d7", "luxpy_test_lid_file"]
)
def test_both_files_of_a_luminaire_agree_in_every_direction(name):
    """C0 of EULUMDAT and 0 degrees of LM-63 are the same plane in these pairs, so there is no turn."""
    paths = WILD / "ldt" / f"{name}.ldt", WILD / "ies" / f"{name}.ies"
    if not all(path.exists() for path in paths):
        pytest.skip(f"{paths[0]} or {paths[1]} is absent")
    files = [read_luminaire(path) for path in paths]
    azimuth, polar = np.deg2rad(np.arange(0.0, 360.0, 2.5)), np.deg2rad(np.arange(0.0, 180.1, 2.5))
    direction = directions(azimuth[:, None], polar)
    first, second = (intensity(file.distribution, direction) for file in files)
    assert np.abs(first - second).max() < 0.005 * first.max()
    assert flux(files[0].distribution) == pytest.approx(flux(files[1].distribution), rel=2e-3)


REAL = sorted(
    path for kind in ("ies", "ldt") for path in (WILD / kind).rglob("*") if path.is_file()
)


@pytest.mark.parametrize("path", REAL, ids=lambda path: path.name)
def test_every_real_file_is_read_or_refused_with_a_reason(path):
    try:
        file = read_luminaire(path)
    except FileFormatError as error:
        assert len(str(error)) > len(str(path)) + 20
    else:
        assert 0.0 < flux(file.distribution) < 1e9
