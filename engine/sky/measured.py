"""Skies as they were measured: luminances of the 145 patches of Tregenza, or of any grid of directions.

They become pictures of even cells (`ImageWorld`), so what the engine knows of pictures holds for them: patches are met
exactly by pixels, as all their borders lie at multiples of 6 degrees of elevation and of half a degree of azimuth; grids are
linear in elevation and azimuth between their places, seen at the middles of cells of half a degree. Azimuths are those of
a compass, 0 north and 90 east.

A table of patches is 145 numbers, one a line, in the order of Radiance: rows from the horizon up, each from north over east;
sky scanners that go to and fro have to be sorted before. A table of a grid has the columns elevation, azimuth and luminance,
and a line for each pair of its elevations and azimuths, in any order.

References
----------
P. R. Tregenza: Subdivision of the sky hemisphere for luminance measurements, Lighting Research and Technology 19(1), 1987,
13-14, doi:10.1177/096032718701900103
"""

from dataclasses import dataclass

import numpy as np

from ..errors import FileFormatError, SceneError
from ..reading.content import read_bytes
from ..reading.text_table import MAXIMUM_BYTES, parse_table
from ..scene.light import ImageWorld
from ..scene.texture import ImageTexture

ROW_COUNTS = (30, 30, 24, 24, 18, 12, 6, 1)
"""Patches of each row, from the horizon up."""

PATCHES = sum(ROW_COUNTS)

BAND = 12.0
"""Height of a row but the last, which is the cap of half as much about the zenith. [degree]"""

PATCH_ROWS, PATCH_COLUMNS = 30, 720
"""Pixels of a picture of patches."""

GRID_ROWS, GRID_COLUMNS = 360, 720
"""Pixels of a picture of a grid."""

MOST_PLACES = 100_000
"""Of a grid."""

BRIGHTEST = 1e7
"""No sky without its sun is brighter. [cd/m2]"""


@dataclass(frozen=True, eq=False)
class SkyGrid:
    """Luminances over a grid.

    Parameters
    ----------
    elevations : (n,) array    Ascending, 0 to 90. [degree]
    azimuths : (m,) array    Ascending, 0 to less than 360. [degree]
    luminances : (n, m) array    [cd/m2]
    """

    elevations: np.ndarray
    azimuths: np.ndarray
    luminances: np.ndarray


def patch_bounds() -> np.ndarray:
    """Return lowest and highest elevation, and first and last azimuth, of every patch. (145, 4) [degree]

    The first azimuth of the patches about north is negative.
    """
    bounds = []
    for row, count in enumerate(ROW_COUNTS):
        low, high, width = row * BAND, min((row + 1) * BAND, 90.0), 360.0 / count
        bounds += [(low, high, (k - 0.5) * width, (k + 0.5) * width) for k in range(count)]
    return np.array(bounds)


def horizontal_weights() -> np.ndarray:
    """Return what each patch's luminance adds to the illuminance of a horizontal plane. (145,) [sr]"""
    low, high, start, end = np.radians(patch_bounds()).T
    return 0.5 * (end - start) * (np.sin(high) ** 2 - np.sin(low) ** 2)


def find_patches(directions) -> np.ndarray:
    """Return the patch of directions, from 0.

    Parameters
    ----------
    directions : (..., 3) array    Unit vectors, +z up, +y north.

    Returns
    -------
    (...) int array    -1 below the horizon.
    """
    directions = np.asarray(directions, dtype=np.float64)
    elevation = np.degrees(
        np.arctan2(directions[..., 2], np.hypot(*np.moveaxis(directions, -1, 0)[:2]))
    )
    azimuth = np.degrees(np.arctan2(directions[..., 0], directions[..., 1]))
    row = np.clip(elevation // BAND, 0, len(ROW_COUNTS) - 1).astype(np.int64)
    counts = np.array(ROW_COUNTS)
    firsts = np.cumsum(counts) - counts
    place = np.floor(azimuth * counts[row] / 360.0 + 0.5).astype(np.int64) % counts[row]
    return np.where(elevation >= 0.0, firsts[row] + place, -1)


def make_patch_world(luminances, ground_reflectance: float = 0.0) -> ImageWorld:
    """Return the sky of 145 patches over an evenly bright ground.

    Parameters
    ----------
    luminances : (145,) array    In the order of Radiance. [cd/m2]
    ground_reflectance : float    As of `CieSky`. [-]

    Raises
    ------
    SceneError    There are not 145 luminances, or one is negative, missing or absurd.
    """
    luminances = _checked(luminances, (PATCHES,))
    illuminance = float(horizontal_weights() @ luminances)
    directions = _pixel_directions(PATCH_ROWS, PATCH_COLUMNS)
    return make_world(luminances[find_patches(directions)], illuminance, ground_reflectance)


def make_grid_world(grid: SkyGrid, ground_reflectance: float = 0.0) -> ImageWorld:
    """Return the sky of a grid over an evenly bright ground.

    Below the lowest elevation the sky goes on as it is there; above the highest it leads to the mean of that row at the
    zenith.

    Parameters
    ----------
    grid : SkyGrid
    ground_reflectance : float    As of `CieSky`. [-]

    Raises
    ------
    SceneError    The grid is none.
    """
    elevations, azimuths = (np.asarray(x, np.float64) for x in (grid.elevations, grid.azimuths))
    luminances = _checked(grid.luminances, (len(elevations), len(azimuths)))
    is_rising = all((np.diff(x) > 0.0).all() for x in (elevations, azimuths))
    if not len(luminances) or not is_rising or elevations[0] < 0.0 or elevations[-1] > 90.0:
        raise SceneError("the sky's elevations do not ascend within 0 to 90 degrees")
    if azimuths[0] < 0.0 or azimuths[-1] >= 360.0:
        raise SceneError("the sky's azimuths do not ascend from 0 to less than 360 degrees")
    if elevations[-1] < 90.0:
        elevations = np.append(elevations, 90.0)
        top = np.full((1, len(azimuths)), luminances[-1].mean())
        luminances = np.concatenate([luminances, top])
    # Round the circle.
    azimuths = np.append(azimuths, azimuths[0] + 360.0)
    luminances = np.concatenate([luminances, luminances[:, :1]], axis=1)
    height = (np.arange(GRID_ROWS // 2) + 0.5) * 180.0 / GRID_ROWS
    # Column j has its middle at u = (j + 1/2) / columns, and north at a quarter.
    turn = ((np.arange(GRID_COLUMNS) + 0.5) / GRID_COLUMNS - 0.25) * 360.0
    turn = azimuths[0] + (turn - azimuths[0]) % 360.0
    along = np.array([np.interp(turn, azimuths, row) for row in luminances])
    above = np.array([np.interp(height, elevations, column) for column in along.T]).T
    edges = np.radians(np.arange(GRID_ROWS // 2 + 1) * 180.0 / GRID_ROWS)
    weights = 0.5 * np.diff(np.sin(edges) ** 2) * 2.0 * np.pi
    illuminance = float(weights @ above.mean(axis=1))
    pixels = np.concatenate([np.zeros_like(above), above])
    return make_world(pixels, illuminance, ground_reflectance)


def find_luminances(measured, directions) -> np.ndarray:
    """Return the luminance that a measured sky has in directions, over a black ground.

    Parameters
    ----------
    measured : (145,) array or SkyGrid    As `read_measured_sky` gives it.
    directions : (..., 3) array    Unit vectors, +z up, +y north.

    Returns
    -------
    (...) float64 array    That of the patch, or of the cell of half a degree. [cd/m2]

    Raises
    ------
    SceneError    As `make_patch_world` and `make_grid_world`.
    """
    directions = np.asarray(directions, dtype=np.float64)
    if not isinstance(measured, SkyGrid):
        patch = find_patches(directions)
        return np.where(patch >= 0, _checked(measured, (PATCHES,))[patch], 0.0)
    return look_up(make_grid_world(measured), directions)


def look_up(world: ImageWorld, directions) -> np.ndarray:
    """Return the luminance that the picture of a sky has in directions. (..., 3) -> (...) [cd/m2]"""
    directions = np.asarray(directions, dtype=np.float64)
    pixels = world.image.pixels[..., 0]
    rows, columns = pixels.shape
    polar = np.arccos(np.clip(-directions[..., 2], -1.0, 1.0))
    turn = np.arctan2(directions[..., 0], directions[..., 1]) / (2.0 * np.pi) + 0.25
    row = np.minimum((polar / np.pi * rows).astype(np.int64), rows - 1)
    return pixels[row, np.floor(turn * columns).astype(np.int64) % columns].astype(np.float64)


def make_world(pixels: np.ndarray, illuminance: float, ground_reflectance: float) -> ImageWorld:
    """Return the sky of a picture over an evenly bright ground.

    Parameters
    ----------
    pixels : (rows, columns) array    Luminances, from the lowest row up; the lower half does not count. [cd/m2]
    illuminance : float    Horizontal illuminance by which the ground is lit. [lx]
    ground_reflectance : float    As of `CieSky`. [-]

    Raises
    ------
    SceneError    The reflectance is none.
    """
    if not 0.0 <= ground_reflectance <= 1.0:
        raise SceneError(f"the reflectance of the ground is {ground_reflectance}, expected 0 to 1")
    pixels = np.array(pixels, dtype=np.float32)
    pixels[: len(pixels) // 2] = ground_reflectance * illuminance / np.pi
    pixels = np.repeat(pixels[..., None], 3, axis=-1)
    # What follows from them is found once.
    pixels.flags.writeable = False
    return ImageWorld(ImageTexture(pixels, interpolation="closest"), 1.0)


def _checked(luminances, shape) -> np.ndarray:
    luminances = np.asarray(luminances, dtype=np.float64)
    if luminances.shape != shape:
        raise SceneError(
            f"the sky has luminances of the shape {luminances.shape}, expected {shape}"
        )
    if not ((luminances >= 0.0) & (luminances <= BRIGHTEST)).all():
        raise SceneError(f"a luminance of the sky is not within 0 to {BRIGHTEST:g} cd/m2")
    return luminances


def _pixel_directions(rows: int, columns: int) -> np.ndarray:
    """Middles of a picture's pixels, from the lowest row up. (rows, columns, 3)"""
    polar = np.pi * (np.arange(rows) + 0.5)[:, None] / rows
    turn = 2.0 * np.pi * ((np.arange(columns) + 0.5) / columns - 0.25)
    return np.stack(
        np.broadcast_arrays(
            np.sin(polar) * np.sin(turn), np.sin(polar) * np.cos(turn), -np.cos(polar)
        ),
        axis=-1,
    )


# ---- files ----


def read_measured_sky(path) -> np.ndarray | SkyGrid:
    """Read a table of luminances in cd/m2.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    (145,) array or SkyGrid

    Raises
    ------
    FileFormatError    It is no such table; names the line.
    """
    return parse_measured_sky(path, read_bytes(path, MAXIMUM_BYTES))


def parse_measured_sky(path, data: bytes) -> np.ndarray | SkyGrid:
    """Read the content of such a table; the parameters and errors are those of `read_measured_sky`."""
    expected = "a luminance, or elevation, azimuth and luminance"
    rows = parse_table(path, data, 1, expected).rows
    if not rows:
        raise FileFormatError(path, f"has no numbers, expected {expected} in each line")
    width = len(rows[0][1])
    if width not in {1, 3}:
        raise FileFormatError(path, f"has {width} columns, expected {expected}", rows[0][0])
    for line, values in rows:
        if len(values) != width or None in values:
            raise FileFormatError(path, f"has {len(values)} numbers, expected {width}", line)
        if not 0.0 <= values[-1] <= BRIGHTEST:
            raise FileFormatError(
                path, f"has the luminance {values[-1]:g}, expected 0 to {BRIGHTEST:g} cd/m2", line
            )
    if width == 3:
        return _grid(path, rows)
    if len(rows) != PATCHES:
        raise FileFormatError(path, f"has {len(rows)} luminances, expected those of 145 patches")
    return np.array([values[0] for _, values in rows])


def _grid(path, rows) -> SkyGrid:
    if len(rows) > MOST_PLACES:
        raise FileFormatError(path, f"has more than {MOST_PLACES} places", rows[MOST_PLACES][0])
    for line, (elevation, azimuth, _) in rows:
        if not (0.0 <= elevation <= 90.0 and 0.0 <= azimuth < 360.0):
            raise FileFormatError(
                path,
                f"has the elevation {elevation:g} and the azimuth {azimuth:g}, expected 0 to 90 and 0 to less than 360",
                line,
            )
    table = np.array([values for _, values in rows])
    elevations, row = np.unique(table[:, 0], return_inverse=True)
    azimuths, column = np.unique(table[:, 1], return_inverse=True)
    if len(elevations) * len(azimuths) != len(rows):
        raise FileFormatError(
            path,
            f"has {len(rows)} places, expected {len(elevations)} elevations times {len(azimuths)} azimuths",
        )
    luminances = np.full((len(elevations), len(azimuths)), np.nan)
    luminances[row.ravel(), column.ravel()] = table[:, 2]
    if np.isnan(luminances).any():
        i, j = np.argwhere(np.isnan(luminances))[0]
        raise FileFormatError(
            path,
            f"has nothing at the elevation {elevations[i]:g} and the azimuth {azimuths[j]:g}, and another place twice",
        )
    return SkyGrid(elevations, azimuths, luminances)
