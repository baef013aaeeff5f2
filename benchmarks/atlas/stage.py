"""A scene as the engine's estimators trace it, without the engine's session: for references and plain gathering."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...engine.arrays import upload
from ...engine.requirements.plan import make_plan
from ...engine.scene.scene import Scene, SceneDelta
from ...engine.transport import backend
from .scenes import AtlasScene

PROBES = 32
"""Rays that look whether a place is inside a solid."""

LEAST_DARK = 0.5
"""Share of rays that meet the back of a surface, from which on a place is inside."""


class Stage:
    """A compiled scene.

    Parameters
    ----------
    scene : AtlasScene
    transport : str    ``auto``, ``mono`` or ``spectral``.
    """

    def __init__(self, scene: AtlasScene, transport: str = "auto"):
        self.scene = Scene()
        self.scene.apply(SceneDelta(changed=scene.items))
        needs = make_plan(self.scene, transport=transport)
        self.variant = backend.start(needs.spectral)
        from ...engine.transport.compiled.compile import CompiledScene

        self.compiled = CompiledScene(self.scene, needs)
        self.compiled.settle()

    def are_inside(self, positions: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Whether places on surfaces (k, 3) see the backs of other surfaces for the most part. (k,)"""
        from ...engine.transport.paths.gather import receiver
        from ...engine.transport.rays import spawn_ray

        count, compiled = len(positions), self.compiled
        local = compiled.local(positions)
        lane = dr.arange(mi.UInt32, count * PROBES)
        who = lane // PROBES

        def fetch(kind, columns):
            return kind(
                *(dr.gather(mi.Float, upload(mi.Float, columns[:, k]), who) for k in range(3))
            )

        normal = fetch(mi.Normal3f, normals)
        si = receiver(fetch(mi.Point3f, local), normal, normal, None, compiled.extent)
        numbers = mi.PCG32(size=count * PROBES)
        sample = mi.Point2f(numbers.next_float32(), numbers.next_float32())
        direction = si.sh_frame.to_world(mi.warp.square_to_cosine_hemisphere(sample))
        ray = spawn_ray(compiled, si, direction)
        hit = compiled.surface(compiled.solid.ray_intersect_preliminary(ray), ray, mi.Bool(True))
        back = hit.is_valid() & (dr.dot(hit.n, ray.d) > 0.0)
        seen = np.array(dr.select(back, 1.0, 0.0)).reshape(count, PROBES)
        return seen.mean(axis=1) > LEAST_DARK
