"""New luminaires in a scene: an empty with its body, at the 3D cursor or on the surface under the mouse."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from bpy_extras import view3d_utils
from mathutils import Matrix, Vector

from ...engine.luminaires.formats.record import LuminaireFile
from ..foundation.selection import select_only
from ..foundation.units import metres_per_unit
from .body import body_extent, build_body
from .files import photometric_files

GAP = 0.2
"""Between luminaires that are placed side by side. [m]"""

CLEARANCE = 0.001
"""Between a luminaire and the surface that it is mounted on. [m]"""


@dataclass(frozen=True)
class Mount:
    """Where luminaires are placed.

    Parameters
    ----------
    point : (float, float, float)    In Blender units.
    normal : (float, float, float)    Where they shine to.
    is_surface : bool    Whether the body stands on a surface there; else the photometric centre is there.
    """

    point: tuple[float, float, float]
    normal: tuple[float, float, float] = (0.0, 0.0, -1.0)
    is_surface: bool = False


def cursor_mount(context) -> Mount:
    """Return the 3D cursor's place, shining down."""
    return Mount(tuple(context.scene.cursor.location))


def mount_under(context, x: int, y: int) -> Mount:
    """Return the place under the mouse in a 3D view: the first surface, or else the 3D cursor.

    Parameters
    ----------
    context : bpy.types.Context    Of the 3D view.
    x, y : int    In its region. [pixel]
    """
    view, region = context.region_data, context.region
    if view is None or region is None:
        return cursor_mount(context)
    origin = view3d_utils.region_2d_to_origin_3d(region, view, (x, y))
    direction = view3d_utils.region_2d_to_vector_3d(region, view, (x, y))
    is_hit, point, normal, *_ = context.scene.ray_cast(
        context.evaluated_depsgraph_get(), origin, direction
    )
    if not is_hit:
        return cursor_mount(context)
    if normal.dot(direction) > 0.0:
        normal = -normal
    return Mount(tuple(point), tuple(normal), True)


def add_luminaires(context, paths: Iterable[str], mount: Mount, is_embedded: bool = True) -> list:
    """Add luminaires side by side, and select them.

    Parameters
    ----------
    context : bpy.types.Context
    paths : iterable of str    Of their photometric files.
    mount : Mount    The first one's place.
    is_embedded : bool    Whether the files are embedded or linked.

    Returns
    -------
    list of bpy.types.Object    The empties.

    Raises
    ------
    FileFormatError    A file is refused; nothing is added then.
    """
    paths = [str(path) for path in paths]
    for path in paths:
        photometric_files.obtain_path(bpy.path.abspath(path))
    scale = metres_per_unit(context.scene)
    turn = _shining_to(Vector(mount.normal))
    made, end = [], None
    for path in paths:
        empty = bpy.data.objects.new(Path(path).stem, None)
        file = photometric_files.load(empty.lumenray.luminaire, path, is_embedded).file
        least, largest = body_extent(file)
        offset = 0.0 if end is None else end + GAP - least[0]
        end = offset + largest[0]
        drop = largest[2] + CLEARANCE if mount.is_surface else 0.0
        place = Vector(mount.point) + turn @ Vector((offset, 0.0, -drop)) / scale
        empty.matrix_world = Matrix.Translation(place) @ turn.to_4x4()
        empty.empty_display_type = "ARROWS"
        empty.empty_display_size = 0.75 * float((largest - least).max()) / scale
        context.collection.objects.link(empty)
        add_body(context, empty, file)
        made.append(empty)
    select_only(context.view_layer, made)
    return made


def add_body(context, empty, file: LuminaireFile) -> None:
    """Give an empty a body to look at, in place of the one that it has.

    It is an instance of a collection of its own, not a child: so it is copied, appended, deleted and clicked on with the
    empty.
    """
    remove_body(empty)
    name = f"{empty.name} body"
    mesh = build_body(file, name, metres_per_unit(context.scene))
    body = bpy.data.objects.new(name, mesh)
    body.lumenray.is_luminaire_body = True
    holder = bpy.data.collections.new(name)
    holder.objects.link(body)
    empty.instance_type, empty.instance_collection = "COLLECTION", holder


def has_body(empty) -> bool:
    """Whether an empty shows a luminaire's body."""
    holder = empty.instance_collection if empty.instance_type == "COLLECTION" else None
    return holder is not None and any(o.lumenray.is_luminaire_body for o in holder.objects)


def remove_body(empty) -> None:
    """Take the body off an empty; what nothing else shows is deleted."""
    if not has_body(empty):
        return
    holder = empty.instance_collection
    empty.instance_type, empty.instance_collection = "NONE", None
    if holder.users or holder.library is not None:
        return
    for body in [o for o in holder.objects if o.lumenray.is_luminaire_body and o.users == 1]:
        mesh = body.data
        bpy.data.objects.remove(body)
        if mesh.users == 0:
            bpy.data.meshes.remove(mesh)
    bpy.data.collections.remove(holder)


def _shining_to(normal: Vector) -> Matrix:
    """Axes with -z along a direction and y as far up as it can be; straight down: those of the world."""
    z = -np.array(normal.normalized())
    y = np.array([0.0, 0.0, 1.0]) - z * z[2]
    if np.linalg.norm(y) < 1e-3:
        y = np.array([0.0, 1.0, 0.0]) - z * z[1]
    y /= np.linalg.norm(y)
    return Matrix(np.stack([np.cross(y, z), y, z], axis=1).tolist())
