"""LM-63 as it is written."""

import math
from dataclasses import replace

import numpy as np
import pytest
from lm63_files import FIRST_LINES, HORIZONTAL, PLAIN, VERTICAL, made, parsed, table_ab

from lumenray.engine.errors import LumenrayError
from lumenray.engine.luminaires.distribution import flux, intensity, mirrored, turned
from lumenray.engine.luminaires.formats.lm63.writer import write_lm63
from lumenray.engine.scene.distribution import IntensityDistribution


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
