"""Light that reaches a point by way of plane mirrors: next-event through virtual images.

A chain of mirrors is drawn, the point is reflected at each of them in turn, and an emitter is chosen and sampled as that
image sees it; the path is then traced from the point over the mirrors, which must be met in this order. So even ideal points
and suns shine by mirrors, which no scattered ray would find. The chance of a chain depends on its length alone, so hits of
scattered rays that came over mirrors can be weighed against it (see `paths`): their reference point is the same image.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ..arrays import table_size, upload
from .rays import STEP, spawn_ray

MAXIMUM_MIRRORS = 64
"""Most planes; beyond, the smallest are found by scattered rays only."""

LONGEST_CHAIN = 24
"""Most reflections of a chain; longer ones are left to scattered rays."""

GOES_ON = 0.5
"""Chance that a chain gets one mirror more."""

FLATNESS = 1e-5
"""Largest distance from its plane, relative to its size, of what counts as a plane mirror. [-]"""

NEARNESS = 64.0
"""Largest distance of a hit from the chain's plane, in steps by which rays start off surfaces."""


ALIGNMENT = 0.99999
"""Smallest cosine between the normals of a hit and of the chain's plane. [-]"""


@dataclass(frozen=True)
class Plane:
    """Plane of a mirror in the world: unit normal (3,), distance from the origin along it [m], mirror's area in it [m2]."""

    normal: np.ndarray
    distance: float
    area: float

    def order(self) -> tuple:
        """Key that puts planes in an order of their own: the largest first."""
        return (-self.area, *self.normal, self.distance)


def find_planes(vertices, triangles) -> list[Plane] | None:
    """Planes of triangles, None when there are more than `MAXIMUM_MIRRORS` (a curved mirror). (v, 3) [m], (t, 3)"""
    corners = vertices[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.linalg.norm(cross, axis=1)
    kept = double > 0.0
    corners, cross, double = corners[kept], cross[kept], double[kept]
    normals = cross / double[:, None]
    size = float(np.ptp(vertices, axis=0).max(initial=0.0))
    found: list[Plane] = []
    left = np.arange(len(corners))
    while len(left):
        if len(found) == MAXIMUM_MIRRORS:
            return None
        normal, point = normals[left[0]], corners[left[0], 0]
        off = np.abs((corners[left] - point) @ normal).max(axis=1)
        same = off <= FLATNESS * size
        area = 0.5 * float(double[left[same]].sum())
        # One sign for both sides of a plane.
        sign = 1.0 if tuple(normal) >= tuple(-normal) else -1.0
        found.append(Plane(sign * normal, sign * float(normal @ point), area))
        left = left[~same]
    return found


def choose_planes(planes: list[Plane], radius: float) -> tuple[list[Plane], set[int]]:
    """Planes that chains are drawn from: the largest, and only one of those that a hit could not tell apart.

    Parameters
    ----------
    planes : list of Plane
    radius : float    Of the scene. [m]

    Returns
    -------
    (list of Plane, set of int)    With the `id` of every given plane that one of them stands for.
    """
    near = 2.0 * NEARNESS * STEP * max(radius, 1e-30)
    chosen: list[Plane] = []
    known: set[int] = set()
    for plane in sorted(planes, key=Plane.order):
        for other in chosen:
            cosine = float(plane.normal @ other.normal)
            if abs(cosine) > ALIGNMENT and abs(plane.distance * cosine - other.distance) <= near:
                known.add(id(plane))
                break
        else:
            if len(chosen) < MAXIMUM_MIRRORS:
                chosen.append(plane)
                known.add(id(plane))
    return chosen, known


class MirrorSet:
    """Plane mirrors on the device.

    Parameters
    ----------
    planes : list of Plane    At least one.
    origin : (3,) array    Of the compiled scene's frame. [m]
    """

    def __init__(self, planes: list[Plane], origin: np.ndarray):
        rows = np.zeros((table_size(len(planes)), 4))
        for row, plane in zip(rows, planes, strict=False):
            row[:3], row[3] = plane.normal, plane.distance - float(plane.normal @ origin)
        self._rows = upload(mi.Float, rows)
        self._count = dr.opaque(mi.UInt32, len(planes))
        dr.eval(self._rows)

    def plane(self, index, active):
        """Unit normal and distance of a plane in the scene's frame."""
        x, y, z, w = (dr.gather(mi.Float, self._rows, index * 4 + k, active) for k in range(4))
        return mi.Vector3f(x, y, z), w

    def probability(self, length):
        """Chance of one chain of a length: of the length, and of its mirrors, no two alike in sequence."""
        count = mi.Float(self._count)
        others = dr.maximum(count - 1.0, 1.0)
        extent = mi.Float(length)
        share = (1.0 - GOES_ON) * dr.power(GOES_ON / others, extent - 1.0) / count
        # All that would be longer is cut to the longest.
        share = dr.select(length == LONGEST_CHAIN, share / (1.0 - GOES_ON), share)
        is_drawn = (length >= 1) & (length <= LONGEST_CHAIN)
        # With a single mirror all chains have one reflection.
        share = dr.select(self._count == 1, dr.select(length == 1, 1.0, 0.0), share)
        return dr.select(is_drawn, share, 0.0)

    def length(self, u):
        """Number of reflections of a chain, from a number in [0, 1)."""
        drawn = 1.0 + dr.floor(dr.log(dr.maximum(1.0 - u, 1e-9)) / float(np.log(GOES_ON)))
        drawn = dr.minimum(mi.UInt32(drawn), LONGEST_CHAIN)
        return dr.select(self._count == 1, 1, drawn)

    def next(self, u, last, is_first):
        """Index of a chain's next mirror, another than the last."""
        others = dr.select(is_first, self._count, dr.maximum(self._count, 2) - 1)
        drawn = dr.minimum(mi.UInt32(u * mi.Float(others)), others - 1)
        return dr.select(~is_first & (drawn >= last), drawn + 1, drawn)

    def image(self, point, stream, length, active):
        """Reflect a point over a chain.

        Returns
        -------
        (Point3f, Matrix3f)    The image and the linear part of the reflections.
        """
        state = (mi.Point3f(point), mi.Matrix3f(1.0), mi.PCG32(stream), mi.UInt32(0), mi.UInt32(0))

        def body(image, turn, numbers, last, step):
            index = self.next(numbers.next_float32(), last, step == 0)
            normal, distance = self.plane(index, active)
            image = mi.Point3f(image - 2.0 * (dr.dot(normal, image) - distance) * normal)
            turn = turn - 2.0 * _outer(normal, turn.T @ normal)
            return image, turn, numbers, index, step + 1

        image, turn, *_ = dr.while_loop(
            state=state,
            cond=lambda image, turn, numbers, last, step: active & (step < length),
            body=body,
            labels=("image", "turn", "numbers", "last", "step"),
        )
        return image, turn


def _outer(a, b):
    return mi.Matrix3f(
        a.x * b.x, a.x * b.y, a.x * b.z,
        a.y * b.x, a.y * b.y, a.y * b.z,
        a.z * b.x, a.z * b.y, a.z * b.z,
    )  # fmt: skip


def walk(scene, si, direction, stream, length, closest_hit, active):
    """Follow a chain from a surface.

    Parameters
    ----------
    direction : Vector3f    From the surface, to where the chain begins.
    stream, length : PCG32, UInt32    The numbers that the chain was drawn with.
    closest_hit : callable    As in `paths`.

    Returns
    -------
    (SurfaceInteraction3f, Spectrum, Bool)    The last mirror's surface, the chain's reflectance, and whether it was met.
    """
    context = mi.BSDFContext()
    mirrors = scene.mirrors
    ray = spawn_ray(scene, si, direction)
    state = {
        "ray": ray,
        "at": mi.SurfaceInteraction3f(si),
        "value": mi.Spectrum(1.0),
        "numbers": mi.PCG32(stream),
        "last": mi.UInt32(0),
        "step": mi.UInt32(0),
        "passes": mi.UInt32(0),
        "going": mi.Bool(active),
    }

    def body(ray, at, value, numbers, last, step, passes, going):
        hit = closest_hit(scene, ray, going)
        hit.wavelengths = ray.wavelengths
        going &= hit.is_valid()
        bsdf = scene.bsdf(hit, going)
        ids = dr.reinterpret_array(mi.UInt32, hit.shape)
        is_mirror = dr.gather(mi.Bool, scene.is_mirror, ids, going) & going
        drawn = mi.PCG32(numbers)
        index = mirrors.next(drawn.next_float32(), last, step == 0)
        normal, distance = mirrors.plane(index, is_mirror)
        off = dr.abs(dr.dot(normal, hit.p) - distance)
        is_meant = is_mirror & (off <= NEARNESS * STEP * scene.extent)
        is_meant &= dr.abs(dr.dot(normal, hit.n)) > ALIGNMENT
        bs, weight = bsdf.sample(context, hit, 0.5, mi.Point2f(0.5), is_meant)
        through = bsdf.eval_null_transmission(hit, going & ~is_mirror)
        value = value * dr.select(is_mirror, weight, through)
        onwards = dr.select(is_mirror, hit.to_world(bs.wo), ray.d)
        going &= (is_meant | ~is_mirror) & dr.any(value != 0.0)
        step = dr.select(is_meant, step + 1, step)
        last = dr.select(is_meant, index, last)
        numbers = dr.select(is_meant, drawn, numbers)
        at = dr.select(is_mirror, hit, at)
        following = spawn_ray(scene, hit, onwards)
        following.wavelengths = ray.wavelengths
        passes += 1
        return following, at, value, numbers, last, step, passes, going & (passes < 1000)

    result = dr.while_loop(
        state=tuple(state.values()),
        cond=lambda ray, at, value, numbers, last, step, passes, going: going & (step < length),
        body=body,
        labels=tuple(state),
    )
    at, value, step, going = result[1], result[2], result[5], result[7]
    return at, value, going & (step == length)
