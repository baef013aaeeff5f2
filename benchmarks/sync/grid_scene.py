"""A Blender scene of so many triangles in so many objects: bumpy patches in a grid, lamps above, a camera."""

import colorsys
import math

import bpy
import numpy as np

SPACING = 1.2
"""Distance of neighbouring patches, which are 1 m wide. [m]"""

MATERIALS = 20
"""Materials that the patches share; the first half are node trees, the others physical overrides."""

LAMPS = ("AREA", "POINT", "SPOT")

VIEW = (1280, 720)
"""Size of the live view. [pixel]"""


def build_scene(triangles: int, objects: int) -> None:
    """Replace the open file by a scene. ``triangles`` is rounded to twice the objects' number."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.preferences.edit.use_global_undo = True
    scene = bpy.context.scene
    materials = [_add_material(number) for number in range(MATERIALS)]
    patches = _Patches(max(triangles // objects // 2, 1))
    for number in range(objects):
        made = bpy.data.objects.new(f"Patch {number:04}", patches.make(number))
        made.data.materials.append(materials[number % MATERIALS])
        made.location = patch_location(number, objects)
        scene.collection.objects.link(made)
    side = SPACING * math.isqrt(objects)
    for kind in LAMPS:
        scene.collection.objects.link(_make_lamp(kind, side))
    scene.world = _make_world()
    scene.camera = _add_camera(side)
    scene.render.resolution_x, scene.render.resolution_y = VIEW
    bpy.context.view_layer.update()


def patch_location(number: int, objects: int) -> tuple[float, float, float]:
    """Place of a patch in the grid. [m]"""
    columns = math.ceil(math.sqrt(objects))
    middle = 0.5 * (columns - 1)
    row, column = divmod(number, columns)
    return SPACING * (column - middle), SPACING * (row - middle), 0.0


def count_triangles() -> int:
    """Count the triangles of the open file's scene."""
    return sum(
        2 * len(made.data.polygons) for made in bpy.context.scene.objects if made.type == "MESH"
    )


class _Patches:
    """Makes patches of ``quads`` quadrilaterals; every other one is smooth and has texture coordinates."""

    def __init__(self, quads: int):
        self.rows = next(n for n in range(math.isqrt(quads), 0, -1) if quads % n == 0)
        self.columns = quads // self.rows
        x, y = np.meshgrid(
            np.linspace(-0.5, 0.5, self.columns + 1), np.linspace(-0.5, 0.5, self.rows + 1)
        )
        self.x, self.y = x.ravel(), y.ravel()
        self._templates = [self._make_template(is_smooth) for is_smooth in (False, True)]

    def make(self, number: int):
        """Return a new mesh with a shape of its own."""
        mesh = self._templates[number % 2].copy()
        mesh.name = f"Patch {number:04}"
        write_heights(mesh, self.x, self.y, 0.001 * number)
        return mesh

    def _make_template(self, is_smooth: bool):
        mesh = bpy.data.meshes.new("Template")
        corners = self._corners()
        mesh.vertices.add(len(self.x))
        mesh.loops.add(corners.size)
        mesh.polygons.add(len(corners))
        mesh.loops.foreach_set("vertex_index", corners.ravel())
        mesh.polygons.foreach_set("loop_start", np.arange(0, corners.size, 4, dtype=np.int32))
        mesh.polygons.foreach_set("use_smooth", np.full(len(corners), is_smooth))
        if is_smooth:
            layer = mesh.uv_layers.new(name="UVMap")
            places = np.stack([self.x + 0.5, self.y + 0.5], axis=1).astype(np.float32)
            layer.data.foreach_set("uv", places[corners.ravel()].ravel())
        return mesh

    def _corners(self) -> np.ndarray:
        """Vertices of every quadrilateral, (n, 4) int32."""
        row, column = np.divmod(np.arange(self.rows * self.columns), self.columns)
        first = row * (self.columns + 1) + column
        above = first + self.columns + 1
        return np.stack([first, first + 1, above + 1, above], axis=1).astype(np.int32)


def write_heights(mesh, x, y, phase: float) -> None:
    """Give a patch bumps. ``x``, ``y``: (n,) of its vertices. [m]"""
    z = 0.08 * np.sin(9.0 * x + 40.0 * phase) * np.cos(7.0 * y - 25.0 * phase)
    positions = np.stack([x, y, z], axis=1).astype(np.float32)
    mesh.vertices.foreach_set("co", positions.ravel())
    mesh.update()


def reshape(mesh, phase: float) -> None:
    """Move all vertices of a patch, as sculpting would."""
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    x, y, _ = positions.reshape(-1, 3).T
    write_heights(mesh, x, y, phase)


def _add_material(number: int):
    material = bpy.data.materials.new(f"Paint {number:02}")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    colour = colorsys.hsv_to_rgb(number / MATERIALS, 0.6, 0.7)
    if number < MATERIALS // 2:
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = (*colour, 1.0)
        shader.inputs["Roughness"].default_value = 0.3 + 0.05 * number
    else:
        settings = material.lumenray
        settings.use_override = True
        settings.model = ("DIFFUSE", "COATED")[number % 2]
        settings.reflectance_source = "COLOR"
        settings.reflectance_color = colour
    return material


def _make_lamp(kind: str, side: float):
    data = bpy.data.lights.new(kind.title(), kind)
    data.energy = 20.0 * side
    place = LAMPS.index(kind) - 1
    data.color = ((1.0, 0.8, 0.6), (1.0, 1.0, 1.0), (0.7, 0.8, 1.0))[place + 1]
    if kind == "AREA":
        data.size = 1.0
    made = bpy.data.objects.new(data.name, data)
    made.location = (0.3 * side * place, 0.1 * side * place, 0.4 * side + 1.0)
    return made


def _make_world():
    world = bpy.data.worlds.new("Sky")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.6, 0.7, 0.9, 1.0)
    background.inputs["Strength"].default_value = 0.5
    return world


def _add_camera(side: float):
    made = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    made.data.clip_end = 10.0 * side
    made.location = (0.0, -0.8 * side, 0.8 * side)
    made.rotation_euler = (math.radians(45.0), 0.0, 0.0)
    bpy.context.scene.collection.objects.link(made)
    return made
