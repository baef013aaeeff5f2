"""Means over surfaces and pictures, each with the error that its case needs."""

from dataclasses import replace

import numpy as np

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.mesh import Mesh

from ..bench import MARGIN, Bench

DENSITY = 4.0
"""Of the lux maps. [lumel/m]"""

PIXELS = 16
"""Along the sides of the pictures."""

FIRST_SAMPLES, MOST_SAMPLES = 16, 1 << 20
"""Per lumel or pixel; there are hundreds of them."""

ENOUGH = 1 << 12
"""Samples per lumel for maps whose error is known to be small by then, if no light is missed."""

SEED_STEP = 1009
"""Between the seeds of a group's scenes; larger than what the comparison of seeds goes through."""


def reseeded(bench: Bench, number: int) -> Bench:
    """Bench for the scene of that number of a group.

    Scenes that differ in a reflectance only would make the same random choices, and so the same errors; a group is judged
    by the mean of its errors, as of independent ones.
    """
    return replace(bench, seed=bench.seed + SEED_STEP * number)


def mean_at_points(
    bench: Bench, items, points, normals, allowed: float, weights=None, **more
) -> tuple[float, float]:
    """Mean illuminance of points (n, 3) and its standard error; ``weights`` (n,) sum to 1, None: all alike. [lx]"""
    count = len(points)
    weights = np.full(count, 1.0 / count) if weights is None else np.asarray(weights)
    # The errors of single points add up like squares.
    each = allowed / np.sqrt((weights**2).sum())
    made = bench.measure(items, points, normals, each, **more)
    return float(weights @ made.values), float(np.sqrt(weights**2 @ made.errors**2))


def mean_by_bake(
    bench: Bench, items, meshes: tuple[Mesh, ...], allowed: float, area: float, most=MOST_SAMPLES
):
    """Flux that the lux maps of meshes hold, over an area, and its standard error. [lx]

    ``most``: samples per lumel after which the error is as it is; where light is missed, no number would be enough.
    """
    session = bench.engine.stage(items)
    shares = np.array([mesh.areas().sum() for mesh in meshes]) / area
    objects = tuple(mesh.id for mesh in meshes)

    def bake(samples: int) -> tuple[float, float]:
        order = BakeOrder(objects, StopRule(samples=samples), density=DENSITY, seed=bench.seed)
        maps = session.bake_objects(order).maps
        means, errors = np.array([(m.mean, m.mean_standard_error) for m in maps]).T
        # The maps of a bake share the light of its cells, so their errors add up like numbers at the worst.
        return float(shares @ means), float(shares @ errors)

    return _refine(bake, allowed, most)


def mean_of_picture(bench: Bench, items, camera: Camera, allowed: float) -> tuple[float, float]:
    """Mean luminance of a picture's pixels and its standard error. [cd/m2]"""

    def render(samples: int) -> tuple[float, float]:
        picture = bench.engine.render(items, camera, StopRule(samples=samples), bench.seed)
        error = np.sqrt((picture.luminance_error.astype(np.float64) ** 2).sum())
        return float(picture.tristimulus[..., 1].mean(dtype=np.float64)), error / PIXELS**2

    return _refine(render, allowed)


def look(eye, target, extent: float) -> Camera:
    """Square perspective view with +z up; ``extent`` is its full width at unit distance."""
    back = np.subtract(eye, target)
    back = back / np.linalg.norm(back)
    side = np.cross((0.0, 0.0, 1.0), back)
    side /= np.linalg.norm(side)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([side, np.cross(back, side), back], axis=1)
    frame[:3, 3] = eye
    return Camera(frame, Projection.PERSPECTIVE, PIXELS, PIXELS, extent, extent)


def _refine(run, allowed: float, most: int = MOST_SAMPLES) -> tuple[float, float]:
    """Repeat a run with more samples until its standard error is a third of what is allowed."""
    samples = FIRST_SAMPLES
    while True:
        mean, error = run(samples)
        excess = MARGIN * error / allowed
        if excess <= 1.0 or samples >= most:
            return mean, error
        # A power of two keeps the sequences well distributed; a fifth more, for the error of the error.
        wanted = samples * max(1.2 * excess**2, 2.0)
        samples = int(min(1 << int(np.ceil(np.log2(wanted))), most))
