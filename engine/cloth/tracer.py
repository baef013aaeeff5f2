"""Rays in a woven cloth: from yarn to yarn until they are above it or below.

The repeat is periodic: rays that leave it by a side come in by the other one. Where a ray meets a yarn a facet of its
surface reflects it, or it enters and comes out by a record of the thread (`records`); so nothing is lost. Ways inside each
kind of yarn are summed up, by which dyes absorb afterwards.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np

from .records import DrawnExits
from .thread_walk import ThreadOptics, random_numbers
from .tubes import CORNERS, Tubes, make_triangles

CHUNK = 4
"""Steps after which rays that have left are put aside, so that the others do not wait for them."""

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
        self.rings = tubes.widths.shape[1]
        # Four numbers are fetched at a time.
        self.centres, self.tangents, self.ups = (
            mi.Float(np.concatenate([each, more[..., None]], axis=2).ravel())
            for each, more in (
                (tubes.centres, 0.5 * tubes.heights),
                (tubes.tangents, 0.5 * tubes.widths),
                (tubes.ups, np.zeros_like(tubes.widths)),
            )
        )
        self.steps, self.periods = mi.Float(tubes.steps), mi.Float(tubes.periods)
        self.kinds = mi.UInt32(tubes.kinds)
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

    def trace(self, direction, count: int, seed: int) -> Traced:
        """Send rays onto a cloth at places that are evenly spread; ray k goes at the anchor k modulo their number.

        Parameters
        ----------
        direction : (3,) array    In which they go; with z below 0 onto the front, above 0 onto the back.
        """
        width, depth, *_ = self.bounds
        place = dr.arange(mi.UInt32, count)
        stream = random_numbers(seed, 0, place)
        # Places along one axis are even, so that openings are met as often as they are wide.
        x = (dr.arange(mi.Float, count) + stream.next_float32()) / count * width
        y = stream.next_float32() * depth
        down = float(direction[2]) < 0.0
        z = dr.opaque(mi.Float, self.tubes.high if down else self.tubes.low, count)
        # Opaque, as a kernel of its own for each direction would take longer than the rays do.
        heading = [dr.opaque(mi.Float, float(each), count) for each in direction]
        zero = dr.zeros(mi.Float, count)
        none = dr.zeros(mi.UInt32, count)
        state = [x, y, z, *heading, *(mi.Float(zero) for _ in range(KINDS)), none, mi.UInt32(none)]
        found = [dr.zeros(type(each), count) for each in state]
        for chunk in range(MOST_STEPS // CHUNK):
            inside = dr.full(mi.Bool, True, dr.width(place))
            stream = random_numbers(seed, chunk + 1, place)
            state[-1] = dr.zeros(mi.UInt32, dr.width(place))
            inside, _, *state = dr.while_loop(
                (inside, stream, *state),
                lambda inside, *rest: inside & (rest[-1] < CHUNK),
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
        lost = dr.zeros(mi.Bool, count)
        if dr.width(place):
            dr.scatter(lost, mi.Bool(True), place)
        dr.eval(found, lost)
        _, _, _, dx, dy, dz, *ways, events, _ = found
        return Traced(dx, dy, dz, ways, events, lost)

    def _step(self, anchor, inside, stream, x, y, z, dx, dy, dz, warp, weft, pile, events, steps):
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
        px, py, pz, ex, ey, ez, way, kind, counts = self._meet(
            anchor, stream, met, hits, mi.Point3f(x, y, z), mi.Vector3f(dx, dy, dz)
        )
        x = _wrapped(dr.select(hits, px, dr.fma(side, dx, x)), width)
        y = _wrapped(dr.select(hits, py, dr.fma(side, dy, y)), depth)
        z = dr.select(hits, pz, dr.fma(side, dz, z))
        dx, dy, dz = dr.select(hits, ex, dx), dr.select(hits, ey, dy), dr.select(hits, ez, dz)
        warp = warp + dr.select(hits & (kind == 0), way, 0.0)
        weft = weft + dr.select(hits & (kind == 1), way, 0.0)
        pile = pile + dr.select(hits & (kind == 2), way, 0.0)
        events = events + dr.select(counts, mi.UInt32(1), mi.UInt32(0))
        return inside & ~ends, stream, x, y, z, dx, dy, dz, warp, weft, pile, events, steps + 1

    def _meet(self, anchor, stream, met, hits, origin, direction):
        """Where a ray that meets a yarn goes on, and by which way inside: place, direction, way, kind, whether it counts."""
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
        _, normal, along, about = self._frame(tube, place, turn, hits)
        inward, axial, around = (
            -dr.dot(direction, normal),
            dr.dot(direction, along),
            dr.dot(direction, about),
        )
        # From inside, where yarns press into each other, there is nothing to meet.
        from_inside = inward <= 0.0
        reflected, out = self._facet(
            stream, kind, mi.Vector3f(-around, -axial, dr.maximum(inward, 1e-4)), hits
        )
        drawn = self.exits.draw(
            kind + KINDS * anchor, axial, around, dr.maximum(inward, 1e-4), stream
        )
        radius = dr.gather(mi.Float, self.radii, kind, hits)
        enters = ~reflected & ~from_inside
        moved = place + dr.select(
            enters, drawn[0] * radius / dr.gather(mi.Float, self.steps, tube, hits), 0.0
        )
        moved = self._placed(tube, moved, hits)
        turned = turn + dr.select(enters, drawn[1], 0.0)
        point, normal, along, about = self._frame(tube, moved, turned, hits)
        ahead = drawn[2] * normal + drawn[3] * along + drawn[4] * about
        mirrored = out.z * normal + out.y * along + out.x * about
        made = dr.normalize(dr.select(enters, ahead, mirrored))
        made = dr.select(from_inside, direction, made)
        through = origin + (met.t + self.offset) * direction
        start = dr.select(from_inside, through, point + normal * self.offset)
        way = dr.select(enters, drawn[5] * radius, 0.0)
        return start.x, start.y, start.z, made.x, made.y, made.z, way, kind, hits & ~from_inside

    def _placed(self, tube, place, hits):
        """Places along tubes, brought back by whole repeats, or to a pile's ends."""
        period = dr.gather(mi.Float, self.periods, tube, hits)
        last = mi.Float(self.last_ring)
        safe = dr.maximum(period, 1.0)
        middle = 0.5 * last
        shifted = place - safe * dr.round((place - middle) / safe)
        return dr.clip(dr.select(period > 0.0, shifted, place), 0.0, last)

    def _frame(self, tube, place, turn, hits):
        """Point, normal, and axes along and about a tube."""
        low = dr.minimum(mi.UInt32(place), self.last_ring - 1)
        share = place - mi.Float(low)
        first = tube * (self.last_ring + 1) + low

        def between(array):
            one = dr.gather(mi.Vector4f, array, first, hits)
            made = dr.lerp(one, dr.gather(mi.Vector4f, array, first + 1, hits), share)
            return mi.Vector3f(made.x, made.y, made.z), made.w

        centre, b = between(self.centres)
        along, a = between(self.tangents)
        up, _ = between(self.ups)
        along = dr.normalize(along)
        up = dr.normalize(up - dr.dot(up, along) * along)
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
