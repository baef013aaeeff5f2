"""Charts of a mesh: a UV layout of its own in which no two places of the surface share a lumel."""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from ..scene.mesh import Mesh

MAXIMUM_TRIANGLES = 2_000_000
"""More than this is refused before the chart search, whose time grows faster than the mesh."""

ATTEMPTS = 6
"""How often the density is lowered until a map fits the largest size."""


@dataclass(frozen=True)
class AtlasChart:
    """Layout of one mesh in one map.

    Parameters
    ----------
    uv : (t, 3, 2) float64 array    Texture coordinates per triangle corner, in 0..1, v upwards.
    width, height : int    Size of the map. [lumel]
    density : float    Lumels per metre that were reached.
    requested_density : float    Lumels per metre that were asked for.
    chart_count : int
    """

    uv: np.ndarray
    width: int
    height: int
    density: float
    requested_density: float
    chart_count: int


def unwrap(mesh: Mesh, density: float, largest: int = 1024, margin: int = 4) -> AtlasChart:
    """Lay out a mesh at a density, or at the highest one that fits the largest map.

    Parameters
    ----------
    mesh : Mesh
    density : float    Lumels per metre.
    largest : int    Longest side of the map. [lumel]
    margin : int    Lumels kept free around every chart.

    Raises
    ------
    SceneError    The mesh has no area, too many triangles, or does not fit even at a tiny density.
    """
    if len(mesh.triangles) > MAXIMUM_TRIANGLES:
        raise SceneError(
            f"object '{mesh.name}' has {len(mesh.triangles)} triangles, at most {MAXIMUM_TRIANGLES} can be unwrapped; "
            "split or simplify it"
        )
    if len(mesh.triangles) == 0 or not mesh.areas().sum() > 0.0:
        raise SceneError(f"object '{mesh.name}' has no surface to bake")
    reached = min(density, _density_bound(mesh, largest))
    for _ in range(ATTEMPTS):
        uv, width, height, charts = _layout(mesh, reached, margin)
        longest = max(width, height)
        if longest <= largest:
            return AtlasChart(
                uv / np.array([width, height], dtype=np.float64),
                width,
                height,
                reached,
                density,
                charts,
            )
        # The margins do not shrink with the density, so aim a little lower than proportion says.
        reached *= 0.95 * max(largest - 4 * margin, 1) / longest
    raise SceneError(
        f"object '{mesh.name}': {charts} charts do not fit a map of {largest} x {largest} with a margin of {margin}; "
        "raise the largest map or lower the margin"
    )


def _density_bound(mesh: Mesh, largest: int) -> float:
    """Density at which the bare area would fill the map: no layout can be denser."""
    return float(largest / np.sqrt(mesh.areas().sum()))


def _layout(mesh: Mesh, density: float, margin: int):
    """Lay out with xatlas; polygons that it would cut get charts of their own. Returns uv in lumels."""
    uv, width, height, charts = _search_charts(mesh, density, margin)
    broken = _cut_polygons(mesh, uv)
    if not broken.any():
        return uv, width, height, charts
    return _repack(mesh, uv, broken, density, margin)


def _options(density: float, margin: int):
    import xatlas

    packing = xatlas.PackOptions()
    packing.texels_per_unit = float(density)
    packing.resolution = 0
    packing.padding = int(2 * margin)
    packing.bilinear = True
    packing.rotate_charts = True
    return packing


def _search_charts(mesh: Mesh, density: float, margin: int):
    import xatlas

    vertices = (mesh.vertices - mesh.vertices.mean(axis=0)).astype(np.float32)
    atlas = xatlas.Atlas()
    atlas.add_mesh(vertices, mesh.triangles.astype(np.uint32))
    atlas.generate(xatlas.ChartOptions(), _options(density, margin))
    _, indices, uv = atlas[0]
    if atlas.width == 0 or atlas.height == 0:
        raise SceneError(
            f"object '{mesh.name}' could not be unwrapped; check it for degenerate faces"
        )
    scaled = uv.astype(np.float64)[indices] * np.array([atlas.width, atlas.height])
    return scaled, atlas.width, atlas.height, atlas.chart_count


def _cut_polygons(mesh: Mesh, uv: np.ndarray) -> np.ndarray:
    """Triangles of polygons in which one vertex got two places, so that the host's UV map could not hold them. (t,)"""
    broken = np.zeros(len(mesh.triangles), dtype=bool)
    if mesh.polygon is None:
        return broken
    polygon = mesh.polygon
    key = (polygon[:, None].astype(np.int64) * len(mesh.vertices) + mesh.triangles).ravel()
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    flat = uv.reshape(-1, 2)
    differs = np.abs(flat - flat[first[inverse.reshape(-1)]]).max(axis=1) > 1e-3
    cut = np.unique(polygon[np.flatnonzero(differs) // 3])
    return np.isin(polygon, cut)


def _repack(mesh: Mesh, uv: np.ndarray, broken: np.ndarray, density: float, margin: int):
    """Give every cut polygon a planar chart and pack all charts anew."""
    import xatlas

    uv = uv.copy()
    polygon = mesh.polygon
    for number in np.unique(polygon[broken]):
        rows = np.flatnonzero(polygon == number)
        uv[rows] = _project(mesh.vertices[mesh.triangles[rows]]) * density
    corner = np.concatenate(
        [np.where(broken, polygon + 1, 0)[:, None].repeat(3, axis=1)[..., None], np.round(uv, 4)],
        axis=2,
    ).reshape(-1, 3)
    _, first, inverse = np.unique(corner, axis=0, return_index=True, return_inverse=True)
    faces = inverse.reshape(-1, 3).astype(np.uint32)
    points = uv.reshape(-1, 2)[first].astype(np.float32)
    atlas = xatlas.Atlas()
    atlas.add_uv_mesh(points, faces)
    packing = _options(1.0, margin)
    atlas.generate(xatlas.ChartOptions(), packing)
    _, indices, packed = atlas[0]
    scaled = packed.astype(np.float64)[indices] * np.array([atlas.width, atlas.height])
    return scaled, atlas.width, atlas.height, atlas.chart_count


def _project(corners: np.ndarray) -> np.ndarray:
    """Project triangles (n, 3, 3) on their mean plane, true to length. (n, 3, 2) [m]"""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)
    length = np.linalg.norm(normal)
    normal = normal / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    helper = np.eye(3)[np.argmin(np.abs(normal))]
    u = np.cross(helper, normal)
    u /= np.linalg.norm(u)
    flat = (corners - corners.reshape(-1, 3).mean(axis=0)) @ np.stack(
        [u, np.cross(normal, u)], axis=1
    )
    return flat - flat.reshape(-1, 2).min(axis=0)
