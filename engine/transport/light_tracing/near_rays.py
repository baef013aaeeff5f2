"""Next-event to lights from ray sets that are near: what their own rays give at a point that none of them meets.

A generated ray is one of the set with a normal fluctuation of its start and direction (`engine/raysets/cloud.py`). Once the
start is drawn, the direction is a normal vector made a unit vector, whose density is known in closed form (the general
projected normal distribution, F. Wang and A. E. Gelfand, 2013). So a start is drawn, and its density towards the point over
the square of the distance is what it gives there:

    E = <w(omega) p(omega | start) / d^2>

This has no bias against rays that are traced (`ray_lights`), for sensors and pictures, by plane mirrors and panes too. Of a
few starts one is kept in proportion to what it gives and asked for shadows (J. Talbot, 2005).
"""

from contextlib import contextmanager

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...scene.nearness import triangle_distance
from ...scene.ray_emission import GROUP, HULL, PLANE, SPHERE
from ...scene.scene import content_digest
from .ray_weight import RayWeight

CANDIDATES = 8
"""Starts that are compared at a next event, a power of two. They are spread evenly over the rays, which stand in an order
that keeps neighbours together, and over the turns about an axis."""

TURN_STEP = 3
"""Odd, so that rays and turns are not spread alike."""

SPREAD, NARROW_TURN = 0.5, 1e-3
"""Width of the law by which turns about an axis are drawn, relative to what is known of the best one, and the least. [-]"""

LOWER = 21
"""Entries of a triangular factor that are not zero, row by row."""

NUMBERS, VALUES = 8, 13
"""Columns of the tables of ray sets: where their rays, groups and slabs begin, how many rays and slabs, kind of the body,
whether it is one-sided and whether there is an axis; and vectors and numbers, see `_values`."""

PLANE_KIND, SPHERE_KIND, HULL_KIND = range(3)


@contextmanager
def near_rays(scene, places: np.ndarray):
    """Let next-event of a `CompiledScene` see the rays of ray sets that are near; gives notes on those that it cannot.

    ``places``: of what is asked, in the scene's frame (n, 3) [m]; surfaces of the scene count anyhow.
    """
    near, narrow = [], []
    shining = set(map(id, scene.lights.sources))
    for name, source in scene.named_sources():
        row = source.luminaire
        if (
            id(source) not in shining
            or row is None
            or row.rays is None
            or not len(row.rays.threshold)
        ):
            continue
        if _is_near(scene, row.centre, row.rays.near, places):
            (narrow if row.rays.is_narrow else near).append((name, source))
    palette = scene.lights.palette if near else None
    if near:
        palette.near = NearRays(scene, [source for _, source in near])
    notes = tuple(
        f"ray set '{name}' is taken for a point by sensors and pictures: its rays hardly fluctuate in direction, so none is "
        "found by chance"
        for name, _ in narrow
    )
    try:
        yield notes
    finally:
        if palette is not None:
            palette.near = None


def _is_near(scene, centre: np.ndarray, reach: float, places: np.ndarray) -> bool:
    """Whether a surface or a place lies nearer than a distance. [m]"""
    if len(places) and (((places - centre) ** 2).sum(axis=1) < reach**2).any():
        return True
    for key, part, _ in scene.parts():
        low, high = scene.object_bounds(key)
        beside = np.maximum(np.maximum(low - centre, centre - high), 0.0)
        is_close = (beside**2).sum() < reach**2
        if is_close and triangle_distance(centre, scene.triangles(part)) < reach:
            return True
    return False


class NearRays:
    """What lights from ray sets give near by: the part of `LuminairePalette.receive` that asks their rays.

    Parameters
    ----------
    scene : CompiledScene
    sources : list of Source    Lights that are asked so.
    """

    def __init__(self, scene, sources):
        known: dict[bytes, int] = {}
        emissions = []
        rows = np.zeros((scene.lights.palette.count, 14))
        for source in sources:
            rays = source.luminaire.rays
            key = content_digest(rays)
            if key not in known:
                known[key] = len(emissions)
                emissions.append(rays)
            line = rows[scene.lights.row_of(source)]
            line[:9] = source.luminaire.rotation.T.ravel()
            line[9:12], line[12], line[13] = source.luminaire.centre, rays.near, known[key]
        self._rows = upload(mi.Float, rows)
        counts = np.array([len(rays.threshold) for rays in emissions])
        groups = np.array([len(rays.factor) for rays in emissions])
        slabs = [np.asarray(rays.body.slabs, dtype=np.float64).reshape(-1, 5) for rays in emissions]
        begins = [np.cumsum(each) - each for each in (counts, groups, [len(s) for s in slabs])]
        numbers = np.zeros((len(emissions), NUMBERS), dtype=np.int64)
        kinds = {PLANE: PLANE_KIND, SPHERE: SPHERE_KIND, HULL: HULL_KIND}
        for k, (line, rays) in enumerate(zip(numbers, emissions, strict=True)):
            line[:3] = [begin[k] for begin in begins]
            line[3:6] = counts[k], len(slabs[k]), kinds[rays.body.kind]
            line[6:] = rays.body.is_one_sided, rays.axis is not None
        self._numbers = upload(mi.UInt32, numbers)
        self._values = upload(mi.Float, [_values(rays) for rays in emissions])
        self._weight = RayWeight([rays.weight for rays in emissions])
        self._slabs = upload(mi.Float, np.concatenate([*slabs, np.zeros((1, 5))]))
        places = np.tril_indices(6)
        joined = {
            "_position": [rays.position for rays in emissions],
            "_direction": [rays.direction for rays in emissions],
            "_factor": [rays.factor[:, places[0], places[1]] for rays in emissions],
            "_threshold": [rays.threshold for rays in emissions],
        }
        for name, parts in joined.items():
            setattr(self, name, upload(mi.Float, np.concatenate(parts)))
        self._other = upload(mi.UInt32, np.concatenate([rays.other for rays in emissions]))
        self._has_axis = bool(numbers[:, 7].any())
        self._kinds = set(numbers[:, 5].tolist())
        dr.eval(self._rows, self._numbers, self._values, self._slabs, self._other)
        dr.eval(self._position, self._direction, self._factor, self._threshold)

    def receive(self, row, it, sample, ds, active):
        """Ask the rays of lights within whose reach a point lies.

        Parameters
        ----------
        row : UInt32    Of the palette.
        it : Interaction3f    The point.
        sample : Point2f
        ds : DirectionSample3f    Is changed where rays are asked.
        active : Bool

        Returns
        -------
        (Bool, Float)    Where that is, and what a unit of flux gives there on a plane that faces it. [m-2]
        """
        first, second, third = (
            self._vector(self._rows, row * 14 + 3 * k, active) for k in range(3)
        )
        centre = self._vector(self._rows, row * 14 + 9, active)
        reach = dr.gather(mi.Float, self._rows, row * 14 + 12, active)
        away = mi.Vector3f(it.p) - centre
        near = active & (dr.squared_norm(away) < dr.square(reach))
        q = mi.Vector3f(dr.dot(first, away), dr.dot(second, away), dr.dot(third, away))
        number = mi.UInt32(dr.gather(mi.Float, self._rows, row * 14 + 13, near))
        stream = _stream(sample, it.p)
        which, turn = stream.next_uint32(), stream.next_uint32()

        def step(nth, start, total, stream):
            own = mi.UInt32(nth * ((1 << 32) // CANDIDATES))
            turned = mi.Float((turn + own * TURN_STEP) >> 8) * (1.0 / (1 << 24))
            at, value = self._candidate(number, q, which + own, turned, stream, near)
            total = total + value
            picks = stream.next_float32() * total < value
            return nth + 1, dr.select(picks, at, start), total, stream

        _, start, total, _ = dr.while_loop(
            state=(mi.UInt32(0), mi.Vector3f(0.0), mi.Float(0.0), stream),
            cond=lambda nth, *_: near & (nth < CANDIDATES),
            body=step,
            labels=("nth", "start", "total", "stream"),
        )
        if HULL_KIND in self._kinds:
            start, total = self._put_on_hull(number, start, q, total, near)
        at = mi.Point3f(first * start.x + second * start.y + third * start.z + centre)
        towards = at - it.p
        distance = dr.maximum(dr.norm(towards), 1e-12)
        ds.p = dr.select(near, at, ds.p)
        ds.d = dr.select(near, towards / distance, ds.d)
        ds.dist = dr.select(near, distance, ds.dist)
        ds.n = dr.select(near, mi.Normal3f(-ds.d), ds.n)
        return near, total * (1.0 / CANDIDATES)

    # ---- private ----

    def _vector(self, table, place, active):
        return mi.Vector3f(*(dr.gather(mi.Float, table, place + k, active) for k in range(3)))

    def _candidate(self, number, q, which, turn, stream, active):
        """Where a ray that passes ``q`` starts, in the light's axes [m], and what it gives there. [m-2]

        ``which``: word that chooses the ray; ``turn``: number in [0, 1) that chooses the turn about an axis.
        """
        info = [dr.gather(mi.UInt32, self._numbers, number * NUMBERS + k, active) for k in range(8)]
        first, group, slab, count, slabs, kind, one_sided, has_axis = info

        def values(k, many=3):
            found = [
                dr.gather(mi.Float, self._values, number * VALUES + k + i, active)
                for i in range(many)
            ]
            return mi.Vector3f(*found) if many == 3 else found

        place = dr.mul_hi(which, count)
        stays = stream.next_float32() < dr.gather(mi.Float, self._threshold, first + place, active)
        place = dr.select(stays, place, dr.gather(mi.UInt32, self._other, first + place, active))
        noise = _three_normals(stream)
        row = (group + place // GROUP) * LOWER
        factor = [dr.gather(mi.Float, self._factor, row + k, active) for k in range(LOWER)]
        position = dr.gather(mi.Vector3f, self._position, first + place, active)
        mean = dr.gather(mi.Vector3f, self._direction, first + place, active)
        moved = [
            factor[i * (i + 1) // 2 + j] * noise[j] for i in range(6) for j in range(3) if j <= i
        ]
        position += mi.Vector3f(moved[0], moved[1] + moved[2], moved[3] + moved[4] + moved[5])
        mean += mi.Vector3f(*(moved[k] + moved[k + 1] + moved[k + 2] for k in (6, 9, 12)))
        own = [factor[k] for k in (9, 13, 14, 18, 19, 20)]
        angle, over = mi.Float(0.0), mi.Float(1.0)
        axis = mi.Vector3f(0.0, 0.0, 1.0)
        if self._has_axis:
            through, axis = values(7), values(10)
            width = dr.sqrt(sum(dr.square(each) for each in own) * (1.0 / 3.0))
            angle, over = _draw_turn(axis, position - through, mean, q - through, width, turn)
            angle, over = dr.select(has_axis > 0, angle, 0.0), dr.select(has_axis > 0, over, 1.0)
            position = through + _turned(position - through, axis, angle)
        centre, normal = values(0), values(3)
        radius = values(6, 1)[0]
        weigh = self._weight.of_set(number, active)

        def density(direction):
            back = _turned(direction, axis, -angle) if self._has_axis else direction
            return weigh(direction) * over * _density(back, mean, own)

        start, value = mi.Vector3f(0.0), mi.Float(0.0)
        if self._kinds & {PLANE_KIND, HULL_KIND}:
            flat = kind == PLANE_KIND
            height = dr.select(flat, dr.dot(position - centre, normal), 0.0)
            kept = self._keep(position - normal * height, slab, slabs, active)
            away = q - kept
            distance = dr.maximum(dr.norm(away), 1e-12)
            direction = away / distance
            side = dr.dot(direction, normal)
            is_folded = flat & (one_sided > 0)
            found = density(direction)
            if PLANE_KIND in self._kinds:
                # Light that fluctuates to behind is sent to the front.
                found += dr.select(is_folded, density(direction - normal * (2.0 * side)), 0.0)
                found = dr.select(is_folded & (side <= 0.0), 0.0, found)
            start, value = kept, found / dr.square(distance)
        if SPHERE_KIND in self._kinds:
            at, found = _from_sphere(position - centre, radius, q - centre, density, stream)
            is_round = kind == SPHERE_KIND
            start = dr.select(is_round, centre + at, start)
            value = dr.select(is_round, found, value)
        return start, dr.select(active & dr.isfinite(value), value, 0.0)

    def _put_on_hull(self, number, start, q, total, active):
        """Put the chosen start where its line leaves the body, if that is a hull; within it there is no light."""
        slab, slabs, kind = (
            dr.gather(mi.UInt32, self._numbers, number * NUMBERS + k, active) for k in (2, 4, 5)
        )
        is_hull = active & (kind == HULL_KIND)
        away = q - start
        distance = dr.maximum(dr.norm(away), 1e-12)
        direction = away / distance
        way = self._leave(start, direction, slab, slabs, is_hull)
        total = dr.select(is_hull & (distance <= way), 0.0, total)
        return dr.select(is_hull, start + direction * way, start), total

    def _slab(self, k, active):
        values = [dr.gather(mi.Float, self._slabs, k * 5 + i, active) for i in range(5)]
        return mi.Vector3f(*values[:3]), values[3], values[4]

    def _keep(self, position, first, count, active):
        """As `RaySource._keep`."""

        def step(position, k):
            normal, low, high = self._slab(first + k, active)
            height = dr.dot(position, normal)
            inside = dr.maximum(dr.select(height > high, 2.0 * high - height, height), low)
            inside = dr.select(height < low, dr.minimum(2.0 * low - height, high), inside)
            return position + normal * (inside - height), k + 1

        position, _ = dr.while_loop(
            state=(mi.Vector3f(position), mi.UInt32(0)),
            cond=lambda position, k: active & (k < count),
            body=step,
            labels=("position", "slab"),
        )
        return position

    def _leave(self, position, direction, first, count, active):
        """As `RaySource._leave`."""

        def step(way, k):
            normal, low, high = self._slab(first + k, active)
            height, rate = dr.dot(position, normal), dr.dot(direction, normal)
            rest = dr.select(rate > 0.0, high - height, low - height)
            return dr.select(dr.abs(rate) > 1e-9, dr.minimum(way, rest / rate), way), k + 1

        way, _ = dr.while_loop(
            state=(mi.Float(1e30), mi.UInt32(0)),
            cond=lambda way, k: active & (k < count),
            body=step,
            labels=("way", "slab"),
        )
        return dr.maximum(dr.select(way < 1e29, way, 0.0), 0.0)


def _values(rays) -> np.ndarray:
    """Line of the table: the body's centre, normal and radius, a point and direction of the axis."""
    line = np.zeros(VALUES)
    line[0:3], line[3:6], line[6] = rays.body.centre, rays.body.normal, rays.body.radius
    if rays.axis is not None:
        line[7:10], line[10:13] = rays.axis
    return line


def _stream(sample, point):
    """Numbers of their own for every sample and place."""
    words = [dr.reinterpret_array(mi.UInt32, mi.Float(v)) for v in (sample.x, sample.y, *point)]
    seed = mi.UInt32(0x9E3779B9)
    for word in words:
        seed = (seed ^ word) * mi.UInt32(0x85EBCA6B)
        seed ^= seed >> 15
        seed *= mi.UInt32(0xC2B2AE35)
        seed ^= seed >> 13
    return mi.PCG32(initstate=mi.UInt64(seed), initseq=mi.UInt64(seed ^ words[1]))


def _three_normals(stream) -> list:
    made = []
    for _ in range(2):
        sample = mi.Point2f(stream.next_float32(), stream.next_float32())
        made += list(mi.warp.square_to_std_normal(sample))
    return made[:3]


def _turned(vector, axis, angle):
    sine, cosine = dr.sincos(angle)
    along = axis * dr.dot(vector, axis)
    return along + cosine * (vector - along) + sine * dr.cross(axis, vector)


def _draw_turn(axis, position, mean, q, width, u):
    """Turn by which a ray may pass ``q``, by a Cauchy law around the circle, and even density over that of the draw.

    ``position``, ``q``: from a point of the axis; ``width``: of the fluctuation of directions.
    """
    start, along, away = (v - axis * dr.dot(v, axis) for v in (position, mean, q))
    best = dr.atan2(dr.dot(axis, dr.cross(along, away)), dr.dot(along, away))
    unsure = width / dr.maximum(dr.norm(along), 1e-9)
    unsure += dr.norm(start) / dr.maximum(dr.norm(away), 1e-12)
    half = dr.clip(SPREAD * unsure, NARROW_TURN, 1.0)
    tangent = half * dr.tan(dr.pi * (u - 0.5))
    # By the half angle t the density is (h^2 + t^2) / (h (1 + t^2)) times less than even.
    over = (dr.square(half) + dr.square(tangent)) / (half * (1.0 + dr.square(tangent)))
    return best + 2.0 * dr.atan(tangent), over


def _density(direction, mean, factor):
    """Density of the direction of a normal vector. ``factor``: of its covariance, by rows below the diagonal. [sr-1]"""
    a, b, c, d, e, f = factor

    def solve(vector):
        x = vector.x / a
        y = (vector.y - b * x) / c
        return mi.Vector3f(x, y, (vector.z - d * x - e * y) / f)

    w, n = solve(direction), solve(mean)
    length = dr.norm(w)
    w /= length
    along, across = dr.dot(n, w), dr.squared_norm(dr.cross(n, w))
    bell = dr.exp(-0.5 * dr.square(along)) * float(1.0 / np.sqrt(2.0 * np.pi))
    below = 0.5 * (1.0 + dr.erf(along * float(np.sqrt(0.5))))
    moment = dr.maximum((1.0 + dr.square(along)) * below + along * bell, 0.0)
    spread = dr.abs(a * c * f) * length
    return dr.exp(-0.5 * across) * (moment / dr.square(length)) / (dr.two_pi * spread)


def _from_sphere(away, radius, q, density, stream):
    """As `NearRays._candidate`, about the middle of a sphere: rays leave it, or start at its nearest point if they miss it.

    Of lines that miss it those count that touch it and pass ``q``: two, in the plane of ``q`` and the drawn point.
    """
    outside = dr.norm(away)
    choice = stream.next_float32()
    may_miss = outside > radius
    is_line = ~may_miss | (choice < 0.5)
    # Lines through the drawn point.
    line = q - away
    distance = dr.maximum(dr.norm(line), 1e-12)
    straight = line / distance
    along = dr.dot(away, straight)
    inside = dr.square(along) - dr.square(outside) + dr.square(radius)
    way = dr.safe_sqrt(inside) - along
    leaves = (inside >= 0.0) & (distance > way)
    through = dr.select(leaves, dr.rcp(dr.square(distance)), 0.0)
    # Lines that touch.
    axis = away / dr.maximum(outside, 1e-30)
    depth = dr.dot(q, axis)
    beside = q - axis * depth
    off = dr.maximum(dr.norm(beside), 1e-12)
    beside = beside / off
    far = dr.norm(q)
    turn = dr.safe_acos(radius / dr.maximum(far, 1e-30)) * dr.select(choice < 0.75, 1.0, -1.0)
    sine, cosine = dr.sincos(dr.atan2(off, depth) + turn)
    foot = (axis * cosine + beside * sine) * radius
    tangent = q - foot
    reach = dr.maximum(dr.norm(tangent), 1e-12)
    touching = tangent / reach
    misses = (far > radius) & (outside * cosine > radius)
    slant = dr.safe_sqrt(1.0 - dr.square(dr.dot(touching, axis)))
    grazes = dr.select(misses, slant / (reach * off), 0.0)
    direction = dr.select(is_line, straight, touching)
    chance = dr.select(may_miss, dr.select(is_line, 2.0, 4.0), 1.0)
    value = dr.select(is_line, through, grazes) * chance
    start = dr.select(is_line, away + straight * way, foot)
    return start, dr.select(value > 0.0, value * density(direction), 0.0)
