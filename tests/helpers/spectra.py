"""A spectrum as rows of text, and with one row changed."""

import numpy as np

from lumenray.engine.photometry.spectra import planck

NM = np.arange(380, 781, 5)
POWER = planck(NM, 3000.0)
ROWS = [f"{nm} {value:.6g}" for nm, value in zip(NM, POWER, strict=True)]


def changed_rows(place, row):
    """Return the rows with one of them replaced."""
    rows = list(ROWS)
    rows[place] = row
    return rows
