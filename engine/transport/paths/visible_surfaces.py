"""What a job looks at: rays leave the lumels and wander on from surface to surface.

Of most objects only one side is seen, such as the inner one of the walls of a room. Where nobody looks, cells need no
light, and the outside of a house in the sun must not be taken for a lamp.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ..compiled.diffuse import DiffuseTable
from ..rays import spawn_ray

BOUNCES = 8
"""Surfaces that a ray meets one after the other."""

WEIGHTS = (1.0, 0.5)
"""How much the first and the second surface count for how often something is looked at."""

OWN, LOOKED, EVEN = 0.5, 0.25, 0.25
"""Shares of what matters: as the job's own places lie, as rays from there meet surfaces, and evenly."""

LIFT = 1e-3
"""How far above the job's places a ray begins that looks for what they lie on, in scenes of 1 m and more; in smaller ones a
share of the radius. [m]"""

SPREADING = 2
"""Times that what is seen is taken to reach to the neighbours: what few rays may have missed."""


class Sight:
    """Hits of wandering rays.

    Parameters
    ----------
    scene : CompiledScene
    places : (n, 3) array    Where the rays start, in the compiled scene's frame. [m]
    normals : (n, 3) array
    seed : int
    """

    def __init__(self, scene, places: np.ndarray, normals: np.ndarray, seed: int):
        count = len(places)
        stream = mi.PCG32(size=count, initstate=seed & 0xFFFFFFFF)
        si = dr.zeros(mi.SurfaceInteraction3f, count)
        si.p = mi.Point3f(*(upload(mi.Float, places[:, i]) for i in range(3)))
        si.n = mi.Normal3f(*(upload(mi.Float, normals[:, i]) for i in range(3)))
        si.sh_frame = mi.Frame3f(si.n)
        matt, active = DiffuseTable(scene), mi.Bool(True)
        self._shape_count = scene.shape_count
        self._own = _stand_on(scene, si)
        self._hits = []
        for _ in range(BOUNCES):
            sample = mi.Point2f(stream.next_float32(), stream.next_float32())
            away = si.to_world(mi.warp.square_to_cosine_hemisphere(sample))
            ray = spawn_ray(scene, si, away)
            hit = scene.solid.ray_intersect_preliminary(ray, mi.Bool(False), active)
            active &= hit.is_valid()
            met = scene.surface(hit, ray, active)
            is_back = mi.Frame3f.cos_theta(met.wi) < 0.0
            # What is not matt may let light through.
            passes = (matt.row(met.shape, active) == 0) & (stream.next_float32() < 0.5)
            turn = dr.select((dr.dot(met.n, away) < 0.0) ^ passes, 1.0, -1.0)
            si = dr.zeros(mi.SurfaceInteraction3f, count)
            si.p, si.n, si.t = met.p, met.n * turn, met.t
            si.sh_frame = mi.Frame3f(si.n)
            dr.eval(hit, is_back, active, si, stream)
            self._hits.append((hit, is_back, mi.Bool(active)))

    def met(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Everything that rays met: numbers of shapes, triangles in them, and whether from behind. (m,) each"""
        found = [
            np.stack(
                [
                    np.array(dr.reinterpret_array(mi.UInt32, hit.shape)),
                    np.array(hit.prim_index),
                    np.array(mi.UInt32(is_back)),
                ]
            )[:, np.array(active)]
            for hit, is_back, active in self._hits
        ]
        shape, triangle, back = np.concatenate(found, axis=1)
        return shape, triangle, back > 0

    def shares(self, shapes: list[int]) -> np.ndarray:
        """How often the rays, and those that go on from where they land, meet each of some shapes. (n,) of sum 1"""
        found = np.zeros(self._shape_count)
        for weight, (hit, _, active) in zip(WEIGHTS, self._hits, strict=False):
            met = np.array(dr.reinterpret_array(mi.UInt32, hit.shape))[np.array(active)]
            found += weight * np.bincount(met, minlength=len(found))
        own = found[shapes]
        return own / max(own.sum(), 1e-300)

    def near_share(self, distances: np.ndarray) -> float:
        """Share of the rays that land nearer than at certain distances. ``distances``: by shape [m]. [-]"""
        hit, _, active = self._hits[0]
        shape = dr.reinterpret_array(mi.UInt32, hit.shape)
        limit = dr.gather(mi.Float, upload(mi.Float, distances), shape, active)
        return float(np.array(active & (hit.t < limit)).mean())

    def sides(self, cells) -> tuple[np.ndarray, np.ndarray]:
        """Sides of cells that were met, and their neighbours; and how often every side was looked at.

        Returns
        -------
        (n,) uint32 array, ascending, and (2 c,) array    The latter by `WEIGHTS`.
        """
        looks = np.zeros(2 * cells.count)
        seen = np.zeros(2 * cells.count, dtype=bool)
        for number, landed in enumerate(self._hits):
            met = _sides_of(cells, *landed)
            seen[met] = True
            if number < len(WEIGHTS):
                looks += WEIGHTS[number] * np.bincount(met, minlength=len(looks))
        for _ in range(SPREADING):
            before = seen.copy()
            for face in (0, 1):
                a, b = (2 * each + face for each in cells.neighbours)
                seen[a[before[b]]] = True
                seen[b[before[a]]] = True
        return cells.sides[seen[cells.sides]], looks

    def worth(self, cells, sides: np.ndarray, looks: np.ndarray) -> np.ndarray:
        """How much light matters to the job where it lands, of sum 1 over the area of ``sides``. (2 c,) [m-2]

        The same all over a side of a shape: of single cells, which few rays meet, little is known. ``sides``, ``looks``: as
        `sides` gives them.
        """
        area = np.zeros(2 * cells.count)
        area[sides] = np.repeat(cells.area, 2)[sides]
        own = np.bincount(_sides_of(cells, *self._own), minlength=len(area))
        made = np.zeros(len(area))
        for share, amount in ((OWN, own), (LOOKED, looks), (EVEN, area)):
            counted = np.where(area > 0.0, amount, 0.0)
            made += share * counted / max(counted.sum(), 1e-300)
        group = np.repeat(2 * cells.shapes.astype(np.int64), 2)
        group[1::2] += 1
        sums, areas = np.bincount(group, made), np.bincount(group, area)
        each = np.divide(sums, areas, out=np.zeros(len(areas)), where=areas > 0.0)[group]
        return np.where(area > 0.0, each / max(made.sum(), 1e-300), 0.0)


def _stand_on(scene, si) -> tuple:
    """What places lie on: hit, whether on its back, and where there is something."""
    lift = LIFT * min(scene.radius, 1.0)
    ray = mi.Ray3f(si.p + si.n * lift, -si.n)
    ray.maxt = mi.Float(2.0 * lift)
    hit = scene.solid.ray_intersect_preliminary(ray, mi.Bool(False), mi.Bool(True))
    active = hit.is_valid()
    is_back = mi.Frame3f.cos_theta(scene.surface(hit, ray, active).wi) < 0.0
    dr.eval(hit, is_back, active)
    return hit, is_back, active


def _sides_of(cells, hit, is_back, active) -> np.ndarray:
    """Sides of cells that were hit, where these are matt. (m,)"""
    is_matt = active & (cells.matt.row(hit.shape, active) > 0)
    side = cells.side(hit.shape, hit.prim_index, hit.prim_uv, is_back, is_matt)
    return np.array(side)[np.array(is_matt)]
