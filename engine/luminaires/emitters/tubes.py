"""Sampling of luminous tubes as a receiver sees them.

Along the tube places are drawn evenly by the angle at the receiver, as if the tube were a line at the distance of its
nearest part; around it evenly over the part that the receiver sees.

References
----------
C. Kulla, M. Fajardo: Importance Sampling Techniques for Path Tracing in Participating Media, Computer Graphics Forum 31
(2012), section 4.1 (equiangular sampling, there of a ray about a point light).
"""

import drjit as dr
import mitsuba as mi

NEAREST = 1e-6
"""Smallest distance of a receiver from a tube, relative to its length, by which angles are measured. [-]"""


def sample_tube(tube, point, sample):
    """Draw a direction to a tube.

    Parameters
    ----------
    tube : (Point3f, Vector3f, Float)    One end of its axis, from there to the other, and its radius. [m]
    point : Point3f    The receiver.
    sample : Point2f

    Returns
    -------
    DirectionSample3f    Its density, over solid angle, is 0 where nothing of the outside is seen.
    """
    start, _, radius = tube
    axis, length, along, across, distance, height, angle, half = _look(tube, point)
    first = dr.atan2(-along, height)
    place = along + height * dr.tan(first + sample.x * angle)
    place = dr.clip(place, 0.0, length)
    outwards = dr.select(distance > 0.0, across / dr.maximum(distance, 1e-30), mi.Frame3f(axis).s)
    sine, cosine = dr.sincos((2.0 * sample.y - 1.0) * half)
    ds = dr.zeros(mi.DirectionSample3f)
    ds.n = mi.Normal3f(outwards * cosine + dr.cross(axis, outwards) * sine)
    ds.p = start + axis * place + ds.n * radius
    ds.d = ds.p - point
    ds.dist = dr.norm(ds.d)
    ds.d /= dr.maximum(ds.dist, 1e-20)
    ds.pdf = find_tube_density(tube, point, ds)
    return ds


def find_tube_density(tube, point, ds):
    """Density over solid angle with which `sample_tube` would have drawn a place, given by all of ``ds`` but it. [sr-1]"""
    start, _, radius = tube
    axis, _, along, _, distance, height, angle, half = _look(tube, point)
    aside = dr.dot(ds.p - start, axis) - along
    by_length = height / ((dr.square(height) + dr.square(aside)) * angle)
    facing = -dr.dot(ds.d, ds.n)
    density = by_length * dr.square(ds.dist) / (2.0 * half * radius * dr.maximum(facing, 1e-20))
    return dr.select((distance > radius) & (facing > 0.0), density, 0.0)


def _look(tube, point):
    """Axis, length, the receiver's place along and away from it; its distance; distance, angle and half turn to draw by."""
    start, whole, radius = tube
    length = dr.norm(whole)
    axis = whole / length
    away = point - start
    along = dr.dot(away, axis)
    across = away - axis * along
    distance = dr.norm(across)
    height = dr.maximum(distance - radius, NEAREST * length)
    # Of both ends at once, as the difference of two angles has no digits from afar.
    angle = dr.atan2(height * length, dr.square(height) + along * (along - length))
    half = dr.acos(dr.clip(radius / dr.maximum(distance, 1e-30), 0.0, 1.0))
    return axis, length, along, across, distance, height, angle, dr.maximum(half, 1e-6)
