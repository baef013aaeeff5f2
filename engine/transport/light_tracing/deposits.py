"""Where light of paths that begin at a light lands: the first surfaces that spread it out.

Surface models state how radiance is scattered on its way from the eye. The flux that a path carries here is not denser in
a denser body, so the square of the relative index that they apply is taken back (E. Veach: Robust Monte Carlo Methods for
Light Transport Simulation, 1997, 5.2). Where shading normals stand for a curved surface, a facet sends on all flux that it
receives: the mesh is an approximation of the curved body, and that conserves energy.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ..compiled.compile import CompiledScene
from ..paths.gather import photometric
from ..paths.sampler import random_stream
from ..paths.visibility import first_ground, meet
from .bent_rays import BentRays

CRACK = 4e-6
"""How far beside a ray others have to land too, relative to the scene's radius: rays of single precision slip between faces
that touch without sharing their corners. [-]"""

ALIKE = 0.01
"""Difference of the lengths of their ways, relative to these, up to which two rays land in one place. [-]"""

TURN = 0.4
"""Of the directions across: no side runs along the edges of a model that is square to its axes. [rad]"""

PLACE = ("shape", "prim", "uv", "back", "cosine", "geometric_cosine")
"""What is told of where a ray lands, by names as of `Deposits`."""

MAXIMUM_STEPS = 4096
"""Stops a path between surfaces of which numerical trouble would let none end it."""


@dataclass(frozen=True)
class Deposits:
    """Where light of traced paths landed, in a fixed order: the same seed gives the same arrays.

    Parameters
    ----------
    shape : (m,) uint32    Number of the shape, see `arrays.pointer_id`.
    prim : (m,) uint32    Triangle of it.
    uv : (m, 2) float32    Barycentric coordinates in the triangle, of its second and third corner.
    back : (m,) bool    Whether light came from behind the geometric normal.
    flux : (m,) float64    Share of the estimate: the sum is the light that lands on the whole. [lm]
    cosine : (m,) float32    Of the incident direction to the shading normal, of the side that is lit. [-]
    geometric_cosine : (m,) float32    The same to the geometric normal: flux over area is the illuminance by that normal,
        times ``cosine`` over this one it is that by the shading normal.
    light : (m,) uint32    Place among the tracer's ``lights``.
    wavelengths : (m, 4) float32 or None    Of the path, None in photometric variants. [nm]
    parts : (m, 4) float32 or None    Flux by wavelength; their sum is ``flux``. [lm]
    lost : int    Paths that landed with what is no number, and are not among them.
    """

    shape: np.ndarray
    prim: np.ndarray
    uv: np.ndarray
    back: np.ndarray
    flux: np.ndarray
    cosine: np.ndarray
    geometric_cosine: np.ndarray
    light: np.ndarray
    wavelengths: np.ndarray | None = None
    parts: np.ndarray | None = None
    lost: int = 0

    def only(self, kept: np.ndarray) -> "Deposits":
        """Some of them. ``kept``: as an index of arrays."""
        columns = {name: getattr(self, name) for name in COLUMNS}
        return replace(self, **{n: None if c is None else c[kept] for n, c in columns.items()})


COLUMNS = tuple(entry.name for entry in fields(Deposits) if entry.name != "lost")
"""Fields with an entry for each deposit."""


def follow(
    scene: CompiledScene,
    ray,
    stream,
    active,
    counts_straight: Callable | None = None,
    meets_grounds: bool = False,
) -> dict:
    """Follow rays until they land, leave or are absorbed.

    Parameters
    ----------
    scene : CompiledScene
    ray : Ray3f
    stream : PCG32
    active : Bool
    counts_straight : callable or None    From the length [m] of a way that was not bent to whether light that lands there
        counts, and is not left to next-event; None: it never does. Panes, cut-outs and known mirrors do not bend.
    meets_grounds : bool    Whether light that counts also lands on grounds which only the camera meets.

    Returns
    -------
    dict    ``landed`` and, where it holds, ``throughput`` (share of the flux that arrived), ``shape``, ``prim``, ``uv``,
        ``back``, ``cosine`` and ``geometric_cosine`` of `Deposits`; ``bends``, and ``length`` of the way where straight ones
        may count.
    """
    has_length = counts_straight is not None

    def body(rays, landed, place, length):
        hit, si = meet(scene, rays.ray, rays.active)
        is_ground = mi.Bool(False)
        if meets_grounds:
            bent = rays.active & (rays.bends > 0)
            ground, distance = first_ground(scene, rays.ray, bent)
            is_ground = bent & ground.is_valid() & (distance <= hit.t)
            hit = dr.select(is_ground, ground, hit)
            si = scene.surface(hit, rays.ray, rays.active)
        rays.active &= si.is_valid()
        bsdf = scene.bsdf(si, rays.active)
        flags = bsdf.flags()
        # Straight passes are among Mitsuba's Delta.
        goes_on = mi.has_flag(flags, mi.BSDFFlags.Delta) & ~is_ground
        counts = rays.bends > 0
        if has_length:
            length = dr.select(rays.active, length + hit.t, length)
            counts |= counts_straight(length)
        arrives = rays.active & (mi.has_flag(flags, mi.BSDFFlags.Smooth) | is_ground) & counts
        # Where a part of the light goes on (a cut-out), one of the two is followed, at twice its amount.
        rays.throughput = dr.select(arrives & goes_on, 2.0 * rays.throughput, rays.throughput)
        lands = arrives & (~goes_on | (rays.stream.next_float32() < 0.5))
        found = _place_of(hit, si, rays.ray)
        place = tuple(dr.select(lands, new, old) for new, old in zip(found, place, strict=True))
        rays.active &= ~lands & goes_on
        turned = rays.go_on(scene, si, *bend(si, bsdf, rays.stream, rays.active))
        rays.play_roulette(turned, MAXIMUM_STEPS)
        return rays, landed | lands, place, length

    nowhere = (
        mi.UInt32(0), mi.UInt32(0), mi.Point2f(0.0), mi.Bool(False), mi.Float(0.0), mi.Float(0.0),
    )  # fmt: skip
    rays = BentRays(mi.Ray3f(ray), mi.PCG32(stream), mi.Bool(active))
    rays, landed, place, length = dr.while_loop(
        state=(rays, mi.Bool(False), nowhere, mi.Float(0.0) if has_length else None),
        cond=lambda rays, *_: rays.active,
        body=body,
        labels=("rays", "landed", "place", "length"),
    )
    end = {"ray": rays.ray, "throughput": rays.throughput, "bends": rays.bends, "landed": landed}
    return end | dict(zip(PLACE, place, strict=True)) | {"length": length}


def lands_beside(scene: CompiledScene, ways: np.ndarray, made: Deposits) -> np.ndarray:
    """Whether rays beside some that landed straight do so too, on the same side of the same shape.

    Parameters
    ----------
    scene : CompiledScene
    ways : (m, 7) array    Length of the way [m], origin [m] and direction of each.
    made : Deposits    Where they landed.

    Returns
    -------
    (m,) bool array    Whether any does of four, one in each direction across.
    """
    count = len(ways)
    if not count:
        return np.zeros(0, dtype=bool)
    lane = dr.arange(mi.UInt32, 4 * count)
    row = lane // 4
    table = upload(mi.Float, np.asarray(ways, dtype=np.float32))
    length, *values = (dr.gather(mi.Float, table, row * 7 + k) for k in range(7))
    ray = mi.Ray3f(mi.Point3f(*values[:3]), mi.Vector3f(*values[3:]))
    if made.wavelengths is not None:
        known = upload(mi.Float, made.wavelengths)
        ray.wavelengths = mi.Spectrum(*(dr.gather(mi.Float, known, row * 4 + k) for k in range(4)))
    angle = mi.Float(lane % 4) * (0.5 * dr.pi) + TURN
    frame = mi.Frame3f(ray.d)
    across = frame.s * dr.cos(angle) + frame.t * dr.sin(angle)
    ray.o += across * dr.opaque(mi.Float, CRACK * float(scene.radius))
    always = mi.Bool(True)
    end = follow(scene, ray, random_stream(lane, mi.UInt32(0)), always, lambda _: always)
    lands = end["landed"] & (end["bends"] == 0)
    lands &= dr.abs(end["length"] - length) < ALIKE * length
    lands &= end["shape"] == dr.gather(mi.UInt32, upload(mi.UInt32, made.shape), row)
    lands &= end["back"] == dr.gather(mi.Bool, upload(mi.Bool, made.back), row)
    return np.array(lands).reshape(count, 4).any(axis=1)


def _place_of(hit, si, ray) -> tuple:
    """Where a ray lands, in the order of `PLACE`."""
    facing = dr.dot(ray.d, si.n)
    number = dr.reinterpret_array(mi.UInt32, si.shape)
    cosine = dr.abs(mi.Frame3f.cos_theta(si.wi))
    return number, hit.prim_index, hit.prim_uv, facing > 0.0, cosine, dr.abs(facing)


def bend(si, bsdf, stream, active):
    """Draw how a surface sends light on: the sample and the share of the flux over its probability."""
    choice = stream.next_float32()
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    # Of all surfaces only a relief answers light on its way from a lamp otherwise, as its normals are not those of the mesh.
    context = mi.BSDFContext(mi.TransportMode.Importance)
    bs, weight = bsdf.sample(context, si, choice, sample, active)
    return bs, weight * dr.square(bs.eta)


def _only(value, k: int):
    single = mi.Spectrum(0.0)
    single[k] = value[k]
    return single


def _fetch(column, chosen: np.ndarray) -> np.ndarray:
    if isinstance(column, list):
        return np.stack([np.array(c)[chosen] for c in column], axis=1)
    return np.array(column)[chosen]


def join(landed: list[Deposits], count: int, spectral: bool) -> Deposits:
    """One row of deposits, with fluxes over the number of paths."""
    if not landed:
        whole, single = np.zeros(0, np.uint32), np.zeros(0, np.float32)
        four = np.zeros((0, 4), np.float32) if spectral else None
        pairs = np.zeros((0, 2), np.float32)
        return Deposits(
            whole, whole, pairs, np.zeros(0, bool), np.zeros(0), single, single, whole, four, four
        )
    made = {}
    for name in COLUMNS:
        columns = [getattr(part, name) for part in landed]
        made[name] = None if columns[0] is None else np.concatenate(columns)
    made["flux"] = made["flux"] / count
    if made["parts"] is not None:
        made["parts"] = made["parts"] / np.float32(count)
    return Deposits(**made, lost=sum(part.lost for part in landed))


def gather_deposits(
    end: dict, sampler, spectral, wavelengths, light
) -> tuple[Deposits, np.ndarray]:
    """What landed of the paths of a kernel; fluxes are those of single paths.

    Parameters
    ----------
    end : dict    Of `follow`.
    sampler : WavelengthSampler or None    None in photometric variants.
    spectral : Spectrum    Flux over density, by wavelength, as it arrives.
    wavelengths : Spectrum or None    [nm]
    light : UInt32, or list of Float    What is told of every path, see below.

    Returns
    -------
    (Deposits, (m,) or (m, k) array)    ``light`` of the deposits is to be set; the second tells what was given of them.
    """
    amount = photometric(sampler, spectral, wavelengths)
    parts = None
    if sampler is not None:
        parts = [sampler.luminance(_only(spectral, k), wavelengths) for k in range(4)]
    return fetch_deposits(end, amount, wavelengths, parts, light)


def fetch_deposits(end: dict, amount, wavelengths, parts, light) -> tuple[Deposits, np.ndarray]:
    """As `gather_deposits`, for light in lumens: ``amount``, and ``parts`` of it by wavelength."""
    kept = end["landed"] & (amount > 0.0) & dr.isfinite(amount)
    is_lost = end["landed"] & ~dr.isfinite(amount)
    columns = {
        "shape": end["shape"],
        "prim": end["prim"],
        "uv": [end["uv"].x, end["uv"].y],
        "back": end["back"],
        "flux": amount,
        "cosine": end["cosine"],
        "geometric_cosine": end["geometric_cosine"],
    }
    if parts is not None:
        columns["wavelengths"], columns["parts"] = list(wavelengths), parts
    dr.eval(columns, kept, is_lost, light)
    chosen = np.flatnonzero(np.array(kept))
    arrays = {name: _fetch(column, chosen) for name, column in columns.items()}
    arrays["flux"] = arrays["flux"].astype(np.float64)
    told = _fetch(light, chosen)
    lost = int(np.count_nonzero(np.array(is_lost)))
    return Deposits(**arrays, light=np.zeros(len(chosen), np.uint32), lost=lost), told
