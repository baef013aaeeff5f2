"""What a picture of the surroundings holds as light, and what that means for renders, in words.

References
----------
A. G. Voloboy: Software technologies that automate the making of realistic images, doctoral dissertation, Keldysh Institute
of Applied Mathematics, Moscow 2012 (in Russian), section 1.3.4
"""

from dataclasses import dataclass, replace

import numpy as np

from ..scene.texture import ImageTexture
from ..sky.picture import (
    ROWS_AT_ONCE,
    clean,
    count_faults,
    find_illuminance,
    find_luminances,
    grid_of,
)
from .cells import place_of
from .extraction import clip_sources
from .repair import clear_ratio, find_sun_of
from .scale import UPWARDS
from .sources import Coefficients, Source, find_sources
from .sun_doubt import find_doubts

DARKEST = 1.0
"""Luminance to which everything below is lifted: eyes tell no difference there. [cd/m2]"""

SUNNY_RANGE, CLOUDY_RANGE = 1e6, 1e5
"""Range of luminances of surroundings with a visible sun, and with a partly cloudy sky: those of the CIE's skies, and about
two powers of ten that the ground adds. [-]"""

CLIPPED = 0.6
"""Part of the sunlight that is usual below which a sun is called clipped. [-]"""

LOW = 3.0
"""Height of the sun below which no ratio to the sky is usual. [degree]"""


@dataclass(frozen=True, eq=False)
class SourceRow:
    """A bright source in real units.

    Parameters
    ----------
    elevation, azimuth : float    Of its brightest part in the world, the azimuth from +y over +x. [degree]
    row, column : float    Place in the picture, from its top and from its left. [pixel]
    diameter : float    Of an even disk as wide. [degree]
    luminance : float    The largest. [cd/m2]
    illuminance, horizontal : float    Of a plane that faces it, and of a horizontal one. [lx]
    is_sun : bool    Whether it is taken for the sun.
    """

    elevation: float
    azimuth: float
    row: float
    column: float
    diameter: float
    luminance: float
    illuminance: float
    horizontal: float
    is_sun: bool


@dataclass(frozen=True, eq=False)
class Analysis:
    """What a picture holds.

    Parameters
    ----------
    width, height : int    [pixel]
    per_unit : float    Luminance of a value of 1. [cd/m2]
    largest, range : float    Largest luminance [cd/m2], and that over the least one, both lifted to `DARKEST`. [-]
    horizontal : float    Illuminance of a horizontal plane. [lx]
    below : float    Of a plane that faces down. [lx]
    rest : float    Horizontal illuminance by all but the bright sources. [lx]
    conserved : float    Horizontal illuminance of the clipped picture and its lights over that of the picture. [-]
    mean, edge : float    What the coefficients are multiples of, and from which on pixels belong to sources. [cd/m2]
    wide, small : int    Bright places that stay, as of `Search`.
    faults : (int, int, int)    Pixels that are NaN, infinite and negative.
    sources : tuple of SourceRow
    verdict : tuple of str    What that means, a sentence each.
    doubts : tuple of str    What speaks against the sun being one, and for a lamp.
    """

    width: int
    height: int
    per_unit: float
    largest: float
    range: float
    horizontal: float
    below: float
    rest: float
    conserved: float
    mean: float
    edge: float
    wide: int
    small: int
    faults: tuple[int, int, int]
    sources: tuple[SourceRow, ...]
    verdict: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()

    @property
    def sun(self) -> SourceRow | None:
        """The source that is taken for the sun."""
        return next((row for row in self.sources if row.is_sun), None)

    @property
    def ratio(self) -> float | None:
        """Horizontal illuminance of the sun over that of all but it; None without a sun or without anything else."""
        if self.sun is None:
            return None
        others = self.horizontal - self.sun.horizontal
        return self.sun.horizontal / others if others > 0.0 else None


def analyse(
    image: ImageTexture,
    per_unit: float,
    coefficients: Coefficients | None = None,
    choose_sun=find_sun_of,
    rotation: np.ndarray | None = None,
) -> Analysis:
    """Analyse a picture.

    Parameters
    ----------
    image : ImageTexture    Equirectangular.
    per_unit : float    Luminance of a value of 1. [cd/m2]
    coefficients : Coefficients or None    As of `find_sources`.
    choose_sun : callable    From a `Search` and the upward direction to the source that is the sun, or None.
    rotation : (3, 3) array or None    As of `ImageWorld`; None: the picture is upright, and its +y is the world's.

    Raises
    ------
    SceneError    The coefficients are none.
    """
    search = find_sources(image, coefficients)
    clipped = clip_sources(image, coefficients)
    rotation = np.eye(3) if rotation is None else np.asarray(rotation, dtype=np.float64)
    up = np.array(UPWARDS)
    before, after, below = (
        find_illuminance(each, rotation, normal)
        for each, normal in ((image, up), (clipped, up), (image, -up))
    )
    sun = choose_sun(search, rotation @ up)
    rows = tuple(
        _describe(source, image, per_unit, source is sun, rotation) for source in search.sources
    )
    together = after + sum(source.on(rotation @ up) for source in search.sources)
    least, largest = _limits(image)
    low, high = (max(each * per_unit, DARKEST) for each in (least, largest))
    height, width = image.pixels.shape[:2]
    made = Analysis(
        width,
        height,
        per_unit,
        largest * per_unit,
        high / low,
        before * per_unit,
        below * per_unit,
        after * per_unit,
        together / before if before > 0.0 else 1.0,
        search.mean * per_unit,
        search.edge * per_unit,
        search.wide,
        search.small,
        count_faults(image.pixels),
        rows,
    )
    if sun is not None:
        found = find_doubts(sun, image, clipped, made.ratio, made.sun.elevation, rotation @ up)
        made = replace(made, doubts=found)
    return replace(made, verdict=tell_verdict(made))


def _describe(source: Source, image, per_unit: float, is_sun: bool, rotation) -> SourceRow:
    x, y, z = (float(each) for each in rotation.T @ source.core)
    grid = grid_of(image)
    row, column = place_of(source.core, grid)
    return SourceRow(
        float(np.degrees(np.arcsin(np.clip(z, -1.0, 1.0)))),
        float(np.degrees(np.arctan2(x, y)) % 360.0),
        grid.height - row,
        column,
        float(np.degrees(source.angle)),
        source.peak * per_unit,
        source.illuminance * per_unit,
        source.on(rotation @ np.array(UPWARDS)) * per_unit,
        is_sun,
    )


def _limits(image) -> tuple[float, float]:
    """Least and largest luminance, in the picture's values."""
    pixels = clean(image.pixels)
    parts = [
        find_luminances(pixels[i : i + ROWS_AT_ONCE]) for i in range(0, len(pixels), ROWS_AT_ONCE)
    ]
    return min(float(p.min()) for p in parts), max(float(p.max()) for p in parts)


# ---- words ----


def tell_verdict(analysis: Analysis) -> tuple[str, ...]:
    """Return what an analysis means for renders, a sentence each."""
    if not analysis.horizontal > 0.0 and not analysis.below > 0.0:
        return ("the picture is black",)
    told = [_tell_sources(analysis)]
    if analysis.doubts:
        told.append(f"lamp or sun? {', and '.join(analysis.doubts)}")
    told.append(_tell_range(analysis))
    if analysis.wide:
        told.append("large bright areas, such as windows or a bright cloud, stay in the picture")
    return tuple(told)


def _tell_sources(analysis: Analysis) -> str:
    sun, others = analysis.sun, len(analysis.sources) - (analysis.sun is not None)
    beside = f", beside {_count(others)}" if others else ""
    if sun is None:
        if not analysis.sources:
            return "no bright source: even light, soft shadows"
        return f"{_count(others)}, none that stands out as a sun"
    name = "a sun or a lamp" if analysis.doubts else "a sun"
    if analysis.ratio is None:
        return f"{name} and nothing else{beside}"
    is_weak, usual = judge_sun(analysis)
    shown = format_ratio(analysis.ratio)
    if usual is None:
        return f"{name} on the horizon at {shown}{beside}"
    if is_weak:
        return f"{name} clipped at {shown}{beside}; clear weather gives about {usual:.1f} : 1; expect weak shadows"
    if analysis.doubts:
        return f"{name} at {shown}{beside}; expect clear shadows"
    return f"a sun at {shown}{beside}, as in clear weather; expect clear shadows"


def judge_sun(analysis: Analysis) -> tuple[bool, float | None]:
    """Tell whether the sun gives less than is usual over the sky, and what is usual; None where nothing is."""
    if analysis.sun is None or analysis.ratio is None or analysis.sun.elevation < LOW:
        return False, None
    usual = clear_ratio(analysis.sun.elevation)
    return analysis.ratio < CLIPPED * usual, usual


def _tell_range(analysis: Analysis) -> str:
    shown = f"range {format_range(analysis.range)}"
    if analysis.range >= SUNNY_RANGE:
        return f"{shown}, as surroundings with a visible sun have"
    if analysis.range >= CLOUDY_RANGE:
        return (
            f"{shown}, as surroundings under a partly cloudy sky have, too little for a visible sun"
        )
    if analysis.range >= 1e3:
        return f"{shown}, less than outdoors in daylight"
    return f"{shown}, that of an ordinary photograph"


def _count(number: int) -> str:
    return "one bright lamp" if number == 1 else f"{number} bright lamps"


def format_ratio(ratio: float) -> str:
    """Return a ratio as people say it: 4.2 : 1, or 1 : 3."""
    if ratio >= 1.0:
        return f"{ratio:.2g} : 1"
    return f"1 : {1.0 / ratio:.2g}" if ratio > 0.0 else "0 : 1"


def format_range(value: float) -> str:
    """Return a range of luminances as people read it: 12 000 000 : 1."""
    return f"{float(f'{value:.2g}'):,.0f} : 1".replace(",", " ")
