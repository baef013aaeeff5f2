"""Measured scattering of MDL (.mbsdf): binary, one number or one colour for each cell of angles about the normal."""

import re

import numpy as np

from ...errors import FileFormatError
from ...reading.blocks import Blocks
from ...reading.remarks import Remark
from ...reading.text import decode_text
from ...reading.words import LARGEST
from ..data.record import ScatteringFile
from .checks import shares_of, tell_excess, tell_negative
from .colour import ANY_WAVELENGTH, WAVELENGTHS, spectra_of_rgb
from .slices import Slice, SliceFan

START = b"NVIDIA ARC MBSDF V1\n"

MARKS = {
    b"": "front_reflection",
    b"_REFLECTION": "front_reflection",
    b"_TRANSMISSION": "front_transmission",
}
"""Sides by what ends the keyword of their data."""

MOST_CELLS = 10_000
"""Of either kind of angle."""

MOST_NODES = 300_000
"""For one angle of incidence."""

_MARK = re.compile(rb"(?s)(.{0,4096}?)MBSDF_DATA(|_REFLECTION|_TRANSMISSION)=\n")


def is_mdl(data: bytes) -> bool:
    """Whether a file says at its beginning that it is of MDL."""
    return START.strip() in data[:256]


def read_mdl(data: bytes, path, tolerance: float = 0.02) -> ScatteringFile:
    """Read measured scattering of MDL.

    After a line for the side stand the kind (0 numbers, 1 colours of linear Rec. 709), the numbers of cells of the angles to
    the normal and of the azimuth between both directions from 0 to pi, and the values in the middles of cells: the angle of
    incidence changes slowest, the azimuth fastest. (Of the two slow axes only this one gives measured paint a reflectance
    that changes smoothly with incidence; the mirror direction is at pi.)

    Raises
    ------
    FileFormatError    It is cut short or no such file; says what was found and expected.
    """
    if not data.startswith(START):
        raise FileFormatError(path, f"expected to begin with '{START.decode().strip()}'", 1)
    blocks = Blocks(data, path, len(START))
    sides, texts, remarks, incidences = {}, [], [], np.zeros(0)
    while found := _MARK.match(data, blocks.at):
        texts.append(decode_text(found[1]).strip())
        blocks.at = found.end()
        side = MARKS[found[2]]
        if side in sides:
            blocks.fail(f"has {side.replace('_', ' ')} twice")
        values = _read_values(blocks)
        fan, more = _fan(side, values)
        remarks += more
        is_coloured = values.shape[-1] == 3
        sides[side] = fan.to_table(
            (lambda v: spectra_of_rgb(v)[1]) if is_coloured else None, tolerance
        )
        remarks += tell_excess(side, shares_of(sides[side]))
        incidences = incidences if incidences.size else fan.incidences[0]
    if not sides:
        blocks.fail("has no data, expected a line such as 'MBSDF_DATA='")
    if blocks.at != len(data):
        blocks.fail(f"has {len(data) - blocks.at} bytes after the data")
    return ScatteringFile(
        path,
        "MDL measured BSDF",
        sides,
        description="\n".join(text for text in texts if text),
        incidences=incidences,
        remarks=tuple(remarks),
    )


def _read_values(blocks: Blocks) -> np.ndarray:
    """Values by angle of incidence, of scattering, azimuth, and colour or none. (s, t, a, 1 or 3) float32 [1/sr]"""
    colours = (1, 3)[blocks.whole("the kind of values", 0, 1)]
    polars = blocks.whole("the number of angles to the normal", 1, MOST_CELLS)
    azimuths = blocks.whole("the number of azimuths", 1, MOST_CELLS)
    if polars * azimuths > MOST_NODES:
        blocks.fail(
            f"states {polars * azimuths} cells for each angle, expected at most {MOST_NODES}"
        )
    count = polars * polars * azimuths * colours
    values = np.frombuffer(blocks.take(4 * count, "values"), "<f4")
    # A comparison with NaN is false.
    if not (np.abs(values) <= LARGEST).all():
        blocks.fail(f"has values that are no numbers up to {LARGEST:g}")
    return values.reshape(polars, polars, azimuths, colours)


def _fan(side: str, values: np.ndarray) -> tuple[SliceFan, list[Remark]]:
    polars = (np.arange(values.shape[1]) + 0.5) * 0.5 * np.pi / values.shape[1]
    azimuths = (np.arange(values.shape[2]) + 0.5) * np.pi / values.shape[2]
    is_coloured = values.shape[3] == 3
    negative = int((values < 0.0).sum())
    if is_coloured:
        # Colours may be outside the gamut; what counts is that spectra are not negative.
        remarks = [
            Remark(
                "states colours, taken as linear Rec. 709, and kept as smooth spectra that look alike"
            )
        ]
        if negative:
            remarks.append(
                Remark(
                    f"{negative} of {values.size} components of {side.replace('_', ' ')} are negative; spectra "
                    "are cut off at 0"
                )
            )
    else:
        remarks = tell_negative(side, negative, values.size)
        values = np.maximum(values, 0.0)
    slices = tuple(Slice(polars, azimuths, each) for each in values)
    wavelengths = WAVELENGTHS if is_coloured else np.array([ANY_WAVELENGTH])
    return SliceFan(np.zeros(1), (polars,), (slices,), wavelengths), remarks
