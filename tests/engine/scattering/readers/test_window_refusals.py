"""Files that are no WINDOW XML, or broken: each is refused with the place and what was expected."""

from dataclasses import replace

import numpy as np
import pytest
from window_files import (
    GRID,
    KLEMS_FULL,
    SMALL_BASIS,
    basis,
    block,
    klems,
    read_window,
    tree,
    window_xml,
)

from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.scattering.data.patches import check_patches
from lumenray.engine.scattering.data.tree import check_tree
from lumenray.engine.scattering.readers.window_xml import is_window_xml


def test_other_files_are_told_apart():
    assert is_window_xml(klems("Reflection Back", "0"))
    assert is_window_xml(klems("Reflection Back", "0").decode().encode("utf-16"))
    for other in (b"<IESTM33-22></IESTM33-22>", b"IESNA:LM-63-2002", b"", b"<WindowElements>"):
        assert not is_window_xml(other)


FULL = (KLEMS_FULL, KLEMS_FULL)

BAD = {
    "begins with the element 'Window'": (b"<Window/>", 1),
    "no Optical/Layer": (b"<WindowElement/>", 1),
    "template without data": (window_xml("Columns"), 3),
    "IncidentDataStructure 'pyramids'": (window_xml("Pyramids", block("Reflection Back", "1")), 5),
    "'NIR', expected Visible or Solar": (
        window_xml("Columns", block("Reflection Back", "1", FULL, "NIR")),
        3,
    ),
    "'Reflection Back' twice": (
        window_xml("Columns", *[block("Reflection Back", "1", FULL)] * 2),
        13,
    ),
    "neither Transmission nor Reflection": (klems("Absorption Front", "1"), 3),
    "has no ScatteringData for Reflection Back": (klems("Reflection Back", " "), 7),
    "has 2 values of Reflection Back, expected 145 rows of 145": (
        klems("Reflection Back", "0 1"),
        9,
    ),
    "has more values of": (klems("Reflection Back", "0 " * 21026), 9),
    "has 'n' among ScatteringData": (klems("Reflection Back", "0 1\n0 nan"), 11),
    "has '1e99'": (klems("Reflection Back", "0 1\n1e99 " + "0 " * 21022), 11),
    "has '1.2.3'": (klems("Reflection Back", "1.2.3 " + "0 " * 21024), 10),
    "ColumnAngleBasis 'Tregenza', which it does not define": (
        klems("Reflection Back", "0", "Tregenza"),
        8,
    ),
    "a ring with 5 patches": (
        window_xml(
            "Columns",
            block("Reflection Back", "0 " * 36, ("Odd", "Odd")),
            bases=basis("Odd", ((0, 45, 1), (45, 90, 5))),
        ),
        None,
    ),
    "a ring from 31 to 60 degrees": (
        window_xml(
            "Columns",
            block("Reflection Back", "0", FULL),
            bases=basis("Gap", ((0, 30, 1), (31, 60, 4), (60, 90, 4))),
        ),
        7,
    ),
    "rings end at 80 degrees": (
        window_xml(
            "Columns",
            block("Reflection Back", "0", FULL),
            bases=basis("Short", ((0, 30, 1), (30, 80, 4))),
        ),
        5,
    ),
    "has the nPhis 4e+09": (
        window_xml(
            "Columns",
            block("Reflection Back", "0", FULL),
            bases=basis("Huge", ((0, 30, 1), (30, 90, 4_000_000_000))),
        ),
        7,
    ),
    "has the nPhis '1_0', expected a number": (
        window_xml(
            "Columns",
            block("Reflection Back", "0", FULL),
            bases=SMALL_BASIS.replace("<nPhis>4<", "<nPhis>1_0<"),
        ),
        7,
    ),
    "expected LBNL/Shirley-Chiu": (
        tree("Reflection Back", "{ 1 }").replace(b"Shirley-Chiu", b"Square"),
        7,
    ),
    "3 values in braces, expected a power of 16": (tree("Reflection Back", "{ 1 2 3 }"), 10),
    "2 branches in braces, expected 16": (tree("Reflection Back", "{ { 1 } { 2 } }"), 10),
    "0 branches in braces": (tree("Reflection Back", "{ }"), 10),
    "braces do not close": (tree("Reflection Back", "{ { 1 }"), 9),
    "a closing brace without": (tree("Reflection Back", "} { 1 }"), 10),
    "something after the last brace": (tree("Reflection Back", "{ 1 }\n{ 2 }"), 11),
    "numbers beside braces": (tree("Reflection Back", "{ { 1 }\n 2 }"), None),
    "nested deeper than 16 levels": (tree("Reflection Back", "{" * 100_000), 10),
    "DOCTYPE": (b"<!DOCTYPE w [<!ENTITY a 'b'>]><WindowElement>&a;</WindowElement>", 1),
}


@pytest.mark.parametrize("told", BAD)
def test_refusals_name_the_place_and_what_was_expected(told):
    data, line = BAD[told]
    with pytest.raises(FileFormatError) as caught:
        read_window(data)
    message = str(caught.value)
    assert told in message
    assert "\n" not in message
    assert line is None or caught.value.line == line


def test_text_that_is_no_xml_is_refused():
    with pytest.raises(FileFormatError, match="not well-formed"):
        read_window(b"Pane of glass")


def test_too_deep_trees_of_branches_and_grids_are_refused():
    rest = " { 0 }" * 7
    deep = "{ 1 2 3 4 5 6 7 8 }"
    for _ in range(16):
        deep = "{" + deep + rest + "}"
    with pytest.raises(FileFormatError, match="deeper than 16"):
        read_window(tree("Reflection Back", deep, 3))


def test_matrices_and_trees_that_break_their_rules_are_refused():
    matrix = read_window(klems("Reflection Front", np.ones((145, 145))), "front_reflection")
    rings = matrix.incoming
    for change, told in (
        ({"values": matrix.values[:-1]}, "shape"),
        ({"values": -matrix.values}, "negative"),
        ({"wavelengths": np.zeros(0)}, "no wavelength"),
        ({"incoming": replace(rings, bounds=rings.bounds[::-1])}, "ascend"),
        ({"incoming": replace(rings, bounds=rings.bounds * 0.9)}, "horizon"),
        ({"incoming": replace(rings, counts=rings.counts * 0)}, "without patches"),
        ({"incoming": replace(rings, counts=rings.counts[1:])}, "one polar angle more"),
    ):
        with pytest.raises(SceneError, match=told):
            check_patches(replace(matrix, **change))
    found = read_window(tree("Reflection Front", f"{{ {GRID} }}"), "front_reflection")
    for change, told in (
        ({"rank": 5}, "rank 5"),
        ({"rank": 3}, "8 children"),
        ({"values": found.values[:3]}, "does not have"),
        ({"values": -found.values}, "negative"),
        ({"children": np.zeros_like(found.children)}, "hangs"),
        ({"wavelengths": np.array([np.nan])}, "no number"),
    ):
        with pytest.raises(SceneError, match=told):
            check_tree(replace(found, **change))
