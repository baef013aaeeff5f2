"""The cone of Blender's spot lights over an intensity distribution."""

import numpy as np

from ....engine.luminaires.coordinates import directions
from ....engine.luminaires.distribution import intensity, intensity_at
from ....engine.scene.distribution import IntensityDistribution

EDGE_STEPS = 32
"""Polar steps over the soft edge; linear between them, a smoothstep is met to 0.1 % of its height."""

STEP = np.deg2rad(1.0)
"""Of the grid on which distributions about another axis than the beam are taken. [rad]"""


def within_cone(
    distribution: IntensityDistribution, half_angle: float, blend: float
) -> IntensityDistribution | None:
    """Return what a spot light's cone lets through of a distribution, None if that is nothing.

    Parameters
    ----------
    distribution : IntensityDistribution    In the light's own axes; the cone is about -z.
    half_angle : float    Where the light ends. [rad]
    blend : float    Share of the cone that the soft edge takes, 0..1, as of `SpotLight`.
    """
    if distribution.frame[2, 2] < 1.0 - 1e-9:
        distribution = _about_beam(distribution, half_angle)
    polar = distribution.polar
    cos_end = np.cos(half_angle)
    width = (1.0 - cos_end) * blend
    start = np.arccos(np.clip(cos_end + width, -1.0, 1.0))
    edge = np.linspace(start, half_angle, EDGE_STEPS + 1)
    end = min(half_angle, polar[-1])
    rows = np.unique(np.concatenate([polar[polar < end], edge, [polar[0], end]]))
    rows = rows[(rows >= polar[0]) & (rows <= end)]
    rows = rows[np.append(True, np.diff(rows) > 1e-9)]
    if len(rows) < 2:
        return None
    place = (np.cos(rows) - cos_end) / max(width, 1e-7)
    # A hard edge still shines at its end: nothing is emitted outside the grid.
    place = np.clip(place, 0.0, 1.0) if blend > 0.0 else np.ones(len(rows))
    share = place * place * (3.0 - 2.0 * place)
    values = intensity_at(distribution, distribution.azimuth[:, None], rows[None, :]) * share
    return IntensityDistribution(distribution.azimuth, rows, values, distribution.frame)


def _about_beam(distribution: IntensityDistribution, half_angle: float) -> IntensityDistribution:
    """Return a distribution on a grid about the beam, as far as the cone reaches."""
    azimuth = np.linspace(0.0, 2.0 * np.pi, round(2.0 * np.pi / STEP) + 1)
    polar = np.linspace(0.0, half_angle, max(round(half_angle / STEP), 2) + 1)
    values = intensity(distribution, directions(azimuth[:, None], polar[None, :]))
    return IntensityDistribution(azimuth, polar, values)
