"""Triangle meshes as pure data: what is sent (geometry and where it stands), and one object's triangles in the world."""

from dataclasses import dataclass, field

import numpy as np

CHART_MAP = "texels of materials"
"""UV map of pictures that were made for one surface alone; it is the default of nothing."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """Triangles in a frame of their own, shared by all objects that show them.

    Parameters
    ----------
    id : str    Stable and unique.
    vertices : (v, 3) float array    Positions in the local frame.
    triangles : (t, 3) int32 array    Vertex indices, anticlockwise seen from outside.
    material_index : (t,) int32 array    Slot of each triangle; beyond the object's last slot the last one serves.
    corner_normals : (t, 3, 3) float32 array or None    Shading normals per triangle corner; None: flat.
    uv_maps : dict of str to (t, 3, 2) float32 array    Texture coordinates per triangle corner; the first is the default.
    polygon : (t,) int32 array or None    Index of the polygon that each triangle came from (None: its own).
    box : (2, 3) float64 array or None    Middle and halves of the sides of its box in the local frame, round which
        directions of facets go (None: that of its vertices).
    """

    id: str
    vertices: np.ndarray
    triangles: np.ndarray
    material_index: np.ndarray
    corner_normals: np.ndarray | None = None
    uv_maps: dict[str, np.ndarray] = field(default_factory=dict)
    polygon: np.ndarray | None = None
    box: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Placement:
    """An object: a geometry, where it stands and what it is made of.

    Parameters
    ----------
    id : str    Stable and unique per object (and per instance).
    name : str    For people.
    geometry : str    Id of a `Geometry` of the scene.
    frame : (4, 4) float64 array    From the geometry's frame to the world. [m]
    materials : tuple of str    Material ids, one per slot; at least one.
    visible_to_camera : bool    Whether rays of the camera meet it.
    index : int    The user's number for the index pass.
    meets_light : bool    Whether light meets it. What does not neither shades nor reflects nor gives light.
    is_holdout : bool    Whether the camera sees a hole in its place, see `material.Holdout`.
    is_catcher : bool    Whether the camera sees but its shadows, see `material.Catcher`.
    """

    id: str
    name: str
    geometry: str
    frame: np.ndarray
    materials: tuple[str, ...]
    visible_to_camera: bool = True
    index: int = 0
    meets_light: bool = True
    is_holdout: bool = False
    is_catcher: bool = False


@dataclass(frozen=True, eq=False)
class Mesh:
    """One object's triangles in world coordinates.

    Parameters
    ----------
    id : str    Stable and unique per object (and per instance).
    name : str    For people.
    vertices : (v, 3) float64 array    Positions. [m]
    triangles : (t, 3) int32 array    Vertex indices, anticlockwise seen from outside.
    materials : tuple of str    Material ids, one per slot; at least one.
    material_index : (t,) int32 array    Slot of each triangle.
    corner_normals : (t, 3, 3) float32 array or None    Shading normals per triangle corner; None: flat.
    uv_maps : dict of str to (t, 3, 2) float32 array    Texture coordinates per triangle corner; the first is the default.
    polygon : (t,) int32 array or None    Index of the polygon that each triangle came from (None: its own).
    visible_to_camera : bool    Whether rays of the camera meet it.
    index : int    The user's number for the index pass.
    meets_light : bool    Whether light meets it. What does not neither shades nor reflects nor gives light.
    is_holdout : bool    Whether the camera sees a hole in its place, see `material.Holdout`.
    is_catcher : bool    Whether the camera sees but its shadows, see `material.Catcher`.
    """

    id: str
    name: str
    vertices: np.ndarray
    triangles: np.ndarray
    materials: tuple[str, ...]
    material_index: np.ndarray
    corner_normals: np.ndarray | None = None
    uv_maps: dict[str, np.ndarray] = field(default_factory=dict)
    polygon: np.ndarray | None = None
    visible_to_camera: bool = True
    index: int = 0
    meets_light: bool = True
    is_holdout: bool = False
    is_catcher: bool = False

    def areas(self) -> np.ndarray:
        """Return the triangle areas, shape (t,). [m2]"""
        corners = self.vertices[self.triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return 0.5 * np.linalg.norm(normal, axis=1)


def place(geometry: Geometry, placement: Placement) -> Mesh:
    """Bring a geometry into the world; a mirrored object keeps its outside outside."""
    frame = np.asarray(placement.frame, dtype=np.float64)
    linear = frame[:3, :3]
    vertices = geometry.vertices.astype(np.float64) @ linear.T + frame[:3, 3]
    triangles, uv_maps = geometry.triangles, geometry.uv_maps
    normals = geometry.corner_normals
    if normals is not None:
        normals = _turn_normals(normals, linear)
    if np.linalg.det(linear) < 0.0:
        triangles = np.ascontiguousarray(triangles[:, ::-1])
        normals = None if normals is None else normals[:, ::-1]
        uv_maps = {key: uv[:, ::-1] for key, uv in uv_maps.items()}
    return Mesh(
        id=placement.id,
        name=placement.name,
        vertices=vertices,
        triangles=triangles,
        materials=placement.materials,
        material_index=np.minimum(geometry.material_index, len(placement.materials) - 1),
        corner_normals=normals,
        uv_maps=uv_maps,
        polygon=geometry.polygon,
        visible_to_camera=placement.visible_to_camera,
        meets_light=placement.meets_light,
        is_holdout=placement.is_holdout,
        is_catcher=placement.is_catcher,
        index=placement.index,
    )


def _turn_normals(normals: np.ndarray, linear: np.ndarray) -> np.ndarray:
    """Turn normals with a linear map: by its inverse transpose, then to unit length; mirroring needs no more."""
    a, b, c = linear.T
    # Columns of the inverse transpose, times the determinant.
    turn = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)])
    determinant = np.dot(a, turn[0])
    if abs(determinant) < 1e-30:
        return normals
    turn *= np.sign(determinant) / np.abs(turn).max()
    turned = normals @ turn.astype(np.float32)
    length = np.sqrt(np.einsum("...i,...i", turned, turned))[..., None]
    return turned / np.maximum(length, np.float32(1e-12))


def find_uv_map(uv_maps: dict[str, np.ndarray], name: str) -> np.ndarray | None:
    """Return the UV map with a name, or else the default one; None if there is none."""
    if name in uv_maps:
        return uv_maps[name]
    return next((uv for key, uv in uv_maps.items() if key != CHART_MAP), None)
