"""What pictures of the documents share: cameras, smooth meshes, and pixels as a screen shows them."""

from dataclasses import replace

import numpy as np

from ...engine.analysis.tone import encode_srgb
from ...engine.paint.sphere import KNEE
from ...engine.photometry.colour import XYZ_TO_REC709
from ...engine.scene.camera import Camera, Projection
from ...engine.scene.mesh import Mesh


def camera_at(place, target, size, extent: float) -> Camera:
    """Camera at a place that looks at another, with the width of its film at unit distance."""
    back = np.asarray(place, float) - target
    back /= np.linalg.norm(back)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([right, np.cross(back, right), back], axis=1)
    frame[:3, 3] = place
    return Camera(frame, Projection.PERSPECTIVE, *size, extent, extent * size[1] / size[0])


def shown(picture, white: float) -> np.ndarray:
    """Pixels of a picture with a luminance [cd/m2] as white, highlights rolled off. (h, w, 3) uint8, from above"""
    colour = np.maximum(picture.tristimulus.astype(float) @ XYZ_TO_REC709.T / white, 0.0)
    most = colour.max(axis=-1, keepdims=True)
    over = np.maximum(most - KNEE, 0.0)
    rolled = np.where(over > 0.0, KNEE + (1.0 - KNEE) * over / (over + 1.0 - KNEE), most)
    colour = colour * rolled / np.maximum(most, 1e-9)
    return encode_srgb(colour)[::-1]


def smoothed(mesh: Mesh) -> Mesh:
    """A mesh with the means of its faces' normals at its corners."""
    corners = mesh.vertices[mesh.triangles]
    own = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros_like(mesh.vertices)
    for k in range(3):
        np.add.at(total, mesh.triangles[:, k], own)
    total /= np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)
    return replace(mesh, corner_normals=total[mesh.triangles].astype(np.float32))
