"""Small bright spots on surfaces, which paths of sensors and pictures ask for what they send on.

What a lamp close to a wall or a sun through a keyhole lights is so small that scattered rays hardly ever meet it, though all
the room may be lit by it. Where such spots lie is found as for lux maps (see `straight_lights`). Every vertex that is not
specular sends one ray more to a spot, or to its image in a plane mirror or pane, with a density that falls away from its
middle as the light of a lamp at a wall does:

    p(s) = (1 + s / s_0)^(-3/2) / (4 pi s_0 (1 - (1 + 1 / s_0)^(-1/2))),    0 <= s <= 1

by s, one less the cosine of the angle to the middle, and s_0, that of the bright core's edge. The next event at the
surface which that ray meets, over mirrors and through panes, competes with the one at the surface that the scattered ray
meets, by the power heuristic; so estimates stay without bias, whatever lies there.
"""

from contextlib import contextmanager

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import table_size, upload
from ..compiled.mirrors import ROUNDING
from ..paths.visible_surfaces import Sight
from ..paths.wavelengths import make_sampler
from ..rays import STEP
from .straight_lights import FOUND, StraightLights, find_candidates

PLACES = 1 << 13
"""Places for which next-event is taken to cope with bundled light, see `straight_lights.FOUND`: what is less bundled than
the light of a lamp 11 cm off a wall of a room of 3 m costs less than rays to spots do."""

LOOKS = 1 << 12
"""Rays that find what paths see."""

VOXELS = 32
"""Of the scene's radius; triangles of a part in one of them are taken to be seen together, as few rays miss most of many."""

MOST_VOXELS = 1 << 8
"""On either side of the scene's middle."""

PATHS, SEED = 1 << 16, 0x3F51
"""Traced to find where spots lie."""

MOST_SPOTS, MOST_IMAGES = 32, 16
"""Most spots, and most images of them in mirrors and panes; of more, the brightest."""

FEWEST_PLACES = 32
"""Places where a light was seen to land from which its spot is known."""

NARROWEST = 1e-5
"""Least radius of a core over its distance: directions have no more digits. [-]"""

PANE_SHARE = 0.1
"""What a pane shows of a spot. [-]"""

CORE = 0.75
"""Share of what a spot counts for within its core: a point lamp's is then as wide as its distance from the wall. [-]"""

NEAREST = 2.0
"""Least distance from a spot's middle, in radii of its core, from which rays go to it."""

COLUMNS = 6
"""Of the table: centre, square of the core's radius, weight, and the plane that shows an image, plus 1."""


@contextmanager
def bright_spots(scene, places: np.ndarray, normals: np.ndarray):
    """Let the paths of a `CompiledScene` ask its bright spots, as far as they matter at places (n, 3) [m] in its frame."""
    spots = find_spots(scene, places, normals)
    slack = ROUNDING * STEP * scene.extent
    scene.spots = BrightSpots(spots, scene.mirrors, slack) if len(spots) else None
    try:
        yield
    finally:
        scene.spots = None


class _Triangles:
    """All triangles of a scene by their sides, for `StraightLights`."""

    def __init__(self, scene):
        numbers, corners = [], [np.zeros((0, 3, 3))]
        self._first = np.full(scene.shape_count, -1)
        count = 0
        for _, part, _ in scene.parts():
            self._first[part.number] = count
            corners.append(scene.triangles(part).astype(np.float64))
            numbers.append(np.full(len(corners[-1]), part.number))
            count += len(corners[-1])
        whole = np.concatenate(corners)
        a, b, c = np.moveaxis(whole, 1, 0)
        self.count = len(whole)
        self.area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        voxel = np.floor(whole.mean(axis=1) * (VOXELS / max(float(scene.radius), 1e-9)))
        key = np.concatenate([*numbers, np.zeros(0)]).astype(np.int64)
        for along in np.clip(voxel, -MOST_VOXELS, MOST_VOXELS - 1).astype(np.int64).T:
            key = key * (2 * MOST_VOXELS) + along + MOST_VOXELS
        # Triangles of a part that lie together have one key.
        self._key = np.unique(key, return_inverse=True)[1]

    def sides(self, shape, triangle, back) -> np.ndarray:
        """Sides by the numbers of shapes and triangles and whether from behind, -1: none. (n,)"""
        first = self._first[shape]
        return np.where(first < 0, -1, 2 * (first + triangle.astype(np.int64)) + back)

    def sides_of(self, deposits) -> tuple[np.ndarray, np.ndarray]:
        """Side and share of the light that passes, of every deposit."""
        side = self.sides(deposits.shape, deposits.prim, deposits.back)
        return np.maximum(side, 0), (side >= 0).astype(float)

    def spread(self, sides: np.ndarray) -> np.ndarray:
        """How often sides are met, over area and of sum 1; triangles that lie together are met together. (2 c,) [m-2]"""
        keys = 2 * np.repeat(self._key.ravel(), 2) + np.tile([0, 1], self.count)
        size = 2 * (int(self._key.max(initial=-1)) + 1)
        area = np.bincount(keys, np.repeat(self.area, 2), size)
        met = np.bincount(keys[sides], minlength=size)
        density = np.divide(met, area, out=np.zeros(size), where=area > 0.0)
        return density[keys] / max(len(sides), 1)


def find_spots(scene, places: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Bright spots and their images, as in the table: in the scene's frame, but with the core's radius itself. (n, 6) [m]"""
    if not len(places) or not find_candidates(scene):
        return np.zeros((0, COLUMNS))
    sampler = make_sampler(scene, "luminance")
    triangles = _Triangles(scene)
    rows = np.random.default_rng(SEED).integers(0, len(places), LOOKS)
    met = triangles.sides(*Sight(scene, places[rows], normals[rows], SEED).met())
    looks = triangles.spread(met[met >= 0])
    # Of all the light that paths see, a light may have little, and scatter little however bundled it is.
    least = PLACES / FOUND
    lights = StraightLights(
        scene, sampler, triangles, np.flatnonzero(looks), PLACES, looks, unmattering=least
    )
    if not lights.is_needed:
        return np.zeros((0, COLUMNS))
    light, position, weight = lights.find_places(PATHS, SEED)
    worth = np.bincount(light, weight, len(lights.lights)) / lights.seen**2
    order = np.argsort(-worth, kind="stable")
    left = worth.sum() - np.cumsum(worth[order]) + worth[order]
    made = []
    for number in order[left > least][:MOST_SPOTS]:
        own = light == number
        if own.sum() >= FEWEST_PLACES and worth[number] > 0.0:
            core = _find_core(position[own], weight[own])
            made.append((*core, np.sqrt(worth[number]), 0.0))
    made = np.array(made).reshape(-1, COLUMNS)
    images = np.zeros((0, COLUMNS)) if scene.mirrors is None else _mirrored(made, scene.mirrors)
    return np.concatenate([made, _brightest(images, MOST_IMAGES)])


def _brightest(spots: np.ndarray, count: int) -> np.ndarray:
    return spots[np.argsort(-spots[:, 4], kind="stable")][:count]


def _mirrored(spots: np.ndarray, mirrors) -> np.ndarray:
    """Images of spots in every plane, rows as of `find_spots`."""
    made = []
    for number, plane in enumerate(mirrors.planes):
        away = plane.distance - plane.normal @ mirrors.origin - spots[:, :3] @ plane.normal
        images = spots.copy()
        images[:, :3] += 2.0 * away[:, None] * plane.normal
        images[:, 4] *= PANE_SHARE if plane.is_pane else 1.0
        images[:, 5] = number + 1
        made.append(images[np.abs(away) > spots[:, 3]])
    return np.concatenate(made)


def _find_core(position: np.ndarray, weight: np.ndarray):
    """Middle and radius of what counts most among places."""
    share = weight / weight.sum()
    order = np.argsort(position, axis=0)
    # Medians, so that a few far places do not move the middle.
    ends = np.cumsum(share[order], axis=0)
    rows = [min(int(np.searchsorted(ends[:, k], 0.5)), len(share) - 1) for k in range(3)]
    centre = position[order[rows, range(3)], range(3)]
    away = np.linalg.norm(position - centre, axis=1)
    order = np.argsort(away)
    at = min(int(np.searchsorted(np.cumsum(share[order]), CORE)), len(away) - 1)
    return (*centre, max(float(away[order[at]]), 1e-9))


class BrightSpots:
    """Directions to spots.

    Parameters
    ----------
    spots : (n, 6) array    Of `find_spots`.
    mirrors : MirrorSet or None    Of the scene.
    slack : Float    Of the bounds of mirrors. [m]
    """

    def __init__(self, spots: np.ndarray, mirrors, slack):
        self._mirrors, self._slack = mirrors, slack
        rows = np.zeros((table_size(len(spots)), COLUMNS))
        rows[: len(spots)] = spots
        rows[:, 3] **= 2
        self._rows = upload(mi.Float, rows)
        # A kernel must not depend on how many spots there are, since edits of lights change that.
        self._count = dr.opaque(mi.UInt32, len(spots))
        dr.eval(self._rows)

    def sample(self, point, choice, sample):
        """Direction towards one of the spots; whichever, where `density` is 0."""

        def choose(number, chosen, total, choice):
            weight = self._look(number, point)[3]
            total += weight
            # Each takes the place of those before with its share, and the number that decides is spread out again.
            share = dr.select(total > 0.0, weight / dr.maximum(total, 1e-30), 0.0)
            takes = choice < share
            left = dr.select(takes, choice, choice - share)
            width = dr.select(takes, share, 1.0 - share)
            choice = dr.clip(left / dr.maximum(width, 1e-9), 0.0, 0.9999999)
            return number + 1, dr.select(takes, number, chosen), total, choice

        _, chosen, _, _ = dr.while_loop(
            state=(mi.UInt32(0), mi.UInt32(0), mi.Float(0.0), mi.Float(choice)),
            cond=lambda number, *_: number < self._count,
            body=choose,
            labels=("number", "chosen", "total", "choice"),
        )
        towards, apart, core, _ = self._look(chosen, point)
        root = 1.0 - sample.x * _reach(core)
        sunk = dr.minimum(core * (dr.rcp(dr.square(root)) - 1.0), 1.0)
        sine = dr.safe_sqrt(sunk * (2.0 - sunk))
        s, c = dr.sincos(2.0 * dr.pi * sample.y)
        frame = mi.Frame3f(towards * dr.rsqrt(apart))
        return frame.to_world(mi.Vector3f(sine * c, sine * s, 1.0 - sunk))

    def density(self, point, direction):
        """Density of a direction, 0 from points that are close to all spots. [sr-1]"""

        def add(number, found, total):
            towards, apart, core, weight = self._look(number, point)
            # By the sine, as cosines of small angles have no digits left.
            square = dr.squared_norm(dr.cross(direction, towards)) / apart
            sunk = square / (1.0 + dr.safe_sqrt(1.0 - square))
            fall = dr.rcp(1.0 + sunk / core)
            own = fall * dr.sqrt(fall) / (4.0 * dr.pi * core * _reach(core))
            found += dr.select(dr.dot(direction, towards) > 0.0, weight * own, 0.0)
            return number + 1, found, total + weight

        _, found, total = dr.while_loop(
            state=(mi.UInt32(0), mi.Float(0.0), mi.Float(0.0)),
            cond=lambda number, *_: number < self._count,
            body=add,
            labels=("number", "found", "total"),
        )
        return dr.select(total > 0.0, found / dr.maximum(total, 1e-30), 0.0)

    def _look(self, number, point):
        """Way to a spot, its square, what the core sinks below the middle's direction, and the weight."""
        x, y, z, square, weight, plane = (
            dr.gather(mi.Float, self._rows, number * COLUMNS + k) for k in range(COLUMNS)
        )
        middle = mi.Point3f(x, y, z)
        towards = middle - point
        apart = dr.maximum(dr.squared_norm(towards), 1e-30)
        share = dr.clip(square / apart, NARROWEST**2, 1.0)
        core = share / (1.0 + dr.safe_sqrt(1.0 - share))
        counts = apart > NEAREST**2 * square
        if self._mirrors is not None:
            is_image = plane > 0.0
            index = mi.UInt32(dr.maximum(plane, 1.0)) - 1
            counts &= ~is_image | self._mirrors.shows(index, point, middle, self._slack, is_image)
        far = dr.select(counts, weight / apart, 0.0)
        return towards, apart, core, far


def _reach(core):
    """Integral of the density by s up to 1, over 2 s_0."""
    return 1.0 - dr.rsqrt(1.0 + dr.rcp(core))
