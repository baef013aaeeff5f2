"""Tables of scattering of SPEOS (.anisotropicbsdf, .brdf): angles about the normal, as text or in LZ4 blocks.

Values are taken as relative and brought to the per cent that a file states for its spectrum or for each table: values that
SPEOS's own converter makes of BRDFs come out pi times larger.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...reading.blocks import Blocks
from ...reading.remarks import Remark
from ...reading.words import Words
from ..data.record import ScatteringFile
from .checks import shares_of, tell_excess, tell_missing, tell_negative, tell_scaling
from .colour import ANY_WAVELENGTH
from .slices import Slice, SliceFan, choose_fan, slice_about_light, turn_up

MOST_TEXT = 100_000
"""Characters of a description."""

MOST_ROTATIONS, MOST_INCIDENCES, MOST_BANDS = 720, 1000, 500

MOST_TABLES = 10_000
"""Of a side."""

MOST_ANGLES, MOST_NODES, MOST_VALUES = 10_000, 300_000, 50_000_000
"""Of one table: angles of either kind and values; values of all."""

MOST_PERCENT = 1000.0
"""A stated total may be so large to be read at all."""

MIRRORS = (0.0, np.pi)
"""Azimuths that the mirror direction may have, the likelier first. [rad]"""

BINARY_HEAD = bytes.fromhex("03000000 01000000 00000000 00000000 00")
"""What stands before the direction of anisotropy in a binary file without comments."""


@dataclass(frozen=True, eq=False)
class _Grid:
    """One table as it stands in a file: angles [rad], values (t, a)."""

    polars: np.ndarray
    azimuths: np.ndarray
    values: np.ndarray


@dataclass(frozen=True, eq=False)
class _Spectrum:
    """Totals [-] by wavelength [nm] for light from one direction. [rad]"""

    incidence: float
    rotation: float
    wavelengths: np.ndarray
    totals: np.ndarray


# ---- .anisotropicbsdf ----


def read_anisotropic(data: bytes, path, at: int, tolerance: float) -> ScatteringFile:
    """Read a table for several azimuths of the sample, with one spectrum. Version 8 to 11 as text, 9 in binary."""
    if data[at : at + 1] == b"1":
        return _read_binary(data, path, at + 1, tolerance)
    words = Words(data, path)
    words.read_line()
    words.whole("the mark of text (0) or binary (1)", 0, 0)
    comment = words.read_line()
    description = words.read_characters(words.whole("the length of the description", 0, MOST_TEXT))
    words.numbers(3, "the direction of anisotropy")
    kinds = _read_kinds(words)
    is_intensity = words.whole("the mark of BSDF (1) or intensity (0)", 0, 1) == 0
    read, remarks, size = {}, [], 0
    for side in kinds:
        turns, angles = _read_directions(words)
        spectrum = _read_spectrum(words)
        grids = []
        for some in angles:
            grids.append([])
            for _ in some:
                grids[-1].append(_read_grid(words))
                size += grids[-1][-1].values.size
                if size > MOST_VALUES:
                    words.fail(f"has more than {MOST_VALUES} values")
        read[side] = turns, angles, spectrum, grids
    words.end()
    if len(kinds) > 1:
        remarks.append(
            Remark("holds reflection and transmission, taken to stand one after the other")
        )
    return _make_anisotropic(words, read, is_intensity, comment, description, remarks, tolerance)


def _read_kinds(words: Words) -> list[str]:
    """Sides by the two marks of reflection and of transmission."""
    marks = [words.whole(f"the mark of {kind}", 0, 1) for kind in ("reflection", "transmission")]
    if not any(marks):
        words.fail("states that it holds neither reflection nor transmission")
    names = ("front_reflection", "front_transmission")
    return [name for name, mark in zip(names, marks, strict=True) if mark]


def _read_directions(words: Words) -> tuple[np.ndarray, list[np.ndarray]]:
    """Azimuths of incidence, and the angles of incidence of each."""
    count = words.whole("the number of anisotropy angles", 1, MOST_ROTATIONS)
    turns = words.angles(count, "anisotropy angles", 360.0)
    angles = []
    for _ in range(count):
        number = words.whole("the number of angles of incidence", 1, MOST_INCIDENCES)
        angles.append(words.angles(number, "angles of incidence", 90.0))
    _check_tables(words, sum(map(len, angles)))
    return turns, angles


def _read_spectrum(words: Words) -> _Spectrum:
    incidence = words.number("the angle of incidence of the spectrum", 0.0, 90.0)
    rotation = words.number("the anisotropy angle of the spectrum", -360.0, 360.0)
    # A comment, mostly empty, has a line of its own.
    words.read_line()
    count = words.whole("the number of wavelengths", 1, MOST_BANDS)
    pairs = words.numbers(2 * count, "wavelengths and totals").reshape(count, 2)
    return _check_spectrum(words, incidence, rotation, pairs[:, 0], pairs[:, 1])


def _check_spectrum(source: Words | Blocks, incidence, rotation, wavelengths, percents):
    if np.any(np.diff(wavelengths) <= 0.0) or wavelengths[0] < 100.0 or wavelengths[-1] > 1e5:
        source.fail("has wavelengths that do not ascend within 100 to 100000 nm")
    if percents.min() < 0.0 or percents.max() > MOST_PERCENT:
        source.fail(
            f"has totals from {percents.min():g} to {percents.max():g} per cent, expected 0 to 100"
        )
    return _Spectrum(np.radians(incidence), np.radians(rotation), wavelengths, 0.01 * percents)


def _read_grid(words: Words) -> _Grid:
    polars = words.whole("the number of polar angles", 1, MOST_ANGLES)
    azimuths = words.whole("the number of azimuths", 1, MOST_ANGLES)
    _check_size(words, polars, azimuths)
    across = words.angles(azimuths, "azimuths", 360.0)
    rows = words.numbers(polars * (azimuths + 1), "values").reshape(polars, azimuths + 1)
    return _check_grid(words, rows[:, 0], across, rows[:, 1:])


def _check_tables(source: Words | Blocks, count: int) -> None:
    if count > MOST_TABLES:
        source.fail(f"states {count} tables of a side, expected at most {MOST_TABLES}")


def _check_size(source: Words | Blocks, polars: int, azimuths: int) -> None:
    if polars * azimuths > MOST_NODES:
        source.fail(
            f"states {polars * azimuths} values in a table, expected at most {MOST_NODES}; thin it out"
        )


def _check_grid(source: Words | Blocks, degrees, azimuths, values) -> _Grid:
    if np.any(np.diff(degrees) <= 0.0) or degrees[0] < 0.0 or degrees[-1] > 180.0 + 1e-6:
        source.fail("has polar angles that do not ascend within 0 to 180 degrees")
    return _Grid(np.radians(degrees), azimuths, values)


def _read_binary(data: bytes, path, at: int, tolerance: float) -> ScatteringFile:
    """Read the binary form, as far as it is known: without comments, with reflection only.

    Before every array stand its size, and for each block of it the size and the compressed size; whatever follows the last
    table is not known, and is left out.
    """
    blocks = Blocks(data, path, at)
    if blocks.take(len(BINARY_HEAD), "the head") != BINARY_HEAD:
        blocks.fail("has a binary head that is not known; export the file in text mode")
    blocks.numbers(3, "the direction of anisotropy")
    if blocks.take(2, "the marks of sides") != b"\x01\x00":
        blocks.fail(
            "holds transmission in binary form, which is not known; export the file in text mode"
        )
    blocks.numbers(2, "factors")
    is_intensity = blocks.take(2, "the mark of intensity") == b"\x00\x00"
    count = blocks.whole("the number of anisotropy angles", 1, MOST_ROTATIONS)
    turns = _check_angles(blocks, blocks.lz4_numbers(count, "anisotropy angles"), 360.0)
    angles = []
    for _ in range(count):
        number = blocks.whole("the number of angles of incidence", 1, MOST_INCIDENCES)
        found = blocks.lz4_numbers(number, "angles of incidence")
        angles.append(_check_angles(blocks, found, 90.0))
    _check_tables(blocks, sum(map(len, angles)))
    incidence, rotation = blocks.numbers(2, "the direction of the spectrum")
    blocks.take(blocks.whole("the length of a comment", 0, MOST_TEXT), "a comment")
    bands = blocks.whole("the number of wavelengths", 1, MOST_BANDS)
    wavelengths = blocks.numbers(bands, "wavelengths")
    totals = blocks.numbers(bands, "totals")
    spectrum = _check_spectrum(blocks, incidence, rotation, wavelengths, totals)
    grids = [[_read_binary_grid(blocks) for _ in some] for some in angles]
    read = {"front_reflection": (turns, angles, spectrum, grids)}
    return _make_anisotropic(blocks, read, is_intensity, "", "", [], tolerance)


def _read_binary_grid(blocks: Blocks) -> _Grid:
    polars = blocks.whole("the number of polar angles", 1, MOST_ANGLES)
    azimuths = blocks.whole("the number of azimuths", 1, MOST_ANGLES)
    _check_size(blocks, polars, azimuths)
    down = blocks.lz4_numbers(polars, "polar angles")
    across = _check_angles(blocks, blocks.lz4_numbers(azimuths, "azimuths"), 360.0)
    values = blocks.lz4_numbers(polars * azimuths, "values").reshape(polars, azimuths)
    return _check_grid(blocks, down, across, values)


def _check_angles(blocks: Blocks, degrees: np.ndarray, highest: float) -> np.ndarray:
    """Angles that ascend. [degree -> rad]"""
    if np.any(np.diff(degrees) <= 0.0) or degrees[0] < 0.0 or degrees[-1] > highest + 1e-6:
        blocks.fail(f"has angles that do not ascend within 0 to {highest:g} degrees")
    return np.radians(np.minimum(degrees, highest))


def _make_anisotropic(
    source, read, is_intensity, comment, description, remarks, tolerance
) -> ScatteringFile:
    sides, stated, incidences = {}, {}, np.zeros(0)
    for side, (turns, angles, spectrum, grids) in read.items():
        fan, more = _fan(source, side, turns, angles, grids, is_intensity)
        fan, again = _unfold(fan, np.degrees(turns[-1]))
        fan = _with_spectrum(source, fan, spectrum)
        sides[side] = fan.to_table(tolerance=tolerance)
        remarks += more + again + tell_missing(side, fan.steepest)
        remarks += tell_excess(side, shares_of(sides[side]))
        if not incidences.size:
            incidences = sides[side].incidences
        is_told = np.abs(incidences - spectrum.incidence) < 1e-6
        if is_told.any():
            stated[side] = np.where(is_told, spectrum.totals.mean(), np.nan)
    return ScatteringFile(
        source.path,
        "SPEOS anisotropic BSDF",
        sides,
        name=comment,
        description=description,
        incidences=incidences,
        stated=stated,
        remarks=tuple(remarks),
    )


def _fan(source, side, turns, angles, grids, is_intensity) -> tuple[SliceFan, list[Remark]]:
    """The tables of one side as slices, with remarks."""
    is_transmitted = side.endswith("transmission")
    negative = sum(int((grid.values < 0.0).sum()) for row in grids for grid in row)
    remarks = tell_negative(side, negative, sum(g.values.size for row in grids for g in row))
    halves = [[_half(source, grid, is_transmitted) for grid in row] for row in grids]

    def read(mirror: float) -> SliceFan | None:
        slices = [
            [
                slice_about_light(
                    each.polars,
                    each.azimuths + np.pi - mirror,
                    each.values[..., None],
                    is_intensity,
                )
                for each in row
            ]
            for row in halves
        ]
        if any(each is None for row in slices for each in row):
            return None
        return SliceFan(turns, tuple(angles), tuple(map(tuple, slices)), np.array([ANY_WAVELENGTH]))

    fan, number = choose_fan(read(mirror) for mirror in MIRRORS)
    if fan is None:
        source.fail("has azimuths that go neither all around nor from 0 to 180 degrees")
    if number:
        remarks.append(
            Remark(
                f"values of {side.replace('_', ' ')} are larger at the azimuth 180 degrees, where the mirror "
                "direction is taken to be"
            )
        )
    return fan, remarks


def _half(source, grid: _Grid, is_transmitted: bool) -> _Grid:
    polars, values = turn_up(grid.polars, np.maximum(grid.values, 0.0), is_transmitted)
    if not len(polars):
        source.fail("has no polar angle on the side of the reflection")
    return _Grid(polars, grid.azimuths, values)


def _unfold(fan: SliceFan, last: float) -> tuple[SliceFan, list[Remark]]:
    """Azimuths of the sample all around, from those up to the last one. [degree]"""
    first = fan.slices[0]
    if len(fan.rotations) == 1:
        return replace(fan, rotations=np.zeros(1)), []
    if all(
        len(row) == len(first)
        and np.array_equal(some, fan.incidences[0])
        and all(_is_alike(*pair) for pair in zip(row, first, strict=True))
        for row, some in zip(fan.slices, fan.incidences, strict=True)
    ):
        made = replace(fan, rotations=np.zeros(1), incidences=fan.incidences[:1], slices=(first,))
        return made, [Remark("has the same values at all anisotropy angles, so one is kept")]
    # In rounded degrees, so that what is mirrored onto a line falls on it.
    rows = dict(
        zip(
            np.degrees(fan.rotations).round(6),
            zip(fan.incidences, fan.slices, strict=True),
            strict=True,
        )
    )
    text = "the anisotropy angle is taken as the azimuth of the light from +x"
    for end in (90.0, 180.0):
        if last < end + 1e-6:
            for turn, (some, slices) in list(rows.items()):
                mirrored = tuple(each.mirrored() for each in slices)
                rows.setdefault(round(2.0 * end - turn, 6), (some, mirrored))
            text += f", values mirrored about {end:g} degrees"
            last = 2.0 * end
    turns = sorted(turn for turn in rows if turn < 360.0)
    made = replace(
        fan,
        rotations=np.radians(turns),
        incidences=tuple(rows[turn][0] for turn in turns),
        slices=tuple(rows[turn][1] for turn in turns),
    )
    return made, [Remark(text)]


def _is_alike(one: Slice, other: Slice) -> bool:
    return (
        np.array_equal(one.polars, other.polars)
        and np.array_equal(one.azimuths, other.azimuths)
        and np.array_equal(one.values, other.values)
    )


def _with_spectrum(source, fan: SliceFan, spectrum: _Spectrum) -> SliceFan:
    """The values brought to the totals of a spectrum in the direction that it is for."""
    away = np.abs((fan.rotations - spectrum.rotation + np.pi) % (2.0 * np.pi) - np.pi)
    row = int(np.argmin(away))
    totals = [each.total()[0] for each in fan.slices[row]]
    have = np.interp(spectrum.incidence, fan.incidences[row], totals)
    if have <= 0.0:
        source.fail("has no light for the direction of its spectrum")
    if np.ptp(spectrum.totals) == 0.0:
        return replace(fan, spectrum=spectrum.totals[:1] / have)
    return replace(fan, wavelengths=spectrum.wavelengths, spectrum=spectrum.totals / have)


# ---- .brdf ----


def read_brdf(data: bytes, path, at: int, tolerance: float) -> ScatteringFile:
    """Read a table for several wavelengths, with a total for each and each angle of incidence; reflection comes first."""
    words = Words(data, path)
    words.read_line()
    if words.whole("the mark of text (0) or binary (1)", 0, 1):
        words.fail("is in binary form, which is not known; export the file in text mode")
    comment = words.read_line()
    description = words.read_characters(words.whole("the length of the description", 0, MOST_TEXT))
    kinds = _read_kinds(words)
    is_intensity = words.whole("the mark of BSDF (1) or intensity (0)", 0, 1) == 0
    count = words.whole("the number of angles of incidence", 1, MOST_INCIDENCES)
    bands = words.whole("the number of wavelengths", 1, MOST_BANDS)
    _check_tables(words, count * bands)
    incidences = words.angles(count, "angles of incidence", 90.0)
    wavelengths = words.rising(bands, "wavelengths", 100.0, 1e5)
    sides, stated, scaled, remarks = {}, {}, {}, []
    if count > 1 and bands > 1:
        remarks.append(
            Remark("tables are taken to go through all wavelengths of each angle in turn")
        )
    size = 0
    for side in kinds:
        totals, grids = np.empty((1, count, bands)), []
        for place in np.ndindex(count, bands):
            totals[0][place] = 0.01 * words.number("a total in per cent", 0.0, MOST_PERCENT)
            grids.append(_read_grid(words))
            size += grids[-1].values.size
            if size > MOST_VALUES:
                words.fail(f"has more than {MOST_VALUES} values")
        angles = [incidences.repeat(bands)]
        flat, more = _fan(words, side, np.zeros(1), angles, [grids], is_intensity)
        slices = [flat.slices[0][k : k + bands] for k in range(0, count * bands, bands)]
        fan = SliceFan(
            np.zeros(1), (incidences,), (tuple(_join(some) for some in slices),), wavelengths
        )
        fan, scaled[side] = fan.brought_to(totals)
        sides[side] = fan.to_table(tolerance=tolerance)
        stated[side] = totals[0].mean(axis=-1)
        remarks += more + tell_scaling(side, scaled[side]) + tell_missing(side, fan.steepest)
        remarks += tell_excess(side, shares_of(sides[side]))
    words.end()
    return ScatteringFile(
        path,
        "SPEOS BRDF",
        sides,
        name=comment,
        description=description,
        incidences=incidences,
        stated=stated,
        factors=scaled,
        remarks=tuple(remarks),
    )


def _join(slices: tuple[Slice, ...]) -> Slice:
    """Slices of one wavelength each as one, on the angles of all."""
    polars = np.unique(np.concatenate([each.polars for each in slices]))
    azimuths = np.unique(np.concatenate([each.azimuths for each in slices]))
    values = [each.on(polars, azimuths).values for each in slices]
    return replace(
        slices[0], polars=polars, azimuths=azimuths, values=np.concatenate(values, axis=2)
    )
