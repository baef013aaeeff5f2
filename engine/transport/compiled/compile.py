"""From the scene description to the Mitsuba objects that the estimators trace, and from edit to edit.

Every object, light and material is kept under its id; a commit changes what the ids named since the last one ask for.
The state after any series of edits gives the same pictures as a scene compiled at once: everything that steers sampling
(the order of the lights, the frame's origin, the mean light) follows from the scene alone, not from its history.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import pointer_id, table_size, upload
from ...luminaires.emitters import plugins as emitter_plugins
from ...luminaires.emitters.luminaire_plugin import make_emitter
from ...luminaires.emitters.palette import LuminairePalette
from ...luminaires.emitters.rectangle_plugin import make_rectangles
from ...materials import plugins as surface_plugins
from ...photometry.spectra import GRID
from ...requirements.facts import worlds
from ...requirements.plan import Plan
from ...scattering.kernels import plugin as scattering_plugin
from ...scene.light import ImageWorld, Luminaire, SunLight
from ...scene.light_groups import WORLD
from ...scene.material import Holdout
from ...scene.scene import Scene
from ...sky import plugin as sky_plugin
from ...sky.picture import describe_faults
from ..devices import of_variant
from ..layers import make_layers
from .bounds import find_bounds, frame_of
from .changes import Changes, Outgrown, Stamps
from .compiled_light import CompiledLight, Shared, change_light, compile_light, is_rectangle
from .enclosures import find_enclosed
from .grain_ways import find_coordinates, find_ways
from .known_mirrors import KnownMirrors, is_hard_to_meet
from .lights import LightTable, Source
from .material_palette import MaterialPalette
from .mean_light import find_mean_light
from .object_set import ObjectSet
from .polarisation import make_polarisation
from .pool import SurfacePool
from .surroundings import Outside

FEW_RAYS = 0.01
"""Error for want of rays above which results tell it. [-]"""

COARSE_RADIUS = 1e5
"""Size of scenes from which on the rounding of places is told. [m]"""

SINGLE = 2.0**-24
"""Relative error by which single precision rounds."""


class CompiledScene:
    """Mitsuba objects of one scene, for one variant. Owned and used by one thread.

    ``solid`` holds what stops light, ``transparent`` what light may pass straight (panes, cut-outs, the bodies of lights),
    ``shown`` what is there for the camera alone. Tables by shape, None where there is nothing of the kind: ``hidden``, what
    the camera does not see, ``holdouts``, where it sees a hole, ``catchers``, what shows but its shadows, ``grounds``, those
    of them that light does not meet, ``seen_catchers``, all parts of those that the camera sees, and ``unlit``, what is
    there for the camera alone. ``lights`` chooses emitters; ``surroundings`` is what rays that leave the scene see.
    Positions are relative to ``origin`` (float64, world) so that single precision serves scenes far from the world's origin;
    ``extent`` [m] is the largest of them.
    ``stamps`` tell what commits have changed.

    Raises
    ------
    SceneError    An object has a material that the scene lacks, or a light's quantity does not fit its kind.
    """

    def __init__(self, scene: Scene, requirements: Plan):
        surface_plugins.register()
        scattering_plugin.register()
        emitter_plugins.register()
        sky_plugin.register()
        self.requirements = requirements
        self.origin = frame_of(*find_bounds(scene))[0]
        self.radius = 1.0
        self.extent = mi.Float(1.0)
        self._extents = mi.Float(0.0)
        self.mean_light = np.ones(len(GRID)) / len(GRID)
        self.light_spectra: list[np.ndarray] = []
        self._pool = SurfacePool()
        shares = not of_variant(mi.variant()).traces_many
        self.solid, self._transparent, self._shown = make_layers(self._pool, 3, shares)
        # What light bodies are made of for others' light: nothing.
        self._nothing = mi.load_dict({"type": "null"})
        self.hidden = self.holdouts = self.unlit = None
        self.catchers = self.grounds = self.seen_catchers = None
        # Whether the camera does not see an object, and not only bodies of lights.
        self.has_hidden_objects = False
        # Whether the camera sees flakes of some surface one by one.
        self.has_sparkle = False
        self.known_mirrors = KnownMirrors()
        self.polarisation = None
        self.indices: dict = {}
        self.notes: list[str] = []
        self.stamps = Stamps()
        # What bends light, with the stamps for which it was found, see `find_targets`.
        self.kept_targets: tuple[Stamps, object] | None = None
        # Light over bends for the paths of a job, see `bent_lights`.
        self.bent = None
        # Small bright spots towards which paths are scattered, see `bright_spots`.
        self.spots = None
        # Straight light that a job traces, see `straight_lights`.
        self.near = None
        self._lights: dict[str, CompiledLight] = {}
        self._suns: list[SunLight] = []
        # Ids of what shines, None: all; what is kept of the light of a scene holds for these alone, see `shine`.
        self.shining: frozenset[str] | None = None
        # Mitsuba visits every emitter that lives, so there is none without luminaires, or rectangles.
        self._luminaires = self._rectangles = None
        self._material_palette = MaterialPalette(self.mean_light)
        self._objects = ObjectSet(
            self.origin,
            self._pool,
            self._material_palette,
            self.solid,
            self._transparent,
            self._shown,
        )
        self._outside = Outside()
        self.commit(scene, [*scene.meshes, *scene.materials, *scene.lights], requirements)

    @property
    def transparent(self):
        """Layer of what light may pass straight, None when there is nothing of the kind."""
        return self._transparent if len(self._transparent) else None

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
        self._transparent.settle()
        self._shown.settle()

    def commit(self, scene: Scene, named: list[str], requirements: Plan) -> Changes:
        """Bring everything that ids name up to date.

        The order of the ids decides nothing but between surfaces at exactly the same place.

        Raises
        ------
        Outgrown    The scene has to be compiled anew.
        SceneError    The scene cannot be computed; this object must not be used any more.
        """
        changes = Changes()
        self.requirements = requirements
        self.shining = None
        self._objects.commit(scene, named, changes)
        self._commit_lights(scene, named, changes)
        if self._outside.take_world(scene.world, self.origin):
            changes.other.append("surroundings changed")
        self._commit_light(scene)
        self._commit_light_table()
        self._commit_tables()
        changes.is_rebuilt = self.solid.commit() | self._transparent.commit() | self._shown.commit()
        self._note(scene)
        self.stamps = self.stamps.after(changes)
        return changes

    def shine(self, members: frozenset[str] | None = None) -> bool:
        """Let no other lights than these shine until the next commit, and tell whether that is new; None: all shine.

        Nothing but the choice of lights is made anew. What steers sampling beyond it stays that of the whole scene.

        Parameters
        ----------
        members : frozenset of str or None    Ids of lights and glowing materials, and `WORLD`.
        """
        if members == self.shining:
            return False
        self.shining = members
        self._commit_light_table()
        self._commit_tables()
        return True

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

    @property
    def has_lit_catchers(self) -> bool:
        """Whether light meets some of what shows but its shadows."""
        items = (body.item for body in self._objects.bodies.values())
        return any(item.is_catcher and item.meets_light for item in items)

    def parts(self):
        """Yield every part of an object that light meets: the object's id, the part, its material."""
        for key, body in self._objects.bodies.items():
            for part in body.parts:
                if part.meets_light:
                    yield key, part, self._material_palette.item(part.material)

    def compiled_lights(self):
        """Yield every light at work but those at infinity, as `CompiledLight`."""
        yield from self._lights.values()

    def object_name(self, key: str) -> str:
        """Name of an object, for people."""
        return self._objects.bodies[key].item.name

    def object_bounds(self, key: str) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest corner of an object in the scene's frame. (3,), (3,) [m]"""
        body = self._objects.bodies[key]
        return body.low - self.origin, body.high - self.origin

    @property
    def surroundings(self):
        """Emitter that rays which leave the scene see, None if they see nothing."""
        return self._outside.emitter

    @property
    def backdrop(self):
        """Emitter that the camera sees behind everything, None if that is nothing."""
        return self._outside.backdrop

    @property
    def has_backdrop(self) -> bool:
        """Whether the camera sees other surroundings than those that give light."""
        return self._outside.has_backdrop

    def whole_surroundings(self) -> tuple:
        """`surroundings` and `backdrop` as they are while all lights shine."""
        return self._outside.whole(self._suns, self.radius)

    @property
    def suns(self) -> tuple[SunLight, ...]:
        """Suns of the surroundings, in their order there."""
        return self._outside.suns

    @property
    def world_luminance(self) -> float:
        """Mean over all directions of the world without its suns. [cd/m2]"""
        return self._outside.world_luminance

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

    # ---- lights ----

    def _commit_lights(self, scene: Scene, named, changes: Changes) -> None:
        for key in named:
            light, old = scene.lights.get(key), self._lights.get(key)
            if light is None and old is None:
                continue
            changes.lights += 1
            if isinstance(light, Luminaire) and self._luminaires is None:
                self._luminaires = make_emitter(LuminairePalette())
            if light is not None and is_rectangle(light) and self._rectangles is None:
                self._rectangles = make_rectangles()
            shared = Shared(self.origin, self._nothing, self._luminaires, self._rectangles)
            if light is not None and old is not None:
                is_moved = change_light(old, light, shared)
                if is_moved is not None:
                    if is_moved:
                        self._transparent.replace(old.body_id)
                        old.put_into(self._pool)
                    continue
            if old is not None:
                del self._lights[key]
                if old.body is not None:
                    self._transparent.remove(old.body_id)
                    self._pool.remove(old.body_id)
            new = None if light is None else compile_light(light, shared)
            if new is not None:
                self._lights[key] = new
                if new.body is not None:
                    self._transparent.add(new.body, new.body_id, 1)
                    new.put_into(self._pool)

    def sources(self) -> dict[str, Source]:
        """Emitters of the lights at work, by the lights' ids."""
        return {key: light.source for key, light in self._lights.items()}

    def named_sources(self):
        """Yield the name of every light and glowing object at work with its emitter."""
        for light in self._lights.values():
            yield light.item.name, light.source
        for body in self._objects.bodies.values():
            for part in body.parts:
                if part.source is not None:
                    yield body.item.name, part.source

    def _commit_light(self, scene: Scene) -> None:
        """Bring bounds, mean light and portals up to date."""
        origin, self.radius = frame_of(*find_bounds(scene, self._objects.bodies.values()))
        if not np.array_equal(origin, self.origin) or self._pool.is_wasteful:
            raise Outgrown
        self.extent = dr.opaque(mi.Float, self.radius)
        met = [body for body in self._objects.bodies.values() if body.item.meets_light]
        self._outside.take_panes([pane for body in met for pane in body.panes], self.origin)
        sources = self._sources()
        if all(source.luminaire is None for source in sources):
            self._luminaires = None
        if all(source.rectangle is None for source in sources):
            self._rectangles = None
        suns = [
            light
            for light in scene.lights.values()
            if isinstance(light, SunLight) and light.output.value > 0.0
        ]
        suns.sort(key=lambda sun: (*sun.direction, sun.angle, sun.output.value))
        self._suns = suns
        hard = bool(suns) or any(is_hard_to_meet(source, self.radius) for source in sources)
        parts = [part for _, part in self._objects.parts()]
        self.known_mirrors.choose(parts, hard, self.origin)
        seen = [p.source for p in parts if p.source is not None and not p.meets_light]
        mean, self.light_spectra = find_mean_light(
            scene.world, self.world_luminance, sources, suns, self.radius, seen
        )
        if not np.array_equal(mean, self.mean_light):
            self.mean_light = mean
            self._material_palette.set_light(mean)

    def _shines(self, key: str) -> bool:
        return self.shining is None or key in self.shining

    def _sources(self) -> list[Source]:
        """Emitters of what shines but the surroundings, in the order of `Source.order`."""
        sources = [light.source for key, light in self._lights.items() if self._shines(key)]
        parts = [part for _, part in self._objects.parts() if part.meets_light and part.source]
        sources += [part.source for part in parts if self._shines(part.owner)]
        return sorted(sources, key=Source.order)

    def _commit_light_table(self) -> None:
        """Bring surroundings and the choice of lights up to date."""
        sources = self._sources()
        rows = [source.luminaire for source in sources if source.luminaire is not None]
        if rows:
            self._luminaires.palette.commit(rows)
        rectangles = [source.rectangle for source in sources if source.rectangle is not None]
        if rectangles:
            self._rectangles.table.commit(rectangles)
        suns = [sun for sun in self._suns if self._shines(sun.id)]
        outside = self._outside.commit(suns, self.radius, self._shines(WORLD))
        if outside is not None:
            sources.insert(0, outside)
        palette = self._luminaires.palette if rows else None
        table = self._rectangles.table if rectangles else None
        self.lights = LightTable(
            sources, max(self.radius, 1.0), self._outside.portals, palette, table
        )

    # ---- tables by shape ----

    def _commit_tables(self) -> None:
        parts = self._objects.parts()
        luminous = [light for light in self._lights.values() if light.body is not None]
        numbers = [part.number for _, part in parts] + [light.body_id for light in luminous]
        size = table_size(max(numbers, default=0) + 1)
        names = (
            "row",
            "object",
            "material",
            "hidden",
            "holdout",
            "catcher",
            "ground",
            "seen_catcher",
            "unlit",
            "extent",
            "bsdf",
            "emitter",
            "lamp",
        )
        columns = {name: np.zeros(size) for name in names}
        self.has_hidden_objects = False
        if parts:
            place = np.array([part.number for _, part in parts])
            columns["row"][place] = [self._material_palette.row(part.material) for _, part in parts]
            columns["object"][place] = [body.item.index for body, _ in parts]
            columns["material"][place] = [
                self._material_palette.item(part.material).index for _, part in parts
            ]
            columns["hidden"][place] = [
                not (body.item.visible_to_camera and part.meets_camera) for body, part in parts
            ]
            self.has_hidden_objects = bool(columns["hidden"].any())
            columns["holdout"][place] = [
                isinstance(self._material_palette.item(part.material).surface, Holdout)
                for _, part in parts
            ]
            columns["catcher"][place] = [
                body.item.is_catcher and not body.item.is_holdout for body, _ in parts
            ]
            columns["ground"][place] = columns["catcher"][place] * [
                not body.item.meets_light for body, _ in parts
            ]
            columns["seen_catcher"][place] = columns["catcher"][place] * [
                body.item.visible_to_camera for body, _ in parts
            ]
            columns["unlit"][place] = [not part.meets_light for _, part in parts]
            columns["extent"][place] = [
                np.abs([body.low - self.origin, body.high - self.origin]).max() for body, _ in parts
            ]
            columns["bsdf"][place] = [
                self._material_palette.plugin_number(part.material) for _, part in parts
            ]
            columns["emitter"][place] = [
                p.source.number if p.source and self._shines(p.owner) else 0 for _, p in parts
            ]
        for light in luminous:
            columns["extent"][light.body_id] = (
                np.abs(light.source.centre).max() + light.source.radius
            )
            columns["hidden"][light.body_id] = not light.item.visible_to_camera
            columns["bsdf"][light.body_id] = pointer_id(self._nothing)
            if not self._shines(light.item.id):
                continue
            columns["emitter"][light.body_id] = light.source.number
            columns["lamp"][light.body_id] = self.lights.row_of(light.source)
        has_rows = self.lights.palette is not None or self.lights.rectangles is not None
        lamps = columns["lamp"] if has_rows else None
        surfaces = [item.surface for item in self._objects.materials()]
        self._pool.has_grain = any(surface.has_grain for surface in surfaces)
        self._pool.has_relief = any(surface.has_relief for surface in surfaces)
        self._pool.commit(size, columns["bsdf"], columns["emitter"], lamps)
        is_round = any(grain.axis is not None for surface in surfaces for grain in surface.grains)
        ways = find_ways(size, parts, self.origin) if is_round else None
        self.has_sparkle = any(surface.has_sparkle for surface in surfaces)
        places = find_coordinates(size, parts, self.origin) if self.has_sparkle else None
        self._material_palette.commit(columns["row"], self._axes(size, parts), ways, places)
        self.indices = {name: upload(mi.Float, columns[name]) for name in ("object", "material")}
        self._extents = upload(mi.Float, columns["extent"])
        self.hidden, self.holdouts, self.unlit = (
            _marks(columns[name]) for name in ("hidden", "holdout", "unlit")
        )
        self.catchers, self.grounds, self.seen_catchers = (
            _marks(columns[name]) for name in ("catcher", "ground", "seen_catcher")
        )
        shapes = [part for _, part in parts]
        self.known_mirrors.commit(size, shapes)
        self.polarisation = make_polarisation(
            size, shapes, self._material_palette.item, self._material_palette.make
        )
        dr.eval(self.indices, self.hidden, self.holdouts, self.unlit, self._extents)
        dr.eval(self.catchers, self.grounds, self.seen_catchers)

    def _axes(self, size: int, parts) -> np.ndarray | None:
        """Axes of the object of every shape, None where no relief asks for them. (size, 3, 3)"""
        if not self._pool.has_relief:
            return None
        axes = np.broadcast_to(np.eye(3), (size, 3, 3)).copy()
        for body, part in parts:
            if hasattr(body.item, "frame"):
                axes[part.number] = np.asarray(body.item.frame)[:3, :3]
        return axes

    # ---- notes ----

    def _note(self, scene: Scene) -> None:
        """Say what is approximated."""
        self.notes = self._material_palette.notes()
        device = of_variant(mi.variant())
        if not device.is_trusted:
            self.notes.append(
                f"computed on {device.label}, where not all jobs have been seen to be right: compare with the processor"
            )
        self.notes += find_enclosed(self)
        self.notes += _tell_few_rays(scene)
        for world in worlds(scene):
            if isinstance(world, ImageWorld):
                self.notes += [
                    f"{what}: {instead}" for what, instead in describe_faults(world.image)
                ]
        if self.radius > COARSE_RADIUS:
            self.notes.append(
                f"the scene is {2e-3 * self.radius:.3g} km wide: places in it are rounded to about "
                f"{1e3 * self.radius * SINGLE:.2g} mm"
            )


def _tell_few_rays(scene: Scene) -> list[str]:
    """Say of which lights so few rays are known that results cannot be as exact as what is stated of them."""
    known: dict[float, list[str]] = {}
    for light in scene.lights.values():
        rays = getattr(light, "rays", None)
        if rays is not None and rays.open_error > FEW_RAYS:
            known.setdefault(rays.open_error, []).append(light.name)
    return [
        f"'{names[0]}'{f' and {len(names) - 1} more' if len(names) > 1 else ''}: the ray file has so few rays that light in "
        f"a cell with a 192nd of it is known within {100.0 * error:.2g} %, which errors of sensors and lux maps hold, but "
        "none of pictures"
        for error, names in known.items()
    ]


def _marks(column: np.ndarray):
    """Marks by the number of a shape on the device, None where there is none."""
    marks = column > 0.0
    return upload(mi.Bool, marks) if marks.any() else None
