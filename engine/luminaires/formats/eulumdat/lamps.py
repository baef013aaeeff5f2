"""Lamp sets of an EULUMDAT: how many lamps, their flux, power and colour."""

import re

from ....errors import FileFormatError
from ....reading.remarks import Remark
from ..record import LampSet
from .fields import FLUX, POWER, Fields

MAXIMUM_LAMPS = 100_000
"""Most lamps of a set."""

PLACEHOLDER_FLUX = 1.0
"""Lamps with no more are those of a form that was not filled in. [lm]"""


def read_lamps(fields: Fields, count: int, remarks) -> tuple[tuple[LampSet, ...], bool]:
    """The lamp sets, set after set or, in some files, all numbers, then all types and so on; whether they are absolute."""
    rows = fields.take(6 * count, f"{count} lamp sets of 6 lines")
    try:
        return _lamps(fields.path, rows, remarks)
    except FileFormatError as error:
        if count == 1:
            raise
        turned = [rows[item * count + lamp] for lamp in range(count) for item in range(6)]
        try:
            found = _lamps(fields.path, turned, remarks)
        except FileFormatError:
            raise error from None
        text = "the lamp sets stand line by line side by side instead of one after the other"
        remarks.append(Remark(text, rows[0][0]))
        return found


def _lamps(path, rows, remarks) -> tuple[tuple[LampSet, ...], bool]:
    """Lamp sets of six lines each; remarks are added only if all can be read."""
    fields = Fields(path, rows)
    lamps, signs = [], []
    for place in range(1, len(rows) // 6 + 1):
        lamp, sign = _lamp(fields, place)
        lamps.append(lamp)
        signs.append(sign)
    remarks += fields.remarks()
    return tuple(lamps), signs[0] < 0


def _lamp(fields: Fields, place: int) -> tuple[LampSet, int]:
    of = f"of lamp set {place}"
    count = fields.number(f"the number of lamps {of}", default=0.0, assumed="unknown")
    if abs(count) > MAXIMUM_LAMPS or abs(count - round(count)) > 1e-6:
        fields.fail(f"expected the number of lamps {of}, found {count:g}")
    name = fields.text(f"the type of the lamps {of}")
    flux_of_lamps = fields.number(f"the flux of the lamps {of}", FLUX, 0.0)
    if flux_of_lamps <= 0.0 and place == 1:
        fields.fail(
            f"{flux_of_lamps:g} lm as flux of the lamps {of}, expected more than 0: the intensities are in cd"
            " per 1000 lm of it"
        )
    if flux_of_lamps <= 0.0:
        fields.remark(f"{flux_of_lamps:g} lm as flux of the lamps {of}, taken as not stated")
    elif flux_of_lamps <= PLACEHOLDER_FLUX and place == 1:
        fields.remark(
            f"{flux_of_lamps:g} lm as flux of the lamps {of} is that of an empty form; the intensities are"
            " for it, so give the light its true flux"
        )
    colour = fields.text(f"the colour of the lamps {of}")
    rendering = fields.text(f"the colour rendering of the lamps {of}")
    watts = fields.number(f"the power {of}", POWER, 0.0, "not stated")
    if watts < 0.0:
        fields.remark(f"{watts:g} W as power {of}, taken as not stated")
    lamp = LampSet(
        count=abs(round(count)),
        luminous_flux=flux_of_lamps if flux_of_lamps > 0.0 else None,
        watts=watts if watts > 0.0 else None,
        colour_temperature=colour_temperature(colour),
        name=name,
        colour=colour,
        colour_rendering=rendering,
    )
    return lamp, round(count)


def colour_temperature(text: str) -> float | None:
    """Correlated colour temperature that a text tells, such as ``4000 K``, ``nw/4200`` or the code ``840``. [K]

    In the three digits of a lamp's code the first is the colour rendering in tens, the others are hundreds of kelvin.
    """
    joined = re.sub(r"(?<![0-9.,])([0-9]{1,2})[ .,]([0-9]{3})(?=\s*[kK]\b)", r"\1\2", text)
    match = re.search(r"(?<![0-9.,])([0-9]{4,5})(?![0-9])", joined)
    if match and 1000.0 <= float(match[1]) <= 25000.0:
        return float(match[1])
    match = re.search(r"(?<![0-9.,])[5-9]([0-9]{2})(?![0-9.,])", text)
    if match and 1800.0 <= 100.0 * float(match[1]) <= 10000.0:
        return 100.0 * float(match[1])
    return None
