"""Small squares in the air about sensors that count the light that crosses them, and gather it for comparison.

Light from the lights passes a sensor's point never, but a square about it often enough. What it brings there is compared
with what gathering finds on the very same square, so that its size makes no difference. Squares are cut to what can be seen
from the sensor, cell by cell: what reaches behind a wall is left out on both ways.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...scene.sensor import SensorKind
from ..paths.illuminance import SNAP_DISTANCE, Receivers
from .sums import Sums

SIDE = 16
"""Cells across a square."""

PLACES, MOST_PLACES = 64, 1 << 20
"""Places of gathering in each cell, and most of them in all. They are the same for all samples, whose scatter knows nothing
of what a shadow's edge between them does."""

LARGEST, SMALLEST = 0.05, 1e-4
"""Half the side of the largest and the smallest square, relative to the scene's radius."""

OPEN_SHARE = 0.4
"""Share of a square that has to be seen from its sensor, else it is made smaller."""

LIFT = 2e-3
"""How far a square lies before its sensor, relative to half its side: sensors may lie on surfaces."""

MOST = 48
"""Squares at most; they stand for the other sensors."""

LOOKS = 64
"""Rays from each square that tell how far its surroundings are."""

RESPONSES = {
    SensorKind.SPHERICAL: 0.25,
    SensorKind.CYLINDRICAL: 1.0 / np.pi,
    SensorKind.SEMICYLINDRICAL: 2.0 / np.pi,
}
"""Largest response of sensors that are no planes: so much of what misses on all sides of a cube they miss at most."""


@dataclass(frozen=True)
class Squares:
    """Where squares are: sensor (k,), centre, normal and two axes (k, 3) in the scene's frame, half side (k,) [m]."""

    sensor: np.ndarray
    centre: np.ndarray
    normal: np.ndarray
    along: np.ndarray
    across: np.ndarray
    half: np.ndarray
    is_open: np.ndarray

    @property
    def area(self) -> np.ndarray:
        """Of the cells that are seen. (k,) [m2]"""
        cell = (2.0 * self.half / SIDE) ** 2
        return cell * self.is_open.sum(axis=1)


class Sheets:
    """Squares about sensors.

    Parameters
    ----------
    scene : CompiledScene
    positions, normals : (n, 3) array    In the world. [m]
    kind : SensorKind

    Attributes
    ----------
    response : float    Largest response of a sensor.
    faces : int    Squares about each.
    """

    def __init__(self, scene, positions, normals, kind: SensorKind = SensorKind.PLANAR):
        self._scene = scene
        points = scene.local(np.asarray(positions, dtype=np.float64)).astype(np.float64)
        if kind is SensorKind.PLANAR:
            facing = np.asarray(normals, dtype=np.float64)
            facing = (facing / np.linalg.norm(facing, axis=1, keepdims=True))[:, None]
        else:
            six = np.concatenate([np.eye(3), -np.eye(3)])
            facing = np.broadcast_to(six, (len(points), 6, 3))
        each = facing.shape[1]
        count = max(min(len(points), MOST // each), 1)
        chosen = np.unique(np.linspace(0, len(points) - 1, count).round().astype(int))
        repeated = np.repeat(chosen, each)
        made = _lay(repeated, points[repeated], facing[chosen].reshape(-1, 3))
        self.squares = _fit(scene, made)
        self.response, self.faces = RESPONSES.get(kind, 1.0), each

    def __len__(self) -> int:
        return len(self.squares.half)

    def prepare(self, batches: int, flux: float) -> None:
        """Put everything onto the device, with counters at 0. ``flux``: about that of all lights [lm]."""
        q = self.squares
        inverse = 1.0 / q.half[:, None]
        # Each of the four with a number behind it: rows of a power of two are loaded at once.
        planes = np.stack([q.normal, q.along * inverse, q.across * inverse], axis=1)
        offsets = np.einsum("kix,kx->ki", planes, q.centre)
        rows = np.concatenate([planes, offsets[..., None]], axis=2)
        rows = np.concatenate([rows, np.zeros((len(rows), 1, 4))], axis=1)
        self._rows = upload(mi.Float, rows)
        self._open = upload(mi.Bool, q.is_open)
        self._many = dr.opaque(mi.UInt32, len(self))
        self._batches = batches
        self.flux = Sums(len(self) * batches, flux)
        dr.eval(self._rows, self._open)

    def count(self, ray, way, amount, batch, active, chance, watcher, facts):
        """Count what crosses on its way [m]; returns all that every path brought. ``chance``: as of `Sums.quanta`. [lm]"""
        start, count = mi.Vector3f(ray.o), self.flux.quanta(amount, chance)

        def step(k, brought):
            normal, along, across = (
                dr.gather(mi.Vector4f, self._rows, k * 4 + i) for i in range(3)
            )
            slope = dr.dot(ray.d, normal.xyz)
            t = (normal.w - dr.dot(start, normal.xyz)) / dr.select(slope == 0.0, 1.0, slope)
            at = start + ray.d * t
            x = (dr.dot(at, along.xyz) - along.w + 1.0) * (0.5 * SIDE)
            y = (dr.dot(at, across.xyz) - across.w + 1.0) * (0.5 * SIDE)
            met = active & (slope < 0.0) & (t > 0.0) & (t < way)
            met &= (x >= 0.0) & (x < SIDE) & (y >= 0.0) & (y < SIDE)
            cell = mi.UInt32(dr.select(met, y, 0.0)) * SIDE + mi.UInt32(dr.select(met, x, 0.0))
            met &= dr.gather(mi.Bool, self._open, k * (SIDE * SIDE) + cell, met)
            place = k * mi.UInt32(self._batches) + batch
            self.flux.add_quanta(count, place, met)
            if watcher is not None:
                watcher.see_sheet(k, amount, *facts, met)
            return k + 1, dr.select(met, brought + amount, brought)

        _, brought = dr.while_loop(
            state=(mi.UInt32(0), mi.Float(0.0)),
            cond=lambda k, brought: active & (k < self._many),
            body=step,
            labels=("sheet", "brought"),
        )
        return brought

    def view_distance(self) -> float:
        """Median distance of what the squares see; 0 where they see nothing. [m]"""
        q, draw = self.squares, np.random.default_rng(8)
        away = draw.normal(size=(len(self), LOOKS, 3))
        away /= np.linalg.norm(away, axis=2, keepdims=True)
        away *= np.sign(np.einsum("klx,kx->kl", away, q.normal))[..., None]
        starts = np.broadcast_to(q.centre[:, None], away.shape)
        hit = self._scene.solid.ray_intersect_preliminary(
            _rays(starts, away), mi.Bool(False), mi.Bool(True)
        )
        way = np.array(hit.t)
        way = way[np.isfinite(way)]
        return float(np.median(way)) if len(way) else 0.0

    def receivers(self, seed: int) -> Receivers:
        """Places all over the squares, in the world."""
        q, draw = self.squares, np.random.default_rng([seed & 0xFFFFFFFF, 6])
        positions, counts = [], []
        each = int(np.clip(MOST_PLACES // max(len(self) * SIDE * SIDE, 1), 1, PLACES))
        for k in range(len(self)):
            cells = np.repeat(np.flatnonzero(q.is_open[k]), each)
            place = np.stack([cells % SIDE, cells // SIDE], axis=1) + draw.random((len(cells), 2))
            place = (place * (2.0 / SIDE) - 1.0) * q.half[k]
            spread = place[:, :1] * q.along[k] + place[:, 1:] * q.across[k]
            positions.append(q.centre[k] + spread + self._scene.origin)
            counts.append(len(cells))
        counts = np.array(counts, dtype=np.int64)
        normals = np.repeat(q.normal, counts, axis=0)
        starts = np.cumsum(counts) - counts
        return Receivers(np.concatenate(positions), normals, normals, starts, counts, q.area)


def _lay(sensor, points, normals) -> Squares:
    """Squares without a size yet."""
    helper = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    along = np.cross(helper, normals)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return Squares(
        sensor, points, normals, along, np.cross(normals, along), np.zeros(len(points)),
        np.zeros((len(points), SIDE * SIDE), dtype=bool),
    )  # fmt: skip


def _fit(scene, made: Squares) -> Squares:
    """Make squares as large as enough of them is seen from their sensors; leaves out those that stand in nothing."""
    size = LARGEST * scene.radius
    half = np.full(len(made.half), size)
    centre, is_open = made.centre.copy(), made.is_open.copy()
    todo = np.arange(len(half))
    while len(todo) and half[todo[0]] >= SMALLEST * scene.radius:
        lift = LIFT * half[todo] + 2.0 * SNAP_DISTANCE * min(scene.radius, 1.0)
        centre[todo] = made.centre[todo] + made.normal[todo] * lift[:, None]
        is_open[todo] = _seen(scene, centre[todo], made.along[todo], made.across[todo], half[todo])
        todo = todo[is_open[todo].mean(axis=1) < OPEN_SHARE]
        half[todo] *= 0.5
    kept = np.setdiff1d(np.arange(len(half)), todo)
    return Squares(
        made.sensor[kept], centre[kept], made.normal[kept], made.along[kept], made.across[kept],
        half[kept], is_open[kept],
    )  # fmt: skip


def _seen(scene, centre, along, across, half) -> np.ndarray:
    """Which cells lie open before the centres with all of their corners. (k, SIDE * SIDE)"""
    edges = np.arange(SIDE + 1) * (2.0 / SIDE) - 1.0
    y, x = (m.ravel() for m in np.meshgrid(edges, edges, indexing="ij"))
    spread = x[:, None] * along[:, None] + y[:, None] * across[:, None]
    ends = centre[:, None] + spread * half[:, None, None]
    starts = np.broadcast_to(centre[:, None], ends.shape)
    away = ends - starts
    # The middle corner is the centre itself, and a ray needs a direction.
    away[:, len(edges) ** 2 // 2] = along * (1e-6 * half[:, None])
    ray = _rays(starts, away)
    # Lengths are told by the direction: what stands at 1 stands at the corner itself.
    ray.maxt = mi.Float(1.001)
    lies = np.array(~scene.solid.ray_test(ray, mi.Bool(True))).reshape(-1, SIDE + 1, SIDE + 1)
    whole = lies[:, 1:, 1:] & lies[:, :-1, 1:] & lies[:, 1:, :-1] & lies[:, :-1, :-1]
    return whole.reshape(len(centre), -1)


def _rays(starts: np.ndarray, away: np.ndarray):
    """Rays from points along vectors, of any shape (..., 3)."""
    columns = [upload(mi.Float, v.reshape(-1, 3)[:, i]) for v in (starts, away) for i in range(3)]
    return mi.Ray3f(mi.Point3f(*columns[:3]), mi.Vector3f(*columns[3:]))
