"""What tests of EULUMDAT share."""

import numpy as np

from lumenray.engine.luminaires.coordinates import directions
from lumenray.engine.luminaires.distribution import intensity
from lumenray.engine.luminaires.formats.eulumdat.reader import parse_eulumdat

NAMES = {4: "quadrant", 3: "C90-C270", 2: "C0-C180", 1: "rotational", 0: "none"}

DIRECTIONS = directions(
    np.deg2rad(np.arange(0.0, 360.0, 3.7))[:, None], np.deg2rad(np.arange(0.0, 180.1, 1.3))
)

EIGHT = [0, 45, 90, 135, 180, 225, 270, 315]
"""C-planes of the small samples; the polar angles are 0, 45, 90."""


def small(isym=0, rows=None, planes=EIGHT, polars=(0, 45, 90), lamps=(1, "LED", 1000)):
    """Lines of a file that departs from nothing but has a computed flux that LORL and DFF do not state."""
    rows = [[100, 80, 0]] * len(planes) if rows is None else rows
    count, name, lumens = lamps
    steps = [np.diff(angles) for angles in (planes, polars)]
    dc, dg = (s[0] if len(s) and np.ptp(s) == 0 else 0 for s in steps)
    return [
        *("A & B", 1 if isym == 1 else 2, isym, len(planes), dc, len(polars), dg),
        *("R1", "Lamp", "L-1", "lamp.ldt", "2024-05-06/us"),
        *(1200, 300, 60, 1150, 250, 0, 0, 0, 0),
        *("", "", 1, 0, 1),
        *(count, name, lumens, "4000 K", "80", 12.5),
        *[0.5] * 10,
        *planes,
        *polars,
        *[value for row in rows for value in row],
    ]


def as_bytes(lines, end="\r\n", encoding="latin-1"):
    return end.join(map(str, lines)).encode(encoding)


def parsed(lines, **kinds):
    return parse_eulumdat(as_bytes(lines, **kinds), "a.ldt")


def changed(line, text, **kinds):
    """Lines with one replaced; ``line`` counts from 1."""
    lines = small(**kinds)
    lines[line - 1] = text
    return lines


def plane_values(file, azimuths, polar=45.0):
    direction = directions(np.deg2rad(np.asarray(azimuths, dtype=float)), np.deg2rad(polar))
    return intensity(file.distribution, direction)


def remarks_of(file):
    """Remarks but those on the two blank fractions of `small`."""
    return [r for r in file.remarks if "fraction DFF" not in r.text]


# The values at 45 degrees from C0 to C315 that the format's description demands.
SAMPLES = {
    4: ([[300, v, 0] for v in (200, 180, 160)], [200, 180, 160, 180, 200, 180, 160, 180]),
    3: ([[300, v, 0] for v in (70, 80, 90, 100, 110)], [90, 100, 110, 100, 90, 80, 70, 80]),
    2: ([[300, v, 0] for v in (10, 20, 30, 40, 50)], [10, 20, 30, 40, 50, 40, 30, 20]),
    1: ([[300, 77, 0]], [77] * 8),
    0: ([[300, v, 0] for v in range(1, 9)], [1, 2, 3, 4, 5, 6, 7, 8]),
}
