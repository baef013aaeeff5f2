"""Evaluation of nodes at the vertices of a mesh: they take the place of a UV map's pixels."""

from dataclasses import dataclass

import numpy as np

from .evaluation import Context
from .fields import Field, Layout, look_up

LAYOUT = Layout("vertices", np.eye(3), name="vertices")
"""Layout of what is known at vertices; it lies on no surface."""


@dataclass(frozen=True, eq=False)
class Vertices:
    """Vertices of a mesh.

    Parameters
    ----------
    places, normals : (n, 3) float array    In the object's own frame. [BU], [-]
    uv_maps : dict of str to (n, 2) float array    The first is the default.
    box : (2, 3) array    Middle and halves of the sides of what Generated coordinates span. [BU]
    frame : (4, 4) float array    From the object's frame to the world. [BU]
    """

    places: np.ndarray
    normals: np.ndarray
    uv_maps: dict[str, np.ndarray]
    box: np.ndarray
    frame: np.ndarray


class VertexContext(Context):
    """The conversion of what a material says of the vertices of one object.

    Parameters
    ----------
    datablock, report, images    As of `Context`.
    vertices : Vertices
    """

    lies_on_maps = False

    def __init__(self, datablock: str, report, images, vertices: Vertices):
        super().__init__(datablock, report, images)
        self.vertices = vertices

    def take_output(self, at) -> Field | None:
        """Return what a node gives at every vertex; None: it gives the same as on a surface."""
        source = _SOURCES.get(at.node.bl_idname)
        found = None if source is None else source(at, self.vertices)
        return None if found is None else _at_vertices(found)

    def coordinates(self) -> Field:
        """Return generated coordinates, by which textures go where nothing is linked."""
        return _at_vertices(_generated(self.vertices))

    def settle(self, field: Field) -> Field:
        """Return a picture as it is at the vertices."""
        if field.is_constant or field.is_spread or field.layout is LAYOUT:
            return field
        uv = _map_of(self.vertices, field.layout.uv_map)
        if uv is None:
            return Field(field.mean(), None, True)
        u, v = (uv @ field.layout.transform[:2, :2].T + field.layout.transform[:2, 2]).T
        return _at_vertices(look_up(field, u, v), field.is_stand_in)


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors of length 1 (n, 3); 0 stays 0."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30)


def _at_vertices(values: np.ndarray, is_stand_in: bool = False) -> Field:
    return Field(np.asarray(values, np.float32)[None], LAYOUT, is_stand_in)


def _map_of(vertices: Vertices, name: str) -> np.ndarray | None:
    if name == "" and vertices.uv_maps:
        return next(iter(vertices.uv_maps.values()))
    return vertices.uv_maps.get(name)


def _generated(vertices: Vertices) -> np.ndarray:
    middle, half = vertices.box
    return 0.5 + 0.5 * (vertices.places - middle) / np.where(half > 0.0, half, 1.0)


def _on_map(vertices: Vertices, name: str) -> np.ndarray | None:
    uv = _map_of(vertices, name)
    return None if uv is None else np.concatenate([uv, np.zeros((len(uv), 1))], axis=1)


def _coordinates(at, vertices: Vertices) -> np.ndarray | None:
    node, name = at.node, at.output.identifier
    if name == "Generated":
        return _generated(vertices)
    if name == "Object" and node.object is None:
        return vertices.places
    if name == "Normal":
        return vertices.normals
    return _on_map(vertices, "") if name == "UV" and not node.from_instancer else None


def _uv_map(at, vertices: Vertices) -> np.ndarray | None:
    return None if at.node.from_instancer else _on_map(vertices, at.node.uv_map)


def _attribute(at, vertices: Vertices) -> np.ndarray | None:
    node = at.node
    if node.attribute_type != "GEOMETRY" or at.output.identifier != "Vector":
        return None
    return _on_map(vertices, node.attribute_name) if node.attribute_name else None


def _geometry(at, vertices: Vertices) -> np.ndarray | None:
    linear, name = vertices.frame[:3, :3], at.output.identifier
    if name == "Position":
        return vertices.places @ linear.T + vertices.frame[:3, 3]
    if name != "Normal":
        return None
    return unit(vertices.normals @ np.linalg.pinv(linear))


_SOURCES = {
    "ShaderNodeTexCoord": _coordinates,
    "ShaderNodeUVMap": _uv_map,
    "ShaderNodeAttribute": _attribute,
    "ShaderNodeNewGeometry": _geometry,
}
"""What nodes give at vertices, by their ``bl_idname``."""
