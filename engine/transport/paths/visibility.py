"""What a ray meets first, and how much light goes straight from one point to another."""

import drjit as dr
import mitsuba as mi

from ..compiled.polarisation import polarise
from ..rays import spawn_ray_to, spawn_straight

SAME_PLACE = 1.0 + 2.0**-20
"""Relative distance up to which what is there for the camera alone hides what light meets at the same place."""

MOST_PASSES = 1000
"""Most surfaces that light goes straight through; reached by no valid scene."""


def meet(scene, ray, active, coherent=False, looks=None, passes_veil=False):
    """Find what a ray meets first.

    Parameters
    ----------
    scene : CompiledScene
    ray : Ray3f
    active : Bool
    coherent : bool    Whether neighbouring lanes have similar rays.
    looks : Bool or None    Which rays also meet what is there for the camera alone; None: none.
    passes_veil : bool    Whether rays pass what light may pass straight.

    Returns
    -------
    (PreliminaryIntersection3f, SurfaceInteraction3f)    The hit and the surface there.
    """
    hit = scene.solid.ray_intersect_preliminary(ray, mi.Bool(coherent), active)
    if scene.transparent is not None and not passes_veil:
        other = scene.transparent.ray_intersect_preliminary(ray, mi.Bool(coherent), active)
        hit = dr.select(other.t < hit.t, other, hit)
    if scene.shown is not None and looks is not None:
        other = scene.shown.ray_intersect_preliminary(ray, mi.Bool(coherent), active & looks)
        nearer = other.is_valid() & (other.t <= hit.t * SAME_PLACE)
        hit = dr.select(nearer, other, hit)
    return hit, scene.surface(hit, ray, active)


def closest_hit(scene, ray, active, **more):
    """Return the nearest surface on a ray; parameters as of `meet`."""
    return meet(scene, ray, active, **more)[1]


def first_ground(scene, ray, active):
    """Find the first ground on a ray that only the camera meets.

    Returns
    -------
    (PreliminaryIntersection3f, Float)    The hit, none where there is no ground, and the distance to it. [m]
    """

    def step(ray, hit, way, going):
        hit = scene.shown.ray_intersect_preliminary(ray, mi.Bool(False), going)
        si = scene.surface(hit, ray, going)
        way = dr.select(going, way + hit.t, way)
        going &= si.is_valid()
        going &= ~dr.gather(
            mi.Bool, scene.grounds, dr.reinterpret_array(mi.UInt32, si.shape), going
        )
        return dr.select(going, spawn_straight(scene, si, ray), ray), hit, way, going

    hit = dr.zeros(mi.PreliminaryIntersection3f)
    hit.t = dr.inf
    _, hit, way, _ = dr.while_loop(
        state=(mi.Ray3f(ray), hit, mi.Float(0.0), mi.Bool(active)),
        cond=lambda ray, hit, way, going: going,
        body=step,
        labels=("ray", "hit", "way", "going"),
    )
    return hit, dr.select(hit.is_valid(), way, dr.inf)


def first_seen(scene, ray, active, coherent=False, passes_veil=False):
    """Return the nearest surface on a ray of the camera that it sees; parameters as of `meet`."""
    looks = mi.Bool(True)
    hides = scene.has_hidden_objects if passes_veil else scene.hidden is not None
    if hides:

        def step(ray, going):
            si = closest_hit(scene, ray, going, looks=looks, passes_veil=passes_veil)
            going = going & si.is_valid()
            number = dr.reinterpret_array(mi.UInt32, si.shape)
            going &= dr.gather(mi.Bool, scene.hidden, number, going)
            return dr.select(going, spawn_straight(scene, si, ray), ray), going

        ray, _ = dr.while_loop(
            state=(mi.Ray3f(ray), mi.Bool(active)),
            cond=lambda ray, going: going,
            body=step,
            labels=("ray", "going"),
        )
    return closest_hit(scene, ray, active, coherent=coherent, looks=looks, passes_veil=passes_veil)


def transmittance(scene, origin, target, active, polar=None):
    """Share of light that goes straight from one point to another.

    Parameters
    ----------
    origin : SurfaceInteraction3f    Where the ray starts; the ray is offset from its surface.
    target : PositionSample3f    Where it ends, excluded: point and normal.
    polar : Vector3f or None    Polarisation of the ray, see `polarisation`; None: it has none.

    Returns
    -------
    Spectrum    0 where something solid stands between.
    """
    ray = spawn_ray_to(scene, origin, target.p, target.n)
    lit = active & ~scene.solid.ray_test(ray, active)
    if scene.transparent is None:
        return dr.select(lit, mi.Spectrum(1.0), 0.0)

    value = dr.select(lit, mi.Spectrum(1.0), 0.0)
    ray = mi.Ray3f(ray)
    steps = mi.UInt32(0)
    polar = mi.Vector3f(0.0) if polar is None else mi.Vector3f(polar)

    def step(value, ray, lit, steps, polar):
        si = scene.transparent.ray_intersect(ray, lit)
        lit &= si.is_valid()
        factor, polar = polarise(scene, si, ray.d, ray.d, polar, mi.Bool(False), lit)
        value[lit] = value * scene.bsdf(si, lit).eval_null_transmission(si, lit) * factor
        ray = dr.select(lit, spawn_ray_to(scene, si, target.p, target.n), ray)
        lit &= dr.any(value != 0.0)
        steps += 1
        return value, ray, lit & (steps < MOST_PASSES), steps, polar

    result = dr.while_loop(
        state=(value, ray, mi.Bool(lit), steps, polar),
        cond=lambda value, ray, lit, steps, polar: lit,
        body=step,
        labels=("value", "ray", "lit", "steps", "polar"),
    )
    return result[0]
