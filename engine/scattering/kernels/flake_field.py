"""The field of a surface's flakes in kernels: the same flakes from everywhere, one by one where they are few.

A flake lies in a cell of place and slope, and a hash of the cell's number says how many there are and where and how each
lies; so wherever it is looked at from, it is the same flake. Places are those of the object, projected along the axis that
its face is most across, where more flakes are laid out than there are at the steepest and the rest is left out.

Where a pixel covers more than `FEWEST_CELLS` cells across, flakes are counted no longer but give way to a log-normal field
of the same mean and variance, until at `MOST_CELLS` none is left. It comes of Gaussian noise on a lattice of a spacing that
follows the pixel's size in steps of two, between which it fades.

References
----------
S. Ershov, A. Khodulev, K. Kolchin: Simulation of Sparkles in Metallic Paints, Graphicon 1999.
W. Jakob, M. Hasan, L.-Q. Yan, J. Lawrence, R. Ramamoorthi, S. Marschner: Discrete Stochastic Microfacet Models, ACM TOG
33(4), 2014.
T. Deliot, L. Belcour: Real-Time Rendering of Glinty Appearances using Distributed Binomial Laws on Anisotropic Grids, CGF
42(8), 2023.
"""

import math

import drjit as dr
import mitsuba as mi

from ...arrays import upload
from ...scene.scattering import Sparkle
from ..data.flake_field import (
    AREAS,
    FACING,
    SQUARED_KERNEL,
    counts_of_cells,
    lay_out,
)

PIXEL_RADIUS = 0.75
"""Radius of the kernel over the surface. [pixel]"""

FEWEST_CELLS, MOST_CELLS = 2.0, 3.0
"""Half the extent of the kernel from which on flakes give way to noise, and at which there is noise alone. [cell]"""

GRAZING = 0.05
"""Cosine from which on the kernel grows no longer at flat angles. [-]"""

STEEPEST = 4.5
"""Slopes over their standard deviation from which on there are no flakes to speak of. [-]"""

MOST_VARIANCE = 4.0
"""Of the noise while flakes give way to it, unless the whole has more. [-]"""

SURE = 1.0 - 2.0**-23
"""Largest share of flakes whose slope is finite in single precision. [-]"""

LEVELS = 24
"""Lattices of noise, each twice as wide as the one before."""


class Eyed:
    """What all flakes of a surface have in common where it is looked at.

    Attributes
    ----------
    is_seen : Bool    Whether the camera looks at it.
    place : Point2f    In the object, projected along one of its axes. [m]
    across : Float    Cosine between that axis and the face. [-]
    form : tuple of Float    Of the kernel: r^2 = form[0] x^2 + 2 form[1] x y + form[2] y^2 about the place. [1/m2]
    axis : UInt32    That axis.
    first : Vector2f    Local tangent that slopes are measured along; the other one is across it.
    """

    def __init__(self, si, ways, active):
        self.is_seen = mi.Bool(active) & (si.duv_dx.x > 0.0)
        number = dr.reinterpret_array(mi.UInt32, si.shape)
        rows = [
            mi.Vector3f(*(dr.gather(mi.Float, ways, number * 12 + 3 * k + n, self.is_seen) for n in range(3)))
            for k in range(4)
        ]  # fmt: skip
        away = mi.Vector3f(si.p) - rows[3]
        normal = [dr.dot(row, mi.Vector3f(si.n)) for row in rows[:3]]
        eye = si.to_world(si.wi)
        place = [dr.dot(row, away) for row in rows[:3]]
        seen = [dr.dot(row, eye) for row in rows[:3]]
        size = [dr.abs(each) for each in normal]
        is_x = (size[0] >= size[1]) & (size[0] >= size[2])
        is_y = ~is_x & (size[1] >= size[2])
        self.axis = dr.select(is_x, mi.UInt32(0), dr.select(is_y, mi.UInt32(1), mi.UInt32(2)))

        def turn(v):
            return [
                dr.select(is_x, v[(1 + k) % 3], dr.select(is_y, v[(2 + k) % 3], v[k]))
                for k in range(3)
            ]

        a, b, c = turn(normal)
        self.across = dr.maximum(dr.abs(c), 1e-3)
        c = dr.select(c < 0.0, -self.across, self.across)
        u, v, w = turn(seen)
        first, second = u - w * a / c, v - w * b / c
        share = 1.0 - GRAZING**2
        scale = dr.rcp(dr.square(PIXEL_RADIUS * dr.maximum(si.duv_dx.x, 1e-12)))
        self.form = (
            scale * (1.0 + dr.square(a / c) - share * dr.square(first)),
            scale * (a * b / dr.square(c) - share * first * second),
            scale * (1.0 + dr.square(b / c) - share * dr.square(second)),
        )
        x, y, _ = turn(place)
        self.place = mi.Point2f(x, y)
        axis = dr.select(is_x, rows[1], dr.select(is_y, rows[2], rows[0]))
        tangent = si.to_local(axis)
        length = dr.hypot(tangent.x, tangent.y)
        is_known = length > 1e-6
        self.first = mi.Vector2f(
            dr.select(is_known, tangent.x / dr.maximum(length, 1e-6), 1.0),
            dr.select(is_known, tangent.y / dr.maximum(length, 1e-6), 0.0),
        )

    @property
    def determinant(self):
        """Of the form; the kernel's area in the projection is pi over its root. [1/m4]"""
        return dr.maximum(self.form[0] * self.form[2] - dr.square(self.form[1]), 1e-30)


class FlakeField:
    """Field of one kind of flakes.

    Parameters
    ----------
    sparkle : Sparkle
    number : int    Of the kind; other numbers give other flakes.
    """

    def __init__(self, sparkle: Sparkle, number: int = 0):
        layout = lay_out(sparkle)
        self.areas = upload(mi.Float, layout.areas)
        dr.eval(self.areas)
        cells = layout.slope_cells
        for name, value in (
            ("density", layout.density),
            ("slope", layout.slope),
            ("radius", layout.radius),
            ("cell", layout.cell),
            ("moment", layout.moment),
            ("index", layout.index),
            ("smooth", layout.smooth_variance),
            ("squared", layout.squared_variance),
        ):
            made = mi.Float(value)
            dr.make_opaque(made)
            setattr(self, name, made)
        self.cells, self.salt = mi.Int32(cells), mi.UInt32(0x9E3779B9 * (number + 1) & 0xFFFFFFFF)
        dr.make_opaque(self.cells, self.salt)

    def evaluate(self, eyed: Eyed, wi, wo):
        """Factor of mean 1 for light between two local directions on the same side, z turned up; 1 where nobody looks."""
        slope = self._slope(eyed, wi, wo)
        squared = dr.squared_norm(slope)
        steep = squared > dr.square(STEEPEST * self.slope)
        active = eyed.is_seen & ~steep
        root = dr.sqrt(eyed.determinant)
        halves = [dr.sqrt(eyed.form[n]) / root for n in (2, 0)]
        extent = dr.maximum(halves[0], halves[1]) / self.cell
        counted = dr.clip((MOST_CELLS - extent) / (MOST_CELLS - FEWEST_CELLS), 0.0, 1.0)

        # Flakes in sight and lit, and the mean square of their weights.
        number = self.density / eyed.across * (math.pi / 3.0) / root
        lit = math.pi / 3.0 * dr.square(self.radius) * _gauss(squared, self.smooth)
        square = math.pi / 5.0 * dr.square(self.radius) * _gauss(squared, self.squared)
        mean = number * lit
        variance = self.moment * SQUARED_KERNEL * square / dr.maximum(mean * lit, 1e-30)

        found = self._count(eyed, slope, halves, counted, active & (counted > 0.0))
        rest = 1.0 - counted
        most = dr.maximum(variance, MOST_VARIANCE)
        own = dr.minimum(variance / dr.maximum(rest, 1e-6), most)
        spread = dr.log(1.0 + own)
        noise = self._noise(eyed, slope, root, active & (rest > 0.0))
        smooth = dr.exp(dr.sqrt(spread) * noise - 0.5 * spread)
        value = found / dr.maximum(mean, 1e-30) + rest * smooth
        return dr.select(active, value, 1.0)

    # ---- private ----

    def _slope(self, eyed: Eyed, wi, wo):
        """Slope of the flakes that mirror light between two directions, along the field's own axes. (Vector2f)"""
        half = _refracted(wi, self.index) + _refracted(wo, self.index)
        x, y = half.x / half.z, half.y / half.z
        return mi.Vector2f(x * eyed.first.x + y * eyed.first.y, y * eyed.first.x - x * eyed.first.y)

    def _share(self, slope):
        """Share of flakes below a slope. [-]"""
        return 0.5 + 0.5 * dr.erf(slope / self.slope * math.sqrt(0.5))

    def _slope_at(self, share):
        """Slope below which a share of the flakes lies."""
        inner = dr.clip(2.0 * share - 1.0, -SURE, SURE)
        return self.slope * math.sqrt(2.0) * dr.erfinv(inner)

    def _count(self, eyed: Eyed, slope, halves, counted, active):
        """Sum of the weights of the flakes that are there; ``counted``: share that has not given way."""
        top = self.cells - 1
        place = [eyed.place[n] / self.cell for n in (0, 1)]
        reach = [half / self.cell for half in halves]
        ends = [
            (dr.clip(mi.Int32(self._share(s - self.radius) * self.cells), 0, top),
             dr.clip(mi.Int32(self._share(s + self.radius) * self.cells), 0, top))
            for s in slope
        ] + [
            (mi.Int32(dr.floor(p - r)), mi.Int32(dr.floor(p + r)))
            for p, r in zip(place, reach, strict=True)
        ]  # fmt: skip
        begin, end = ([each[n] for each in ends] for n in (0, 1))
        chance = counted / (eyed.across * FACING)
        form = [each * dr.square(self.cell) for each in eyed.form]
        inverse, narrow = dr.rcp(mi.Float(self.cells)), dr.rcp(dr.square(self.radius))
        base = self.salt ^ (eyed.axis * mi.UInt32(0xC2B2AE35))
        thresholds = counts_of_cells()

        def step(cell, at, left, word, found):
            """Take the next flake of the cell, or go on to the next cell where none is left."""
            enters = left == 0
            # Cells are counted like the digits of a number, the slopes' first.
            cell, carries = list(cell), mi.Bool(enters)
            for n in range(3):
                number = dr.select(carries, cell[n] + 1, cell[n])
                carries &= number > end[n]
                cell[n] = dr.select(carries, begin[n], number)
            cell[3] = dr.select(carries, cell[3] + 1, cell[3])
            key = _hash(base ^ mi.UInt32(cell[2]))
            key = _hash(key + mi.UInt32(cell[3]))
            key = _hash(key + mi.UInt32(cell[0] + self.cells * cell[1]))
            draw, count = _unit(key), mi.UInt32(0)
            for threshold in thresholds:
                count += dr.select(draw >= threshold, mi.UInt32(1), mi.UInt32(0))
            corner = [mi.Float(cell[0]), mi.Float(cell[1])]
            corner += [mi.Float(cell[2]) - place[0], mi.Float(cell[3]) - place[1]]
            at = dr.select(enters, mi.Vector4f(*corner), at)

            here, lies, lives = (
                _hash(word + number) for number in (0x68BC21EB, 0x02E5BE93, 0x967A889B)
            )
            x, y = at.z + _low(here), at.w + _high(here)
            r2 = form[0] * x * x + 2.0 * form[1] * x * y + form[2] * y * y
            shares = (at.x + _low(lies)) * inverse, (at.y + _high(lies)) * inverse
            own = [self._slope_at(share) for share in shares]
            t2 = (dr.square(own[0] - slope[0]) + dr.square(own[1] - slope[1])) * narrow
            is_there = ~enters & (_low(lives) < chance) & (r2 < 1.0) & (t2 < 1.0)
            area = dr.gather(mi.Float, self.areas, lives >> 16 & (AREAS - 1), is_there)
            weight = area * dr.square(1.0 - r2) * dr.square(1.0 - t2)
            found = dr.select(is_there, found + weight, found)

            word = dr.select(enters, key, word + 0x9E3779B9)
            left = dr.select(enters, count, left - 1)
            return mi.Vector4i(*cell), at, left, word, found

        first = mi.Vector4i(begin[0] - 1, *begin[1:])
        *_, found = dr.while_loop(
            state=(first, mi.Vector4f(0.0), mi.UInt32(0), mi.UInt32(0), mi.Float(0.0)),
            cond=lambda cell, at, left, word, found: active & ((left > 0) | (cell.w <= end[3])),
            body=step,
            labels=("cell", "at", "left", "word", "found"),
        )
        return found

    def _noise(self, eyed: Eyed, slope, root, active):
        """Standard normal noise that changes over a pixel and over the slopes that a flake blurs."""
        level = 0.5 * dr.log2(1.0 / (root * dr.square(self.cell)))
        level = dr.clip(level, 0.0, float(LEVELS))
        lower, share = mi.UInt32(level), level - dr.floor(level)
        u = [self._share(s) * (2.0 * mi.Float(self.cells)) for s in slope]
        first = [dr.floor(each) for each in u]
        base = _hash(self.salt + eyed.axis)
        total, squares = mi.Float(0.0), mi.Float(0.0)
        for step, weight in ((0, 1.0 - share), (1, share)):
            spacing = self.cell * dr.exp2(mi.Float(lower + step))
            place = [eyed.place[n] / spacing for n in (0, 1)]
            begin = [dr.floor(p) for p in place]
            for corner in range(16):
                part, key = dr.sqrt(weight), _hash(base + (lower + step))
                for n, (value, low) in enumerate(zip((*place, *u), (*begin, *first), strict=True)):
                    bit = corner >> n & 1
                    near = value - low
                    part *= near if bit else 1.0 - near
                    key = _hash(key + mi.UInt32(mi.Int32(low)) + bit)
                total += part * math.sqrt(2.0) * dr.erfinv(2.0 * _unit(key) - 1.0)
                squares += dr.square(part)
        return dr.select(active, total / dr.sqrt(dr.maximum(squares, 1e-20)), 0.0)


def _gauss(squared, variance):
    return dr.exp(-0.5 * squared / variance) / (2.0 * math.pi * variance)


def _refracted(w, index):
    """Direction inside a body of a local direction above it."""
    x, y = w.x / index, w.y / index
    return mi.Vector3f(x, y, dr.safe_sqrt(1.0 - x * x - y * y))


def _hash(x):
    """Mix a 32-bit word (C. Wellons' hash of least bias)."""
    x = mi.UInt32(x)
    x ^= x >> 16
    x *= mi.UInt32(0x7FEB352D)
    x ^= x >> 15
    x *= mi.UInt32(0x846CA68B)
    x ^= x >> 16
    return x


def _unit(x):
    """Number within 0 and 1, never either, of a word."""
    return (mi.Float(x >> 9) + 0.5) * (1.0 / (1 << 23))


def _low(x):
    return (mi.Float(x & 0xFFFF) + 0.5) * (1.0 / (1 << 16))


def _high(x):
    return (mi.Float(x >> 16) + 0.5) * (1.0 / (1 << 16))
