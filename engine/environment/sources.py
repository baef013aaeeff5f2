"""Bright sources in an equirectangular picture: found by three coefficients, and what each gives.

A pixel brighter than the first coefficient makes a source. The source is the part within a radius, the second coefficient,
that is brighter than the third one; what it gives is the excess over that. Both luminances are multiples of the mean of the
segment, in which what is brighter than the third coefficient counts as that bright: so a sun does not raise the bar for
itself. The radius lies about the middle of what is brighter than the first coefficient.

References
----------
A. G. Voloboy: Software technologies that automate the making of realistic images, doctoral dissertation, Keldysh Institute
of Applied Mathematics, Moscow 2012 (in Russian), section 1.3.3; its factors of the mean are not told.
"""

from dataclasses import dataclass, field

import numpy as np

from ..errors import SceneError
from ..photometry.colour import REC709_LUMINANCE
from ..scene.memo import recall_latest
from ..scene.texture import ImageTexture
from ..sky.picture import ROWS_AT_ONCE, Grid, clean, find_luminances, grid_of
from .cells import Moments, azimuths, cell_sizes, directions, find_moments, first_row_above

SOURCE, EDGE = 20.0, 10.0
"""Luminances over the mean that make a source, and that belong to one. Beside their sun the CIE's clear skies have up to 16,
its most turbid ones up to 30 where the sun is lower than 10 degrees."""

RADIUS = np.radians(3.0)
"""Largest radius of a bright area. [rad]"""

MOST = 16
"""Sources that are found, the brightest first."""

LEAST = 0.02
"""Part of the light of all directions that a source gives at least; stars and faulty pixels stay in the picture. [-]"""

FAINT, ALONE, FEW = 1e-4, 2.0, 4
"""Part of that light from which on sources count where none gives so much, as a sun does that is clipped most, if at most so
many stand out: the last of them gives so many times the light of the next bright place."""

STEPS = 8
"""Steps in which the middle of a source is found."""

BORDER = 1.25
"""Width of the ring about a source by which it is judged whether it goes on there, over its radius. [-]"""

GOES_ON = 0.25
"""Part of the ring that is half as bright as the source, from which on it is a part of something larger. [-]"""

PLACES = 256
"""Bright places that are looked at, at most."""

BINS, DECADES = 4096, 12.0
"""Of the distribution of luminances by which their mean is found."""

FLOOR = 1e-4
"""Least mean over that of all light: in a black picture with a sun nothing else is there to be a mean. [-]"""


@dataclass(frozen=True)
class Coefficients:
    """What makes a bright source.

    Parameters
    ----------
    source : float    Luminance over the mean that makes one. [-]
    radius : float    Largest of a bright area. [rad]
    edge : float    Least luminance over the mean that belongs to one, not above ``source``. [-]
    is_upper : bool    Whether only the upper half is searched.
    """

    source: float = SOURCE
    radius: float = RADIUS
    edge: float = EDGE
    is_upper: bool = True


@dataclass(frozen=True, eq=False)
class Source:
    """A bright source of a picture; light in units of the picture's values times steradians.

    Parameters
    ----------
    towards : (3,) array    Unit vector of the picture's directions to the middle of its light, its glare included.
    core : (3,) array    To the middle of its brightest part: where a sun stands, whatever glows about it.
    irradiance : (3,) array    Linear Rec. 709 components of a plane that faces it, by the excess over the edge.
    angle : float    Diameter of an even disk with the same mean square of angles. [rad]
    peak : float    Largest luminance.
    solid_angle : float    Of the pixels that belong to it. [sr]
    rows, columns : (n,) int arrays    Those pixels.
    """

    towards: np.ndarray
    core: np.ndarray
    irradiance: np.ndarray
    angle: float
    peak: float
    solid_angle: float
    rows: np.ndarray = field(repr=False)
    columns: np.ndarray = field(repr=False)

    @property
    def illuminance(self) -> float:
        """Of a plane that faces it."""
        return float(REC709_LUMINANCE @ self.irradiance)

    def on(self, normal) -> float:
        """Illuminance of a plane. ``normal``: (3,), in the picture's directions."""
        return self.illuminance * max(float(self.towards @ np.asarray(normal)), 0.0)


@dataclass(frozen=True, eq=False)
class Search:
    """What was found in a picture.

    Parameters
    ----------
    mean : float    Luminance that the coefficients are multiples of, in the picture's values.
    edge : float    Luminance from which on pixels belong to sources, in the picture's values.
    sources : tuple of Source    The one that gives most first.
    wide : int    Bright places that are parts of something larger than the radius, such as a window; they stay.
    small : int    Bright places that give too little, or are too many; they stay.
    """

    mean: float
    edge: float
    sources: tuple[Source, ...] = ()
    wide: int = 0
    small: int = 0


def check_coefficients(coefficients: Coefficients) -> None:
    """Refuse coefficients that are none.

    Raises
    ------
    SceneError    Names what is wrong.
    """
    source, edge = coefficients.source, coefficients.edge
    if not (np.isfinite(source) and 1.0 < edge <= source):
        raise SceneError(
            f"the luminances of bright sources are {source:g} and {edge:g} times the mean, expected both above 1, the first "
            "one not below the second"
        )
    if not 0.0 < coefficients.radius <= np.radians(45.0):
        raise SceneError(
            f"the radius of bright areas is {np.degrees(coefficients.radius):g} degrees, expected 0 to 45"
        )


def find_sources(image: ImageTexture, coefficients: Coefficients | None = None) -> Search:
    """Find the bright sources of a picture.

    Parameters
    ----------
    image : ImageTexture    Equirectangular, as of `ImageWorld`.
    coefficients : Coefficients or None    None: by the rule.

    Raises
    ------
    SceneError    The coefficients are none.
    """
    coefficients = coefficients or Coefficients()
    check_coefficients(coefficients)
    state = (image.interpolation, coefficients)
    return recall_latest(image.pixels, "sources", (), state, lambda: _search(image, coefficients))


def _search(image: ImageTexture, coefficients: Coefficients) -> Search:
    grid = grid_of(image)
    pixels = clean(image.pixels)
    luminances = find_luminances(pixels)
    first = first_row_above(grid) if coefficients.is_upper else 0
    mean = find_mean_luminance(luminances, grid, first, coefficients.edge)
    search = Search(mean, coefficients.edge * mean)
    if mean <= 0.0:
        return search
    bright = _Bright.of(luminances, grid, first, search.edge)
    whole = float(cell_sizes(grid) @ luminances.sum(axis=1, dtype=np.float64))
    moments = find_moments(grid)
    found, wide, passed = [], 0, []
    for _ in range(PLACES):
        peak = bright.brightest()
        if peak is None or bright.luminances[peak] <= coefficients.source * mean:
            break
        part, middle = bright.gather(peak, coefficients, mean)
        bright.take(part)
        if bright.is_beside(peak, passed, coefficients.radius):
            wide += 1
            continue
        passed.append(middle)
        if bright.goes_on(part, middle, coefficients, mean):
            wide += 1
            continue
        found.append(_measure(bright, part, pixels, grid, moments, search.edge))
    found.sort(key=lambda source: -source.illuminance)
    kept = _keep(found, whole)
    return Search(mean, search.edge, tuple(kept), wide, len(found) - len(kept))


def _keep(found: list[Source], whole: float) -> list[Source]:
    """Return the sources that give enough of all light, or else the few that stand out."""
    kept = [source for source in found[:MOST] if source.illuminance >= LEAST * whole]
    if kept:
        return kept
    light = [source.illuminance for source in found]
    for count in range(1, min(FEW, len(found)) + 1):
        if light[count - 1] < FAINT * whole:
            break
        if count == len(found) or light[count - 1] >= ALONE * light[count]:
            return found[:count]
    return []


def find_mean_luminance(luminances: np.ndarray, grid: Grid, first: int, edge: float) -> float:
    """Return the mean luminance of rows from ``first`` on, in which ``edge`` times that mean is the most that counts.

    Parameters
    ----------
    luminances : (height, width) array    Not below 0.
    grid : Grid
    first : int
    edge : float    Above 1.
    """
    sizes = cell_sizes(grid)
    largest = float(luminances[first:].max(initial=0.0))
    if largest <= 0.0:
        return 0.0
    solid, light = np.zeros(BINS + 1), np.zeros(BINS + 1)
    per_decade = BINS / DECADES
    for start in range(first, grid.height, ROWS_AT_ONCE):
        part = luminances[start : start + ROWS_AT_ONCE]
        with np.errstate(divide="ignore"):
            place = np.log10(part / np.float32(largest)) * np.float32(per_decade) + np.float32(BINS)
        number = np.clip(place, 0, BINS).astype(np.int16).ravel()
        size = np.repeat(sizes[start : start + len(part)], grid.width)
        solid += np.bincount(number, size, BINS + 1)
        light += np.bincount(number, size * part.ravel(), BINS + 1)
    whole, plain = solid.sum(), light.sum() / solid.sum()
    means = light / np.maximum(solid, 1e-300)
    mean = plain
    for _ in range(100):
        clipped = float((solid * np.minimum(means, edge * mean)).sum() / whole)
        if clipped >= (1.0 - 1e-6) * mean or clipped < FLOOR * plain:
            break
        mean = clipped
    return max(mean, FLOOR * plain)


class _Bright:
    """Pixels above the edge: (n,) rows, columns, luminances and solid angles, (n, 3) directions; what is taken is off."""

    def __init__(self, rows, columns, luminances, grid: Grid):
        self.rows, self.columns, self.luminances = rows, columns, luminances
        self.directions = directions(rows, columns, grid)
        self.sizes = cell_sizes(grid)[rows]
        self.is_free = np.ones(len(rows), dtype=bool)
        self.pixel = np.pi / grid.height

    @classmethod
    def of(cls, luminances: np.ndarray, grid: Grid, first: int, edge: float) -> "_Bright":
        rows, columns = [], []
        for start in range(first, grid.height, ROWS_AT_ONCE):
            row, column = np.nonzero(luminances[start : start + ROWS_AT_ONCE] > edge)
            rows.append(row.astype(np.int32) + start)
            columns.append(column.astype(np.int32))
        row, column = (
            np.concatenate(each) if each else np.zeros(0, int) for each in (rows, columns)
        )
        return cls(row, column, luminances[row, column], grid)

    def brightest(self) -> int | None:
        """Number of the brightest pixel that is free, None without one."""
        if not self.is_free.any():
            return None
        return int(np.argmax(np.where(self.is_free, self.luminances, -1.0)))

    def gather(self, peak: int, coefficients: Coefficients, mean: float):
        """Numbers of the pixels about a peak that belong to its source, and the middle of the bright ones of them."""
        middle = self.directions[peak].astype(np.float64)
        # A clipped sun is even: the first of its brightest pixels lies at its edge, so the middle moves inwards.
        for _ in range(STEPS):
            near = self._within(middle, coefficients.radius)
            core = near[self.luminances[near] > coefficients.source * mean]
            light = self.sizes[core] * (self.luminances[core] - coefficients.edge * mean)
            before = middle
            middle = light @ self.directions[core].astype(np.float64)
            middle /= np.linalg.norm(middle)
            if np.linalg.norm(middle - before) < 0.1 * self.pixel:
                break
        return self._within(middle, coefficients.radius), middle

    def _within(self, middle, radius: float) -> np.ndarray:
        return np.flatnonzero(self.is_free & (self._chords(middle) <= 2.0 * np.sin(0.5 * radius)))

    def _chords(self, middle) -> np.ndarray:
        # By the chord: a cosine in single precision loses small angles.
        return np.linalg.norm(self.directions - np.asarray(middle, dtype=np.float32), axis=1)

    def take(self, part) -> None:
        """Leave pixels out from now on."""
        self.is_free[part] = False

    def is_beside(self, peak: int, middles, radius: float) -> bool:
        """Tell whether a peak is only the rest of a place that was looked at before, at its border."""
        reach = max(BORDER * radius, radius + 2.0 * self.pixel)
        chord = 2.0 * np.sin(0.5 * min(reach, np.pi))
        return any(np.linalg.norm(self.directions[peak] - middle) <= chord for middle in middles)

    def goes_on(self, part, middle, coefficients: Coefficients, mean: float) -> bool:
        """Tell whether a place is as bright beyond its radius as within it."""
        core = part[self.luminances[part] > coefficients.source * mean]
        if not len(core):
            return False
        level = float(self.sizes[core] @ self.luminances[core]) / float(self.sizes[core].sum())
        radius, outer = coefficients.radius, BORDER * coefficients.radius
        chords = self._chords(middle)
        ring = (chords > 2.0 * np.sin(0.5 * radius)) & (chords <= 2.0 * np.sin(0.5 * outer))
        least = max(coefficients.source * mean, 0.5 * level)
        covered = float(self.sizes[ring & (self.luminances > least)].sum())
        return covered > GOES_ON * 2.0 * np.pi * (np.cos(radius) - np.cos(outer))


def _measure(bright: _Bright, part, pixels, grid: Grid, moments: Moments, edge: float) -> Source:
    """Return the source of pixels."""
    rows, columns = bright.rows[part], bright.columns[part]
    luminances = bright.luminances[part].astype(np.float64)
    excess = pixels[rows, columns].astype(np.float64) * (1.0 - edge / luminances)[:, None]
    if excess.shape[1] == 1:
        excess = np.repeat(excess, 3, axis=1)
    turn, plan = azimuths(columns, grid.width), moments.plan[rows]
    weights = np.stack([plan * np.cos(turn), plan * np.sin(turn), moments.up[rows]], axis=1)
    vectors = excess.T @ weights
    towards = REC709_LUMINANCE @ vectors
    towards = towards / np.linalg.norm(towards)
    # The glow of a low sun covers more of the sky than its disk, which is brighter than the mean of its light.
    above, sizes = luminances - edge, bright.sizes[part]
    level = (sizes @ above**2) / (sizes @ above)
    core = (sizes * np.maximum(above - 0.25 * level, 0.0)) @ bright.directions[part]
    apart = 2.0 * np.arcsin(
        np.clip(0.5 * np.linalg.norm(bright.directions[part] - towards, axis=1), 0.0, 1.0)
    )
    light = (luminances - edge) * moments.solid[rows]
    spread = float(light @ apart**2) / float(light.sum())
    return Source(
        towards,
        core / np.linalg.norm(core),
        np.maximum(vectors @ towards, 0.0),
        float(min(2.0 * np.sqrt(2.0 * spread), np.pi)),
        float(luminances.max()),
        float(bright.sizes[part].sum()),
        rows,
        columns,
    )
