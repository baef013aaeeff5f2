"""The path loop: radiance along rays by unidirectional tracing with next-event estimation at every vertex.

Emitters are counted by two strategies, next-event and hits of scattered rays, joined by the power heuristic with
exponent two (E. Veach, 1997, ch. 9). Surfaces that light passes straight through (panes, cut-outs, bodies of lights)
are no vertices: both strategies see through them, so the joint weights stay valid. Plane mirrors are vertices, but a third
strategy reaches lights by them (see `mirrors`), so a path behind them still has a reference, the image of its last vertex.
Paths end by Russian roulette alone, whose survival probability is the path's throughput, or what it is of a share from which
on it is played, at most `SURVIVAL`, so no depth is cut off and the estimate is unbiased.

There is one loop for all who trace from receivers and cameras. What a scene or a job does not need (mirrors, bright spots,
light over bends, reading of cells) is left out when the kernel is made.
"""

from dataclasses import dataclass, field

import drjit as dr
import mitsuba as mi

from ...materials.plugins import DISPERSED_COMPONENT
from ..compiled.compile import CompiledScene
from ..compiled.polarisation import polarise
from ..compiled.textures import is_spectral
from ..rays import spawn_ray
from .next_event import (
    emitter_density,
    mirrored_light,
    next_event,
    power_heuristic,
    respond_by,
    surroundings_density,
)
from .spotted_light import LONGEST_WAY, scatters, spotted_light
from .visibility import meet
from .wavelengths import disperse

SURVIVAL = 0.999
"""Largest probability of going on; below 1 so that paths end even between perfect mirrors. It must exceed the square of the
largest reflectance, or the variance of a closed room is infinite."""

ROULETTE_START = 3
"""Number of scatterings before roulette begins."""

MAXIMUM_STEPS = 100_000
"""Stops a path that numerical trouble would keep alive for ever; reached by no valid scene."""


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
    reader=None,
    pixel_width=None,
    faded=None,
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
    first : (Point2f, Point2f, Point2f) or None
        Well-distributed samples as of `gather.first_points`: for next-event and scattering at the first vertex that spreads
        light, and for what the first two surfaces do with it.
    depth : int    Scatterings so far; 0 hides what the camera must not see.
    limit : UInt32 or None    Most reflections of light that counts, for rays from receivers (``depth`` 1).
    reader : CellReader or None    What ends paths at cells; None: nothing does.
    pixel_width : callable or None
        Takes places that the camera sees and returns the width of a pixel there [m], so that surfaces show what is about as
        fine; None: they show none of it.
    faded : Float or None    Throughput below which roulette is played, see `requirements.fading`; None: 1.

    Returns
    -------
    Spectrum    Spectral radiance [W/(m2 sr nm)], or luminance [cd/m2] in photometric variants.
    """
    ray = mi.Ray3f(ray)
    if is_spectral():
        ray.wavelengths = wavelengths
    path = Path(
        ray,
        mi.PCG32(stream),
        mi.Float(scatter_pdf),
        mi.Point3f(reference),
        mi.UInt32(depth),
        mi.Bool(active),
    )
    left_out = None
    if scene.bent is not None:
        # Light over bends has its own estimator at vertices that spread it out, receivers among them.
        left_out = scene.bent.left_out
        path.bent, path.is_answered = mi.Bool(False), mi.Bool(depth > 0)
    # A receiver counts as the first scattering but reflects nothing.
    last = None if limit is None else limit + (depth - 1)
    if reader is not None:
        reader.begin(path)
    if not scene.has_sparkle:
        pixel_width = None
    loop = PathLoop(scene, left_out, depth == 0, first, last, reader, pixel_width, faded)
    path = loop.run(path)
    return path.radiance if reader is None else path.radiance + path.read


@dataclass
class Path:
    """State of paths on the device; parts that a loop does without are None.

    Parameters
    ----------
    ray : Ray3f    Along which the path goes on.
    stream : PCG32
    pdf : Float    Density with which the last vertex that is not specular chose the ray, over solid angle; 0: it did not.
    reference : Point3f    That vertex, or its image in mirrors: next-event from there competes with what the ray meets.
    depth : UInt32    Scatterings so far.
    active : Bool
    throughput, radiance : Spectrum    Of the way so far; what has been found.
    steps : UInt32    Surfaces so far.
    chain : (UInt32, UInt32, Float)    Of known mirrors, see `MirrorSet.extend`.
    polar : Vector3f    Polarisation.
    dispersed : Bool    Whether one wavelength is left.
    eta : Float    Refractive index against that at the start.
    bent : Bool or None    Whether light was bent since it was spread out the last time.
    is_answered : Bool or None    Whether light over bends is found otherwise where that was.
    way : UInt32 or None    Mirrors and panes since the last vertex; more than `LONGEST_WAY` where rays to spots could not go
        the same way.
    next_share : Float or None    Share of the lamps' light at the next vertex that the way there counts for; the rest is
        counted by rays to spots.
    share : Float or None    The same at the last vertex, for a lamp that is met at once.
    ratio : Float or None    Next-event samples at the reference for every ray; None: one.
    read : Spectrum or None    What was read from cells, which is not in ``radiance``.
    is_read : Bool or None    Whether the base of what is met next has been read.
    is_asked : Bool or None    Whether the last vertex asked bright spots for traced light.
    is_fresh : Bool or None    Whether no vertex has spread light yet; None: nobody asks.
    """

    ray: object
    stream: object
    pdf: object
    reference: object
    depth: object
    active: object
    throughput: object = field(default_factory=lambda: mi.Spectrum(1.0))
    radiance: object = field(default_factory=lambda: mi.Spectrum(0.0))
    steps: object = field(default_factory=lambda: mi.UInt32(0))
    chain: tuple = field(default_factory=lambda: (mi.UInt32(0), mi.UInt32(0), mi.Float(1.0)))
    polar: object = field(default_factory=lambda: mi.Vector3f(0.0))
    dispersed: object = field(default_factory=lambda: mi.Bool(False))
    eta: object = field(default_factory=lambda: mi.Float(1.0))
    bent: object = None
    is_answered: object = None
    way: object = None
    next_share: object = None
    share: object = None
    ratio: object = None
    read: object = None
    is_read: object = None
    is_asked: object = None
    spread: object = None
    is_fresh: object = None


@dataclass
class Vertex:
    """What paths have met, while it is dealt with.

    ``hit``, ``si``, ``valid``: as of `meet`, and whether there is anything. ``is_hidden``: from the camera, which sees
    through it. ``origin``: an interaction at the path's reference. ``rivals``: next-event samples there for every ray,
    times the chance of the mirrors in between. ``bsdf``, ``smooth``: the surface model, and whether it asks lights.
    ``respond``: as of `next_event`. ``chance``: of being asked. ``light_sample``, ``choice``, ``sample``: numbers for
    next-event and for scattering.
    ``is_readable``, ``row``, ``coat``, ``matte``, ``glossy``: see `lux_maps.cell_reader`.
    """

    hit: object
    si: object
    valid: object
    is_hidden: object
    origin: object
    rivals: object
    bsdf: object = None
    smooth: object = None
    light_sample: object = None
    respond: object = None
    chance: object = 1.0
    choice: object = None
    sample: object = None
    is_readable: object = False
    row: object = None
    coat: object = None
    matte: object = None
    glossy: object = None


class PathLoop:
    """Follows paths to their ends.

    Parameters
    ----------
    scene : CompiledScene
    left_out : LeftOut or None    Light over bends that does not count, since it is found otherwise; None: nothing.
    is_camera : bool    Whether paths begin at a camera, which does not see everything.
    first : (Point2f, Point2f, Point2f) or None    As of `trace`.
    last : UInt32 or None    Depth of the last vertex whose light counts.
    reader : CellReader or None    What ends paths at cells; None: nothing does.
    pixel_width : callable or None    As of `trace`.
    faded : Float or None    As of `trace`.
    """

    def __init__(
        self,
        scene,
        left_out=None,
        is_camera=False,
        first=None,
        last=None,
        reader=None,
        pixel_width=None,
        faded=None,
    ):
        self._pixel_width, self._faded = pixel_width, faded
        self._scene, self._left_out, self._reader = scene, left_out, reader
        self._is_camera, self._first, self._last = is_camera, first, last

    def run(self, path: Path) -> Path:
        """Follow paths; what was found is in their state."""
        spots = self._scene.spots
        if self._first is not None:
            path.is_fresh = mi.Bool(True)
        if spots is not None:
            path.way = dr.select(path.pdf > 0.0, mi.UInt32(0), LONGEST_WAY + 1)
            rival = spots.density(path.reference, path.ray.d)
            path.next_share = power_heuristic(path.pdf, rival)
            path.share = mi.Float(1.0)
        (path,) = dr.while_loop(
            state=(path,), cond=lambda path: path.active, body=self._step, labels=("path",)
        )
        return path

    def _step(self, path: Path) -> tuple[Path]:
        scene = self._scene
        at = self._meet(path)
        self._count_emitter(path, at)
        if scene.surroundings is not None:
            self._count_surroundings(path, at)
        if self._is_camera and scene.has_backdrop and scene.backdrop is not None:
            self._count_backdrop(path, at)
        path.active = mi.Bool(at.valid)
        if self._last is not None:
            path.active &= path.depth <= self._last
        at.bsdf = scene.bsdf(at.si, path.active)
        if self._reader is not None:
            self._reader.read(path, at)
        self._draw(path, at)
        self._ask_lights(path, at)
        bs, turned = self._scatter(path, at)
        self._note_reference(path, at, bs, turned)
        self._play_roulette(path, at, turned)
        return (path,)

    def _meet(self, path: Path) -> Vertex:
        """Find what rays run into."""
        scene = self._scene
        looks = path.depth == 0 if self._is_camera else None
        hit, si = meet(scene, path.ray, path.active, looks=looks)
        if self._pixel_width is not None:
            # Surfaces know by this that the camera looks at them, and what a pixel covers.
            width = dr.select(path.depth == 0, self._pixel_width(si.p), 0.0)
            si.duv_dx = mi.Vector2f(width, 0.0)
        valid = path.active & si.is_valid()
        origin = dr.zeros(mi.Interaction3f)
        origin.p, origin.t = path.reference, 0.0
        origin.wavelengths = si.wavelengths
        rivals = 1.0 if path.ratio is None else path.ratio
        if scene.mirrors is not None:
            rivals = scene.mirrors.probability(path.chain[0], path.chain[2]) * rivals
        is_hidden = mi.Bool(False)
        if self._is_camera and scene.hidden is not None:
            number = dr.reinterpret_array(mi.UInt32, si.shape)
            begins = valid & (path.depth == 0)
            is_hidden = dr.gather(mi.Bool, scene.hidden, number, begins) & begins
        return Vertex(hit, si, valid, is_hidden, origin, rivals)

    def _count_emitter(self, path: Path, at: Vertex) -> None:
        """Count light that rays run into."""
        scene, si = self._scene, at.si
        emitter = scene.emitter(si, at.valid)
        glows = at.valid & ~at.is_hidden & (emitter != None)  # noqa: E711 - element-wise
        competes = glows & (path.pdf > 0.0)
        found = emitter_density(scene, at.origin, si, emitter, competes) * at.rivals
        weight = _ray_weight(path.pdf, found)
        value = emitter.eval(si, glows)
        if scene.near is not None:
            glows &= ~scene.near.has_emitter(emitter, si.time, path.reference, competes)
        if self._left_out is not None:
            asks = glows & path.bent & path.is_answered
            glows &= ~(asks & self._left_out.has(scene.lights, emitter, si.time, asks))
        if path.share is not None:
            weight *= path.share
        amount = path.throughput * value * weight
        path.radiance = dr.select(glows, path.radiance + amount, path.radiance)

    def _count_surroundings(self, path: Path, at: Vertex) -> None:
        """Count light from infinity where rays leave the scene."""
        scene, direction = self._scene, path.ray.d
        leaves = path.active & ~at.si.is_valid()
        if self._is_camera and scene.has_backdrop:
            leaves &= path.depth > 0
        away = dr.zeros(mi.SurfaceInteraction3f)
        away.wi = -direction
        # A ground that the surroundings lie on is seen from where the ray comes from.
        away.p = path.ray.o
        away.wavelengths = at.si.wavelengths
        is_mirrored = path.chain[0] > 0 if scene.mirrors is not None else None
        competes = leaves & (path.pdf > 0.0)
        found = surroundings_density(scene, at.origin, direction, competes, is_mirrored)
        weight = _ray_weight(path.pdf, found * at.rivals)
        value = scene.surroundings.eval(away, leaves)
        # Suns that are traced straight are left out for rays that compete with next-event alone.
        alone = leaves & (path.pdf <= 0.0)
        if self._left_out is not None and self._left_out.suns:
            sun = scene.surroundings.sun_value(direction, away.wavelengths, leaves)
            value -= dr.select(path.bent & path.is_answered, sun, 0.0)
            alone &= ~(path.bent & path.is_answered)
        straight = scene.surroundings.left_out_value(direction, away.wavelengths, alone)
        value += dr.select(alone, straight, 0.0)
        amount = path.throughput * value * weight
        path.radiance = dr.select(leaves, path.radiance + amount, path.radiance)

    def _count_backdrop(self, path: Path, at: Vertex) -> None:
        """Count what the camera sees straight behind everything, where that is not what gives light."""
        looks = path.active & ~at.si.is_valid() & (path.depth == 0)
        away = dr.zeros(mi.SurfaceInteraction3f)
        away.wi, away.p = -path.ray.d, path.ray.o
        away.wavelengths = at.si.wavelengths
        amount = path.throughput * self._scene.backdrop.eval(away, looks)
        path.radiance = dr.select(looks, path.radiance + amount, path.radiance)

    def _draw(self, path: Path, at: Vertex) -> None:
        """Draw the numbers of a vertex, and find out how it answers light."""
        stream = path.stream
        is_smooth = mi.has_flag(at.bsdf.flags(), mi.BSDFFlags.Smooth)
        at.smooth = path.active & ~at.is_hidden & is_smooth
        at.light_sample = mi.Point2f(stream.next_float32(), stream.next_float32())
        at.sample = mi.Point2f(stream.next_float32(), stream.next_float32())
        if self._first is not None:
            light, scatter, choices = self._first
            at.light_sample = dr.select(path.is_fresh, light, at.light_sample)
            at.sample = dr.select(path.is_fresh, scatter, at.sample)
            # What bends light alone has no use for them.
            path.is_fresh &= ~at.smooth
        at.choice = stream.next_float32()
        if self._first is not None:
            at.choice = dr.select(path.steps == 1, choices.y, at.choice)
            at.choice = dr.select(path.steps == 0, choices.x, at.choice)
        at.respond = respond_by(at.bsdf, at.si)
        if self._reader is not None:
            self._reader.keep_coat(path, at)

    def _ask_lights(self, path: Path, at: Vertex) -> None:
        """Count light that vertices send on by next-event."""
        scene, stream = self._scene, path.stream
        if path.share is not None:
            path.share = mi.Float(1.0)
        if scene.lights.count:
            light = next_event(scene, at.si, at.light_sample, at.respond, at.smooth)
            amount = path.throughput * light / at.chance
            if scene.spots is not None:
                amount = self._ask_spots(path, at, amount)
            path.radiance = path.radiance + amount
            if scene.mirrors is not None:
                sample = mi.Point2f(stream.next_float32(), stream.next_float32())
                rest = self._rest(path.depth)
                light = mirrored_light(scene, at.si, sample, stream, at.respond, at.smooth, rest)
                path.radiance = path.radiance + path.throughput * light / at.chance
        if scene.bent is not None:
            rest, is_first = self._rest(path.depth), ~path.is_answered
            is_seen = self._is_traced(path, at) if self._is_camera else None
            light = scene.bent.light(
                at.si, stream, at.respond, at.smooth, path.dispersed, rest, is_first, is_seen
            )
            path.radiance = path.radiance + path.throughput * light
        if self._reader is not None:
            self._reader.ask_spots(path, at)

    def _is_traced(self, path: Path, at: Vertex):
        """Whether light that is traced to the camera reaches a vertex: at once in view, and met by light."""
        is_seen = path.depth == 0
        if self._scene.unlit is not None:
            number = dr.reinterpret_array(mi.UInt32, at.si.shape)
            is_seen &= ~dr.gather(mi.Bool, self._scene.unlit, number, at.smooth)
        return is_seen

    def _ask_spots(self, path: Path, at: Vertex, amount):
        """Light by next-event, ``amount``, and by bright spots, each as far as it counts."""
        path.share = dr.select(path.way <= LONGEST_WAY, path.next_share, 1.0)
        asks = at.smooth if self._last is None else at.smooth & (path.depth < self._last)
        rest = self._rest(path.depth + 1)
        light = spotted_light(self._scene, at.si, path.stream, at.respond, asks, rest)
        return amount * path.share + path.throughput * light

    def _rest(self, depth):
        """Most reflections that light may still have had, None where there is no limit."""
        if self._last is None:
            return None
        return mi.UInt32(self._last - dr.minimum(depth, self._last))

    def _scatter(self, path: Path, at: Vertex):
        """Send paths on; returns the sample and which of them do not go straight."""
        scene, si, is_hidden = self._scene, at.si, at.is_hidden
        bs, scattered = at.bsdf.sample(mi.BSDFContext(), si, at.choice, at.sample, path.active)
        if self._reader is not None:
            scattered = self._reader.scatter(at, bs, scattered)
        turned = path.active & ~is_hidden & ~mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)
        direction = dr.select(is_hidden, path.ray.d, si.to_world(bs.wo))
        throughput = dr.select(is_hidden, path.throughput, path.throughput * scattered)
        throughput, path.dispersed = disperse(scene, bs, throughput, path.dispersed, turned)
        factor, path.polar = polarise(
            scene, si, path.ray.d, direction, path.polar, turned, path.active & ~is_hidden
        )
        path.throughput = throughput * factor
        left = dr.maximum(path.ray.maxt - si.t, 0.0)
        path.ray = spawn_ray(scene, si, direction)
        if self._is_camera:
            # The end of the camera's clipping holds for what is seen straight.
            path.ray.maxt = dr.select(turned, dr.largest(mi.Float), left)
        return bs, turned

    def _note_reference(self, path: Path, at: Vertex, bs, turned) -> None:
        """Note what the next hit has to be weighed against."""
        scene, si, direction = self._scene, at.si, path.ray.d
        is_delta = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
        anew = turned
        if scene.mirrors is not None:
            # Behind a plane mirror the path goes on as if from the image of its last vertex.
            number = scene.mirror_at(si, turned)
            is_mirrored = turned & (number > 0)
            image = si.p - direction * dr.norm(si.p - path.reference)
            path.reference = dr.select(is_mirrored, image, path.reference)
            path.chain = scene.mirrors.extend(path.chain, number, is_mirrored, turned)
            anew = turned & ~is_mirrored
            if self._reader is not None:
                self._reader.see_mirror(path, is_mirrored)
        if self._left_out is not None:
            spreads = turned & ~is_delta
            # Where vertices do not ask for light over bends it is traced to matt surfaces.
            answers = mi.Bool(True) if scene.bent is not None else at.row > 0
            path.is_answered = dr.select(spreads, answers, path.is_answered)
            path.bent = dr.select(spreads, False, path.bent | (anew & is_delta))
        if scene.spots is not None:
            self._see_spots(path, at, bs, turned & ~is_delta)
        path.pdf = dr.select(anew, dr.select(is_delta, 0.0, bs.pdf), path.pdf)
        path.reference = dr.select(anew, si.p, path.reference)
        if self._reader is not None:
            self._reader.leave(path, anew, turned, is_delta)
        path.eta = dr.select(turned, path.eta * bs.eta, path.eta)
        path.depth = dr.select(turned, path.depth + 1, path.depth)
        path.steps += 1

    def _see_spots(self, path: Path, at: Vertex, bs, spreads) -> None:
        """Note what the next vertex counts of the lamps' light beside rays to bright spots."""
        leaves_anew = spreads & at.smooth
        passes = path.active & ~at.is_hidden & ~scatters(at.bsdf)
        passes &= bs.sampled_component != DISPERSED_COMPONENT
        way = dr.select(passes, dr.minimum(path.way, LONGEST_WAY) + 1, LONGEST_WAY + 1)
        path.way = dr.select(leaves_anew, 0, way)
        rival = self._scene.spots.density(at.si.p, path.ray.d)
        next_share = power_heuristic(bs.pdf, rival)
        path.next_share = dr.select(leaves_anew, next_share, path.next_share)
        path.share = dr.select(spreads, path.share, 1.0)

    def _play_roulette(self, path: Path, at: Vertex, turned) -> None:
        """End paths that bring little."""
        left = dr.max(path.throughput) * dr.square(path.eta)
        survival = dr.minimum(left if self._faded is None else left / self._faded, SURVIVAL)
        tried = turned & ((path.depth >= ROULETTE_START) | at.is_readable)
        is_lit = dr.any(path.throughput != 0.0) & (path.steps < MAXIMUM_STEPS)
        goes_on = ~tried | (path.stream.next_float32() < survival)
        throughput = path.throughput / dr.maximum(survival, 1e-20)
        path.throughput = dr.select(tried, throughput, path.throughput)
        # A path that ends with a share that is no number is lost even if it has met no light since, and is to be counted.
        is_number = ~path.active | dr.isfinite(dr.sum(path.throughput))
        path.radiance = dr.select(is_number, path.radiance, dr.nan)
        path.active &= is_lit & goes_on & is_number
        if self._last is not None:
            path.active &= path.depth <= self._last + 1


def _ray_weight(pdf, found):
    """Weight of what a ray with density ``pdf`` runs into, which next-event would have found with another; 1 without one."""
    return dr.select(pdf > 0.0, power_heuristic(pdf, found), 1.0)
