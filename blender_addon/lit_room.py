"""A lit room to begin with: surfaces of stated reflectance, luminaires at the ceiling, a work plane and a camera."""

import itertools
from contextlib import suppress
from dataclasses import dataclass

import bpy
from mathutils import Vector

from ..libraries import luminaires
from .foundation.selection import select_only
from .foundation.units import metres_per_unit
from .luminaires import placing
from .rendering.render_engine import LumenrayRenderEngine
from .sync.meshes import MESH_TYPES
from .sync.visibility import LIGHT_RAYS

REFLECTANCES = {"Floor": 0.2, "Walls": 0.5, "Ceiling": 0.7}
"""Of the surfaces: the lower ends of what EN 12464-1:2011 recommends (0.2 to 0.4, 0.5 to 0.8 and 0.7 to 0.9)."""

LUMINAIRE = "panel_600_opal"
"""Model of the library that lights the room."""

WORK_PLANE = 0.75
"""Height of the work plane: that of a desk. [m]"""

BORDER = 0.5
"""Band along the walls that the work plane leaves out, as EN 12464-1:2011 does. [m]"""

EYE = 1.6
"""Height of the camera: that of somebody who stands. [m]"""

CORNER = 0.3
"""Distance of the camera from the walls. [m]"""

LENS = 16.0
"""Focal length of the camera, which sees most of the room from its corner. [mm]"""

GAP = 1.0
"""Between the room and what stands beside it. [m]"""


@dataclass(frozen=True)
class Plan:
    """Sizes of a room in metres, along x, y and z, and how many luminaires it has along x and along y."""

    width: float
    depth: float
    height: float
    columns: int
    rows: int


def add_lit_room(context, plan: Plan) -> list:
    """Add a room to the scene, on the 3D cursor or beside what stands there, and get the scene ready for it.

    The surfaces and the work plane are selected, so that they can be baked at once.

    Parameters
    ----------
    context : bpy.types.Context    In object mode.
    plan : Plan

    Returns
    -------
    list of bpy.types.Object    Floor, walls, ceiling and work plane.
    """
    scene = context.scene
    _prepare(scene)
    unit = 1.0 / metres_per_unit(scene)
    half = Vector((plan.width, plan.depth, 0.0)) * (0.5 * unit)
    top = Vector((0.0, 0.0, plan.height * unit))
    place = _free_place(context, half, top, GAP * unit)
    collection = bpy.data.collections.new("Lit Room")
    scene.collection.children.link(collection)
    # What is added next belongs to the room, too.
    layer = context.view_layer.layer_collection.children[collection.name]
    context.view_layer.active_layer_collection = layer
    made = [
        _add_mesh(collection, name, place, *shape, _material(name))
        for name, shape in _shapes(half, top).items()
    ]
    made.append(_add_work_plane(collection, place, plan, unit))
    _add_luminaires(context, collection, place + top, half, plan)
    scene.camera = _add_camera(collection, place, half, unit)
    select_only(context.view_layer, made)
    return made


def _prepare(scene) -> None:
    """Let our engine render the scene, metres be its unit, and colours be what the scale of false colours shows."""
    units = scene.unit_settings
    if units.system == "NONE":
        # The scale does not count without units.
        units.scale_length = 1.0
    units.system = "METRIC"
    scene.render.engine = LumenrayRenderEngine.bl_idname
    # A colour configuration of one's own may lack it; the panel of baked light says what that means.
    with suppress(TypeError):
        scene.view_settings.view_transform = "Standard"


def _free_place(context, half: Vector, top: Vector, gap: float) -> Vector:
    """Where the middle of the floor stands: on the 3D cursor, moved along x until nothing else is inside the walls."""
    place = context.scene.cursor.location.copy()
    extents = sorted(
        (_extent(thing) for thing in context.visible_objects if thing.type in MESH_TYPES),
        key=lambda extent: extent[0].x,
    )
    for low, high in extents:
        least, largest = place - half, place + half + top
        if all(low[k] < largest[k] and high[k] > least[k] for k in range(3)):
            place.x = high.x + gap + half.x
    return place


def _extent(thing) -> tuple[Vector, Vector]:
    """Return the least and the largest corner of an object in world space."""
    corners = [thing.matrix_world @ Vector(corner) for corner in thing.bound_box]
    return tuple(Vector(map(pick, zip(*corners, strict=True))) for pick in (min, max))


def _shapes(half: Vector, top: Vector) -> dict[str, tuple[list, list]]:
    """Return corners and faces of the surfaces, which face the room."""
    x, y = half.x, half.y
    below = [Vector(corner) for corner in ((-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0))]
    above = [corner + top for corner in below]
    sides = [((k + 1) % 4, k, k + 4, (k + 1) % 4 + 4) for k in range(4)]
    return {
        "Floor": (below, [(0, 1, 2, 3)]),
        "Walls": (below + above, sides),
        "Ceiling": (above, [(3, 2, 1, 0)]),
    }


def _material(name: str):
    """Return a matt material of stated reflectance, which looks alike in Blender's own engines."""
    reflectance = REFLECTANCES[name]
    material = bpy.data.materials.new(f"{name} {100.0 * reflectance:.0f} %")
    if material.node_tree is None:
        # Before Blender 5.0, where materials have nodes at all times.
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    shader.location.x = -200.0
    colour = (reflectance, reflectance, reflectance, 1.0)
    shader.inputs["Color"].default_value = material.diffuse_color = colour
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    settings = material.lumenray
    settings.use_override, settings.model = True, "DIFFUSE"
    settings.reflectance_source, settings.reflectance = "VALUE", reflectance
    return material


def _add_mesh(collection, name: str, place: Vector, corners, faces, material=None):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], faces)
    if material is not None:
        mesh.materials.append(material)
    thing = bpy.data.objects.new(name, mesh)
    thing.location = place
    collection.objects.link(thing)
    return thing


def _add_work_plane(collection, place: Vector, plan: Plan, unit: float):
    """Add a plane that is baked and neither lights, shades nor is seen."""
    # A small room has a narrower band, so that something is left.
    border = min(BORDER, 0.25 * min(plan.width, plan.depth))
    x, y = (unit * (0.5 * size - border) for size in (plan.width, plan.depth))
    corners = [(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)]
    height = Vector((0.0, 0.0, unit * min(WORK_PLANE, 0.5 * plan.height)))
    plane = _add_mesh(collection, "Work Plane", place + height, corners, [(0, 1, 2, 3)])
    plane.display_type = "WIRE"
    for name in (*LIGHT_RAYS, "visible_camera"):
        setattr(plane, name, False)
    return plane


def _add_luminaires(context, collection, middle: Vector, half: Vector, plan: Plan) -> None:
    """Mount luminaires on the ceiling, each in the middle of its part of the room."""
    mount = placing.Mount(tuple(middle), is_surface=True)
    (first,) = placing.add_luminaires(context, [luminaires.find_model(LUMINAIRE).file], mount)
    start = first.location.copy()
    for number, (row, column) in enumerate(
        itertools.product(range(plan.rows), range(plan.columns))
    ):
        made = first
        if number:
            made = first.copy()
            collection.objects.link(made)
        x = half.x * ((2 * column + 1) / plan.columns - 1.0)
        y = half.y * ((2 * row + 1) / plan.rows - 1.0)
        made.location = start + Vector((x, y, 0.0))


def _add_camera(collection, place: Vector, half: Vector, unit: float):
    """Add a camera that looks from a corner across the room."""
    data = bpy.data.cameras.new("Room Camera")
    data.lens, data.clip_start, data.clip_end = LENS, 0.01 * unit, 1000.0 * unit
    camera = bpy.data.objects.new("Room Camera", data)
    # A corner of a narrow room has to be nearer.
    inset = min(CORNER * unit, 0.25 * half.x, 0.25 * half.y)
    corner = Vector((inset - half.x, inset - half.y, 0.0))
    camera.location = place + corner + Vector((0.0, 0.0, EYE * unit))
    towards = Vector((-corner.x, -corner.y, -0.3 * unit))
    camera.rotation_euler = towards.to_track_quat("-Z", "Y").to_euler()
    collection.objects.link(camera)
    return camera
