"""What shader nodes can ask of a surface beside its UV maps, at the corners of its triangles."""

from dataclasses import dataclass, field, replace

import numpy as np

from ...engine.scene.mesh import CHART_MAP, Geometry, Mesh
from ...imports import loaded_when_used
from .instance_attributes import KINDS
from .meshes import corners_of, read_geometry, read_values
from .vertex_values import find_islands, measure_pointiness

with loaded_when_used():
    from ...engine.atlas import picture_charts


@dataclass(frozen=True, eq=False)
class Surface:
    """A geometry and what else is known of it.

    Parameters
    ----------
    geometry : Geometry    Without a map of charts.
    attributes : dict of str to (t, 3, c) float32 array    By corner; colours have four channels, linear.
    colour : str    Name of the colour attribute that is shown where none is named.
    generated : (t, 3, 3) float32 array    In the box of the shape before modifiers bent it.
    edges : (e, 2) int32 array
    vertex_normals : (v, 3) float32 array
    """

    geometry: Geometry
    attributes: dict[str, np.ndarray]
    colour: str
    generated: np.ndarray
    edges: np.ndarray
    vertex_normals: np.ndarray
    _kept: dict = field(default_factory=dict)

    def is_same(self, other: "Surface | None") -> bool:
        """Whether another one is the same in all that materials may ask for, the geometry itself aside."""
        if other is None or self.attributes.keys() != other.attributes.keys():
            return False
        pairs = [(self.attributes[name], other.attributes[name]) for name in self.attributes]
        pairs += [
            (self.generated, other.generated),
            (self.edges, other.edges),
            (self.vertex_normals, other.vertex_normals),
        ]
        return self.colour == other.colour and all(np.array_equal(a, b) for a, b in pairs)

    def rows(self, slot: int, is_last: bool) -> np.ndarray:
        """Triangles of a slot; the last one has those beyond it as well."""
        numbers = self.geometry.material_index
        return np.flatnonzero(numbers >= slot if is_last else numbers == slot)

    def charts(self, slot: int, is_last: bool) -> "picture_charts.PictureCharts | None":
        """Return the charts of a slot's triangles; None if they have no area."""
        key = ("charts", slot, is_last)
        if key not in self._kept:
            self._kept[key] = picture_charts.lay_charts(self._part(slot, is_last))
        return self._kept[key]

    def area(self, slot: int, is_last: bool) -> float:
        """Area of a slot's triangles in the object's own frame. [Blender unit²]"""
        key = ("area", slot, is_last)
        if key not in self._kept:
            self._kept[key] = float(self._part(slot, is_last).areas().sum())
        return self._kept[key]

    def _part(self, slot: int, is_last: bool) -> Mesh:
        rows, whole = self.rows(slot, is_last), self.geometry
        return Mesh(
            id=whole.id,
            name=whole.id,
            vertices=whole.vertices.astype(np.float64),
            triangles=whole.triangles[rows],
            materials=("",),
            material_index=np.zeros(len(rows), np.int32),
            polygon=None if whole.polygon is None else whole.polygon[rows],
        )

    def with_charts(self, slots) -> Geometry:
        """Return the geometry with the charts of slots, (slot, whether it is the last), as a UV map."""
        uv = np.zeros((len(self.geometry.triangles), 3, 2), np.float32)
        is_laid = False
        for slot in sorted(slots):
            charts = self.charts(*slot)
            if charts is not None:
                uv[self.rows(*slot)] = charts.texture_coordinates
                is_laid = True
        if not is_laid:
            return self.geometry
        return replace(self.geometry, uv_maps={**self.geometry.uv_maps, CHART_MAP: uv})

    # ---- what nodes ask for, at corners: (t, 3, c) ----

    def positions(self) -> np.ndarray:
        """Places in the object's own frame."""
        return self.geometry.vertices[self.geometry.triangles]

    def flat_normals(self) -> np.ndarray:
        """Directions across the triangles."""
        corners = self.positions().astype(np.float64)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        return np.repeat(normal[:, None].astype(np.float32), 3, axis=1)

    def normals(self) -> np.ndarray:
        """Directions across the surface as it is shaded."""
        smooth = self.geometry.corner_normals
        return self.flat_normals() if smooth is None else smooth

    def tangents(self, uv_map: str) -> np.ndarray:
        """Where U of a UV map grows across each triangle, of length 1 or 0, and on which side V does: 1 or -1."""
        corners, uv = self.positions().astype(np.float64), self.uv_map(uv_map).astype(np.float64)
        (a, b), (p, q) = (
            (each[:, 1] - each[:, 0], each[:, 2] - each[:, 0]) for each in (corners, uv)
        )
        whole = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
        along = np.sign(whole)[:, None] * (a * q[:, 1:] - b * p[:, 1:])
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
        side = np.where(whole < 0.0, -1.0, 1.0)[:, None]
        made = np.concatenate([along, side], axis=1).astype(np.float32)
        return np.repeat(made[:, None], 3, axis=1)

    def islands(self) -> np.ndarray:
        """A random number for every connected part."""
        triangles = self.geometry.triangles
        values = self._vertex_values("islands", find_islands, len(self.geometry.vertices))
        return np.repeat(values[triangles[:, :1]], 3, axis=1)[..., None]

    def pointiness(self) -> np.ndarray:
        """How far vertices stick out, 0.5 where the surface is flat."""
        positions, normals = self.geometry.vertices, self.vertex_normals
        values = self._vertex_values("pointiness", measure_pointiness, positions, normals)
        return values[self.geometry.triangles][..., None]

    def _vertex_values(self, name: str, make, *arguments) -> np.ndarray:
        if name not in self._kept:
            self._kept[name] = make(*arguments, self.edges)
        return self._kept[name]

    def uv_map(self, name: str) -> np.ndarray | None:
        """The UV map with a name, the default one if it has none; None if there is no such map."""
        maps = self.geometry.uv_maps
        return maps.get(name) if name else next(iter(maps.values()), None)


def read_surface(source, geometry_id: str, change=None) -> Surface | None:
    """Read the surface of an evaluated object with all that materials may ask for; None when there is no face.

    Parameters as of `read_geometry`.
    """
    found = []
    read_geometry(source, geometry_id, change, lambda mesh, made: found.append(_read(mesh, made)))
    return found[0] if found else None


def _read(mesh, geometry: Geometry) -> Surface:
    corners = corners_of(mesh)
    attributes = {}
    for attribute in mesh.attributes:
        if attribute.data_type in KINDS and not attribute.name.startswith("."):
            values = _at_corners(attribute, geometry, corners)
            if values is not None:
                attributes[attribute.name] = values
    count = len(mesh.vertices)
    return Surface(
        geometry,
        attributes,
        _shown_colour(mesh),
        _generated(mesh)[geometry.triangles],
        read_values(mesh.edges, "vertices", np.int32, (len(mesh.edges), 2)),
        read_values(mesh.vertex_normals, "vector", np.float32, (count, 3)),
    )


def _at_corners(attribute, geometry: Geometry, corners: np.ndarray) -> np.ndarray | None:
    name, kind, channels = KINDS[attribute.data_type]
    if attribute.domain not in {"POINT", "CORNER", "FACE"}:
        return None
    values = read_values(attribute.data, name, kind, (len(attribute.data), channels))
    values = values.astype(np.float32)
    if attribute.domain == "POINT":
        return values[geometry.triangles]
    if attribute.domain == "CORNER":
        return values[corners]
    return np.repeat(values[geometry.polygon][:, None], 3, axis=1)


def _shown_colour(mesh) -> str:
    layers = mesh.color_attributes
    number = layers.render_color_index
    return layers[number].name if 0 <= number < len(layers) else ""


def _generated(mesh) -> np.ndarray:
    """Places of vertices in the box of the shape before modifiers bent it, 0..1. (v, 3)"""
    places = read_values(mesh.vertices, "undeformed_co", np.float32, (len(mesh.vertices), 3))
    size = np.array(mesh.texspace_size, np.float32)
    scale = np.divide(0.5, size, out=np.zeros(3, np.float32), where=size != 0)
    return places * scale - (np.array(mesh.texspace_location, np.float32) * scale - 0.5)
