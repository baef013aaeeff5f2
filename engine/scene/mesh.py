"""Triangle meshes as pure data."""

from dataclasses import dataclass, field

import numpy as np


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
    visible_to_camera : bool    Blender's ray visibility.
    index : int    The user's number for the index pass.
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

    def areas(self) -> np.ndarray:
        """Return the triangle areas, shape (t,). [m2]"""
        corners = self.vertices[self.triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return 0.5 * np.linalg.norm(normal, axis=1)
