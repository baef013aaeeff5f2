"""From meshes to an atlas: charts of every mesh, all together on pages."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ..errors import Cancelled, SceneError
from ..scene.material import Material
from ..scene.mesh import Mesh
from .chart_search import ChartSearch
from .charts import ChartLimits, find_charts
from .layout import Atlas, Charts, SurfaceLayout
from .packing import Packing, pack
from .texture_density import texture_density

FACES = 1_000_000
"""Triangles of all meshes together that xatlas is asked about; the meshes given first have precedence."""

RIGID = 1e-6
"""Share of a mesh's size up to which the corners of two instances may differ after one is turned onto the other."""


MOST_KEPT = 8
"""Instances of one geometry whose charts are kept for others that may stand the same way."""


def lay_out(
    meshes: Sequence[Mesh],
    densities: Sequence[float],
    *,
    largest: int = 2048,
    pages: int = 0,
    margin: int = 4,
    cone: float = 1.0,
    two_sided: Sequence[int] = (),
    materials: Mapping[str, Material] | None = None,
    factors: np.ndarray | None = None,
    charts: Sequence[Charts] | None = None,
    progress: Callable[[int, str], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Atlas:
    """Lay out meshes on the pages of an atlas.

    Parameters
    ----------
    meshes : sequence of Mesh    Every instance by itself.
    densities : sequence of float    Lumels per metre of each mesh.
    largest : int    Side of a page. [lumel]
    pages : int    Most pages; all charts shrink alike to fit. 0: as many as it takes.
    margin : int    Free rim of every chart. [lumel]
    cone : float    Largest angle between a chart's direction and its triangles' normals. [rad]
    two_sided : sequence of int    Places of the meshes whose back sides get charts as well.
    materials : mapping of str to Material, or None
        By id. Meshes then get at least the density of their own pictures.
    factors : (c,) float array or None
        On the density of every chart of the atlas, by their numbers there; None: 1 for all. The numbers do not depend on it.
    charts : sequence of Charts or None
        Of each mesh, as `find_all_charts` gave them before, so that another layout needs no new search.
    progress : callable or None    Told the place and name of every mesh whose charts are looked for.
    cancelled : callable or None    Tells whether the user wants no more.

    Raises
    ------
    SceneError    No mesh has any area, a mesh cannot be read, or the charts cannot fit.
    Cancelled
    """
    if materials is not None:
        densities = [
            max(float(density), texture_density(mesh, materials))
            for mesh, density in zip(meshes, densities, strict=True)
        ]
    if charts is None:
        charts = find_all_charts(
            meshes, densities, cone=cone, progress=progress, cancelled=cancelled
        )
    return arrange(
        meshes,
        charts,
        densities,
        largest=largest,
        pages=pages,
        margin=margin,
        two_sided=two_sided,
        factors=factors,
    )


def find_all_charts(
    meshes: Sequence[Mesh],
    densities: Sequence[float],
    *,
    cone: float = 1.0,
    limits: ChartLimits | None = None,
    progress: Callable[[int, str], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> tuple[Charts, ...]:
    """Find the charts of meshes; instances of one geometry share the search where they only stand elsewhere.

    Parameters and errors are those of `lay_out`.
    """
    limits = limits or ChartLimits()
    found: list[Charts] = []
    kept: dict[tuple, list[tuple[Mesh, Charts]]] = {}
    with ChartSearch(limits.seconds) as search:
        for number, (mesh, density) in enumerate(zip(meshes, densities, strict=True)):
            if cancelled is not None and cancelled():
                raise Cancelled("cancelled")
            if progress is not None:
                progress(number, mesh.name)
            # All meshes live on here, so that no two arrays can come to have the same number.
            known = kept.setdefault((id(mesh.triangles), id(mesh.polygon), float(density)), [])
            charts = next((c for other, c in known if _is_moved(other, mesh)), None)
            if charts is None:
                left = max(FACES - search.faces, 0)
                own = ChartLimits(min(limits.faces, left), limits.seconds)
                charts = find_charts(
                    mesh, cone=cone, density=density, search=search, limits=own, cancelled=cancelled
                )
                known.append((mesh, charts))
                del known[:-MOST_KEPT]
            found.append(charts)
    return tuple(found)


def arrange(
    meshes: Sequence[Mesh],
    charts: Sequence[Charts],
    densities: Sequence[float],
    *,
    largest: int = 2048,
    pages: int = 0,
    margin: int = 4,
    two_sided: Sequence[int] = (),
    factors: np.ndarray | None = None,
) -> Atlas:
    """Place the charts of meshes on pages.

    Parameters
    ----------
    charts : sequence of Charts    Of each mesh.

    The other parameters and the errors are those of `lay_out`; a `ValueError` says that the factors are not as many as the
    charts.
    """
    sides = [(number, False) for number in range(len(meshes))]
    sides += [(number, True) for number in two_sided]
    counts = np.array([len(charts[number].size) for number, _ in sides], dtype=np.int64)
    if not counts.sum():
        raise SceneError("none of the objects has a surface to bake")
    size = np.concatenate([charts[number].size for number, _ in sides])
    density = np.repeat([float(densities[number]) for number, _ in sides], counts)
    if not (np.isfinite(density) & (density > 0.0)).all():
        raise SceneError("the lumels per metre must be a finite number above 0")
    if factors is not None:
        if len(factors) != len(density):
            raise ValueError(f"{len(factors)} factors for {len(density)} charts")
        density = density * factors
    packing = pack(
        size,
        density,
        largest=largest,
        pages=pages,
        margin=margin,
        owner=np.repeat(np.arange(len(sides)), counts),
    )
    starts = np.cumsum(counts) - counts
    layouts, notes = [], []
    for (number, is_back), start, count in zip(sides, starts, counts, strict=True):
        mesh, own = meshes[number], charts[number]
        here = slice(int(start), int(start + count))
        layouts.append(
            SurfaceLayout(
                *_place(own, mesh.polygon, packing, here),
                float(densities[number]),
                is_back,
                number,
            )
        )
        if is_back:
            continue
        notes += [(mesh.name, note) for note in own.notes]
        if count == 0:
            notes.append((mesh.name, "has no surface and gets no map"))
        nowhere = int((own.chart < 0).sum()) if count else 0
        if nowhere:
            notes.append((mesh.name, f"{nowhere} triangles have no area and get no place"))
        too_large = int(packing.cut_down[here].sum())
        if too_large:
            notes.append(
                (
                    mesh.name,
                    f"{too_large} charts are larger than a page and were made coarser to fit",
                )
            )
    return Atlas(packing.sizes, tuple(layouts), int(counts.sum()), packing.shrink, tuple(notes))


def _place(charts: Charts, polygon: np.ndarray | None, packing: Packing, here: slice):
    """Bring a mesh's charts to their places: uv, page, chart and the density that was reached."""
    chart = charts.chart
    if len(charts.size) == 0:
        nowhere = np.full(len(chart), -1, dtype=np.int32)
        return charts.uv, nowhere, nowhere, 0.0
    # Charts fill whole lumels, so that the rim of a wall is not made of partly covered ones.
    scale = packing.lumels[here] / np.where(charts.size > 0.0, charts.size, 1.0)
    home = _find_homes(chart, polygon)
    uv = charts.uv * scale[home][:, None] + packing.place[here][home][:, None]
    uv[home < 0] = 0.0
    shown = chart >= 0
    a, b = charts.uv[:, 1] - charts.uv[:, 0], charts.uv[:, 2] - charts.uv[:, 0]
    area = np.where(shown, 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), 0.0)
    reached = np.sqrt((area * scale.prod(axis=1)[home]).sum() / area.sum())
    number = np.where(shown, chart + here.start, -1).astype(np.int32)
    page = np.where(shown, packing.page[here][chart], -1).astype(np.int32)
    return uv, page, number, float(reached)


def _find_homes(chart: np.ndarray, polygon: np.ndarray | None) -> np.ndarray:
    """Charts on which triangles lie, those without area on their polygon's; -1: none. (t,)"""
    flat = chart < 0
    if polygon is None or not flat.any():
        return chart
    numbers, inverse = np.unique(polygon, return_inverse=True)
    inverse = inverse.reshape(-1)
    of_polygon = np.full(len(numbers), -1, dtype=np.int64)
    of_polygon[inverse[~flat]] = chart[~flat]
    return np.where(flat, of_polygon[inverse], chart)


def _is_moved(mesh: Mesh, other: Mesh) -> bool:
    """Tell whether two meshes with the same triangles differ by a motion alone."""
    a, b = mesh.vertices, other.vertices
    if a.shape != b.shape or len(a) == 0:
        return False
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    left, _, right = np.linalg.svd(a.T @ b)
    turn = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    return bool(np.abs(a @ turn - b).max() <= RIGID * np.abs(b).max())
