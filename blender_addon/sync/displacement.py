"""Displacement of meshes by their materials: vertices are moved as Cycles moves them, before light is computed."""

from dataclasses import dataclass, replace

import bpy
import numpy as np

from ...engine.scene.mesh import Geometry
from ..foundation.node_trees import uses_nodes
from ..foundation.report import ConversionReport
from .images.cache import ImageCache
from .nodes.evaluation import Inputs, evaluate_field
from .nodes.fields import rgb
from .nodes.graph import find_socket, trace
from .nodes.vertices import VertexContext, Vertices, unit

ALIKE = 1e-3
"""How much corner normals of one vertex may differ and still be one. [-]"""

_LEFT_OUT = "the mesh is not displaced by it"

_ALONG = {"ShaderNodeDisplacement", "ShaderNodeVectorDisplacement"}
"""Nodes whose vectors may be those of the object."""


def displaces(material) -> bool:
    """Tell whether a material moves the vertices of meshes."""
    if material is None or getattr(material, "displacement_method", "BUMP") == "BUMP":
        return False
    settings = getattr(material, "lumenray", None)
    if (settings is not None and settings.use_override) or not uses_nodes(material):
        return False
    output = material.node_tree.get_output_node("CYCLES")
    return output is not None and trace(output.inputs["Displacement"]).is_output


def follows_object(material) -> bool:
    """Tell whether what a material does to a mesh is the same wherever the object stands."""
    if not displaces(material):
        return True
    nodes = _nodes_of(material.node_tree)
    return not any(
        node.bl_idname == "ShaderNodeNewGeometry" or getattr(node, "space", "OBJECT") == "WORLD"
        for node in nodes
    ) and any(node.bl_idname in _ALONG for node in nodes)


def _nodes_of(tree, seen=None):
    seen = set() if seen is None else seen
    if tree is None or tree in seen:
        return []
    seen.add(tree)
    return [
        each
        for node in tree.nodes
        for each in (node, *_nodes_of(getattr(node, "node_tree", None), seen))
    ]


@dataclass(frozen=True, eq=False)
class Displacement:
    """What moves the vertices of one object.

    Parameters
    ----------
    materials : tuple of bpy.types.Material or None    By slot, the ones that displace; None: others.
    frame : (4, 4) array    From the object's frame to the world. [BU]
    images : ImageCache    What was read of images before.
    """

    materials: tuple[bpy.types.Material | None, ...]
    frame: np.ndarray
    images: ImageCache

    def apply(self, geometry: Geometry, mesh, report: ConversionReport) -> Geometry:
        """Return a geometry as it is after the displacement.

        Parameters
        ----------
        geometry : Geometry
        mesh : bpy.types.Mesh    That it was made of.
        report : ConversionReport    Gets a row for what is not taken over.
        """
        slots = np.minimum(geometry.material_index, len(self.materials) - 1)
        box = np.array([mesh.texspace_location, mesh.texspace_size], dtype=np.float64)
        offsets = np.zeros(geometry.vertices.shape)
        is_new = np.zeros(len(geometry.triangles), dtype=bool)
        is_done = np.zeros(len(offsets), dtype=bool)
        for slot, material in enumerate(self.materials):
            chosen = np.flatnonzero(slots == slot)
            if material is None or len(chosen) == 0:
                continue
            is_new[chosen] = material.displacement_method == "DISPLACEMENT"
            corners = _first_corners(geometry.triangles[chosen].ravel())
            corners = corners[~is_done[geometry.triangles[chosen].ravel()[corners]]]
            number, vertices = _vertices_of(geometry, chosen, corners, box, self.frame)
            offsets[number] = self._offsets(material, vertices, report)
            is_done[number] = True
        if not np.any(offsets):
            return geometry
        moved = (geometry.vertices + offsets).astype(np.float32)
        made = replace(geometry, vertices=moved)
        if geometry.corner_normals is None or not is_new.any():
            return made
        return replace(made, corner_normals=_turned_normals(geometry, moved, is_new))

    def _offsets(self, material, vertices: Vertices, report) -> np.ndarray:
        """How far vertices move, in the object's frame. (n, 3) or (1, 3) [BU]"""
        context = VertexContext(material.name, report, self.images, vertices)
        socket = material.node_tree.get_output_node("CYCLES").inputs["Displacement"]
        origin = trace(socket)
        at = Inputs(origin.socket.node, origin.socket, context, origin.groups)
        to_object = np.linalg.pinv(self.frame[:3, :3])
        space = getattr(at.node, "space", "WORLD")
        match at.node.bl_idname:
            case "ShaderNodeDisplacement":
                found = self._heights(at)
            case "ShaderNodeVectorDisplacement" if space == "TANGENT":
                at.fail("Displacement by a vector in tangent space is not supported", _LEFT_OUT)
                return np.zeros((1, 3))
            case "ShaderNodeVectorDisplacement":
                inputs = map(at, ("Vector", "Midlevel", "Scale"))
                found = at.map(lambda vector, middle, size: (rgb(vector) - middle) * size, *inputs)
            case _:
                found, space = evaluate_field(socket, context), "WORLD"
        if found.is_spread or found.is_stand_in:
            at.fail("A displacement depends on what is not known at vertices", _LEFT_OUT)
            return np.zeros((1, 3))
        values = found.values.reshape(-1, found.values.shape[-1]).astype(np.float64)
        if at.node.bl_idname != "ShaderNodeDisplacement":
            vectors = np.broadcast_to(values, (len(values), 3))
            return vectors if space == "OBJECT" else vectors @ to_object.T
        if space == "OBJECT":
            return values * vertices.normals
        # Along the normal in the world, whose way in the object's frame is another where that is stretched.
        return values * (unit(vertices.normals @ to_object) @ to_object.T)

    def _heights(self, at):
        """How far along the normal a Displacement node moves vertices."""
        normal = trace(find_socket(at.node.inputs, "Normal"), at.groups)
        if normal.is_output and normal.socket.node.bl_idname != "ShaderNodeNewGeometry":
            at.note("Displacement along another normal is not supported", "the mesh's is used")
        inputs = map(at, ("Height", "Midlevel", "Scale"))
        return at.map(lambda height, middle, size: (height - middle) * size, *inputs)


def _first_corners(vertex: np.ndarray) -> np.ndarray:
    """Which corner names each vertex first."""
    return np.unique(vertex, return_index=True)[1]


def _vertices_of(geometry, chosen, corners, box, frame) -> tuple[np.ndarray, Vertices]:
    """Numbers of the vertices at corners of chosen triangles, and what is known there."""
    number = geometry.triangles[chosen].ravel()[corners]
    if geometry.corner_normals is None:
        normals = _face_normals(geometry.vertices, geometry.triangles[chosen])[corners // 3]
    else:
        normals = geometry.corner_normals[chosen].reshape(-1, 3)[corners]
    uv_maps = {
        name: uv[chosen].reshape(-1, 2)[corners].astype(np.float64)
        for name, uv in geometry.uv_maps.items()
    }
    places = geometry.vertices[number].astype(np.float64)
    return number, Vertices(places, normals.astype(np.float64), uv_maps, box, frame)


def _face_normals(vertices, triangles) -> np.ndarray:
    a, b, c = (vertices[triangles[:, k]].astype(np.float64) for k in range(3))
    return unit(np.cross(b - a, c - a))


def _turned_normals(geometry: Geometry, moved, is_new) -> np.ndarray:
    """Corner normals where triangles were displaced: the mean of the faces about a vertex that shared a normal before."""
    made = np.array(geometry.corner_normals, dtype=np.float32)
    triangles = geometry.triangles[is_new]
    before = np.round(made[is_new].reshape(-1, 3) / ALIKE).astype(np.int64)
    key = np.column_stack([triangles.ravel(), before])
    _, group = np.unique(key, axis=0, return_inverse=True)
    faces = np.repeat(_face_normals(moved, triangles), 3, axis=0)
    sums = np.stack([np.bincount(group.ravel(), faces[:, k]) for k in range(3)], axis=1)
    made[is_new] = unit(sums)[group.ravel()].reshape(-1, 3, 3)
    return made
