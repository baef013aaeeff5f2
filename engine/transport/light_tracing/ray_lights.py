"""Light of ray sets: traced with the rays themselves to what is near, left to their distributions of intensity elsewhere.

By the rule of photometry a source may be taken for a point from five times its size on; a narrow beam only from where that
is right within a hundredth (`RayEmission.near`). Light that lands straight within that distance of the source's centre is
traced from the source, and next-event leaves it out there; farther away next-event sees a point with the distribution of
intensity. Light that glass or a curved mirror bends is traced however far it goes.

Where next to nothing lands near or bent, nothing is traced, and next-event counts everywhere. So it does for lights that
have surfaces near that are not matt: what is sent on of traced light is read from cells, which matt surfaces alone have.
Tracing costs more than next-event by far, so of near light only that is traced without which all of a light's would be
wrong by more than `RayEmission.spared`: of a tube in a room what it throws on the ceiling, not what it throws on the walls.
"""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import table_size, upload
from ...scene.ray_emission import RayEmission
from ...scene.scene import content_digest
from ..compiled.diffuse import DiffuseTable
from ..paths.sampler import random_stream, sobol_pair
from ..rays import STEP
from .deposits import Deposits, fetch_deposits, follow, gather_deposits
from .ray_source import RaySource

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

PATHS = 2.0
"""Paths for every one that ideal lights get: what is left to chance is all direct light near them, not a few caustics."""

SALT = 0x51F7
"""Sets these paths apart from others of the same seed."""


class RayLights:
    """Lights from ray sets of a scene.

    Parameters
    ----------
    scene : CompiledScene    Its next-event leaves out what is traced here, until `close`.
    sampler : WavelengthSampler or None    None in photometric variants.
    first : int    Number of the first of these lights in `Deposits`.
    has_near : bool    Whether straight light is traced near them; else they are points everywhere.
    meets_grounds : bool    As of `deposits.follow`.

    Attributes
    ----------
    sources : list of Source    Those that are traced.
    shares : dict of int to float    Share of the flux of all lights from ray sets, by palette row, that lands near or bent.
    limits : dict of int to float    Distance below which their light is traced, likewise. [m]
    is_kept_point : bool    Whether some are taken for points for the sake of surfaces near them.
    is_needed : bool    Whether anything is traced.
    reason : str    Why, for people.
    """

    def __init__(
        self, scene, sampler, first: int = 0, has_near: bool = True, meets_grounds: bool = False
    ):
        self._scene, self._sampler, self._first = scene, sampler, first
        self._has_near, self._meets_grounds = has_near, meets_grounds
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
        self.is_kept_point = False
        self.shares: dict[int, float] = {}
        self.limits: dict[int, float] = {}
        for cloud in self._clouds:
            near = [source.luminaire.rays.near for source in cloud.sources]
            cloud.upload(scene, [1.0] * len(cloud.sources), near)
        self._palette = scene.lights.palette if found else None
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
        if self.is_kept_point:
            text = (
                "a ray set lights what is close by and not matt, so it is taken for a point there"
            )
            self.reason = f"{self.reason}; {text}" if self.reason else text

    def limit_of(self, source) -> float:
        """Distance from a light below which its light is traced; 0 for lights that are not. [m]"""
        if source.luminaire is None or source.luminaire.rays is None:
            return 0.0
        return self.limits.get(self._scene.lights.row_of(source), 0.0)

    def trace(self, count: int, seed: int, index: int = 0) -> list[Deposits]:
        """Trace `PATHS` times ``count`` paths; fluxes of deposits are ``count`` times their share of the estimate. [lm]"""
        made = []
        split = self._split(round(count * PATHS))
        for number, (cloud, width) in enumerate(zip(self._clouds, split, strict=True)):
            for first in range(0, width, LANES):
                lanes = min(LANES, width - first)
                salted = (seed + SALT * (number + 1)) & 0xFFFFFFFF
                made.append(self._launch(cloud, lanes, salted, index + first, count / width)[0])
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
        row_of, limits = self._scene.lights.row_of, np.zeros(self._palette.count)
        matt = DiffuseTable(self._scene)
        for cloud in self._clouds:
            lanes = PILOT * (1 << min((len(cloud.sources) - 1).bit_length(), 5))
            made, who, distance = self._launch(cloud, lanes, PILOT_SEED, 0, 1.0)
            weights, near = np.zeros(len(cloud.sources)), np.zeros(len(cloud.sources))
            shiny = matt.passing(made.shape.astype(np.int64), made.cosine) <= 0.0
            for i, source in enumerate(cloud.sources):
                own = who == i
                landed, way = made.flux[own] / lanes, distance[own]
                near[i] = choose_limit(source.luminaire.rays, landed / source.flux, way)
                lost = landed[shiny[own] & (way >= 0.0) & (way < near[i])].sum()
                if lost > LEAST_SHARE * source.flux or (near[i] > 0.0 and not self._has_near):
                    # What a surface that is not matt makes of traced light, nothing would find.
                    near[i], self.is_kept_point = 0.0, True
                # Bent light is traced in any case.
                landed = landed[(way < near[i]) | (way < 0.0)]
                share = float(landed.sum()) / source.flux
                self.shares[row_of(source)] = share
                if share > LEAST_SHARE:
                    self.sources.append(source)
                    self.limits[row_of(source)] = limits[row_of(source)] = near[i]
                    best = np.sqrt((landed**2).sum() * lanes / len(cloud.sources))
                    weights[i] = FLOOR * source.flux * share + (1.0 - FLOOR) * best
            cloud.weight = float(weights.sum())
            if cloud.weight > 0.0:
                cloud.upload(self._scene, weights, near)
        self._palette.set_limits(limits)

    def sent(self, count: int, seed: int):
        """Send about ``count`` paths; yields how they end, as `follow`, with the flux that arrives and its wavelengths.

        The flux is that of single paths, over their density: [W/nm], [lm] in photometric variants.
        """
        for number, (cloud, width) in enumerate(zip(self._clouds, self._split(count), strict=True)):
            salted = (seed + SALT * (number + 1)) & 0xFFFFFFFF
            for first in range(0, width, LANES):
                lanes = min(LANES, width - first)
                end, power, wavelengths, is_lumens, _ = self._send(
                    cloud, lanes, salted, first, 1.0 / width
                )
                if is_lumens:
                    power = self._sampler.from_lumens(power, wavelengths)
                yield end, power, wavelengths

    def _launch(self, cloud: "_Cloud", width, seed, index, over):
        """Run one kernel. ``over``: what fluxes are multiplied by.

        Returns
        -------
        (Deposits, (m,) array, (m,) array)    Also the place of each one's light in the cloud, and the distance of where it
            landed from the light's centre, -1 after a bend. [m]
        """
        end, power, wavelengths, is_lumens, told = self._send(cloud, width, seed, index, over)
        if is_lumens:
            parts = list(power)
            made, told = fetch_deposits(end, sum(parts[1:], parts[0]), wavelengths, parts, told)
        else:
            made, told = gather_deposits(end, self._sampler, power, wavelengths, told)
        number = told[:, 0].astype(np.uint32)
        return replace(made, light=number + np.uint32(self._first)), number, told[:, 1]

    def _send(self, cloud: "_Cloud", width, seed, index, over):
        """How paths end, their flux, wavelengths, whether the flux is in lumens by wavelength, and what is told of each."""
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
        limit = cloud.limit(who)

        def counts_straight(length):
            return dr.norm(from_centre + towards * length) < limit

        end = follow(self._scene, ray, stream, weight > 0.0, counts_straight, self._meets_grounds)
        factor = weight * dr.opaque(mi.Float, float(over)) / chance
        distance = dr.norm(from_centre + towards * end["length"])
        told = [mi.Float(who), dr.select(end["bends"] > 0, -1.0, distance)]
        if own is None or self._sampler is None:
            power = self._palette.spectrum(row, wavelengths, True) * factor * end["throughput"]
            return end, power, wavelengths, False, told
        # A ray with a wavelength of its own carries lumens of that one; after dispersion all of it is in the first part.
        return end, 0.25 * cloud.flux(who) * factor * end["throughput"], wavelengths, True, told


def choose_limit(rays: RayEmission, shares: np.ndarray, distances: np.ndarray) -> float:
    """Choose the distance below which light is traced, so that the rest is right within its ``spared``.

    Parameters
    ----------
    rays : RayEmission
    shares : (n,) array    Of the light's flux, that landed within the near distance. [-]
    distances : (n,) array    Where it landed, from the light's centre; below 0 what was bent. [m]

    Returns
    -------
    float    At most the near distance. [m]
    """
    straight = distances >= 0.0
    order = np.argsort(-distances[straight])
    far = distances[straight][order]
    squares = np.cumsum(shares[straight][order] * rays.point_errors(far) ** 2)
    spared = int(np.searchsorted(squares, rays.spared**2, side="right"))
    if spared == len(far):
        return 0.0
    return float(min(far[spared] * (1.0 + 1e-6), rays.near))


class _Cloud:
    """Lights that share a ray set. Rows of its table: nine numbers of the axes, the centre, the flux, the limit."""

    COLUMNS = 14

    def __init__(self, rays: RaySource):
        self.rays = rays
        self.sources = []
        self.weight = 0.0

    def upload(self, scene, weights, limits) -> None:
        """Set how often each light is chosen, up to a factor, and the distances below which its light is traced. [m]"""
        share = np.asarray(weights, dtype=np.float64)
        share = share / share.sum()
        # Of a length that is a power of two, since kernels have it in them.
        steps, chances = np.full((2, table_size(len(share))), 2.0)
        last = np.flatnonzero(share)[-1]
        steps[:last] = np.cumsum(share)[:last]
        chances[: len(share)] = np.maximum(share, 1e-9)
        self._cdf, self._share = upload(mi.Float, steps), upload(mi.Float, chances)
        rows = np.zeros((len(share), self.COLUMNS))
        for line, source, limit in zip(rows, self.sources, limits, strict=True):
            line[:9] = source.luminaire.rotation.T.ravel()
            line[9:12], line[12:] = source.luminaire.centre, (source.flux, limit)
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

    def limit(self, who):
        """Distance from the light below which its light counts. [m]"""
        return dr.gather(mi.Float, self._rows, who * self.COLUMNS + 13)

    def row(self, who):
        """Row of the light in the palette."""
        return dr.gather(mi.UInt32, self._palette_rows, who)

    def _three(self, who, first: int):
        base = who * self.COLUMNS + first
        return mi.Vector3f(*(dr.gather(mi.Float, self._rows, base + k) for k in range(3)))
