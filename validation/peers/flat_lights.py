"""Flat lights as rectangles, which Radiance aims at best, and how near sensors are to them."""

import numpy as np

from lumenray.engine.scene.light import AreaLight, PointLight

from .contents import Contents, Face

SMALL_MESH = 300
"""Triangles of one material beyond which they become a mesh, which Radiance keeps compactly but cannot aim at."""

NEAR = 0.5
"""A light is met by the hemisphere's rays, not aimed at, from nearer than this share of its shorter side: Radiance divides
a source into 64 parts at most."""

NEAR_SPHERE = 10.0
"""The same for spheres, over their radius: Radiance takes them for disks."""

MOST_TILES = 1024
"""Parts into which a light is cut, each of which Radiance divides again."""

STRIPS = 64
"""Rectangles that stand for an ellipse or a triangle: Radiance aims best at rectangles."""


def is_near(contents: Contents, positions: np.ndarray) -> np.ndarray:
    """Whether each of the sensors (n, 3) is so near an area light that aiming at it is inaccurate."""
    near = np.zeros(len(positions), dtype=bool)
    for face in _emitters(contents):
        sides = face.corners[1] - face.corners[0], face.corners[-1] - face.corners[0]
        shorter = min(np.linalg.norm(side) for side in sides)
        near |= distances(face, positions) < NEAR * shorter
    for light in contents.lights:
        if isinstance(light, PointLight) and light.radius > 0.0:
            away = np.linalg.norm(positions - light.position, axis=1)
            near |= away < NEAR_SPHERE * light.radius
    return near


def distances(face: Face, positions: np.ndarray) -> np.ndarray:
    """Distances of points (n, 3) from a face, as if a triangle were the parallelogram of its sides. [m]"""
    corner = face.corners[0]
    sides = np.stack([face.corners[1] - corner, face.corners[-1] - corner], axis=1)
    place = np.clip((positions - corner) @ np.linalg.pinv(sides).T, 0.0, 1.0)
    return np.linalg.norm(positions - corner - place @ sides.T, axis=1)


def cut(face: Face, sensors: np.ndarray, least: int) -> list[np.ndarray]:
    """Cut a light's face into tiles that are no larger than the way to the nearest sensor, ``least`` along each side."""
    corner = face.corners[0]
    u, v = face.corners[1] - corner, face.corners[3] - corner
    nearest = float(distances(face, sensors).min())
    counts = np.ceil(np.array([np.linalg.norm(u), np.linalg.norm(v)]) / max(nearest, 1e-12))
    counts = np.clip(counts, least, MOST_TILES).astype(int)
    while counts.prod() > MOST_TILES:
        counts[np.argmax(counts)] = (counts.max() + 1) // 2
    u, v = u / counts[0], v / counts[1]
    starts = [corner + i * u + j * v for j in range(int(counts[1])) for i in range(int(counts[0]))]
    return [np.stack([start, start + u, start + u + v, start + v]) for start in starts]


def _emitters(contents: Contents) -> list[Face]:
    faces = [box_around(light) for light in contents.lights if isinstance(light, AreaLight)]
    for part in contents.parts:
        if part.material.emission is not None and len(part.triangles) <= SMALL_MESH:
            faces += part.faces()
    return faces


def box_around(light: AreaLight) -> Face:
    """Rectangle around an area light, facing where it shines."""
    frame = np.asarray(light.frame, dtype=np.float64)
    return _rectangle(
        frame[:3, 3], 0.5 * light.size_y * frame[:3, 1], 0.5 * light.size_x * frame[:3, 0]
    )


def ellipse_strips(box: Face) -> list[Face]:
    """Rectangles along one axis, each of the area of its part of the ellipse in a rectangle."""
    y, x = (0.5 * (box.corners[k] - box.corners[0]) for k in (1, 3))
    edges = np.linspace(-1.0, 1.0, STRIPS + 1)
    # The integral of the half chord sqrt(1 - t^2).
    areas = np.diff(0.5 * (edges * np.sqrt(1.0 - edges**2) + np.arcsin(edges)))
    centre, half = box.corners.mean(axis=0), 1.0 / STRIPS
    places = 0.5 * (edges[1:] + edges[:-1])
    return [
        _rectangle(centre + place * y, half * y, area / (2.0 * half) * x)
        for place, area in zip(places, areas, strict=True)
    ]


def triangle_strips(face: Face) -> list[Face]:
    """Rectangles along one side, each of the area of its part of the triangle."""
    a, b, c = face.corners
    base = c - b
    foot = b + base * np.dot(a - b, base) / np.dot(base, base)
    shares = (np.arange(STRIPS) + 0.5) / STRIPS
    return [
        _rectangle(a + share * (0.5 * (b + c) - a), 0.5 / STRIPS * (foot - a), 0.5 * share * base)
        for share in shares
    ]


def _rectangle(centre, half_y, half_x) -> Face:
    """Rectangle that faces half_y x half_x."""
    low, high = centre - half_x, centre + half_x
    return Face(np.stack([low - half_y, low + half_y, high + half_y, high - half_y]))
