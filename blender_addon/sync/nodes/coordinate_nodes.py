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


def _divided(vector, divisor):
    divisor = np.broadcast_to(divisor, vector.shape)
    return np.divide(vector, divisor, out=np.zeros_like(vector), where=divisor != 0)


FUNCTIONS = {
    "ShaderNodeMapping": _mapping,
}
"""What each node does, by its ``bl_idname``."""
