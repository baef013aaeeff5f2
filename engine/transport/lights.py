"""Choice of the emitter for next-event estimation."""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

PILOT_POINTS = 1024
"""Points at which the lights are compared before a job."""

PILOT_LANES = 1 << 18
"""Shadow rays spent on the comparison, so that each point is asked several times about each light."""

EVEN_SHARE = 0.1
"""Share of choices made evenly, so that no light is forgotten where only it counts."""

LOCAL_LIMIT = 32
"""Up to this many lights, each point weighs all of them by distance; beyond, one choice serves all points."""


@dataclass(frozen=True)
class Place:
    """Where an emitter is, roughly: ``centre`` (3,) in the scene's frame and ``radius`` [m]; None: at infinity.

    ``axis`` (3,) is the direction to which a flat one-sided emitter shines; nothing behind it is lit.
    """

    centre: np.ndarray | None
    radius: float = 0.0
    axis: np.ndarray | None = None


class LightTable:
    """Chooses one of the scene's emitters.

    The probability at a point is proportional to strength / (distance^2 + radius^2); light from infinity counts by the
    rough solid angle of the portals, or evenly without any. Next to a desk lamp the desk lamp counts, across the room the
    ceiling. Strengths are fluxes at first; `learn` replaces them by what arrives at the points that a job looks at, shadows
    included, so that a sky of enormous flux outside a small window does not draw the samples from the lamps inside.
    """

    def __init__(
        self, emitters: list, fluxes: list[float], places: list[Place], reach: float, portals=None
    ):
        self.count = len(emitters)
        self.portals = portals
        if not emitters:
            return
        ids = np.array([dr.reinterpret_array(mi.UInt32, mi.EmitterPtr(e))[0] for e in emitters])
        number = np.full(int(ids.max()) + 1, 0)
        number[ids] = np.arange(self.count)
        self._pointers = mi.UInt32(ids.astype(np.uint32))
        self._number = mi.UInt32(number.astype(np.uint32))
        self.is_local = self.count <= LOCAL_LIMIT
        self.places = places
        kernels = [1.0 if p.centre is None else 1.0 / (reach**2 + p.radius**2) for p in places]
        self.set_strengths(np.asarray(fluxes) / reach**2, kernels)

    def set_strengths(self, arriving: np.ndarray, kernels) -> None:
        """Set strengths from light that arrives (n,) where the distance kernels have the values ``kernels`` (n,)."""
        arriving = np.asarray(arriving, dtype=np.float64)
        if not arriving.sum() > 0.0:
            arriving = np.ones(self.count)
        arriving = arriving / arriving.sum()
        strengths = arriving / np.maximum(kernels, 1e-30)
        shares = EVEN_SHARE / self.count + (1.0 - EVEN_SHARE) * arriving
        self._strength = mi.Float(strengths.astype(np.float32))
        self._cdf = mi.Float(np.cumsum(shares).astype(np.float32))
        self._share = mi.Float(shares.astype(np.float32))
        dr.eval(self._pointers, self._number, self._strength, self._cdf, self._share)

    def kernels(self, points: np.ndarray) -> np.ndarray:
        """Distance kernels of all lights at points (k, 3), shape (k, n). [1/m2, 1 for light from infinity]"""
        made = np.ones((len(points), self.count))
        for i, place in enumerate(self.places):
            if place.centre is None:
                if self.portals is not None:
                    made[:, i] = self.portals.openness_of(points)
            else:
                away = points - place.centre
                squared = (away**2).sum(axis=1) + max(place.radius, 1e-3) ** 2
                made[:, i] = 1.0 / squared
                if place.axis is not None:
                    height = np.maximum(away @ place.axis, 1e-9)
                    rise = height + np.minimum(height, place.radius)
                    made[:, i] *= np.minimum(rise / np.sqrt(squared), 1.0)
        return made

    def pointer(self, index):
        """Return the emitter with a number."""
        return dr.reinterpret_array(mi.EmitterPtr, dr.gather(mi.UInt32, self._pointers, index))

    def sample(self, u, point):
        """Return an emitter pointer, its probability at a point, and the stretched remainder of ``u``."""
        if not self.is_local:
            index = dr.binary_search(
                0, self.count - 1, lambda i: dr.gather(mi.Float, self._cdf, i) <= u
            )
            share = dr.gather(mi.Float, self._share, index)
            start = dr.gather(mi.Float, self._cdf, index) - share
        else:
            index, share, start = mi.UInt32(0), mi.Float(1.0), mi.Float(0.0)
            running = mi.Float(0.0)
            for i, value in enumerate(self._local_shares(point)):
                chosen = u >= running
                index = dr.select(chosen, mi.UInt32(i), index)
                share = dr.select(chosen, value, share)
                start = dr.select(chosen, running, start)
                running = running + value
        return self.pointer(index), share, dr.clip((u - start) / share, 0.0, 0.9999999)

    def probability(self, pointer, point, active):
        """Probability of choosing an emitter at a point."""
        if self.count == 0:
            return mi.Float(0.0)
        ids = dr.reinterpret_array(mi.UInt32, pointer)
        known = active & (ids < dr.width(self._number))
        index = dr.gather(mi.UInt32, self._number, ids, known)
        if not self.is_local:
            return dr.gather(mi.Float, self._share, index, known)
        probability = mi.Float(0.0)
        for i, value in enumerate(self._local_shares(point)):
            probability = dr.select(known & (index == i), value, probability)
        return probability

    def _local_shares(self, point) -> list:
        """Probabilities of all lights at a point."""
        if self.count == 1:
            return [mi.Float(1.0)]
        weights = []
        for i, place in enumerate(self.places):
            weight = dr.gather(mi.Float, self._strength, mi.UInt32(i))
            if place.centre is None:
                if self.portals is not None:
                    weight = weight * self.portals.openness(point)
            else:
                away = point - mi.Point3f(*map(float, place.centre))
                squared = dr.squared_norm(away) + max(place.radius, 1e-3) ** 2
                weight = weight / squared
                if place.axis is not None:
                    # The cosine at the emitter, at most that of its nearest part.
                    height = dr.maximum(dr.dot(away, mi.Vector3f(*map(float, place.axis))), 0.0)
                    rise = height + dr.minimum(height, place.radius)
                    weight = weight * dr.minimum(rise * dr.rsqrt(squared), 1.0)
            weights.append(weight)
        total = sum(weights[1:], weights[0])
        total = dr.maximum(total, 1e-30)
        shares = [(1.0 - EVEN_SHARE) * w / total for w in weights]
        # Whatever is missing to 1 (all of it where no light shines) is spread evenly.
        rest = (1.0 - sum(shares[1:], shares[0])) / self.count
        return [share + rest for share in shares]


def learn(scene, points, normals, wavelengths) -> None:
    """Set the probabilities by the illuminance that each light gives at a job's points and one bounce further.

    The choice is made once from a fixed seed and does not depend on the job's own samples, so estimates stay unbiased.

    Parameters
    ----------
    scene : CompiledScene
    points, normals : (k, 3) float32 array    In the compiled scene's frame.
    wavelengths : Spectrum or None    Four wavelengths that stand for the visible range.
    """
    if scene.lights.count < 2 or len(points) == 0:
        return
    chosen = np.random.default_rng(1).integers(0, len(points), PILOT_POINTS)
    near = _surface(mi.Point3f(*_columns(points[chosen])), mi.Normal3f(*_columns(normals[chosen])))
    stream = mi.PCG32(size=PILOT_POINTS, initstate=7)
    away = near.to_world(
        mi.warp.square_to_cosine_hemisphere(
            mi.Point2f(stream.next_float32(), stream.next_float32())
        )
    )
    hit = scene.solid.ray_intersect(near.spawn_ray(away))
    facing = hit.n * dr.select(dr.dot(hit.n, away) < 0.0, 1.0, -1.0)
    far = _surface(hit.p, facing)
    logarithms, found, kernels = [], [], []
    for si, active in ((near, mi.Bool(True)), (far, hit.is_valid())):
        arriving = _arriving(scene, si, active, wavelengths)
        seen = arriving > 0.0
        logarithms.append(np.where(seen, np.log(np.where(seen, arriving, 1.0)), 0.0))
        found.append(seen)
        place = np.stack([np.array(c) for c in si.p], axis=1)
        kernels.append(np.log(scene.lights.kernels(np.nan_to_num(place, posinf=0.0, neginf=0.0))))
    found = np.concatenate(found)
    times = np.maximum(found.sum(axis=0), 1)
    # Geometric means over the points that a light reaches: a few bright places must not stand for all.
    level = np.exp((np.concatenate(logarithms) * found).sum(axis=0) / times) * found.mean(axis=0)
    kernel = np.exp((np.concatenate(kernels) * found).sum(axis=0) / times)
    scene.lights.set_strengths(level, kernel)


def _columns(array):
    return [mi.Float(np.ascontiguousarray(array[:, i], dtype=np.float32)) for i in range(3)]


def _surface(point, normal):
    si = dr.zeros(mi.SurfaceInteraction3f, PILOT_POINTS)
    si.p, si.n, si.sh_frame = point, normal, mi.Frame3f(normal)
    return si


def _arriving(scene, si, active, wavelengths) -> np.ndarray:
    """Illuminance that each light gives at each point, shadows included, up to a factor. (points, lights)"""
    from .paths import transmittance

    count = scene.lights.count
    repeats = int(np.clip(PILOT_LANES // (PILOT_POINTS * count), 1, 64))
    lane = dr.arange(mi.UInt32, PILOT_POINTS * count * repeats)
    light = (lane // repeats) % count
    point = lane // (repeats * count)
    at = dr.gather(mi.SurfaceInteraction3f, si, point)
    active = dr.gather(mi.Bool, dr.select(active, True, dr.zeros(mi.Bool, PILOT_POINTS)), point)
    if wavelengths is not None:
        at.wavelengths = wavelengths
    stream = mi.PCG32(size=dr.width(lane), initstate=11)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    ds, value = scene.lights.pointer(light).sample_direction(at, sample, active)
    cosine = dr.maximum(dr.dot(ds.d, at.n), 0.0)
    lit = active & (ds.pdf > 0.0) & (cosine > 0.0)
    amount = dr.mean(value * transmittance(scene, at, ds.p, lit)) * cosine
    amount = dr.select(lit & dr.isfinite(amount), amount, 0.0)
    sums = dr.block_reduce(dr.ReduceOp.Add, amount, repeats)
    return np.array(sums, dtype=np.float64).reshape(PILOT_POINTS, count)
