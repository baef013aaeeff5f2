"""Light traced from lights over glass and mirrors to the surfaces where it lands: caustics.

A point, a spot, a sun that shines through a solid glass or by a curved mirror gives light that no path from a receiver
finds: every bend has one direction only. Of a small lamp in a glass body they find so little, and so seldom, that not even
the error tells. So these paths begin at the light. What is traced is exactly what the other estimators leave out, so that
the parts add up:

- the light is ideal, or a luminous surface that a pilot run shows to be hard to find (see `find_bent_lights`);
- on its way it is bent at least once by a perfectly smooth surface that is no plane mirror known to next-event; straight
  passes through panes and cut-outs, and known mirrors, may come before, between and after, but do not count;
- the path ends at the first surface that spreads light out. What is sent on from there is interreflection.

Light of ray sets joins in, see `ray_lights`.
"""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import table_size, upload
from ..compiled.compile import CompiledScene
from ..paths.left_out import LeftOut
from ..paths.sampler import random_stream, sobol_pair
from ..paths.visibility import closest_hit
from ..paths.wavelengths import make_sampler
from .deposits import Deposits, follow, gather_deposits, join
from .emission_rays import SUN, SURFACE, EmissionRays, TracedLight, find_ideal_lights, find_surfaces
from .ray_lights import RayLights
from .targets import find_targets

LANES = 1 << 19
"""Paths per launch."""

PILOT = 1 << 16
"""Paths by which the pairs of lights and targets are compared, shadows included."""

PILOT_SEED = 0x2F6B
"""Of these paths; the same scene always gives the same choice."""

LEAST_SHARE = 1e-3
"""Share of a luminous surface's flux that must come over bends for it to be traced. [-]"""

SMALL_SURFACE = 0.1
"""Radius of a luminous surface over the way of its light, root mean square, below which rays from receivers seldom meet it
over bends. [-]"""

LEARNED = 0.7
"""Share of the choices that follow the pilot run; the rest follows the flux without regard to shadows."""

PAIR_WAVELENGTH, PAIR_PLACE, PAIR_SPREAD = range(3)
"""Which pair of the low-discrepancy sequence serves what; the first one's second number chooses light and target."""


class LightTracer:
    """Traces light of a scene's ideal lights over what bends it, and of its ray sets.

    Parameters
    ----------
    scene : CompiledScene    Must stay as it is while this object is used. Until `close`, next-event leaves out what is
        traced of ray sets.
    has_near : bool    As of `RayLights`.

    Attributes
    ----------
    lights : tuple of TracedLight
    rays : RayLights
    sampler : WavelengthSampler or None    Of the paths; None in photometric variants.
    is_needed : bool    Whether there are both lights to trace and surfaces that bend light, or near light of ray sets.
    reason : str    Why, for people.
    """

    def __init__(self, scene: CompiledScene, has_near: bool = True):
        self.scene = scene
        targets = find_targets(scene)
        self.sampler = make_sampler(scene, "luminance")
        self.lights = find_bent_lights(scene, targets.tree, self.sampler)
        self._bends = bool(self.lights) and targets.tree is not None
        self.rays = RayLights(scene, self.sampler, len(self.lights), has_near)
        try:
            self._prepare(targets)
        except BaseException:
            self.close()
            raise

    def _prepare(self, targets) -> None:
        self.is_needed = self._bends or self.rays.is_needed
        told = [self.rays.reason] if self.rays.is_needed else []
        if self._bends or not told:
            told.append(_explain(self.lights, targets.names))
        self.reason = "; ".join(told)
        if self._bends:
            self._rays = EmissionRays(self.scene, self.lights, targets.tree)
            self._learn()

    def close(self) -> None:
        """Leave all light of the scene to next-event again, as far as that finds it."""
        self.rays.close()

    @property
    def left_out(self) -> LeftOut | None:
        """What rays from receivers must not count, since it is traced; None: nothing that they could find."""
        return left_out_of(self.scene, self.lights) if self._bends else None

    def trace(self, count: int, seed: int, index: int = 0, straight=None) -> Deposits:
        """Trace paths.

        Parameters
        ----------
        count : int    Paths, at least 1; fewer of them land.
        seed : int    Same seed, same result; other seeds are independent.
        index : int    Number of the first sample, to go on with a sequence.
        straight : StraightLights or None    Traced too, as many paths where it is needed.

        Returns
        -------
        Deposits    Each call is an estimate of its own: fluxes are over ``count``.
        """
        landed = self.rays.trace(count, seed, index)
        if straight is not None and straight.is_needed:
            landed += straight.trace(count, seed, index)
        if self._bends:
            for first in range(0, count, LANES):
                width = min(LANES, count - first)
                landed.append(self._launch(width, seed, index + first)[0])
        return join(landed, count, self.sampler is not None)

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
        ray, flux, pair, wavelengths = draw_paths(self._rays, self.sampler, lane, seed)
        end = follow(self.scene, ray, random_stream(lane, seed), dr.any(flux > 0.0))
        made, pairs = gather_deposits(
            end, self.sampler, end["throughput"] * flux, wavelengths, pair
        )
        return replace(made, light=pairs // np.uint32(self._rays.targets)), pairs


def find_bent_lights(scene: CompiledScene, tree, sampler) -> tuple[TracedLight, ...]:
    """Lights whose light over bends has to be traced: ideal ones, and small luminous surfaces.

    The latter are those of which enough comes over bends and which are small for those who look from where it lands.

    Parameters
    ----------
    tree : SphereTree or None    Of what bends light; None: nothing does.
    sampler : WavelengthSampler or None    None in photometric variants.
    """
    ideal = find_ideal_lights(scene)
    found = find_surfaces(scene) if tree is not None else ()
    if not found:
        return ideal
    landed = send_pilot(scene, EmissionRays(scene, found, tree), sampler, PILOT)
    who = landed["light"]
    total = np.array([light.source.flux for light in found])
    radius = np.array([light.source.radius for light in found])
    flux = np.bincount(who, landed["flux"], len(found))
    square = np.minimum(radius[who] / np.maximum(landed["length"], 1e-30), 1.0) ** 2
    square = np.bincount(who, landed["flux"] * square, len(found))
    is_hard = (flux > LEAST_SHARE * total) & (square < SMALL_SURFACE**2 * flux)
    return ideal + tuple(light for light, hard in zip(found, is_hard, strict=True) if hard)


def left_out_of(scene, lights) -> LeftOut | None:
    """What scattered rays must not count of light that is traced; None where they would find none of it."""
    starts = {light.start for light in lights}
    if not starts & {SUN, SURFACE}:
        return None
    numbers = [light.number for light in lights if light.start == SURFACE]
    if not numbers:
        return LeftOut(True)
    table = np.zeros(table_size(scene.lights.count), dtype=bool)
    table[numbers] = True
    surfaces = upload(mi.Bool, table)
    dr.eval(surfaces)
    return LeftOut(SUN in starts, surfaces)


def send_pilot(scene: CompiledScene, rays: EmissionRays, sampler, count: int) -> dict:
    """Trace paths over bends, and tell of each that lands, or leaves the scene, by which line it came.

    Returns
    -------
    dict    Of arrays by path: ``light`` and ``flux`` [lm], its share of the whole; ``start``
        and ``direction`` (m, 3) of the last line, in the scene's frame, and ``way`` along it [m]; ``length`` of the whole
        path; ``reach`` from the light to what it met first [m].
    """
    lane = dr.arange(mi.UInt32, count)
    seed = dr.opaque(mi.UInt32, PILOT_SEED)
    ray, flux, pair, wavelengths = draw_paths(rays, sampler, lane, seed)
    begins = dr.any(flux > 0.0)
    reach = closest_hit(scene, ray, begins).t
    end = follow(scene, ray, random_stream(lane, seed), begins, lambda length: mi.Bool(False))
    last = end["ray"]
    way = closest_hit(scene, last, begins).t
    # Sensors may stand where nothing else does, so light that leaves counts too.
    leaves = (end["bends"] > 0) & ~end["landed"] & ~dr.isfinite(way)
    end["landed"] |= leaves
    way = dr.select(leaves, scene.extent, way)
    length = end["length"] + dr.select(leaves, scene.extent, 0.0)
    told = [mi.Float(pair), *last.o, *last.d, way, length, reach]
    made, told = gather_deposits(end, sampler, end["throughput"] * flux, wavelengths, told)
    told = told.astype(np.float64)
    return {
        "light": told[:, 0].astype(np.int64) // rays.targets,
        "flux": made.flux / count,
        "start": told[:, 1:4],
        "direction": told[:, 4:7],
        "way": told[:, 7],
        "length": told[:, 8],
        "reach": told[:, 9],
    }


def draw_paths(rays: EmissionRays, sampler, lane, seed):
    """Ray of every lane, its flux over density, its pair of light and target, and its wavelengths."""
    first = sobol_pair(lane, seed, PAIR_WAVELENGTH)
    wavelengths = None if sampler is None else sampler.sample(first.x)
    place, spread = (sobol_pair(lane, seed, pair) for pair in (PAIR_PLACE, PAIR_SPREAD))
    ray, flux, pair, _ = rays.draw(first.y, place, spread, wavelengths)
    return ray, flux, pair, wavelengths


def _explain(lights: tuple[TracedLight, ...], names: tuple[str, ...]) -> str:
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
