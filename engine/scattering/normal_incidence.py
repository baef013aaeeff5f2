"""Light along the normal where it was not measured: what instruments cannot see, because the lamp is in the way.

Along the normal an isotropic surface scatters alike in all azimuths, and averaged over the azimuth its scattering is even
in the angle of incidence; so a parabola without a linear term through two incidences gives it.
"""

from dataclasses import replace

import numpy as np

from ..scene.scattering import ScatterTable
from .table import direction_of

FARTHEST = np.radians(30.0)
"""Lowest angle of incidence from which the normal can still be told."""

SAME = 1e-4
"""Angles so near are one. [rad]"""

MOST = 2.0
"""By which the extrapolated values may differ from those of the lowest incidence. [-]"""


def along_normal(radials, azimuths, incidences, values) -> np.ndarray:
    """Values for light along the normal, extrapolated in the logarithm.

    Parameters
    ----------
    radials, azimuths : (t,), (a,) arrays    As of `ScatterTable`. [rad]
    incidences : (s,) array    The lowest one or two count. [rad]
    values : (s, t, a, w) array    [1/sr]

    Returns
    -------
    (t, a, w) array    The same at all azimuths. [1/sr]
    """
    means = [
        _mean_around(radials, azimuths, angle, each)
        for angle, each in zip(incidences[:2], values[:2], strict=True)
    ]
    made = means[0]
    if len(means) == 2:
        first, second = incidences[:2] ** 2
        made = (second * means[0] - first * means[1]) / (second - first)
        made = np.clip(made, means[0] - np.log(MOST), means[0] + np.log(MOST))
    return np.broadcast_to(np.exp(made)[:, None], values.shape[1:])


def add_normal_incidence(table: ScatterTable) -> ScatterTable | None:
    """Return an isotropic table with light along the normal; None where it has it, or cannot tell."""
    lowest = table.incidences[0]
    if len(table.rotations) > 1 or not SAME < lowest <= FARTHEST:
        return None
    values = table.values[0].astype(np.float64)
    first = along_normal(table.radials, table.azimuths, table.incidences, values)
    direct = table.direct
    return replace(
        table,
        incidences=np.append(0.0, table.incidences),
        values=np.concatenate([first[None], values])[None].astype(np.float32),
        direct=None if direct is None else np.concatenate([direct[:, :1], direct], axis=1),
    )


def _mean_around(radials, azimuths, incidence: float, values) -> np.ndarray:
    """Mean logarithm over the azimuths above the horizon, at every radial angle. (t, w)"""
    radial, azimuth = np.meshgrid(radials, azimuths, indexing="ij")
    above = direction_of(incidence, radial, azimuth)[..., 2] > 0.0
    # The trapezium around the whole turn.
    step = np.diff(azimuths)
    weight = 0.5 * (np.append(step, 0.0) + np.append(0.0, step))
    counted = np.where(above.any(axis=1, keepdims=True), above * weight, weight)
    return np.einsum("ta,taw->tw", counted, np.log(np.maximum(values, 1e-12))) / counted.sum(
        axis=1, keepdims=True
    )
