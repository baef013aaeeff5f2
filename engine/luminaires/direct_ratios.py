"""Direct ratios: which share of a luminaire's downward flux meets the floor of a room directly."""

import numpy as np

from .coordinates import directions
from .distribution import TURN, intensity

ROOM_INDICES = (0.6, 0.8, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0)
"""Room indices of EULUMDAT, k = l w / (h (l + w))."""

_STEPS = (360, 360)
"""Points of the midpoint rule in azimuth and polar angle; the ratios of a Lambertian luminaire are then good to 1e-4."""


def direct_ratios(distribution) -> np.ndarray:
    """Share of the downward flux that meets the floor of square rooms, for `ROOM_INDICES`.

    The luminaires are spread evenly over the ceiling, sides along the walls. A beam that lands at (x, y) from below its
    luminaire then meets the floor, of side a, with the probability (1 - |x| / a) (1 - |y| / a).

    Returns
    -------
    (10,) float64 array    All 0 if nothing is emitted downwards.

    Notes
    -----
    EULUMDAT only names these numbers. This is the direct ratio of the utilisation factor method (CIE 40-1978) in the limit
    of many luminaires. Those in the files of several makers agree to 0.013; others reckon with a grid of luminaires at a
    spacing and state up to 0.12 more for small rooms.
    """
    azimuth = (np.arange(_STEPS[0]) + 0.5) * TURN / _STEPS[0]
    polar = (np.arange(_STEPS[1]) + 0.5) * 0.5 * np.pi / _STEPS[1]
    direction = directions(azimuth[:, None], polar)
    share_of_flux = intensity(distribution, direction) * np.sin(polar)
    total = share_of_flux.sum()
    if total <= 0.0:
        return np.zeros(len(ROOM_INDICES))
    # Distances on the floor, in heights of the room above it.
    x, y = (np.abs(direction[..., axis] / direction[..., 2]) for axis in (0, 1))
    sides = 2.0 * np.array(ROOM_INDICES)
    return (
        np.array(
            [
                (share_of_flux * np.maximum(1.0 - x / a, 0.0) * np.maximum(1.0 - y / a, 0.0)).sum()
                for a in sides
            ]
        )
        / total
    )
