"""Projections that look around from one point: from places on the film to directions, and back."""

import math

import drjit as dr
import mitsuba as mi

from ...scene.camera import Camera, Projection


class Panorama:
    """A projection in the camera's own axes; places are in the measure of `Camera.extent_x`.

    Parameters
    ----------
    camera : Camera    Of a panoramic projection.

    Attributes
    ----------
    is_invertible : bool    Whether `places` is known for all of the film.
    """

    def __init__(self, camera: Camera):
        self._projection = camera.projection
        field = camera.field
        limit = {
            Projection.EQUIDISTANT: 0.5 * field,
            Projection.EQUISOLID: 2.0 * math.sin(0.25 * field),
            Projection.MIRROR_BALL: 1.0,
        }.get(camera.projection, 0.5 * field)
        self._limit = mi.Float(float(limit))
        self._powers = [mi.Float(float(each)) for each in camera.polynomial]
        dr.make_opaque(self._limit, self._powers)
        self.is_invertible = _is_invertible(camera)

    def direction(self, x, y):
        """Direction in which a place on the film looks, and whether there is any. (Vector3f, Bool)"""
        match self._projection:
            case Projection.EQUIRECTANGULAR:
                flat, seen = dr.cos(y), mi.Bool(True)
                made = mi.Vector3f(dr.sin(x) * flat, dr.sin(y), -dr.cos(x) * flat)
            case Projection.CENTRAL_CYLINDRICAL:
                made, seen = dr.normalize(mi.Vector3f(dr.sin(x), y, -dr.cos(x))), mi.Bool(True)
            case Projection.CUBE_FACE:
                made, seen = dr.normalize(mi.Vector3f(dr.tan(x), dr.tan(y), -1.0)), mi.Bool(True)
            case _:
                radius = dr.sqrt(dr.square(x) + dr.square(y))
                angle, seen = self._angle(radius)
                sin, cos = dr.sincos(angle)
                share = dr.select(radius > 0.0, sin / radius, 0.0)
                made = mi.Vector3f(share * x, share * y, -cos)
        return dr.select(seen, made, mi.Vector3f(0.0, 0.0, -1.0)), seen

    def places(self, direction):
        """Places on the film that look in a direction, as far as they may lie on it, and what area of film they have.

        Parameters
        ----------
        direction : Vector3f    Of the length 1.

        Returns
        -------
        (list of (Float, Float), Float, Bool)
            Places, film over solid angle [measure of the extents over sr], and whether the projection sees it.
        """
        x, y, depth = direction.x, direction.y, -direction.z
        match self._projection:
            case Projection.EQUIRECTANGULAR | Projection.CENTRAL_CYLINDRICAL:
                return *self._places_round(direction), mi.Bool(True)
            case Projection.CUBE_FACE:
                seen = depth > 0.0
                depth = dr.select(seen, depth, 1.0)
                x, y = x / depth, y / depth
                density = (1.0 + dr.square(x)) * (1.0 + dr.square(y))
                density = 1.0 / (depth * dr.square(depth) * density)
                return [(dr.atan(x), dr.atan(y))], density, seen
        flat = dr.sqrt(dr.square(x) + dr.square(y))
        angle = dr.atan2(flat, depth)
        if self._projection is Projection.EQUIDISTANT:
            radius = angle
            density = dr.select(flat > 1e-9, angle / dr.maximum(flat, 1e-9), 1.0)
        else:
            # Equal areas of the film are equal solid angles.
            unit = 1.0 if self._projection is Projection.MIRROR_BALL else 2.0
            radius, density = unit * dr.sin(0.5 * angle), mi.Float(0.25 * unit**2)
        share = dr.select(flat > 0.0, radius / flat, 0.0)
        return [(share * x, share * y)], density, radius <= self._limit

    def lens_axes(self, direction):
        """Axes across a direction, in which an aperture that looks there lies. (Vector3f, Vector3f)"""
        is_ball = self._projection is Projection.MIRROR_BALL
        axis = mi.Vector3f(1.0, 0.0, 0.0) if is_ball else mi.Vector3f(0.0, 0.0, -1.0)
        other = mi.Vector3f(0.0, 1.0, 0.0)
        across = axis - direction * dr.dot(axis, direction)
        # Along the axis itself there is no such direction, and any will do.
        across = dr.select(dr.norm(across) > 1e-6, across, other - direction * direction.y)
        first = dr.normalize(across)
        second = dr.cross(direction, first)
        return first, -second if is_ball else second

    # ---- private ----

    def _angle(self, radius):
        """Angle to the view axis, and whether there is one."""
        match self._projection:
            case Projection.EQUIDISTANT:
                return radius, radius <= self._limit
            case Projection.POLYNOMIAL:
                angle = mi.Float(0.0)
                for power in reversed(self._powers):
                    angle = angle * radius - power
                return angle, dr.abs(angle) <= self._limit
        unit = 1.0 if self._projection is Projection.MIRROR_BALL else 2.0
        return 2.0 * dr.asin(dr.minimum(radius / unit, 1.0)), radius <= self._limit

    def _places_round(self, direction):
        """Of projections with longitudes."""
        flat = dr.sqrt(dr.square(direction.x) + dr.square(direction.z))
        flat = dr.maximum(flat, 1e-9)
        longitude = dr.atan2(direction.x, -direction.z)
        # The film may reach around more than once, and the filter over its ends and poles.
        if self._projection is Projection.EQUIRECTANGULAR:
            latitude, beyond = dr.atan2(direction.y, flat), longitude + dr.pi
            density = 1.0 / flat
            ways = (longitude, latitude), (beyond, dr.pi - latitude), (beyond, -dr.pi - latitude)
        else:
            density = 1.0 / (flat * dr.square(flat))
            ways = ((longitude, direction.y / flat),)
        turns = range(-2, 2)
        return [(lon + turn * dr.two_pi, y) for lon, y in ways for turn in turns], density


def _is_invertible(camera: Camera) -> bool:
    """Whether every place on the film is among those that are known of its direction."""
    across, along = 0.5 * abs(camera.extent_x), 0.5 * abs(camera.extent_y)
    left, right = camera.shift_x - across, camera.shift_x + across
    low, high = camera.shift_y - along, camera.shift_y + along
    match camera.projection:
        case Projection.POLYNOMIAL:
            return False
        case Projection.EQUIDISTANT:
            return camera.field <= 2.0 * math.pi
        case Projection.CUBE_FACE:
            return max(-left, right, -low, high) < 0.5 * math.pi
        case Projection.EQUIRECTANGULAR:
            is_within = max(-low, high) <= 1.5 * math.pi
            return is_within and -4.0 * math.pi <= left and right <= 3.0 * math.pi
        case Projection.CENTRAL_CYLINDRICAL:
            return -5.0 * math.pi <= left and right <= 3.0 * math.pi
    return True
