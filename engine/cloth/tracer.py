"""Rays in a woven cloth: from yarn to yarn until they are above it or below.

The repeat is periodic: rays that leave it by a side come in by the other one. Where a ray meets a yarn a facet of its
surface reflects it, or it enters and comes out by a record of the thread (`records`); so nothing is lost. Ways inside each
kind of yarn are summed up, by which dyes absorb afterwards.

What a ray does is as likely the other way round. Records are of straight round threads, on which equal steps along and
about are equal areas; so on bent flat yarns exits are moved by equal areas (`tubes.girths`). Where yarns press into each
other, light that leaves one inside another meets the first surface back along its line: that of the other yarn in the
first, or the first yarn's own far side. The map of lines keeps projected solid angles and is its own reverse.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np

from .records import DrawnExits
from .thread_walk import ThreadOptics, random_numbers
from .tubes import ABOUT, CORNERS, Tubes, girths, make_triangles

FIRST_CHUNK, LARGEST_CHUNK = 4, 64
"""Steps after which rays that have left are put aside, so that the others do not wait for them.

Of those that are still there most stay long, so each chunk is twice the one before; a pile holds some for hundreds of steps.
"""

MOST_STEPS = 4000
"""Steps, from yarn to yarn or to a side of what is there of them, after which a ray counts as lost."""

KINDS = 3
"""Kinds of yarn: warp, weft, pile."""


@dataclass
class Traced:
    """Where rays end; arrays of Dr.Jit.

    Parameters
    ----------
    x, y, z : Float    Direction in which they leave.
    ways : list of Float    Way inside each kind of yarn. [mm]
    events : UInt32    How often they met yarns; 0: they went straight through.
    lost : Bool
    """

    x: mi.Float
    y: mi.Float
    z: mi.Float
    ways: list
    events: mi.UInt32
    lost: mi.Bool


class WovenScene:
    """A cloth's repeat on the device.

    Parameters
    ----------
    tubes : Tubes
    optics : list of ThreadOptics    Of each kind of yarn; of these the index and roughness count.
    exits : DrawnExits    Of `KINDS` threads for each anchor, one after the other.
    anchors : int    Wavelengths at which rays are followed, in turn.
    radii : list of float    Of the round threads that the records are of, by kind. [mm]
    """

    def __init__(
        self, tubes: Tubes, optics: list[ThreadOptics], exits: DrawnExits, anchors: int, radii
    ):
        self.tubes, self.exits, self.anchors = tubes, exits, anchors
        points, faces = make_triangles(tubes)
        mesh = mi.Mesh("cloth", len(points), len(faces))
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = mi.Float(points.ravel())
        parameters["faces"] = mi.UInt32(faces.ravel())
        parameters.update()
        self.scene = mi.load_dict({"type": "scene", "cloth": mesh})
        one, two, three = (points[faces[:, k]] for k in range(3))
        self.facing = mi.Float(np.cross(three - one, two - one).ravel())
        self.rings = tubes.widths.shape[1]
        # Four numbers are fetched at a time.
        self.centres, self.tangents, self.ups = (
            mi.Float(np.concatenate([each, more[..., None]], axis=2).ravel())
            for each, more in (
                (tubes.centres, 0.5 * tubes.heights),
                (tubes.tangents, 0.5 * tubes.widths),
                (tubes.ups, tubes.bends),
            )
        )
        self.steps, self.periods = mi.Float(tubes.steps), mi.Float(tubes.periods)
        self.kinds = mi.UInt32(tubes.kinds)
        self.girths = mi.Float(girths(tubes).ravel())
        self.radii = mi.Float(np.asarray(radii, np.float64))
        self.indices = mi.Float([each.index for each in optics])
        self.roughnesses = mi.Float([each.roughness for each in optics])
        # Opaque: numbers that stand in a kernel make it another one for each cloth.
        self.bounds = [
            dr.opaque(mi.Float, float(each))
            for each in (*tubes.size, *tubes.pad, tubes.low, tubes.high)
        ]
        self.offset = dr.opaque(mi.Float, 2e-4 * float(tubes.heights.max()))
        self.last_ring = dr.opaque(mi.UInt32, self.rings - 1)

    def trace(self, direction, count: int, seed: int, places=None) -> Traced:
        """Send rays onto a cloth at places that are evenly spread; ray k goes at the anchor k modulo their number.

        Parameters
        ----------
        direction : (3,) array, or three Float
            In which they go, all or each; with z below 0 onto the front, above 0 onto the back.
        places : two Float or None    x and y where they start, above or below all yarns. [mm]
        """
        width, depth, *_ = self.bounds
        place = dr.arange(mi.UInt32, count)
        stream = random_numbers(seed, 0, place)
        # Places along one axis are even, so that openings are met as often as they are wide.
        x = (dr.arange(mi.Float, count) + stream.next_float32()) / count * width
        y = stream.next_float32() * depth
        if places is not None:
            x, y = (mi.Float(each) for each in places)
        # Opaque, as a kernel of its own for each direction would take longer than the rays do.
        heading = [
            each if isinstance(each, mi.Float) else dr.opaque(mi.Float, float(each), count)
            for each in direction
        ]
        z = dr.select(heading[2] < 0.0, self.bounds[5], self.bounds[4])
        zero = dr.zeros(mi.Float, count)
        none = dr.zeros(mi.UInt32, count)
        ways = [mi.Float(zero) for _ in range(KINDS)]
        state = [x, y, z, *heading, *ways, dr.zeros(mi.Bool, count), none, mi.UInt32(none)]
        found = [dr.zeros(type(each), count) for each in state]
        done, size, part = 0, FIRST_CHUNK, 0
        while done < MOST_STEPS:
            part += 1
            inside = dr.full(mi.Bool, True, dr.width(place))
            stream = random_numbers(seed, part, place)
            state[-1] = dr.zeros(mi.UInt32, dr.width(place))
            # Opaque, or each size would be a kernel of its own.
            steps = dr.opaque(mi.UInt32, size)
            inside, _, *state = dr.while_loop(
                (inside, stream, *state),
                lambda inside, *rest, steps=steps: inside & (rest[-1] < steps),
                partial(self._step, place % dr.opaque(mi.UInt32, self.anchors)),
                label="rays in a cloth",
            )
            dr.eval(inside, *state)
            for array, values in zip(found, state, strict=True):
                dr.scatter(array, values, place, ~inside)
            rest = dr.compress(inside)
            if not dr.width(rest):
                place = rest
                break
            place, *state = (dr.gather(type(each), each, rest) for each in (place, *state))
            dr.eval(place, *state)
            done, size = done + size, min(2 * size, LARGEST_CHUNK)
        lost = dr.zeros(mi.Bool, count)
        if dr.width(place):
            dr.scatter(lost, mi.Bool(True), place)
        dr.eval(found, lost)
        _, _, _, dx, dy, dz, *ways, _, events, _ = found
        return Traced(dx, dy, dz, ways, events, lost)

    def straight_shares(self, directions, count: int, seed: int = 0) -> np.ndarray:
        """Share of light that meets no yarn. (n, 3) directions in which it goes down onto the front -> (n,) [-]

        Parameters
        ----------
        count : int    Rays of each direction, at places that are evenly spread along one axis.
        """
        width, depth, about_x, about_y, low, high = self.bounds
        place = dr.arange(mi.UInt32, len(directions) * count)
        stream = random_numbers(seed, 0, place)
        dx, dy, dz = (mi.Float(np.repeat(each, count)) for each in np.transpose(directions))
        x = (mi.Float(place % count) + stream.next_float32()) / count * width
        y = stream.next_float32() * depth
        z = high + dr.zeros(mi.Float, dr.width(place))

        def step(inside, is_open, x, y, z):
            sides = (
                (
                    dr.select(d > 0.0, extent + about - spot, spot + about)
                    / dr.maximum(dr.abs(d), 1e-9)
                )
                for d, spot, extent, about in ((dx, x, width, about_x), (dy, y, depth, about_y))
            )
            side = dr.maximum(dr.minimum(*sides), 0.0)
            down = dr.maximum((low - z) / dz, 0.0)
            reach = dr.minimum(side, down)
            ray = mi.Ray3f(mi.Point3f(x, y, z), mi.Vector3f(dx, dy, dz), reach, 0.0, mi.Color0f())
            is_open = is_open & ~self.scene.ray_test(ray)
            inside = inside & is_open & (side < down)
            x, y = _wrapped(dr.fma(reach, dx, x), width), _wrapped(dr.fma(reach, dy, y), depth)
            return inside, is_open, x, y, dr.fma(reach, dz, z)

        yes = dr.full(mi.Bool, True, dr.width(place))
        _, is_open, *_ = dr.while_loop(
            (mi.Bool(yes), mi.Bool(yes), x, y, z),
            lambda inside, *_: inside,
            step,
            label="straight light",
        )
        return np.array(is_open).reshape(len(directions), count).mean(axis=1)

    def _step(
        self,
        anchor,
        inside,
        stream,
        x,
        y,
        z,
        dx,
        dy,
        dz,
        warp,
        weft,
        pile,
        goes_back,
        events,
        steps,
    ):
        width, depth, about_x, about_y, low, high = self.bounds
        # To the nearest side of the repeat with what lies about it.
        away_x = dr.select(dx > 0.0, width + about_x - x, x + about_x) / dr.maximum(
            dr.abs(dx), 1e-9
        )
        away_y = dr.select(dy > 0.0, depth + about_y - y, y + about_y) / dr.maximum(
            dr.abs(dy), 1e-9
        )
        away_z = dr.select(dz > 0.0, high - z, z - low) / dr.maximum(dr.abs(dz), 1e-9)
        side = dr.maximum(dr.minimum(away_x, away_y), 0.0)
        reach = dr.minimum(side, dr.maximum(away_z, 0.0))
        ray = mi.Ray3f(
            mi.Point3f(x, y, z), mi.Vector3f(dx, dy, dz), reach + self.offset, 0.0, mi.Color0f()
        )
        met = self.scene.ray_intersect_preliminary(ray, coherent=False)
        hits = met.is_valid() & (met.t <= reach)
        ends = ~hits & (away_z <= side)
        facing = dr.gather(mi.Vector3f, self.facing, met.prim_index, hits)
        from_inside = dr.dot(mi.Vector3f(dx, dy, dz), facing) > 0.0
        # Light that turns out to be inside a yarn looks back along its line for the surface that it meets.
        counts = hits & (from_inside == goes_back)
        turns = hits & from_inside & ~goes_back
        sign = dr.select(goes_back, -1.0, 1.0)
        start, made, way, kind = self._meet(
            anchor, stream, met, counts, sign * mi.Vector3f(dx, dy, dz)
        )
        ahead = dr.select(turns, 0.0, dr.select(hits, met.t + self.offset, side))
        x = _wrapped(dr.select(counts, start.x, dr.fma(ahead, dx, x)), width)
        y = _wrapped(dr.select(counts, start.y, dr.fma(ahead, dy, y)), depth)
        z = dr.select(counts, start.z, dr.fma(ahead, dz, z))
        turn = dr.select(turns, -1.0, 1.0)
        dx, dy, dz = (
            dr.select(counts, one, turn * other)
            for one, other in ((made.x, dx), (made.y, dy), (made.z, dz))
        )
        goes_back = (goes_back | turns) & ~counts
        warp = warp + dr.select(counts & (kind == 0), way, 0.0)
        weft = weft + dr.select(counts & (kind == 1), way, 0.0)
        pile = pile + dr.select(counts & (kind == 2), way, 0.0)
        events = events + dr.select(counts, mi.UInt32(1), mi.UInt32(0))
        inside = inside & ~ends
        return inside, stream, x, y, z, dx, dy, dz, warp, weft, pile, goes_back, events, steps + 1

    def _meet(self, anchor, stream, met, hits, direction):
        """Where a ray that meets a yarn goes on, and by which way inside: place, direction, way, kind."""
        prim = met.prim_index
        quad, second = prim // 2, (prim & 1) == 1
        corner = quad % CORNERS
        strip = quad // CORNERS
        tube = strip // self.last_ring
        ring = strip - tube * self.last_ring
        u, v = met.prim_uv.x, met.prim_uv.y
        place = mi.Float(ring) + dr.select(second, u, u + v)
        turn = (mi.Float(corner) + dr.select(second, u + v, v)) * (2.0 * np.pi / CORNERS)
        kind = dr.gather(mi.UInt32, self.kinds, tube, hits)
        frame = self._frame(tube, place, hits)
        _, normal, along, about = self._point(frame, turn)
        axial, around = dr.dot(direction, along), dr.dot(direction, about)
        # A facet of the drawn body may face light that its round one turns away from.
        inward = dr.maximum(-dr.dot(direction, normal), 1e-4)
        reflected, out = self._facet(stream, kind, mi.Vector3f(-around, -axial, inward), hits)
        drawn = self.exits.draw(kind + KINDS * anchor, axial, around, inward, stream, hits)
        radius = dr.gather(mi.Float, self.radii, kind, hits)
        moved = place + drawn[0] * radius / dr.gather(mi.Float, self.steps, tube, hits)
        moved = self._placed(tube, dr.select(reflected, place, moved), hits)
        area = self._area(kind, turn, frame[-1], hits) + drawn[1]
        frame = self._frame(tube, moved, hits)
        turn = dr.select(reflected, turn, self._turn(kind, area, frame[-1], hits))
        point, normal, along, about = self._point(frame, turn)
        ahead = drawn[2] * normal + drawn[3] * along + drawn[4] * about
        mirrored = out.z * normal + out.y * along + out.x * about
        made = dr.normalize(dr.select(reflected, mirrored, ahead))
        way = dr.select(reflected, 0.0, drawn[5] * radius)
        return point + normal * self.offset, made, way, kind

    def _placed(self, tube, place, hits):
        """Places along tubes, brought back by whole repeats, or mirrored at a pile's ends."""
        period = dr.gather(mi.Float, self.periods, tube, hits)
        last = mi.Float(self.last_ring)
        safe = dr.maximum(period, 1.0)
        shifted = place - safe * dr.round((place - 0.5 * last) / safe)
        double = 2.0 * last
        folded = dr.abs(place - double * dr.round(place / double))
        return dr.clip(dr.select(period > 0.0, shifted, folded), 0.0, last)

    def _area(self, kind, turn, bend, hits):
        """Share of a ring's area up to an angle about it, times 2 pi; see `tubes.girths`."""
        half = turn - 2.0 * np.pi * dr.round(turn / (2.0 * np.pi))
        spot = dr.minimum(dr.abs(half) * (ABOUT / np.pi), ABOUT - 1e-3)
        low = mi.UInt32(spot)
        first, second = (self._cut(kind, low + k, bend, hits) for k in (0, 1))
        return dr.mulsign(dr.lerp(first, second, spot - mi.Float(low)), half)

    def _turn(self, kind, area, bend, hits):
        """The angle about a ring up to which there is a share of its area: the reverse of `_area`."""
        half = area - 2.0 * np.pi * dr.round(area / (2.0 * np.pi))
        wanted = dr.abs(half)
        low = dr.zeros(mi.UInt32, dr.width(half))
        step = ABOUT // 2
        while step:
            middle = low + step
            low = dr.select(self._cut(kind, middle, bend, hits) <= wanted, middle, low)
            step //= 2
        first, second = (self._cut(kind, low + k, bend, hits) for k in (0, 1))
        share = dr.clip((wanted - first) / dr.maximum(second - first, 1e-9), 0.0, 1.0)
        return dr.mulsign((mi.Float(low) + share) * (np.pi / ABOUT), half)

    def _cut(self, kind, number, bend, hits):
        pair = dr.gather(mi.Vector2f, self.girths, kind * (ABOUT + 1) + number, hits)
        return pair.x - bend * pair.y

    def _frame(self, tube, place, hits):
        """Centre, half axes, axes along, up and across of a tube at places along it, and its bend."""
        low = dr.minimum(mi.UInt32(place), self.last_ring - 1)
        share = place - mi.Float(low)
        first = tube * (self.last_ring + 1) + low

        def between(array):
            one = dr.gather(mi.Vector4f, array, first, hits)
            made = dr.lerp(one, dr.gather(mi.Vector4f, array, first + 1, hits), share)
            return mi.Vector3f(made.x, made.y, made.z), made.w

        centre, b = between(self.centres)
        along, a = between(self.tangents)
        up, bend = between(self.ups)
        along = dr.normalize(along)
        up = dr.normalize(up - dr.dot(up, along) * along)
        return centre, a, b, along, up, bend

    @staticmethod
    def _point(frame, turn):
        """Point, normal, and axes along and about a tube at an angle about it."""
        centre, a, b, along, up, _ = frame
        across = dr.cross(along, up)
        sine, cosine = dr.sincos(turn)
        point = centre + b * cosine * up + a * sine * across
        normal = dr.normalize(a * cosine * up + b * sine * across)
        return point, normal, along, dr.cross(along, normal)

    def _facet(self, stream, kind, view, hits):
        """Whether a facet reflects, and where to; ``view`` points back along the ray in (about, along, normal)."""
        roughness = dr.gather(mi.Float, self.roughnesses, kind, hits)
        index = dr.gather(mi.Float, self.indices, kind, hits)
        stretched = dr.normalize(mi.Vector3f(roughness * view.x, roughness * view.y, view.z))
        level = dr.sqrt(dr.maximum(stretched.x * stretched.x + stretched.y * stretched.y, 0.0))
        safe = dr.maximum(level, 1e-8)
        one = dr.select(
            level > 1e-7,
            mi.Vector3f(-stretched.y / safe, stretched.x / safe, 0.0),
            mi.Vector3f(1.0, 0.0, 0.0),
        )
        two = dr.cross(stretched, one)
        radius = dr.sqrt(stream.next_float32())
        side, up = dr.sincos(dr.two_pi * stream.next_float32())
        first, second = radius * up, radius * side
        lift = 0.5 * (1.0 + stretched.z)
        second = (1.0 - lift) * dr.safe_sqrt(1.0 - first * first) + lift * second
        rest = dr.safe_sqrt(1.0 - first * first - second * second)
        facet = first * one + second * two + rest * stretched
        facet = dr.normalize(
            mi.Vector3f(roughness * facet.x, roughness * facet.y, dr.maximum(facet.z, 1e-6))
        )
        facet = dr.select(roughness > 0.0, facet, mi.Vector3f(0.0, 0.0, 1.0))
        cosine = dr.maximum(dr.dot(view, facet), 0.0)
        out = 2.0 * cosine * facet - view
        masking = (1.0 + _lambda(view.z, roughness)) / (
            1.0 + _lambda(view.z, roughness) + _lambda(out.z, roughness)
        )
        chance = dr.select(out.z > 1e-4, _fresnel(cosine, index) * masking, 0.0)
        return stream.next_float32() < chance, out


def _lambda(cosine, roughness):
    cosine = dr.maximum(cosine, 1e-4)
    return 0.5 * (dr.sqrt(1.0 + roughness * roughness * (dr.rcp(cosine * cosine) - 1.0)) - 1.0)


def _fresnel(cosine, index):
    inner = dr.safe_sqrt(1.0 - (1.0 - cosine * cosine) / (index * index))
    across = (cosine - index * inner) / (cosine + index * inner)
    within = (index * cosine - inner) / (index * cosine + inner)
    return 0.5 * (across * across + within * within)


def _wrapped(place, period: float):
    return place - period * dr.floor(place / period)
