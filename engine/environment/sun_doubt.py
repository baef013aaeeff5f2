"""Lamp or sun: what speaks against a picture's bright source being the sun, in words.

A small lamp alone looks as a sun does in many ways. What differs are its size, its colour over that of all else (air
scatters the blue of sunlight into the sky, while walls keep more of a lamp's blue than of its red), and how far it outshines
the rest. None of these proves a sun, so a picture about which nothing is said may still show a lamp.
"""

import numpy as np

from ..scene.texture import ImageTexture
from ..sky.picture import ROWS_AT_ONCE, clean, find_luminances, grid_of
from .cells import cell_sizes, find_moments, first_row_above
from .repair import clear_ratio
from .scale import UPWARDS
from .sources import Source

WIDEST = 2.0
"""Diameter of what is at least half as bright as the brightest pixel up to which it may be the sun, clipped. [degree]"""

BLUER = 1.05
"""Blue over red of a source, over that of all other light from above, from which on it is told. [-]"""

PUREST, BEYOND = 2.0, 1.5
"""Luminous turbidity of the clearest air, and what of the sun's part in it a lamp has to outshine. [-]"""


def find_doubts(
    source: Source, image: ImageTexture, clipped: ImageTexture, ratio, elevation, up=UPWARDS
):
    """Return what speaks against a source being the sun.

    Parameters
    ----------
    source : Source
    image, clipped : ImageTexture    The picture, and without its sources.
    ratio : float or None    Horizontal illuminance by the source over that by all else. [-]
    elevation : float    Of the source. [degree]
    up : (3,) array    Upwards in the picture's directions.

    Returns
    -------
    tuple of str    Reasons; none where nothing speaks against it.
    """
    made: list[str] = []
    width = find_core_width(source, image)
    if width > WIDEST:
        made.append(f"it is {width:.1f}° wide, the sun 0.53°")
    share, rest = _blue_share(source.irradiance), _blue_share(_light_from_above(clipped))
    # Turned pictures have no rows by which light from above could be told.
    if share is not None and rest is not None and np.allclose(up, UPWARDS) and share > BLUER * rest:
        made.append(
            "its light is bluer than that of all else, while a sun's is redder than the sky's"
        )
    most = BEYOND * clear_ratio(max(elevation, 1.0), PUREST)
    if ratio is not None and ratio > most:
        made.append(
            f"it gives {ratio:.3g} times the light of all else, the sun {most / BEYOND:.2g} times at most"
        )
    return tuple(made)


def find_core_width(source: Source, image: ImageTexture) -> float:
    """Return the diameter of an even disk as large as what is at least half as bright as a source's peak. [degree]"""
    grid = grid_of(image)
    values = clean(image.pixels[source.rows, source.columns][None])[0]
    bright = find_luminances(values[None])[0] >= 0.5 * source.peak
    solid = float(cell_sizes(grid)[source.rows[bright]].sum())
    return float(np.degrees(2.0 * np.sqrt(solid / np.pi)))


def _blue_share(light) -> float | None:
    """Blue over red, None where there is no red."""
    return float(light[2] / light[0]) if light[0] > 0.0 else None


def _light_from_above(image: ImageTexture) -> np.ndarray:
    """Components of the light of the upper half on a horizontal plane, in the picture's values. (3,)"""
    grid = grid_of(image)
    weights, total = find_moments(grid).up, np.zeros(3)
    for start in range(first_row_above(grid), grid.height, ROWS_AT_ONCE):
        part = clean(image.pixels[start : start + ROWS_AT_ONCE]).astype(np.float64).sum(axis=1)
        total += weights[start : start + ROWS_AT_ONCE] @ np.broadcast_to(part, (len(part), 3))
    return total
