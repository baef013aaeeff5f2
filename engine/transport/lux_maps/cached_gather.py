"""Radiance along rays that ends at the first cell: the path loop, but what matt surfaces send is read.

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

from ..compiled.polarisation import polarise
from ..compiled.textures import is_spectral
from ..paths.path_loop import Path, PathLoop
from ..paths.visibility import meet
from ..rays import spawn_ray
from .cell_reader import MIRRORED, CellReader, locate, matt_response, weigh_against_guide


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
    spread=None,
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
    spread : Float or None    As of `cell_reader.locate`.

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
        None if spread is None else mi.Float(spread),
    )
    if not reads and scene.transparent is None:
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


@dataclass
class _Rays:
    """Rays from receivers; parameters as of `incoming`, and of what panes have done to them.

    ``number``: of the ray. ``length``, ``last``, ``chance``: of the chain of known mirrors met, see `MirrorSet.extend`.
    ``polar``: polarisation, None where the scene needs none. ``is_read``: whether the base of what they meet has been read.
    ``spread``: see `cell_reader.locate`.
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
    spread: object

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
    hit, si = meet(scene, rays.ray, active)
    valid = active & si.is_valid()
    is_dark = scene.emitter(si, valid) == None  # noqa: E711 - element-wise
    readable, mirrored = mi.Bool(False), mi.Bool(False)
    traced = value = mi.Spectrum(0.0)
    if reads:
        row, coat, side, local, readable = locate(
            cells, hit, si, rays.reference, valid, rays.spread
        )
        readable &= is_dark
        bsdf = scene.bsdf(si, readable)
        matte = matt_response(cells, bsdf, si, row, coat, readable)
        if guide is not None:
            rival = guide, rays.reference, rays.guided_ratio
            matte *= weigh_against_guide(*rival, si, side, local, rays.scatter_pdf, readable)
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
    if scene.transparent is not None:
        flags = scene.bsdf(si, valid & ~readable).flags()
        forks = valid & ~readable & mi.has_flag(flags, mi.BSDFFlags.Null)
        forks &= mi.has_flag(flags, mi.BSDFFlags.DeltaReflection)
        forks &= ~mi.has_flag(flags, mi.BSDFFlags.Smooth) & is_dark
    return traced, value, goes_on & ~forks, forks


def _fork(scene, rays: _Rays) -> list[_Rays]:
    """What a pane mirrors and what it lets through, where rays meet one first.

    Following one of them by chance would scatter: lamps that are seen in a window are bright, and seldom chosen.
    """
    _, si = meet(scene, rays.ray, mi.Bool(True))
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


def _follow(scene, cells, rays: _Rays, active, left_out, reads, guide):
    """Follow rays to their ends; returns as `incoming`."""
    path = Path(
        rays.ray,
        mi.PCG32(rays.stream),
        mi.Float(rays.scatter_pdf),
        mi.Point3f(rays.reference),
        mi.UInt32(rays.depth),
        mi.Bool(active),
        throughput=mi.Spectrum(rays.throughput),
        chain=(mi.UInt32(rays.length), mi.UInt32(rays.last), mi.Float(rays.chance)),
        polar=mi.Vector3f(0.0) if rays.polar is None else mi.Vector3f(rays.polar),
        ratio=mi.Float(rays.ratio),
        read=mi.Spectrum(0.0),
        is_read=mi.Bool(rays.is_read),
        is_asked=mi.Bool(False),
        spread=None if rays.spread is None else mi.Float(rays.spread),
    )
    if left_out is not None:
        # Traced light lands on receivers and matt surfaces only.
        path.bent, path.is_answered = mi.Bool(rays.bent), mi.Bool(True)
    rival = None if guide is None else (guide, rays.reference, rays.guided_ratio)
    reader = CellReader(scene, cells, reads, rays.mirrored_ratio, rival)
    path = PathLoop(scene, left_out, reader=reader).run(path)
    return path.radiance, path.read
