"""From where any place gets light over bends, by the light that lands about it.

The aims of `bent_lights` serve all places at once. Beside a polished ring or under a ball of glass every place sees other
images of a lamp, and aims that hold them all are wide: most rays miss, and the few that do not are bright. The pilot's paths
tell more: those that land about a place have left what bends them near to where its own light does. So space is parted by
where paths land, with as many in each part, and their starts there by where they lie; a few spheres hold them. Rays go to one
of these or by an aim, and are weighed by the density of both together: wherever light comes from, there is no bias.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import table_size, upload
from .emission_rays import in_cap, solid_cap

LEAF, GROUPS = 64, 16
"""Paths that land in a part of space, and spheres that hold their starts; powers of two."""

MOST_PARTS = 1 << 12
"""Most parts of space; more paths than these take are left out."""

SHARE, FAR_SHARE = 0.75, 0.25
"""Share of the rays that goes to spheres, in a part of space and beyond where its paths land. [-]"""

REACH = 1.0
"""How far beyond where its paths land they tell of a part of space, relative to how far these reach. [-]"""

WIDTH, DOUBT = 1.5, 0.25
"""Radius of a sphere, relative to the distance of the farthest start that it holds; and what is added to it, relative to how far
the paths of a part land from each other. [-]"""

COLUMNS, BOX = 5, 6
"""Of a sphere: centre, radius, light. Of a part of space: middle and half the size of where its paths land."""

SMALLEST_CAP = 1e-12
"""Least width of a cone, as 1 - cos: directions have no more digits."""


class LandedWays:
    """Tables of parts of space on the device.

    Parameters
    ----------
    lines : aims.Lines    By which the pilot's light arrives.
    lights : int    How many of the lights are looked for; lines of others are left out.

    Attributes
    ----------
    is_useful : bool    Whether there are enough lines to tell anything.
    """

    def __init__(self, lines, lights: int):
        held = np.flatnonzero(lines.light < lights)
        self._depth = min(int(np.log2(max(len(held), 1) / LEAF)), int(np.log2(MOST_PARTS)))
        self.is_useful = self._depth >= 1
        if not self.is_useful:
            return
        parts = 1 << self._depth
        kept = held[np.linspace(0, len(held) - 1, parts * LEAF).astype(np.int64)]
        ends, starts, light = lines.end[kept], lines.start[kept], lines.light[kept]
        order, self._planes = _part(ends, self._depth)
        ends, starts, light = (each[order].reshape(parts, LEAF, -1) for each in (ends, starts, light))
        low, high = ends.min(axis=1), ends.max(axis=1)
        boxes = np.concatenate([0.5 * (low + high), 0.5 * (high - low)], axis=1)
        apart = np.linalg.norm(high - low, axis=1)
        self._spheres = _hold(starts, light[..., 0], apart)
        planes = np.zeros((table_size(len(self._planes)), 2))
        planes[: len(self._planes)] = self._planes
        self._on_device = [
            upload(mi.Float, _filled(each)) for each in (planes, boxes, self._spheres)
        ]
        self._levels = dr.opaque(mi.UInt32, self._depth)
        self._aims = upload(mi.UInt32, np.zeros(table_size(lights)))
        dr.eval(self._on_device, self._aims)

    def number(self, aims: dict[int, int]) -> None:
        """Take note of the rows of the lights' first aims, by the lights' numbers."""
        rows = np.zeros(table_size(max(aims, default=0) + 1), dtype=np.uint32)
        for light, row in aims.items():
            rows[light] = row
        self._aims = upload(mi.UInt32, rows)
        dr.eval(self._aims)

    def of(self, place, active) -> "Ways":
        """What is known at places. ``active``: where it is asked at all."""
        planes, boxes, _ = self._on_device

        def descend(node, level):
            axis = dr.gather(mi.Float, planes, 2 * node, level < self._levels)
            height = dr.gather(mi.Float, planes, 2 * node + 1, level < self._levels)
            along = dr.select(axis < 0.5, place.x, dr.select(axis < 1.5, place.y, place.z))
            return 2 * node + 1 + dr.select(along > height, mi.UInt32(1), 0), level + 1

        node, _ = dr.while_loop(
            state=(mi.UInt32(0), mi.UInt32(0)),
            cond=lambda node, level: active & (level < self._levels),
            body=descend,
            labels=("node", "level"),
        )
        part = node - ((mi.UInt32(1) << self._levels) - 1)
        part = dr.select(active, part, 0)
        box = [dr.gather(mi.Float, boxes, part * BOX + k) for k in range(BOX)]
        away = dr.abs(mi.Vector3f(*(p - c for p, c in zip(place, box[:3], strict=True))))
        size = mi.Vector3f(*box[3:])
        reach = REACH * dr.max(size)
        is_near = dr.all(away <= size + reach)
        share = dr.select(active, dr.select(is_near, SHARE, FAR_SHARE), 0.0)
        return Ways(self, part, mi.Point3f(place), share)

    # ---- for `Ways` ----

    def sphere(self, part, number):
        """Centre, radius and light of a sphere of a part of space."""
        first = (part * GROUPS + number) * COLUMNS
        values = [dr.gather(mi.Float, self._on_device[2], first + k) for k in range(COLUMNS)]
        return mi.Point3f(*values[:3]), values[3], mi.UInt32(values[4])

    def aim_of(self, light):
        """Row of the first aim of a light."""
        return dr.gather(mi.UInt32, self._aims, light)


@dataclass(frozen=True)
class Ways:
    """What is known at places, inside a kernel; as `known_directions.Directions`."""

    tables: LandedWays
    part: object
    place: object
    share: object

    def draw(self, stream, index, direction):
        """An aim and a direction: into one of the spheres, or those given."""
        number = dr.minimum(mi.UInt32(stream.next_float32() * GROUPS), GROUPS - 1)
        is_known = stream.next_float32() < self.share
        axis, cap, light = self._cone(number)
        sample = mi.Point2f(stream.next_float32(), stream.next_float32())
        into = mi.Frame3f(axis).to_world(in_cap(cap, sample))
        return (
            dr.select(is_known, self.tables.aim_of(light), index),
            dr.select(is_known, into, direction),
        )

    def density(self, other, light, direction):
        """Density of a direction, for a light: of spheres and of others of the density ``other``. [sr-1]"""

        def add(held, number):
            axis, cap, own = self._cone(number)
            # By the chord, since cosines of narrow cones have no digits left.
            inside = 0.5 * dr.squared_norm(direction - axis) <= cap * (1.0 + 1e-4) + 1e-13
            return dr.select(inside & (own == light), held + dr.rcp(cap), held), number + 1

        held, _ = dr.while_loop(
            state=(mi.Float(0.0), mi.UInt32(0)),
            cond=lambda held, number: (self.share > 0.0) & (number < GROUPS),
            body=add,
            labels=("held", "number"),
        )
        known = held * (dr.inv_two_pi / GROUPS)
        return (1.0 - self.share) * other + self.share * known

    def scale(self):
        """Size of spheres that stand for points, relative to the usual one."""
        return mi.Float(1.0)

    def _cone(self, number):
        """Axis to a sphere, 1 - cos of the half angle that it fills, and its light."""
        centre, radius, light = self.tables.sphere(self.part, number)
        away = centre - self.place
        _, cap = solid_cap(away, radius)
        distance = dr.norm(away)
        up = mi.Vector3f(0.0, 0.0, 1.0)
        axis = dr.select(distance > 0.0, away / dr.maximum(distance, 1e-30), up)
        return axis, dr.maximum(cap, SMALLEST_CAP), light


def _part(places: np.ndarray, depth: int) -> tuple[np.ndarray, np.ndarray]:
    """Part places in halves again and again, each time across where they reach farthest.

    Returns
    -------
    (n,) int array, (2^depth - 1, 2) array
        Order of the places, those of a part one after the other; axis and height of the planes, as a heap.
    """
    order, planes = np.arange(len(places)), []
    for level in range(depth):
        nodes = order.reshape(1 << level, -1)
        own = places[nodes]
        axis = np.ptp(own, axis=1).argmax(axis=1)
        along = np.take_along_axis(own, axis[:, None, None], axis=2)[..., 0]
        sorted_by = np.argsort(along, axis=1, kind="stable")
        along = np.take_along_axis(along, sorted_by, axis=1)
        half = along.shape[1] // 2
        planes.append(np.column_stack([axis, 0.5 * (along[:, half - 1] + along[:, half])]))
        order = np.take_along_axis(nodes, sorted_by, axis=1).ravel()
    return order, np.concatenate(planes)


def _hold(starts: np.ndarray, light: np.ndarray, apart: np.ndarray) -> np.ndarray:
    """Spheres that hold starts: (parts, `LEAF`, 3) to (parts, `GROUPS`, `COLUMNS`).

    ``light``: (parts, `LEAF`), of which a sphere has the most frequent one; ``apart``: (parts,), as of `DOUBT`. [m]
    """
    parts = len(starts)
    # Lights are parted first: none is as far from another as this.
    far = 4.0 * np.abs(starts).max(initial=1.0)
    keys = np.concatenate([starts, far * light[..., None]], axis=2)
    for level in range(int(np.log2(GROUPS))):
        keys = keys.reshape(parts << level, -1, 4)
        axis = np.ptp(keys, axis=1).argmax(axis=1)
        along = np.take_along_axis(keys, axis[:, None, None], axis=2)
        keys = np.take_along_axis(keys, np.argsort(along, axis=1, kind="stable"), axis=1)
    keys = keys.reshape(parts, GROUPS, LEAF // GROUPS, 4)
    numbers = np.sort(np.round(keys[..., 3] / far), axis=2)[:, :, LEAF // GROUPS // 2]
    low, high = keys[..., :3].min(axis=2), keys[..., :3].max(axis=2)
    centre = 0.5 * (low + high)
    reach = np.linalg.norm(keys[..., :3] - centre[:, :, None], axis=3).max(axis=2)
    radius = WIDTH * reach + DOUBT / np.sqrt(LEAF) * apart[:, None]
    return np.concatenate([centre, radius[..., None], numbers[..., None]], axis=2)


def _filled(table: np.ndarray) -> np.ndarray:
    """A table as one row, longer than it need be so that its size is seldom a new one."""
    made = np.zeros(table_size(table.size))
    made[: table.size] = table.ravel()
    return made
