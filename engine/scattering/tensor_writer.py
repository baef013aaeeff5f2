"""Tensor files made of any isotropic reflection, on the first of some grids whose error is as wanted."""

import math

import numpy as np

from ..scene.scattering import Scatter
from .data.evaluation import evaluate, incidences_of, totals
from .data.resampling import measure_error
from .readers.tensor_file import parse_tensor_file, write_tensor_file

COARSE = (*range(0, 81, 5), 84, 87, 89)
FINE = (*np.arange(0.0, 81.0, 2.5), *range(82, 90))

GRIDS = ((COARSE, 64), (COARSE, 128), (FINE, 128), (FINE, 256))
"""Angles of incidence [deg], and points along each side of the square of half vectors."""

MOST_VALUES = 1 << 25
"""Of a file on another grid than the first: 128 MiB."""


def make_tensor_file(scatter: Scatter, tolerance: float = 0.02) -> tuple[bytes, float]:
    """Make a tensor file of an isotropic reflection without a direct part.

    Parameters
    ----------
    scatter : Scatter
    tolerance : float    Wanted error; the first grid that keeps it is taken, or else the best one. [-]

    Returns
    -------
    bytes    The content of the file.
    float    Its error against ``scatter``, as `resampling.measure_error` tells it. [-]
    """
    wavelengths = scatter.wavelengths
    albedo = float(totals(scatter, incidences_of(scatter), [0.0]).max())
    best, least = b"", math.inf
    for number, (incidences, n) in enumerate(GRIDS):
        if number and len(incidences) * n**2 * len(wavelengths) > MOST_VALUES:
            break
        data = write_tensor_file(
            None, lambda wi, wo: evaluate(scatter, wi, wo), np.radians(incidences), wavelengths, n
        )
        made = parse_tensor_file(data, "tensor file")
        # Fine bands are thinned when they are read, by straight lines between neighbours.
        bands = np.eye(len(wavelengths))
        shares = np.stack([np.interp(made.wavelengths, wavelengths, band) for band in bands])

        def true(wi, wo, shares=shares):
            return evaluate(scatter, wi, wo) @ shares

        error = measure_error(true, made.evaluate, albedo)
        if error < least:
            best, least = data, error
        if error <= tolerance:
            break
    return best, least
