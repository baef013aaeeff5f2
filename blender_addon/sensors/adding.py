"""New sensors in a scene: empties at the 3D cursor, on a face, over a floor, and those of a whole room."""

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector

from ...engine.errors import SceneError
from ..foundation.pose import pose_of
from ..foundation.selection import select_only
from ..foundation.units import metres_per_unit
from ..luminaires.settings import is_luminaire
from .settings import is_sensor

TITLES = {
    "POINT": "Sensor",
    "LINE": "Sensor Line",
    "GRID": "Sensor Grid",
    "FACE": "Sensors on Face",
    "FLOOR": "Sensors over Floor",
    "BAND": "Sensor Band",
    "CAMERA": "Camera Luminances",
    "SPHERE": "Goniometer",
}
"""Names of new empties by their layout."""

SHOWN = 0.15
"""Size of new empties as they are drawn. [m]"""

LEVEL, UPRIGHT = 0.95, 0.3
"""Least upward part of normals of floors and ceilings, and the largest of those of walls. [-]"""

SMALLEST_FACE = 0.05
"""Faces of a room with less area get no sensors of their own. [m2]"""

SURROUNDINGS, BACKGROUND = 0.5, 3.0
"""Widths of the immediate surroundings of a task area and of the background around them (EN 12464-1). [m]"""


def add_sensors(context, layout: str, quantity: str = "PLANAR", height: float = 0.75):
    """Add an empty with sensors, select it and return it.

    Parameters
    ----------
    context : bpy.types.Context
    layout, quantity : str    As of `settings`.
    height : float    Of sensors over a floor. [m]

    Raises
    ------
    SceneError    The layout needs a mesh or a face, and none is active.
    """
    matrix, surface = Matrix.Translation(context.scene.cursor.location), None
    if layout in {"FACE", "FLOOR"}:
        surface = _active_mesh(context, layout)
    if layout == "FACE":
        matrix = _face_matrix(surface)
    elif layout == "FLOOR":
        matrix = Matrix.Translation(surface.matrix_world.translation)
    empty = _new(context, TITLES[layout], matrix, layout, quantity)
    empty.lumenray.sensor.surface, empty.lumenray.sensor.height = surface, height
    if layout == "CAMERA":
        # Nothing else is told of them.
        empty.lumenray.sensor.quantity = "LUMINANCE"
    if layout == "SPHERE":
        _stand_at_luminaire(context, empty)
    if layout == "FACE":
        _follow(empty, surface, matrix)
    _select(context, [empty])
    return empty


def _stand_at_luminaire(context, empty) -> None:
    """Let a goniometer stand at the active light or luminaire with its axes, if there is one."""
    settings, active = empty.lumenray.sensor, context.view_layer.objects.active
    settings.quantity = "INTENSITY"
    if active is not None and (active.type == "LIGHT" or is_luminaire(active)):
        empty.matrix_world = Matrix(pose_of(active.matrix_world, 1.0).frame.tolist())


def add_room(context) -> list:
    """Add the sensors of a room of the selected meshes: over its floors, on its walls and ceilings, and about a task area.

    The task area is the active empty if that is a rectangle of sensors; it gets its surroundings and its background.

    Raises
    ------
    SceneError    No mesh is selected, or they have neither floors nor walls.
    """
    meshes = [thing for thing in context.selected_objects if thing.type == "MESH"]
    if not meshes:
        raise SceneError("no mesh is selected; select what the room is made of")
    task = context.view_layer.objects.active
    made, floor, largest = [], None, 0.0
    for mesh in meshes:
        planes = _planes(mesh, metres_per_unit(context.scene))
        for matrix, normal, area in planes:
            if area <= SMALLEST_FACE:
                continue
            if normal.z >= LEVEL:
                if area > largest:
                    floor, largest = mesh, area
                continue
            name = "Ceiling" if normal.z <= -LEVEL else "Wall"
            if name == "Ceiling" or abs(normal.z) <= UPRIGHT:
                empty = _new(context, name, matrix, "FACE", "PLANAR")
                empty.lumenray.sensor.surface = mesh
                _follow(empty, mesh, matrix)
                empty.lumenray.sensor.area = "CEILING" if name == "Ceiling" else "WALLS"
                made.append(empty)
    if floor is not None:
        matrix = Matrix.Translation(floor.matrix_world.translation)
        empty = _new(context, "Floor", matrix, "FLOOR", "PLANAR")
        empty.lumenray.sensor.surface, empty.lumenray.sensor.height = floor, 0.0
        # Requirements are of places above it.
        empty.lumenray.sensor.area = "NONE"
        made.append(empty)
    if is_sensor(task) and task.lumenray.sensor.layout == "GRID":
        made += _add_bands(context, task, floor)
    if not made:
        raise SceneError("the selected meshes have neither a floor nor walls nor a ceiling")
    _select(context, made)
    return made


def _add_bands(context, task, floor) -> list:
    """Add surroundings and background of a task area."""
    made, own = [], task.lumenray.sensor
    length, width = own.length, own.width
    for name, band in (("Surroundings", SURROUNDINGS), ("Background", BACKGROUND)):
        empty = _new(context, name, task.matrix_world.copy(), "BAND", own.quantity)
        settings = empty.lumenray.sensor
        settings.length, settings.width, settings.band = length, width, band
        settings.surface, settings.area = floor, name.upper()
        length, width = length + 2.0 * band, width + 2.0 * band
        made.append(empty)
    return made


def _new(context, name: str, matrix, layout: str, quantity: str):
    empty = bpy.data.objects.new(name, None)
    empty.empty_display_type = "ARROWS"
    empty.empty_display_size = SHOWN / metres_per_unit(context.scene)
    empty.matrix_world = matrix
    settings = empty.lumenray.sensor
    settings.is_sensor, settings.layout, settings.quantity = True, layout, quantity
    context.collection.objects.link(empty)
    return empty


def _follow(empty, mesh, matrix) -> None:
    """Let an empty go with a mesh, from where it is."""
    empty.parent, empty.matrix_parent_inverse = mesh, mesh.matrix_world.inverted()
    empty.matrix_basis = matrix


def _select(context, empties) -> None:
    if context.mode == "OBJECT":
        select_only(context.view_layer, empties)
    context.view_layer.update()


def _active_mesh(context, layout: str):
    thing = context.view_layer.objects.active
    if thing is None or thing.type != "MESH":
        what = "floor" if layout == "FLOOR" else "mesh with the face"
        raise SceneError(f"no mesh is active; select the {what} that the sensors belong to")
    return thing


def _face_matrix(mesh):
    """Matrix of sensors on the active face of a mesh: z along its normal, x level or along the longest edge."""
    if mesh.mode == "EDIT":
        shape = bmesh.from_edit_mesh(mesh.data)
        face = shape.faces.active
        if face is None:
            raise SceneError(f"no face of '{mesh.name}' is active; select one")
        corners = [vertex.co.copy() for vertex in face.verts]
    else:
        active = mesh.data.polygons.active
        if not 0 <= active < len(mesh.data.polygons):
            raise SceneError(f"'{mesh.name}' has no active face; select one in edit mode")
        corners = [mesh.data.vertices[k].co for k in mesh.data.polygons[active].vertices]
    corners = [mesh.matrix_world @ corner for corner in corners]
    normal = _normal(corners)
    if normal is None:
        raise SceneError(f"the active face of '{mesh.name}' has no area")
    if mesh.matrix_world.determinant() < 0.0:
        normal = -normal
    return _plane_matrix(sum(corners, Vector()) / len(corners), normal, corners)


def _normal(corners):
    """Unit normal of a polygon by Newell's sum, None where it has no area."""
    total = Vector()
    for here, there in zip(corners, [*corners[1:], corners[0]], strict=True):
        total += (here - corners[0]).cross(there - corners[0])
    return total.normalized() if total.length > 1e-12 else None


def _plane_matrix(middle, normal, corners):
    """Matrix at a place whose z is a normal and whose x is level, or along the longest edge where all of it is."""
    x = Vector((0.0, 0.0, 1.0)).cross(normal)
    if abs(normal.z) >= LEVEL:
        edges = [b - a for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]
        x = max(edges, key=lambda edge: edge.length)
        x -= normal * x.dot(normal)
    x = x.normalized()
    y = normal.cross(x)
    matrix = Matrix.Identity(4)
    for column, axis in enumerate((x, y, normal, middle)):
        for row in range(3):
            matrix[row][column] = axis[row]
    return matrix


def _planes(mesh, metres: float) -> list:
    """Planes of a mesh's faces: matrix of sensors in each, its normal, and the area of its faces. [m2]"""
    found: dict[tuple, list] = {}
    turn = mesh.matrix_world
    is_mirrored = turn.determinant() < 0.0
    for polygon in mesh.data.polygons:
        corners = [turn @ mesh.data.vertices[k].co for k in polygon.vertices]
        normal = _normal(corners)
        if normal is None:
            continue
        normal = -normal if is_mirrored else normal
        area = 0.5 * abs(
            sum(
                ((a - corners[0]).cross(b - corners[0]).dot(normal))
                for a, b in zip(corners[1:], corners[2:], strict=False)
            )
        )
        place = normal.dot(corners[0])
        key = (*(round(c, 2) for c in normal), round(place * metres, 2))
        found.setdefault(key, []).append((corners, normal, area))
    made = []
    for faces in found.values():
        total = sum(area for *_, area in faces)
        corners, normal, _ = max(faces, key=lambda face: face[2])
        middle = Vector(np.mean([np.array(corner) for corner in corners], axis=0))
        made.append((_plane_matrix(middle, normal, corners), normal, metres**2 * total))
    return made
