"""From meshes to an atlas: charts of every mesh, all together on pages."""

from collections.abc import Callable, Sequence

import numpy as np

from ..errors import Cancelled, SceneError
from ..scene.mesh import Mesh
from .chart_search import ChartSearch
from .charts import MOST_FACES, ChartLimits, find_charts
from .layout import Atlas, Charts, SurfaceLayout
from .packing import pack

FACES = 1_000_000
"""Triangles of all meshes together that xatlas is asked about; the meshes given first have precedence."""

RIGID = 1e-6
"""Share of a mesh's size up to which the corners of two instances may differ after one is turned onto the other."""


def lay_out(
    meshes: Sequence[Mesh],
    densities: Sequence[float],
    *,
    largest: int = 2048,
    pages: int = 0,
    margin: int = 4,
    cone: float = 1.0,
    two_sided: Sequence[int] = (),
    progress: Callable[[int, int], None] | None = None,
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
    progress : callable or None    Told how many meshes are done, and of how many.
    cancelled : callable or None    Tells whether the user wants no more.

    Raises
    ------
    SceneError    No mesh has any area, or the charts cannot fit.
    Cancelled
    """
    charts = find_all_charts(meshes, densities, cone=cone, progress=progress, cancelled=cancelled)
    return arrange(
        meshes, charts, densities, largest=largest, pages=pages, margin=margin, two_sided=two_sided
    )


def find_all_charts(
    meshes: Sequence[Mesh],
    densities: Sequence[float],
    *,
    cone: float = 1.0,
    limits: ChartLimits | None = None,
    progress: Callable[[int, int], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> tuple[Charts, ...]:
    """Find the charts of meshes; instances of one geometry share the search where they only stand elsewhere.

    Parameters and errors are those of `lay_out`.
    """
    limits = limits or ChartLimits(MOST_FACES)
    left = FACES
    found: list[Charts] = []
    kept: dict[tuple, list[tuple[Mesh, Charts]]] = {}
    with ChartSearch(limits.seconds) as search:
        for number, (mesh, density) in enumerate(zip(meshes, densities, strict=True)):
            if cancelled is not None and cancelled():
                raise Cancelled("the bake was cancelled")
            # The meshes are kept too, so that no other array can come to have the same number.
            known = kept.setdefault((id(mesh.triangles), id(mesh.polygon), float(density)), [])
            charts = next((c for other, c in known if _is_moved(other, mesh)), None)
            if charts is None:
                own = ChartLimits(min(limits.faces, left), limits.seconds)
                charts = find_charts(
                    mesh, cone=cone, density=density, search=search, limits=own, cancelled=cancelled
                )
                left -= min(len(mesh.triangles), left)
                known.append((mesh, charts))
            found.append(charts)
            if progress is not None:
                progress(number + 1, len(meshes))
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
    factors : (c,) float array or None
        On the density of every chart of the atlas, by their numbers there; None: 1 for all. The numbers do not depend on it.

    The other parameters and the errors are those of `lay_out`.
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
        layouts.append(_place(own, packing, here, float(densities[number]), is_back, number))
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
                (mesh.name, f"{too_large} charts are larger than a page and were made coarser to fit")
            )
    return Atlas(
        packing.sizes, tuple(layouts), int(counts.sum()), packing.shrink, tuple(notes)
    )


def _place(charts: Charts, packing, here: slice, density: float, is_back: bool, mesh: int):
    """Bring a mesh's charts to their places."""
    chart = charts.chart
    if len(charts.size) == 0:
        nowhere = np.full(len(chart), -1, dtype=np.int32)
        return SurfaceLayout(charts.uv, nowhere, nowhere, density, density, is_back, mesh)
    lumels, place = packing.lumels[here], packing.place[here]
    # Charts fill whole lumels: a wall has no partly covered ones.
    extent = np.where(charts.size > 0.0, charts.size, 1.0)
    scale = lumels / extent
    # Triangles without area lie where their polygon's chart does; without one they lie nowhere.
    home = _find_homes(charts)
    uv = charts.uv * scale[home][:, None] + place[home][:, None]
    uv[home < 0] = 0.0
    a, b = charts.uv[:, 1] - charts.uv[:, 0], charts.uv[:, 2] - charts.uv[:, 0]
    area = np.where(chart >= 0, 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), 0.0)
    reached = np.sqrt((area * scale.prod(axis=1)[home]).sum() / max(float(area.sum()), 1e-300))
    number = np.where(chart >= 0, chart + here.start, -1).astype(np.int32)
    page = np.where(chart >= 0, packing.page[here][chart], -1).astype(np.int32)
    return SurfaceLayout(uv, page, number, float(reached), density, is_back, mesh)
