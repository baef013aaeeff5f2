"""Planes of a symmetric luminaire expanded to the whole turn, and one value at each pole."""

import numpy as np

from ..distribution import azimuth_weights

_IMAGES = {
    "none": ((1.0, 0.0),),
    "C0-C180": ((1.0, 0.0), (-1.0, 0.0)),
    "C90-C270": ((1.0, 0.0), (-1.0, 180.0)),
    "quadrant": ((1.0, 0.0), (-1.0, 180.0), (1.0, 180.0), (-1.0, 0.0)),
}
"""Sign and offset [degree] of the azimuths that share a stored plane."""

_SAME = 1e-6
"""Planes nearer than this are one. [degree]"""

POLE_TOLERANCE = 0.02
"""How far planes may differ at a pole, of their mean, before a reader remarks on it."""


def expand_planes(azimuth, values, symmetry: str) -> tuple[np.ndarray, np.ndarray]:
    """Return all planes of the turn from the stored ones.

    Parameters
    ----------
    azimuth : (n,) array    Of the stored planes, in any order and from any start; planes beyond the ones that the symmetry
        needs may be there, the first of those that fall together counts. [degree]
    values : (n, p) array    One row for each plane.
    symmetry : str    As of `LuminaireFile`.

    Returns
    -------
    (m,) float64 array    From 0 to 360, ascending; a single 0 if the symmetry is ``rotational``. [degree]
    (m, p) float64 array    The last row equals the first. If no plane lies at 0, the one there is interpolated, which leaves
        the bilinear interpolant as it was.
    """
    azimuth = np.asarray(azimuth, dtype=np.float64)
    values = np.asarray(values, dtype=np.float64)
    if symmetry == "rotational":
        return np.zeros(1), values[:1].copy()
    images = np.concatenate([sign * azimuth + offset for sign, offset in _IMAGES[symmetry]])
    images = np.mod(images, 360.0)
    images[images > 360.0 - _SAME] = 0.0
    row = np.tile(np.arange(len(azimuth)), len(_IMAGES[symmetry]))
    order = np.argsort(images, kind="stable")
    images, row = images[order], row[order]
    first = np.concatenate([[True], np.diff(images) > _SAME])
    images, table = images[first], values[row[first]]
    if images[0] > _SAME:
        before = 360.0 - images[-1]
        share = before / (before + images[0])
        seam = table[-1] * (1.0 - share) + table[0] * share
        images, table = np.concatenate([[0.0], images]), np.vstack([seam, table])
    images[0] = 0.0
    return np.append(images, 360.0), np.vstack([table, table[0]])


def average_poles(azimuth, polar, values) -> tuple[np.ndarray, float]:
    """Give each pole one value, the mean over the planes by their width: a pole is one direction. The flux stays.

    Parameters
    ----------
    azimuth : (a,) array    Ascending; of all planes. [degree]
    polar : (p,) array    [degree]
    values : (a, p) array

    Returns
    -------
    (a, p) float64 array
    float    Largest difference of a plane from the mean, relative to it; 0 without a pole in the grid.
    """
    values = np.array(values, dtype=np.float64)
    if len(azimuth) == 1:
        return values, 0.0
    weights = azimuth_weights(np.asarray(azimuth, dtype=np.float64))
    worst = 0.0
    for row, pole in ((0, 0.0), (-1, 180.0)):
        column = values[:, row]
        if abs(polar[row] - pole) > _SAME or np.all(column == column[0]):
            continue
        mean = float(weights @ column / weights.sum())
        worst = max(worst, float(np.abs(column - mean).max()) / mean)
        values[:, row] = mean
    return values, worst
