"""Light that bright spots send on: rays from a surface to a spot, and next-event there."""

import drjit as dr
import mitsuba as mi

from ...materials.plugins import DISPERSED_COMPONENT
from ..compiled.compile import CompiledScene
from ..compiled.polarisation import polarise
from ..rays import spawn_ray
from .next_event import emitter_density, next_event, power_heuristic, respond_by
from .visibility import closest_hit

LONGEST_WAY = 16
"""Most mirrors and panes between a vertex and the bright spot that it asks."""


def spotted_light(scene: CompiledScene, si, stream, respond, active, rest=None):
    """One-sample estimate of the light of lamps that bright spots send on (see `bright_spots`).

    Next event and scattered rays that meet a lamp at once both count there: close to a lamp neither is good alone.

    Parameters
    ----------
    respond : callable    As of `next_event`.
    rest : UInt32 or None    Most reflections between the surface and the spot.

    Returns
    -------
    Spectrum    Response times radiance, weighed against the next event of scattered rays.
    """
    aim = stream.next_float32()
    aim_sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    light_sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    choice = stream.next_float32()
    scatter_sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    direction = scene.spots.sample(si.p, aim, aim_sample)
    density = scene.spots.density(si.p, direction)
    asked = active & (density > 0.0)
    response, response_pdf = respond(direction, asked)
    amount = response * (power_heuristic(density, response_pdf) / dr.maximum(density, 1e-30))
    asked &= dr.any(amount != 0.0)
    there, passed = _go_on(scene, si, direction, stream, asked, rest)
    amount = amount * passed
    asked &= dr.any(amount != 0.0)
    bsdf = scene.bsdf(there, asked)
    light = next_event(scene, there, light_sample, respond_by(bsdf, there), asked)
    bs, scattered = bsdf.sample(mi.BSDFContext(), there, choice, scatter_sample, asked)
    meets = asked & ~_is_single(bs) & dr.any(scattered != 0.0)
    lamp = closest_hit(scene, spawn_ray(scene, there, there.to_world(bs.wo)), meets)
    emitter = scene.emitter(lamp, meets & lamp.is_valid())
    meets &= lamp.is_valid() & (emitter != None)  # noqa: E711 - element-wise
    found = emitter_density(scene, mi.Interaction3f(there), lamp, emitter, meets)
    value = emitter.eval(lamp, meets) * power_heuristic(bs.pdf, found)
    light += dr.select(meets, scattered * value, 0.0)
    return dr.select(asked, amount * light, 0.0)


def _go_on(scene: CompiledScene, si, direction, stream, active, rest=None):
    """First surface that scatters in a direction, over mirrors and through panes and bodies of glass.

    Paths do the same by the same chances, so that densities compare where both leave the first surface.

    Returns
    -------
    (SurfaceInteraction3f, Spectrum)    And the share of its light that comes back; 0 where there is no such surface.
    """
    ray = spawn_ray(scene, si, direction)
    there = closest_hit(scene, ray, active)
    on_way = active & there.is_valid()
    state = {
        "there": there,
        "ray": ray,
        "numbers": mi.PCG32(stream),
        "value": dr.select(on_way, mi.Spectrum(1.0), 0.0),
        "polar": mi.Vector3f(0.0),
        "turns": mi.UInt32(0),
        "steps": mi.UInt32(0),
        "passes": on_way & ~scatters(scene.bsdf(there, on_way)),
    }

    def step(there, ray, numbers, value, polar, turns, steps, passes):
        bsdf = scene.bsdf(there, passes)
        choice = numbers.next_float32()
        sample = mi.Point2f(numbers.next_float32(), numbers.next_float32())
        bs, weight = bsdf.sample(mi.BSDFContext(), there, choice, sample, passes)
        is_turned = passes & ~mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)
        onwards = there.to_world(bs.wo)
        factor, polar = polarise(scene, there, ray.d, onwards, polar, is_turned, passes)
        value = dr.select(passes, value * weight * factor, value)
        turns = dr.select(is_turned, turns + 1, turns)
        steps += 1
        goes_on = passes & (steps <= LONGEST_WAY) & (bs.sampled_component != DISPERSED_COMPONENT)
        if rest is not None:
            goes_on &= turns <= rest
        ray = dr.select(passes, spawn_ray(scene, there, onwards), ray)
        hit = closest_hit(scene, ray, goes_on)
        goes_on &= hit.is_valid() & dr.any(value != 0.0)
        value = dr.select(passes & ~goes_on, 0.0, value)
        there = dr.select(goes_on, hit, there)
        passes = goes_on & ~scatters(scene.bsdf(there, goes_on))
        return there, ray, numbers, value, polar, turns, steps, passes

    result = dr.while_loop(
        state=tuple(state.values()),
        cond=lambda *values: values[-1],
        body=step,
        labels=tuple(state),
    )
    return result[0], result[3]


def scatters(bsdf):
    """Whether a surface sends light into more than single directions."""
    return mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)


def _is_single(bs):
    """Whether a direction was told by itself, without a density."""
    kinds = mi.BSDFFlags.Delta, mi.BSDFFlags.Null
    return mi.has_flag(bs.sampled_type, kinds[0]) | mi.has_flag(bs.sampled_type, kinds[1])
