"""Cycles' light portals: area lights that give no light but mark an opening that daylight enters by."""

import numpy as np

from ....engine.scene.material import Material, Transparent
from ....engine.scene.mesh import Geometry
from .kinds import sizes_of

GEOMETRY = "geometry:portal"
"""Id of the unit square that all portals show."""

MATERIAL = "material:portal"
"""Id of what they are made of."""

STANDOFF = 1e-3
"""How far an opening is put before its portal: of it and a pane in the same place a ray would meet only one. [m]"""


def is_portal(light) -> bool:
    """Tell whether a light (`bpy.types.Light`) is a portal; there is no such setting while Cycles is switched off."""
    return light.type == "AREA" and getattr(getattr(light, "cycles", None), "is_portal", False)


def portal_geometry() -> Geometry:
    """Return a square with sides of 1 about the origin, which faces -z as area lights do."""
    corners = 0.5 * np.array([(-1, -1, 0), (-1, 1, 0), (1, 1, 0), (1, -1, 0)], dtype=np.float64)
    triangles = np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int32)
    return Geometry(GEOMETRY, corners, triangles, np.zeros(2, np.int32))


def portal_material() -> Material:
    """Return what lets all light pass."""
    return Material(MATERIAL, "Portal", Transparent())


def portal_frame(light, matrix, scale: float) -> np.ndarray:
    """Return where the square of a portal stands: around the light's shape, just before it.

    Parameters
    ----------
    light : bpy.types.AreaLight
    matrix : (4, 4) array    World matrix of its object, in Blender units.
    scale : float    Metres per Blender unit.

    Returns
    -------
    (4, 4) float64 array    [m]
    """
    frame = np.array(matrix, dtype=np.float64)
    frame[:3] *= scale
    depth = np.linalg.norm(frame[:3, 2])
    if depth > 0.0:
        frame[:3, 3] -= frame[:3, 2] / depth * STANDOFF
    frame[:3, :2] *= sizes_of(light)
    return frame
