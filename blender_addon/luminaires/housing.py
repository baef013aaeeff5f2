"""The housing of a luminaire as an obstacle for the light of others, out of the way of its own.

What leaves a luminaire is what its file says: the housing has taken its part already. So it may stand only where none of the
luminaire's own light passes: above its opening, if it sends no light up, and within an opening that is a box, as boxes shine
outwards.
"""

import hashlib

import numpy as np

from ...engine.errors import SceneError
from ...engine.luminaires.coordinates import directions
from ...engine.luminaires.distribution import intensity
from ...engine.luminaires.formats.record import LuminaireFile
from ...engine.scene.distribution import IntensityDistribution, Opening
from ...engine.scene.mesh import Geometry
from .body import THIN, make_box, make_prism

UPWARD = 1e-3
"""Share of the flux that may go up into a housing, where it is lost. [-]"""

STEP = np.deg2rad(2.5)
"""Of the directions in which is looked for light. [rad]"""

PREFIX = "geometry:housing/"
"""Beginning of the ids of housings."""


def make_housing(
    file: LuminaireFile, distribution: IntensityDistribution, opening: Opening
) -> Geometry:
    """Return the housing that others' light cannot pass, in the luminaire's own axes. [m]

    Parameters
    ----------
    file : LuminaireFile
    distribution : IntensityDistribution    As it is mounted, in the axes of the luminaire.
    opening : Opening    What shines.

    Raises
    ------
    SceneError    The file states no housing, or all of it is where the luminaire's own light passes.
    """
    if file.housing is None:
        raise SceneError("its file states no housing")
    length, width, height = file.housing
    is_round = width <= 0.0
    half = 0.5 * np.array([length, length if is_round else width])
    inside = 0.5 * np.array(opening.size)
    low = np.append(-half, -inside[2])
    high = np.append(half, -inside[2] + max(height, 2.0 * THIN))
    parts = []
    if upward_share(distribution) <= UPWARD:
        above = np.append(low[:2], inside[2] + THIN)
        if high[2] - above[2] >= THIN:
            parts.append(make_prism(above, high, 2) if is_round else make_box(above, high))
    if opening.shape == "box" and not is_round:
        inner = np.maximum(low, THIN - inside), np.minimum(high, inside - THIN)
        if (inner[1] - inner[0] >= THIN).all():
            parts.append(make_box(*inner))
    if not parts:
        raise SceneError("its own light passes where its housing is")
    return _to_geometry(parts)


def upward_share(distribution: IntensityDistribution) -> float:
    """Share of the flux that goes up, along +z of the luminaire. [-]"""
    polar = np.arange(0.5 * STEP, np.pi, STEP)
    azimuth = np.arange(0.0, 2.0 * np.pi, STEP)
    ways = directions(azimuth[:, None], polar[None])
    parts = (intensity(distribution, ways) * np.sin(polar)).sum(axis=0)
    is_up = ways[0, :, 2] > 0.0
    total = float(parts.sum())
    return float(parts[is_up].sum()) / total if total > 0.0 else 0.0


def _to_geometry(parts) -> Geometry:
    """Triangles of closed bodies (corners, polygons), under an id by what they are."""
    vertices, triangles = [], []
    for corners, polygons in parts:
        for polygon in polygons:
            fan = zip(polygon[1:], polygon[2:], strict=False)
            triangles += [[each + len(vertices) for each in (polygon[0], *pair)] for pair in fan]
        vertices += corners.tolist()
    vertices, triangles = np.array(vertices), np.array(triangles, dtype=np.int32)
    digest = hashlib.sha256(vertices.tobytes()).hexdigest()[:24]
    return Geometry(f"{PREFIX}{digest}", vertices, triangles, np.zeros(len(triangles), np.int32))
