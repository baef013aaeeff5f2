"""What means over facets that are shaded smoothly can be off by."""

import numpy as np

from ..scene.mesh import Mesh
from .means import ObjectMean
from .notes import Notes
from .order import Departure
from .surfaces import BakedSurface

TOLD = 0.01
"""Share of a mean from which it is told. [-]"""

PLACES = np.array([
    [1 / 3, 1 / 3, 1 / 3],
    [0.797426985353087, 0.101286507323456, 0.101286507323456],
    [0.101286507323456, 0.797426985353087, 0.101286507323456],
    [0.101286507323456, 0.101286507323456, 0.797426985353087],
    [0.059715871789770, 0.470142064105115, 0.470142064105115],
    [0.470142064105115, 0.059715871789770, 0.470142064105115],
    [0.470142064105115, 0.470142064105115, 0.059715871789770],
])  # fmt: skip
WEIGHTS = np.array([0.225, *[0.125939180544827] * 3, *[0.132394152788506] * 3])
"""Quadrature on a triangle, exact for polynomials of degree 5 (Radon 1948)."""

CHUNK = 1 << 18
"""Triangles that are looked at in one go."""


def find_facet_loss(mesh: Mesh) -> float:
    """Find by how much smooth shading may change the mean illuminance of a mesh. [-]

    A lumel is lit by its shading normal, the flux on a facet is told by the facet's own. Under a light that shines straight
    at it a facet with normal n loses the share 1 - (n_s, n) on the average over its shading normals n_s; under an even sky,
    of which it cannot see what lies below its plane, half as much (theory, 11.14).

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    float    Mean of 1 - (n_s, n) by area; 0 for flat shading. [-]
    """
    if mesh.corner_normals is None or len(mesh.triangles) == 0:
        return 0.0
    lost = total = 0.0
    for first in range(0, len(mesh.triangles), CHUNK):
        part = slice(first, first + CHUNK)
        corners = mesh.vertices[mesh.triangles[part]].astype(np.float64)
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(across, axis=1)
        flat = across / np.maximum(length, 1e-300)[:, None]
        bent = np.einsum("pc,tcx->tpx", PLACES, mesh.corner_normals[part].astype(np.float64))
        bent /= np.maximum(np.linalg.norm(bent, axis=2, keepdims=True), 1e-12)
        cosine = np.einsum("tpx,tx->tp", bent, flat)
        # Seen from either side a surface counts with the normal on that side.
        lost += float(length @ (np.clip(1.0 - np.abs(cosine), 0.0, 1.0) @ WEIGHTS))
        total += float(length.sum())
    return lost / total if total > 0.0 else 0.0


def find_facet_losses(
    surfaces: list[BakedSurface], means: list[ObjectMean], notes: Notes
) -> np.ndarray:
    """What the mean of each surface's map may be off by because facets are shaded smoothly. (n,) [lx]"""
    losses: dict[str, float] = {}
    for each in surfaces:
        if each.key not in losses:
            losses[each.key] = find_facet_loss(each.mesh)
            notes.departures += tell_facet_loss(each.mesh.name, losses[each.key])
    return np.array(
        [losses[each.key] * own.mean for each, own in zip(surfaces, means, strict=True)]
    )


def tell_facet_loss(name: str, loss: float) -> list[Departure]:
    """Say what a loss means, where it is worth it."""
    if loss <= TOLD:
        return []
    return [
        Departure(
            name,
            f"smooth shading bends the normals of its facets, so its mean illuminance is known to {100.0 * loss:.2g} % only",
            "the stated error of the mean covers it; use more and smaller facets, or shade flat what is flat",
        )
    ]
