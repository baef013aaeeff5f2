"""Which places of lumels light can reach at all, and which lie so near to a surface that rounding could put them behind it.

Three things are told by short rays and a few long ones:

- *inside*: most rays of the hemisphere meet solids from within (see `solids` for what counts as one). A floor goes on under
  the wall that stands on it; without this its border lumels would be darkened by what nobody sees.
- *covered*: something lies on the place within `TOUCH`, so that a ray that starts a little off the surface may or may not
  have passed it: two boxes face to face, a sheet on a table. Such places are given up, rather than lit by chance.
- *beside*: a surface stands up next to the place within `NEAR`. The place is moved away from it, or out of it, if it is a
  solid that the place has entered by less than that, so that no ray begins on its wrong side.

Lumels are looked over as a whole first, along six lines each way close above the surface; only where those meet something
is every place looked at. What is smaller than a fifth of a lumel and stands between the lines can be overlooked.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ..arrays import upload
from ..errors import Cancelled
from ..transport.rays import STEP
from .solids import Soup, find_solids

NEAR = 1e-3
"""Places are kept this far from surfaces that stand beside them. [lumel]"""

TOUCH = 1e-4
"""What is nearer above a surface lies on it. [lumel]"""

LINES = 6
"""Lines across a lumel, each way."""

PROBES = 3
"""Rays of a place that are asked first; none of them meets a solid from within where a place is outside."""

RAYS = 16
"""Rays that decide whether a place is inside."""

LAUNCH = 1 << 20
"""Rays traced at once."""


class Examiner:
    """Looks over places of one scene.

    Parameters
    ----------
    scene : CompiledScene
    cancelled : callable    Asked before every launch.
    """

    def __init__(self, scene, cancelled=lambda: False):
        self._scene, self._cancelled = scene, cancelled
        # As far as rays step off surfaces, and positions are rounded.
        self._step = STEP * float(scene.radius)
        self._mark_solids()

    def examine(self, receivers, u, v, rim):
        """Find places that are of no use, those that have to be moved, and those that have to stay where they are.

        Parameters
        ----------
        receivers : Receivers    Of n lumels with k places.
        u, v : (n, 3) float64 arrays    Steps on the surface for one lumel to the right and one upwards. [m]
        rim : (n,) array or float    How far lumels go on beyond their outermost places. [lumel]

        Returns
        -------
        dropped : (k,) bool array
        moved : (m,) int array    Places to be moved.
        shift : (m, 3) float64 array    How far. [m]
        doubtful : (d,) int array    Lumels of which places were looked at one by one; beside these it may be otherwise.

        Raises
        ------
        Cancelled    When ``cancelled`` answered true.
        """
        dropped = np.zeros(len(receivers.positions), dtype=bool)
        if len(receivers.start) == 0:
            return dropped, np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0, np.int64)
        doubtful = self._doubtful(receivers, u, v, rim)
        lumel = np.repeat(doubtful, receivers.count[doubtful])
        begin = np.cumsum(receivers.count[doubtful]) - receivers.count[doubtful]
        place = np.arange(len(lumel)) + np.repeat(
            receivers.start[doubtful] - begin, receivers.count[doubtful]
        )
        normal = receivers.geometric_normals[place].astype(np.float64)
        size = np.sqrt(np.linalg.norm(u[lumel], axis=1) * np.linalg.norm(v[lumel], axis=1))
        shift = self._push(receivers.positions[place], normal, u[lumel], v[lumel], size)
        positions = receivers.positions[place] + shift
        lost = self._is_covered(positions, normal, size)
        lost[~lost] = self._is_inside(positions[~lost], normal[~lost])
        dropped[place[lost]] = True
        moves = np.flatnonzero(shift.any(axis=1))
        return dropped, place[moves], shift[moves], doubtful

    # ---- lumels as a whole ----

    def _doubtful(self, receivers, u, v, rim) -> np.ndarray:
        """Lumels that something reaches into, or that lie in or under something."""
        start, count = receivers.start, receivers.count
        origin = receivers.positions[start]
        normal = receivers.geometric_normals[start].astype(np.float64)
        size = np.sqrt(np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1))
        # Column by column: there may be millions of places.
        away = [receivers.positions[:, i] - np.repeat(origin[:, i], count) for i in range(3)]
        bounds = []
        for axis in (u, v):
            step = axis / np.maximum(np.einsum("nx,nx->n", axis, axis), 1e-300)[:, None]
            along = sum(each * np.repeat(step[:, i], count) for i, each in enumerate(away))
            bounds.append(
                (np.minimum.reduceat(along, start) - rim, np.maximum.reduceat(along, start) + rim)
            )
        corner = origin + u * bounds[0][0][:, None] + v * bounds[1][0][:, None]
        corner += normal * self._lift(size)[:, None]
        sides = [
            axis * (high - low)[:, None] for axis, (low, high) in zip((u, v), bounds, strict=True)
        ]
        found = self._is_crossed(corner, *sides)
        for share in (0.125, 0.375, 0.625, 0.875):
            chosen = start + (count * share).astype(np.int64)
            normals = receivers.geometric_normals[chosen].astype(np.float64)
            found |= self._is_covered(receivers.positions[chosen], normals, size)
        rest = np.flatnonzero(~found)
        found[rest] = self._meets_inside(origin[rest], normal[rest], PROBES) > 0
        return np.flatnonzero(found)

    def _lift(self, size):
        """Height of lines close above the surface. [m]"""
        return np.maximum(TOUCH * size, 2.0 * self._step)

    # ---- places ----

    def _push(self, positions, normal, u, v, size) -> np.ndarray:
        """How far places have to be moved away from surfaces beside them. (k, 3) [m]"""
        wanted = np.maximum(NEAR * size, 8.0 * self._step)
        # Rays begin a little behind the place, to meet what it lies on.
        back = 0.25 * wanted
        start = positions + normal * self._lift(size)[:, None]
        total = np.zeros_like(positions)
        for axis in (u, v, -u, -v):
            direction = axis / np.maximum(np.linalg.norm(axis, axis=1, keepdims=True), 1e-300)
            begin = start - direction * back[:, None]
            distance, facing, within = self._nearest(begin, direction * (2.0 * wanted)[:, None])
            upright = facing - normal * np.einsum("kx,kx->k", facing, normal)[:, None]
            length = np.linalg.norm(upright, axis=1)
            # Surfaces nearly level with this one, such as the next facet of a bowl, stand in nobody's way.
            meets = np.isfinite(distance) & (length > 0.1)
            upright = upright / np.maximum(length, 0.1)[:, None]
            slope = np.einsum("kx,kx->k", direction, upright)
            apart = (np.where(meets, distance, 0.0) - back) * np.abs(slope)
            # Places on the surface go to its front, those in a solid out of it, all others on away from it.
            is_on = meets & (np.abs(apart) <= 0.1 * wanted)
            leaves = is_on | (within & meets & (apart > 0.0))
            stride = np.where(leaves, apart + wanted, np.maximum(wanted - apart, 0.0))
            sign = np.where(leaves, 1.0, -np.sign(slope))
            # What lies behind is for the opposite ray.
            counts = is_on | (meets & (apart > 0.0))
            total += upright * np.where(counts, stride * sign, 0.0)[:, None]
        return total

    def _is_covered(self, positions, normal, size) -> np.ndarray:
        reach = np.maximum(TOUCH * size, 4.0 * self._step)
        start = positions + normal * self._step
        return self._is_blocked(start, normal * (reach - self._step)[:, None])

    def _is_inside(self, positions, normal) -> np.ndarray:
        inside = self._meets_inside(positions, normal, PROBES) > 0
        asked = np.flatnonzero(inside)
        inside[asked] = 2 * self._meets_inside(positions[asked], normal[asked], RAYS) > RAYS
        return inside

    def _meets_inside(self, positions, normal, count: int) -> np.ndarray:
        """How many of some rays over the hemisphere meet a solid from within. (k,)"""
        found = np.zeros(len(positions), dtype=np.int64)
        if not self._has_solids:
            return found
        helper = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
        s = np.cross(helper, normal)
        s /= np.maximum(np.linalg.norm(s, axis=1, keepdims=True), 1e-300)
        t = np.cross(normal, s)
        start = positions + normal * self._step
        length = 4.0 * float(self._scene.radius)
        for number in range(count):
            # Even in solid angle, but for the lowest tenth; turned by the golden angle.
            height = 0.1 + 0.9 * (number + 0.5) / count
            turn, flat = number * np.pi * (3.0 - np.sqrt(5.0)) + 0.3, np.sqrt(1.0 - height**2)
            direction = normal * height + flat * (s * np.cos(turn) + t * np.sin(turn))
            found += self._nearest(start, direction * length)[2]
        return found

    # ---- rays ----

    def _is_crossed(self, corner, right, up) -> np.ndarray:
        """Whether something meets any of the lines across lumels, each way. (n, 3), (n, 3), (n, 3) [m]"""
        crossed = np.zeros(len(corner), dtype=bool)
        for begin in range(0, len(corner), LAUNCH // LINES):
            if self._cancelled():
                raise Cancelled("cancelled")
            part = slice(begin, begin + LAUNCH // LINES)
            columns = (self._scene.local(corner[part]), right[part], up[part])
            origin, first, second = (
                kind(*(upload(mi.Float, column) for column in each.T))
                for kind, each in zip((mi.Point3f, mi.Vector3f, mi.Vector3f), columns, strict=True)
            )
            found = mi.Bool(False)
            for along, across in ((first, second), (second, first)):
                length = dr.norm(along)
                for place in np.linspace(0.0, 1.0, LINES).tolist():
                    ray = mi.Ray3f(origin + across * place, along / dr.maximum(length, 1e-30))
                    ray.maxt = length
                    found |= self._scene.solid.ray_test(ray, mi.Bool(True))
            crossed[part] = np.array(found)
        return crossed

    def _rays(self, start, way):
        """Yield ranges of rays and rays, from starts along ways in the world. (k, 3), (k, 3) [m]"""
        for begin in range(0, len(start), LAUNCH):
            if self._cancelled():
                raise Cancelled("cancelled")
            part = slice(begin, min(begin + LAUNCH, len(start)))
            length = np.linalg.norm(way[part], axis=1)
            direction = way[part] / np.maximum(length, 1e-300)[:, None]
            origin = self._scene.local(start[part])
            ray = mi.Ray3f(
                mi.Point3f(*(upload(mi.Float, column) for column in origin.T)),
                mi.Vector3f(*(upload(mi.Float, column) for column in direction.T)),
            )
            ray.maxt = upload(mi.Float, length)
            yield part, ray

    def _is_blocked(self, start, way) -> np.ndarray:
        blocked = np.zeros(len(start), dtype=bool)
        for part, ray in self._rays(start, way):
            blocked[part] = np.array(self._scene.solid.ray_test(ray, mi.Bool(True)))
        return blocked

    def _nearest(self, start, way):
        """First hits.

        Returns
        -------
        distance : (k,) array    Infinite where there is none. [m]
        normal : (k, 3) array    Of the surface that is met, 0 where there is none.
        within : (k,) bool array    Whether it is that of a solid, met from inside.
        """
        distance, within = np.full(len(start), np.inf), np.zeros(len(start), dtype=bool)
        normal = np.zeros((len(start), 3))
        for part, ray in self._rays(start, way):
            hit = self._scene.solid.ray_intersect_preliminary(ray, mi.Bool(False), mi.Bool(True))
            met = hit.is_valid()
            si = self._scene.surface(hit, ray, met)
            shape = dr.reinterpret_array(mi.UInt32, hit.shape)
            first = dr.gather(mi.UInt32, self._first, shape, met)
            belongs = dr.gather(mi.Bool, self._flags, first + hit.prim_index, met)
            leaves = met & belongs & (dr.dot(si.n, ray.d) > 0.0)
            t, facing = dr.select(met, hit.t, dr.inf), dr.select(met, si.n, 0.0)
            dr.eval(t, facing, leaves)
            distance[part], within[part] = np.array(t), np.array(leaves)
            normal[part] = np.stack([np.array(column) for column in facing], axis=1)
        return distance, normal, within

    def _mark_solids(self) -> None:
        """Find the solids among the objects, for look-up by shape and triangle."""
        scene = self._scene
        corners, owners, opaque, glowing, numbers = [], [], [], [], []
        owner_of: dict[str, int] = {}
        for key, part, material in scene.parts():
            sides = 0 if part.source is None else 1 + bool(material.emission.two_sided)
            own = scene.triangles(part)
            corners.append(own)
            owners.append(np.full(len(own), owner_of.setdefault(key, len(owner_of))))
            opaque.append(np.full(len(own), not part.is_transparent and material.surface.is_opaque))
            glowing.append(np.full(len(own), sides, dtype=np.int8))
            numbers.append((part.number, len(own)))
        glows = {id(part.source) for _, part, _ in scene.parts() if part.source is not None}
        lamps = [
            (source.centre, source.radius)
            for source in scene.lights.sources
            if source.centre is not None and id(source) not in glows
        ]
        if corners:
            soup = Soup(
                *(np.concatenate(column) for column in (corners, owners, opaque)),
                np.array([centre for centre, _ in lamps], dtype=np.float64).reshape(-1, 3),
                np.array([radius for _, radius in lamps], dtype=np.float64),
                np.concatenate(glowing),
            )
            flags = find_solids(soup)
        else:
            flags = np.zeros(1, dtype=bool)
        self._has_solids = bool(flags.any())
        first = np.zeros(scene.shape_count, dtype=np.uint32)
        ends = np.cumsum([count for _, count in numbers])
        for (number, count), end in zip(numbers, ends, strict=True):
            first[number] = end - count
        self._first, self._flags = upload(mi.UInt32, first), upload(mi.Bool, flags)
        dr.eval(self._first, self._flags)
