"""Choice of the emitter for next-event estimation."""

import drjit as dr
import mitsuba as mi
import numpy as np

PILOT_POINTS = 1024
"""Points at which the lights are compared before a job."""

PILOT_LANES = 1 << 18
"""Shadow rays spent on the comparison, so that each point is asked several times about each light."""

EVEN_SHARE = 0.1
"""Share of choices made evenly, so that no light is forgotten where only it counts."""


class LightTable:
    """Chooses one of the scene's emitters with fixed probabilities.

    At first in proportion to flux; `learn` replaces this by what arrives at the points that a job looks at, so that a
    sky of enormous flux outside a small window does not draw away the samples from the lamps inside.
    """

    def __init__(self, emitters: list, fluxes: list[float]):
        self.count = len(emitters)
        if not emitters:
            return
        self._ids = np.array([dr.reinterpret_array(mi.UInt32, mi.EmitterPtr(e))[0] for e in emitters])
        self._pointers = mi.UInt32(self._ids.astype(np.uint32))
        self.set_weights(np.asarray(fluxes, dtype=np.float64), even=0.5)

    def set_weights(self, weights: np.ndarray, even: float = EVEN_SHARE) -> None:
        """Choose in proportion to ``weights`` (n,), but for a share of ``even`` choices."""
        shares = np.full(self.count, 1.0 / self.count)
        if weights.sum() > 0.0:
            shares = even * shares + (1.0 - even) * weights / weights.sum()
        by_id = np.zeros(int(self._ids.max()) + 1)
        by_id[self._ids] = shares
        self.shares = shares
        self._cdf = mi.Float(np.cumsum(shares).astype(np.float32))
        self._share = mi.Float(shares.astype(np.float32))
        self._share_by_id = mi.Float(by_id.astype(np.float32))
        dr.eval(self._pointers, self._cdf, self._share, self._share_by_id)

    def pointer(self, index):
        """Return the emitter with a number."""
        return dr.reinterpret_array(mi.EmitterPtr, dr.gather(mi.UInt32, self._pointers, index))

    def sample(self, u):
        """Return an emitter pointer, its probability and the stretched remainder of ``u``."""
        index = dr.binary_search(
            0, self.count - 1, lambda i: dr.gather(mi.Float, self._cdf, i) <= u
        )
        share = dr.gather(mi.Float, self._share, index)
        start = dr.gather(mi.Float, self._cdf, index) - share
        return self.pointer(index), share, dr.clip((u - start) / share, 0.0, 0.9999999)

    def probability(self, pointer, active):
        """Probability of choosing an emitter."""
        ids = dr.reinterpret_array(mi.UInt32, pointer)
        return dr.gather(mi.Float, self._share_by_id, ids, active & (ids < len(self._share_by_id)))


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
        mi.warp.square_to_cosine_hemisphere(mi.Point2f(stream.next_float32(), stream.next_float32()))
    )
    hit = scene.solid.ray_intersect(near.spawn_ray(away))
    facing = hit.n * dr.select(dr.dot(hit.n, away) < 0.0, 1.0, -1.0)
    far = _surface(hit.p, facing)
    weights = np.zeros(scene.lights.count)
    for si, active in ((near, mi.Bool(True)), (far, hit.is_valid())):
        arriving = _arriving(scene, si, active, wavelengths)
        # Shares of each point's own light: a bright place outside counts no more than a dim one inside.
        total = arriving.sum(axis=1, keepdims=True)
        weights += (arriving / np.where(total > 0.0, total, 1.0)).sum(axis=0)
    scene.lights.set_weights(weights)


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
