"""Coated surfaces of SPEOS (.coated, .bsdf180): what is reflected as by a mirror and what passes, both polarisations."""

import re

import numpy as np

from ...photometry.spectra import GRID, luminous_efficiency
from ...reading.blocks import Blocks
from ...reading.remarks import Remark
from ...reading.text import decode_text
from ...reading.words import Words
from ..data.record import ScatteringFile
from .checks import MOST_LIGHT
from .mixtures import direct_table

MOST_INCIDENCES, MOST_BANDS = 10_000, 2_000

MOST_TEXT = 100_000
"""Characters of a comment."""

_COATED = re.compile(rb"OPTIS - Coated surface file v2\n")


def read_coated(data: bytes, path, *_) -> ScatteringFile:
    """Read per cent reflected and transmitted of one side: a pair for each wavelength, a row for each polarisation."""
    words = Words(data, path)
    words.read_line()
    name = words.read_line()
    count = words.whole("the number of angles of incidence", 1, MOST_INCIDENCES)
    bands = words.whole("the number of wavelengths", 1, MOST_BANDS)
    wavelengths = words.rising(bands, "wavelengths", 100.0, 1e5)
    rows = words.numbers(count * (1 + 4 * bands), "reflectances and transmittances")
    rows = rows.reshape(count, -1)
    words.end()
    incidences = _check_incidences(words, rows[:, 0])
    pairs = _check_shares(words, rows[:, 1:].reshape(count, 2, bands, 2))
    halves = pairs.mean(axis=1)
    sides = {
        "front_reflection": direct_table(incidences, wavelengths, halves[..., 0]),
        "front_transmission": direct_table(incidences, wavelengths, halves[..., 1]),
    }
    return _file(path, "SPEOS coated surface", sides, name, incidences)


def read_two_sides(data: bytes, path, at: int, *_) -> ScatteringFile:
    """Read a file that holds coated surfaces of both sides, in compressed blocks.

    After a text stand two marks for the sides, then for each side a file of its own: a first line, the number 3, a name, the
    numbers of angles and of wavelengths, blocks of both, and blocks of percentages for reflection and for transmission, of
    either polarisation one.
    """
    blocks = Blocks(data, path, at)
    _read_text(blocks)
    marks = [blocks.whole("the mark of a side", 0, 1) for _ in range(2)]
    sides, names, incidences = {}, [], np.zeros(0)
    for side in [name for name, mark in zip(("front", "back"), marks, strict=True) if mark]:
        found = _COATED.match(data, blocks.at)
        if found is None:
            blocks.fail(
                "holds another kind of surface than 'Coated surface file v2'; export each side by itself"
            )
        blocks.at = found.end()
        blocks.whole("the mark before a name", 3, 3)
        names.append(_read_text(blocks))
        count = blocks.whole("the number of angles of incidence", 1, MOST_INCIDENCES)
        bands = blocks.whole("the number of wavelengths", 1, MOST_BANDS)
        wavelengths = blocks.zlib_numbers(bands, "wavelengths")
        if (
            wavelengths.min() < 100.0
            or wavelengths.max() > 1e5
            or (np.diff(wavelengths) <= 0).any()
        ):
            blocks.fail("has wavelengths that do not ascend within 100 to 100000 nm")
        angles = _check_incidences(blocks, blocks.zlib_numbers(count, "angles of incidence"))
        shares = np.stack([blocks.zlib_numbers(count * bands, "shares") for _ in range(4)])
        shares = _check_shares(
            blocks, shares.reshape(2, 2, count, bands).transpose(2, 1, 3, 0)
        ).mean(axis=1)
        for k, kind in enumerate(("reflection", "transmission")):
            sides[f"{side}_{kind}"] = direct_table(angles, wavelengths, shares[..., k])
        incidences = incidences if incidences.size else angles
    if not sides:
        blocks.fail("holds no side")
    return _file(path, "SPEOS BSDF180", sides, " / ".join(names), incidences)


def _read_text(blocks: Blocks) -> str:
    count = blocks.whole("the length of a text", 0, MOST_TEXT)
    found = blocks.zlib_block("a text")
    if len(found) != count:
        blocks.fail(f"has a text of {len(found)} bytes, expected {count}")
    return decode_text(found).strip()


def _check_incidences(source: Words | Blocks, degrees: np.ndarray) -> np.ndarray:
    """Angles of incidence. [degree -> rad]"""
    if degrees.min() < 0.0 or degrees.max() > 90.0 + 1e-6 or (np.diff(degrees) <= 0.0).any():
        source.fail("has angles of incidence that do not ascend within 0 to 90 degrees")
    return np.radians(np.minimum(degrees, 90.0))


def _check_shares(source: Words | Blocks, percents: np.ndarray) -> np.ndarray:
    """Shares (s, polarisation, w, kind) that are none of too much light. [per cent -> -]"""
    if percents.min() < -1e-3 or percents.sum(axis=-1).max() > 100.0 * MOST_LIGHT:
        source.fail(
            f"has shares from {percents.min():g} per cent and up to {percents.sum(axis=-1).max():g} of "
            "reflection and transmission together, expected 0 to 100"
        )
    return np.clip(0.01 * percents, 0.0, 1.0)


def _by_eye(table) -> np.ndarray:
    """Direct shares of all incidences as the eye weighs them at equal energy. (s,)"""
    weight = luminous_efficiency()
    shares = [np.interp(GRID, table.wavelengths, row) @ weight for row in table.direct[0]]
    return np.array(shares) / weight.sum()


def _file(path, kind: str, sides: dict, name: str, incidences) -> ScatteringFile:
    told = {
        side: _by_eye(table)
        for side, table in sides.items()
        if np.array_equal(table.incidences, incidences)
    }
    return ScatteringFile(
        path,
        kind,
        sides,
        name=name,
        incidences=incidences,
        stated=told,
        remarks=(
            Remark(
                "the mean of both polarisations is kept; light that passes goes on straight, as through a "
                "thin pane"
            ),
        ),
    )
