"""What lies within bodies that absorb light: there the law of their inside cannot be kept, and has to be told.

Bodies take from light what it loses on its way to their boundary. A way inside that ends at something else is none of these.
"""

from collections.abc import Iterator

import drjit as dr
import mitsuba as mi
import numpy as np

RAYS = 1 << 12
"""Rays into each body by which others are found in it."""

SEED = 0x5EED

OF_EACH = 16
"""Places of each other thing that are looked at."""

BEYOND = 1e-3
"""How far behind what a ray has met has still to be inside, relative to the body: others may stand at its boundary. [-]"""

WINDING = 0.5
"""Turns of the boundary about a point from which on it lies within. [-]"""

PAIRS = 1 << 22
"""Points times triangles of one step."""


def find_enclosed(scene) -> Iterator[str]:
    """Yield notes on what lies within bodies of a `CompiledScene` that absorb light."""
    bodies: dict[str, list] = {}
    absorbing = set()
    for key, part, material in scene.parts():
        bodies.setdefault(key, []).append(part)
        if material.surface.is_absorbing:
            absorbing.add(key)
    names = {part.number: key for key, parts in bodies.items() for part in parts}
    for key in sorted(absorbing):
        triangles = np.concatenate([scene.triangles(part) for part in bodies[key]]).astype(float)
        corners = triangles.reshape(-1, 3)
        low, high = corners.min(axis=0), corners.max(axis=0)
        margin = BEYOND * float((high - low).max())
        low, high = low + margin, high - margin
        lamps = [
            light
            for light in scene.compiled_lights()
            if _overlap(*_reach_of(light.source), low, high)
        ]
        near = any(
            other != key and _overlap(*scene.object_bounds(other), low, high) for other in bodies
        )
        if not near and not lamps:
            continue
        numbers = _met_within(scene, triangles, {part.number for part in bodies[key]})
        others = {scene.object_name(names[each]) for each in numbers if each in names}
        places = np.array([light.source.centre for light in lamps], float).reshape(-1, 3)
        is_within = _turns(triangles, places) > WINDING
        others |= {
            light.item.name for light, inside in zip(lamps, is_within, strict=True) if inside
        }
        if others:
            first, *rest = sorted(others)
            more = f" and {len(rest)} more" if rest else ""
            yield (
                f"'{first}'{more} lies within '{scene.object_name(key)}', which absorbs light: what light loses between "
                "the two is counted on its ways to the boundary alone"
            )


def _reach_of(source) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of a lamp. (3,), (3,) [m]"""
    centre = np.asarray(source.centre, float)
    return centre - source.radius, centre + source.radius


def _overlap(low, high, other_low, other_high) -> bool:
    """Whether two boxes have something in common."""
    return bool((np.maximum(low, other_low) <= np.minimum(high, other_high)).all())


def _met_within(scene, triangles: np.ndarray, own: set[int]) -> set[int]:
    """Numbers of other shapes that rays into a body meet inside it. ``triangles``: (t, 3, 3) [m]"""
    draw = np.random.default_rng(SEED)
    a, b, c = triangles.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    if not area.sum() > 0.0:
        return set()
    size = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    face = draw.choice(len(area), RAYS, p=area / area.sum())
    u, v = np.sort(draw.random((2, RAYS)), axis=0)
    start = a[face] + (v - u)[:, None] * (b - a)[face] + u[:, None] * (c - a)[face]
    inwards = -normal[face] / area[face, None]
    # Evenly about the normal by the cosine: a unit vector plus a random one.
    away = draw.standard_normal((RAYS, 3))
    direction = inwards + away / np.linalg.norm(away, axis=1, keepdims=True)
    length = np.linalg.norm(direction, axis=1, keepdims=True)
    direction /= np.maximum(length, 1e-12)
    start += BEYOND * size * inwards
    ray = mi.Ray3f(mi.Point3f(start.T), mi.Vector3f(direction.T))
    found = set()
    for layer in (scene.solid, scene.transparent):
        if layer is None:
            continue
        hit = layer.ray_intersect_preliminary(ray, mi.Bool(False), mi.Bool(True))
        number = dr.reinterpret_array(mi.UInt32, hit.shape).numpy()
        way, is_met = hit.t.numpy().astype(np.float64), hit.is_valid().numpy()
        foreign = _some_of_each(np.flatnonzero(is_met & ~np.isin(number, list(own))), number)
        place = start[foreign] + (way[foreign, None] + BEYOND * size) * direction[foreign]
        is_within = _turns(triangles, place) > WINDING
        found |= set(number[foreign[is_within]].tolist())
    return found


def _some_of_each(rows: np.ndarray, number: np.ndarray) -> np.ndarray:
    """Return the first few of the rows that met each shape."""
    order = rows[np.argsort(number[rows], kind="stable")]
    _, first, count = np.unique(number[order], return_index=True, return_counts=True)
    place = np.arange(len(order)) - np.repeat(first, count)
    return order[place < OF_EACH]


def _turns(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """How often a boundary goes round points, by the solid angles of its triangles. (n,)

    References
    ----------
    A. Van Oosterom, J. Strackee: The Solid Angle of a Plane Triangle, IEEE Trans. Biomed. Eng. 30 (1983).
    """
    total = np.zeros(len(points))
    step = max(PAIRS // max(len(points), 1), 1)
    for first in range(0, len(triangles), step):
        a, b, c = (triangles[first : first + step, None, k] - points for k in range(3))
        la, lb, lc = (np.linalg.norm(each, axis=-1) for each in (a, b, c))
        volume = (a * np.cross(b, c)).sum(axis=-1)
        below = (
            la * lb * lc
            + (a * b).sum(axis=-1) * lc
            + (a * c).sum(axis=-1) * lb
            + (b * c).sum(axis=-1) * la
        )
        total += 2.0 * np.arctan2(volume, below).sum(axis=0)
    return total / (4.0 * np.pi)
