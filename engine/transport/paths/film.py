"""The camera on the device: rays of pixels, what they see, and the lights compared where they look."""

import math

import drjit as dr
import mitsuba as mi
import numpy as np

from ...scene.camera import Camera, Projection
from ..compiled.compile import CompiledScene
from . import gather
from .aperture import Aperture
from .light_learning import PILOT_LANES, PILOT_POINTS, learn
from .panorama import Panorama
from .pixel_filter import filter_offset
from .sampler import sobol_pair

GROUPS = 2
"""Even and odd half of a picture."""

MAXIMUM_PIXELS = 1 << 28
"""Largest picture."""


SHORTEST = 1e-30
"""Least length of rays that see at all; those with none see nothing, not even the surroundings. [m]"""


class Film:
    """Camera as numbers on the device: makes rays from film positions.

    Attributes
    ----------
    aperture : Aperture or None    None: a pinhole.
    panorama : Panorama or None    None: perspective or orthographic.
    """

    def __init__(self, camera: Camera, origin):
        self.camera = camera
        frame = np.asarray(camera.frame, dtype=np.float64)
        position = frame[:3, 3] - origin
        self.axes = [
            mi.Vector3f(*map(float, frame[:3, i] / np.linalg.norm(frame[:3, i]))) for i in range(3)
        ]
        self.position = mi.Point3f(*map(float, position))
        self.aperture = Aperture(camera) if camera.aperture_radius > 0.0 else None
        self.panorama = Panorama(camera) if camera.projection.is_panoramic else None
        self.focus = mi.Float(max(camera.focus_distance, 1e-6))
        end = math.inf if camera.clip_end is None else camera.clip_end
        self.clip, self.end = mi.Float(camera.clip_start), mi.Float(float(end))
        self.length = mi.Float(float(end) - camera.clip_start)
        self.size = mi.Vector2f(camera.width, camera.height)
        self.width = mi.UInt32(camera.width)
        self.extent = mi.Vector2f(float(camera.extent_x), float(camera.extent_y))
        self.shift = mi.Vector2f(float(camera.shift_x), float(camera.shift_y))
        area = camera.extent_x * camera.extent_y / (camera.width * camera.height)
        self.pixel = mi.Float(math.sqrt(abs(area)))
        # As data, so that another view or size meets the same compiled kernel.
        dr.make_opaque(self.axes, self.position, self.focus, self.size, self.width)
        dr.make_opaque(self.clip, self.end, self.length, self.extent, self.shift, self.pixel)

    def to_world(self, x, y, z):
        """Direction that has these components along the camera's axes."""
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
        """Ray through a film position (pixels from the lower left corner).

        It ends where the clipping does, and has no length where nothing is projected to, see `sees`.
        """
        px = (x / self.size.x - 0.5) * self.extent.x + self.shift.x
        py = (y / self.size.y - 0.5) * self.extent.y + self.shift.y
        if self.panorama is not None:
            return self._ray_around(px, py, lens_sample)
        start, shift = self.position, None
        if self.aperture is not None:
            on_lens = self.aperture.sample(lens_sample)
            shift = self.to_world(on_lens.x, on_lens.y, 0.0)
            start = start + shift
        if self.camera.projection is Projection.ORTHOGRAPHIC:
            start = start + self.to_world(px, py, 0.0)
            if shift is None:
                return self._clipped(start, self.forward(), 1.0)
            direction = self.forward() * self.focus - shift
        else:
            direction = self.to_world(px, py, -1.0)
            if shift is not None:
                direction = direction * self.focus - shift
        direction = dr.normalize(direction)
        return self._clipped(start, direction, dr.dot(direction, self.forward()))

    def pixel_width(self, place):
        """Width of a pixel where it shows a place, across the line of sight. [m]"""
        width = self.pixel
        if self.camera.projection is Projection.ORTHOGRAPHIC:
            return mi.Float(width)
        away = place - self.position
        if self.panorama is None:
            return width * dr.abs(dr.dot(away, self.forward()))
        return width * dr.norm(away)

    # ---- private ----

    def _ray_around(self, px, py, lens_sample):
        """Ray of a panorama, whose lens faces every direction."""
        local, seen = self.panorama.direction(px, py)
        start, direction = self.position, self.to_world(local.x, local.y, local.z)
        if self.aperture is not None:
            on_lens = self.aperture.sample(lens_sample)
            first, second = self.panorama.lens_axes(local)
            shift = first * on_lens.x + second * on_lens.y
            shift = self.to_world(shift.x, shift.y, shift.z)
            start, direction = start + shift, dr.normalize(direction * self.focus - shift)
        ray = self._clipped(start, direction, 1.0)
        ray.maxt = dr.select(seen, ray.maxt, 0.0)
        return ray

    def _clipped(self, start, direction, along):
        """Ray between start and end of the clipping. ``along``: cosine to the axis that these are measured along."""
        ray = mi.Ray3f(start + direction * (self.clip / along), direction)
        if self.camera.clip_end is not None:
            ray.maxt = dr.maximum(self.length / along, SHORTEST)
        return ray


def sees(ray):
    """Whether a ray of the camera sees anything; what it does not is black and transparent."""
    return ray.maxt > 0.0


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
    si = scene.solid.ray_intersect(ray, sees(ray))
    normal = si.n * dr.select(dr.dot(si.n, ray.d) < 0.0, 1.0, -1.0)
    seen = np.array(si.is_valid())
    points = np.stack([np.array(c) for c in si.p], axis=1)[seen]
    normals = np.stack([np.array(c) for c in normal], axis=1)[seen]
    return points, normals
