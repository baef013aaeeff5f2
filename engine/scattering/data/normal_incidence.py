"""Light along the normal where it was not measured: what instruments cannot see, because the lamp is in the way.

Along the normal an isotropic surface scatters alike in all azimuths, and averaged over the azimuth its scattering is even
in the angle of incidence; so a parabola without a linear term through two incidences gives it.
"""

from dataclasses import replace

import numpy as np

from ...scene.scattering import ScatterTable
from .table import albedo_of, direction_of, is_symmetric

FARTHEST = np.radians(30.0)
"""Lowest angle of incidence from which a slope tells of the normal; above it the mean over the azimuths holds. [rad]"""

SAME = 1e-4
"""Angles so near are one. [rad]"""

LEAST = 1e-3
"""Share of the mean that values count as at least. [-]"""

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
    if len(means) == 2 and incidences[0] <= FARTHEST:
        # The logarithm is that of a lobe's shape; a floor keeps holes in the data from counting as infinitely dark.
        floor = LEAST * max(float(means[0].mean()), 1e-30)
        first, second = incidences[:2] ** 2
        logarithms = [np.log(np.maximum(mean, floor)) for mean in means]
        made = np.exp((second * logarithms[0] - first * logarithms[1]) / (second - first))
        made = np.clip(made, means[0] / MOST, means[0] * MOST)
    return np.broadcast_to(made[:, None], values.shape[1:])


def add_normal_incidence(table: ScatterTable) -> ScatterTable | None:
    """Return a table with light along the normal; None where it has it, or is not alike in all azimuths."""
    lowest = table.incidences[0]
    if len(table.rotations) > 1 or lowest <= SAME or not is_symmetric(table):
        return None
    values = table.values[0].astype(np.float64)
    first = along_normal(table.radials, table.azimuths, table.incidences, values)
    direct = table.direct
    made = replace(
        table,
        incidences=np.append(0.0, table.incidences),
        values=np.concatenate([first[None], values])[None].astype(np.float32),
        direct=None if direct is None else np.concatenate([direct[:, :1], direct], axis=1),
    )
    excess = albedo_of(made, 0.0) / np.maximum(albedo_of(made, lowest), 1.0)
    values = made.values.copy()
    values[0, 0] /= np.maximum(excess, 1.0)
    return replace(made, values=values)


def _mean_around(radials, azimuths, incidence: float, values) -> np.ndarray:
    """Mean over the azimuths above the horizon, at every radial angle. (t, w)"""
    radial, azimuth = np.meshgrid(radials, azimuths, indexing="ij")
    above = direction_of(incidence, radial, azimuth)[..., 2] > 0.0
    # The trapezium around the whole turn.
    step = np.diff(azimuths)
    weight = 0.5 * (np.append(step, 0.0) + np.append(0.0, step))
    counted = np.where(above.any(axis=1, keepdims=True), above * weight, weight)
    return np.einsum("ta,taw->tw", counted, values) / counted.sum(axis=1, keepdims=True)
