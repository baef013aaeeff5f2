"""From the scene description to the Mitsuba objects that the estimators trace, and from edit to edit.

Every object, light and material is kept under its id; a commit changes what the ids named since the last one ask for.
The state after any series of edits gives the same pictures as a scene compiled at once: everything that steers sampling
(the order of the lights, the frame's origin, the mean light) follows from the scene alone, not from its history.
"""

from dataclasses import dataclass, field

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import pointer_id, table_size, upload
from ...errors import SceneError
from ...luminaires.emitters import plugins as emitter_plugins
from ...luminaires.emitters.palette import LuminairePalette, make_emitter
from ...luminaires.emitters.portals import MAXIMUM_PORTALS, Portal, PortalSet, portal_order
from ...materials import plugins as surface_plugins
from ...photometry.spectra import GRID, illuminant
from ...scattering.kernels import plugin as scattering_plugin
from ...scene.checks import FARTHEST, check_reach
from ...scene.light import ImageWorld, Luminaire, SunLight
from ...scene.mesh import Mesh
from ...scene.scene import Scene
from ...sky import plugin as sky_plugin
from ...sky.picture import describe_faults
from ..requirements import Requirements
from . import emission
from .bodies import Body, Part, check_mesh, extent, make_body, needs_new_shape, reglow
from .known_mirrors import KnownMirrors, is_hard_to_meet
from .lamps import Lamp, change_lamp, make_lamp
from .layers import Layer
from .lights import LightTable, Source
from .material_palette import Finishes
from .polarisation import make_polarisation
from .pool import SurfacePool
from .surfaces import has_grain
from .surroundings import make_surroundings, make_world

COARSE_RADIUS = 1e5
"""Size of scenes from which on the rounding of places is told. [m]"""

SINGLE = 2.0**-24
"""Relative error by which single precision rounds."""


class Outgrown(Exception):  # noqa: N818 - not a fault
    """An edit has moved the frame's origin, or edits have left much waste: everything has to be compiled anew."""


@dataclass
class Changes:
    """What a commit did, counted for people."""

    built: int = 0
    removed: int = 0
    surfaces: int = 0
    lights: int = 0
    is_rebuilt: bool = False
    other: list[str] = field(default_factory=list)

    def text(self) -> str:
        """One line."""
        parts = [
            f"{count} {name}{'s' if count > 1 else ''} {verb}"
            for count, name, verb in (
                (self.built, "object", "built"),
                (self.removed, "object", "removed"),
                (self.surfaces, "surface", "changed"),
                (self.lights, "light", "changed"),
            )
            if count
        ]
        parts += self.other
        if self.is_rebuilt:
            parts.append("search tree rebuilt")
        return ", ".join(parts) or "nothing"


def frame_of(scene_low: np.ndarray, scene_high: np.ndarray) -> tuple[np.ndarray, float]:
    """Origin of the compiled frame and radius of everything around it. [m]

    The origin lies on a grid about as coarse as the scene is large, so that positions are small numbers and yet hardly any
    edit moves it.
    """
    if not np.all(scene_low <= scene_high):
        return np.zeros(3), 1.0
    half = 0.5 * float((scene_high - scene_low).max())
    grid = 2.0 ** max(np.floor(np.log2(max(half, 1.0))) - 1.0, 0.0)
    origin = np.round(0.5 * (scene_low + scene_high) / grid) * grid
    return origin, float(np.linalg.norm(np.maximum(scene_high - origin, origin - scene_low)))


class CompiledScene:
    """Mitsuba objects of one scene, for one variant. Owned and used by one thread.

    ``solid`` holds what stops light, ``veil`` what light may pass straight (panes, cut-outs, the bodies of lights),
    ``shown`` what is there for the camera alone. ``lights`` chooses emitters; ``surroundings`` is what rays that leave the
    scene see. Positions are relative to ``origin`` (float64, world) so that single precision serves scenes far from the
    world's origin; ``extent`` [m] is the largest of them.

    Raises
    ------
    SceneError    An object has a material that the scene lacks, or a light's quantity does not fit its kind.
    """

    def __init__(self, scene: Scene, requirements: Requirements):
        surface_plugins.register()
        scattering_plugin.register()
        emitter_plugins.register()
        sky_plugin.register()
        self.requirements = requirements
        self.origin = frame_of(*_bounds(scene))[0]
        self.radius = 1.0
        self.extent = mi.Float(1.0)
        self._extents = mi.Float(0.0)
        self.mean_light = np.ones(len(GRID)) / len(GRID)
        self.light_spectra: list[np.ndarray] = []
        self._pool = SurfacePool()
        self.solid = Layer(self._pool)
        self._veil = Layer(self._pool)
        self._shown = Layer(self._pool)
        # What light bodies are made of for others' light: nothing.
        self._nothing = mi.load_dict({"type": "null"})
        self.surroundings = None
        self.hidden = None
        self.known_mirrors = KnownMirrors()
        self.polarisation = None
        self.indices: dict = {}
        self.notes: list[str] = []
        # Light over bends for the paths of a job, see `bent_lights`.
        self.bent = None
        # Small bright spots towards which paths are scattered, see `bright_spots`.
        self.spots = None
        # Straight light that a job traces, see `straight_lights`.
        self.near = None
        self._bodies: dict[str, Body] = {}
        self._lamps: dict[str, Lamp] = {}
        # Mitsuba visits every emitter that lives, so there is none without luminaires.
        self._luminaires = None
        self._finishes = Finishes(self.mean_light)
        self._users: dict[str, dict[str, None]] = {}
        self._world_item, self._world = None, None
        self._panes: list[Portal] = []
        self._portals: PortalSet | None = None
        self._outside_key: object = None
        self._outside: Source | None = None
        self.commit(scene, [*scene.meshes, *scene.materials, *scene.lights], requirements)

    @property
    def veil(self):
        """Layer of what light may pass straight, None when there is nothing of the kind."""
        return self._veil if len(self._veil) else None

    @property
    def shown(self):
        """Layer of what light does not meet, though the camera may see it; None when there is nothing of the kind."""
        return self._shown if len(self._shown) else None

    def local(self, points) -> np.ndarray:
        """World points (n, 3) [m] in the compiled scene's frame, float32."""
        return (np.asarray(points, dtype=np.float64) - self.origin).astype(np.float32)

    def settle(self) -> None:
        """Put everything into still scenes, for long jobs."""
        self.solid.settle()
        self._veil.settle()
        self._shown.settle()

    def commit(self, scene: Scene, named: list[str], requirements: Requirements) -> Changes:
        """Bring everything that ids name up to date.

        The order of the ids decides nothing but between surfaces at exactly the same place.

        Raises
        ------
        Outgrown    The scene has to be compiled anew.
        SceneError    The scene cannot be computed; this object must not be used any more.
        """
        changes = Changes()
        self.requirements = requirements
        moved = self._changed_meshes(scene, named)
        rebuilt = self._commit_materials(scene, named, changes)
        for key in dict.fromkeys([*moved, *rebuilt]):
            self._commit_mesh(scene, key, key in rebuilt, changes)
        self._drop_unused_materials()
        self._commit_lights(scene, named, changes)
        if scene.world is not self._world_item:
            self._world = make_world(scene.world, self._world_item, self._world)
            self._world_item = scene.world
            changes.other.append("surroundings changed")
        self._commit_light_table(scene)
        self._commit_tables()
        changes.is_rebuilt = self.solid.commit() | self._veil.commit() | self._shown.commit()
        self._note(scene)
        return changes

    # ---- what a ray meets ----

    def surface(self, hit, ray, active):
        """Surface at a preliminary hit."""
        return self._pool.interaction(hit, ray, active)

    def bsdf(self, si, active=True):
        """Surface model at an interaction."""
        return self._pool.bsdf(si, mi.Bool(active) & si.is_valid())

    def extent_at(self, si):
        """Largest coordinate of the object that a surface belongs to, 0 for places of their own. [m]"""
        number = dr.reinterpret_array(mi.UInt32, si.shape)
        return dr.gather(mi.Float, self._extents, number)

    def emitter(self, si, active=True):
        """Emitter at an interaction, null where the surface does not glow."""
        return self._pool.emitter(si, mi.Bool(active) & si.is_valid())

    @property
    def mirrors(self):
        """Plane mirrors and panes that light is aimed over, a `MirrorSet`, None when there are none."""
        return self.known_mirrors.planes

    def mirror_at(self, si, active):
        """Number of the plane among ``mirrors`` that a surface lies in, plus 1; 0: none."""
        return self.known_mirrors.at(si, active)

    def parts(self):
        """Yield every part of an object that light meets: the object's id, the part, its material."""
        for key, body in self._bodies.items():
            for part in body.parts if body.item.meets_light else ():
                yield key, part, self._finishes.item(part.material)

    def lamps(self):
        """Yield every light at work but those at infinity, as `Lamp`."""
        yield from self._lamps.values()

    def object_name(self, key: str) -> str:
        """Name of an object, for people."""
        return self._bodies[key].item.name

    def object_bounds(self, key: str) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest corner of an object in the scene's frame. (3,), (3,) [m]"""
        body = self._bodies[key]
        return body.low - self.origin, body.high - self.origin

    @property
    def suns(self) -> tuple[SunLight, ...]:
        """Suns of the surroundings, in their order there."""
        return () if self.surroundings is None else tuple(self._outside_parts[1])

    @property
    def world_luminance(self) -> float:
        """Mean over all directions of the world without its suns. [cd/m2]"""
        return 0.0 if self._world is None else self._world.mean_luminance

    @property
    def shape_count(self) -> int:
        """Entries of tables by the number of a shape."""
        return dr.width(self._extents)

    def triangles(self, part) -> np.ndarray:
        """Corners of a part's triangles in the scene's frame. (t, 3, 3) float32 [m]"""
        return self._pool.triangles(part.number)

    def interaction_at(self, shape, prim, uv, active=True):
        """Surface at a place that is given by shape, triangle and barycentric coordinates, seen from its front."""
        hit = dr.zeros(mi.PreliminaryIntersection3f)
        hit.valid, hit.t, hit.prim_index, hit.prim_uv = mi.Bool(active), mi.Float(0.0), prim, uv
        hit.shape = dr.reinterpret_array(mi.ShapePtr, shape)
        return self._pool.interaction(hit, dr.zeros(mi.Ray3f), active)

    # ---- materials ----

    def _commit_materials(self, scene: Scene, named, changes: Changes) -> dict[str, None]:
        """Take in the named materials; returns the ids of objects whose shapes must be built anew."""
        rebuilt: dict[str, None] = {}
        for key in named:
            new, old = scene.materials.get(key), self._finishes.item(key)
            if new is None or new is old or (old is None and key not in self._users):
                continue
            self._finishes.put(new)
            changes.surfaces += 1
            if old is None:
                continue
            users = self._users.get(key, {})
            if needs_new_shape(old, new):
                rebuilt |= users
                continue
            for part in self._parts_of(users, key):
                reglow(part, old, new)
        return rebuilt

    def _parts_of(self, bodies, material: str):
        for key in bodies:
            for part in self._bodies[key].parts if key in self._bodies else ():
                if part.material == material:
                    yield part

    def _drop_unused_materials(self) -> None:
        for key in [k for k, users in self._users.items() if not users]:
            del self._users[key]
            self._finishes.drop(key)

    # ---- meshes ----

    def _changed_meshes(self, scene: Scene, named) -> list[str]:
        changed = [key for key in named if key in scene.meshes or key in self._bodies]
        geometries = {key for key in named if key in scene.geometries}
        if geometries:
            changed += [
                key
                for key, item in scene.meshes.items()
                if not isinstance(item, Mesh) and item.geometry in geometries
            ]
        return changed

    def _commit_mesh(self, scene: Scene, key: str, is_stale: bool, changes: Changes) -> None:
        item, old = scene.meshes.get(key), self._bodies.get(key)
        if item is None:
            if old is not None:
                self._remove_body(key)
                changes.removed += 1
            return
        geometry = None if isinstance(item, Mesh) else scene.geometries.get(item.geometry)
        if old is not None and not is_stale and not old.is_moved(item, geometry):
            self._redress(scene, key, item, changes)
            if self._bodies[key].item is item:
                return
        mesh = scene.mesh(key)
        check_mesh(mesh, scene.materials)
        if old is not None:
            self._remove_body(key)
        for material in mesh.materials:
            self._users.setdefault(material, {})[key] = None
            if self._finishes.item(material) is not scene.materials[material]:
                self._finishes.put(scene.materials[material])
        body = make_body(item, geometry, mesh, self.origin, self._finishes, self._pool)
        for part in body.parts:
            self._layer_of(body, part).add(part.shape, part.number, part.triangles)
        self._bodies[key] = body
        changes.built += 1

    def _redress(self, scene: Scene, key: str, item, changes: Changes) -> None:
        """Change what an object is made of or how it shows, where its shapes can stay; sets the body's item if so."""
        body = self._bodies[key]
        if item.materials != body.item.materials:
            if len(item.materials) != len(body.item.materials):
                return
            for part in body.parts:
                new = scene.materials.get(item.materials[part.slot])
                if new is None or needs_new_shape(self._finishes.item(part.material), new):
                    return
            for old, new in zip(body.item.materials, item.materials, strict=True):
                if new not in scene.materials:
                    return
                self._users.setdefault(new, {})[key] = None
                if self._finishes.item(new) is not scene.materials[new]:
                    self._finishes.put(scene.materials[new])
                if old not in item.materials:
                    self._users[old].pop(key, None)
            for part in body.parts:
                new = item.materials[part.slot]
                reglow(part, self._finishes.item(part.material), self._finishes.item(new))
                part.material = new
            changes.surfaces += 1
        body.item = item

    def _remove_body(self, key: str) -> None:
        body = self._bodies.pop(key)
        for part in body.parts:
            self._layer_of(body, part).remove(part.number)
            self._pool.remove(part.number)
        for material in body.item.materials:
            self._users[material].pop(key, None)

    def _layer_of(self, body: Body, part: Part) -> Layer:
        if not body.item.meets_light:
            return self._shown
        return self._veil if part.is_veil else self.solid

    # ---- lights ----

    def _commit_lights(self, scene: Scene, named, changes: Changes) -> None:
        for key in named:
            light, lamp = scene.lights.get(key), self._lamps.get(key)
            if light is None and lamp is None:
                continue
            changes.lights += 1
            if light is not None and lamp is not None:
                is_moved = change_lamp(lamp, light, self.origin, self._nothing)
                if is_moved is not None:
                    if is_moved:
                        self._veil.replace(lamp.body_id)
                        lamp.put_into(self._pool)
                    continue
            if lamp is not None:
                del self._lamps[key]
                if lamp.body is not None:
                    self._veil.remove(lamp.body_id)
                    self._pool.remove(lamp.body_id)
            if isinstance(light, Luminaire) and self._luminaires is None:
                self._luminaires = make_emitter(LuminairePalette())
            made = None
            if light is not None:
                made = make_lamp(light, self.origin, self._nothing, self._luminaires)
            if made is not None:
                self._lamps[key] = made
                if made.body is not None:
                    self._veil.add(made.body, made.body_id, 1)
                    made.put_into(self._pool)

    def sources(self) -> dict[str, Source]:
        """Emitters of the lights at work, by the lights' ids."""
        return {key: lamp.source for key, lamp in self._lamps.items()}

    def named_sources(self):
        """Yield the name of every light and glowing object at work with its emitter."""
        for lamp in self._lamps.values():
            yield lamp.item.name, lamp.source
        for body in self._bodies.values():
            for part in body.parts:
                if part.source is not None:
                    yield body.item.name, part.source

    def _commit_light_table(self, scene: Scene) -> None:
        """Bring bounds, mean light, portals, surroundings and the choice of lights up to date."""
        origin, self.radius = frame_of(*_bounds(scene, self._bodies.values()))
        if not np.array_equal(origin, self.origin) or self._pool.is_wasteful:
            raise Outgrown
        self.extent = dr.opaque(mi.Float, self.radius)
        met = [body for body in self._bodies.values() if body.item.meets_light]
        panes = [pane for body in met for pane in body.panes]
        panes = sorted(panes, key=portal_order)[:MAXIMUM_PORTALS]
        if [id(p) for p in panes] != [id(p) for p in self._panes]:
            self._panes = panes
            local = [Portal(p.centre - self.origin, p.half_u, p.half_v) for p in panes]
            self._portals = PortalSet(local) if local else None
        sources = [lamp.source for lamp in self._lamps.values()]
        sources += [p.source for body in met for p in body.parts if p.source]
        sources.sort(key=Source.order)
        rows = [source.luminaire for source in sources if source.luminaire is not None]
        if rows:
            self._luminaires.palette.commit(rows)
        else:
            self._luminaires = None
        suns = [
            light
            for light in scene.lights.values()
            if isinstance(light, SunLight) and light.output.value > 0.0
        ]
        suns.sort(key=lambda sun: (*sun.direction, sun.angle, sun.output.value))
        hard = bool(suns) or any(is_hard_to_meet(source, self.radius) for source in sources)
        parts = [part for body in self._bodies.values() for part in body.parts]
        self.known_mirrors.choose(parts, hard, self.origin)
        mean = self._mean_light(scene, sources, suns)
        if not np.array_equal(mean, self.mean_light):
            self.mean_light = mean
            self._finishes.set_light(mean)
        outside = self._commit_surroundings(suns)
        if outside is not None:
            sources.insert(0, outside)
        palette = self._luminaires.palette if rows else None
        self.lights = LightTable(sources, max(self.radius, 1.0), self._portals, palette)

    def _mean_light(self, scene: Scene, sources, suns) -> np.ndarray:
        """Flux-weighted mean spectrum of the scene's lights on the 1 nm grid, sum 1. (471,)

        Only the proportions of lamps matter here (they steer sampling and photometric reflectances), so emitters whose
        flux depends on the scene around them (world, sun) are weighed by the flux through the scene's bounds.
        """
        disk = np.pi * max(self.radius, 1.0) ** 2
        total = np.zeros(len(GRID))
        shining = [(source.density, source.flux) for source in sources]
        shining += [(m.density, m.amount * disk) for m in map(emission.sun_illuminance, suns)]
        if self._world is not None and not isinstance(scene.world, ImageWorld):
            made = emission.luminous(self._world.mean_luminance, scene.world.spectrum)
            shining.append((made.density, made.amount * np.pi * 4.0 * disk))
        different = {density.tobytes(): density for density, flux in shining if flux > 0.0}
        self.light_spectra = list(different.values())
        for density, flux in shining:
            total += density / max(density.sum(), 1e-300) * flux
        if isinstance(scene.world, ImageWorld) and scene.world.luminance_per_unit > 0.0:
            white = illuminant(GRID, "D65")
            total += white / white.sum() * max(total.sum(), 1.0)
        if total.sum() <= 0.0:
            total = np.ones(len(GRID))
        return total / total.sum()

    def _commit_surroundings(self, suns) -> Source | None:
        key = (id(self._world), tuple(map(id, suns)), self.radius, id(self._portals))
        if key != self._outside_key:
            made = make_surroundings(self._world, suns, self.radius, self._portals)
            self._outside = None
            self.surroundings = None
            if made is not None:
                self.surroundings, flux = made
                self._outside = Source(self.surroundings, flux, np.zeros(len(GRID)), None)
            # Kept so that the ids above stay taken.
            self._outside_key, self._outside_parts = key, (self._world, suns, self._portals)
        return self._outside

    # ---- tables by shape ----

    def _commit_tables(self) -> None:
        parts: list[tuple[Body, Part]] = [
            (body, part) for body in self._bodies.values() for part in body.parts
        ]
        lamps = [lamp for lamp in self._lamps.values() if lamp.body is not None]
        numbers = [part.number for _, part in parts] + [lamp.body_id for lamp in lamps]
        size = table_size(max(numbers, default=0) + 1)
        names = (
            "row",
            "object",
            "material",
            "hidden",
            "extent",
            "bsdf",
            "emitter",
            "luminaire",
        )
        columns = {name: np.zeros(size) for name in names}
        if parts:
            place = np.array([part.number for _, part in parts])
            columns["row"][place] = [self._finishes.row(part.material) for _, part in parts]
            columns["object"][place] = [body.item.index for body, _ in parts]
            columns["material"][place] = [
                self._finishes.item(part.material).index for _, part in parts
            ]
            columns["hidden"][place] = [not body.item.visible_to_camera for body, _ in parts]
            columns["extent"][place] = [
                np.abs([body.low - self.origin, body.high - self.origin]).max() for body, _ in parts
            ]
            columns["bsdf"][place] = [
                self._finishes.plugin_number(part.material) for _, part in parts
            ]
            columns["emitter"][place] = [p.source.number if p.source else 0 for _, p in parts]
        for lamp in lamps:
            columns["extent"][lamp.body_id] = np.abs(lamp.source.centre).max() + lamp.source.radius
            columns["hidden"][lamp.body_id] = not lamp.item.visible_to_camera
            columns["bsdf"][lamp.body_id] = pointer_id(self._nothing)
            columns["emitter"][lamp.body_id] = lamp.source.number
            if lamp.source.luminaire is not None:
                columns["luminaire"][lamp.body_id] = self.lights.row_of(lamp.source)
        luminaires = columns["luminaire"] if self._luminaires is not None else None
        used = (self._finishes.item(key) for key in self._users)
        self._pool.has_grain = any(has_grain(item.surface) for item in used if item is not None)
        self._pool.commit(size, columns["bsdf"], columns["emitter"], luminaires)
        self._finishes.commit(columns["row"])
        self.indices = {name: upload(mi.Float, columns[name]) for name in ("object", "material")}
        self._extents = upload(mi.Float, columns["extent"])
        hidden = columns["hidden"] > 0.0
        self.hidden = upload(mi.Bool, hidden) if hidden.any() else None
        shapes = [part for _, part in parts]
        self.known_mirrors.commit(size, shapes)
        self.polarisation = make_polarisation(
            size, shapes, self._finishes.item, self._finishes.make
        )
        dr.eval(self.indices, self.hidden, self._extents)

    # ---- notes ----

    def _note(self, scene: Scene) -> None:
        """Say what is approximated."""
        self.notes = self._finishes.notes()
        if isinstance(scene.world, ImageWorld):
            self.notes += [
                f"{what}: {instead}" for what, instead in describe_faults(scene.world.image)
            ]
        if self.radius > COARSE_RADIUS:
            self.notes.append(
                f"the scene is {2e-3 * self.radius:.3g} km wide: places in it are rounded to about "
                f"{1e3 * self.radius * SINGLE:.2g} mm"
            )


def _bounds(scene: Scene, bodies=None) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of everything, objects by their boxes. ``bodies``: known extents. (3,), (3,) [m]"""
    low, high = [np.full(3, np.inf)], [np.full(3, -np.inf)]
    if bodies is None:
        for item in scene.meshes.values():
            geometry = None if isinstance(item, Mesh) else scene.geometries.get(item.geometry)
            lowest, highest = extent(item, geometry)
            if np.all(lowest <= highest):
                check_reach(f"object '{item.name}'", lowest, highest)
            low.append(lowest)
            high.append(highest)
    else:
        for body in bodies:
            # Boxes of nothing are endless the wrong way round.
            if not np.abs(body.high).max() <= FARTHEST and np.all(body.low <= body.high):
                check_reach(f"object '{body.item.name}'", body.low, body.high)
            low.append(body.low)
            high.append(body.high)
    for light in scene.lights.values():
        if not isinstance(light, SunLight) and light.output.value > 0.0:
            low.append(light.place - light.reach)
            high.append(light.place + light.reach)
    low, high = np.min(low, axis=0), np.max(high, axis=0)
    is_empty = np.isposinf(low).all() and np.isneginf(high).all()
    if not is_empty and not (np.isfinite(low) & np.isfinite(high)).all():
        raise SceneError("a mesh or light has a position that is not a finite number")
    return low, high
