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

    Attributes
    ----------
    is_possible : bool    Whether it is known of this camera where it sees a place.
    """

    def __init__(self, film):
        self._film = film
        # Lenses of panoramas face every direction, so the way back through one of their points has no closed form.
        self.is_possible = film.panorama is None or (
            film.aperture is None and film.panorama.is_invertible
        )

    def link(self, point, stream) -> CameraLink:
        """Join places with a camera, of one with a lens with a point of that. ``stream``: numbers for it."""
        if self._film.panorama is not None:
            return self._link_round(point)
        if self._film.camera.projection is Projection.ORTHOGRAPHIC:
            return self._link_parallel(point, stream)
        return self._link_central(point, stream)

    # ---- private ----

    def _local(self, vector):
        """In the camera's axes."""
        x, y, z = (dr.dot(vector, axis) for axis in self._film.axes)
        return mi.Vector3f(x, y, z)

    def _on_film(self, px, py):
        film = self._film
        u, v = (px - film.shift.x) / film.extent.x, (py - film.shift.y) / film.extent.y
        return (u + 0.5) * film.size.x, (v + 0.5) * film.size.y

    def _pixels_per_area(self):
        """Of the film in its own measure: of the plane at the distance 1, of the orthographic view. [pixel/m2]"""
        film = self._film
        return film.size.x * film.size.y / dr.abs(film.extent.x * film.extent.y)

    def _within(self, distance):
        """Whether a distance is within the clipping."""
        return (distance > self._film.clip) & (distance < self._film.end)

    def _on_lens(self, stream):
        """Point of the lens, and where that is to the camera's place."""
        film = self._film
        at = film.aperture.sample(mi.Point2f(stream.next_float32(), stream.next_float32()))
        return at, film.to_world(at.x, at.y, 0.0)

    def _link_central(self, point, stream) -> CameraLink:
        film = self._film
        start = mi.Point3f(film.position)
        if film.aperture is not None:
            on_lens, shift = self._on_lens(stream)
            start = start + shift
        away = mi.Vector3f(point - start)
        at = self._local(away)
        depth = -at.z
        seen = self._within(depth) & (depth > 0.0)
        depth = dr.select(seen, depth, 1.0)
        # Where the ray meets the plane in focus, over its distance; the lens's middle sees that at the same place.
        x, y = at.x / depth, at.y / depth
        if film.aperture is not None:
            x, y = x + on_lens.x / film.focus, y + on_lens.y / film.focus
        distance = dr.maximum(dr.norm(away), 1e-30)
        direction = away / distance
        cosine = dr.maximum(depth / distance, 1e-12)
        density = self._pixels_per_area() / (cosine * dr.square(cosine) * dr.square(distance))
        begin = start + direction * (film.clip / cosine)
        return CameraLink(begin, -direction, density, [self._on_film(x, y)], seen)

    def _link_parallel(self, point, stream) -> CameraLink:
        film = self._film
        at = self._local(mi.Vector3f(point - film.position))
        depth, seen = -at.z, self._within(-at.z)
        density = dr.zeros(mi.Float, dr.width(point)) + self._pixels_per_area()
        direction, x, y, cosine = film.forward(), at.x, at.y, 1.0
        if film.aperture is not None:
            # Rays by one point of the lens are parallel, and are seen where they meet the plane in focus.
            on_lens, shift = self._on_lens(stream)
            direction = dr.normalize(direction * film.focus - shift)
            cosine = dr.dot(direction, film.forward())
            x = x - on_lens.x * (1.0 - depth / film.focus)
            y = y - on_lens.y * (1.0 - depth / film.focus)
            density = density / cosine
        begin = point - direction * ((depth - film.clip) / cosine)
        return CameraLink(begin, -direction, density, [self._on_film(x, y)], seen)

    def _link_round(self, point) -> CameraLink:
        film = self._film
        away = mi.Vector3f(point - film.position)
        distance = dr.maximum(dr.norm(away), 1e-30)
        direction = away / distance
        places, density, seen = film.panorama.places(self._local(direction))
        density = density * self._pixels_per_area() / dr.square(distance)
        return CameraLink(
            film.position + direction * film.clip,
            -direction,
            density,
            [self._on_film(*place) for place in places],
            seen & self._within(distance),
        )
