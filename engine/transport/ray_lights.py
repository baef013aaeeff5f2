"""Light of ray sets: traced with the rays themselves to what is near, left to their distributions of intensity elsewhere.

By the rule of photometry a source may be taken for a point from five times its size on; a narrow beam only from where that
is right within a hundredth (`RayEmission.near`). Light that lands straight within that distance of the source's centre is
traced from the source, and next-event leaves it out there; farther away next-event sees a point with the distribution of
intensity. Light that glass or a curved mirror bends is traced however far it goes.
Where next to nothing lands near or bent, nothing is traced, and next-event counts everywhere.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ..arrays import table_size, upload
from ..scene.scene import content_digest
from .landing import Deposits, fetch_deposits, follow, gather_deposits
from .ray_source import RaySource
from .rays import STEP
from .sampler import random_stream, sobol_pair

LANES = 1 << 19
"""Paths per launch."""

PILOT = 1 << 14
"""Paths that tell how much of a light lands near or bent."""

PILOT_SEED = 0x3B1D
"""Of these paths; the same scene always gives the same choice."""

LEAST_SHARE = 1e-3
"""Share of a light's flux below which tracing it does not pay."""

FLOOR = 0.3
"""Share of the paths that follow the flux; the rest follows what landed."""

SALT = 0x51F7
"""Sets these paths apart from others of the same seed."""


class RayLights:
    """Lights from ray sets of a scene.

    Parameters
    ----------
    scene : CompiledScene    Its next-event leaves out what is traced here, until `close`.
    sampler : WavelengthSampler or None    None in photometric variants.
    first : int    Number of the first of these lights in `Deposits`.

    Attributes
    ----------
    sources : list of Source    Those that are traced.
    shares : dict of int to float    Share of the flux of all lights from ray sets, by palette row, that lands near or bent.
    is_needed : bool    Whether anything is traced.
    reason : str    Why, for people.
    """

    def __init__(self, scene, sampler, first: int = 0):
        self._scene, self._sampler, self._first = scene, sampler, first
        found = [
            source
            for source in scene.lights.sources
            if source.luminaire is not None
            and source.luminaire.rays is not None
            and len(source.luminaire.rays.threshold)
        ]
        known: dict[bytes, _Cloud] = {}
        for source in found:
            key = content_digest(source.luminaire.rays)
            if key not in known:
                known[key] = _Cloud(RaySource(source.luminaire.rays))
            known[key].sources.append(source)
        self._clouds = list(known.values())
        for cloud in self._clouds:
            cloud.upload(scene, [1.0] * len(cloud.sources))
        self._palette = scene.lights.palette if found else None
        self.shares: dict[int, float] = {}
        self.sources = []
        if found:
            self._learn()
        self.is_needed = bool(self.sources)
        self.reason = ""
        if self.is_needed:
            more = f" and {len(self.sources) - 1} more" if len(self.sources) > 1 else ""
            total = sum(s.flux * self.shares[scene.lights.row_of(s)] for s in self.sources)
            part = total / max(sum(s.flux for s in self.sources), 1e-30)
            self.reason = (
                f"{100.0 * part:.2g} % of the light of {len(self.sources)} ray set"
                f"{'s' if more else ''} lands near them or bent, and is traced from there"
            )

    def trace(self, count: int, seed: int, index: int = 0) -> list[Deposits]:
        """Trace as many paths in all; fluxes of deposits are ``count`` times their share of the estimate. [lm]"""
        made = []
        for number, (cloud, width) in enumerate(zip(self._clouds, self._split(count), strict=True)):
            for first in range(0, width, LANES):
                lanes = min(LANES, width - first)
                salted = (seed + SALT * (number + 1)) & 0xFFFFFFFF
                found, _ = self._launch(cloud, lanes, salted, index + first, count / width)
                made.append(found)
        return made

    def close(self) -> None:
        """Let next-event see these lights as points everywhere again."""
        if self._palette is not None:
            self._palette.set_limits(np.zeros(self._palette.count))

    # ---- private ----

    def _split(self, count: int) -> list[int]:
        """Paths of each cloud; none where nothing lands."""
        wanted = np.array([cloud.weight for cloud in self._clouds])
        if not wanted.sum() > 0.0:
            return [0] * len(wanted)
        return [max(round(count * w / wanted.sum()), 64) if w > 0.0 else 0 for w in wanted]

    def _learn(self) -> None:
        """See what lands of every light, choose those that are traced, and have next-event leave that out."""
        rows, limits = self._scene.lights.row_of, np.zeros(self._palette.count)
        for cloud in self._clouds:
            lanes = PILOT * (1 << min((len(cloud.sources) - 1).bit_length(), 5))
            made, who = self._launch(cloud, lanes, PILOT_SEED, 0, 1.0, is_pilot=True)
            flux = np.array([source.flux for source in cloud.sources])
            sums = np.bincount(who, made.flux, len(flux)) / lanes
            squares = np.bincount(who, made.flux**2, len(flux)) / lanes
            share = sums / np.maximum(flux, 1e-30)
            weights = np.zeros(len(flux))
            for i, source in enumerate(cloud.sources):
                self.shares[rows(source)] = float(share[i])
                if share[i] > LEAST_SHARE:
                    self.sources.append(source)
                    limits[rows(source)] = source.luminaire.rays.near
                    best = np.sqrt(squares[i] / len(flux))
                    weights[i] = FLOOR * source.flux * share[i] + (1.0 - FLOOR) * best
            cloud.weight = float(weights.sum())
            if cloud.weight > 0.0:
                cloud.upload(self._scene, weights)
        self._palette.set_limits(limits)

    def _launch(self, cloud: "_Cloud", width, seed, index, over, is_pilot=False):
        """Run one kernel. ``over``: what fluxes are multiplied by; a pilot gives every light its limit."""
        lane = dr.arange(mi.UInt32, width) + dr.opaque(mi.UInt32, int(index) & 0xFFFFFFFF)
        seed = dr.opaque(mi.UInt32, int(seed) & 0xFFFFFFFF)
        stream = random_stream(lane, seed)
        first = sobol_pair(lane, seed, 0)
        who, chance = cloud.choose(first.y)
        start, direction, weight, own = cloud.rays.draw(stream)
        towards, centre = cloud.to_world(who, direction), cloud.centre(who)
        from_centre = cloud.to_world(who, mi.Vector3f(start))
        row = cloud.row(who)
        wavelengths = None
        if self._sampler is not None:
            wavelengths = self._sampler.sample(first.x) if own is None else mi.Spectrum(own)
        lift = 2.0 * STEP * self._scene.extent
        ray = mi.Ray3f(mi.Point3f(centre + from_centre + towards * lift), towards)
        if wavelengths is not None:
            ray.wavelengths = wavelengths
        limit = cloud.limit

        def counts_straight(length):
            return dr.norm(from_centre + towards * length) < limit

        end = follow(self._scene, ray, stream, weight > 0.0, counts_straight)
        factor = weight * dr.opaque(mi.Float, float(over)) / chance
        light = mi.UInt32(who)
        if own is None or self._sampler is None:
            spectral = self._palette.spectrum(row, wavelengths, True) * factor * end["throughput"]
            made, told = gather_deposits(end, self._sampler, spectral, wavelengths, light)
        else:
            # A ray with a wavelength of its own carries lumens of that one.
            share = cloud.flux(who) * factor * end["throughput"]
            amount = share[0]
            parts = [0.25 * amount] * 4
            made, told = fetch_deposits(end, amount, wavelengths, parts, light)
        return made, told


class _Cloud:
    """Lights that share a ray set. Rows of its table: nine numbers of the axes, the centre, the flux, the palette's row."""

    COLUMNS = 14

    def __init__(self, rays: RaySource):
        self.rays = rays
        self.sources = []
        self.weight = 0.0
        self.limit = dr.opaque(mi.Float, float(rays.emission.near))

    def upload(self, scene, weights) -> None:
        """Set how often each light is chosen, up to a factor."""
        share = np.asarray(weights, dtype=np.float64)
        share = share / share.sum()
        # Of a length that is a power of two, since kernels have it in them.
        limits, chances = np.full((2, table_size(len(share))), 2.0)
        last = np.flatnonzero(share)[-1]
        limits[:last] = np.cumsum(share)[:last]
        chances[: len(share)] = np.maximum(share, 1e-9)
        self._cdf, self._share = upload(mi.Float, limits), upload(mi.Float, chances)
        rows = np.zeros((len(share), self.COLUMNS))
        for line, source in zip(rows, self.sources, strict=True):
            line[:9] = source.luminaire.rotation.T.ravel()
            line[9:12], line[12] = source.luminaire.centre, source.flux
        self._rows = upload(mi.Float, rows)
        self._palette_rows = upload(mi.UInt32, [scene.lights.row_of(s) for s in self.sources])
        dr.eval(self._cdf, self._share, self._rows, self._palette_rows)

    def choose(self, u):
        """Light, and the probability of the choice."""
        last = dr.width(self._cdf) - 1
        who = dr.binary_search(0, last, lambda i: dr.gather(mi.Float, self._cdf, i) <= u)
        return who, dr.gather(mi.Float, self._share, who)

    def to_world(self, who, v):
        """Turn a vector from the light's axes into the scene's frame."""
        x, y, z = (self._three(who, 3 * k) for k in range(3))
        return x * v.x + y * v.y + z * v.z

    def centre(self, who):
        """Where the light is, in the scene's frame. [m]"""
        return self._three(who, 9)

    def flux(self, who):
        """Flux of the light. [lm]"""
        return dr.gather(mi.Float, self._rows, who * self.COLUMNS + 12)

    def row(self, who):
        """Row of the light in the palette."""
        return dr.gather(mi.UInt32, self._palette_rows, who)

    def _three(self, who, first: int):
        base = who * self.COLUMNS + first
        return mi.Vector3f(*(dr.gather(mi.Float, self._rows, base + k) for k in range(3)))
