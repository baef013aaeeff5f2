"""Radiance along rays that ends at the first cell: the loop of `path_loop`, but what matt surfaces send is read.

A path goes on past a matt surface where reading would be wrong by more than noise: nearer than a cell's size (corners), and
at cells whose quarters differ (edges of shadows, floors that reach under a wall). There it continues as in `path_loop`, with
next-event and a scattered ray, whose hit is read in its turn. From coats only the mirrored part goes on: that of the first
hit by chance, since it is little and following costs much.

What is read holds light of all earlier reflections, so the estimate is unbiased but for the cells: their size, and what the
sweeps before left out. The `job` measures that difference against full paths.
"""

from dataclasses import dataclass, fields, replace

import drjit as dr
import mitsuba as mi

from ...arrays import average
from ..compiled.polarisation import polarise
from ..compiled.textures import is_spectral
from ..rays import spawn_ray
from . import path_loop as paths

NEAR = 2.0
"""Distance within which cells are not read, in their sizes."""

MIRRORED = 2.0
"""Share of what is asked for the light that a coat mirrors, in its reflectances."""


def incoming(
    scene,
    cells,
    ray,
    wavelengths,
    stream,
    scatter_pdf,
    reference,
    active,
    ratio,
    left_out=None,
    is_exact=False,
    guide=None,
    guided_ratio=1.0,
    mirrored_ratio=1.0,
):
    """Radiance that arrives along rays from receivers.

    Parameters
    ----------
    scene : CompiledScene
    cells : CellSet or None    None: full paths.
    ray : Ray3f
    wavelengths : Spectrum or None    Four wavelengths of each path, None in photometric variants. [nm]
    stream : PCG32
    scatter_pdf : Float    Solid-angle density with which the ray was chosen.
    reference : Point3f    The receiver: next-event from there competes with the ray's hits.
    active : Bool
    ratio : Float    Next-event samples at the receiver for every ray.
    left_out : LeftOut or None    What is traced from the lights, and so does not count here; None: nothing.
    is_exact : bool    Whether no cells are read after all, but for light that was traced to them.
    guide : Guide or None    Competes with the rays of the receiver for what they read; None: nothing does.
    guided_ratio : Float    Samples of it for every ray.
    mirrored_ratio : Float    As ``ratio``, of next-event over mirrors.

    Returns
    -------
    (Spectrum, Spectrum)
        Spectral radiance [W/(m2 sr nm)], or luminance [cd/m2] in photometric variants: what was met otherwise, and what
        was read from cells. Their sum is what arrives.
    """
    reads = cells is not None and bool(cells) and not is_exact
    rays = _Rays(
        dr.arange(mi.UInt32, dr.width(ray)),
        mi.Point3f(ray.o),
        mi.Vector3f(ray.d),
        wavelengths if is_spectral() else None,
        mi.PCG32(stream),
        mi.Float(scatter_pdf),
        mi.Point3f(reference),
        mi.Float(ratio),
        mi.Float(guided_ratio),
        mi.Float(mirrored_ratio),
        mi.Spectrum(1.0),
        mi.UInt32(1),
        mi.UInt32(0),
        mi.UInt32(0),
        mi.Float(1.0),
        None if scene.polarisation is None else mi.Vector3f(0.0),
        mi.Bool(False),
        mi.Bool(False),
    )
    if not reads and scene.veil is None:
        return _follow(scene, cells, rays, active, left_out, False, guide)
    # Most rays end where they land. The others are few, and go on in a kernel of their own.
    rest, read, goes_on, forks = _look_up(scene, cells, rays, active, guide, reads)
    dr.eval(rays, rest, read, goes_on, forks)
    none = dr.zeros(mi.Spectrum, dr.width(ray))
    rest, read = rest + none, read + none
    few, forked = dr.compress(goes_on), dr.compress(forks)
    followed = [rays.take(few)] if len(few) else []
    if len(forked):
        followed += _fork(scene, rays.take(forked))
    if followed:
        onwards = _collect(followed)
        found = _follow(scene, cells, onwards, mi.Bool(True), left_out, reads, guide)
        for whole, part in zip((rest, read), found, strict=True):
            # Two at most go on from one ray, so their order does not matter. Other modes would make the size a part of
            # the kernel.
            dr.scatter_add(whole, part, onwards.number, mode=dr.ReduceMode.Direct)
    return rest, read


@dataclass(frozen=True)
class LeftOut:
    """Light over ideal glass and curved mirrors to matt surfaces that is traced from the lights (see `light_paths`).

    Parameters
    ----------
    suns : bool    Whether that of the suns is.
    emitters : Bool or None    Which luminous surfaces' is, by number of the emitter; None: none's.
    """

    suns: bool
    emitters: object = None

    def has(self, emitter, active):
        """Whether light of an emitter is left out."""
        if self.emitters is None:
            return mi.Bool(False)
        number = dr.reinterpret_array(mi.UInt32, emitter)
        return dr.gather(mi.Bool, self.emitters, number, active)


@dataclass
class _Rays:
    """Rays from receivers; parameters as of `incoming`, and of what panes have done to them.

    ``number``: of the ray. ``length``, ``last``, ``chance``: of the chain of known mirrors met, see `MirrorSet.extend`.
    ``polar``: polarisation, None where the scene needs none. ``is_read``: whether the base of what they meet has been read.
    """

    number: object
    origin: object
    direction: object
    wavelengths: object
    stream: object
    scatter_pdf: object
    reference: object
    ratio: object
    guided_ratio: object
    mirrored_ratio: object
    throughput: object
    depth: object
    length: object
    last: object
    chance: object
    polar: object
    bent: object
    is_read: object

    @property
    def ray(self):
        ray = mi.Ray3f(self.origin, self.direction)
        if self.wavelengths is not None:
            ray.wavelengths = self.wavelengths
        return ray

    def take(self, index) -> "_Rays":
        """Some of the rays."""
        return self._map(
            lambda value: value if dr.width(value) == 1 else dr.gather(type(value), value, index)
        )

    def _map(self, make) -> "_Rays":
        values = ((field.name, getattr(self, field.name)) for field in fields(self))
        return _Rays(**{name: None if value is None else make(value) for name, value in values})


def _collect(parts: list[_Rays]) -> _Rays:
    """Rays one after the other.

    All is written to memory and at full width, so that the large kernel that follows rays is one and the same whatever they
    have been through.
    """
    counts = [dr.width(part.number) for part in parts]
    whole = parts[0]._map(lambda value: dr.empty(type(value), sum(counts)))
    for number, (part, count) in enumerate(zip(parts, counts, strict=True)):
        # A plain number would be a part of the kernel.
        index = dr.arange(mi.UInt32, count) + dr.opaque(mi.UInt32, sum(counts[:number]))
        for field in fields(part):
            value = getattr(part, field.name)
            if value is not None:
                dr.scatter(getattr(whole, field.name), value, index)
    dr.eval(whole)
    return whole


def _look_up(scene, cells, rays: _Rays, active, guide, reads):
    """What is read where rays land on a cell that may be read and has no light of its own.

    Returns
    -------
    (Spectrum, Spectrum, Bool, Bool)
        Light that was traced to these cells; what is read of them; which rays have to be followed; and which meet a pane,
        where they go two ways. Rays that are followed for what a coat mirrors alone are marked and weigh more.
    """
    hit, si = _hit(scene, rays.ray, active)
    if is_spectral():
        si.wavelengths = rays.wavelengths
    valid = active & si.is_valid()
    is_dark = scene.emitter(si, valid) == None  # noqa: E711 - element-wise
    readable, mirrored = mi.Bool(False), mi.Bool(False)
    traced = value = mi.Spectrum(0.0)
    if reads:
        row, coat, side, local, readable = _meet(cells, hit, si, rays.reference, valid)
        readable &= is_dark
        bsdf = scene.bsdf(si, readable)
        matte = _matte(cells, bsdf, si, row, coat, readable)
        if guide is not None:
            rival = guide, rays.reference, rays.guided_ratio
            matte *= _against_guide(*rival, si, side, local, rays.scatter_pdf, readable)
        value = dr.select(readable, matte * cells.value(side, si.wavelengths, readable), 0.0)
        if cells.traced is not None:
            traced = cells.traced_value(side, local, si.wavelengths, readable)
            traced = dr.select(readable, matte * traced, 0.0)
        if cells.matt.has_coat:
            share = dr.minimum(MIRRORED * coat, 1.0)
            mirrored = readable & (rays.stream.next_float32() < share)
            rays.throughput /= dr.select(mirrored, share, 1.0)
            rays.is_read = mirrored
    leaves = active & ~si.is_valid()
    goes_on = (valid & ~readable) | mirrored | (leaves & (scene.surroundings is not None))
    forks = mi.Bool(False)
    if scene.veil is not None:
        flags = scene.bsdf(si, valid & ~readable).flags()
        forks = valid & ~readable & mi.has_flag(flags, mi.BSDFFlags.Null)
        forks &= mi.has_flag(flags, mi.BSDFFlags.DeltaReflection)
        forks &= ~mi.has_flag(flags, mi.BSDFFlags.Smooth) & is_dark
    return traced, value, goes_on & ~forks, forks


def _fork(scene, rays: _Rays) -> list[_Rays]:
    """What a pane mirrors and what it lets through, where rays meet one first.

    Following one of them by chance would scatter: lamps that are seen in a window are bright, and seldom chosen.
    """
    _, si = _hit(scene, rays.ray, mi.Bool(True))
    if is_spectral():
        si.wavelengths = rays.wavelengths
    bsdf, made = scene.bsdf(si, mi.Bool(True)), []
    for number, wanted in (
        (0.0, mi.BSDFFlags.DeltaReflection),
        (1.0 - dr.epsilon(mi.Float), mi.BSDFFlags.Null),
    ):
        bs, weight = bsdf.sample(
            mi.BSDFContext(), si, mi.Float(number), mi.Point2f(0.5), mi.Bool(True)
        )
        is_wanted = mi.has_flag(bs.sampled_type, wanted)
        onwards = spawn_ray(scene, si, si.to_world(bs.wo))
        is_turned = mi.Bool(wanted == mi.BSDFFlags.DeltaReflection)
        factor, polar = polarise(
            scene, si, rays.direction, onwards.d, rays.polar, is_turned, mi.Bool(True)
        )
        found = replace(
            rays,
            origin=onwards.o,
            direction=onwards.d,
            throughput=rays.throughput * dr.select(is_wanted, weight * bs.pdf * factor, 0.0),
            polar=polar,
        )
        if wanted == mi.BSDFFlags.DeltaReflection:
            known, chain = mi.Bool(False), (rays.length, rays.last, rays.chance)
            if scene.mirrors is not None:
                plane = scene.mirror_at(si, mi.Bool(True))
                known = plane > 0
                chain = scene.mirrors.extend(chain, plane, known, mi.Bool(True))
            image = si.p - onwards.d * dr.norm(si.p - rays.reference)
            found = replace(
                found,
                scatter_pdf=dr.select(known, rays.scatter_pdf, 0.0),
                reference=dr.select(known, image, si.p),
                ratio=dr.select(known, rays.mirrored_ratio, 1.0),
                depth=rays.depth + 1,
                length=chain[0],
                last=chain[1],
                chance=chain[2],
                bent=~known,
            )
        made.append(found)
    return made


def _matte(cells, bsdf, si, row, coat, active):
    """Radiance that a matt surface sends for the irradiance that passes its coat. [sr-1]"""
    return bsdf.eval_diffuse_reflectance(si, active) * (
        (1.0 - coat) * cells.matt.scale(row, active) * dr.inv_pi
    )


def _against_guide(guide, reference, ratio, si, side, local, pdf, active):
    """Weight of what a ray has found on a cell, beside so many points that the guide chooses for every ray. [-]"""
    away = si.p - reference
    facing = dr.abs(dr.dot(dr.normalize(away), si.n))
    found = guide.density(side, local, active) * dr.squared_norm(away)
    found *= ratio / dr.maximum(facing, 1e-9)
    return dr.select(active, paths.power_heuristic(pdf, found), 1.0)


def _follow(scene, cells, rays: _Rays, active, left_out, reads, guide):
    """Follow rays to their ends; returns as `incoming`."""
    spectral = is_spectral()
    context = mi.BSDFContext()
    traced = cells is not None and bool(cells) and cells.traced is not None
    spots = cells.spots if traced else None
    has_mirrors = scene.mirrors is not None
    rival = guide, rays.reference, rays.guided_ratio
    state = {
        "ray": rays.ray,
        "stream": mi.PCG32(rays.stream),
        "throughput": mi.Spectrum(rays.throughput),
        "radiance": mi.Spectrum(0.0),
        "read": mi.Spectrum(0.0),
        "pdf": mi.Float(rays.scatter_pdf),
        "reference": mi.Point3f(rays.reference),
        "ratio": mi.Float(rays.ratio),
        "depth": mi.UInt32(rays.depth),
        "steps": mi.UInt32(0),
        "chain": (mi.UInt32(rays.length), mi.UInt32(rays.last), mi.Float(rays.chance)),
        "polar": mi.Vector3f(0.0) if rays.polar is None else mi.Vector3f(rays.polar),
        "bent": mi.Bool(rays.bent),
        "is_read": mi.Bool(rays.is_read),
        "asked": mi.Bool(False),
        # Traced light lands on receivers and matt surfaces only.
        "traceable": mi.Bool(True),
        "dispersed": mi.Bool(False),
        "eta": mi.Float(1.0),
        "active": mi.Bool(active),
    }

    def body(
        ray,
        stream,
        throughput,
        radiance,
        read,
        pdf,
        reference,
        ratio,
        depth,
        steps,
        chain,
        polar,
        bent,
        is_read,
        asked,
        traceable,
        dispersed,
        eta,
        active,
    ):
        hit, si = _hit(scene, ray, active)
        if spectral:
            si.wavelengths = ray.wavelengths
        valid = active & si.is_valid()
        origin = dr.zeros(mi.Interaction3f)
        origin.p, origin.t = reference, 0.0
        origin.wavelengths = si.wavelengths
        over = mi.Float(ratio)
        if has_mirrors:
            over *= scene.mirrors.probability(chain[0], chain[2])

        # ---- light that the ray runs into ----
        emitter = scene.emitter(si, valid)
        glows = valid & (emitter != None)  # noqa: E711 - element-wise
        found = paths.emitter_density(scene, origin, si, emitter, glows & (pdf > 0.0)) * over
        weight = dr.select(pdf > 0.0, paths.power_heuristic(pdf, found), 1.0)
        value = emitter.eval(si, glows)
        if scene.near is not None:
            straight = glows & (pdf > 0.0)
            glows &= ~scene.near.has_emitter(emitter, si.time, reference, straight)
        if left_out is not None:
            glows &= ~(bent & traceable & left_out.has(emitter, glows))
        radiance = dr.select(glows, radiance + throughput * value * weight, radiance)
        if scene.surroundings is not None:
            leaves = active & ~si.is_valid()
            away = dr.zeros(mi.SurfaceInteraction3f)
            away.wi = -ray.d
            away.wavelengths = si.wavelengths
            mirrored = chain[0] > 0 if has_mirrors else None
            found = paths.surroundings_density(scene, origin, ray.d, leaves & (pdf > 0.0), mirrored)
            found *= over
            weight = dr.select(pdf > 0.0, paths.power_heuristic(pdf, found), 1.0)
            value = scene.surroundings.eval(away, leaves)
            # Suns that are traced straight are left out for rays that compete with next-event alone.
            alone = leaves & (pdf <= 0.0)
            if left_out is not None and left_out.suns:
                sun = scene.surroundings.sun_value(ray.d, away.wavelengths, leaves)
                value -= dr.select(bent & traceable, sun, 0.0)
                alone &= ~(bent & traceable)
            hidden = scene.surroundings.left_out_value(ray.d, away.wavelengths, alone)
            value += dr.select(alone, hidden, 0.0)
            radiance = dr.select(leaves, radiance + throughput * value * weight, radiance)

        # ---- what a matt surface sends ----
        active = mi.Bool(valid)
        bsdf = scene.bsdf(si, active)
        readable = mi.Bool(False)
        matte = mi.Spectrum(0.0)
        row = mi.UInt32(0)
        coat = mi.Float(0.0)
        if reads or traced:
            row, coat, side, local, readable = _meet(cells, hit, si, reference, active)
            is_matt = row > 0
            matte = _matte(cells, bsdf, si, row, coat, is_matt)
            if traced:
                value = cells.traced_value(side, local, si.wavelengths, is_matt)
                if guide is not None:
                    first = is_matt & (depth == 1)
                    value *= _against_guide(*rival, si, side, local, pdf, first)
                if spots is not None:
                    first = is_matt & asked
                    value *= _against_guide(spots, reference, 1.0, si, side, local, pdf, first)
                lit = is_matt & ~is_read
                radiance = dr.select(lit, radiance + throughput * matte * value, radiance)
            # What was read before is so, whatever rounding says here.
            readable = (readable & reads) | is_read
            value = cells.value(side, si.wavelengths, readable)
            if guide is not None:
                # Only what a straight line from the receiver meets could have been chosen.
                first = readable & (depth == 1)
                value *= _against_guide(*rival, si, side, local, pdf, first)
            read = dr.select(readable & ~is_read, read + throughput * matte * value, read)
        if reads:
            # Only coats mirror what has not been read.
            active &= ~readable | (coat > 0.0)

        # ---- next event ----
        smooth = active & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
        light_sample = mi.Point2f(stream.next_float32(), stream.next_float32())
        scatter_sample = mi.Point2f(stream.next_float32(), stream.next_float32())
        choice = stream.next_float32()
        share = mi.Float(1.0)
        has_coat = reads and cells.matt.has_coat
        if has_coat:
            # A coat mirrors little, so few are asked what light it mirrors.
            share = dr.select(readable & ~is_read, dr.minimum(MIRRORED * coat, 1.0), 1.0)
            smooth &= stream.next_float32() < share
            # Of a surface whose base has been read the coat alone is sampled, which is what the least number chooses.
            choice = dr.select(readable, 0.0, choice)
            reflectance = bsdf.eval_diffuse_reflectance(si, readable)
            base = (1.0 - coat) * average(reflectance)
            glossy = coat / dr.maximum(coat + base, 1e-8)

        def coat_only(wo, response, density):
            """Response and density of the coat, where the base has been read."""
            cosine = dr.abs(mi.Frame3f.cos_theta(wo))
            passes = 1.0 - cells.matt.coat(row, cosine, readable)
            part = dr.maximum(response - matte * cosine * passes, 0.0)
            own = density - (1.0 - glossy) * cosine * dr.inv_pi
            own = dr.maximum(own, 0.0) / dr.maximum(glossy, 1e-8)
            return dr.select(readable, part, response), dr.select(readable, own, density)

        def respond(direction, asked):
            wo = si.to_local(direction)
            response, density = bsdf.eval_pdf(context, si, wo, asked)
            return coat_only(wo, response, density) if has_coat else (response, density)

        if scene.lights.count:
            ds, value = paths.sample_emitter(scene, si, light_sample, smooth)
            lit = smooth & (ds.pdf > 0.0) & dr.any(value != 0.0)
            response, response_pdf = respond(ds.d, lit)
            weight = dr.select(ds.delta, 1.0, paths.power_heuristic(ds.pdf, response_pdf))
            amount = throughput * response * value * (weight / share)
            lit &= dr.any(amount != 0.0)
            amount *= paths.transmittance(scene, si, ds, lit)
            radiance = dr.select(lit, radiance + amount, radiance)
            if has_mirrors:
                mirror_sample = mi.Point2f(stream.next_float32(), stream.next_float32())
                amount = paths.mirrored_light(scene, si, mirror_sample, stream, respond, smooth)
                radiance = dr.select(smooth, radiance + throughput * amount / share, radiance)
        if spots is not None:
            # Rays would meet light on a small spot by chance only, once in thousands of paths.
            which, where = (
                stream.next_float32(),
                mi.Point2f(stream.next_float32(), stream.next_float32()),
            )
            amount = spots.traced_light(scene, si, which, where, respond, smooth)
            radiance = dr.select(smooth, radiance + throughput * amount / share, radiance)

        # ---- scattering ----
        bs, scattered = bsdf.sample(context, si, choice, scatter_sample, active)
        straight = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)
        if has_coat:
            response, density = coat_only(bs.wo, scattered * bs.pdf, bs.pdf)
            found = dr.select(density > 0.0, response / dr.maximum(density, 1e-20), 0.0)
            scattered = dr.select(readable, found, scattered)
            bs.pdf = density
        throughput = throughput * scattered
        if scene.requirements.dispersive:
            splits = (
                active
                & ~straight
                & (bs.sampled_component == paths.DISPERSED_COMPONENT)
                & ~dispersed
            )
            hero = mi.Spectrum(0.0)
            hero[0] = 4.0 * throughput[0]
            throughput = dr.select(splits, hero, throughput)
            dispersed |= splits
        direction = si.to_world(bs.wo)
        turned = active & ~straight
        factor, polar = polarise(scene, si, ray.d, direction, polar, turned, active)
        throughput = throughput * factor
        onwards = spawn_ray(scene, si, direction)
        onwards.wavelengths = ray.wavelengths
        ray = onwards
        delta = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
        # A copy: changing it in place must not change the other.
        anew = mi.Bool(turned)
        bends = turned & delta
        if has_mirrors:
            # Behind a plane mirror the path goes on as if from the image of its last vertex.
            number = scene.mirror_at(si, turned)
            mirrored = turned & (number > 0)
            image = si.p - direction * dr.norm(si.p - reference)
            reference = dr.select(mirrored, image, reference)
            # Next-event of the receiver over mirrors has its own number of samples.
            ratio = dr.select(mirrored & (depth == 1), rays.mirrored_ratio, ratio)
            chain = scene.mirrors.extend(chain, number, mirrored, turned)
            anew &= ~mirrored
            bends &= ~mirrored
        if left_out is not None:
            spreads = turned & ~delta
            bent = dr.select(spreads, False, bent | bends)
            traceable = dr.select(spreads, row > 0, traceable)
        pdf = dr.select(anew, dr.select(delta, 0.0, bs.pdf), pdf)
        reference = dr.select(anew, si.p, reference)
        ratio = dr.select(anew, 1.0, ratio)
        asked = dr.select(turned, ~delta, asked)
        eta = dr.select(turned, eta * bs.eta, eta)
        depth = dr.select(turned, depth + 1, depth)
        steps += 1

        # ---- roulette ----
        survival = dr.minimum(dr.max(throughput) * dr.square(eta), paths.SURVIVAL)
        tried = active & ~straight & ((depth >= paths.ROULETTE_START) | readable)
        alive = dr.any(throughput != 0.0) & (steps < paths.MAXIMUM_STEPS)
        goes_on = ~tried | (stream.next_float32() < survival)
        throughput = dr.select(tried, throughput / dr.maximum(survival, 1e-20), throughput)
        active &= alive & goes_on
        return (
            ray, stream, throughput, radiance, read, pdf, reference, ratio, depth, steps, chain, polar, bent, mi.Bool(False),
            asked, traceable, dispersed, eta, active,
        )  # fmt: skip

    result = dr.while_loop(
        state=tuple(state.values()),
        cond=lambda *values: values[-1],
        body=body,
        labels=tuple(state),
    )
    return result[3], result[4]


def _meet(cells, hit, si, reference, active):
    """Row of the matt table (0: not matt), reflectance of the coat, side of the cell, where in it, whether it is read."""
    row = dr.select(active, cells.matt.row(si.shape, active), 0)
    is_matt = row > 0
    cosine = mi.Frame3f.cos_theta(si.wi)
    coat = mi.Float(cells.matt.coat(row, cosine, is_matt))
    side, local = cells.locate(si.shape, hit.prim_index, hit.prim_uv, cosine < 0.0, is_matt)
    readable = is_matt & (dr.norm(si.p - reference) > NEAR * cells.near(si.shape, is_matt))
    readable &= ~dr.gather(mi.Bool, cells.uneven, side, readable)
    return row, coat, side, local, readable


def _hit(scene, ray, active):
    """Return the nearest hit of both sub-scenes, and the surface there."""
    hit = scene.solid.ray_intersect_preliminary(ray, mi.Bool(False), active)
    if scene.veil is not None:
        other = scene.veil.ray_intersect_preliminary(ray, mi.Bool(False), active)
        hit = dr.select(other.t < hit.t, other, hit)
    return hit, scene.surface(hit, ray, active)
