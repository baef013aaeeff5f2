"""Parts of several materials put together to one Blender object."""

import math

import bpy
import numpy as np

from . import shapes

SHARP_ANGLE = math.radians(36.0)
"""Edges that bend more than this stay sharp under smooth shading. [rad]"""


def plane_uvs(part):
    """Return texture coordinates in metres, projected along the main axis of each face."""
    uvs = []
    for face in part.faces:
        corners = part.points[list(face)]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        axes = [(1, 2), (0, 2), (0, 1)][int(np.argmax(np.abs(normal)))]
        uvs.append(corners[:, axes])
    return np.concatenate(uvs)


class Assembly:
    """Collects parts with their materials; :meth:`build` makes one mesh object of them."""

    def __init__(self):
        self.entries = []

    def add(self, material, *parts):
        """Add parts of one material (a Blender material) and return the assembly."""
        self.entries += [(material, part) for part in parts]
        return self

    def build(self, name, collection, location=(0.0, 0.0, 0.0), turn=0.0):
        """Make the object.

        Parameters
        ----------
        name : str
        collection : bpy.types.Collection
        location : (3,) sequence    [m]
        turn : float    Rotation about z. [degrees]

        Returns
        -------
        bpy.types.Object
        """
        materials = list(dict.fromkeys(material for material, _ in self.entries))
        whole = shapes.merged([part for _, part in self.entries])
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(whole.points.tolist(), [], whole.faces)
        for material in materials:
            mesh.materials.append(material)
        slots = [materials.index(m) for m, part in self.entries for _ in part.faces]
        mesh.polygons.foreach_set("material_index", slots)
        uvs = [plane_uvs(p) if p.uvs is None else p.uvs for _, p in self.entries]
        layer = mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", np.concatenate(uvs).astype(np.float32).ravel())
        mesh.shade_smooth()
        mesh.set_sharp_from_angle(angle=SHARP_ANGLE)
        mesh.update()
        item = bpy.data.objects.new(name, mesh)
        item.location = location
        item.rotation_euler = (0.0, 0.0, math.radians(turn))
        collection.objects.link(item)
        return item
