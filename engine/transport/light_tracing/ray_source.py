"""Rays drawn from a `RayEmission` inside kernels: the same as `engine/raysets/cloud.py` draws on the host."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...scene.ray_emission import GROUP, HULL, PLANE, SPHERE, RayEmission
from .ray_weight import RayWeight

LOWER = [(i, j) for i in range(6) for j in range(i + 1)]
"""Entries of a triangular factor that are not zero."""


class RaySource:
    """Tables of an emission, and how rays are drawn from them.

    Parameters
    ----------
    emission : RayEmission
    """

    def __init__(self, emission: RayEmission):
        self.emission = emission
        self._position = upload(mi.Float, emission.position)
        self._direction = upload(mi.Float, emission.direction)
        factor = emission.factor.astype(np.float32)
        self._factor = upload(mi.Float, np.stack([factor[:, i, j] for i, j in LOWER], axis=1))
        self._threshold = upload(mi.Float, emission.threshold)
        self._other = upload(mi.UInt32, emission.other)
        self._slabs = upload(mi.Float, emission.body.slabs if len(emission.body.slabs) else [0.0])
        self._slab_count = dr.opaque(mi.UInt32, len(emission.body.slabs))
        self._wavelength = None
        if emission.wavelength is not None:
            self._wavelength = upload(mi.Float, emission.wavelength)
        self._count = dr.opaque(mi.UInt32, len(emission.threshold))
        body = emission.body
        self._centre, self._normal = _vector(body.centre), _vector(body.normal)
        self._radius = dr.opaque(mi.Float, float(body.radius))
        self._weight = RayWeight([emission.weight])
        if emission.axis is not None:
            self._axis_centre, self._axis = (_vector(each) for each in emission.axis)

    def draw(self, stream):
        """Draw a ray for every lane.

        Returns
        -------
        (Point3f, Vector3f, Float, Float or None)    Start in the luminaire's axes about its centre [m], direction, share of
            the flux over that of an even share (1 in the mean), wavelength [nm].
        """
        place = dr.mul_hi(stream.next_uint32(), self._count)
        stays = stream.next_float32() < dr.gather(mi.Float, self._threshold, place)
        number = dr.select(stays, place, dr.gather(mi.UInt32, self._other, place))
        position, direction = self._scatter(number, stream)
        if self.emission.axis is not None:
            position, direction = self._turn(position, direction, dr.two_pi * stream.next_float32())
        position, direction = self._place(position, direction)
        colour = None
        if self._wavelength is not None:
            colour = dr.gather(mi.Float, self._wavelength, number)
        weight = self._weight.of_set(mi.UInt32(0), True)
        return mi.Point3f(position), direction, weight(direction), colour

    def _scatter(self, number, stream):
        noise = []
        for _ in range(3):
            pair = mi.warp.square_to_std_normal(
                mi.Point2f(stream.next_float32(), stream.next_float32())
            )
            noise += [pair.x, pair.y]
        row = number // GROUP * len(LOWER)
        moved = [mi.Float(0.0) for _ in range(6)]
        for k, (i, j) in enumerate(LOWER):
            moved[i] = dr.fma(dr.gather(mi.Float, self._factor, row + k), noise[j], moved[i])
        position = dr.gather(mi.Vector3f, self._position, number) + mi.Vector3f(*moved[:3])
        direction = dr.gather(mi.Vector3f, self._direction, number) + mi.Vector3f(*moved[3:])
        length = dr.norm(direction)
        direction = dr.select(length > 1e-12, direction / length, mi.Vector3f(0.0, 0.0, 1.0))
        return position, direction

    def _turn(self, position, direction, angle):
        sine, cosine = dr.sincos(angle)

        def rotate(vector):
            along = self._axis * dr.dot(vector, self._axis)
            return along + cosine * (vector - along) + sine * dr.cross(self._axis, vector)

        return self._axis_centre + rotate(position - self._axis_centre), rotate(direction)

    def _place(self, position, direction):
        """Put rays onto the body."""
        kind = self.emission.body.kind
        if kind == SPHERE:
            return self._place_on_sphere(position, direction)
        if kind == PLANE:
            position -= self._normal * dr.dot(position - self._centre, self._normal)
            position = self._keep(position)
            if self.emission.body.is_one_sided:
                below = dr.minimum(dr.dot(direction, self._normal), 0.0)
                direction -= self._normal * (2.0 * below)
            return position, direction
        if kind != HULL:
            raise ValueError(f"a body of rays is of no known kind: {kind}")
        position = self._keep(position)
        return position + direction * dr.maximum(self._leave(position, direction), 0.0), direction

    def _place_on_sphere(self, position, direction):
        away = position - self._centre
        b = dr.dot(away, direction)
        inside = b * b - dr.squared_norm(away) + dr.square(self._radius)
        away += direction * (dr.safe_sqrt(inside) - b)
        return self._centre + away * (self._radius / dr.maximum(dr.norm(away), 1e-30)), direction

    def _slab(self, k):
        values = [dr.gather(mi.Float, self._slabs, k * 5 + i) for i in range(5)]
        return mi.Vector3f(*values[:3]), values[3], values[4]

    def _keep(self, position):
        """Bring points that lie outside back inside, mirrored at the side that they have left."""

        def step(position, k):
            normal, low, high = self._slab(k)
            height = dr.dot(position, normal)
            inside = dr.maximum(dr.select(height > high, 2.0 * high - height, height), low)
            inside = dr.select(height < low, dr.minimum(2.0 * low - height, high), inside)
            return position + normal * (inside - height), k + 1

        position, _ = dr.while_loop(
            state=(mi.Vector3f(position), mi.UInt32(0)),
            cond=lambda position, k: k < self._slab_count,
            body=step,
            labels=("position", "slab"),
        )
        return position

    def _leave(self, position, direction):
        """Way to where a line leaves the hull. [m]"""

        def step(way, k):
            normal, low, high = self._slab(k)
            height, rate = dr.dot(position, normal), dr.dot(direction, normal)
            rest = dr.select(rate > 0.0, high - height, low - height)
            return dr.select(dr.abs(rate) > 1e-9, dr.minimum(way, rest / rate), way), k + 1

        way, _ = dr.while_loop(
            state=(mi.Float(1e30), mi.UInt32(0)),
            cond=lambda way, k: k < self._slab_count,
            body=step,
            labels=("way", "slab"),
        )
        return dr.select(way < 1e29, way, 0.0)


def _vector(values):
    return mi.Vector3f(*(dr.opaque(mi.Float, float(v)) for v in values))
