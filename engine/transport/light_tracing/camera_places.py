"""Where a camera sees a place, and how much of it: the way back of `film.Film.ray`."""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ...scene.camera import Projection


@dataclass(frozen=True)
class CameraLink:
    """A place and the camera.

    Parameters
    ----------
    start : Point3f    Where the camera's ray begins. [m]
    direction : Vector3f    From the place towards it.
    density : Float    Area of the film over that of a surface at the place that faces the camera. [pixel/m2]
    places : list of (Float, Float)    Where on the film the place is seen; only those count that lie on it. [pixel]
    seen : Bool    Whether it may be seen, but for what stands between.
    """

    start: object
    direction: object
    density: object
    places: list
    seen: object


class CameraPlaces:
    """Joins places with a camera.

    Parameters
    ----------
    film : Film
    """

    def __init__(self, film):
        self._film = film

    def link(self, point, stream) -> CameraLink:
        """Join places with a camera, of one with a lens with a point of that. ``stream``: numbers for it."""
        projection = self._film.camera.projection
        if projection is Projection.EQUIRECTANGULAR:
            return self._link_round(point)
        if projection is Projection.ORTHOGRAPHIC:
            return self._link_parallel(point)
        return self._link_central(point, stream)

    # ---- private ----

    def _local(self, vector):
        """In the camera's axes."""
        x, y, z = (dr.dot(vector, axis) for axis in self._film.axes)
        return mi.Vector3f(x, y, z)

    def _on_film(self, px, py):
        film = self._film
        u, v = (px - film.shift.x) / film.extent.x, (py - film.shift.y) / film.extent.y
        return [((u + 0.5) * film.size.x, (v + 0.5) * film.size.y)]

    def _pixels_per_area(self):
        """Of the plane at the distance 1, or of the orthographic view. [pixel/m2]"""
        film = self._film
        return film.size.x * film.size.y / (film.extent.x * film.extent.y)

    def _link_central(self, point, stream) -> CameraLink:
        film = self._film
        start, px, py = mi.Point3f(film.position), mi.Float(0.0), mi.Float(0.0)
        if film.camera.aperture_radius > 0.0:
            sample = mi.Point2f(stream.next_float32(), stream.next_float32())
            on_lens = mi.warp.square_to_uniform_disk_concentric(sample) * film.lens
            px, py = on_lens.x, on_lens.y
            start = start + film.axes[0] * px + film.axes[1] * py
        away = mi.Vector3f(point - start)
        at = self._local(away)
        depth = -at.z
        seen = depth > film.clip
        depth = dr.select(seen, depth, 1.0)
        # Where the ray meets the plane in focus, over its distance; the lens's middle sees that at the same place.
        x, y = at.x / depth, at.y / depth
        if film.camera.aperture_radius > 0.0:
            x, y = x + px / film.focus, y + py / film.focus
        distance = dr.maximum(dr.norm(away), 1e-30)
        direction = away / distance
        cosine = dr.maximum(depth / distance, 1e-12)
        density = self._pixels_per_area() / (cosine * dr.square(cosine) * dr.square(distance))
        begin = start + direction * (film.clip / cosine)
        return CameraLink(begin, -direction, density, self._on_film(x, y), seen)

    def _link_parallel(self, point) -> CameraLink:
        film = self._film
        at = self._local(mi.Vector3f(point - film.position))
        forward = film.forward()
        begin = point - forward * (-at.z - film.clip)
        seen = -at.z > film.clip
        density = dr.zeros(mi.Float, dr.width(point)) + self._pixels_per_area()
        return CameraLink(begin, -forward, density, self._on_film(at.x, at.y), seen)

    def _link_round(self, point) -> CameraLink:
        film = self._film
        away = mi.Vector3f(point - film.position)
        distance = dr.maximum(dr.norm(away), 1e-30)
        direction = away / distance
        at = self._local(direction)
        flat = dr.maximum(dr.sqrt(dr.square(at.x) + dr.square(at.z)), 1e-9)
        longitude, latitude = dr.atan2(at.x, -at.z), dr.atan2(at.y, flat)
        width, height = film.high.x - film.low.x, film.high.y - film.low.y
        density = film.size.x * film.size.y / dr.abs(width * height * flat) / dr.square(distance)
        places = []
        # The film may reach around more than once, and the filter over its ends and poles.
        beyond = longitude + dr.pi
        ways = (longitude, latitude), (beyond, dr.pi - latitude), (beyond, -dr.pi - latitude)
        for lon, lat in ways:
            for turn in (-2, -1, 0, 1):
                x = (lon + turn * dr.two_pi - film.low.x) / width * film.size.x
                places.append((x, (lat - film.low.y) / height * film.size.y))
        return CameraLink(mi.Point3f(film.position), -direction, density, places, mi.Bool(True))
