"""Photometric files that hold radiant intensities, as those of germicidal lamps do: what their text says of the unit.

LM-63 and EULUMDAT have no field for it. Laboratories write watts per steradian where candelas belong, and say so in words,
as guides for ultraviolet lamps ask them to.
"""

import re
from dataclasses import replace

from ...errors import FileFormatError
from ...reading.remarks import Remark
from .record import RADIANT, LuminaireFile

UNIT_KEY = "_INTENSITYUNITS"
"""Keyword by which laboratories tell the unit of the intensities in LM-63."""

WRITTEN = "mW/sr"
"""Unit that is written where none is told."""

PREFIXES = {
    "": 1.0,
    "k": 1e3,
    "m": 1e-3,
    "milli": 1e-3,
    "µ": 1e-6,
    "μ": 1e-6,
    "u": 1e-6,
    "micro": 1e-6,
    "n": 1e-9,
}

_NOT_AFTER_A_NUMBER = r"(?<![\d.,]\s)(?<![\d.,\w])"
"""A unit behind a number belongs to that number, not to those of the table."""

_WATTS = re.compile(
    _NOT_AFTER_A_NUMBER
    + r"(milli|micro|[mµμunk])?\s?W(?:atts?)?\s*(?:/|per|·|⋅)?\s*(?:sr|steradian)s?\b",
    re.IGNORECASE,
)

_PHOTONS = re.compile(
    _NOT_AFTER_A_NUMBER + r"[mµμun]?mol\s*(?:/|per|·|⋅)?\s*\(?\s*s(?:-1|⁻¹)?\W{0,3}sr\b",
    re.IGNORECASE,
)


def radiant_unit(metadata: dict[str, str]) -> tuple[str, float] | None:
    """Unit of radiant intensities as a text tells it, and its length in W/sr; None where it tells none."""
    found = next((match for text in metadata.values() if (match := _WATTS.search(text))), None)
    return None if found is None else (found[0], PREFIXES[(found[1] or "").lower()])


def require_luminous(path, file: LuminaireFile) -> None:
    """Refuse a file of radiant intensities where only visible light is of use.

    Raises
    ------
    FileFormatError
    """
    if file.quantity == RADIANT:
        raise FileFormatError(
            path, "holds radiant intensities (W/sr), not candelas: it lights nothing visible"
        )


def settle_unit(path, file: LuminaireFile) -> LuminaireFile:
    """Return a file in candelas as it is, and one whose text says otherwise with W/sr.

    Raises
    ------
    FileFormatError    The text says that photons are counted.
    """
    photons = next((m for text in file.metadata.values() if (m := _PHOTONS.search(text))), None)
    if photons is not None:
        raise FileFormatError(
            path,
            f"says that its values count photons ({photons[0]}), expected candelas or W/sr; ask for those, or TM-33",
        )
    unit = radiant_unit(file.metadata)
    if unit is None:
        return file
    words, size = unit
    told = Remark(
        f"the text says that the values are {words}, not candelas: the luminaire shines in watts, and without a "
        "spectrum it lights nothing visible"
    )
    stated = None if file.stated_flux is None else file.stated_flux * size
    return replace(
        file,
        quantity=RADIANT,
        distribution=replace(file.distribution, intensity=file.distribution.intensity * size),
        stated_flux=stated,
        lamps=tuple(replace(lamp, luminous_flux=None) for lamp in file.lamps),
        remarks=(*file.remarks, told),
    )
