"""Luminous openings of LM-63 files, by the table of each edition."""

import re

import numpy as np
import pytest
from lm63_files import FIRST_LINES, made, parsed, words

from lumenray.engine.scene.distribution import Opening

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
