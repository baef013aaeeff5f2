"""Light inside a thread by NumPy, all photons a step at a time: what the walk of the engine is timed against."""

import numpy as np

from ...engine.cloth.boundary import COSINES, share_table


def walk(optics, axial, offset, seed: int = 0) -> np.ndarray:
    """Ways inside of photons in a thread, as `thread_walk.walk_inside` has them. (n,), (n,) -> (n,) [radius]"""
    rng = np.random.default_rng(seed)
    level = np.sqrt(1.0 - axial**2)
    dy, dz = level * offset / optics.index, axial / optics.index
    dx = -np.sqrt(1.0 - dy**2 - dz**2)
    x, y = np.ones_like(dx), np.zeros_like(dx)
    length, rows = np.zeros_like(dx), np.arange(len(dx))
    shares = share_table(optics.index, optics.roughness)
    roots = np.linspace(0.0, 1.0, COSINES + 1)
    chances = np.linspace(0.0, 1.0, len(optics.cosines))
    while len(rows):
        count = len(rows)
        free = -np.log(1.0 - rng.random(count)) / optics.optical_radius
        a, b = np.maximum(dx**2 + dy**2, 1e-12), x * dx + y * dy
        wall = (np.sqrt(np.maximum(b**2 - a * (x**2 + y**2 - 1.0), 0.0)) - b) / a
        hits = wall <= free
        way = np.where(hits, np.maximum(wall, 0.0), free)
        x, y = x + way * dx, y + way * dy
        length[rows] += way
        cosine = x * dx + y * dy
        outside = 1.0 - optics.index**2 * (1.0 - cosine**2)
        share = np.interp(np.maximum(outside, 0.0) ** 0.25, roots, shares)
        goes = hits & (outside > 0.0) & (rng.random(count) >= share)
        bend = np.interp(rng.random(count), chances, optics.cosines)
        turn, tilt = 2.0 * np.pi * rng.random(count), np.sqrt(np.maximum(1.0 - bend**2, 0.0))
        sign = np.where(dz >= 0.0, 1.0, -1.0)
        c = -1.0 / (sign + dz)
        d = dx * dy * c
        one, two = tilt * np.cos(turn), tilt * np.sin(turn)
        sx = (1.0 + sign * dx * dx * c) * one + d * two + dx * bend
        sy = sign * d * one + (sign + dy * dy * c) * two + dy * bend
        sz = -sign * dx * one - dy * two + dz * bend
        back = 2.0 * cosine
        dx, dy, dz = (
            np.where(hits, mirrored, scattered)
            for mirrored, scattered in ((dx - back * x, sx), (dy - back * y, sy), (dz, sz))
        )
        rest = ~goes
        rows = rows[rest]
        x, y, dx, dy, dz = (each[rest] for each in (x, y, dx, dy, dz))
    return length
