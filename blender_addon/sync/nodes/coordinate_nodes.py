"""Nodes that calculate coordinates which are no UV map.

Where they are one, textures ask for its `Placement` instead.
"""

import mathutils
import numpy as np

from .fields import constant, rgb


def _mapping(at):
    kind = at.node.vector_type
    vector, scale = at("Vector"), at("Scale")
    location = at("Location") if kind in {"POINT", "TEXTURE"} else constant(0)
    angles = at("Rotation").settled()
    if not angles.is_constant:
        at.note("Rotation varies over the surface", "its mean is used")
    turned = mathutils.Euler([float(angle) for angle in rgb(angles.mean())], "XYZ").to_matrix()
    matrix = constant(*np.array(turned).ravel())

    def move(vector, scale, location, matrix):
        vector, matrix = rgb(vector), matrix.reshape(3, 3)
        if kind == "TEXTURE":
            return _divided((vector - location) @ matrix, scale)
        if kind != "NORMAL":
            return (vector * scale) @ matrix.T + location
        normal = _divided(vector, scale) @ matrix.T
        return _divided(normal, np.linalg.norm(normal, axis=-1, keepdims=True))

    return at.map(move, vector, scale, location, matrix)


def _rotate(at):
    node = at.node
    kind, is_inverse = node.rotation_type, node.invert
    vector, centre = at("Vector"), at("Center")
    if kind == "EULER_XYZ":
        angles = at("Rotation").settled()
        if not angles.is_constant:
            at.note("Rotation varies over the surface", "its mean is used")
        turned = np.array(mathutils.Euler(rgb(angles.mean()).tolist(), "XYZ").to_matrix())
        matrix = constant(*(turned.T if is_inverse else turned).ravel())

        def turn(vector, centre, matrix):
            return (rgb(vector) - rgb(centre)) @ matrix.reshape(3, 3).T + rgb(centre)

        return at.map(turn, vector, centre, matrix)
    own = {"X_AXIS": (1, 0, 0), "Y_AXIS": (0, 1, 0), "Z_AXIS": (0, 0, 1)}.get(kind)
    axis = at("Axis") if own is None else constant(*own)

    def turn_about(vector, centre, axis, angle):
        vector, axis = rgb(vector) - rgb(centre), rgb(axis)
        length = np.linalg.norm(axis, axis=-1, keepdims=True)
        axis = _divided(axis, length)
        angle = -angle if is_inverse else angle
        cosine, sine = np.cos(angle), np.sin(angle)
        along = (vector * axis).sum(axis=-1, keepdims=True) * axis
        turned = along + cosine * (vector - along) + sine * np.cross(axis, vector)
        return np.where(length > 0, turned, vector) + rgb(centre)

    return at.map(turn_about, vector, centre, axis, at("Angle"))


def _normal(at):
    own = np.array(at.node.outputs["Normal"].default_value, np.float32)
    own /= max(float(np.linalg.norm(own)), 1e-30)
    if at.output.identifier == "Normal":
        return constant(*own)

    def dot(normal, own):
        normal = rgb(normal)
        normal = _divided(normal, np.linalg.norm(normal, axis=-1, keepdims=True))
        return (normal * own).sum(axis=-1, keepdims=True)

    return at.map(dot, at("Normal"), constant(*own))


def _divided(vector, divisor):
    divisor = np.broadcast_to(divisor, vector.shape)
    return np.divide(vector, divisor, out=np.zeros_like(vector), where=divisor != 0)


FUNCTIONS = {
    "ShaderNodeMapping": _mapping,
    "ShaderNodeVectorRotate": _rotate,
    "ShaderNodeNormal": _normal,
}
"""What each node does, by its ``bl_idname``."""
