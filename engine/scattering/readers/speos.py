"""Scattering files of SPEOS: told by their first line, and the two that are mixtures of shares of light."""

import re

import numpy as np

from ...errors import FileFormatError
from ...reading.remarks import Remark
from ...reading.text import decode_text
from ...reading.words import Words
from ..data.record import ScatteringFile
from .checks import shares_of, tell_excess
from .colour import ANY_WAVELENGTH
from .mixtures import Mixture
from .speos_coatings import read_coated, read_two_sides
from .speos_tables import read_anisotropic, read_brdf

START = b"OPTIS - "

MOST_INCIDENCES, MOST_BANDS = 181, 500

INCIDENCES = np.radians([0, 10, 20, 30, 40, 50, 60, 70, 75, 80, 85, 89.0])
"""Of a mixture that is the same at all of them. [rad]"""

_HEAD = re.compile(rb"OPTIS - ([A-Za-z0-9 ]{1,60}?) (?:surface )?file v ?([0-9.]{1,8})\s*")


def is_speos(data: bytes) -> bool:
    """Whether a file begins as all of SPEOS do."""
    return data.startswith(START)


def read_speos(data: bytes, path, tolerance: float = 0.02) -> ScatteringFile:
    """Read a file of any kind of SPEOS that is scattering.

    Raises
    ------
    FileFormatError    It is of another kind or cannot be read; says what was found and expected.
    """
    head = _HEAD.match(data)
    kind = head[1].decode().lower() if head else ""
    if kind not in _READERS:
        line = decode_text(data, 60).split("\n", 1)[0].strip()
        raise FileFormatError(
            path, f"begins with '{line}', expected scattering of SPEOS: {', '.join(_READERS)}", 1
        )
    return _READERS[kind](data, path, head.end(), tolerance)


def _read_scattering(data: bytes, path, _, tolerance: float) -> ScatteringFile:
    """Shares of light by angle of incidence and wavelength.

    After a comment stand the numbers of angles and of wavelengths, the wavelengths, then for each angle the angle and five
    rows of pairs, a pair for each wavelength, of reflection and of transmission. The rows are taken as the direct, the
    Lambertian and the Gaussian share in per cent, and the widths of the Gaussian lobe along and across the plane of
    incidence: of a glossy black paint the first goes from 4 to 100 per cent as Fresnel's law does, the second falls.
    """
    words = Words(data, path)
    words.read_line()
    comment = words.read_line()
    count = words.whole("the number of angles of incidence", 1, MOST_INCIDENCES)
    bands = words.whole("the number of wavelengths", 1, MOST_BANDS)
    wavelengths = words.rising(bands, "wavelengths", 100.0, 1e5)
    incidences, rows = np.empty(count), np.empty((count, 5, bands, 2))
    for s in range(count):
        incidences[s] = words.number("an angle of incidence", 0.0, 90.0)
        rows[s] = words.numbers(10 * bands, "shares").reshape(5, bands, 2)
        if s and incidences[s] <= incidences[s - 1]:
            words.fail("has angles of incidence that do not ascend")
        if rows[s].min() < 0.0 or rows[s, :3].max() > 100.0 or rows[s, 3:].max() > 360.0:
            words.fail("has shares that are not 0 to 100 per cent, or widths that are not angles")
    words.end()
    incidences = np.radians(incidences)
    sides, remarks = {}, []
    for k, side in enumerate(("front_reflection", "front_transmission")):
        direct, lambert, gauss = 0.01 * rows[:, :3, :, k].transpose(1, 0, 2)
        along, across = np.radians(rows[:, 3:, :, k].transpose(1, 0, 2))
        if k and not (direct + lambert + gauss).any():
            continue
        if direct.max() > 1.0:
            words.fail("has a direct share above 100 per cent")
        across = np.where(across > 0.0, across, along)
        sides[side] = Mixture(
            incidences, wavelengths, direct, lambert, gauss, along, across
        ).to_table(tolerance)
        remarks += tell_excess(side, shares_of(sides[side]))
    remarks.append(
        Remark(
            "the five rows of each angle are taken as direct, Lambertian and Gaussian share and the full "
            "widths of the Gaussian lobe along and across the plane of incidence, each for reflection and "
            "transmission"
        )
    )
    return ScatteringFile(
        path, "SPEOS scattering", sides, name=comment, incidences=incidences, remarks=tuple(remarks)
    )


def _read_simple(data: bytes, path, _, tolerance: float) -> ScatteringFile:
    """Shares of light at all angles and wavelengths: absorbed, then of the rest Lambertian and Gaussian, and a width.

    What is left of the rest is direct: leather with 20, 30 and 70 per cent has shares that sum up to 100 only so.
    """
    words = Words(data, path)
    words.read_line()
    comment = words.read_line()
    mode = words.read_line().lower()
    if mode not in {"reflection", "transmission"}:
        words.fail(f"has '{mode[:40]}', expected Reflection or Transmission")
    absorbed, lambert, gauss = (
        0.01 * words.number(f"the {name} share in per cent", 0.0, 100.0)
        for name in ("absorbed", "Lambertian", "Gaussian")
    )
    width = np.radians(words.number("the width of the lobe in degrees", 0.0, 360.0))
    words.end()
    if lambert + gauss > 1.0 + 1e-6:
        words.fail(
            f"has {100.0 * lambert:g} and {100.0 * gauss:g} per cent as Lambertian and Gaussian share, "
            "expected at most 100 together"
        )
    shape = len(INCIDENCES), 1
    rest = 1.0 - absorbed
    side = f"front_{mode}"
    table = Mixture(
        INCIDENCES,
        np.array([ANY_WAVELENGTH]),
        np.full(shape, rest * max(1.0 - lambert - gauss, 0.0)),
        np.full(shape, rest * lambert),
        np.full(shape, rest * gauss),
        np.full(shape, width),
        np.full(shape, width),
    ).to_table(tolerance)
    return ScatteringFile(
        path,
        "SPEOS simple scattering",
        {side: table},
        name=comment,
        incidences=INCIDENCES,
        remarks=(
            Remark(
                "the numbers are taken as per cent absorbed, of the rest per cent Lambertian and Gaussian, "
                "what is left being direct, and the full width of the Gaussian lobe"
            ),
        ),
    )


_READERS = {
    "scattering": _read_scattering,
    "simple scattering": _read_simple,
    "anisotropic bsdf": read_anisotropic,
    "brdf": read_brdf,
    "coated": read_coated,
    "bsdf180": read_two_sides,
}
