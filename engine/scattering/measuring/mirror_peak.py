"""Light that a measured surface reflects as a mirror, told from what it scatters about the mirror direction."""

from dataclasses import replace

import numpy as np

from .calibration import CalibratedSlice

REACH = 2.5
"""Directions within so many widths of the instrument are compared with its profile."""

OTHER_WIDTH = 1.5
"""Profiles wider and narrower by this must fit worse."""

FEWEST = 6
"""Directions in reach that are needed."""

CONTRAST = 3.0
"""The peak must stand so many times above what lies under it."""

WORST_FIT = 0.1
"""Largest relative difference, root mean square, of a peak that counts as the instrument's profile."""

LITTLE = 0.8
"""Share of the light in a direction that must be left for it to be a datum of the smooth part."""


def split_mirror_peak(piece: CalibratedSlice, resolution: float):
    """Take the image of the lamp off a measurement, where there is one.

    In a mirror an instrument sees its own profile, taken as a bell of its resolution. A peak of another width is a lobe of
    the surface and stays.

    Parameters
    ----------
    piece : CalibratedSlice
    resolution : float    Full width at half maximum of the profile; 0: not known, so nothing is taken off. [rad]

    Returns
    -------
    piece : CalibratedSlice    Without the peak; directions in which little else is left have no value.
    share : (w,) float64 array    Share of light that is reflected as by a mirror. [-]
    """
    nothing = piece, np.zeros(piece.values.shape[1])
    near = piece.radial < REACH * resolution
    if near.sum() < FEWEST:
        return nothing
    angle, values = piece.radial[near], piece.values[near]
    good = np.isfinite(values).all(axis=1)
    if good.sum() < FEWEST or angle[good].min() > 0.5 * resolution:
        return nothing
    angle, values = angle[good], values[good]
    own, height, under = _fit(angle, values, resolution)
    others = [_fit(angle, values, resolution * f)[0] for f in (OTHER_WIDTH, 1.0 / OTHER_WIDTH)]
    if own > min(WORST_FIT, *others) or height.mean() < CONTRAST * under.mean():
        return nothing
    peak = _profile(piece.radial, resolution)[:, None] * height
    rest = piece.values - peak
    with np.errstate(invalid="ignore"):
        clean = np.where(rest > LITTLE * piece.values, rest, np.nan)
    # The profile over all directions, and the cosine with which light falls in.
    solid_angle = np.pi * resolution**2 / (4.0 * np.log(2.0))
    share = np.clip(height * solid_angle * np.cos(piece.incidence), 0.0, 1.0)
    return replace(piece, values=clean), share


def _profile(angle, width: float):
    return np.exp(-4.0 * np.log(2.0) * (angle / width) ** 2)


def _fit(angle, values, width: float):
    """Relative difference of values and the best sum of a profile and a level; height and level of each band."""
    shapes = np.stack([_profile(angle, width), np.ones_like(angle)], axis=1)
    # Every direction counts alike, by its share of what is there.
    weight = 1.0 / values.mean(axis=1, keepdims=True)
    found = np.linalg.lstsq(shapes * weight, values * weight, rcond=None)[0]
    found = np.maximum(found, 0.0)
    off = (shapes @ found - values) * weight
    return float(np.sqrt((off**2).mean())), found[0], found[1]
