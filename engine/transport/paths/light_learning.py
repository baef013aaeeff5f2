"""How much each light gives where a job looks: asked of a few points before it, for the choice of lights by next-event."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...luminaires.emitters.distribution_arrays import FLOOR
from ..compiled.light_tree import PRIOR_DRAWS, TINY
from ..rays import spawn_ray
from .visibility import transmittance

PILOT_POINTS = 1024
"""Points at which the lights are compared before a job."""

PILOT_LANES = 1 << 18
"""Shadow rays spent on the comparison, so that each point is asked several times about each light."""

FEWEST_POINTS = 4
"""With fewer points in its beam, a luminaire's strength follows from its flux."""

MOST_DRAWS = 64
"""Lights that a pilot point draws from the tree where there is one."""

LEAST_RATIO = 0.02
"""Share of the mean ratio of what arrives to what was expected below which no light's is taken to lie: a light that no
pilot point sees may count all the same at some other point."""


def learn(scene, points, normals, wavelengths, lanes: int = PILOT_LANES) -> None:
    """Set the probabilities by the illuminance that each light gives at a job's points and one bounce further.

    The choice is made once from a fixed seed and does not depend on the job's own samples, so estimates stay unbiased.

    Parameters
    ----------
    scene : CompiledScene
    points, normals : (k, 3) float32 array    In the compiled scene's frame.
    wavelengths : Spectrum or None    Four wavelengths that stand for the visible range.
    lanes : int    Shadow rays to be spent at most.
    """
    scene.lights.reset()
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
    hit = scene.solid.ray_intersect(spawn_ray(scene, near, away))
    facing = hit.n * dr.select(dr.dot(hit.n, away) < 0.0, 1.0, -1.0)
    far = _surface(hit.p, facing)
    surfaces = ((near, mi.Bool(True)), (far, hit.is_valid()))
    if scene.lights.tree is None:
        _compare_all(scene, surfaces, wavelengths, lanes)
    else:
        _compare_drawn(scene, surfaces, wavelengths, lanes)


def _compare_all(scene, surfaces, wavelengths, lanes) -> None:
    """Ask every point about every light."""
    logarithms, found, kernels, eligible = [], [], [], []
    for si, active in surfaces:
        arriving = _arriving(scene, si, active, wavelengths, lanes)
        place = np.stack([np.array(c) for c in si.p], axis=1)
        place = np.nan_to_num(place, posinf=0.0, neginf=0.0)
        # Beside its beam a luminaire's kernel is only a floor and says nothing about its strength.
        lit = scene.lights.importances(place) > 2.0 * FLOOR
        seen = (arriving > 0.0) & lit
        logarithms.append(np.where(seen, np.log(np.where(seen, arriving, 1.0)), 0.0))
        found.append(seen)
        eligible.append(lit)
        kernels.append(np.log(scene.lights.kernels(place)))
    found, eligible = np.concatenate(found), np.concatenate(eligible)
    times = np.maximum(found.sum(axis=0), 1)
    # Geometric means over the points that a light reaches: a few bright places must not stand for all.
    mean = np.exp((np.concatenate(logarithms) * found).sum(axis=0) / times)
    kernel = np.exp((np.concatenate(kernels) * found).sum(axis=0) / times)
    strengths = mean / kernel * found.sum(axis=0) / np.maximum(eligible.sum(axis=0), 1)
    # Of a beam that no point of the pilot run lies in nothing is known but its flux.
    fluxes = np.array([source.flux for source in scene.lights.sources])
    known, missed = strengths > 0.0, eligible.sum(axis=0) < FEWEST_POINTS
    if known.any():
        strengths[missed] = fluxes[missed] * np.median(strengths[known] / fluxes[known])
    scene.lights.set_strengths(strengths)


def _compare_drawn(scene, surfaces, wavelengths, lanes) -> None:
    """Ask every point about lights that it draws by their fluxes: the cost is the same however many there are."""
    lights = scene.lights
    count, first = lights.count, int(lights.sources[0].centre is None)
    ratios, draws = np.zeros(count), np.zeros(count)
    repeats = 1 << int(np.clip(lanes // PILOT_POINTS, 1, MOST_DRAWS)).bit_length() - 1
    times = dr.opaque(mi.UInt32, repeats)
    for nth, (si, exists) in enumerate(surfaces):
        lane = dr.arange(mi.UInt32, PILOT_POINTS * repeats)
        stream = mi.PCG32(size=PILOT_POINTS * repeats, initstate=dr.opaque(mi.UInt64, 11 + nth))
        at, active = _at(si, exists, lane // times, wavelengths)
        u = (mi.Float(lane % times) + stream.next_float32()) / mi.Float(times)
        light, _, _ = lights.sample(dr.minimum(u, 0.9999999), at.p)
        amount = _amount(scene, at, light, stream, active)
        expected, is_telling = lights.expect(light, at.p)
        ratio = dr.select(expected > 0.0, amount / dr.maximum(expected, TINY), 0.0)
        counts = active & is_telling & dr.isfinite(ratio)
        dr.eval(light, ratio, counts)
        asked = np.array(counts)
        numbers = np.array(light)[asked]
        ratios += np.bincount(numbers, np.array(ratio, dtype=np.float64)[asked], count)
        draws += np.bincount(numbers, minlength=count)
    if not ratios.sum() > 0.0:
        return
    mean = ratios.sum() / draws.sum()
    learned = np.full(count, (ratios[0] + PRIOR_DRAWS * mean) / (draws[0] + PRIOR_DRAWS))
    learned[first:] = lights.tree.smooth(ratios[first:], draws[first:])
    lights.set_strengths(lights.strengths * np.maximum(learned, LEAST_RATIO * mean))


def _columns(array):
    return [upload(mi.Float, array[:, i]) for i in range(3)]


def _surface(point, normal):
    si = dr.zeros(mi.SurfaceInteraction3f, PILOT_POINTS)
    si.p, si.n, si.sh_frame = point, normal, mi.Frame3f(normal)
    return si


def _arriving(scene, si, active, wavelengths, lanes) -> np.ndarray:
    """Illuminance that each light gives at each point, shadows included, up to a factor. (points, lights)"""
    count = scene.lights.count
    # A power of two, since kernels have it in them.
    repeats = 1 << int(np.clip(lanes // (PILOT_POINTS * count), 1, 64)).bit_length() - 1
    lane = dr.arange(mi.UInt32, PILOT_POINTS * count * repeats)
    # Numbers of lights as data, so that one more needs no new kernel.
    many, times = dr.opaque(mi.UInt32, count), dr.opaque(mi.UInt32, repeats)
    light = (lane // times) % many
    point = lane // (times * many)
    at, active = _at(si, active, point, wavelengths)
    stream = mi.PCG32(size=dr.width(lane), initstate=11)
    amount = _amount(scene, at, light, stream, active)
    sums = dr.block_reduce(dr.ReduceOp.Add, amount, repeats)
    return np.array(sums, dtype=np.float64).reshape(PILOT_POINTS, count)


def _at(si, active, point, wavelengths):
    """Surfaces of pilot points by their numbers, and which of them are asked."""
    at = dr.gather(mi.SurfaceInteraction3f, si, point)
    if wavelengths is not None:
        at.wavelengths = wavelengths
    return at, dr.gather(mi.Bool, dr.select(active, True, dr.zeros(mi.Bool, PILOT_POINTS)), point)


def _amount(scene, at, light, stream, active):
    """One-sample estimate of the illuminance that a light gives, shadows included, up to a factor."""
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    at.time = scene.lights.row(light)
    ds, value = scene.lights.pointer(light).sample_direction(at, sample, active)
    cosine = dr.maximum(dr.dot(ds.d, at.n), 0.0)
    lit = active & (ds.pdf > 0.0) & (cosine > 0.0)
    # A sum, since a mean has the number of lanes in its kernel.
    amount = dr.sum(value * transmittance(scene, at, ds, lit)) * cosine
    return dr.select(lit & dr.isfinite(amount), amount, 0.0)
