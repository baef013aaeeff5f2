"""Small LM-63 files, and what was read of them."""

import math

import numpy as np

from lumenray.engine.luminaires.distribution import intensity
from lumenray.engine.luminaires.formats.lm63.reader import parse_lm63
from lumenray.engine.luminaires.formats.record import LuminaireFile

HEAD_2002 = (
    "IESNA:LM-63-2002",
    "[TEST] 1",
    "[TESTLAB] Hand made",
    "[ISSUEDATE] 2024-01-01",
    "[MANUFAC] Example",
)

FIRST_LINES = {
    1986: ("A downlight of 1986",),
    1991: ("IESNA91",),
    1995: ("IESNA:LM-63-1995",),
    2002: HEAD_2002,
    2019: ("IES:LM-63-2019", *HEAD_2002[1:]),
}


def made(
    head=HEAD_2002,
    tilt="TILT=NONE",
    lamps="1 2000 1",
    counts=None,
    kind=1,
    unit=2,
    size="0 0 0",
    factors="1 1 10",
    vertical="0 45 90",
    horizontal="0",
    candela=("300 200 100",),
    tail=(),
):
    """Text of a file; by default line 6 is TILT, 7 and 8 the counts and factors, 9 and 10 the angles."""
    counts = counts or f"{len(vertical.split())} {len(horizontal.split())}"
    numbers = f"{lamps} {counts} {kind} {unit} {size}"
    return "\n".join([*head, tilt, numbers, factors, vertical, horizontal, *candela, *tail]) + "\n"


def parsed(text, folder=None) -> LuminaireFile:
    return parse_lm63(text if isinstance(text, bytes) else text.encode(), "sample.ies", folder)


def toward(polar, azimuth=0.0):
    """Direction of type C angles. [degree]"""
    gamma, c = math.radians(polar), math.radians(azimuth)
    return (math.sin(gamma) * math.cos(c), math.sin(gamma) * math.sin(c), -math.cos(gamma))


def candela(file, polar, azimuth=0.0) -> float:
    return float(intensity(file.distribution, np.array(toward(polar, azimuth))))


VERTICAL, HORIZONTAL = [-90, -60, -20, 0, 30, 90], [-90, -45, 0, 10, 90]


def table_ab(kind):
    """Values that tell all angles apart but are one at each pole."""
    rows = []
    for h in HORIZONTAL:
        pole = kind == 2 and abs(h) == 90
        rows.append(
            " ".join(
                str(1000 + h if pole or (kind == 3 and abs(v) == 90) else 1000 + 2 * h + v)
                for v in VERTICAL
            )
        )
    if kind == 3:
        rows = [
            " ".join(
                "700" if abs(v) == 90 else x for x, v in zip(row.split(), VERTICAL, strict=True)
            )
            for row in rows
        ]
    return rows


PLAIN = made()


def words(file) -> str:
    return "\n".join(map(str, file.remarks))
