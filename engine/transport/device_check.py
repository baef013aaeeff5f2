"""A small job whose answer is known, by which a device is tried before anybody trusts it.

It uses what all transport is made of: integers that wrap (random numbers), a loop that ends at another
turn in each lane, sums that many lanes add to, and rays that meet a surface.
"""

import math
import time
from dataclasses import dataclass

SIDE = 1 << 9
"""Rays are a grid of this many by this many."""

RADIUS = 0.5
"""Of the cone inside the square of rays. [m]"""

SIDES = 512
"""Of the cone."""

REPEATS = 8
"""How often the rays are shot for the speed."""


@dataclass(frozen=True)
class Check:
    """What came out: ``fault`` is empty where all answers are right; ``speed`` in rays a second, ``seconds`` in all."""

    fault: str
    speed: float
    seconds: float


def check_variant(variant: str) -> Check:
    """Try a Mitsuba variant, which stays active."""
    import mitsuba as mi

    start = time.perf_counter()
    if mi.variant() != variant:
        mi.set_variant(variant)
    fault = _check_integers() or _check_loop() or _check_layers(variant)
    hit, speed = _shoot()
    # The grid misses the disc's area by less than its own rim does.
    expected, tolerance = math.pi * RADIUS**2, 4.0 * RADIUS / SIDE
    if not fault and not abs(hit - expected) < tolerance:
        fault = f"rays met {hit:.5f} of a square of which a cone covers {expected:.5f}"
    return Check(fault, speed, time.perf_counter() - start)


def _check_integers() -> str:
    """Step a linear congruential generator in every lane, and add up by scattering."""
    import drjit as dr
    import mitsuba as mi
    import numpy as np

    count, bins = 1 << 16, 16
    state = dr.arange(mi.UInt32, count)
    for _ in range(5):
        state = state * mi.UInt32(1664525) + mi.UInt32(1013904223)
    sums = dr.zeros(mi.UInt32, bins)
    dr.scatter_add(sums, state >> 16, dr.arange(mi.UInt32, count) & mi.UInt32(bins - 1))
    expected = np.arange(count, dtype=np.uint64)
    for _ in range(5):
        expected = (expected * 1664525 + 1013904223) % (1 << 32)
    expected = (expected >> 16).reshape(-1, bins).sum(axis=0) % (1 << 32)
    if np.array_equal(np.array(sums), expected):
        return ""
    return "sums of integers are wrong"


def _check_loop() -> str:
    """Halve numbers until they are 1: a recorded loop that ends at another turn in each lane."""
    import drjit as dr
    import mitsuba as mi
    import numpy as np

    count = 1 << 12
    number, turns = dr.arange(mi.UInt32, count) + 1, dr.zeros(mi.UInt32, count)
    root = mi.Float(number)

    def halve(number, turns, root):
        return number >> 1, turns + 1, dr.sqrt(root)

    number, turns, root = dr.while_loop(
        (number, turns, root), lambda number, turns, root: number > 1, halve
    )
    numbers = np.arange(1, count + 1)
    halvings = np.floor(np.log2(numbers)).astype(np.uint32)
    expected = numbers ** (0.5**halvings)
    if not np.array_equal(np.array(turns), halvings):
        return "a loop ended at wrong turns"
    if not np.allclose(np.array(root), expected, rtol=1e-5):
        return "square roots are wrong"
    return ""


def _check_layers(variant: str) -> str:
    """Trace two layers of a scene in one kernel: a cone of one, and a cone below it, smaller by half, of the other."""
    import drjit as dr
    import mitsuba as mi

    from ..arrays import pointer_id
    from .devices import of_variant
    from .layers import make_layers

    layers = make_layers(None, 2, shares=not of_variant(variant).traces_many)
    for number, layer in enumerate(layers):
        cone = _cone(0.5**number, -float(number))
        layer.add(cone, pointer_id(cone), SIDES)
    for layer in layers:
        layer.commit()
    ray = _parallel_rays(dr.opaque(mi.Float, 2.0))
    seen = [
        dr.mean(dr.select(layer.ray_test(ray), mi.Float(1.0), mi.Float(0.0))) for layer in layers
    ]
    # Both at once, as paths trace them.
    dr.eval(seen)
    for number, mean in enumerate(seen):
        expected, tolerance = math.pi * (RADIUS * 0.5**number) ** 2, 4.0 * RADIUS / SIDE
        if not abs(float(mean[0]) - expected) < tolerance:
            return f"rays through two layers met {float(mean[0]):.5f} of a square of which a cone covers {expected:.5f}"
    return ""


def _shoot() -> tuple[float, float]:
    """Return the part of parallel rays over a square of 1 m that meet a cone from above, and rays a second."""
    import drjit as dr
    import mitsuba as mi

    scene = mi.load_dict({"type": "scene", "cone": _cone()})

    def shoot(height):
        ray = _parallel_rays(height)
        return dr.mean(dr.select(scene.ray_test(ray), mi.Float(1.0), mi.Float(0.0)))

    hit = float(shoot(dr.opaque(mi.Float, 2.0))[0])
    start = time.perf_counter()
    for number in range(REPEATS):
        dr.eval(shoot(dr.opaque(mi.Float, 2.0 + 0.01 * number)))
    dr.sync_thread()
    return hit, REPEATS * SIDE * SIDE / (time.perf_counter() - start)


def _parallel_rays(height):
    """Return a grid of rays that go down from a height over a square of 1 m."""
    import drjit as dr
    import mitsuba as mi

    lane = dr.arange(mi.UInt32, SIDE * SIDE)
    x = (mi.Float(lane % SIDE) + 0.5) / SIDE - 0.5
    y = (mi.Float(lane // SIDE) + 0.5) / SIDE - 0.5
    return mi.Ray3f(mi.Point3f(x, y, height), mi.Vector3f(0.0, 0.0, -1.0))


def _cone(size: float = 1.0, height: float = 0.0):
    """Return a cone of triangles, so many times as wide, at a height. [m]"""
    import mitsuba as mi
    import numpy as np

    sides = SIDES
    angle = np.linspace(0.0, 2.0 * math.pi, sides, endpoint=False)
    rim = np.stack([RADIUS * np.cos(angle), RADIUS * np.sin(angle), np.zeros(sides)], axis=1)
    points = size * np.concatenate([[[0.0, 0.0, RADIUS]], rim]) + [0.0, 0.0, height]
    points = points.astype(np.float32)
    first = np.arange(sides)
    faces = np.stack([np.zeros(sides), first + 1, (first + 1) % sides + 1], axis=1)
    mesh = mi.Mesh("cone", len(points), sides)
    values = mi.traverse(mesh)
    values["vertex_positions"] = points.ravel()
    values["faces"] = faces.astype(np.uint32).ravel()
    values.update()
    return mesh
