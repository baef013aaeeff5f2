"""Small photometric files, written as text."""

import numpy as np


def write_ies(
    candela,
    vertical,
    horizontal,
    kind="C",
    size=(0.0, 0.0, 0.0),
    lumens=-1,
    edition="IESNA:LM-63-2002",
    tilt="TILT=NONE",
    second_factor=1.0,
    keywords=(),
):
    """Return the text of an LM-63 file.

    Parameters
    ----------
    candela : (h, v) array or function of both angles [rad]
    vertical, horizontal : sequences    Angles. [degree]
    kind : str    ``C``, ``B`` or ``A``.
    size : (float, float, float)    Width, length and height as in the file. [m]
    tilt : str    The TILT line and what follows it.
    """
    if callable(candela):
        h, v = np.deg2rad(horizontal)[:, None], np.deg2rad(vertical)[None, :]
        candela = candela(h, v) + np.zeros((len(horizontal), len(vertical)))
    rows = (_wrap(row) for row in np.atleast_2d(candela))
    return "\n".join(
        (
            edition,
            "[TEST] own",
            "[TESTLAB] own",
            "[ISSUEDATE] 2026-01-01",
            "[MANUFAC] own",
            *keywords,
            tilt,
            f"1 {lumens} 1 {len(vertical)} {len(horizontal)} {'CBA'.index(kind) + 1} 2 "
            + " ".join(f"{length:g}" for length in size),
            f"1 {second_factor:g} 10",
            _wrap(vertical),
            _wrap(horizontal),
            *rows,
            "",
        )
    )


def _wrap(numbers) -> str:
    """Numbers over lines that the standard allows."""
    words = [f"{number:.6g}" for number in numbers]
    return "\n".join(" ".join(words[i : i + 10]) for i in range(0, len(words), 10))


EVEN = write_ies([[100.0, 100.0]], [0, 180], [0], size=(0.3, 1.2, 0.0))
"""100 cd in all directions from a rectangle of 0.3 m along y and 1.2 m along x."""

FULL_FLUX = 400.0 * np.pi
"""Of `EVEN`. [lm]"""

FOUR = write_ies(
    np.outer([1.0, 2.0, 3.0, 4.0, 1.0], [0.0, 100.0, 0.0]), [0, 90, 180], [0, 90, 180, 270, 360]
)
"""100, 200, 300 and 400 cd to C0, C90, C180 and C270 at the horizontal."""

SIDEWAYS = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], float)
"""The directions in which `FOUR` shines."""


def write_peaks(
    azimuths=(0, 90, 180, 270, 360), peaks=(9, 1, 1, 1, 9), kind=1, size=(0.3, 0.6, 0.0)
):
    """Return an LM-63 file whose planes have 1 cd down, their peak at 45 degrees, and nothing at 90 and above."""
    polars = (0, 45, 90) if kind == 1 else (-90, 0, 45, 90)
    rows = [(1, peak, 0) if kind == 1 else (0, 0, peak, 0) for peak in peaks]
    numbers = [*polars, *azimuths, *(value for row in rows for value in row)]
    return (
        "IESNA:LM-63-2002\n[TEST] made for a test\n[MANUFAC] Example\n[LUMINAIRE] Spot\n"
        "[LAMP] LED 4000 K\nTILT=NONE\n"
        f"1 -1 1 {len(polars)} {len(azimuths)} {kind} 2 {size[0]} {size[1]} {size[2]}\n1 1 5\n"
        + "\n".join(str(number) for number in numbers)
        + "\n"
    )
