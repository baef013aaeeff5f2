"""Light of every light of a scene as rays that begin there, each with its share of the flux.

Points and spots shine by their intensity, luminaires by their distribution from the opening, ray sets by their rays,
luminous surfaces from places drawn by area with the cosine law (narrowed to the cone of their spread), suns and the world
through disks that face the direction (`far_disks`), suns by a map of what was found before (`sun_maps`). What
`emission_rays` and `ray_lights` draw is aimed at what bends light; here all of the light is represented.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...luminaires.emitters.limb import darken
from ..compiled import emission
from ..compiled.textures import is_spectral
from ..paths.gather import photometric
from ..paths.sampler import launch_stream
from ..rays import STEP, start_of
from .emission_rays import in_cap
from .far_disks import PORTAL_SHARE, FarDisks, Focus, aim_at_portals
from .ray_source import RaySource
from .sun_maps import SunMap

POINT, LUMINAIRE, RAYS, BODY, MESH, SUN, WORLD = range(7)
"""Kinds of lights, in the order of their lanes."""

DRAWING = 1
"""Purpose of the random numbers that rays are drawn with."""

MAP_SHARE, MAP_SIZE = 0.8, 1.5
"""Share of a sun's rays that follow its map, and the map's radius relative to what is asked about."""


@dataclass(frozen=True, eq=False)
class Origin:
    """A light.

    Parameters
    ----------
    name : str    Of the light, or of the object that glows; for people.
    kind : int
    flux : float    About what it gives, by which paths are shared out. [lm]
    number : int    Place among the sources of the scene's `LightTable`, or among the suns.
    thing : object    Its `CompiledLight`, `Part` or source.
    """

    name: str
    kind: int
    flux: float
    number: int
    thing: object = None


@dataclass
class Rays:
    """Rays at their beginning, on the device.

    Parameters
    ----------
    ray : Ray3f
    power : Spectrum    Flux that the ray stands for. [W/nm, lm in photometric variants]
    response : Spectrum    Lumens per unit of it, by wavelength.
    cell : UInt32    Of the sun's map; 0 for others.
    """

    ray: object
    power: object
    response: object
    cell: object

    def lumens(self, power):
        """Flux of paths from their power. [lm]"""
        return dr.sum(power * self.response)


def find_origins(scene) -> tuple[Origin, ...]:
    """All lights of a `CompiledScene`, by kind; none that gives nothing."""
    lamps = {id(lamp.source): lamp for lamp in scene.compiled_lights()}
    glowing = {
        id(part.source): (scene.object_name(key), part)
        for key, part, _ in scene.parts()
        if part.source is not None
    }
    found = []
    for number, source in enumerate(scene.lights.sources):
        if source.centre is None:
            continue
        if id(source) in glowing:
            name, part = glowing[id(source)]
            found.append(Origin(name, MESH, source.flux, number, part))
            continue
        lamp = lamps[id(source)]
        kind = BODY
        if source.luminaire is not None:
            rays = source.luminaire.rays
            kind = RAYS if rays is not None and len(rays.threshold) else LUMINAIRE
        elif lamp.body is None:
            kind = POINT
        found.append(Origin(lamp.item.name, kind, source.flux, number, lamp))
    disk = np.pi * scene.radius**2
    for number, sun in enumerate(scene.suns):
        amount = emission.sun_illuminance(sun)
        found.append(Origin(sun.name, SUN, amount.amount * disk, number, sun))
    if scene.surroundings is not None and scene.surroundings.world is not None:
        found.append(Origin("world", WORLD, scene.world_luminance * np.pi * 4.0 * disk, 0))
    found = [origin for origin in found if origin.flux > 0.0]
    return tuple(sorted(found, key=lambda origin: origin.kind))


class AllLights:
    """Draws rays from all lights of a scene.

    Parameters
    ----------
    scene : CompiledScene
    sampler : WavelengthSampler or None    None in photometric variants.
    seed : int
    focus : Focus or None    Where most of the light from infinity is led to; None: all over.
    """

    def __init__(self, scene, sampler, seed: int, focus: Focus | None = None):
        self._scene, self._sampler = scene, sampler
        self._disks = FarDisks(focus, scene.radius)
        self._seed = int(seed) & 0xFFFFFFFF
        self.origins = find_origins(scene)
        self.maps = {place: SunMap() for place, each in enumerate(self.origins) if each.kind == SUN}
        self._sources: dict[int, RaySource] = {}

    def flux_shares(self) -> np.ndarray:
        """Shares of the lights in the flux, of which those at infinity have a half at most beside others. (n,)"""
        flux = np.array([origin.flux for origin in self.origins], dtype=np.float64)
        is_far = np.array([origin.kind in {SUN, WORLD} for origin in self.origins])
        for part in (is_far, ~is_far):
            if part.any():
                flux[part] /= flux[part].sum()
        return flux / flux.sum()

    def draw(self, which: np.ndarray, chance: np.ndarray, salt: int) -> Rays:
        """Draw rays.

        Parameters
        ----------
        which : (n,) int array    Light of every ray, ascending.
        chance : (n,) array    Expected number of rays of that light: the flux is over it.
        salt : int    Other salts give independent rays.

        Returns
        -------
        Rays
        """
        host = np.random.default_rng([self._seed, salt, 5])
        kinds = np.array([origin.kind for origin in self.origins])[which]
        makers = {
            POINT: self._draw_points,
            LUMINAIRE: self._draw_luminaires,
            RAYS: self._draw_ray_sets,
            BODY: self._draw_bodies,
            MESH: self._draw_meshes,
            SUN: self._draw_suns,
            WORLD: self._draw_world,
        }
        parts, first = [], 0
        # Lights of one kind, and ray sets, suns and meshes one by one, have launches of their own.
        key = np.where(np.isin(kinds, (RAYS, SUN)), which + len(makers), kinds)
        ends = np.flatnonzero(np.diff(key)) + 1
        for rows in np.split(np.arange(len(which)), ends):
            if len(rows) == 0:
                continue
            lanes = _Lanes(self._sampler, len(rows), self._seed, salt, first)
            first += len(rows)
            made = makers[int(kinds[rows[0]])](which[rows], lanes, host)
            scale = upload(mi.Float, 1.0 / chance[rows])
            start, direction, power, response, cell = made
            parts.append((*start, *direction, *(power * scale), *response, cell))
            if lanes.wavelengths is not None:
                parts[-1] = (*parts[-1], *lanes.wavelengths)
            dr.eval(parts[-1])
        columns = [dr.concat(column) if len(column) > 1 else column[0] for column in zip(*parts, strict=True)]  # fmt: skip
        ray = mi.Ray3f(mi.Point3f(*columns[:3]), mi.Vector3f(*columns[3:6]))
        size = len(mi.Spectrum(0.0))
        power = mi.Spectrum(*columns[6 : 6 + size])
        response = mi.Spectrum(*columns[6 + size : 6 + 2 * size])
        cell = columns[6 + 2 * size]
        if is_spectral():
            ray.wavelengths = mi.Spectrum(*columns[7 + 2 * size :])
        return Rays(ray, power, response, cell)

    # ---- one kind each: start, direction, power, response, cell ----

    def _numbers(self, which: np.ndarray):
        """Numbers of the lights in the `LightTable`, on the device."""
        numbers = np.array([origin.number for origin in self.origins])
        return upload(mi.UInt32, numbers[which])

    def _draw_points(self, which, lanes, _host):
        scene = self._scene
        sources = [scene.lights.sources[o.number] if o.kind == POINT else None for o in self.origins]  # fmt: skip
        rows = np.zeros((len(sources), 8))
        for row, source in zip(rows, sources, strict=True):
            if source is not None:
                axis = (0.0, 0.0, 1.0) if source.axis is None else source.axis
                cap = 2.0 if source.cone is None else 1.0 - source.cone
                row[:] = *source.centre, source.radius, *axis, cap
        columns = [upload(mi.Float, column) for column in rows[which].T]
        centre, radius = mi.Vector3f(*columns[:3]), columns[3]
        axis, cap = mi.Vector3f(*columns[4:7]), columns[7]
        direction = mi.Frame3f(axis).to_world(in_cap(cap, lanes.pair()))
        index = self._numbers(which)
        it = dr.zeros(mi.Interaction3f, lanes.count)
        it.p = mi.Point3f(centre + direction * scene.extent)
        it.n = mi.Normal3f(-direction)
        if lanes.wavelengths is not None:
            it.wavelengths = lanes.wavelengths
        ds, value = scene.lights.pointer(index).sample_direction(it, mi.Point2f(0.5), mi.Bool(True))
        power = value * dr.square(ds.dist) * (dr.two_pi * cap)
        # Spots with a radius shine from a disk.
        frame = mi.Frame3f(direction)
        disk = mi.warp.square_to_uniform_disk_concentric(lanes.pair()) * radius
        start = centre + frame.s * disk.x + frame.t * disk.y
        start += direction * (2.0 * STEP * scene.extent)
        return start, direction, power, lanes.response(), lanes.zero()

    def _draw_luminaires(self, which, lanes, _host):
        scene = self._scene
        palette = scene.lights.palette
        row = mi.UInt32(scene.lights.row(self._numbers(which)))
        start, direction, normal = palette.emit(row, lanes.pair(), lanes.pair(), mi.Bool(True))
        power = palette.spectrum(row, lanes.wavelengths, mi.Bool(True), direction)
        lift = 2.0 * STEP * scene.extent
        return start + normal * lift, direction, power, lanes.response(), lanes.zero()

    def _draw_ray_sets(self, which, lanes, _host):
        scene, place = self._scene, int(which[0])
        source = scene.lights.sources[self.origins[place].number]
        made = self._sources.get(place)
        if made is None:
            made = self._sources[place] = RaySource(source.luminaire.rays)
        start, direction, weight, own = made.draw(lanes.stream)
        columns = [mi.Vector3f(*map(float, c)) for c in source.luminaire.rotation.T]
        centre = mi.Vector3f(*map(float, source.luminaire.centre))
        dr.make_opaque(columns, centre)

        def to_world(v):
            return columns[0] * v.x + columns[1] * v.y + columns[2] * v.z

        towards = to_world(direction)
        begin = centre + to_world(mi.Vector3f(start)) + towards * (2.0 * STEP * scene.extent)
        if own is None or self._sampler is None:
            row = dr.opaque(mi.UInt32, scene.lights.row_of(source))
            power = scene.lights.palette.spectrum(row, lanes.wavelengths, mi.Bool(True)) * weight
            return begin, towards, power, lanes.response(), lanes.zero()
        # A ray with a wavelength of its own carries lumens of that one.
        lanes.wavelengths = mi.Spectrum(own)
        power = mi.Spectrum(0.25 * dr.opaque(mi.Float, float(source.flux)) * weight)
        return begin, towards, power, mi.Spectrum(dr.full(mi.Float, 1.0, lanes.count)), lanes.zero()

    def _draw_bodies(self, which, lanes, host):
        """Spheres, rectangles, disks and tubes of lights."""
        points, normals = np.zeros((2, len(which), 3))
        areas, sines = np.zeros(len(self.origins)), np.ones(len(self.origins))
        for place, mine in _runs(which):
            lamp = self.origins[place].thing
            u, v = host.random((2, mine.stop - mine.start))
            points[mine], normals[mine], areas[place] = lamp.outline.places(u, v)
            sines[place] = lamp.outline.sine
        si = dr.zeros(mi.SurfaceInteraction3f, lanes.count)
        si.p, si.n = mi.Point3f(*_columns(points)), mi.Normal3f(*_columns(normals))
        numbers = self._numbers(which)
        pointer, si.time = self._scene.lights.pointer(numbers), self._scene.lights.row(numbers)
        sides = np.ones(len(which))
        return self._shine(si, pointer, areas[which], sines[which], sides, lanes)

    def _draw_meshes(self, which, lanes, host):
        """Glowing triangles."""
        shape, prim = np.zeros((2, len(which)), dtype=np.uint32)
        uv, areas, sides = np.zeros((2, len(which))), *np.ones((2, len(which)))
        for place, mine in _runs(which):
            count = mine.stop - mine.start
            part = self.origins[place].thing
            corners = self._scene.triangles(part).astype(np.float64)
            cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            cdf = np.cumsum(0.5 * np.linalg.norm(cross, axis=1))
            # Places spread evenly over the area, one in each of as many parts of it.
            wanted = host.permutation((np.arange(count) + host.random(count)) / count) * cdf[-1]
            prim[mine] = np.minimum(np.searchsorted(cdf, wanted, side="right"), len(cdf) - 1)
            u, v = host.random((2, count))
            root = np.sqrt(u)
            uv[0, mine], uv[1, mine] = root * (1.0 - v), root * v
            shape[mine], areas[mine] = part.number, cdf[-1]
            if part.source.emitter.two_sided:
                areas[mine] *= 2.0
                sides[mine] = host.permutation(np.arange(count) % 2) * 2.0 - 1.0
        place = mi.Point2f(*(upload(mi.Float, column) for column in uv))
        si = self._scene.interaction_at(upload(mi.UInt32, shape), upload(mi.UInt32, prim), place)
        pointer = self._scene.emitter(si)
        return self._shine(si, pointer, areas, np.ones(len(which)), sides, lanes)

    def _shine(self, si, pointer, areas, sines, sides, lanes):
        """Directions and power from places on luminous surfaces.

        ``sines``: of the half angle of the beam; ``sides``: 1 to the front, -1 to the back.
        """
        si.sh_frame = mi.Frame3f(mi.Vector3f(si.n))
        sample, sine = lanes.pair(), upload(mi.Float, sines)
        rise = dr.sqrt(sample.x) * sine
        sin_phi, cos_phi = dr.sincos(dr.two_pi * sample.y)
        side = upload(mi.Float, sides)
        height = dr.safe_sqrt(1.0 - dr.square(rise)) * side
        local = mi.Vector3f(rise * cos_phi, rise * sin_phi, height)
        si.wi = local
        if lanes.wavelengths is not None:
            si.wavelengths = lanes.wavelengths
        direction = si.to_world(local)
        power = pointer.eval(si, mi.Bool(True)) * (
            dr.pi * dr.square(sine) * upload(mi.Float, areas)
        )
        return (
            start_of(self._scene, si, direction),
            direction,
            power,
            lanes.response(),
            lanes.zero(),
        )

    def _draw_suns(self, which, lanes, _host):
        scene, place = self._scene, int(which[0])
        radiance, towards, cap, _, _, limb = scene.surroundings.suns[self.origins[place].number]
        x, y = self.maps[place].draw(lanes.stream.next_float32(), lanes.pair())
        # The map's axes belong to the sun, not to the ray, so that cells keep their place.
        frame = mi.Frame3f(towards)
        direction = -frame.to_world(in_cap(cap, lanes.pair()))
        # Slanting rays of a wide sun cross the plane farther out.
        wider = 1.0 / dr.maximum(1.0 - cap, 0.1)
        near, whole = self._disks.nearest, self._disks.widest
        size = dr.minimum(near.radius * MAP_SIZE, whole.radius) * wider
        reach = whole.radius * wider
        cx, cy = dr.dot(near.middle, frame.s), dr.dot(near.middle, frame.t)
        disk = mi.warp.square_to_uniform_disk_concentric(lanes.pair()) * reach
        is_mapped = lanes.stream.next_float32() < MAP_SHARE
        x, y = (
            dr.select(is_mapped, x * size + cx, disk.x),
            dr.select(is_mapped, y * size + cy, disk.y),
        )
        cell, density = self.maps[place].find((x - cx) / size, (y - cy) / size)
        density *= MAP_SHARE / dr.square(size)
        inside = dr.square(x) + dr.square(y) <= dr.square(reach)
        density += dr.select(inside, (1.0 - MAP_SHARE) * dr.inv_pi / dr.square(reach), 0.0)
        middle = frame.s * x + frame.t * y
        start = middle - direction * (2.0 * reach + dr.dot(middle, direction))
        si = dr.zeros(mi.SurfaceInteraction3f, lanes.count)
        if lanes.wavelengths is not None:
            si.wavelengths = lanes.wavelengths
        cosine = dr.abs(dr.dot(direction, towards))
        value = darken(radiance.eval(si, mi.Bool(True)), limb, -direction, towards, cap)
        value *= dr.two_pi * cap * cosine
        power = value / dr.maximum(density, 1e-20)
        return start, direction, power, lanes.response(), cell

    def _draw_world(self, which, lanes, _host):
        scene = self._scene
        surroundings = scene.surroundings
        it = dr.zeros(mi.Interaction3f, lanes.count)
        if lanes.wavelengths is not None:
            it.wavelengths = lanes.wavelengths
        ds, _ = surroundings.world.sample_direction(it, lanes.pair(), mi.Bool(True))
        pdf = surroundings.world.pdf_direction(it, ds, mi.Bool(True))
        direction = -dr.normalize(ds.d)
        reach = self._disks.widest.radius
        middle = self._disks.draw(direction, lanes)
        portals, share = surroundings.portals, 0.0
        if portals is not None:
            share = PORTAL_SHARE
            middle, density = aim_at_portals(portals, middle, direction, lanes)
        else:
            density = mi.Float(0.0)
        density += (1.0 - share) * self._disks.density(middle, direction)
        start = middle - direction * (2.0 * reach + dr.dot(middle, direction))
        si = dr.zeros(mi.SurfaceInteraction3f, lanes.count)
        si.wi = direction
        if lanes.wavelengths is not None:
            si.wavelengths = lanes.wavelengths
        value = surroundings.world.eval(si, mi.Bool(True))
        over = pdf * density
        power = dr.select(over > 0.0, value / dr.maximum(over, 1e-30), 0.0)
        return start, direction, power, lanes.response(), lanes.zero()


class _Lanes:
    """Random numbers and wavelengths of rays that are drawn together."""

    def __init__(self, sampler, count: int, seed: int, salt: int, first: int):
        self.count = count
        lane = dr.arange(mi.UInt32, count) + dr.opaque(mi.UInt32, first)
        # Streams of their own for every salt.
        self.stream = launch_stream(lane, salt, seed, DRAWING)
        self._sampler = sampler
        self.wavelengths = None
        if sampler is not None:
            self.wavelengths = sampler.sample(self.stream.next_float32())

    def pair(self):
        """Two numbers in [0, 1)."""
        return mi.Point2f(self.stream.next_float32(), self.stream.next_float32())

    def zero(self):
        """No cell."""
        return dr.zeros(mi.UInt32, self.count)

    def response(self):
        """Lumens per unit of power, by wavelength."""
        made = mi.Spectrum(0.0)
        for k in range(len(made)):
            single = mi.Spectrum(0.0)
            single[k] = 1.0
            made[k] = photometric(self._sampler, single, self.wavelengths)
            if self._sampler is None and k > 0:
                made[k] = 0.0
        return made + dr.zeros(mi.Float, self.count)


def _runs(which: np.ndarray):
    """Yield each light of an ascending row, and where its lanes are."""
    ends = np.append(np.flatnonzero(np.diff(which)) + 1, len(which))
    for first, end in zip(np.append(0, ends[:-1]), ends, strict=True):
        yield int(which[first]), slice(int(first), int(end))


def _columns(points: np.ndarray) -> list:
    return [upload(mi.Float, points[:, k]) for k in range(3)]
