"""The opening of a lens: a disk or a regular polygon, perhaps narrower than it is high."""

import drjit as dr
import mitsuba as mi

from ...scene.camera import Camera


class Aperture:
    """Draws points of an opening, even over its area.

    Parameters
    ----------
    camera : Camera    With a lens.
    """

    def __init__(self, camera: Camera):
        self._is_round = camera.aperture_blades < 3
        self._blades = mi.Float(float(max(camera.aperture_blades, 3)))
        self._rotation = mi.Float(float(camera.aperture_rotation))
        self._size = mi.Vector2f(
            camera.aperture_radius / max(camera.aperture_ratio, 1e-6), camera.aperture_radius
        )
        dr.make_opaque(self._blades, self._rotation, self._size)

    def sample(self, sample):
        """Point of the opening that belongs to a point of the unit square. (Point2f) [m]"""
        if self._is_round:
            return mi.warp.square_to_uniform_disk_concentric(sample) * self._size
        # One of the triangles from the middle to a side, and a point even over it.
        side = dr.minimum(dr.floor(sample.x * self._blades), self._blades - 1.0)
        root = dr.sqrt(dr.clip(sample.x * self._blades - side, 0.0, 1.0))
        first, second = 1.0 - root, sample.y * root
        half = dr.pi / self._blades
        x, y = (first + second) * dr.cos(half), (first - second) * dr.sin(half)
        sin, cos = dr.sincos(self._rotation + 2.0 * half * side)
        return mi.Point2f(cos * x - sin * y, sin * x + cos * y) * self._size
