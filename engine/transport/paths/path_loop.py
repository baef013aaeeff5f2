"""The path loop: radiance along rays by unidirectional tracing with next-event estimation at every vertex.

Emitters are counted by two strategies, next-event and hits of scattered rays, joined by the power heuristic with
exponent two (E. Veach, 1997, ch. 9). Surfaces that light passes straight through (panes, cut-outs, bodies of lights)
are no vertices: both strategies see through them, so the joint weights stay valid. Plane mirrors are vertices, but a third
strategy reaches lights by them (see `mirrors`), so a path behind them still has a reference, the image of its last vertex.
Paths end by Russian roulette alone, whose survival probability is the path's throughput, at most `SURVIVAL`, so no depth
is cut off and the estimate is unbiased.
"""

import drjit as dr
import mitsuba as mi

from ...luminaires.emitters.plugins import SUNS_ONLY
from ...materials.plugins import DISPERSED_COMPONENT
from ..compiled import mirrors
from ..compiled.compile import CompiledScene
from ..compiled.polarisation import polarise
from ..compiled.textures import is_spectral
from ..rays import spawn_ray, spawn_ray_to

SURVIVAL = 0.999
"""Largest probability of going on; below 1 so that paths end even between perfect mirrors. It must exceed the square of the
largest reflectance, or the variance of a closed room is infinite."""

ROULETTE_START = 3
"""Number of scatterings before roulette begins."""

LONGEST_WAY = 16
"""Most mirrors and panes between a vertex and the bright spot that it asks."""

MAXIMUM_STEPS = 100_000
"""Stops a path that numerical trouble would keep alive for ever; reached by no valid scene."""


def closest_hit(scene: CompiledScene, ray, active, coherent=False, looks=None):
    """Return the nearest surface of both sub-scenes, and of what is there for the camera alone to rays that look."""
    hit = scene.solid.ray_intersect_preliminary(ray, mi.Bool(coherent), active)
    if scene.veil is not None:
        other = scene.veil.ray_intersect_preliminary(ray, mi.Bool(coherent), active)
        hit = dr.select(other.t < hit.t, other, hit)
    if looks is not None and scene.shown is not None:
        other = scene.shown.ray_intersect_preliminary(ray, mi.Bool(coherent), active & looks)
        hit = dr.select(other.t < hit.t, other, hit)
    return scene.surface(hit, ray, active)


def transmittance(scene: CompiledScene, origin, target, active, polar=None):
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
    if scene.veil is None:
        return dr.select(lit, mi.Spectrum(1.0), 0.0)

    value = dr.select(lit, mi.Spectrum(1.0), 0.0)
    ray = mi.Ray3f(ray)
    steps = mi.UInt32(0)
    polar = mi.Vector3f(0.0) if polar is None else mi.Vector3f(polar)

    def step(value, ray, lit, steps, polar):
        si = scene.veil.ray_intersect(ray, lit)
        lit &= si.is_valid()
        factor, polar = polarise(scene, si, ray.d, ray.d, polar, mi.Bool(False), lit)
        value[lit] = value * scene.bsdf(si, lit).eval_null_transmission(si, lit) * factor
        ray = dr.select(lit, spawn_ray_to(scene, si, target.p, target.n), ray)
        lit &= dr.any(value != 0.0)
        steps += 1
        return value, ray, lit & (steps < 1000), steps, polar

    result = dr.while_loop(
        state=(value, ray, mi.Bool(lit), steps, polar),
        cond=lambda value, ray, lit, steps, polar: lit,
        body=step,
        labels=("value", "ray", "lit", "steps", "polar"),
    )
    return result[0]


def sample_emitter(scene: CompiledScene, si, sample, active, over_mirrors=False):
    """Choose a direction to an emitter.

    Parameters
    ----------
    over_mirrors : bool    Whether the surface is an image of one in mirrors: not all of the surroundings may count then.

    Returns
    -------
    (DirectionSample3f, Spectrum)    ``pdf`` includes the choice of the emitter; the value is radiance / pdf, unoccluded.
    """
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
    return ds, value / share


def mirrored_light(scene: CompiledScene, si, sample, stream, respond, active, limit=None):
    """One-sample estimate of the light that comes over plane mirrors.

    Parameters
    ----------
    respond : callable
        Given a direction and which lanes ask: the response of the surface, cosine included, and the density with which
        it would have scattered that way.
    limit : UInt32 or None    Most mirrors.

    Returns
    -------
    Spectrum    Response times radiance, weighed against scattered rays.
    """
    planes = scene.mirrors
    length = planes.length(stream.next_float32())
    if limit is not None:
        active &= length <= limit
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


def spotted_light(scene: CompiledScene, si, stream, respond, active, rest=None):
    """One-sample estimate of the light of lamps that bright spots send on (see `bright_spots`).

    Next event and scattered rays that meet a lamp at once both count there: close to a lamp neither is good alone.

    Parameters
    ----------
    respond : callable    As of `mirrored_light`.
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
    light = next_event(scene, there, bsdf, light_sample, asked)
    bs, scattered = bsdf.sample(mi.BSDFContext(), there, choice, scatter_sample, asked)
    meets = asked & ~_is_single(bs) & dr.any(scattered != 0.0)
    lamp = closest_hit(scene, spawn_ray(scene, there, there.to_world(bs.wo)), meets)
    lamp.wavelengths = si.wavelengths
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
    ray.wavelengths = si.wavelengths
    there = closest_hit(scene, ray, active)
    there.wavelengths = si.wavelengths
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
        following = spawn_ray(scene, there, onwards)
        following.wavelengths = ray.wavelengths
        ray = dr.select(passes, following, ray)
        hit = closest_hit(scene, ray, goes_on)
        hit.wavelengths = ray.wavelengths
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


def next_event(scene: CompiledScene, si, bsdf, sample, active):
    """One-sample estimate of the light that a surface sends on from lamps in straight view.

    Returns
    -------
    Spectrum    Response times radiance, weighed against scattered rays that meet the lamp.
    """
    ds, value = sample_emitter(scene, si, sample, active)
    lit = active & (ds.pdf > 0.0) & dr.any(value != 0.0)
    response, response_pdf = bsdf.eval_pdf(mi.BSDFContext(), si, si.to_local(ds.d), lit)
    weight = dr.select(ds.delta, 1.0, power_heuristic(ds.pdf, response_pdf))
    amount = response * value * weight
    lit &= dr.any(amount != 0.0)
    return dr.select(lit, amount * transmittance(scene, si, ds, lit), 0.0)


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


def trace(
    scene: CompiledScene,
    ray,
    wavelengths,
    stream,
    scatter_pdf,
    reference,
    active,
    first=None,
    depth=0,
    limit=None,
):
    """Radiance that arrives along rays.

    Parameters
    ----------
    ray : Ray3f
    wavelengths : Spectrum or None    Four wavelengths of each path, None in photometric variants. [nm]
    stream : PCG32    Random numbers from the first vertex on.
    scatter_pdf : Float    Solid-angle density with which the ray was chosen; 0 for camera rays, whose hits of
        emitters count in full.
    reference : Point3f    Where the ray was scattered: next-event from there competes with its hits.
    active : Bool
    first : (Point2f, Point2f) or None    Well-distributed samples for next-event and scattering at the first vertex.
    depth : int    Scatterings so far; 0 hides what the camera must not see.
    limit : UInt32 or None    Most reflections of light that counts, for rays from receivers (``depth`` 1).

    Returns
    -------
    Spectrum    Spectral radiance [W/(m2 sr nm)], or luminance [cd/m2] in photometric variants.
    """
    spectral = is_spectral()
    context = mi.BSDFContext()
    is_camera = depth == 0
    seen_by_camera = is_camera and scene.hidden is not None

    ray = mi.Ray3f(ray)
    if spectral:
        ray.wavelengths = wavelengths
    state = {
        "ray": ray,
        "stream": mi.PCG32(stream),
        "throughput": mi.Spectrum(1.0),
        "radiance": mi.Spectrum(0.0),
        "pdf": mi.Float(scatter_pdf),
        "reference": mi.Point3f(reference),
        "depth": mi.UInt32(depth),
        "steps": mi.UInt32(0),
        # Length, last mirror and chance.
        "chain": (mi.UInt32(0), mi.UInt32(0), mi.Float(1.0)),
        "polar": mi.Vector3f(0.0),
        "dispersed": mi.Bool(False),
        "eta": mi.Float(1.0),
        "active": mi.Bool(active),
    }

    has_mirrors = scene.mirrors is not None
    has_spots = scene.spots is not None
    if has_spots:
        # Mirrors and panes since the last vertex; more than `LONGEST_WAY` where rays to spots could not go the same way.
        state["way"] = dr.select(scatter_pdf > 0.0, mi.UInt32(0), LONGEST_WAY + 1)
        # Share of the lamps' light at the next vertex that the way there counts for; the rest is counted by rays to spots.
        state["next_share"] = power_heuristic(
            mi.Float(scatter_pdf), scene.spots.density(mi.Point3f(reference), ray.d)
        )
        # The same at the last vertex, for a lamp that is met at once.
        state["share"] = mi.Float(1.0)
        state["active"] = state.pop("active")
    # Light over bends has its own estimator at vertices that spread it out, receivers among them.
    has_bent = scene.bent is not None
    if has_bent:
        state["spread"] = mi.Bool(depth > 0)
        state["bent"] = mi.Bool(False)
        state["active"] = state.pop("active")
    # A receiver counts as the first scattering but reflects nothing.
    last = None if limit is None else limit + (depth - 1)

    def body(
        ray,
        stream,
        throughput,
        radiance,
        pdf,
        reference,
        depth,
        steps,
        chain,
        polar,
        dispersed,
        eta,
        *more,
    ):
        *more, active = more
        way, next_share, share, *bending = more if has_spots else (None, None, None, *more)
        si = closest_hit(scene, ray, active, looks=depth == 0 if is_camera else None)
        if spectral:
            si.wavelengths = ray.wavelengths
        valid = active & si.is_valid()
        origin = dr.zeros(mi.Interaction3f)
        origin.p, origin.t = reference, 0.0
        origin.wavelengths = si.wavelengths

        # ---- light that the ray runs into ----
        hidden = mi.Bool(False)
        if seen_by_camera:
            ids = dr.reinterpret_array(mi.UInt32, si.shape)
            begins = valid & (depth == 0)
            hidden = dr.gather(mi.Bool, scene.hidden, ids, begins) & begins
        emitter = scene.emitter(si, valid)
        glows = valid & ~hidden & (emitter != None)  # noqa: E711 - element-wise
        found = emitter_density(scene, origin, si, emitter, glows & (pdf > 0.0))
        if has_mirrors:
            over = scene.mirrors.probability(chain[0], chain[2])
            found *= over
        weight = dr.select(pdf > 0.0, power_heuristic(pdf, found), 1.0)
        value = emitter.eval(si, glows)
        if has_bent:
            spread, bent = bending
            left_out = scene.bent.left_out
            glows &= ~(bent & spread & left_out.has(emitter, glows))
        if has_spots:
            weight *= share
        radiance = dr.select(glows, radiance + throughput * value * weight, radiance)

        if scene.surroundings is not None:
            leaves = active & ~si.is_valid()
            away = dr.zeros(mi.SurfaceInteraction3f)
            away.wi = -ray.d
            away.wavelengths = si.wavelengths
            mirrored = chain[0] > 0 if has_mirrors else None
            found = surroundings_density(scene, origin, ray.d, leaves & (pdf > 0.0), mirrored)
            if has_mirrors:
                found *= over
            weight = dr.select(pdf > 0.0, power_heuristic(pdf, found), 1.0)
            value = scene.surroundings.eval(away, leaves)
            if has_bent and left_out.suns:
                sun = scene.surroundings.sun_value(ray.d, away.wavelengths, leaves)
                value -= dr.select(bent & spread, sun, 0.0)
            radiance = dr.select(leaves, radiance + throughput * value * weight, radiance)

        # ---- next event ----
        active = mi.Bool(valid)
        if last is not None:
            active &= depth <= last
        bsdf = scene.bsdf(si, active)
        smooth = active & ~hidden & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
        light_sample = mi.Point2f(stream.next_float32(), stream.next_float32())
        scatter_sample = mi.Point2f(stream.next_float32(), stream.next_float32())
        if first is not None:
            light_sample = dr.select(steps == 0, first[0], light_sample)
            scatter_sample = dr.select(steps == 0, first[1], scatter_sample)
        choice = stream.next_float32()

        def respond(direction, asked, si=si, bsdf=bsdf):
            return bsdf.eval_pdf(context, si, si.to_local(direction), asked)

        if has_spots:
            share = mi.Float(1.0)
        if scene.lights.count:
            amount = throughput * next_event(scene, si, bsdf, light_sample, smooth)
            if has_spots:
                share = dr.select(way <= LONGEST_WAY, next_share, 1.0)
                amount *= share

                asks = smooth if last is None else smooth & (depth < last)
                rest = None if last is None else mi.UInt32(last - dr.minimum(depth + 1, last))
                spotted = spotted_light(scene, si, stream, respond, asks, rest)
                amount += throughput * spotted
            radiance = radiance + amount
            if has_mirrors:
                mirror_sample = mi.Point2f(stream.next_float32(), stream.next_float32())
                rest = None if last is None else mi.UInt32(last - dr.minimum(depth, last))
                amount = mirrored_light(scene, si, mirror_sample, stream, respond, smooth, rest)
                radiance = radiance + throughput * amount

        if has_bent:

            def respond_alone(direction, asked, respond=respond):
                return respond(direction, asked)[0]

            rest = None if last is None else mi.UInt32(last - dr.minimum(depth, last))
            amount = scene.bent.light(si, stream, respond_alone, smooth, dispersed, rest, ~spread)
            radiance = radiance + throughput * amount

        # ---- scattering ----
        bs, scattered = bsdf.sample(context, si, choice, scatter_sample, active)
        straight = hidden | mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)
        direction = dr.select(hidden, ray.d, si.to_world(bs.wo))
        throughput = dr.select(hidden, throughput, throughput * scattered)
        if scene.requirements.dispersive:
            splits = active & ~straight & (bs.sampled_component == DISPERSED_COMPONENT) & ~dispersed
            hero = mi.Spectrum(0.0)
            hero[0] = 4.0 * throughput[0]
            throughput = dr.select(splits, hero, throughput)
            dispersed |= splits
        turned = active & ~straight
        factor, polar = polarise(scene, si, ray.d, direction, polar, turned, active & ~hidden)
        throughput = throughput * factor
        onwards = spawn_ray(scene, si, direction)
        onwards.wavelengths = ray.wavelengths
        ray = onwards
        delta = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
        # A copy: changing it in place must not change the other.
        anew = mi.Bool(turned)
        if has_mirrors:
            # Behind a plane mirror the path goes on as if from the image of its last vertex.
            number = scene.mirror_at(si, turned)
            mirrored = turned & (number > 0)
            image = si.p - direction * dr.norm(si.p - reference)
            reference = dr.select(mirrored, image, reference)
            chain = scene.mirrors.extend(chain, number, mirrored, turned)
            anew &= ~mirrored
        if has_bent:
            spreads = turned & ~delta
            spread |= spreads
            bent = dr.select(spreads, False, bent | (anew & delta))
        if has_spots:
            leaves_anew = turned & ~delta & smooth
            passes = active & ~hidden & ~scatters(bsdf)
            passes &= bs.sampled_component != DISPERSED_COMPONENT
            way = dr.select(passes, dr.minimum(way, LONGEST_WAY) + 1, LONGEST_WAY + 1)
            way = dr.select(leaves_anew, 0, way)
            rival = scene.spots.density(si.p, direction)
            next_share = dr.select(leaves_anew, power_heuristic(bs.pdf, rival), next_share)
            share = dr.select(turned & ~delta, share, 1.0)
        pdf = dr.select(anew, dr.select(delta, 0.0, bs.pdf), pdf)
        reference = dr.select(anew, si.p, reference)
        eta = dr.select(turned, eta * bs.eta, eta)
        depth = dr.select(turned, depth + 1, depth)
        steps += 1

        # ---- roulette ----
        survival = dr.minimum(dr.max(throughput) * dr.square(eta), SURVIVAL)
        tried = active & (depth >= ROULETTE_START) & ~straight
        alive = dr.any(throughput != 0.0) & (steps < MAXIMUM_STEPS)
        goes_on = ~tried | (stream.next_float32() < survival)
        throughput = dr.select(tried, throughput / dr.maximum(survival, 1e-20), throughput)
        active &= alive & goes_on
        if last is not None:
            active &= depth <= last + 1
        spotted = (way, next_share, share) if has_spots else ()
        more = (*spotted, *((spread, bent) if has_bent else ()))
        return (
            ray, stream, throughput, radiance, pdf, reference, depth, steps, chain, polar, dispersed, eta, *more,
            active,
        )  # fmt: skip

    result = dr.while_loop(
        state=tuple(state.values()),
        cond=lambda *values: values[-1],
        body=body,
        labels=tuple(state),
    )
    return result[3]
