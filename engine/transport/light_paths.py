"""Light traced from ideal lights over glass and mirrors to the surfaces where it lands: caustics.

A point, a spot, a sun that shines through a solid glass or by a curved mirror gives light that no path from a receiver
finds: every bend has one direction only. So these paths begin at the light. What is traced is exactly what the other
estimators leave out, so that the parts add up:

- the light is ideal (see `emission_rays`);
- on its way it is bent at least once by a perfectly smooth surface that is no plane mirror known to next-event; straight
  passes through panes and cut-outs, and known mirrors, may come before, between and after, but do not count;
- the path ends at the first surface that spreads light out. What is sent on from there is interreflection.

Surface models state how radiance is scattered on its way from the eye. The flux that a path carries here is not denser in
a denser body, so the square of the relative index that they apply is taken back (E. Veach: Robust Monte Carlo Methods for
Light Transport Simulation, 1997, 5.2). Where shading normals stand for a curved surface, a facet sends on all flux that it
receives: the mesh is an approximation of the curved body, and that conserves energy.
"""

from dataclasses import dataclass, fields

import drjit as dr
import mitsuba as mi
import numpy as np

from ..materials.plugins import DISPERSED_COMPONENT
from .compile import CompiledScene
from .emission_rays import EmissionRays, IdealLight, find_lights
from .gather import photometric
from .light_targets import find_targets
from .rays import spawn_ray
from .sampler import random_stream, sobol_pair
from .textures import is_spectral
from .wavelengths import WavelengthSampler

LANES = 1 << 19
"""Paths per launch."""

ROULETTE_START = 4
"""Number of bends before roulette begins."""

SURVIVAL = 0.97
"""Largest probability of going on, so that light that glass holds back for ever ends."""

MAXIMUM_STEPS = 4096
"""Stops a path between surfaces of which numerical trouble would let none end it."""

PILOT = 1 << 16
"""Paths by which the pairs of lights and targets are compared, shadows included."""

PILOT_SEED = 0x2F6B
"""Of these paths; the same scene always gives the same choice."""

LEARNED = 0.7
"""Share of the choices that follow the pilot run; the rest follows the flux without regard to shadows."""

PAIR_WAVELENGTH, PAIR_PLACE, PAIR_SPREAD = range(3)
"""Which pair of the low-discrepancy sequence serves what; the first one's second number chooses light and target."""


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


class LightTracer:
    """Traces light of a scene's ideal lights over what bends it.

    Parameters
    ----------
    scene : CompiledScene    Must stay as it is while this object is used.

    Attributes
    ----------
    lights : tuple of IdealLight
    is_needed : bool    Whether there are both ideal lights and surfaces that bend light.
    reason : str    Why, for people.
    """

    def __init__(self, scene: CompiledScene):
        self.scene = scene
        self.lights: tuple[IdealLight, ...] = find_lights(scene)
        targets = find_targets(scene)
        self.is_needed = bool(self.lights) and targets.tree is not None
        self.reason = _explain(self.lights, targets.names)
        self._sampler = None
        if is_spectral():
            self._sampler = WavelengthSampler(scene.mean_light, "luminance")
        if self.is_needed:
            self._rays = EmissionRays(scene, self.lights, targets.tree)
            self._learn()

    @property
    def has_suns(self) -> bool:
        """Whether suns are among the lights: scattered rays meet them too, over ideal glass and mirrors."""
        return any(light.source is None for light in self.lights)

    def trace(self, count: int, seed: int, index: int = 0) -> Deposits:
        """Trace paths.

        Parameters
        ----------
        count : int    Paths, at least 1; fewer of them land.
        seed : int    Same seed, same result; other seeds are independent.
        index : int    Number of the first sample, to go on with a sequence.

        Returns
        -------
        Deposits    Each call is an estimate of its own: fluxes are over ``count``.
        """
        landed = []
        if self.is_needed:
            for first in range(0, count, LANES):
                width = min(LANES, count - first)
                landed.append(self._launch(width, seed, index + first)[0])
        return _join(landed, count, self._sampler is not None)

    def _learn(self) -> None:
        """Choose pairs by what lands of their light, so that a lamp in a closed room next door costs little."""
        landed, pairs = self._launch(PILOT, PILOT_SEED, 0)
        first = self._rays.shares
        # The best choice follows the root of the mean square of what one pair alone would give.
        squares = np.bincount(pairs, weights=landed.flux**2, minlength=self._rays.pairs)
        wanted = np.sqrt(squares * first)
        if wanted.sum() > 0.0:
            self._rays.set_shares((1.0 - LEARNED) * first + LEARNED * wanted / wanted.sum())

    def _launch(self, width: int, seed: int, index: int) -> tuple[Deposits, np.ndarray]:
        """Run one kernel; fluxes are those of single paths. Also the pair of light and target of every deposit."""
        lane = dr.arange(mi.UInt32, width) + dr.opaque(mi.UInt32, int(index) & 0xFFFFFFFF)
        seed = dr.opaque(mi.UInt32, int(seed) & 0xFFFFFFFF)
        first = sobol_pair(lane, seed, PAIR_WAVELENGTH)
        wavelengths = None if self._sampler is None else self._sampler.sample(first.x)
        ray, flux, pair = self._rays.draw(
            first.y,
            sobol_pair(lane, seed, PAIR_PLACE),
            sobol_pair(lane, seed, PAIR_SPREAD),
            wavelengths,
        )
        end = _follow(self.scene, ray, random_stream(lane, seed), dr.any(flux > 0.0))
        spectral = end["throughput"] * flux
        amount = photometric(self._sampler, spectral, wavelengths)
        kept = end["landed"] & (amount > 0.0) & dr.isfinite(amount)
        columns = {
            "shape": end["shape"],
            "prim": end["prim"],
            "uv": [end["uv"].x, end["uv"].y],
            "back": end["back"],
            "flux": amount,
            "cosine": end["cosine"],
            "geometric_cosine": end["geometric_cosine"],
        }
        if self._sampler is not None:
            columns["wavelengths"] = list(wavelengths)
            columns["parts"] = [
                self._sampler.luminance(_only(spectral, k), wavelengths) for k in range(4)
            ]
        dr.eval(columns, kept, pair)
        chosen = np.flatnonzero(np.array(kept))
        arrays = {name: _fetch(column, chosen) for name, column in columns.items()}
        arrays["flux"] = arrays["flux"].astype(np.float64)
        pairs = _fetch(pair, chosen)
        return Deposits(**arrays, light=pairs // np.uint32(self._rays.targets)), pairs


def _only(value, k: int):
    single = mi.Spectrum(0.0)
    single[k] = value[k]
    return single


def _fetch(column, chosen: np.ndarray) -> np.ndarray:
    if isinstance(column, list):
        return np.stack([np.array(c)[chosen] for c in column], axis=1)
    return np.array(column)[chosen]


def _join(landed: list[Deposits], count: int, spectral: bool) -> Deposits:
    """One row of deposits, with fluxes over the number of paths."""
    if not landed:
        whole, single = np.zeros(0, np.uint32), np.zeros(0, np.float32)
        four = np.zeros((0, 4), np.float32) if spectral else None
        pairs = np.zeros((0, 2), np.float32)
        return Deposits(
            whole, whole, pairs, np.zeros(0, bool), np.zeros(0), single, single, whole, four, four
        )
    made = {}
    for entry in fields(Deposits):
        columns = [getattr(part, entry.name) for part in landed]
        made[entry.name] = None if columns[0] is None else np.concatenate(columns)
    made["flux"] = made["flux"] / count
    if made["parts"] is not None:
        made["parts"] = made["parts"] / np.float32(count)
    return Deposits(**made)


def _explain(lights: tuple[IdealLight, ...], names: tuple[str, ...]) -> str:
    if not lights:
        return "all light comes from surfaces that paths from receivers find"
    if not names:
        return "no smooth glass, pane or curved mirror bends the light of points, spots and suns"
    kinds: dict[str, int] = {}
    for light in lights:
        kinds[light.kind] = kinds.get(light.kind, 0) + 1
    shining = ", ".join(f"{number} x {kind}" for kind, number in kinds.items())
    more = f" and {len(names) - 1} more" if len(names) > 1 else ""
    return f"'{names[0]}'{more} may bend light of {shining}, which only paths from the lights find"


def _follow(scene: CompiledScene, ray, stream, active) -> dict:
    """Follow rays until they land, leave or are absorbed.

    Returns
    -------
    dict    ``landed`` and, where it holds, ``throughput`` (share of the flux that arrived), ``shape``, ``prim``, ``uv``,
        ``back``, ``cosine`` and ``geometric_cosine`` of `Deposits`.
    """
    state = {
        "ray": mi.Ray3f(ray),
        "stream": mi.PCG32(stream),
        "throughput": mi.Spectrum(1.0),
        "bends": mi.UInt32(0),
        "steps": mi.UInt32(0),
        "dispersed": mi.Bool(False),
        "active": mi.Bool(active),
        "landed": mi.Bool(False),
        "shape": mi.UInt32(0),
        "prim": mi.UInt32(0),
        "uv": mi.Point2f(0.0),
        "back": mi.Bool(False),
        "cosine": mi.Float(0.0),
        "geometric_cosine": mi.Float(0.0),
    }

    def body(ray, stream, throughput, bends, steps, dispersed, active, landed, *place):
        hit, si = _meet(scene, ray, active)
        active &= si.is_valid()
        bsdf = scene.bsdf(si, active)
        flags = bsdf.flags()
        # Straight passes are among Mitsuba's Delta.
        goes_on = mi.has_flag(flags, mi.BSDFFlags.Delta)

        # ---- landing ----
        arrives = active & mi.has_flag(flags, mi.BSDFFlags.Smooth) & (bends > 0)
        # Where a part of the light goes on (a cut-out), one of the two is followed, at twice its amount.
        throughput = dr.select(arrives & goes_on, 2.0 * throughput, throughput)
        lands = arrives & (~goes_on | (stream.next_float32() < 0.5))
        found = _place_of(hit, si, ray)
        place = tuple(dr.select(lands, new, old) for new, old in zip(found, place, strict=True))
        landed |= lands

        # ---- going on ----
        active &= ~lands & goes_on
        bs, weight = _bend(si, bsdf, stream, active)
        active &= mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
        straight = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)
        bent = active & ~straight
        throughput = dr.select(active, throughput * weight, throughput)
        if scene.requirements.dispersive:
            splits = bent & (bs.sampled_component == DISPERSED_COMPONENT) & ~dispersed
            hero = mi.Spectrum(0.0)
            hero[0] = 4.0 * throughput[0]
            throughput = dr.select(splits, hero, throughput)
            dispersed |= splits
        counts = mi.Bool(bent)
        if scene.is_mirror is not None:
            ids = dr.reinterpret_array(mi.UInt32, si.shape)
            counts &= ~dr.gather(mi.Bool, scene.is_mirror, ids, bent)
        bends = dr.select(counts, bends + 1, bends)
        # Straight means straight: turned into the surface's frame and back, rays would drift.
        onwards = spawn_ray(scene, si, dr.select(straight, ray.d, si.to_world(bs.wo)))
        onwards.wavelengths = ray.wavelengths
        ray = dr.select(active, onwards, ray)
        steps += 1

        # ---- roulette ----
        tried = bent & (bends >= ROULETTE_START)
        survival = dr.minimum(dr.max(throughput), SURVIVAL)
        active &= ~tried | (stream.next_float32() < survival)
        throughput = dr.select(tried & active, throughput / survival, throughput)
        active &= dr.any(throughput != 0.0) & (steps < MAXIMUM_STEPS)
        return ray, stream, throughput, bends, steps, dispersed, active, landed, *place

    result = dr.while_loop(
        state=tuple(state.values()),
        cond=lambda *values: values[6],
        body=body,
        labels=tuple(state),
    )
    return dict(zip(state, result, strict=True))


def _meet(scene: CompiledScene, ray, active):
    """Nearest hit of both sub-scenes, and the surface there."""
    hit = scene.solid.ray_intersect_preliminary(ray, False, active)
    if scene.veil is not None:
        other = scene.veil.ray_intersect_preliminary(ray, False, active)
        hit = dr.select(other.t < hit.t, other, hit)
    si = scene.surface(hit, ray, active)
    if is_spectral():
        si.wavelengths = ray.wavelengths
    return hit, si


def _place_of(hit, si, ray) -> tuple:
    """Where a ray lands, in the order of `Deposits`, without the flux."""
    facing = dr.dot(ray.d, si.n)
    number = dr.reinterpret_array(mi.UInt32, si.shape)
    cosine = dr.abs(mi.Frame3f.cos_theta(si.wi))
    return number, hit.prim_index, hit.prim_uv, facing > 0.0, cosine, dr.abs(facing)


def _bend(si, bsdf, stream, active):
    """Draw how a surface sends light on: the sample and the share of the flux over its probability."""
    choice = stream.next_float32()
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    bs, weight = bsdf.sample(mi.BSDFContext(), si, choice, sample, active)
    return bs, weight * dr.square(bs.eta)
