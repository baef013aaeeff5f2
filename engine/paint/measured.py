"""Readings of real paints from files: colours in rows, and the files of measured materials."""

from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..reading.content import read_bytes
from ..reading.text import decode, parse_number
from ..scattering.data.evaluation import evaluate
from ..scattering.readers.reader import read_scattering
from ..scene.scattering import PatchMatrix, ScatterTable
from .fitting import BrdfReadings, LabReadings
from .readings import directions

LARGEST_FILE = 1 << 20
"""Of colours. [byte]"""

MOST_ROWS = 100

INCIDENCES = (15.0, 30.0, 45.0, 60.0)
"""Angles of light at which a BRDF is read. [deg]"""

ASPECULAR = (6.0, 10.0, 15.0, 20.0, 25.0, 35.0, 45.0, 60.0, 75.0, 90.0)
"""Aspecular angles at which it is read, where they lie above the horizon by `LOWEST`. [deg]"""

LOWEST = 80.0
"""Largest angle of the eye to the normal. [deg]"""

BANDS = np.arange(420.0, 701.0, 20.0)
"""Wavelengths at which a BRDF with bands is read. [nm]"""


def read_lab_file(path, error: float) -> LabReadings:
    """Read colours: lines of an aspecular angle in degrees, L*, a* and b*, parted by commas, semicolons or blanks.

    Raises
    ------
    FileFormatError    It cannot be read; the text says in which line.
    """
    rows = []
    for number, line in enumerate(decode(path, read_bytes(path, LARGEST_FILE)).splitlines(), 1):
        words = line.replace(",", " ").replace(";", " ").split()
        if not words or words[0].startswith("#"):
            continue
        values = [parse_number(word) for word in words]
        if not rows and None in values:
            continue  # a line of headings
        if len(values) != 4 or None in values:
            raise FileFormatError(
                path,
                f"found '{line.strip()[:40]}', expected four numbers: angle, L*, a*, b*",
                number,
            )
        if not -45.0 < values[0] < 135.0 or not 0.0 <= values[1] < 1000.0:
            raise FileFormatError(
                path, "expected an angle within -45 to 135 degrees and L* from 0", number
            )
        rows.append(values)
        if len(rows) > MOST_ROWS:
            raise FileFormatError(path, f"has more than {MOST_ROWS} colours", number)
    if not rows:
        raise FileFormatError(path, "has no colours, expected lines of an angle, L*, a* and b*")
    table = np.array(rows)
    return LabReadings(table[:, 0], table[:, 1:], error)


def read_brdf(path, error: float) -> BrdfReadings:
    """Read a measured material in the plane of incidence.

    Raises
    ------
    FileFormatError    It cannot be read, or does not tell of reflection.
    """
    path = Path(path)
    scatter = read_scattering(path).sides.get("front_reflection")
    if scatter is None:
        raise FileFormatError(path, "does not tell what the front reflects")
    pairs = [
        directions([angle], incidence)
        for incidence in INCIDENCES
        for angle in ASPECULAR
        if abs(incidence - angle) <= LOWEST
    ]
    wi, wo = (np.concatenate(each) for each in zip(*pairs, strict=True))
    values = evaluate(scatter, wi, wo)
    own = scatter.wavelengths
    if isinstance(scatter, ScatterTable | PatchMatrix) and len(own) == 1:
        bands = BANDS[::7]
        values = np.repeat(values, len(bands), axis=1)
    elif len(own) > 4:
        bands = BANDS[(own[0] <= BANDS) & (own[-1] >= BANDS)]
        values = np.stack([np.interp(bands, own, row) for row in values])
    else:
        bands = np.asarray(own, np.float64)
    return BrdfReadings(wi, wo, values, bands, error)
