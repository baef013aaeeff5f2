"""Light by next-event: emitters chosen and asked for what they send to a surface, straight and over plane mirrors.

Scattered rays find the same light, so both are joined by the power heuristic with exponent two (E. Veach, 1997, ch. 9).
"""

import drjit as dr
import mitsuba as mi

from ...luminaires.emitters.plugins import SUNS_ONLY
from ..compiled import mirrors
from ..compiled.compile import CompiledScene
from .visibility import closest_hit, transmittance


def sample_emitter(scene: CompiledScene, si, sample, active, over_mirrors=False):
    """Choose a direction to an emitter.

    Parameters
    ----------
    over_mirrors : bool    Whether the surface is an image of one in mirrors: not all of the surroundings may count then.

    Returns
    -------
    (DirectionSample3f, Spectrum)    ``pdf`` includes the choice of the emitter; the value is radiance / pdf, unoccluded.
    """
    return sample_numbered_emitter(scene, si, sample, active, over_mirrors)[1:]


def sample_numbered_emitter(scene: CompiledScene, si, sample, active, over_mirrors=False):
    """As `sample_emitter`, with the number of the emitter among the lights first."""
    index, share, remainder = scene.lights.sample(sample.x, si.p)
    at = dr.zeros(mi.Interaction3f)
    at.p, at.n, at.wavelengths = si.p, si.n, si.wavelengths
    at.time = scene.lights.row(index)
    if over_mirrors and scene.mirrors.are_panes:
        at.time = dr.select(scene.lights.is_outside(index), SUNS_ONLY, at.time)
    pointer = scene.lights.pointer(index)
    ds, value = pointer.sample_direction(at, mi.Point2f(remainder, sample.y), active)
    ds.pdf *= share
    if scene.near is not None:
        value = dr.select(scene.near.has(index, si.p, active), 0.0, value)
    return index, ds, value / share


def respond_by(bsdf, si):
    """Return how a surface answers light, for `next_event` and the like."""

    def respond(direction, asked):
        return bsdf.eval_pdf(mi.BSDFContext(), si, si.to_local(direction), asked)

    return respond


def next_event(scene: CompiledScene, si, sample, respond, active, ratio=1.0):
    """One-sample estimate of the light from lamps in straight view.

    Parameters
    ----------
    respond : callable
        Given a direction and which lanes ask: the response of the surface, cosine included, and the density with which
        it would have scattered that way.
    ratio : Float    Such samples for every scattered ray.

    Returns
    -------
    Spectrum    Response times radiance, weighed against scattered rays that meet the lamp.
    """
    ds, value = sample_emitter(scene, si, sample, active)
    lit = active & (ds.pdf > 0.0) & dr.any(value != 0.0)
    response, response_pdf = respond(ds.d, lit)
    weight = dr.select(ds.delta, 1.0, power_heuristic(ds.pdf * ratio, response_pdf))
    amount = response * value * weight
    lit &= dr.any(amount != 0.0)
    return dr.select(lit, amount * transmittance(scene, si, ds, lit), 0.0)


def mirrored_light(scene: CompiledScene, si, sample, stream, respond, active, limit=None):
    """One-sample estimate of the light that comes over plane mirrors.

    Parameters
    ----------
    respond : callable    As of `next_event`.
    limit : UInt32 or None    Most mirrors.

    Returns
    -------
    Spectrum    Response times radiance, weighed against scattered rays.
    """
    planes = scene.mirrors
    length = planes.length(stream.next_float32())
    if limit is not None:
        # Not in place: the caller's lanes stay as they are.
        active = active & (length <= limit)
    numbers = mi.PCG32(stream)
    image, turn, chance = planes.image(si.p, numbers, length, active)
    at = mi.Interaction3f(si)
    at.p = image
    ds, value = sample_emitter(scene, at, sample, active, over_mirrors=True)
    chance = planes.probability(length, chance)
    direction = turn.T @ ds.d
    response, response_pdf = respond(direction, active)
    density = ds.pdf * chance
    weight = dr.select(ds.delta, 1.0, power_heuristic(density, response_pdf))
    amount = response * value * (weight / chance)
    lit = active & (ds.pdf > 0.0) & dr.any(amount != 0.0)
    last, onwards, polar, reflectance, met = mirrors.walk(
        scene, si, direction, numbers, length, closest_hit, lit
    )
    # A light behind the last pane is not seen in it.
    met &= dr.dot(onwards, ds.p - last.p) > 0.0
    passed = transmittance(scene, last, ds, met, polar)
    return dr.select(met, amount * reflectance * passed, 0.0)


def emitter_density(scene: CompiledScene, reference, si, emitter, active):
    """Solid-angle density with which next-event from ``reference`` would have found this emitting point."""
    ds = dr.zeros(mi.DirectionSample3f)
    ds.p, ds.n, ds.uv = si.p, si.n, si.uv
    ds.d = si.p - reference.p
    ds.dist = dr.norm(ds.d)
    ds.d = dr.select(ds.dist > 0.0, ds.d / ds.dist, mi.Vector3f(0, 0, 1))
    # Which luminaire it is, if it is one, travels as the time.
    reference.time = si.time
    density = emitter.pdf_direction(reference, ds, active)
    return density * scene.lights.probability(emitter, reference.p, active, si.time)


def surroundings_density(scene: CompiledScene, reference, direction, active, is_mirrored=None):
    """As `emitter_density`, for light from infinity. ``is_mirrored``: whether the reference is an image in mirrors."""
    if is_mirrored is not None and scene.mirrors.are_panes:
        reference.time = dr.select(is_mirrored, SUNS_ONLY, 0.0)
    ds = dr.zeros(mi.DirectionSample3f)
    ds.d = direction
    density = scene.surroundings.pdf_direction(reference, ds, active)
    return density * scene.lights.probability(
        mi.EmitterPtr(scene.surroundings), reference.p, active
    )


def power_heuristic(pdf, other):
    """Weight of a sample drawn with density ``pdf`` that the density ``other`` would have found too."""
    # By the ratio: squares of densities overflow for tiny lights far away.
    return dr.select(pdf > 0.0, dr.rcp(1.0 + dr.square(other / pdf)), 0.0)
