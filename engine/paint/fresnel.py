"""What smooth faces between clear media reflect, in terms of s = n sin(theta), which they keep."""

import numpy as np


def face_shares(sines, above, below) -> tuple[np.ndarray, np.ndarray]:
    """Reflectance for light polarised across the plane of incidence and within it; 1 beyond either medium's limit.

    Parameters
    ----------
    sines : array    n sin(theta).
    above, below : float or array    Refractive indices, of shapes that go together with it.

    Returns
    -------
    two arrays    The same from both sides. [-]
    """
    squared = np.asarray(sines, np.float64) ** 2
    upper, lower = above**2 - squared, below**2 - squared
    is_total = (upper <= 0.0) | (lower <= 0.0)
    upper, lower = np.sqrt(np.maximum(upper, 0.0)), np.sqrt(np.maximum(lower, 0.0))  # n cos
    shares = []
    for one, other in ((upper, lower), (below**2 * upper, above**2 * lower)):
        total = one + other
        amplitude = (one - other) / np.where(total == 0.0, 1.0, total)
        shares.append(np.where(is_total, 1.0, amplitude**2))
    return shares[0], shares[1]


def face_reflectance(sines, above, below) -> np.ndarray:
    """Reflectance for unpolarised light, as of `face_shares`."""
    across, within = face_shares(sines, above, below)
    return 0.5 * (across + within)
