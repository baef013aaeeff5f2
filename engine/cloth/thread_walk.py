"""Light inside a thread, photon by photon: a cylinder with spheres that scatter, in a matter of another index than air's.

Lengths are in radii. A photon enters where the normal is +x, the thread lies along z; nothing is absorbed: the length of the
way is kept, by which any dye absorbs afterwards, so one walk is for all bands in which spheres scatter alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from .boundary import COSINES, share_table

CHUNK = 64
"""Steps after which photons that have left are put aside, so that the others do not wait for them."""

MOST_CHUNKS = 400
"""Chunks after which a photon counts as lost."""


@dataclass(frozen=True, eq=False)
class ThreadOptics:
    """A thread as photons see it.

    Parameters
    ----------
    index : float    Of the matter between the spheres. [-]
    optical_radius : float    Scattering coefficient times radius. [-]
    cosines : (k,) float64 array    Of the angle of scattering, at chances even from 0 to 1.
    roughness : float    alpha of the surface, see `boundary`; 0: smooth.
    """

    index: float
    optical_radius: float
    cosines: np.ndarray
    roughness: float = 0.0


@dataclass
class Exits:
    """Where photons leave, in the frame of where they entered; arrays of Dr.Jit.

    Parameters
    ----------
    along : Float    Along the thread. [radius]
    turn : Float    About it, from the entry's normal towards y. [rad]
    normal, axial, around : Float    Direction by the exit's own normal, along the thread, and about it.
    length : Float    Way inside. [radius]
    lost : Bool    Not out after `MOST_CHUNKS` chunks; the rest is then of no meaning.
    """

    along: mi.Float
    turn: mi.Float
    normal: mi.Float
    axial: mi.Float
    around: mi.Float
    length: mi.Float
    lost: mi.Bool


def walk_inside(optics: ThreadOptics, axial, offset, seed: int) -> Exits:
    """Follow photons that have entered a thread until they are out.

    Parameters
    ----------
    axial : Float    Component of the incoming direction along the thread.
    offset : Float    Of the ray from the axis, -1 to 1; positive: it goes towards +y.
    seed : int
    """
    count = dr.width(axial)
    level = dr.safe_sqrt(1.0 - axial * axial)
    # Opaque: numbers that stand in a kernel make it another one for each thread.
    index = dr.opaque(mi.Float, optics.index)
    scattering = dr.opaque(mi.Float, max(optics.optical_radius, 1e-12))
    inverse = dr.rcp(index)
    dy, dz = level * offset * inverse, axial * inverse
    dx = -dr.safe_sqrt(1.0 - dy * dy - dz * dz)
    zero = dr.zeros(mi.Float, count)
    state = [mi.Float(1.0) + zero, zero, zero, dx + zero, dy + zero, dz + zero, mi.Float(zero)]
    cosines, shares = (
        mi.Float(optics.cosines),
        mi.Float(share_table(optics.index, optics.roughness)),
    )
    found = [dr.zeros(mi.Float, count) for _ in range(6)]
    place = dr.arange(mi.UInt32, count)
    for chunk in range(MOST_CHUNKS):
        stream = random_numbers(seed, chunk, place)
        inside, *state = _go_on(index, scattering, cosines, shares, stream, state)
        dr.eval(inside, *state)
        out = dr.compress(~inside)
        _put(
            found,
            dr.gather(mi.UInt32, place, out),
            [dr.gather(mi.Float, each, out) for each in state],
        )
        rest = dr.compress(inside)
        if not dr.width(rest):
            place = rest
            break
        place = dr.gather(mi.UInt32, place, rest)
        state = [dr.gather(mi.Float, each, rest) for each in state]
        dr.eval(place, *state)
    lost = dr.zeros(mi.Bool, count)
    if dr.width(place):
        dr.scatter(lost, mi.Bool(True), place)
    along, turn, outward, along_axis, around, length = found
    dr.eval(found, lost)
    return Exits(along, turn, outward, along_axis, around, length, lost)


def random_numbers(seed: int, part: int, place) -> mi.PCG32:
    """Random numbers of photons by their numbers, and of a part of their ways."""
    word = (seed * 0x9E3779B97F4A7C15 + part) % (1 << 64)
    return mi.PCG32(
        size=dr.width(place),
        initstate=dr.opaque(mi.UInt64, word),
        initseq=mi.UInt64(place) + 1,
    )


def _put(found, place, state) -> None:
    """Write photons that are out where they belong. Their directions are those outside, times their positions' frame."""
    if not dr.width(place):
        return
    x, y, z, dx, dy, dz, length = state
    around = x * dy - y * dx
    outward = dr.safe_sqrt(1.0 - dz * dz - around * around)
    for array, value in zip(found, (z, dr.atan2(y, x), outward, dz, around, length), strict=True):
        dr.scatter(array, value, place)


def _go_on(index, scattering, cosines, shares, stream, state):
    """Take up to `CHUNK` steps; directions of those that are out are multiplied by the index, as outside."""
    squared = index * index
    last = dr.width(cosines) - 1

    def step(count, inside, stream, x, y, z, dx, dy, dz, length):
        free = -dr.log(1.0 - stream.next_float32()) / scattering
        a = dr.maximum(dx * dx + dy * dy, 1e-12)
        b = x * dx + y * dy
        wall = (dr.sqrt(dr.maximum(b * b - a * (x * x + y * y - 1.0), 0.0)) - b) / a
        hits = wall <= free
        way = dr.select(hits, dr.maximum(wall, 0.0), free)
        x, y, z = dr.fma(way, dx, x), dr.fma(way, dy, y), dr.fma(way, dz, z)
        length = length + way
        # At the wall: out with what the surface lets pass, back with the rest.
        scale = dr.rcp(dr.sqrt(dr.maximum(x * x + y * y, 1e-12)))
        nx, ny = x * scale, y * scale
        cosine = nx * dx + ny * dy
        outside = 1.0 - squared * (1.0 - cosine * cosine)
        goes = (outside > 0.0) & (stream.next_float32() >= _at_root(shares, dr.safe_sqrt(outside)))
        # At a sphere: a new direction by its own angle and any azimuth.
        place = stream.next_float32() * last
        low = dr.minimum(mi.UInt32(place), last - 1)
        share = place - mi.Float(low)
        first = dr.gather(mi.Float, cosines, low)
        bend = dr.lerp(first, dr.gather(mi.Float, cosines, low + 1), share)
        side, up = dr.sincos(stream.next_float32() * dr.two_pi)
        tilt = dr.safe_sqrt(1.0 - bend * bend)
        sx, sy, sz = _bent(dx, dy, dz, tilt * up, tilt * side, bend)
        times = dr.select(hits, dr.select(goes, index, 1.0), 1.0)
        back = dr.select(goes, 0.0, 2.0 * cosine)
        dx = dr.select(hits, times * (dx - back * nx), sx)
        dy = dr.select(hits, times * (dy - back * ny), sy)
        dz = dr.select(hits, times * dz, sz)
        x, y = dr.select(hits, nx, x), dr.select(hits, ny, y)
        return count + 1, inside & ~(hits & goes), stream, x, y, z, dx, dy, dz, length

    count, inside = dr.zeros(mi.UInt32, dr.width(stream)), dr.full(mi.Bool, True, dr.width(stream))
    _, inside, _, *state = dr.while_loop(
        (count, inside, stream, *state),
        lambda count, inside, *_: inside & (count < CHUNK),
        step,
        label="walk in a thread",
    )
    return inside, *state


def _at_root(table, root):
    """Value of `share_table` at the square root of a cosine, given the cosine."""
    place = dr.sqrt(dr.maximum(root, 0.0)) * COSINES
    low = dr.minimum(mi.UInt32(place), COSINES - 1)
    return dr.lerp(
        dr.gather(mi.Float, table, low), dr.gather(mi.Float, table, low + 1), place - mi.Float(low)
    )


def _bent(x, y, z, one, two, along):
    """A direction turned: ``along`` itself and by ``one`` and ``two`` along axes across it (Duff and others, 2017)."""
    sign = dr.select(z >= 0.0, 1.0, -1.0)
    a = -dr.rcp(sign + z)
    b = x * y * a
    made = (
        (1.0 + sign * x * x * a) * one + b * two + x * along,
        sign * b * one + (sign + y * y * a) * two + y * along,
        -sign * x * one - y * two + z * along,
    )
    scale = dr.rsqrt(made[0] * made[0] + made[1] * made[1] + made[2] * made[2])
    return made[0] * scale, made[1] * scale, made[2] * scale
