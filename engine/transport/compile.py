"""From the scene description to Mitsuba objects that the estimators trace."""

from dataclasses import dataclass, field

import drjit as dr
import mitsuba as mi
import numpy as np

from ..errors import SceneError
from ..luminaires import plugins as emitter_plugins
from ..luminaires.portals import Portal, PortalSet, find_portals
from ..materials import plugins as surface_plugins
from ..photometry import units
from ..photometry.colour import REC709_LUMINANCE
from ..photometry.spectra import GRID, illuminant, luminous_efficiency
from ..scene.light import AreaLight, ImageWorld, PointLight, SpotLight, SunLight, UniformWorld
from ..scene.material import Dielectric, Diffuse, Material, ThinGlass
from ..scene.mesh import Mesh
from ..scene.scene import Scene
from ..scene.spectrum import Constant
from . import emission
from .lights import LightTable, Place
from .requirements import Requirements, pictures
from .surfaces import approximations, bsdf, is_plain, palette, passes_straight
from .textures import TextureMaker, is_spectral

SUN_POINT_ANGLE = 1e-5
"""Suns narrower than this are computed as disks of this angular diameter; no shadow shows the difference. [rad]"""

PORTAL_SHARE = 0.75
"""Share of the world's samples that aim at panes, where there are any."""

DELTA_RADIUS = 1e-5
"""Point lights smaller than this are ideal points. [m]"""


@dataclass
class CompiledScene:
    """Mitsuba objects of one scene state, for one variant. Owned and used by one thread.

    ``solid`` holds what stops light, ``veil`` what light may pass straight (panes, cut-outs, the bodies of lights).
    ``lights`` chooses emitters; ``surroundings`` is what rays that leave the scene see. Positions are relative to
    ``origin`` (float64, world) so that single precision serves scenes far from the world's origin.
    """

    solid: object
    veil: object | None
    lights: object
    surroundings: object | None
    origin: np.ndarray
    requirements: Requirements
    mean_light: np.ndarray
    hidden: object | None
    indices: dict
    notes: list[str] = field(default_factory=list)
    keep: list = field(default_factory=list)

    def local(self, points) -> np.ndarray:
        """World points (n, 3) [m] in the compiled scene's frame, float32."""
        return (np.asarray(points, dtype=np.float64) - self.origin).astype(np.float32)


def mean_light(scene: Scene) -> np.ndarray:
    """Flux-weighted mean spectrum of the scene's lights on the 1 nm grid, sum 1. (471,)

    Only the proportions of lamps matter here (they steer sampling and photometric reflectances), so emitters whose
    flux depends on the scene around them (world, sun) are weighed by the flux through the scene's bounds.
    """
    total = np.zeros(len(GRID))
    for made, flux in _emission_list(scene):
        density = made.density / max(made.density.sum(), 1e-300)
        total += density * flux
    if isinstance(scene.world, ImageWorld):
        white = illuminant(GRID, "D65")
        total += white / white.sum() * max(total.sum(), 1.0)
    if total.sum() <= 0.0:
        total = np.ones(len(GRID))
    return total / total.sum()


def _bounds(scene: Scene) -> tuple[np.ndarray, float]:
    """Centre (rounded to whole metres) and radius of everything. [m]"""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    points = [mesh.vertices for mesh in scene.meshes.values() if len(mesh.vertices)]
    points += [
        np.asarray(light.position)[None]
        for light in scene.lights.values()
        if isinstance(light, PointLight | SpotLight)
    ]
    points += [
        light.frame[:3, 3][None] for light in scene.lights.values() if isinstance(light, AreaLight)
    ]
    for cloud in points:
        low = np.minimum(low, cloud.min(axis=0))
        high = np.maximum(high, cloud.max(axis=0))
    if not np.all(np.isfinite(low)) or not np.all(np.isfinite(high)):
        if points:
            raise SceneError("a mesh or light has a position that is not a finite number")
        return np.zeros(3), 1.0
    centre = np.round(0.5 * (low + high))
    return centre, float(np.linalg.norm(np.maximum(high - centre, centre - low)))


def _emission_list(scene: Scene):
    """Yield (light per unit, flux in lm) of everything that emits; world and suns through the bounding sphere."""
    _, radius = _bounds(scene)
    disk = np.pi * max(radius, 1.0) ** 2
    for light in scene.lights.values():
        match light:
            case PointLight():
                made = emission.point_intensity(light)
                yield made, made.amount * 4.0 * np.pi
            case SpotLight():
                made = emission.spot_intensity(light)
                yield made, made.amount * units.spot_solid_angle(light.half_angle, light.blend)
            case AreaLight():
                made = emission.area_luminance(light)
                flux = made.amount * np.pi * emission.area_of(light)
                yield made, flux / units.spread_axis_factor(light.spread)
            case SunLight():
                made = emission.sun_illuminance(light)
                yield made, made.amount * disk
    for mesh in scene.meshes.values():
        areas = None
        for slot, key in enumerate(mesh.materials):
            glow = scene.materials[key].emission if key in scene.materials else None
            if glow is None or glow.luminance <= 0.0:
                continue
            areas = mesh.areas() if areas is None else areas
            area = float(areas[mesh.material_index == slot].sum())
            sides = 2.0 if glow.two_sided else 1.0
            yield (
                emission.luminous(glow.luminance, glow.spectrum),
                glow.luminance * np.pi * area * sides,
            )
    if isinstance(scene.world, UniformWorld) and scene.world.luminance > 0.0:
        made = emission.luminous(scene.world.luminance, scene.world.spectrum)
        yield made, made.amount * np.pi * 4.0 * disk


def compile_scene(scene: Scene, requirements: Requirements) -> CompiledScene:
    """Build all Mitsuba objects of a scene in the active variant.

    Raises
    ------
    SceneError    A mesh has a material that the scene lacks, or a light's quantity does not fit its kind.
    """
    surface_plugins.register()
    emitter_plugins.register()
    return _Compiler(scene, requirements).run()


class _Compiler:
    """One pass over a scene; keeps what the parts share."""

    def __init__(self, scene: Scene, requirements: Requirements):
        self.scene = scene
        self.requirements = requirements
        self.origin, self.radius = _bounds(scene)
        self.light = mean_light(scene)
        self.make = TextureMaker(self.light)
        self.emitters: list = []
        self.fluxes: list[float] = []
        self.places: list[Place] = []
        self.solids: list = []
        self.veils: list = []
        self.hidden: list = []
        self.rows: list[tuple[object, int, int]] = []
        self.notes: list[str] = []
        self.bsdfs: dict[str, object] = {}
        self.plain: dict[str, int] = {}
        self.plain_shapes: list[tuple[object, int]] = []
        self.palette = mi.load_dict({"type": "lumenray_coated"})

    def run(self) -> CompiledScene:
        for mesh in self.scene.meshes.values():
            self._add_mesh(mesh)
        for light in self.scene.lights.values():
            self._add_light(light)
        self.portals = self._find_portals()
        surroundings = self._add_surroundings()
        self._fill_palette()
        self._note_missing_caustics()
        solid = mi.load_dict(
            {"type": "scene", **{f"s{i}": s for i, s in enumerate(self.solids)}}, optimize=False
        )
        veil = None
        if self.veils:
            veil = mi.load_dict(
                {"type": "scene", **{f"v{i}": s for i, s in enumerate(self.veils)}}, optimize=False
            )
        return CompiledScene(
            solid=solid,
            veil=veil,
            lights=LightTable(
                self.emitters, self.fluxes, self.places, max(self.radius, 1.0), self.portals
            ),
            surroundings=surroundings,
            origin=self.origin,
            requirements=self.requirements,
            mean_light=self.light,
            hidden=_shape_mask(self.hidden),
            indices=_index_tables(self.rows),
            notes=self.notes,
            keep=[self.emitters, self.solids, self.veils, self.bsdfs, self.palette],
        )

    def _note_missing_caustics(self) -> None:
        """Say which light the paths cannot find: that of ideal points, focused by smooth solid glass."""
        used = {key for mesh in self.scene.meshes.values() for key in mesh.materials}
        glass = [
            self.scene.materials[key].name
            for key in sorted(used)
            if isinstance(self.scene.materials[key].surface, Dielectric)
        ]
        points = [
            light.name
            for light in self.scene.lights.values()
            if isinstance(light, SpotLight)
            or (isinstance(light, PointLight) and light.radius < DELTA_RADIUS)
        ]
        if glass and points:
            self.notes.append(
                f"light of '{points[0]}' that passes solid glass ('{glass[0]}') is missing: no path finds an ideal "
                "point or spot through it; use a point light with a radius, or a pane"
            )

    # ---- meshes ----

    def _add_mesh(self, mesh: Mesh) -> None:
        _check_mesh(mesh)
        for slot, key in enumerate(mesh.materials):
            if key not in self.scene.materials:
                raise SceneError(
                    f"object '{mesh.name}' refers to a material that the scene does not hold ({key})"
                )
            triangles = np.flatnonzero(mesh.material_index == slot)
            if len(triangles):
                self._add_part(mesh, self.scene.materials[key], triangles)

    def _add_part(self, mesh: Mesh, material: Material, triangles: np.ndarray) -> None:
        properties = mi.Properties()
        properties["bsdf"] = self._bsdf(material)
        glow = material.emission
        emitter = None
        if glow is not None and glow.luminance > 0.0:
            area = float(mesh.areas()[triangles].sum())
            if area > 0.0:
                emitter = self._surface_emitter(
                    emission.luminous(glow.luminance, glow.spectrum),
                    glow.two_sided,
                    pattern=glow.pattern,
                )
                properties["emitter"] = emitter
                corners = mesh.vertices[mesh.triangles[triangles]].reshape(-1, 3)
                centre = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
                radius = float(np.linalg.norm(corners.max(axis=0) - centre))
                sides = 2 if glow.two_sided else 1
                self._note_emitter(emitter, glow.luminance * np.pi * area * sides, centre, radius)
        shape = self._mesh_shape(mesh, _uv_map_of(material), triangles, properties)
        (self.veils if passes_straight(material.surface) else self.solids).append(shape)
        if not mesh.visible_to_camera:
            self.hidden.append(shape)
        self.rows.append((shape, mesh.index, material.index))
        if material.id in self.plain:
            self.plain_shapes.append((shape, self.plain[material.id]))

    def _mesh_shape(self, mesh: Mesh, uv_map: str, triangles, properties):
        uv = mesh.uv_maps.get(uv_map)
        if uv is None and mesh.uv_maps:
            uv = next(iter(mesh.uv_maps.values()))
        normals = mesh.corner_normals
        if normals is None:
            properties["face_normals"] = True
        used = mesh.triangles[triangles]
        if normals is None and uv is None:
            vertices, faces = np.unique(used, return_inverse=True)
            positions = mesh.vertices[vertices]
            faces = faces.reshape(-1)
        else:
            # Corners carry their own normals and texture coordinates, so vertices are not shared.
            positions = mesh.vertices[used].reshape(-1, 3)
            faces = np.arange(3 * len(triangles))
        shape = mi.Mesh(
            mesh.name,
            len(positions),
            len(triangles),
            properties,
            normals is not None,
            uv is not None,
        )
        values = mi.traverse(shape)
        values["vertex_positions"] = mi.Float(
            ((positions - self.origin).astype(np.float32)).ravel()
        )
        values["faces"] = mi.UInt32(faces.astype(np.uint32))
        if normals is not None:
            values["vertex_normals"] = mi.Float(normals[triangles].astype(np.float32).ravel())
        if uv is not None:
            values["vertex_texcoords"] = mi.Float(uv[triangles].astype(np.float32).ravel())
        values.update()
        return shape

    def _bsdf(self, material: Material):
        """Plug-in of a material; all plain ones share the palette."""
        if is_plain(material.surface):
            self.plain.setdefault(material.id, len(self.plain))
            return self.palette
        if material.id not in self.bsdfs:
            made = bsdf(material.surface, self.make)
            self.bsdfs[material.id] = mi.load_dict(made) if isinstance(made, dict) else made
            self.notes += [
                f"material '{material.name}': {text}" for text in approximations(material.surface)
            ]
        return self.bsdfs[material.id]

    def _fill_palette(self) -> None:
        surfaces = [self.scene.materials[key].surface for key in self.plain] or [
            Diffuse(Constant(0.0))
        ]
        self.palette.set_palette(**palette(surfaces, self.make))
        ids = _shape_ids([shape for shape, _ in self.plain_shapes])
        rows = np.zeros(int(ids.max(initial=0)) + 1)
        rows[ids] = [row for _, row in self.plain_shapes]
        self.palette.set_rows(rows)

    # ---- lights ----

    def _surface_emitter(self, made, two_sided=False, pattern=None, spread=np.pi):
        plugin = {"type": "lumenray_surface", "radiance": made.texture(), "two_sided": two_sided}
        if pattern is not None:
            plugin["pattern"] = self.make.picture(pattern, largest=1.0)
        if spread < np.pi - 1e-3:
            plugin["tan_spread"] = float(np.tan(0.5 * spread))
        return mi.load_dict(plugin)

    def _note_emitter(self, emitter, flux: float, centre=None, radius: float = 0.0) -> None:
        """Offer an emitter to next-event; ``centre`` in world space, None for light from infinity."""
        self.emitters.append(emitter)
        self.fluxes.append(float(flux))
        local = None if centre is None else np.asarray(centre, dtype=np.float64) - self.origin
        self.places.append(Place(local, radius))

    def _add_light(self, light) -> None:
        if light.output.value <= 0.0:
            return
        match light:
            case PointLight():
                self._add_point(light)
            case SpotLight():
                self._add_spot(light)
            case AreaLight():
                self._add_area(light)

    def _add_point(self, light: PointLight) -> None:
        made = emission.point_intensity(light)
        flux = 4.0 * np.pi * made.amount
        centre = [float(x) for x in np.asarray(light.position) - self.origin]
        if light.radius < DELTA_RADIUS:
            self._note_emitter(
                mi.load_dict({"type": "point", "position": centre, "intensity": made.texture()}),
                flux,
                light.position,
            )
            return
        luminance = made.scaled(units.luminance_from_intensity_sphere(1.0, light.radius))
        emitter = self._surface_emitter(luminance)
        shape = {"type": "sphere", "center": centre, "radius": float(light.radius)}
        self._add_body(shape, emitter, flux, light.visible_to_camera)
        self.places[-1] = Place(np.array(centre), light.radius)

    def _add_spot(self, light: SpotLight) -> None:
        made = emission.spot_intensity(light)
        plugin = {
            "type": "lumenray_spot",
            "intensity": made.texture(),
            "position": [float(x) for x in np.asarray(light.position) - self.origin],
            "direction": [float(x) for x in light.direction],
            "cos_end": float(np.cos(light.half_angle)),
            "blend": float(light.blend),
            "radius": float(light.radius),
        }
        flux = made.amount * units.spot_solid_angle(light.half_angle, light.blend)
        self._note_emitter(mi.load_dict(plugin), flux, light.position, light.radius)

    def _add_area(self, light: AreaLight) -> None:
        area = emission.area_of(light)
        if area <= 0.0:
            raise SceneError(f"area light '{light.name}' has no area; give it a size above 0")
        made = emission.area_luminance(light)
        frame = np.array(light.frame, dtype=np.float64)
        frame[:3, 3] -= self.origin
        # Blender's area lights shine along -z, Mitsuba's flat shapes along +z: turn about x.
        placed = frame @ np.diag([0.5 * light.size_x, -0.5 * light.size_y, -1.0, 1.0])
        shape = {
            "type": "disk" if light.shape == "ellipse" else "rectangle",
            "to_world": mi.ScalarTransform4f([list(row) for row in placed]),
        }
        emitter = self._surface_emitter(made, spread=light.spread)
        flux = made.amount * np.pi * area / units.spread_axis_factor(light.spread)
        self._add_body(shape, emitter, flux, light.visible_to_camera)
        self.places[-1] = Place(
            frame[:3, 3], 0.5 * float(np.hypot(light.size_x, light.size_y)), -frame[:3, 2]
        )

    def _add_body(self, shape: dict, emitter, flux: float, visible: bool) -> None:
        """Add the luminous body of a light; light of others passes it, as in Blender."""
        made = mi.load_dict({**shape, "bsdf": {"type": "null"}, "emitter": emitter})
        self.veils.append(made)
        self._note_emitter(emitter, flux)
        if not visible:
            self.hidden.append(made)
        self.rows.append((made, 0, 0))

    # ---- surroundings ----

    def _add_surroundings(self):
        world, shares = self._world()
        suns = [
            s
            for s in self.scene.lights.values()
            if isinstance(s, SunLight) and s.output.value > 0.0
        ]
        if world is None and not suns:
            return None
        plugin = {"type": "lumenray_surroundings", "suns": len(suns)}
        # Half of the samples go to the world and half to the suns: both matter and neither is known beforehand.
        world_share = 0.0 if world is None else (0.5 if suns else 1.0)
        plugin["world_share"] = world_share
        if world is not None:
            plugin["world"] = world
        amounts = [emission.sun_illuminance(sun) for sun in suns]
        total = sum(made.amount for made in amounts)
        flux = shares
        for i, (sun, made) in enumerate(zip(suns, amounts, strict=True)):
            half = 0.5 * max(sun.angle, SUN_POINT_ANGLE)
            plugin[f"sun_{i}"] = made.scaled(
                units.luminance_from_illuminance_disk(1.0, half)
            ).texture()
            plugin[f"towards_{i}"] = [-float(x) for x in sun.direction]
            plugin[f"cap_{i}"] = float(2.0 * np.sin(0.5 * half) ** 2)
            plugin[f"share_{i}"] = float((1.0 - world_share) * made.amount / total)
            flux += made.amount * np.pi * max(self.radius, 1.0) ** 2
        emitter = mi.load_dict(plugin)
        emitter.set_bounds(mi.Point3f(0.0), mi.Float(self.radius))
        if world is not None:
            emitter.set_portals(self.portals, PORTAL_SHARE)
        self._note_emitter(emitter, flux)
        return emitter

    def _find_portals(self) -> PortalSet | None:
        """Rectangles around the panes, in the compiled scene's frame."""
        panes = []
        for mesh in self.scene.meshes.values():
            for slot, key in enumerate(mesh.materials):
                if isinstance(self.scene.materials[key].surface, ThinGlass):
                    panes.append((mesh.vertices, mesh.triangles[mesh.material_index == slot]))
        found = find_portals(pane for pane in panes if len(pane[1]))
        if not found:
            return None
        return PortalSet([Portal(p.centre - self.origin, p.half_u, p.half_v) for p in found])

    def _world(self):
        """Mitsuba emitter of the world and its flux through the scene. [lm]"""
        world = self.scene.world
        sphere = 4.0 * np.pi**2 * max(self.radius, 1.0) ** 2
        if isinstance(world, UniformWorld) and world.luminance > 0.0:
            made = emission.luminous(world.luminance, world.spectrum)
            return mi.load_dict(
                {"type": "constant", "radiance": made.texture()}
            ), world.luminance * sphere
        if isinstance(world, ImageWorld) and world.luminance_per_unit > 0.0:
            return self._image_world(world, sphere)
        return None, 0.0

    def _image_world(self, world: ImageWorld, sphere: float):
        pixels = np.nan_to_num(np.asarray(world.image.pixels, dtype=np.float32), posinf=0.0)
        pixels = np.maximum(pixels, 0.0)
        luma = (pixels @ REC709_LUMINANCE.astype(np.float32))[..., None]
        if not is_spectral():
            pixels = np.repeat(luma, 3, axis=2)
        # Mitsuba looks up (x, y, z) at u = atan2(x, -z) / (2 pi) with +y up; ours at u = 0.5 - atan2(y, x) / (2 pi) with
        # +z up: they agree when Mitsuba's (x, y, z) is our (y, z, x).
        to_map = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]) @ world.rotation
        to_world = np.eye(4)
        to_world[:3, :3] = to_map.T
        scale = world.luminance_per_unit
        if is_spectral():
            scale /= units.LUMINOUS_EFFICACY * luminous_efficiency().sum()
        plugin = {
            "type": "envmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(pixels[::-1])),
            "scale": float(scale),
            "to_world": mi.ScalarTransform4f([list(row) for row in to_world]),
        }
        rows = np.cos((np.arange(len(luma)) + 0.5) / len(luma) * np.pi - 0.5 * np.pi)
        mean = float((luma[..., 0].mean(axis=1) * rows).sum() / rows.sum())
        return mi.load_dict(plugin), mean * world.luminance_per_unit * sphere


def _check_mesh(mesh: Mesh) -> None:
    """Refuse index errors before they reach native code, where they would end the process."""
    if not np.all(np.isfinite(mesh.vertices)):
        raise SceneError(f"object '{mesh.name}' has a vertex that is not a finite number")
    if len(mesh.triangles) and (
        mesh.triangles.min() < 0 or mesh.triangles.max() >= len(mesh.vertices)
    ):
        raise SceneError(
            f"object '{mesh.name}' has a triangle that names a vertex outside its list"
        )
    if len(mesh.material_index) and mesh.material_index.max() >= len(mesh.materials):
        raise SceneError(
            f"object '{mesh.name}' has a triangle in a material slot that does not exist"
        )


def _uv_map_of(material: Material) -> str:
    """Name of the UV map that a material's pictures use; the converter sees to it that there is one at most."""
    for picture in pictures(material):
        return picture.uv_map
    return ""


def _shape_ids(shapes) -> np.ndarray:
    return np.array(
        [dr.reinterpret_array(mi.UInt32, mi.ShapePtr(s))[0] for s in shapes], dtype=np.int64
    )


def _shape_mask(shapes):
    """Table by shape id: true for the given shapes; None when there are none."""
    if not shapes:
        return None
    ids = _shape_ids(shapes)
    mask = np.zeros(ids.max() + 1, dtype=bool)
    mask[ids] = True
    return mi.Bool(mask)


def _index_tables(rows) -> dict:
    """Tables by shape id of the users' object and material numbers."""
    if not rows:
        return {}
    ids = _shape_ids([row[0] for row in rows])
    tables = {}
    for name, column in (("object", 1), ("material", 2)):
        values = np.zeros(ids.max() + 1, dtype=np.float32)
        values[ids] = [row[column] for row in rows]
        tables[name] = mi.Float(values)
    return tables
