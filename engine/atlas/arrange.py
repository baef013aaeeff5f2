"""From meshes to an atlas: charts of every mesh, all together on pages."""

from collections.abc import Callable, Sequence

import numpy as np

from ..errors import Cancelled, SceneError
from ..scene.mesh import Mesh
from .chart_search import ChartSearch
from .charts import ChartLimits, find_charts
from .layout import Atlas, Charts, SurfaceLayout
from .packing import Packing, pack

FACES = 1_000_000
"""Triangles of all meshes together that xatlas is asked about; the meshes given first have precedence."""

RIGID = 1e-6
"""Share of a mesh's size up to which the corners of two instances may differ after one is turned onto the other."""


MOST_KEPT = 8
"""Instances of one geometry whose charts are kept for others that may stand the same way."""


def find_all_charts(
    meshes: Sequence[Mesh],
    densities: Sequence[float],
    *,
    cone: float = 1.0,
    progress: Callable[[int, str], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> tuple[Charts, ...]:
    """Find the charts of meshes; instances of one geometry share the search where they only stand elsewhere.

    Parameters
    ----------
    meshes : sequence of Mesh    Every instance by itself.
    densities : sequence of float    Lumels per metre of each mesh.
    cone : float    Largest angle between a chart's direction and its triangles' normals. [rad]
    progress : callable or None    Told the place and name of every mesh whose charts are looked for.
    cancelled : callable or None    Tells whether the user wants no more.

    Raises
    ------
    SceneError    A mesh cannot be read.
    Cancelled
    """
    limits = ChartLimits()
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
    meshes : sequence of Mesh    Every instance by itself.
    charts : sequence of Charts    Of each mesh, as of `find_all_charts`.
    densities : sequence of float    Lumels per metre of each mesh.
    largest : int    Side of a page. [lumel]
    pages : int    Most pages; all charts shrink alike to fit. 0: as many as it takes.
    margin : int    Free rim of every chart. [lumel]
    two_sided : sequence of int    Places of the meshes whose back sides get charts as well.
    factors : (c,) float array or None
        On the density of every chart of the atlas, by their numbers there; None: 1 for all. The numbers do not depend on it.

    Raises
    ------
    SceneError    No mesh has any area, or the charts cannot fit.
    ValueError    The factors are not as many as the charts.
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
        if not is_back:
            notes += [(mesh.name, note) for note in _notes(own, packing.cut_down[here])]
    return Atlas(packing.sizes, tuple(layouts), int(counts.sum()), packing.shrink, tuple(notes))


def _notes(charts: Charts, cut_down: np.ndarray):
    """Say what is odd about the charts of a mesh. ``cut_down``: (c,) whether each is coarser than it should be."""
    yield from charts.notes
    if not len(cut_down):
        yield "has no surface and gets no map"
        return
    nowhere = int((charts.chart < 0).sum())
    if nowhere:
        yield f"{nowhere} triangles have no area and get no place"
    too_large = int(cut_down.sum())
    if too_large:
        yield f"{too_large} charts are larger than a page and were made coarser to fit"


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
