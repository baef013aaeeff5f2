"""Tables of scattering of Zemax and Radiant (.bsdf): text, about the direction of the mirror."""

import re
from dataclasses import replace

import numpy as np

from ...errors import FileFormatError
from ...reading.remarks import Remark
from ...reading.text import decode_text
from ...reading.words import Words
from ...scene.scattering import ScatterTable
from ..data.record import ScatteringFile
from ..data.table import albedo_of, albedos_of, direction_of, place_on
from .checks import LIMIT_POLAR, tell_excess, tell_negative, tell_scaling
from .colour import ANY_WAVELENGTH

SYMMETRIES = ("planesymmetrical", "asymmetrical", "asymmetrical4d")

CONTENTS = {"monochrome": ("monochrome",), "xyz": ("tristimulusx", "tristimulusy", "tristimulusz")}
"""Blocks by what the file says that it holds."""

SIDES = {"brdf": "front_reflection", "btdf": "front_transmission"}

LISTS = {"samplerotation": 360.0, "angleofincidence": 90.0, "scatterazimuth": 360.0, "scatterradial": 180.0}  # fmt: skip
"""Keywords of lists of angles, and the largest of each. [degree]"""

MOST_ANGLES = 100_000
"""In a list."""

MOST_VALUES = 50_000_000
"""In a file."""

MOST_NODES = 300_000
"""For one direction of incidence: finer ones would take too much memory to integrate."""

MOST_BLOCKS = 10_000
"""Directions of incidence."""

MOST_TIS = 1.02
"""A stated total may be so large: 1, and what rounding and measuring add."""

_COATINGS = re.compile(rb"(?:^|\n)[ \t]*(?:MATE|COAT|TABLE|ENCRYPTED)[ \t]+\S", re.IGNORECASE)

TAIL = np.radians(0.1)
"""Within which values fall to zero where nothing is beyond. [rad]"""

_HEAD = 1 << 16
"""How much of a file is looked at. [byte]"""


def is_zemax(data: bytes) -> bool:
    """Whether a file is a table of Zemax, or one of its thin films, which `read_zemax` refuses."""
    head = data[:_HEAD].lower()
    return (b"angleofincidence" in head and b"scatterradial" in head) or _is_coatings(head)


def _is_coatings(head: bytes) -> bool:
    return b"scatter" not in head and len(_COATINGS.findall(head)) > 1 and b"\0" not in head


def read_zemax(data: bytes, path) -> ScatteringFile:
    """Read a table. Its grid is kept; of colours only Y is.

    The azimuth of the file is 0 towards the normal and turns as that of `ScatterTable` turns back, so the same direction
    has there pi minus it.

    Raises
    ------
    FileFormatError    It is no such table; says what was found and expected, with the line.
    """
    if _is_coatings(data[:_HEAD].lower()):
        raise FileFormatError(
            path,
            "holds thin-film coatings of Zemax (MATE, COAT), expected scattering; export the coating as "
            "reflectance and transmittance by angle",
        )
    words = Words(data, path, "#")
    head = _read_head(words)
    values, totals = _read_blocks(words, head)
    incidences, order = np.unique(head["angleofincidence"], return_index=True)
    if len(order) != len(head["angleofincidence"]):
        words.fail("has the same angle of incidence twice")
    rotations, turns = _rotations(head)
    side = SIDES[head["scattertype"]]
    remarks = tell_negative(side, int((values < 0.0).sum()), values.size)
    values, totals = np.maximum(values[turns][:, order], 0.0), totals[turns][:, order]
    table = _table(words, head, rotations, incidences, values)
    table, shares, factors, more = _scale(_choose_tail(table, totals), totals, side)
    remarks += more + _tell(head, totals) + tell_excess(side, shares)
    return ScatteringFile(
        path,
        "Zemax BSDF",
        {side: table},
        description=_description(data),
        source=head.get("source", ""),
        incidences=incidences,
        stated={side: totals[0]},
        factors={side: factors},
        remarks=tuple(remarks),
    )


def _description(data: bytes) -> str:
    """The comments at the beginning."""
    lines = decode_text(data, _HEAD).split("\n")
    return "\n".join(line[1:].strip() for line in lines if line.startswith("#"))


def _read_head(words: Words) -> dict:
    """Keywords in small letters with what they state, angles in radians in the file's order."""
    head = {}
    while words.peek().lower() not in {"databegin", ""}:
        key = words.word("a keyword").lower()
        if key in head:
            words.fail(f"has '{key}' twice")
        if key in LISTS:
            count = words.whole(f"the number of angles of '{key}'", 1, MOST_ANGLES)
            head[key] = words.angles(
                count, f"angles of '{key}'", LISTS[key], any_order=key != "scatterradial"
            )
        elif key in {"source", "symmetry", "spectralcontent", "scattertype"}:
            head[key] = words.word(f"what '{key}' is")
        elif key in CONTENTS["monochrome"] + CONTENTS["xyz"]:
            head["block"] = key
        else:
            words.fail(f"has the keyword '{key[:40]}', expected one of a table of Zemax")
    for key, known in (
        ("symmetry", SYMMETRIES),
        ("spectralcontent", CONTENTS),
        ("scattertype", SIDES),
    ):
        if head.get(key, "").lower() not in known:
            words.fail(
                f"states '{head.get(key, '')[:40]}' as {key}, expected one of {', '.join(known)}"
            )
        head[key] = head[key].lower()
    for key in LISTS:
        if key not in head:
            words.fail(f"lacks the keyword '{key}'")
    return head


def _read_blocks(words: Words, head: dict) -> tuple[np.ndarray, np.ndarray]:
    """Values of the block that counts, and their totals. (p, s, a, t), (p, s)"""
    shape = tuple(len(head[key]) for key in LISTS)
    size = int(np.prod([float(n) for n in shape]))
    blocks = CONTENTS[head["spectralcontent"]]
    if size * len(blocks) > MOST_VALUES:
        words.fail(f"states {size * len(blocks)} values, expected at most {MOST_VALUES}")
    if shape[0] * shape[1] > MOST_BLOCKS or shape[2] * shape[3] > MOST_NODES:
        words.fail(
            f"states {shape[0] * shape[1]} directions of incidence with {shape[2] * shape[3]} values each, "
            f"expected at most {MOST_BLOCKS} and {MOST_NODES}; thin it out"
        )
    kept = None
    name = head.get("block", blocks[0])
    for number, expected in enumerate(blocks):
        if number:
            name = words.word("a block of tristimulus values").lower()
        if name != expected:
            words.fail(f"has the block '{name[:40]}', expected '{expected}'")
        _expect(words, "databegin")
        values, totals = np.empty(shape), np.empty(shape[:2])
        for place in np.ndindex(*shape[:2]):
            _expect(words, "tis")
            totals[place] = words.number("TIS", 0.0, MOST_TIS)
            values[place] = words.numbers(shape[2] * shape[3], "values").reshape(shape[2:])
        _expect(words, "dataend")
        if expected in {"monochrome", "tristimulusy"}:
            kept = values, totals
    return kept


def _expect(words: Words, keyword: str) -> None:
    found = words.word(f"'{keyword}'")
    if found.lower() != keyword:
        words.fail(f"has '{found[:40]}', expected '{keyword}'; counts of angles may be wrong")


def _rotations(head: dict) -> tuple[np.ndarray, np.ndarray]:
    """Azimuths of wi and the places of their blocks."""
    told = head["samplerotation"]
    if len(told) == 1:
        return np.zeros(1), np.zeros(1, dtype=np.int64)
    # The angle is that of the normal of the plane of incidence, a right angle behind wi.
    return np.unique(np.round((told + 0.5 * np.pi) % (2.0 * np.pi), 9), return_index=True)


def _table(words: Words, head: dict, rotations, incidences, values) -> ScatterTable:
    """The table on the file's own grid. ``values`` (p, s, a, t)"""
    told, order = np.unique(head["scatterazimuth"], return_index=True)
    if len(order) != len(head["scatterazimuth"]):
        words.fail("has the same scatter azimuth twice")
    values = values[:, :, order]
    is_half = head["symmetry"] == "planesymmetrical" and told[-1] < np.pi + 1e-6
    end = np.pi if is_half else 2.0 * np.pi
    # All around, the last line may be missing, as it is the first one again.
    step = 0.0 if is_half or len(told) < 2 else 1.5 * np.diff(told).max()
    if told[0] > 1e-6 or end - told[-1] > step + 1e-6:
        words.fail(
            f"has scatter azimuths from {np.degrees(told[0]):g} to {np.degrees(told[-1]):g} degrees, "
            f"expected 0 to {np.degrees(end):g}"
        )
    if end - told[-1] > 1e-6:
        told = np.append(told, end)
        values = np.concatenate([values, values[:, :, :1]], axis=2)
    told[0], told[-1] = 0.0, end
    # The same lines, and ends where they have to be: between lines values are linear in both.
    wanted = (np.pi - told) % (2.0 * np.pi)
    azimuths = np.unique(np.concatenate([[0.0, end], np.round(wanted[wanted < end], 12)]))
    below, share = place_on(told, (np.pi - azimuths) % (2.0 * np.pi))
    share = share[:, None]
    values = values[:, :, below] * (1.0 - share) + values[:, :, below + 1] * share
    radials = head["scatterradial"]
    if radials[0] > 0.0:
        radials = np.append(0.0, radials)
        values = np.concatenate([values[..., :1], values], axis=-1)
    if len(radials) == 1:
        radials, values = np.array([0.0, np.pi]), np.repeat(values, 2, axis=-1)
    values = values.transpose(0, 1, 3, 2)
    _fill_below_horizon(values, incidences, radials, azimuths)
    return ScatterTable(
        rotations,
        incidences,
        radials,
        azimuths,
        np.array([ANY_WAVELENGTH]),
        values[..., None].astype(np.float32),
    )


def _fill_below_horizon(values, incidences, radials, azimuths) -> None:
    """Let the last values above the horizon hold below it, where files have zeros that are no data. (p, s, t, a)"""
    wo = direction_of(*np.meshgrid(incidences, radials, azimuths, indexing="ij"))
    above = wo[..., 2] > -1e-9
    above[:, 0] = True
    last = np.maximum.accumulate(np.where(above, np.arange(len(radials))[None, :, None], 0), axis=1)
    values[:] = np.take_along_axis(values, last[None], axis=2)


def _choose_tail(table: ScatterTable, totals: np.ndarray) -> ScatterTable:
    """Let values hold beyond the last radial angle, or be zero there, whichever is nearer to the stated totals (p, s)."""
    if table.radials[-1] > LIMIT_POLAR - 1e-6:
        return table
    dark = replace(
        table,
        radials=np.append(table.radials, table.radials[-1] + TAIL),
        values=np.concatenate([table.values, np.zeros_like(table.values[:, :, :1])], axis=2),
    )

    def apart(made):
        have = albedos_of(made, made.incidences, made.rotations)[..., 0]
        known = (totals > 0.0) & (have > 0.0)
        return np.abs(np.log(have[known] / totals[known])).sum()

    return dark if apart(dark) < apart(table) else table


def _scale(table: ScatterTable, totals: np.ndarray, side: str):
    """Bring the table to the stated totals (p, s). Returns it, its totals by incidence, the factors, and remarks."""
    values = table.values.astype(np.float64)
    factors, shares, remarks = [], [], []
    for p, rotation in enumerate(table.rotations):
        for s, incidence in enumerate(table.incidences):
            have, told = albedo_of(table, incidence, rotation)[0], totals[p, s]
            is_scaled = told > 0.0 and have > 0.0
            shares.append((incidence, told if is_scaled else have))
            if is_scaled:
                factors.append((incidence, told / have))
                values[p, s] *= told / have
            elif told != have:
                what = "values, but a TIS of 0" if have > 0.0 else "a TIS above 0, but no light"
                remarks.append(Remark(f"has {what} at {np.degrees(incidence):g} degrees"))
    remarks = tell_scaling(side, factors) + remarks[:1]
    return replace(table, values=values.astype(np.float32)), shares, factors, remarks


def _tell(head: dict, totals: np.ndarray) -> list[Remark]:
    """Remarks on what the table lacks, cannot keep, or does not tell."""
    remarks, farthest = [], head["scatterradial"][-1]
    if farthest < LIMIT_POLAR - 1e-6:
        remarks.append(
            Remark(
                f"has no values farther than {np.degrees(farthest):g} degrees from the mirror direction; "
                "the last ones hold"
            )
        )
    if head["spectralcontent"] == "xyz":
        remarks.append(
            Remark(
                "states X, Y and Z without the light that they are for; Y is kept as the same at all "
                "wavelengths, colour is left out"
            )
        )
    if len(totals) > 1:
        remarks.append(
            Remark(
                "the angle of the sample is taken as that of the normal of the plane of incidence from "
                "+x, and light comes from a right angle ahead of it"
            )
        )
    return remarks
