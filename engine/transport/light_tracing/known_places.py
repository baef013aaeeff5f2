"""From where places all over a scene get light over bends: what a pilot's light has shown.

An aim of `bent_lights` is where a light seems to be from afar. Close to a ball of glass, or in the focus of a mirror, light
comes from much of what bends it, and rays that look there only by chance find it with weights of thousands of times the
mean. So the lines on which a pilot's light has landed are parted by where they ended, until each part has a few, and the
directions of a part are covered by some cones, each as wide as the lines in it lie apart. Whoever asks at a place, a
receiver or a vertex of a path, looks into one of the cones of its part, drawn by their light, or some way round it, or by
the aims, and is weighed by the density of all together: so the estimate has no bias wherever light comes from.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import table_size, upload
from .emission_rays import in_cap

IMAGES, DIRECTIONS = 4, 12
"""Cones of a part about places where light seems to be, and about directions that it comes from."""

CONES = IMAGES + DIRECTIONS

OF_IMAGES = 0.6
"""Share of the cones' light that is looked for about places. [-]"""

FEWEST, MOST = 32, 96
"""Lines of a part, at least, and those that are looked at."""

DEEPEST = 24
"""Times that lines are parted, at most."""

SHARES = (0.35, 0.15)
"""Of what is looked for by cones: within them, and round them. The rest goes by the aims. [-]"""

EVEN = 0.2
"""Share of what goes to cones that is the same for all, whatever their light. [-]"""

SPARE, WIDER = 1.25, 4.0
"""By how much cones are wider than what lies in them, and what lies round them over that."""

NARROWEST = 3e-5
"""Least half angle of a cone: directions have no more digits. [rad]"""

APART = 10.0
"""Distance between directions of two lights, which share no cone."""

FAITH = 4.0
"""Lines that are off the place they share by as much again as was seen, over the number of lines."""

COLUMNS = 9
"""Of a cone: direction or place, light, 1 - cos of its half angle, its share, below which number it is taken and else which
other one, and what it is about: 0: a direction, 1: a place, -1: a place that light goes to."""

SEED = 0x51D3


class KnownPlaces:
    """Tables of the parts of a scene on the device.

    Parameters
    ----------
    lines : dict    Of a pilot, see `light_paths.send_pilot`, with the number of each line's light among ``bent.lights``.
    bent : BentLights
    """

    def __init__(self, lines: dict, bent):
        self.bent = bent
        where = lines["start"] + lines["direction"] * lines["way"][:, None]
        nodes, parts = _part(where)
        rows = np.zeros((table_size(len(parts) * CONES), COLUMNS), dtype=np.float32)
        rows[: len(parts) * CONES] = _make_cones(lines, parts).reshape(-1, COLUMNS)
        self.rows, self._nodes = upload(mi.Float, rows), upload(mi.Float, nodes)
        dr.eval(self.rows, self._nodes)

    def at(self, point, active) -> "Directions":
        """What is known where a point lies, inside a kernel."""

        def descend(node, looks):
            axis, split, child = (dr.gather(mi.Float, self._nodes, node * 3 + k) for k in range(3))
            along = dr.select(axis == 0.0, point.x, dr.select(axis == 1.0, point.y, point.z))
            is_leaf = axis < 0.0
            below = mi.UInt32(child) + dr.select(along > split, 1, 0)
            return dr.select(is_leaf, node, below), looks & ~is_leaf

        node, _ = dr.while_loop(
            state=(mi.UInt32(0), mi.Bool(active)),
            cond=lambda node, looks: looks,
            body=descend,
            labels=("node", "looks"),
        )
        part = mi.UInt32(dr.gather(mi.Float, self._nodes, node * 3 + 2))
        return Directions(self, part, point)


@dataclass(frozen=True)
class Directions:
    """What is known in a part, inside a kernel; as `known_directions.Directions`."""

    places: KnownPlaces
    part: object
    point: object

    def draw(self, stream, index, direction):
        """An aim and a direction: in or round a cone, or those given."""
        place = stream.next_float32() * CONES
        row = dr.minimum(mi.UInt32(place), CONES - 1)
        is_other = place - mi.Float(row) >= self._number(row, 6)
        row = dr.select(is_other, mi.UInt32(self._number(row, 7)), row)
        u = stream.next_float32()
        axis, light, cap, _ = self._row(row)
        cap = dr.select(u < SHARES[0], cap, _widened(cap))
        sample = mi.Point2f(stream.next_float32(), stream.next_float32())
        near = mi.Frame3f(axis).to_world(in_cap(cap, sample))
        is_known = u < sum(SHARES)
        aim = self.places.bent.aim_of(light)
        return dr.select(is_known, aim, index), dr.select(is_known, near, direction)

    def density(self, other, light, direction):
        """Density of a direction, for a light: of cones and of others of the density ``other``. [sr-1]"""

        def add(held, i):
            axis, own, cap, share = self._row(i)
            # By the chord, since cosines of narrow cones have no digits left.
            height = 0.5 * dr.squared_norm(direction - axis)
            made = mi.Float(0.0)
            for part, size in zip(SHARES, (cap, _widened(cap)), strict=True):
                inside = height <= size * (1.0 + 1e-4) + 1e-13
                made += dr.select(inside, part / size, 0.0)
            return held + dr.select(own == light, made * share, 0.0), i + 1

        held, _ = dr.while_loop(
            state=(mi.Float(0.0), mi.UInt32(0)),
            cond=lambda held, i: i < CONES,
            body=add,
            labels=("held", "i"),
        )
        return (1.0 - sum(SHARES)) * other + held * dr.inv_two_pi

    def _number(self, row, column: int):
        return dr.gather(mi.Float, self.places.rows, (self.part * CONES + row) * COLUMNS + column)

    def _row(self, row):
        """Direction of a cone, its light, 1 - cos of its half angle, and its share."""
        numbers, kind = [self._number(row, k) for k in range(6)], self._number(row, 8)
        axis = mi.Vector3f(*numbers[:3])
        away = (axis - self.point) * kind
        axis = dr.select(
            kind == 0.0, axis, away * dr.rsqrt(dr.maximum(dr.squared_norm(away), 1e-30))
        )
        return axis, mi.UInt32(numbers[3]), numbers[4], numbers[5]


def _widened(cap):
    """1 - cos of what lies round a cone."""
    return dr.minimum(WIDER**2 * cap, 2.0)


def _make_cones(lines: dict, parts: list[np.ndarray]) -> np.ndarray:
    """Cones of all parts that hold the directions of their lines: rows as of the table. (p, CONES, COLUMNS)"""
    draw = np.random.default_rng(SEED)
    # Padded by the first line, without flux.
    own = np.zeros((len(parts), min(max(map(len, parts)), MOST)), dtype=np.int64)
    flux = np.zeros(own.shape)
    for number, part in enumerate(parts):
        some = part if len(part) <= own.shape[1] else draw.choice(part, own.shape[1], replace=False)
        own[number], flux[number, : len(some)] = some[0], lines["flux"][some]
        own[number, : len(some)] = some
    towards = -lines["direction"][own]
    start = lines["start"][own]
    landed = start - lines["way"][own][..., None] * towards
    spots = np.concatenate([towards, APART * lines["light"][own][..., None]], axis=2)
    images = _find_images(spots, landed, flux)
    made = np.concatenate([images, _find_directions(spots, flux)], axis=1)
    made[..., 5] *= np.repeat([OF_IMAGES, 1.0 - OF_IMAGES], [IMAGES, DIRECTIONS])
    made[..., 6], made[..., 7] = _alias(made[..., 5])
    return made


def _find_directions(spots, flux) -> np.ndarray:
    """Cones about directions, each as wide as what is nearest to it. (p, DIRECTIONS, COLUMNS)"""
    centres, members, away = _cover(spots, DIRECTIONS)
    at = np.arange(len(spots))[:, None]
    reach, held = np.zeros(centres.shape), np.zeros(centres.shape)
    np.maximum.at(reach, (at, members), away)
    np.add.at(held, (at, members), flux)
    middle = spots[at, centres]
    # What lies alone reaches half way to the next.
    between = np.linalg.norm(middle[:, :, None] - middle[:, None], axis=3)
    between[between <= 0.0] = np.inf
    next_to = between.min(axis=2)
    next_to[next_to >= APART] = 0.0
    width = SPARE * np.maximum(reach, 0.5 * next_to)
    return _rows_of(middle, width, held, np.zeros(held.shape))


def _find_images(spots, landed, flux) -> np.ndarray:
    """Cones about places where the light of a few bundles seems to be, or to go to. (p, IMAGES, COLUMNS)"""
    centres, members, _ = _cover(spots, IMAGES)
    at = np.arange(len(spots))
    made = []
    for number in range(IMAGES):
        weight = np.where(members == number, flux, 0.0)
        held, count = weight.sum(axis=1), (weight > 0.0).sum(axis=1)
        share = weight / np.maximum(held, 1e-300)[:, None]
        towards = spots[..., :3]
        # The point that all lines pass as closely as possible; those that are parallel do not tell it along them.
        middle = np.einsum("pn,pnk->pk", share, landed)
        off = landed - middle[:, None]
        along = (off * towards).sum(axis=2)
        system = np.eye(3) * (1.0 + 1e-9) - np.einsum("pn,pnk,pnl->pkl", share, towards, towards)
        right = -np.einsum("pn,pn,pnk->pk", share, along, towards)
        place = middle + np.linalg.solve(system, right[..., None])[..., 0]
        away = place[:, None] - landed
        before = np.einsum("pn,pnk,pnk->p", share, away, towards)
        kind = np.where(before < 0.0, -1.0, 1.0)
        away *= (kind[:, None] / np.maximum(np.linalg.norm(away, axis=2), 1e-30))[..., None]
        apart = np.where(weight > 0.0, np.linalg.norm(away - towards, axis=2), 0.0)
        width = SPARE * apart.max(axis=1) * (1.0 + FAITH / np.maximum(count, 1))
        spot = np.concatenate([place, spots[at, centres[:, number], 3:]], axis=1)
        made.append((spot, width, held, kind))
    return _rows_of(*(np.stack(each, axis=1) for each in zip(*made, strict=True)))


def _rows_of(spots, width, held, kind) -> np.ndarray:
    """Rows of cones (p, k): places or directions with lights as of `_cover`, half angles [rad], light, and kinds."""
    rows = np.zeros((*held.shape, COLUMNS))
    rows[..., :3], rows[..., 3] = spots[..., :3], np.rint(spots[..., 3] / APART)
    rows[..., 4] = np.clip(0.5 * np.square(width), 0.5 * NARROWEST**2, 2.0)
    rows[..., 5] = EVEN / held.shape[1]
    rows[..., 5] += (1.0 - EVEN) * held / held.sum(axis=1, keepdims=True)
    rows[..., 8] = kind
    return rows


def _cover(spots: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centres that are near to all others: one after the other that which is farthest from those before.

    ``spots``: (p, n, 4). Returns numbers of the centres (p, count), and the nearest centre of every spot and its distance
    (p, n).
    """
    at = np.arange(len(spots))
    centres = np.zeros((len(spots), count), dtype=np.int64)
    away = np.full(spots.shape[:2], np.inf)
    members = np.zeros(spots.shape[:2], dtype=np.int64)
    for number in range(count):
        if number:
            centres[:, number] = away.argmax(axis=1)
        distance = np.linalg.norm(spots - spots[at, centres[:, number]][:, None], axis=2)
        is_nearer = distance < away
        away, members = np.where(is_nearer, distance, away), np.where(is_nearer, number, members)
    return centres, members, away


def _alias(share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Walker's tables for drawing by shares (p, k) of sum 1: thresholds, and what is taken beyond them. (p, k) each"""
    left = share * share.shape[1]
    threshold, other = np.ones_like(share), np.tile(np.arange(share.shape[1]), (len(share), 1))
    at, is_open = np.arange(len(share)), np.ones(share.shape, dtype=bool)
    # Each turn settles what has least left by what has most.
    for _ in range(share.shape[1] - 1):
        least = np.where(is_open, left, np.inf).argmin(axis=1)
        most = np.where(is_open, left, -np.inf).argmax(axis=1)
        threshold[at, least], other[at, least] = np.minimum(left[at, least], 1.0), most
        left[at, most] -= 1.0 - threshold[at, least]
        is_open[at, least] = False
    return threshold, other


def _part(where: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Part places (n, 3) by halves along their longest side.

    Returns
    -------
    nodes : (m, 3) array    Axis, where it is split, and the first of two nodes; -1, 0 and the part's number.
    parts : list of (k,) arrays    Numbers of the places of each part.
    """
    nodes: list[tuple] = [()]
    parts, left = [], [(0, np.arange(len(where)), 0)]
    while left:
        node, own, depth = left.pop()
        halves = _halve(where[own]) if depth < DEEPEST else None
        if halves is None:
            nodes[node] = (-1.0, 0.0, float(len(parts)))
            parts.append(own)
            continue
        axis, split, is_high = halves
        first = len(nodes)
        nodes[node] = (float(axis), split, float(first))
        nodes += [(), ()]
        left += [(first, own[~is_high], depth + 1), (first + 1, own[is_high], depth + 1)]
    return np.array(nodes), parts


def _halve(where: np.ndarray):
    """Axis, where it is split, and what lies beyond, along the longest side that can be split; None where none can."""
    sides = np.ptp(where, axis=0)
    for axis in np.argsort(-sides):
        along = where[:, axis]
        # Many places lie in one plane, so that their median may be at an end.
        for place in (np.median(along), along.min() + 0.5 * sides[axis]):
            # As kernels compare.
            split = float(np.float32(place))
            is_high = along > split
            if min(is_high.sum(), (~is_high).sum()) >= FEWEST:
                return int(axis), split, is_high
    return None
