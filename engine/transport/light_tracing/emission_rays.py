"""Rays from lights, aimed at what may bend them.

Ideal lights are those that no scattered ray meets: points, spots, luminaires without an opening, and suns, which a ray
meets too seldom to count. Luminous surfaces may be as hard to find behind glass where they are small. A pair of a light
and a target is drawn, of a surface a place on it, then a direction in the cone that the target's sphere fills as seen
from there (a place on the sphere's cross-section for a sun). Spheres may overlap: the flux of a ray is divided by the
density with which all targets together would have drawn it, so every direction counts once.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import average, table_size, upload
from ...luminaires.emitters.limb import darken
from ...luminaires.emitters.opening_sampling import POINT
from ..compiled.lights import Source
from ..paths.gather import typical_wavelengths
from ..paths.sampler import sobol_pair
from ..rays import STEP
from .targets import MAXIMUM_TARGETS, SphereTree

MAXIMUM_PAIRS = 1 << 18
"""Most pairs of lights and targets; with many lights the targets are fewer and larger."""

PROBES = 16
"""Rays by which the flux from a light to a target is judged at first; a power of two."""

RESOLUTION = 1 << 24
"""Different numbers by which pairs are chosen. Every pair gets some of them, and its probability is their exact share."""

FLOOR = 0.05
"""Share of the choices made as if the lights were even, since a few rays may miss a narrow beam."""

PROBE_SEED = 0x51A7
"""Of the rays above; the same scene is always judged alike."""

COLUMNS = 4
"""Of the tables of lights and of targets: a vector and a number each."""

IDEAL, SUN, SURFACE = 0, 1, 2
"""How rays of a light begin: at a place, before everything, on a luminous surface."""


@dataclass(frozen=True, eq=False)
class TracedLight:
    """A light whose rays are traced.

    Parameters
    ----------
    source : Source or None    A point, spot, luminaire or luminous surface; None for a sun.
    number : int    Place among the sources of the scene's `LightTable`, or among the suns of its surroundings.
    kind : str    For people.
    """

    source: Source | None
    number: int
    kind: str

    @property
    def start(self) -> int:
        """`IDEAL`, `SUN` or `SURFACE`."""
        if self.source is None:
            return SUN
        return SURFACE if is_surface(self.source) else IDEAL


def is_surface(source: Source) -> bool:
    """Tell whether a light is a luminous surface, as lamps with a body and glowing objects are."""
    return source.luminaire is None and mi.has_flag(source.emitter.flags(), mi.EmitterFlags.Surface)


def find_surfaces(scene) -> tuple[TracedLight, ...]:
    """Luminous surfaces of a `CompiledScene`, in an order that follows from the scene alone."""
    return tuple(
        TracedLight(source, number, "luminous surface")
        for number, source in enumerate(scene.lights.sources)
        if source.centre is not None and is_surface(source)
    )


def has_rays(light: TracedLight) -> bool:
    """Tell whether a light has a ray set, for which the point with its intensities stands."""
    return light.source is not None and getattr(light.source.luminaire, "rays", None) is not None


def find_ray_points(scene) -> tuple[TracedLight, ...]:
    """Ray sets of a `CompiledScene` as points with their intensities, where nothing traces their rays."""
    return tuple(
        TracedLight(source, number, "ray set")
        for number, source in enumerate(scene.lights.sources)
        if getattr(source.luminaire, "rays", None) is not None
    )


def find_ideal_lights(scene) -> tuple[TracedLight, ...]:
    """Ideal lights of a `CompiledScene`, in an order that follows from the scene alone."""
    found = []
    for number, source in enumerate(scene.lights.sources):
        if source.centre is None:
            continue
        if source.luminaire is not None:
            # Rays of ray sets are traced by themselves, see `ray_lights`.
            if source.luminaire.kind == POINT and source.luminaire.rays is None:
                found.append(TracedLight(source, number, "luminaire without an opening"))
        elif mi.has_flag(source.emitter.flags(), mi.EmitterFlags.DeltaPosition):
            found.append(TracedLight(source, number, "point or spot"))
    if scene.surroundings is not None:
        suns = range(len(scene.surroundings.suns))
        found += [TracedLight(None, number, "sun") for number in suns]
    return tuple(found)


class EmissionRays:
    """Draws rays and their flux.

    Parameters
    ----------
    scene : CompiledScene
    lights : tuple of TracedLight    At least one.
    tree : SphereTree    What is aimed at.
    """

    def __init__(self, scene, lights: tuple[TracedLight, ...], tree: SphereTree):
        self._scene, self.lights = scene, lights
        self._has_suns = any(light.start == SUN for light in lights)
        self._has_points = any(light.start == IDEAL for light in lights)
        self._has_surfaces = any(light.start == SURFACE for light in lights)
        rows = np.zeros((table_size(len(lights)), COLUMNS))
        numbers = np.zeros((len(rows), 2))
        for i, light in enumerate(lights):
            numbers[i] = light.number, light.start
            if light.source is not None:
                rows[i, :3] = light.source.centre
            if light.start == IDEAL:
                # Of surfaces every ray has a place of its own, and needs no room for others.
                rows[i, 3] = light.source.radius
        beams = np.tile([0.0, 0.0, 1.0, 2.0], (len(rows), 1))
        for row, light in zip(beams, lights, strict=False):
            if light.source is not None and light.source.cone is not None:
                row[:3], row[3] = light.source.axis, 1.0 - light.source.cone
        self._rows, self._numbers = upload(mi.Float, rows), upload(mi.UInt32, numbers)
        self._beams = upload(mi.Float, beams)
        limit = int(np.clip(MAXIMUM_PAIRS // len(lights), 1, MAXIMUM_TARGETS))
        is_sun = numbers[: len(lights), 1] == SUN
        spheres, counts = tree.cut(rows[: len(lights), :3], is_sun, limit)
        self.targets = spheres.shape[1]
        self.pairs = len(lights) * self.targets
        columns = np.zeros((table_size(self.pairs), COLUMNS))
        columns[: self.pairs] = spheres.reshape(-1, COLUMNS)
        self._spheres = upload(mi.Float, columns)
        self._targets = dr.opaque(mi.UInt32, self.targets)
        dr.eval(self._rows, self._numbers, self._beams, self._spheres)
        self.set_shares(self._judge(counts.ravel()))

    def set_shares(self, shares: np.ndarray) -> None:
        """Set the probability of every pair, up to a factor: the targets of the first light, of the second and so on."""
        shares = np.asarray(shares, dtype=np.float64) / np.sum(shares)
        shares[shares > 0.0] = np.maximum(shares[shares > 0.0], 4.0 / RESOLUTION)
        limits = np.cumsum(shares)
        limits = np.round(limits * (RESOLUTION / limits[-1])) / RESOLUTION
        self.shares = np.diff(limits, prepend=0.0)
        size = table_size(self.pairs)
        cdf = np.full(size, 2.0)
        cdf[: self.pairs - 1] = limits[:-1]
        padded = np.zeros(size)
        padded[: self.pairs] = self.shares
        self._cdf, self._shares = upload(mi.Float, cdf), upload(mi.Float, padded)
        dr.eval(self._cdf, self._shares)

    def draw(self, choice, place, spread, wavelengths):
        """Draw rays.

        Parameters
        ----------
        choice : Float    Number in [0, 1) that chooses light and target.
        place, spread : Point2f    For the aim, and for the extent of a sun, spot or surface.
        wavelengths : Spectrum or None    [nm]

        Returns
        -------
        (Ray3f, Spectrum, UInt32, Float)
            Ray, flux over density [W/nm, or lm in photometric variants], number of the pair, and the density: over solid
            angle, of suns over area.
        """
        pair = self.pair(choice)
        start, direction, offset, surface = self._aim(pair, place, spread)
        amount = self._amount(pair, direction, wavelengths, surface)
        density = self._density(pair, start, direction)
        flux = dr.select(density > 0.0, amount / dr.maximum(density, 1e-30), 0.0)
        is_sun, reach = self.starts(pair, SUN), self._scene.extent
        # Suns start before everything; others a little off their place, which may lie on a surface.
        back = dr.dot(start, direction) + 1.5 * reach
        first = dr.select(is_sun, start - direction * back, start + offset)
        off = mi.Vector3f(direction)
        if surface is not None:
            out = dr.select(dr.dot(surface.n, direction) < 0.0, -surface.n, surface.n)
            off = dr.select(self.starts(pair, SURFACE), out, off)
        first = first + off * dr.select(is_sun, 0.0, 2.0 * STEP * reach)
        ray = mi.Ray3f(mi.Point3f(first), direction)
        if wavelengths is not None:
            ray.wavelengths = wavelengths
        return ray, flux, pair, density

    def pair(self, choice):
        """Number of the pair that a number in [0, 1) chooses."""
        last = dr.width(self._cdf) - 1
        return dr.binary_search(0, last, lambda i: dr.gather(mi.Float, self._cdf, i) <= choice)

    # ---- inside kernels ----

    def _light(self, pair):
        return pair // self._targets

    def _row(self, table, index):
        """Vector and number of a line of a table."""
        x, y, z, w = (dr.gather(mi.Float, table, index * COLUMNS + k) for k in range(COLUMNS))
        return mi.Vector3f(x, y, z), w

    def _number(self, pair):
        return dr.gather(mi.UInt32, self._numbers, self._light(pair) * 2)

    def starts(self, pair, kind: int):
        """Whether rays of a pair's light begin in one of the ways `IDEAL`, `SUN`, `SURFACE`."""
        return dr.gather(mi.UInt32, self._numbers, self._light(pair) * 2 + 1) == kind

    def _sun(self, number):
        """Direction to a sun and 1 - cos of its angular radius."""
        towards, cap = mi.Vector3f(0.0, 0.0, 1.0), mi.Float(1.0)
        if self._has_suns:
            for k, sun in enumerate(self._scene.surroundings.suns):
                towards = dr.select(number == k, sun[1], towards)
                cap = dr.select(number == k, sun[2], cap)
        return towards, cap

    def _aim(self, pair, place, spread):
        """Line of light.

        Returns
        -------
        (Point3f, Vector3f, Vector3f, PositionSample3f or None)
            A point of it, its direction, the way to where the ray begins on a spot's disk, and the place on a surface.
        """
        centre, extent = self._row(self._rows, self._light(pair))
        surface = None
        if self._has_surfaces:
            is_surface = self.starts(pair, SURFACE)
            index = dr.select(is_surface, self._number(pair), 0)
            surface = self._scene.lights.sample_place(index, spread, is_surface)
            centre = dr.select(is_surface, mi.Vector3f(surface.p), centre)
        sphere, radius = self._row(self._spheres, pair)
        away = sphere - centre
        _, cap = solid_cap(away, radius + extent)
        distance = dr.norm(away)
        axis = dr.select(distance > 0.0, away / distance, mi.Vector3f(0.0, 0.0, 1.0))
        # Where a light's cone is narrower than that of the target, it is filled instead.
        beam, width = self._row(self._beams, self._light(pair))
        axis, cap = dr.select(width < cap, beam, axis), dr.minimum(width, cap)
        direction = mi.Frame3f(axis).to_world(in_cap(cap, place))
        disk = mi.warp.square_to_uniform_disk_concentric(spread) * extent
        frame = mi.Frame3f(direction)
        offset = frame.s * disk.x + frame.t * disk.y
        start = centre
        if self._has_suns:
            is_sun = self.starts(pair, SUN)
            towards, size = self._sun(self._number(pair))
            sunwards = -mi.Frame3f(towards).to_world(in_cap(size, spread))
            frame = mi.Frame3f(sunwards)
            disk = mi.warp.square_to_uniform_disk_concentric(place) * radius
            direction = dr.select(is_sun, sunwards, direction)
            start = dr.select(is_sun, sphere + frame.s * disk.x + frame.t * disk.y, start)
        return start, direction, offset, surface

    def _amount(self, pair, direction, wavelengths, surface):
        """Intensity in a direction, or a sun's illuminance of a plane that faces it. ``surface``: as `_aim` gives it."""
        scene, number, is_sun = self._scene, self._number(pair), self.starts(pair, SUN)
        amount = mi.Spectrum(0.0)
        if self._has_points:
            centre, _ = self._row(self._rows, self._light(pair))
            it = dr.zeros(mi.Interaction3f)
            it.p, it.n = mi.Point3f(centre + direction * scene.extent), mi.Normal3f(-direction)
            if wavelengths is not None:
                it.wavelengths = wavelengths
            # A sun's number is none of the table's, so the first light of it stands in.
            is_point = self.starts(pair, IDEAL)
            index = dr.select(is_sun, 0, number)
            it.time = scene.lights.row(index)
            pointer = scene.lights.pointer(index)
            ds, value = pointer.sample_direction(it, mi.Point2f(0.5), is_point)
            amount = dr.select(is_point, value * dr.square(ds.dist), amount)
        if self._has_surfaces:
            is_surface = self.starts(pair, SURFACE)
            it, ds = dr.zeros(mi.Interaction3f), dr.zeros(mi.DirectionSample3f)
            if wavelengths is not None:
                it.wavelengths = wavelengths
            ds.p, ds.n, ds.uv, ds.d = surface.p, surface.n, surface.uv, -direction
            index = dr.select(is_surface, number, 0)
            it.time = scene.lights.row(index)
            pointer = scene.lights.pointer(index)
            value = pointer.eval_direction(it, ds, is_surface)
            value *= dr.abs(dr.dot(surface.n, direction)) / dr.maximum(surface.pdf, 1e-30)
            amount = dr.select(is_surface, value, amount)
        if self._has_suns:
            si = dr.zeros(mi.SurfaceInteraction3f)
            if wavelengths is not None:
                si.wavelengths = wavelengths
            for k, (radiance, towards, cap, _, _, limb) in enumerate(scene.surroundings.suns):
                mine = is_sun & (number == k)
                value = darken(radiance.eval(si, mine), limb, -direction, towards, cap)
                value *= dr.two_pi * cap
                amount = dr.select(mine, value, amount)
        return amount

    def _density(self, pair, start, direction):
        """Density with which a line would have been drawn, whatever the target: over solid angle, of suns over area."""
        light, is_sun = self._light(pair), self.starts(pair, SUN)
        chosen, targets = pair % self._targets, self._targets
        _, extent = self._row(self._rows, light)
        beam, width = self._row(self._beams, light)
        # By the chord, since cosines of narrow cones have no digits left.
        is_in_beam = 0.5 * dr.squared_norm(direction - beam) <= width * (1.0 + 1e-4) + 1e-13

        def step(density, k):
            sphere, radius = self._row(self._spheres, light * targets + k)
            share = dr.gather(mi.Float, self._shares, light * targets + k)
            away = sphere - start
            along = dr.dot(away, direction)
            reach = radius + extent
            is_inside, cap = solid_cap(away, reach)
            is_met = dr.squared_norm(away - direction * along) <= dr.square(reach)
            is_met &= is_sun | is_inside | (along > 0.0)
            is_met = dr.select(~is_sun & (width < cap), is_in_beam, is_met)
            cap = dr.minimum(cap, width)
            # Rounding may put a ray on the rim just outside the sphere that it was aimed at.
            is_met |= k == chosen
            own = dr.select(is_sun, dr.inv_pi / dr.square(radius), dr.inv_two_pi / cap)
            return dr.select(is_met, density + share * own, density), k + 1

        density, _ = dr.while_loop(
            state=(mi.Float(0.0), mi.UInt32(0)),
            cond=lambda density, k: k < targets,
            body=step,
            labels=("density", "target"),
        )
        return density

    # ---- first guess ----

    def _judge(self, counts: np.ndarray) -> np.ndarray:
        """Flux of every pair, up to a factor, by a few rays each and without regard to shadows. ``counts``: which are."""
        lane = dr.arange(mi.UInt32, self.pairs * PROBES)
        pair, index = lane // PROBES, lane % PROBES
        seed = dr.opaque(mi.UInt32, PROBE_SEED)
        places, spreads = sobol_pair(index, seed, 0), sobol_pair(index, seed, 1)
        _, direction, _, surface = self._aim(pair, places, spreads)
        amount = average(self._amount(pair, direction, typical_wavelengths(), surface))
        centre, extent = self._row(self._rows, self._light(pair))
        sphere, radius = self._row(self._spheres, pair)
        _, cap = solid_cap(sphere - centre, radius + extent)
        cap = dr.minimum(cap, self._row(self._beams, self._light(pair))[1])
        size = dr.select(self.starts(pair, SUN), dr.pi * dr.square(radius), dr.two_pi * cap)
        size = dr.block_reduce(dr.ReduceOp.Add, size, PROBES)
        amount = dr.block_reduce(dr.ReduceOp.Add, amount, PROBES)
        size, amount = np.array(size, dtype=np.float64) * counts, np.array(amount, dtype=np.float64)
        seen = amount * size
        shape = (len(self.lights), -1)
        # A light whose probes all miss its beam counts by its flux.
        even = np.array(
            [0.0 if m.source is None else m.source.flux / (4.0 * np.pi) for m in self.lights]
        )
        even = (np.maximum(even, 0.0)[:, None] * size.reshape(shape)).ravel()
        if seen.sum() <= 0.0:
            return even + 1e-12 * size / size.sum()
        shares = (1.0 - FLOOR) * seen / seen.sum()
        return shares + FLOOR * even / even.sum() if even.sum() > 0.0 else shares


def solid_cap(away, radius):
    """Whether a place lies in a sphere, and 1 - cos of the half angle that the sphere fills, 2 from inside."""
    square, limit = dr.squared_norm(away), dr.square(radius)
    is_inside = square <= limit
    sine = dr.select(is_inside, 0.0, limit / dr.maximum(square, 1e-30))
    return is_inside, dr.select(is_inside, 2.0, sine / (1.0 + dr.safe_sqrt(1.0 - sine)))


def in_cap(cap, sample):
    """Even direction about +z within 1 - cos <= ``cap``; exact for the narrowest too."""
    height = sample.x * cap
    sine = dr.safe_sqrt(height * (2.0 - height))
    sin_phi, cos_phi = dr.sincos(dr.two_pi * sample.y)
    return mi.Vector3f(sine * cos_phi, sine * sin_phi, 1.0 - height)
