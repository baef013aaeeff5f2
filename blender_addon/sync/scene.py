"""One walk over an evaluated Blender scene: everything in it as a delta for the engine."""

from dataclasses import dataclass

from ...engine.scene.camera import Camera
from ...engine.scene.scene import SceneDelta
from ..report import ConversionReport
from .camera import convert_camera
from .lights import convert_light
from .materials import convert_material, default_material
from .meshes import MESH_TYPES, read_mesh
from .world import convert_world

DEFAULT_MATERIAL = "material:"
"""Id of what surfaces without a material are made of."""


@dataclass(frozen=True)
class ConvertedScene:
    """A Blender scene for the engine: ``delta`` fills an empty engine scene."""

    delta: SceneDelta
    camera: Camera | None
    report: ConversionReport


def metres_per_unit(scene) -> float:
    """Length of a Blender unit. [m]"""
    settings = scene.unit_settings
    return settings.scale_length if settings.system != "NONE" else 1.0


def convert_scene(depsgraph, report: ConversionReport | None = None) -> ConvertedScene:
    """Convert everything that the dependency graph shows.

    Objects that are hidden in renders are left out, whichever kind of graph it is.
    """
    report = ConversionReport() if report is None else report
    scene = depsgraph.scene
    scale = metres_per_unit(scene)
    efficacy = scene.lumenray.efficacy
    walk = _Walk(report, scale, efficacy)
    for instance in depsgraph.object_instances:
        walk.visit(instance)
    items = [*walk.items, *walk.materials.values()]
    world = convert_world(scene.world, efficacy, report)
    if world is not None:
        items.append(world)
    if not walk.has_light and world is None:
        report.warn(scene.name, "the scene has no light", "everything is black")
    camera = None
    if scene.camera is not None:
        camera = convert_camera(scene.camera.evaluated_get(depsgraph), scene, scale, report)
    return ConvertedScene(SceneDelta(changed=tuple(items)), camera, report)


class _Walk:
    """Collects items while the instances pass by."""

    def __init__(self, report, scale, efficacy):
        self.report, self.scale, self.efficacy = report, scale, efficacy
        self.items: list = []
        self.materials: dict = {}
        self.has_light = False

    def visit(self, instance) -> None:
        """Convert one instance."""
        source = instance.object
        if not instance.show_self or source.hide_render:
            return
        name = source.name_full
        key = name
        if instance.is_instance:
            parent = instance.parent
            if parent is not None and parent.hide_render:
                return
            number = ".".join(str(i) for i in instance.persistent_id if i != 0x7FFFFFFF)
            owner = parent.name_full if parent is not None else ""
            name = f"{name} ({owner} {number})"
            key = f"{owner}/{number}/{source.name_full}"
        if source.type == "LIGHT":
            self._add_light(instance, f"light:{key}", name)
        elif source.type in MESH_TYPES:
            self._add_mesh(instance, f"mesh:{key}", name)
        elif source.type in {"CURVES", "POINTCLOUD", "VOLUME", "GREASEPENCIL", "GPENCIL"}:
            self.report.warn(name, f"objects of type {source.type} are not converted", "left out")

    def _add_light(self, instance, key, name) -> None:
        light = convert_light(
            instance.object,
            key,
            name,
            instance.matrix_world,
            self.scale,
            self.efficacy,
            self.report,
        )
        if light is not None:
            self.items.append(light)
            self.has_light = True

    def _add_mesh(self, instance, key, name) -> None:
        slots = [self._material(slot.material) for slot in instance.object.material_slots]
        mesh = read_mesh(instance, key, name, tuple(slots) or (self._material(None),), self.scale)
        if mesh is not None:
            self.items.append(mesh)

    def _material(self, material) -> str:
        """Convert a material at its first use and return its id."""
        if material is None:
            self.materials.setdefault(DEFAULT_MATERIAL, default_material(DEFAULT_MATERIAL))
            return DEFAULT_MATERIAL
        original = material.original
        key = f"material:{original.name_full}"
        if key not in self.materials:
            made = convert_material(original, key, self.report, self.efficacy)
            self.materials[key] = made
            self.has_light |= made.emission is not None and made.emission.luminance > 0.0
        return key
