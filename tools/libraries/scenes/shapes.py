"""Solid and sheet shapes as plain arrays, metric, with normals that point outwards."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np


@dataclass(frozen=True)
class Part:
    """Polygons that share points; owns nothing of Blender.

    Attributes
    ----------
    points : (n, 3) array    Corner positions. [m]
    faces : list of tuple of int    Polygons, counter-clockwise seen from outside.
    uvs : (c, 2) array or None    One texture coordinate per face corner, in face order.
    """

    points: np.ndarray
    faces: list
    uvs: np.ndarray | None = None

    def moved(self, x=0.0, y=0.0, z=0.0):
        """Return the part shifted by a vector, lengths in metres."""
        return Part(self.points + np.array([x, y, z], dtype=float), self.faces, self.uvs)

    def turned(self, axis, degrees):
        """Return the part turned about an axis ``"x"``, ``"y"`` or ``"z"`` through the origin."""
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
        points = self.points.copy()
        points[:, i] = c * self.points[:, i] - s * self.points[:, j]
        points[:, j] = s * self.points[:, i] + c * self.points[:, j]
        return Part(points, self.faces, self.uvs)

    def warped(self, function):
        """Return the part with ``function((n, 3) array) -> (n, 3) array`` applied to its points."""
        return Part(function(self.points.copy()), self.faces, self.uvs)

    def flipped(self):
        """Return the part with all faces reversed."""
        return Part(self.points, [face[::-1] for face in self.faces], None)


def signed_volume(part):
    """Return the volume a closed part encloses, negative if its normals point inwards, in m3."""
    volume = 0.0
    for face in part.faces:
        first = part.points[face[0]]
        for a, b in pairwise(face[1:]):
            volume += np.dot(first, np.cross(part.points[a], part.points[b]))
    return volume / 6.0


def outward(part):
    """Return a closed part with its normals outwards."""
    return part if signed_volume(part) > 0.0 else part.flipped()


def merged(parts):
    """Return one part that holds all the given ones."""
    points, faces, start = [], [], 0
    for part in parts:
        points.append(part.points)
        faces += [tuple(index + start for index in face) for face in part.faces]
        start += len(part.points)
    uvs = None
    if all(part.uvs is not None for part in parts):
        uvs = np.concatenate([part.uvs for part in parts])
    return Part(np.concatenate(points), faces, uvs)


def quad(origin, u, v, uv_size=None):
    """Return a rectangle with normal ``u x v``.

    Parameters
    ----------
    origin, u, v : (3,) sequence    Corner and the two edges. [m]
    uv_size : tuple of float or None    Texture coordinate of the far corner.
    """
    origin, u, v = (np.asarray(vector, dtype=float) for vector in (origin, u, v))
    points = np.array([origin, origin + u, origin + u + v, origin + v])
    uvs = None
    if uv_size is not None:
        uvs = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float) * uv_size
    return Part(points, [(0, 1, 2, 3)], uvs)


def blocks(xs, ys, zs, solid):
    """Return the boundary of the solid cells of a rectilinear grid: no inner faces, no T-joints.

    Parameters
    ----------
    xs, ys, zs : sequence of float    Cell borders, ascending. [m]
    solid : callable ``(i, j, k) -> bool``    Which cells are filled.
    """
    shape = (len(xs) - 1, len(ys) - 1, len(zs) - 1)
    filled = np.zeros([n + 2 for n in shape], dtype=bool)
    for cell in np.ndindex(shape):
        filled[cell[0] + 1, cell[1] + 1, cell[2] + 1] = solid(*cell)
    index, faces = {}, []
    for cell in np.ndindex(shape):
        if not filled[cell[0] + 1, cell[1] + 1, cell[2] + 1]:
            continue
        for axis in range(3):
            for side in (0, 1):
                beside = [c + 1 for c in cell]
                beside[axis] += 2 * side - 1
                if filled[tuple(beside)]:
                    continue
                face = []
                for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    corner = list(cell)
                    corner[axis] += side
                    corner[(axis + 1) % 3] += a
                    corner[(axis + 2) % 3] += b
                    face.append(index.setdefault(tuple(corner), len(index)))
                faces.append(tuple(face if side else face[::-1]))
    points = np.array([(xs[i], ys[j], zs[k]) for i, j, k in index], dtype=float)
    return Part(points, faces)


def box(size, center=(0.0, 0.0, 0.0)):
    """Return a box. ``size`` and ``center`` in metres."""
    edges = [(c - s / 2, c + s / 2) for s, c in zip(size, center, strict=True)]
    return blocks(*edges, lambda i, j, k: True)


def rounded_box(size, radius, center=(0.0, 0.0, 0.0), segments=2, divisions=1):
    """Return a box with rounded edges.

    Parameters
    ----------
    size : (3,) sequence    Outer size. [m]
    radius : float    Edge radius, at most half of the smallest side. [m]
    center : (3,) sequence    [m]
    segments : int    Faces over half of a quarter turn.
    divisions : int    Faces along each flat side, for parts that are warped afterwards.
    """
    half = np.asarray(size, dtype=float) / 2
    radius = min(radius, 0.999 * half.min())
    # Tangents of even angles spread the points evenly over the quarter turn.
    bend = [math.tan(math.pi / 4 * k / segments) for k in range(segments, -1, -1)]
    steps = [(-1.0, -b) for b in bend]
    steps += [(-1.0 + 2.0 * k / divisions, 0.0) for k in range(1, divisions)]
    steps += [(1.0, b) for b in bend[::-1]]
    index, points, faces = {}, [], []

    def point(core, offset):
        offset = np.asarray(offset)
        position = np.asarray(core) * (half - radius)
        position = position + radius * offset / np.linalg.norm(offset)
        key = tuple(np.round(position, 7))
        if key not in index:
            index[key] = len(points)
            points.append(position)
        return index[key]

    for axis in range(3):
        for side in (-1.0, 1.0):
            grid = np.empty((len(steps), len(steps)), dtype=int)
            for (a, (core_a, off_a)), (b, (core_b, off_b)) in (
                (p, q) for p in enumerate(steps) for q in enumerate(steps)
            ):
                core, offset = [side] * 3, [side] * 3
                core[(axis + 1) % 3], offset[(axis + 1) % 3] = core_a, off_a
                core[(axis + 2) % 3], offset[(axis + 2) % 3] = core_b, off_b
                grid[a, b] = point(core, offset)
            for a in range(len(steps) - 1):
                for b in range(len(steps) - 1):
                    face = (grid[a, b], grid[a + 1, b], grid[a + 1, b + 1], grid[a, b + 1])
                    faces.append(tuple(map(int, face if side > 0 else face[::-1])))
    return Part(np.array(points) + np.asarray(center, dtype=float), faces)


def lathe(profile, segments=32):
    """Return a closed solid of revolution about z.

    Parameters
    ----------
    profile : sequence of (r, z)    Either from the axis to the axis (``r`` 0 at both ends), or a
        closed loop off the axis, such as the wall of a ring; not repeated at the end. [m]
    segments : int    Faces around.
    """
    angles = 2.0 * np.pi * np.arange(segments) / segments
    rings, points = [], []
    for r, z in profile:
        if r == 0.0:
            rings.append([len(points)] * segments)
            points.append((0.0, 0.0, z))
        else:
            rings.append(list(range(len(points), len(points) + segments)))
            points += [(r * math.cos(a), r * math.sin(a), z) for a in angles]
    pairs = list(pairwise(rings))
    if profile[0][0] != 0.0:
        pairs.append((rings[-1], rings[0]))
    faces = []
    for low, high in pairs:
        for a in range(segments):
            b = (a + 1) % segments
            face = dict.fromkeys((low[a], low[b], high[b], high[a]))
            if len(face) > 2:
                faces.append(tuple(face))
    return outward(Part(np.array(points, dtype=float), faces))


def tube(path, radius, segments=12, closed=False):
    """Return a round bar along a path, capped unless closed.

    Parameters
    ----------
    path : (n, 3) array    Centre line. [m]
    radius : float or (n,) sequence    [m]
    """
    path = np.asarray(path, dtype=float)
    radii = np.broadcast_to(np.asarray(radius, dtype=float), len(path))
    if closed:
        tangents = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    else:
        tangents = np.gradient(path, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    side = np.cross(tangents[0], np.eye(3)[np.argmin(np.abs(tangents[0]))])
    points = []
    for center, tangent, r in zip(path, tangents, radii, strict=True):
        # Carrying the frame along keeps the bar from twisting where the path turns.
        side = side - tangent * np.dot(side, tangent)
        side /= np.linalg.norm(side)
        up = np.cross(tangent, side)
        for k in range(segments):
            angle = 2.0 * math.pi * k / segments
            points.append(center + r * (math.cos(angle) * side + math.sin(angle) * up))
    faces, count = [], len(path)
    for i in range(count if closed else count - 1):
        low, high = i * segments, (i + 1) % count * segments
        for k in range(segments):
            m = (k + 1) % segments
            faces.append((low + k, low + m, high + m, high + k))
    if not closed:
        faces.append(tuple(reversed(range(segments))))
        faces.append(tuple(range((count - 1) * segments, count * segments)))
    return outward(Part(np.array(points), faces))


def prism(outline, height):
    """Return a plane outline ``(n, 2)`` raised along z from 0 to ``height``, lengths in metres."""
    n = len(outline)
    points = [(x, y, 0.0) for x, y in outline] + [(x, y, height) for x, y in outline]
    faces = [tuple(reversed(range(n))), tuple(range(n, 2 * n))]
    faces += [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return outward(Part(np.array(points, dtype=float), faces))


def sphere(radius, segments=32, rings=16):
    """Return a sphere about the origin, lengths in metres."""
    angles = np.pi * np.arange(rings + 1) / rings - np.pi / 2
    profile = [(radius * math.cos(a), radius * math.sin(a)) for a in angles]
    profile[0], profile[-1] = (0.0, -radius), (0.0, radius)
    return lathe(profile, segments)


def cylinder(radius, height, segments=24, bevel=0.0):
    """Return an upright cylinder on z = 0 with edges chamfered by ``bevel``, in metres."""
    if bevel == 0.0:
        return lathe([(0.0, 0.0), (radius, 0.0), (radius, height), (0.0, height)], segments)
    inner = radius - bevel
    rim = [(inner, 0.0), (radius, bevel), (radius, height - bevel), (inner, height)]
    return lathe([(0.0, 0.0), *rim, (0.0, height)], segments)


def curve(points, samples=8):
    """Return a smooth path (Catmull-Rom) through ``(n, 3)`` points, ends included."""
    points = np.asarray(points, dtype=float)
    padded = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    path = []
    for p0, p1, p2, p3 in zip(padded, padded[1:], padded[2:], padded[3:], strict=False):
        for t in np.arange(samples) / samples:
            path.append(
                0.5
                * (
                    2 * p1
                    + (p2 - p0) * t
                    + (2 * p0 - 5 * p1 + 4 * p2 - p3) * t**2
                    + (3 * p1 - p0 - 3 * p2 + p3) * t**3
                )
            )
    return np.array([*path, points[-1]])
