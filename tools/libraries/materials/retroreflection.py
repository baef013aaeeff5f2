"""Sheeting of road signs, which throws light back to where it comes from, after its coefficient of retroreflection.

The coefficient R_A is the intensity that an area sends back over the illuminance on a plane facing the lamp and over the
area. With wi and wo the directions of lamp and eye, R_A = f cos(i) cos(o).

References
----------
EN 12899-1:2007, 4.1.1.4 and tables 3, 4: least R_A of new sheeting, classes RA1 (glass beads) and RA2 (prisms).
CIE 54.2: Retroreflection: definition and measurement.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .microfacets import unit

POINTS = 4
"""Points along each side of a cell that its mean is taken of."""


HALO = np.radians(1.0)
"""Angle in which the wide part of the lobe falls by e. [rad]"""

HORIZON = np.radians(75.0)
"""Angle of entrance from which on nothing is thrown back. [rad]"""


@dataclass(frozen=True)
class Fall:
    """R_A that falls exponentially with the angle between lamp and eye: ``peak`` [cd/(lx m2)], ``width`` [rad]."""

    peak: float
    width: float

    def at(self, angle) -> np.ndarray:
        """[rad -> cd/(lx m2)]"""
        return self.peak * np.exp(-angle / self.width)


@dataclass(frozen=True, eq=False)
class Sheeting:
    """Matt sheeting with a white lobe back to the lamp.

    Parameters
    ----------
    colour : (w,) array    Luminance factor of the matt part; w = 1: the same at all wavelengths. [-]
    core, halo : Fall    Parts of R_A by the angle between lamp and eye.
    entrances, shares : (e,) arrays
        By the angle between the normal and the middle of lamp and eye: factors on R_A, linear in between. [rad], [-]
    """

    colour: np.ndarray
    core: Fall
    halo: Fall
    entrances: np.ndarray
    shares: np.ndarray

    def coefficient(self, wi, wo) -> np.ndarray:
        """R_A of the lobe. (n, 3), (n, 3) -> (n,) [cd/(lx m2)]"""
        # Of the chord: acos would lose what counts at small angles.
        chord = np.linalg.norm(wi - wo, axis=1)
        apart = 2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0))
        middle = unit(wi + wo)
        slant = np.arctan2(np.hypot(middle[:, 0], middle[:, 1]), middle[:, 2])
        back = self.core.at(apart) + self.halo.at(apart)
        return back * np.interp(slant, self.entrances, self.shares)

    def evaluate(self, wi, wo) -> np.ndarray:
        """BRDF. (n, w) [1/sr]"""
        lobe = self.coefficient(wi, wo) / (wi[:, 2] * wo[:, 2])
        return lobe[:, None] + self.colour / np.pi


def sheeting_of_class(observed, entered, colour) -> Sheeting:
    """Return the sheeting that has stated coefficients of retroreflection.

    Parameters
    ----------
    observed : three pairs    Angles between lamp and eye, ascending, with R_A. [rad], [cd/(lx m2)]
    entered : pairs
        Angles of entrance, ascending, with R_A where lamp and eye are as in the first of ``observed``; towards the horizon
        it goes to 0.
    colour : (w,) array    As of `Sheeting`.
    """
    (near, at_near), (middle, at_middle), (far, at_far) = observed
    # The narrow part has died away at the last angle.
    halo = Fall(at_far * np.exp(far / HALO), HALO)
    left = [value - halo.at(angle) for angle, value in ((near, at_near), (middle, at_middle))]
    width = (middle - near) / np.log(left[0] / left[1])
    core = Fall(left[0] * np.exp(near / width), width)
    angles, values = np.array(entered).T
    entrances = np.concatenate([[0.0], angles, [HORIZON]])
    shares = np.concatenate([[1.0], values / values[0], [0.0]])
    return Sheeting(colour, core, halo, entrances, shares)


def grow_tree(evaluate: Callable, disk_of: Callable, square_of: Callable, levels: int, step: float):
    """Find the tree of rank 3 (`engine.scene.scattering.TensorTree`) that tells a lobe back to the lamp.

    Parameters
    ----------
    evaluate : callable    BRDF, (n, 3), (n, 3) -> (n, w). [1/sr]
    disk_of, square_of : callables    Between the unit square and the unit disk.
    levels : int    Halvings of a side of the finest cells.
    step : float    Cells are halved where values differ by more than this share of their largest. [-]

    Returns
    -------
    (nodes, 8) int32 array, (leaves, w) array    Children and values.
    """
    children, values = [], []
    cells, holders = np.zeros((1, 3)), None
    bits = np.arange(8)[:, None] >> np.arange(3) & 1
    for level in range(levels + 1):
        size = 0.5**level
        # Directions beyond the horizon come from nowhere: the upper half of the first coordinate is empty.
        is_open = cells[:, 0] < 0.5
        split = is_open & (level < levels)
        if level:
            split[is_open] &= _differs(evaluate, disk_of, square_of, cells[is_open], size, step)
        numbers = np.where(split, np.cumsum(split) - 1 + len(children), 0)
        leaf = np.flatnonzero(~split)
        numbers[leaf] = -1 - (len(values) + np.arange(len(leaf)))
        if len(leaf):
            values.extend(_means(evaluate, disk_of, cells[leaf], size))
        if holders is not None:
            for (row, place), number in zip(holders, numbers, strict=True):
                children[row][place] = number
        first = len(children)
        children.extend([0] * 8 for _ in range(int(split.sum())))
        holders = [(row, place) for row in range(first, len(children)) for place in range(8)]
        cells = (cells[split][:, None] + 0.5 * size * bits).reshape(-1, 3)
        if not len(cells):
            break
    return np.array(children, dtype=np.int32), np.array(values)


def _pairs(disk_of, places) -> tuple[np.ndarray, np.ndarray]:
    """Directions of places in the tree's cube. (n, 3) -> (n, 3), (n, 3)"""
    sine = np.clip(1.0 - 2.0 * places[:, 0], 0.0, 0.9998)
    x, y = disk_of(places[:, 1], places[:, 2])
    # Up to 1.15 degrees above the horizon, where cosines would make anything large.
    reach = np.maximum(np.hypot(x, y) / 0.9998, 1.0)
    x, y = x / reach, y / reach
    wi = np.stack([-sine, 0.0 * sine, np.sqrt(1.0 - sine**2)], axis=1)
    return wi, np.stack([x, y, np.sqrt(1.0 - x * x - y * y)], axis=1)


def _differs(evaluate, disk_of, square_of, cells, size, step) -> np.ndarray:
    """Whether cells hold values that differ too much. (c,)"""
    ends = np.stack(np.meshgrid(*[[0.0, 0.5, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    places = cells[:, None] + size * ends
    # The lobe's ridge, wo = wi, may pass a cell between its corners.
    into = cells[:, 0, None] + size * np.linspace(0.0, 1.0, 5)
    ridge = np.stack([into, *square_of(2.0 * into - 1.0, 0.0 * into)], axis=-1)
    ridge = np.clip(ridge, cells[:, None], cells[:, None] + size)
    places = np.concatenate([places, ridge], axis=1)
    wi, wo = _pairs(disk_of, places.reshape(-1, 3))
    found = evaluate(wi, wo).mean(axis=1).reshape(len(cells), -1)
    return found.max(axis=1) - found.min(axis=1) > step * found.max(axis=1)


def _means(evaluate, disk_of, cells, size) -> np.ndarray:
    """Mean values of cells. (c, w)"""
    side = (np.arange(POINTS) + 0.5) / POINTS
    inner = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).reshape(-1, 3)
    made = []
    for some in np.array_split(cells, max(len(cells) // 4096, 1)):
        wi, wo = _pairs(disk_of, (some[:, None] + size * inner).reshape(-1, 3))
        found = evaluate(wi, wo).reshape(len(some), len(inner), -1).mean(axis=1)
        made.append(np.where(some[:, :1] < 0.5, found, 0.0))
    return np.concatenate(made)
