"""The camera on the device: rays of pixels, what they see, and the lights compared where they look."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...scene.camera import Camera, Projection
from ..compiled.compile import CompiledScene
from . import gather
from .light_learning import PILOT_LANES, PILOT_POINTS, learn
from .pixel_filter import filter_offset
from .sampler import sobol_pair

GROUPS = 2
"""Even and odd half of a picture."""

MAXIMUM_PIXELS = 1 << 28
"""Largest picture."""


class Film:
    """Camera as numbers on the device: makes rays from film positions."""

    def __init__(self, camera: Camera, origin):
        self.camera = camera
        frame = np.asarray(camera.frame, dtype=np.float64)
        position = frame[:3, 3] - origin
        self.axes = [
            mi.Vector3f(*map(float, frame[:3, i] / np.linalg.norm(frame[:3, i]))) for i in range(3)
        ]
        self.position = mi.Point3f(*map(float, position))
        self.lens = mi.Float(camera.aperture_radius)
        self.focus = mi.Float(max(camera.focus_distance, 1e-6))
        self.clip = mi.Float(camera.clip_start)
        self.size = mi.Vector2f(camera.width, camera.height)
        self.width = mi.UInt32(camera.width)
        self.extent = mi.Vector2f(float(camera.extent_x), float(camera.extent_y))
        self.shift = mi.Vector2f(float(camera.shift_x), float(camera.shift_y))
        self.low = mi.Vector2f(float(camera.longitude[0]), float(camera.latitude[0]))
        self.high = mi.Vector2f(float(camera.longitude[1]), float(camera.latitude[1]))
        # As data, so that another view or size meets the same compiled kernel.
        dr.make_opaque(self.axes, self.position, self.lens, self.focus, self.clip, self.size)
        dr.make_opaque(self.width, self.extent, self.shift, self.low, self.high)

    def _to_world(self, x, y, z):
        return self.axes[0] * x + self.axes[1] * y + self.axes[2] * z

    def forward(self):
        """Direction of view."""
        return -self.axes[2]

    def ray_of(self, pixel, sample, seed):
        """Ray of a sample of a pixel, somewhere within the pixel filter."""
        offset = filter_offset(sobol_pair(sample, seed, gather.PAIR_FILM))
        x = mi.Float(pixel % self.width) + 0.5 + offset.x
        y = mi.Float(pixel // self.width) + 0.5 + offset.y
        return self.ray(x, y, sobol_pair(sample, seed, gather.PAIR_LENS))

    def ray(self, x, y, lens_sample):
        """Ray through a film position (pixels from the lower left corner)."""
        camera = self.camera
        u = x / self.size.x - 0.5
        v = y / self.size.y - 0.5
        if camera.projection is Projection.EQUIRECTANGULAR:
            longitude = dr.lerp(self.low.x, self.high.x, u + 0.5)
            latitude = dr.lerp(self.low.y, self.high.y, v + 0.5)
            cos_lat = dr.cos(latitude)
            direction = self._to_world(
                dr.sin(longitude) * cos_lat, dr.sin(latitude), -dr.cos(longitude) * cos_lat
            )
            return mi.Ray3f(self.position, direction)
        px = u * self.extent.x + self.shift.x
        py = v * self.extent.y + self.shift.y
        if camera.projection is Projection.ORTHOGRAPHIC:
            start = self.position + self._to_world(px, py, 0.0)
            return mi.Ray3f(start + self.forward() * self.clip, self.forward())
        start = self.position
        direction = self._to_world(px, py, -1.0)
        if camera.aperture_radius > 0.0:
            on_lens = mi.warp.square_to_uniform_disk_concentric(lens_sample) * self.lens
            shift = self._to_world(on_lens.x, on_lens.y, 0.0)
            direction = direction * self.focus - shift
            start = start + shift
        direction = dr.normalize(direction)
        along = dr.dot(direction, self.forward())
        return mi.Ray3f(start + direction * (self.clip / along), direction)


def learn_lights(scene: CompiledScene, film: Film, lanes: int = PILOT_LANES) -> None:
    """Compare the lights where the camera looks."""
    learn(scene, *look(scene, film), gather.typical_wavelengths(), lanes)


def look(scene: CompiledScene, film: Film) -> tuple[np.ndarray, np.ndarray]:
    """Some of the places that the camera sees, in the scene's frame, and normals there. (n, 3) [m], (n, 3)"""
    stream = mi.PCG32(size=4 * PILOT_POINTS, initstate=3)
    ray = film.ray(
        stream.next_float32() * film.size.x,
        stream.next_float32() * film.size.y,
        mi.Point2f(0.5, 0.5),
    )
    si = scene.solid.ray_intersect(ray)
    normal = si.n * dr.select(dr.dot(si.n, ray.d) < 0.0, 1.0, -1.0)
    seen = np.array(si.is_valid())
    points = np.stack([np.array(c) for c in si.p], axis=1)[seen]
    normals = np.stack([np.array(c) for c in normal], axis=1)[seen]
    return points, normals
