"""Strands and balls as triangles: round tubes of few sides with the normals of round ones, and spheres of few faces.

A polygon that is as long around as a circle is as wide on the mean of all views, and a body of flat faces with the surface
of a ball is as large: so shadows and what is covered are right on the mean, however few the faces.
"""

from dataclasses import dataclass

import numpy as np

MOST_TRIANGLES = 1 << 22
"""Triangles of one object's strands or balls; of more, some strands are left out and the others made wider."""

SIDES = ((16, 1 << 18), (8, 1 << 20), (6, 1 << 21), (4, MOST_TRIANGLES), (3, MOST_TRIANGLES))
"""Sides of tubes, and up to how many triangles they have so many: light on tubes of 8 sides is 0.4 % too dim."""

SUBDIVISIONS = ((2, 1 << 19), (1, 1 << 21), (0, MOST_TRIANGLES))
"""How often the faces of an icosahedron are divided in four, likewise."""

STEPS = 4
"""Pieces of a bent part of a strand between two of its points."""

STRAIGHT = 0.02
"""How far a smooth strand may run beside the line between two points, relative to the line, to be taken for it. [-]"""


@dataclass(frozen=True)
class Strands:
    """Polylines.

    Parameters
    ----------
    points : (p, 3) float64 array    Of all strands, one after the other.
    radii : (p,) float64 array
    counts : (s,) int array    Points of each strand, at least 2.
    slots : (s,) int array    Material slot of each.
    """

    points: np.ndarray
    radii: np.ndarray
    counts: np.ndarray
    slots: np.ndarray

    def __len__(self):
        """Strands."""
        return len(self.counts)

    @property
    def starts(self) -> np.ndarray:
        """First point of each strand. (s,)"""
        return np.cumsum(self.counts) - self.counts

    def owners(self) -> np.ndarray:
        """Strand of each point. (p,)"""
        return np.repeat(np.arange(len(self)), self.counts)

    def chosen(self, keep: np.ndarray) -> "Strands":
        """Some of them. ``keep``: (s,) bool"""
        points = np.repeat(keep, self.counts)
        return Strands(self.points[points], self.radii[points], self.counts[keep], self.slots[keep])


@dataclass(frozen=True)
class Triangles:
    """Triangles as a `Geometry` has them, and what is to be said of them."""

    vertices: np.ndarray
    triangles: np.ndarray
    corner_normals: np.ndarray
    slots: np.ndarray
    note: str = ""


def join(parts: list[Strands]) -> Strands:
    """Return all strands of several sets."""
    arrays = zip(*((p.points, p.radii, p.counts, p.slots) for p in parts), strict=True)
    return Strands(*(np.concatenate(each) for each in arrays))


def usable(strands: Strands) -> Strands:
    """Drop strands of fewer than two different points, and points that lie where the one before does."""
    if not len(strands):
        return strands
    owners, points = strands.owners(), strands.points
    is_first = np.diff(owners, prepend=-1) > 0
    step = np.linalg.norm(np.diff(points, axis=0, prepend=points[:1]), axis=1)
    is_finite = np.isfinite(points).all(axis=1) & np.isfinite(strands.radii)
    if not is_finite.any():
        return strands.chosen(np.zeros(len(strands), bool))
    size = float(np.ptp(points[is_finite], axis=0).max())
    keep = is_finite & (is_first | (step > 1e-7 * size))
    counts = np.bincount(owners[keep], minlength=len(strands))
    made = Strands(points[keep], strands.radii[keep], counts, strands.slots)
    thick = np.maximum.reduceat(made.radii, np.minimum(made.starts, len(made.radii) - 1)) > 0.0
    return made.chosen((counts >= 2) & thick)


def smoothed(strands: Strands) -> Strands:
    """Let strands run through their points as Catmull and Rom have it, in pieces where they bend."""
    if not len(strands):
        return strands
    owners, points = strands.owners(), strands.points
    first = strands.starts
    last = first + strands.counts - 1
    row = np.setdiff1d(np.arange(len(points)), last)
    before = np.maximum(row - 1, first[owners[row]])
    after = np.minimum(row + 2, last[owners[row]])
    keys = points[[before, row, row + 1, after]]
    chord = keys[2] - keys[1]
    aside = max(_aside(_catmull(keys, share) - keys[1], chord) for share in (0.25, 0.5, 0.75))
    if aside <= STRAIGHT:
        return strands
    shares = np.arange(STEPS) / STEPS
    made = np.stack([_catmull(keys, share) for share in shares], axis=1)
    radii = np.stack(
        [(1 - share) * strands.radii[row] + share * strands.radii[row + 1] for share in shares],
        axis=1,
    )
    counts = STEPS * (strands.counts - 1) + 1
    new_points = np.empty((counts.sum(), 3))
    new_radii = np.empty(counts.sum())
    ends = np.cumsum(counts) - 1
    inner = np.setdiff1d(np.arange(counts.sum()), ends)
    new_points[inner], new_radii[inner] = made.reshape(-1, 3), radii.reshape(-1)
    new_points[ends], new_radii[ends] = points[last], strands.radii[last]
    return Strands(new_points, new_radii, counts, strands.slots)


def _aside(away: np.ndarray, chord: np.ndarray) -> float:
    """How far points lie beside lines at most, relative to these. (n, 3), (n, 3) [-]"""
    area = np.linalg.norm(np.cross(away, chord), axis=1)
    return float((area / np.maximum((chord**2).sum(axis=1), 1e-300)).max())


def _catmull(keys: np.ndarray, t: float) -> np.ndarray:
    """Place between the second and the third of four points. (n, 3)"""
    a, b, c, d = keys
    return 0.5 * (
        2.0 * b
        + (c - a) * t
        + (2.0 * a - 5.0 * b + 4.0 * c - d) * t**2
        + (3.0 * b - a - 3.0 * c + d) * t**3
    )


def tubes(strands: Strands) -> Triangles | None:
    """Return strands as tubes, None if there are none."""
    strands, note = usable(strands), ""
    if not len(strands):
        return None
    pieces = int((strands.counts - 1).sum())
    sides = next((each for each, most in SIDES if 2 * each * pieces <= most), 0)
    if not sides:
        sides, most = SIDES[-1]
        step = int(np.ceil(2 * sides * pieces / most))
        count = len(strands)
        strands = strands.chosen(np.arange(count) % step == 0)
        strands = Strands(strands.points, strands.radii * step, strands.counts, strands.slots)
        note = f"{count} strands are too many: one of {step} is there, {step} times as wide"
    return _tubes(strands, sides, note)


def _tubes(strands: Strands, sides: int, note: str) -> Triangles:
    along, across = _frames(strands)
    angle = 2.0 * np.pi * np.arange(sides) / sides
    other = np.cross(along, across)
    radial = (
        np.cos(angle)[None, :, None] * across[:, None]
        + np.sin(angle)[None, :, None] * other[:, None]
    )
    # As long around as the circle.
    wide = strands.radii * (np.pi / sides) / np.sin(np.pi / sides)
    vertices = strands.points[:, None] + wide[:, None, None] * radial
    starts = strands.starts
    ends = starts + strands.counts - 1
    row = np.setdiff1d(np.arange(len(strands.points)), ends)
    i, j = np.arange(sides), (np.arange(sides) + 1) % sides
    a, b = row[:, None] * sides + i, row[:, None] * sides + j
    c, d = b + sides, a + sides
    walls = np.stack([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)], axis=2)
    walls = walls.reshape(-1, 3)
    # The ends are open, as Cycles has them.
    slots = np.repeat(strands.slots[strands.owners()[row]], 2 * sides)
    normals = radial.reshape(-1, 3)[walls]
    return _triangles(vertices.reshape(-1, 3), walls, normals, slots, note)


def _triangles(vertices, triangles, normals, slots, note) -> Triangles:
    """Triangles but those of no size, such as at pointed tips."""
    corners = vertices[triangles]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    longest = np.linalg.norm(np.diff(corners, axis=1), axis=2).max(axis=1)
    keep = area > 1e-10 * longest**2
    return Triangles(
        vertices.astype(np.float32),
        triangles[keep].astype(np.int32),
        normals[keep].astype(np.float32),
        slots[keep].astype(np.int32),
        note,
    )


def _frames(strands: Strands) -> tuple[np.ndarray, np.ndarray]:
    """Direction of strands at their points, and one across, which turns as little as can be. (p, 3), (p, 3)"""
    points, starts, counts = strands.points, strands.starts, strands.counts
    ends = starts + counts - 1
    step = np.diff(points, axis=0)
    step /= np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300)
    along = np.zeros_like(points)
    along[:-1] += step
    along[1:] += step
    along[starts] = step[starts]
    along[ends] = step[ends - 1]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    # A strand that turns back upon itself goes on as it came.
    arrived = np.concatenate([step[:1], step])
    along = np.where(length > 1e-6, along / np.maximum(length, 1e-300), arrived)
    across = np.empty_like(points)
    across[starts] = _upright(along[starts])
    for place in range(1, int(counts.max())):
        row = starts[counts > place] + place
        turned = across[row - 1] - along[row] * (across[row - 1] * along[row]).sum(1)[:, None]
        length = np.linalg.norm(turned, axis=1, keepdims=True)
        across[row] = np.where(
            length > 1e-6, turned / np.maximum(length, 1e-300), _upright(along[row])
        )
    return along, across


def _upright(direction: np.ndarray) -> np.ndarray:
    """Unit vectors at right angles to others. (n, 3)"""
    axis = np.eye(3)[np.abs(direction).argmin(axis=1)]
    made = axis - direction * (axis * direction).sum(axis=1)[:, None]
    return made / np.linalg.norm(made, axis=1, keepdims=True)


def balls(centres: np.ndarray, radii: np.ndarray) -> Triangles | None:
    """Return spheres, None if there are none. (n, 3), (n,)"""
    is_there = np.isfinite(centres).all(axis=1) & np.isfinite(radii) & (radii > 0.0)
    centres, radii, note = centres[is_there], radii[is_there], ""
    if not len(centres):
        return None
    level = next((each for each, most in SUBDIVISIONS if 20 * 4**each * len(centres) <= most), -1)
    if level < 0:
        level, most = SUBDIVISIONS[-1]
        count, step = len(centres), int(np.ceil(20 * len(centres) / most))
        # As much of the view is covered.
        centres, radii = centres[::step], radii[::step] * np.sqrt(step)
        note = f"{count} points are too many: one of {step} is there, with {step} times the surface"
    unit, faces = _icosphere(level)
    corners = unit[faces]
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    wide = radii * np.sqrt(4.0 * np.pi / area.sum())
    vertices = centres[:, None] + wide[:, None, None] * unit
    triangles = np.arange(len(centres))[:, None, None] * len(unit) + faces
    normals = np.broadcast_to(corners, (len(centres), *corners.shape)).reshape(-1, 3, 3)
    slots = np.zeros(len(centres) * len(faces), int)
    return _triangles(vertices.reshape(-1, 3), triangles.reshape(-1, 3), normals, slots, note)


def _icosphere(level: int) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors and faces of an icosahedron, its faces divided so often. (v, 3), (f, 3)"""
    g = 0.5 * (1.0 + np.sqrt(5.0))
    vertices = [
        (-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g),
        (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1),
    ]  # fmt: skip
    faces = [
        (0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
        (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5),
        (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1),
    ]  # fmt: skip
    vertices, faces = np.array(vertices, float), np.array(faces)
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    for _ in range(level):
        a, b, c = vertices[faces].transpose(1, 0, 2)
        ab, bc, ca = (_between(x, y) for x, y in ((a, b), (b, c), (c, a)))
        corners = np.concatenate(
            [
                np.stack(each, axis=1)
                for each in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
            ]
        )
        flat = np.round(corners.reshape(-1, 3), 9)
        vertices, faces = np.unique(flat, axis=0, return_inverse=True)
        faces = faces.reshape(-1, 3)
    return vertices, faces


def _between(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    middle = first + second
    return middle / np.linalg.norm(middle, axis=1, keepdims=True)
