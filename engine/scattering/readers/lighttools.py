"""Tables of scattering of LightTools (.bsdf): text, angles about the normal."""

from dataclasses import dataclass

import numpy as np

from ...reading.remarks import Remark
from ...reading.words import Words
from ..data.record import ScatteringFile
from .checks import shares_of, tell_excess, tell_missing, tell_negative, tell_scaling
from .colour import ANY_WAVELENGTH
from .slices import SliceFan, choose_fan, slice_about_light, turn_up
from .zemax import MOST_ANGLES, MOST_NODES, MOST_TIS, MOST_VALUES

SIDES = {
    ("front", "brdf"): "front_reflection",
    ("back", "brdf"): "back_reflection",
    ("front", "btdf"): "front_transmission",
    ("back", "btdf"): "back_transmission",
}

LISTS = {"scatterazimuth": 360.0, "scatterradial": 180.0}
"""Keywords of lists of angles, and the largest of each. [degree]"""

WORDS = ("source", "symmetry", "spectralcontent", "scattertype", "side", "tristimulusvalue")
"""Keywords before a word."""

NUMBERS = {"aoi": (0.0, 90.0), "poi": (-360.0, 360.0), "wavelength": (0.0, 1e5)}
"""Keywords before a number, and its limits."""

MOST_BLOCKS, MOST_BANDS, MOST_PLANES = 10_000, 500, 720
"""In a file, and of one side."""

LIGHT = (90.0, 0.0, 270.0, 180.0)
"""Azimuths beyond the plane of incidence that light may come from, the likeliest first. [degree]"""

_HEAD = 1 << 16
"""How much of a file is looked at. [byte]"""


def is_lighttools(data: bytes) -> bool:
    """Whether a text has the keywords of such a table: angles of incidence one by one."""
    head = data[:_HEAD].lower().split()
    return b"aoi" in head and b"scatterradial" in head


@dataclass(frozen=True, eq=False)
class _Block:
    """One matrix of values, and what it is for."""

    side: str
    aoi: float
    poi: float
    wavelength: float
    tristimulus: str
    total: float
    polars: np.ndarray
    azimuths: np.ndarray
    values: np.ndarray


def read_lighttools(data: bytes, path, tolerance: float = 0.02) -> ScatteringFile:
    """Read a table. Values at several wavelengths become spectra; of X, Y and Z only Y is kept.

    Light comes from the azimuth of 90 degrees more than the plane of incidence (POI), unless values tell otherwise: of the
    readings of `LIGHT` the one counts by which the mirror direction is brightest.

    Raises
    ------
    FileFormatError    It is no such table; says what was found and expected, with the line.
    """
    words = Words(data, path, "#")
    head, blocks = _read(words)
    kept = [each for each in blocks if each.tristimulus in {"", "trisy", "y"}]
    if not kept:
        words.fail("has no values, or X and Z without Y")
    remarks, sides, stated, scaled, incidences = [], {}, {}, {}, np.zeros(0)
    for side in dict.fromkeys(each.side for each in kept):
        some = [each for each in kept if each.side == side]
        negative = sum(int((each.values < 0.0).sum()) for each in some)
        remarks += tell_negative(side, negative, sum(each.values.size for each in some))
        fan, totals, light = _fan(words, some)
        if light != LIGHT[0]:
            remarks.append(
                Remark(
                    f"{side.replace('_', ' ')} is brightest where light is taken to come from the azimuth "
                    f"of {light} degrees more than the plane of incidence, and is read so"
                )
            )
        fan, scaled[side] = fan.brought_to(totals)
        remarks += tell_scaling(side, scaled[side]) + tell_missing(side, fan.steepest)
        sides[side] = fan.to_table(tolerance=tolerance)
        remarks += tell_excess(side, shares_of(sides[side]))
        if not stated:
            incidences = fan.incidences[0]
        if np.array_equal(incidences, fan.incidences[0]):
            stated[side] = totals[0].mean(axis=-1)
    if len(kept) < len(blocks):
        remarks.append(
            Remark(
                "states X, Y and Z without the light that they are for; Y is kept as the same at all "
                "wavelengths, colour is left out"
            )
        )
    return ScatteringFile(
        path,
        "LightTools BSDF",
        sides,
        source=head.get("source", ""),
        incidences=incidences,
        stated=stated,
        factors=scaled,
        remarks=tuple(remarks),
    )


def _read(words: Words) -> tuple[dict, list[_Block]]:
    """Keywords with what they stated last, and the blocks."""
    head = {"poi": 0.0, "side": "front", "wavelength": 0.0, "tristimulusvalue": ""}
    blocks, size = [], 0
    while words.peek():
        key = words.word("a keyword").lower()
        if key in LISTS:
            if key in head:
                words.fail(f"has '{key}' twice")
            count = words.whole(f"the number of angles of '{key}'", 1, MOST_ANGLES)
            head[key] = words.angles(count, f"angles of '{key}'", LISTS[key])
        elif key in WORDS:
            head[key] = words.word(f"what '{key}' is").lower()
        elif key in NUMBERS:
            head[key] = words.number(f"'{key}'", *NUMBERS[key])
        elif key == "tis":
            blocks.append(_read_block(words, head))
            size += blocks[-1].values.size
            if len(blocks) > MOST_BLOCKS or size > MOST_VALUES:
                words.fail(f"has more than {MOST_BLOCKS} blocks or {MOST_VALUES} values")
        elif key not in {"monochrome", "databegin", "dataend"}:
            words.fail(f"has the keyword '{key[:40]}', expected one of a table of LightTools")
    return head, blocks


def _read_block(words: Words, head: dict) -> _Block:
    total = words.number("TIS", 0.0, MOST_TIS)
    for key in (*LISTS, "aoi", "scattertype"):
        if key not in head:
            words.fail(f"has values before the keyword '{key}'")
    side = SIDES.get((head["side"], head["scattertype"]))
    if side is None:
        words.fail(
            f"has the side '{head['side'][:40]}' and the type '{head['scattertype'][:40]}', expected "
            "Front or Back and BRDF or BTDF"
        )
    azimuths, radials = head["scatterazimuth"], head["scatterradial"]
    a, t = len(azimuths), len(radials)
    if a * t > MOST_NODES:
        words.fail(f"states {a * t} values in a block, expected at most {MOST_NODES}")
    # Rows are azimuths, as in Zemax's tables; rows as long as the list of azimuths tell otherwise.
    is_across = words.peek_row() == a != t
    values = words.numbers(a * t, "values")
    values = values.reshape(t, a) if is_across else values.reshape(a, t).T
    polars, values = turn_up(radials, values, side.endswith("transmission"))
    if not len(polars):
        words.fail("has no scatter radial on the side that its type is about")
    return _Block(
        side, head["aoi"], head["poi"], head["wavelength"], head["tristimulusvalue"], total, polars,
        azimuths, values,
    )  # fmt: skip


def _fan(words: Words, blocks: list[_Block]) -> tuple[SliceFan, np.ndarray, float]:
    """The blocks of one side, their stated totals (p, s, w), and where light comes from. [degree]"""
    planes, angles, bands = (
        sorted({getattr(each, name) for each in blocks}) for name in ("poi", "aoi", "wavelength")
    )
    found = {(each.poi, each.aoi, each.wavelength): each for each in blocks}
    if len(found) != len(blocks) or len(found) != len(planes) * len(angles) * len(bands):
        words.fail(
            f"has {len(blocks)} blocks of one side, expected one for each of {len(planes)} planes, "
            f"{len(angles)} angles of incidence and {len(bands)} wavelengths"
        )
    if len(bands) > MOST_BANDS or len(planes) > MOST_PLANES:
        words.fail(
            f"has {len(planes)} planes and {len(bands)} wavelengths, expected at most {MOST_PLANES} and "
            f"{MOST_BANDS}"
        )
    if len(bands) > 1 and bands[0] < 100.0:
        words.fail(f"has values for {bands[0]:g} nm beside others, expected at least 100 nm")
    totals = np.array([[[found[p, s, w].total for w in bands] for s in angles] for p in planes])
    stacks = {
        (p, s): np.maximum(np.stack([found[p, s, w].values for w in bands], axis=2), 0.0)
        for p in planes
        for s in angles
    }
    wavelengths = np.array(bands if len(bands) > 1 else [ANY_WAVELENGTH])

    def read(light: float) -> SliceFan | None:
        turns = np.radians(np.array(planes) + light) % (2.0 * np.pi)
        order = np.argsort(turns)
        rows = [
            [
                slice_about_light(
                    found[planes[p], s, bands[0]].polars,
                    found[planes[p], s, bands[0]].azimuths - turns[p],
                    stacks[planes[p], s],
                )
                for s in angles
            ]
            for p in order
        ]
        if any(each is None for row in rows for each in row):
            return None
        rotations = turns[order] if len(planes) > 1 else np.zeros(1)
        incidences = (np.radians(angles),) * len(planes)
        return SliceFan(rotations, incidences, tuple(map(tuple, rows)), wavelengths)

    fan, number = choose_fan(read(light) for light in LIGHT)
    if fan is None or np.any(np.diff(fan.rotations) < 1e-9):
        words.fail(
            "has scatter azimuths or planes of incidence that leave out one side or come twice"
        )
    order = np.argsort(np.radians(np.array(planes) + LIGHT[number]) % (2.0 * np.pi))
    return fan, totals[order], LIGHT[number]
