"""Texture coordinates: which UV map a vector socket carries, and how it is moved."""

from dataclasses import dataclass

import mathutils
import numpy as np

from .graph import trace


@dataclass(frozen=True, eq=False)
class Placement:
    """A UV map and the homogeneous matrix applied to (u, v, 0, 1)."""

    uv_map: str
    matrix: np.ndarray

    @property
    def transform(self) -> np.ndarray:
        """The (3, 3) matrix for (u, v, 1); what lies across the picture plane is dropped."""
        return self.matrix[np.ix_([0, 1, 3], [0, 1, 3])]

    def after(self, matrix):
        """Return the placement with a further matrix applied."""
        return Placement(self.uv_map, matrix @ self.matrix)


def resolve_placement(socket, groups, constant_of) -> Placement | None:
    """Find the UV map behind a vector input.

    Parameters
    ----------
    socket : bpy.types.NodeSocket    Vector input of a Mapping or Vector Math node or of a texture.
    groups : tuple    Group nodes around it.
    constant_of : callable
        (socket, groups) to a (3,) array, or None where the value varies over the surface.

    Returns
    -------
    Placement or None    None if the coordinates are not an affine function of one UV map.
    """
    origin = trace(socket, groups)
    if not origin.is_output:
        value = constant_of(socket, groups)
        matrix = np.zeros((4, 4))
        matrix[:3, 3] = value
        matrix[3, 3] = 1.0
        return Placement("", matrix)
    node = origin.socket.node
    source = _SOURCES.get(node.bl_idname)
    return source(origin, constant_of) if source else None


def _from_uv_map(origin, constant_of):
    node = origin.socket.node
    return None if node.from_instancer else Placement(node.uv_map, np.eye(4))


def _from_coordinates(origin, constant_of):
    node = origin.socket.node
    if origin.socket.identifier != "UV" or node.from_instancer:
        return None
    return Placement("", np.eye(4))


def _from_attribute(origin, constant_of):
    node = origin.socket.node
    if node.attribute_type != "GEOMETRY" or origin.socket.identifier != "Vector":
        return None
    return Placement(node.attribute_name, np.eye(4))


def _from_mapping(origin, constant_of):
    node = origin.socket.node
    inner = resolve_placement(node.inputs["Vector"], origin.groups, constant_of)
    if inner is None or node.vector_type == "NORMAL":
        return None
    parts = [constant_of(node.inputs[n], origin.groups) for n in ("Rotation", "Scale")]
    location = np.zeros(3)
    if node.vector_type != "VECTOR":
        location = constant_of(node.inputs["Location"], origin.groups)
    if location is None or any(part is None for part in parts):
        return None
    angles, scale = parts
    rotation = np.array(mathutils.Euler([float(a) for a in angles], "XYZ").to_matrix())
    if node.vector_type == "TEXTURE":
        with np.errstate(divide="ignore"):
            inverse = np.where(scale != 0, 1.0 / scale, 0.0)
        linear = np.diag(inverse) @ rotation.T
        return inner.after(_affine(linear, -linear @ location))
    return inner.after(_affine(rotation @ np.diag(scale), location))


def _from_vector_math(origin, constant_of):
    node = origin.socket.node
    if node.operation not in {"ADD", "SUBTRACT", "MULTIPLY", "DIVIDE", "SCALE"}:
        return None
    first = resolve_placement(node.inputs[0], origin.groups, constant_of)
    other = node.inputs["Scale"] if node.operation == "SCALE" else node.inputs[1]
    value = constant_of(other, origin.groups)
    if first is None or value is None:
        return None
    value = np.broadcast_to(value, 3).astype(float)
    if node.operation == "DIVIDE":
        value = np.divide(1.0, value, out=np.zeros(3), where=value != 0)
    if node.operation in {"ADD", "SUBTRACT"}:
        return first.after(_affine(np.eye(3), value if node.operation == "ADD" else -value))
    return first.after(_affine(np.diag(value), np.zeros(3)))


def _affine(linear, shift):
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = shift
    return matrix


_SOURCES = {
    "ShaderNodeUVMap": _from_uv_map,
    "ShaderNodeTexCoord": _from_coordinates,
    "ShaderNodeAttribute": _from_attribute,
    "ShaderNodeMapping": _from_mapping,
    "ShaderNodeVectorMath": _from_vector_math,
}


def legacy_matrix(node) -> np.ndarray | None:
    """Return the (4, 4) matrix of a texture node's own mapping, None when it has none or that does nothing.

    Files from before Blender 2.81 carry it; it has no place in the node itself.
    """
    settings = getattr(node, "texture_mapping", None)
    if settings is None:
        return None
    rotation = np.array(settings.rotation.to_matrix())
    location, scale = np.array(settings.translation), np.array(settings.scale)
    matrix = _affine(rotation @ np.diag(scale), location)
    return None if np.allclose(matrix, np.eye(4)) else matrix
