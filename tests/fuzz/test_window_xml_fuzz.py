"""Damaged WINDOW XML: whatever stands in it, it is read or refused in one sentence, soon, and with little memory."""

import time

import numpy as np
import pytest
from memory import peak_memory
from mutations import mutate
from window_files import SMALL, SMALL_BASIS, SMALL_COUNT, basis, block, klems, tree, window_xml

from lumenray.engine.errors import FileFormatError
from lumenray.engine.scattering.data.patches import check_patches
from lumenray.engine.scattering.data.tree import check_tree
from lumenray.engine.scattering.readers.window_xml import is_window_xml, read_window_xml
from lumenray.engine.scene.scattering import PatchMatrix

ROUNDS = 400
"""Damages of every kind of file; with four kinds 1600."""

VALUES = np.random.default_rng(0).random((SMALL_COUNT, SMALL_COUNT)) * 0.3

PAIR = (SMALL, SMALL)

FILES = {
    "columns": window_xml(
        "Columns",
        block("Transmission Front", VALUES, PAIR),
        block("Reflection Back", VALUES, PAIR, "Solar"),
        block("Reflection Back", VALUES, PAIR),
        bases=SMALL_BASIS,
    ),
    "rows": window_xml("Rows", block("Transmission Back", VALUES, PAIR), bases=SMALL_BASIS),
    "tree of rank 3": tree(
        "Transmission Back", "{{ 0.1 0.2 0.3 0 0 0 0.1 0.2 }" + "{ 0.3 }" * 7 + "}", 3
    ),
    "tree of rank 4": tree(
        "Reflection Front", "{{ 0.1 " + "0.2, " * 15 + "}" + "\n{ 0.3 }" * 15 + "}"
    ),
}

MOST_MEMORY = 64 << 20
"""That damaged files of some kilobytes may make the process grow. [byte]"""


@pytest.mark.parametrize("name", FILES)
def test_damaged_files_are_read_or_refused(name):
    rng = np.random.default_rng(list(FILES).index(name))
    read, before = 0, peak_memory()
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        for _ in range(ROUNDS):
            data = mutate(FILES[name], rng)
            is_window_xml(data)
            try:
                file = read_window_xml(data, "pane.xml")
            except FileFormatError as error:
                assert "\n" not in str(error)
                continue
            read += 1
            assert file.sides
            for scatter in file.sides.values():
                (check_patches if isinstance(scatter, PatchMatrix) else check_tree)(scatter)
    assert peak_memory() - before < MOST_MEMORY
    # Both happen, or the damage is of the wrong size.
    assert 0 < read < ROUNDS


def entities(depth: int) -> bytes:
    """A document whose entities grow by ten with each level."""
    lines = "".join(
        f"<!ENTITY e{k} '{f'&e{k - 1};' * 10 if k else 'light'}'>" for k in range(depth)
    )
    return f"<!DOCTYPE w [{lines}]><WindowElement>&e{depth - 1};</WindowElement>".encode()


HOSTILE = {
    "braces that only open": tree("Reflection Back", "{" * 2_000_000),
    "braces that only close": tree("Reflection Back", "}" * 2_000_000),
    "empty braces": tree("Reflection Back", "{}" * 1_000_000),
    "braces as deep as they may": tree("Reflection Back", ("{" * 17 + "1}") * 100_000, 3),
    "too many values in braces": tree("Reflection Back", "{" + "1 " * 5_000_000 + "}"),
    "too many values of a matrix": klems("Reflection Back", "1 " * 5_000_000),
    "one endless number": klems("Reflection Back", "1" * 5_000_000),
    "huge nPhis": window_xml(
        "Columns",
        block("Reflection Back", "1", PAIR),
        bases=basis(SMALL, ((0, 90, 10**18),)),
    ),
    "nPhis that add up": window_xml(
        "Columns",
        block("Reflection Back", "1", PAIR),
        bases=basis(SMALL, [(k, k + 1, 5000) for k in range(90)]),
    ),
    "infinite nPhis": window_xml(
        "Columns",
        block("Reflection Back", "1", PAIR),
        bases=SMALL_BASIS.replace("<nPhis>4<", "<nPhis>1e999<"),
    ),
    "bases without values": window_xml(
        "Columns", block("Reflection Back", "1", PAIR), bases=basis(SMALL, ((0, 90, 10_000),))
    ),
    "entities that grow": entities(10),
    "an external entity": b"<!DOCTYPE w [<!ENTITY f SYSTEM 'file:///etc/hostname'>]><WindowElement>&f;</WindowElement>",
    "elements in elements": b"<WindowElement>" * 100_000,
    "long names": window_xml("C" * 100_000, block("R" * 100_000, "1", PAIR)),
    "a long root": b"<" + b"W" * 100_000 + b"/>",
    "bands by the thousand": window_xml(
        "Columns", *[block("Reflection Back", "1", PAIR, f"Band {k}" * 50) for k in range(2000)]
    ),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_are_refused_soon(name):
    start = time.monotonic()
    with pytest.raises(FileFormatError) as caught:
        read_window_xml(HOSTILE[name], "pane.xml")
    assert len(str(caught.value)) < 400
    assert "\n" not in str(caught.value)
    assert time.monotonic() - start < 10.0
