"""A cloth from so near that its threads are seen: a picture of one repeat, by rays from the eye.

Light comes from a round window of directions. Rays go the other way than those of the tables; so the mean of a picture is
the table's value by reciprocity, or one of them is wrong.
"""

from dataclasses import dataclass

import mitsuba as mi
import numpy as np

from ..scattering.data.evaluation import evaluate
from ..scene.scattering import ScatterTable
from .composition import Cloth
from .matter import WAVELENGTHS
from .records import EXITS
from .woven import Maker

BATCH = 600_000
"""Rays at once, which bounds the memory."""


@dataclass(frozen=True)
class Window:
    """Where light comes from.

    Parameters
    ----------
    direction : (3,) tuple    Towards its middle.
    radius : float    [rad]
    """

    direction: tuple[float, float, float] = (0.5**0.5, 0.0, 0.5**0.5)
    radius: float = np.pi / 6.0

    def holds(self, directions) -> np.ndarray:
        """Whether light comes from directions. (..., 3) -> (...,) bool"""
        return np.asarray(directions) @ self.direction > np.cos(self.radius)

    @property
    def projected(self) -> float:
        """Projected solid angle; all of it is above the horizon. [sr]"""
        return np.pi * np.sin(self.radius) ** 2 * self.direction[2]


@dataclass(frozen=True, eq=False)
class CloseUp:
    """A picture of one repeat of a cloth.

    Parameters
    ----------
    values : (rows, columns, w) array
        Luminance over that of a white Lambert surface under the same light; the first row is that of the largest y. [-]
    error : (w,) array    Standard error of the picture's mean. [-]
    size : (2,) array    Of the repeat. [mm]
    """

    values: np.ndarray
    error: np.ndarray
    size: np.ndarray
    wavelengths: np.ndarray


def draw_close_up(
    cloth: Cloth,
    pixels: int = 128,
    samples: int = 32,
    view=(0.0, 0.0, 1.0),
    window: Window = Window(),
    wavelengths=WAVELENGTHS,
    seed: int = 0,
    exits: int = EXITS,
) -> CloseUp:
    """Draw a cloth from near, all yarns as large as they are, without perspective. A variant of Mitsuba must be active.

    Parameters
    ----------
    pixels : int
        Along the weft, about: as many for each end of the warp; along the warp as many as the repeat is longer.
    samples : int    Rays of each pixel, at least.
    view : (3,) array    Towards the eye.
    """
    maker = Maker(cloth, np.asarray(wavelengths, np.float64), 1, seed, exits)
    width, depth = size = maker.scenes[0].tubes.size
    ends, picks = cloth.weave.is_warp_up.shape
    rows = picks * max(1, round(pixels * depth / width / picks))
    pixels = ends * max(1, round(pixels / ends))
    # As many of each pixel at every wavelength that is followed, or pixels would differ in colour.
    samples = maker.anchors * -(-samples // maker.anchors)
    total = rows * pixels * samples
    values = np.zeros((rows * pixels, len(maker.wavelengths)))
    squares = np.zeros(len(maker.wavelengths))
    batch = maker.anchors * (BATCH // maker.anchors)
    for part, first in enumerate(range(0, total, batch)):
        pixel = np.arange(first, min(first + batch, total)) // samples
        draw = np.random.default_rng((seed, 17, part)).random((2, len(pixel)))
        places = (
            mi.Float((pixel % pixels + draw[0]) / pixels * width),
            mi.Float((pixel // pixels + draw[1]) / rows * depth),
        )
        lost, events, ways, *direction = maker.trace(
            -np.asarray(view, float), len(pixel), 1000 * seed + part + 1, places
        )
        weight = maker.weigh((events > 0) & ~lost, ways)
        lit = window.holds(np.stack(direction, axis=1))
        weight *= lit[:, None] * (np.pi / window.projected)
        squares += (weight**2).sum(axis=0)
        for band in range(weight.shape[1]):
            values[:, band] += np.bincount(pixel, weight[:, band], rows * pixels)
    mean = values.sum(axis=0) / total
    error = np.sqrt(np.maximum(squares / total - mean**2, 0.0) / total)
    values = _evened((values / samples).reshape(rows, pixels, -1), cloth)[::-1]
    return CloseUp(values, error, size, maker.wavelengths)


def _evened(values: np.ndarray, cloth: Cloth) -> np.ndarray:
    """Mean over all shifts of a repeat by whole crossings that change nothing of its weave, as rays see the same there."""
    up = cloth.weave.is_warp_up
    ends, picks = up.shape
    shifts = [(0, 0)]
    # Ends of a pile stand where they happen to.
    if cloth.pile is None:
        shifts = [s for s in np.ndindex(ends, picks) if np.array_equal(np.roll(up, s, (0, 1)), up)]
    rows, columns = values.shape[0] // picks, values.shape[1] // ends
    copies = [np.roll(values, (pick * rows, end * columns), (0, 1)) for end, pick in shifts]
    return np.mean(copies, axis=0)


def seen_from_afar(
    table: ScatterTable, view=(0.0, 0.0, 1.0), window: Window = Window()
) -> np.ndarray:
    """What a table says that the mean of `draw_close_up` is. (w,) [-]"""
    # Evenly by solid angle about the middle, on spirals.
    count = 4096
    share = (np.arange(count) + 0.5) / count
    cosine = 1.0 - share * (1.0 - np.cos(window.radius))
    sine, turn = np.sqrt(1.0 - cosine**2), np.pi * (3.0 - 5.0**0.5) * np.arange(count)
    middle = np.asarray(window.direction)
    one = np.cross(middle, [0.0, 1.0, 0.0] if abs(middle[1]) < 0.9 else [1.0, 0.0, 0.0])
    one /= np.linalg.norm(one)
    wi = (
        cosine[:, None] * middle
        + (sine * np.cos(turn))[:, None] * one
        + (sine * np.sin(turn))[:, None] * np.cross(middle, one)
    )
    values = evaluate(table, wi, np.tile(np.asarray(view, float), (count, 1)))
    return np.pi * (values * wi[:, 2:]).sum(axis=0) / wi[:, 2].sum()
