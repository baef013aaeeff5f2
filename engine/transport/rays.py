"""Rays that leave a surface without meeting it again.

Rays start a little off the surface, on the side that they go to. The distance follows the rounding errors: those of
positions in single precision are in proportion to the largest coordinate of the object, and eight units
in the last place were enough for two thousand million rays from large triangles at all slopes. A step of fixed length would
put sensors near lamps, or scenes in millimetres, in a wrong place.

References
----------
C. Waechter, N. Binder: A Fast and Robust Method for Avoiding Self-Intersection, Ray Tracing Gems (2019), ch. 6.
"""

import drjit as dr
import mitsuba as mi

STEP = 8.0 * 2.0**-24
"""Step off a surface, relative to the largest coordinate of the object that it belongs to, in the scene's frame. [-]"""


def start_of(scene, si, direction):
    """Return the point where a ray from a surface begins."""
    side = dr.select(dr.dot(si.n, direction) < 0.0, -1.0, 1.0)
    # Hits of spheres and disks are only as exact as the way to them is long.
    far = dr.select(dr.isfinite(si.t), si.t, 0.0)
    extent = dr.maximum(dr.maximum(dr.max(dr.abs(si.p)), far), scene.extent_at(si))
    return si.p + si.n * (side * extent * STEP)


def spawn_ray(scene, si, direction):
    """Ray from a surface in a direction."""
    return mi.Ray3f(start_of(scene, si, direction), direction, si.time, si.wavelengths)


def spawn_straight(scene, si, ray):
    """Ray that goes on straight from a surface that it has met, as far as it was to go."""
    made = spawn_ray(scene, si, ray.d)
    made.maxt = dr.maximum(ray.maxt - si.t, 0.0)
    return made


def spawn_ray_to(scene, si, target, normal):
    """Ray from a surface to just before a point.

    Parameters
    ----------
    si : SurfaceInteraction3f
    target : Point3f    [m]
    normal : Normal3f    Of the surface that the point lies on; 0 where it is on none.
    """
    away = target - si.p
    start = start_of(scene, si, away)
    side = dr.select(dr.dot(normal, away) < 0.0, 1.0, -1.0)
    # What it belongs to is not known, so the whole scene's extent counts.
    extent = dr.maximum(dr.max(dr.abs(target)), scene.extent)
    end = target + normal * (side * extent * STEP)
    away = end - start
    distance = dr.norm(away)
    ray = mi.Ray3f(start, away / distance, si.time, si.wavelengths)
    ray.maxt = distance * (1.0 - 1e-6)
    return ray
