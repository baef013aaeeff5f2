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
