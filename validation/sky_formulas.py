"""Luminances of skies, written by the formulas and shared with nothing of the engine, so that a mistake there shows.

For reference values and for the other programs. Directions are unit vectors (..., 3), +z up and +y north; what is below the
horizon is not of the sky.

References
----------
CIE S 011/E:2003 (ISO 15469:2004), type 12, and the traditional overcast sky
R. Perez, R. Seals, J. Michalsky: All-weather model for sky luminance distribution, Solar Energy 50(3), 1993, 235-245,
table 1; erratum in 51(5), 1993, 423
P. R. Tregenza: Subdivision of the sky hemisphere for luminance measurements, Lighting Research and Technology 19(1), 1987
"""

import numpy as np

PEREZ = """
1.3525 -0.2576 -0.2690 -1.4366   -0.7670 0.0007 1.2734 -0.1233   2.8000 0.6004 1.2375 1.0000
      1.8734 0.6297 0.9738 0.2809   0.0356 -0.1246 -0.5718 0.9938
-1.2219 -0.7730 1.4148 1.1016   -0.2054 0.0367 -3.9128 0.9156   6.9750 0.1774 6.4477 -0.1239
      -1.5798 -0.5081 -1.7812 0.1080   0.2624 0.0672 -0.2190 -0.4285
-1.1000 -0.2515 0.8952 0.0156   0.2782 -0.1812 -4.5000 1.1766   24.7219 -13.0812 -37.7000 34.8438
      -5.0000 1.5218 3.9229 -2.6204   -0.0156 0.1597 0.4199 -0.5562
-0.5484 -0.6654 -0.2672 0.7117   0.7234 -0.6219 -5.6812 2.6297   33.3389 -18.3000 -62.2500 52.0781
      -3.5000 0.0016 1.1477 0.1062   0.4659 -0.3296 -0.0876 -0.0329
-0.6000 -0.3566 -2.5000 2.3250   0.2937 0.0496 -5.6812 1.8415   21.0000 -4.7656 -21.5906 7.2492
      -3.5000 -0.1554 1.4062 0.3988   0.0032 0.0766 -0.0656 -0.1294
-1.0156 -0.3670 1.0078 1.4051   0.2875 -0.5328 -3.8500 3.3750   14.0000 -0.9999 -7.1406 7.5469
      -3.4000 -0.1078 -1.0750 1.5702   -0.0672 0.4016 0.3017 -0.4844
-1.0000 0.0211 0.5025 -0.5119   -0.3000 0.1922 0.7023 -1.6317   19.0000 -5.0000 1.2438 -1.9094
      -4.0000 0.0250 0.3844 0.2656   1.0468 -0.3788 -2.4517 1.4656
-1.0500 0.0289 0.4260 0.3590   -0.3250 0.1156 0.7781 0.0025   31.0625 -14.5000 -46.1148 55.3750
      -7.2312 0.4050 13.3500 0.6234   1.5000 -0.6426 1.8564 0.5636
"""
"""Four numbers for each of a to e, two lines for each class, overcast first."""

CLASS_ENDS = (1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2)
"""Clearness at which a class ends. [-]"""

PATCH_COUNTS = (30, 30, 24, 24, 18, 12, 6, 1)
"""Of Tregenza's rows, from the horizon up, 12 degrees each but the last."""

HORIZON = 0.01
"""Sine below which the gradation does not change, as in Radiance's perezlum.cal."""


def direction(elevation, azimuth) -> np.ndarray:
    """Unit vector by elevation and azimuth, north over east. [degree]"""
    height, turn = np.radians(elevation), np.radians(azimuth)
    parts = np.cos(height) * np.sin(turn), np.cos(height) * np.cos(turn), np.sin(height)
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def clear_sky(directions: np.ndarray, sun: np.ndarray) -> np.ndarray:
    """Luminance of the standard clear sky, type 12, in an unstated unit."""
    cosine = np.clip(directions @ sun, -1.0, 1.0)
    near = 10.0 * (np.exp(-3.0 * np.arccos(cosine)) - np.exp(-1.5 * np.pi)) + 0.45 * cosine**2
    return (1.0 + near) * (1.0 - np.exp(-0.32 / np.maximum(directions[..., 2], 1e-9)))


def overcast_sky(directions: np.ndarray) -> np.ndarray:
    """Luminance of the standard overcast sky over that of its zenith."""
    return (1.0 + 2.0 * directions[..., 2]) / 3.0


def perez_letters(clearness: float, brightness: float, sun_elevation: float) -> tuple:
    """Coefficients a to e of the all-weather sky. [-, -, degree -> -]"""
    kind = sum(clearness >= end for end in CLASS_ENDS)
    table = np.array(PEREZ.split(), dtype=np.float64).reshape(8, 5, 4)[kind]
    zenith = np.radians(90.0 - sun_elevation)
    if 1.065 < clearness < 2.8:
        brightness = max(brightness, 0.2)
    letters = [p + q * zenith + brightness * (r + s * zenith) for p, q, r, s in table]
    if kind == 0:
        p, q, r, s = table[2]
        letters[2] = np.exp((brightness * (p + q * zenith)) ** r) - s
        p, q, r, s = table[3]
        letters[3] = -np.exp(brightness * (p + q * zenith)) + r + brightness * s
    return tuple(float(letter) for letter in letters)


def perez_sky(directions: np.ndarray, sun: np.ndarray, letters) -> np.ndarray:
    """Luminance of the all-weather sky in an unstated unit."""
    a, b, c, d, e = letters
    cosine = np.clip(directions @ sun, -1.0, 1.0)
    gradation = 1.0 + a * np.exp(b / np.maximum(directions[..., 2], HORIZON))
    return gradation * (1.0 + c * np.exp(d * np.arccos(cosine)) + e * cosine**2)


def patch_sky(directions: np.ndarray, luminances) -> np.ndarray:
    """Luminance of Tregenza's patches in the order of Radiance. ``luminances``: (145,)."""
    height = np.degrees(np.arcsin(np.clip(directions[..., 2], 0.0, 1.0)))
    turn = np.degrees(np.arctan2(directions[..., 0], directions[..., 1])) % 360.0
    row = np.minimum(height / 12.0, 7.0).astype(int)
    count = np.array(PATCH_COUNTS)[row]
    # The first of a row has its middle in the north.
    place = np.rint(turn * count / 360.0).astype(int) % count
    first = np.array([sum(PATCH_COUNTS[:k]) for k in range(8)])
    return np.asarray(luminances)[first[row] + place]


def grid_sky(directions: np.ndarray, elevations, azimuths, luminances) -> np.ndarray:
    """Luminance of a table that is linear in elevation and azimuth between its places. ``luminances``: (n, m).

    The azimuths go round evenly from 0, and the last elevation is the zenith.
    """
    table = np.asarray(luminances, dtype=np.float64)
    rise = np.degrees(np.arcsin(np.clip(directions[..., 2], 0.0, 1.0)))
    turn = np.degrees(np.arctan2(directions[..., 0], directions[..., 1])) % 360.0
    row = np.clip(np.searchsorted(elevations, rise, side="right") - 1, 0, len(elevations) - 2)
    low, high = np.asarray(elevations)[row], np.asarray(elevations)[row + 1]
    up = np.clip((rise - low) / (high - low), 0.0, 1.0)
    # Below the lowest row the sky goes on as it is there.
    step = 360.0 / len(azimuths)
    column = np.minimum((turn / step).astype(int), len(azimuths) - 1)
    along, after = turn / step - column, (column + 1) % len(azimuths)
    below = (1.0 - along) * table[row, column] + along * table[row, after]
    above = (1.0 - along) * table[row + 1, column] + along * table[row + 1, after]
    return (1.0 - up) * below + up * above
