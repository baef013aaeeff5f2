"""Charts of a mesh: connected triangles that face one way, each laid flat and true to scale."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..scene.mesh import Mesh
from .chart_fallback import Patches, group_by_normals, halve, project_groups, split_cones
from .chart_search import ChartSearch, Failed
from .layout import Charts
from .outline import find_borders, find_overlapping, find_rectangles, mean_stretch
from .patches import Units, find_units, lay_out_of, narrow, split_apart, unfold
from .topology import Topology, compress, find_topology, largest_by, sum_by

MARGIN = 8.0
"""Free lumels that a chart is supposed to cost along each side when ways of charting are compared."""

MOST_FACES = 200_000
"""Triangles of one mesh that xatlas is asked about: its time grows faster than their number."""

ROUGH_GROUPS = 64
"""Charts to be expected from which on a surface may be too rough for xatlas, whose time grows faster than the charts."""

ROUGH_FACES = 8
"""Triangles per expected chart below which it is."""

UNEVEN = 10.0
"""Charts in which a triangle's scale departs from the mean by more than this factor are not taken."""

SPARSE = 0.35
"""Share of its rectangle that a chart has to fill, or it is cut in two; polygons are not."""

SPARSE_AREA = 64.0**2
"""Rectangles below this area stay as they are. [lumel]"""

NARROWEST_CONE, WIDEST_CONE = 0.05, 1.4
"""Beyond these a cone is not followed. [rad]"""


@dataclass(frozen=True)
class ChartLimits:
    """What the search may cost.

    Parameters
    ----------
    faces : int    Triangles of the mesh that xatlas is asked about; the groups with the fewest go first.
    seconds : float    After which it is killed. [s]
    """

    faces: int = MOST_FACES
    seconds: float = 60.0


def find_charts(
    mesh: Mesh,
    *,
    cone: float = 1.0,
    density: float = 8.0,
    search: ChartSearch | None = None,
    limits: ChartLimits | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Charts:
    """Find the charts of a mesh.

    Surfaces that fit in the cone are projected, each connected part as one chart; the others are cut by their normals
    first. About these xatlas is asked as well, as far as the limits allow, and its charts are taken where they keep the
    rules and need less room. Edges at which the surface bends by more than the cone always part charts. Polygons are never
    cut, so that one UV map with one place per polygon corner can hold the charts.

    Parameters
    ----------
    mesh : Mesh
    cone : float    Largest angle between a chart's mean normal and its triangles' normals; polygons that are bent more, and
        slivers, may break it. [rad]
    density : float    Lumels per metre, by which it is judged what is too small for a chart of its own.
    search : ChartSearch or None    Process to use; None: one for this mesh alone.
    limits : ChartLimits or None    None: the usual ones.
    cancelled : callable or None    Tells whether the user wants no more.

    Raises
    ------
    SceneError    A triangle names a vertex that is not there, or a vertex lies nowhere.
    Cancelled
    """
    topology = find_topology(mesh)
    rows = np.flatnonzero(topology.area > 0.0)
    if len(rows) == 0:
        count = len(topology.area)
        return Charts(np.zeros((count, 3, 2)), np.full(count, -1, np.int32), np.zeros((0, 2)))
    cone = min(max(cone, NARROWEST_CONE), WIDEST_CONE)
    density = max(density, 1e-6)
    units = find_units(topology, cone)
    limits = limits or ChartLimits()
    label, count = group_by_normals(units, units.area > 0.0, cone, density)
    plain = project_groups(units, label, count, cone)
    asked, notes = _choose_for_search(units, label, count, cone, limits)
    if asked is None:
        chosen = plain
    elif search is None:
        with ChartSearch(limits.seconds) as own:
            chosen, failures = _search(units, asked, plain, cone, density, own, limits, cancelled)
            notes += failures
    else:
        chosen, failures = _search(units, asked, plain, cone, density, search, limits, cancelled)
        notes += failures
    first = np.full(units.count, -1, dtype=np.int64)
    first[units.unit] = chosen.chart
    broken = len(np.unique(units.unit[first[units.unit] != chosen.chart]))
    if broken:
        notes.append(
            f"{broken} polygons cannot be laid flat in one piece; each of their triangles has a chart of its own, which a "
            "UV map of the host cannot show"
        )
    chart = _cut_sparse(units, chosen.chart, chosen.uv, cone, density)
    return _finish(units, chart, chosen.uv, tuple(notes))


def _choose_for_search(
    units: Units, label: np.ndarray, count: int, cone: float, limits: ChartLimits
):
    """Choose the surfaces for xatlas: those too bent for one chart, not too many triangles in all, and none too rough.

    Parameters
    ----------
    label : (u,) int64 array    Charts by normals; -1: none.
    count : int    How many.

    Returns
    -------
    (u,) int64 array of surfaces with -1 for the others, or None where there are none; and what there is to be said
    """
    group, groups = split_apart(units, np.where(units.area > 0.0, 0, -1))
    faces = np.bincount(group[units.unit], minlength=groups)
    owner = np.zeros(count, dtype=np.int64)
    owner[label[label >= 0]] = group[label >= 0]
    expected = np.bincount(owner, minlength=groups)
    bent = expected > 1
    rough = bent & (expected > ROUGH_GROUPS) & (faces < ROUGH_FACES * expected)
    notes = []
    if rough.any():
        notes.append(
            f"{int(faces[rough].sum())} triangles are too rough for the search for charts and were cut by their normals"
        )
    bent &= ~rough
    order = np.flatnonzero(bent)[np.argsort(faces[bent], kind="stable")]
    fits = np.cumsum(faces[order]) <= limits.faces
    if not fits.all():
        left = int(faces[order[~fits]].sum())
        notes.append(
            f"{left} triangles are more than the search for charts may be asked about and were cut by their normals"
        )
    bent[order[~fits]] = False
    if not bent.any():
        return None, notes
    return np.where((group >= 0) & bent[group], group, -1), notes


def _search(
    units: Units,
    group: np.ndarray,
    plain: Patches,
    cone: float,
    density: float,
    search: ChartSearch,
    limits: ChartLimits,
    cancelled: Callable[[], bool] | None,
) -> tuple[Patches, list[str]]:
    """Ask xatlas for the charts of groups, and take its charts for those groups where they need less room."""
    topology = units.topology
    here = np.flatnonzero(group[units.unit] >= 0)
    here = here[np.argsort(group[units.unit[here]], kind="stable")]
    owner = compress(group[units.unit[here]])[0]
    rows = units.rows[here]
    faces = np.bincount(owner)
    # Each group has vertices of its own and a size of its own: xatlas counts areas below a fixed one as nothing.
    span = int(topology.vertex.max()) + 1
    _, first, number = np.unique(
        (owner[:, None] * span + topology.vertex[rows]).ravel(),
        return_index=True,
        return_inverse=True,
    )
    corners = topology.corners[rows]
    edge = np.sqrt(sum_by(owner, topology.area[rows], len(faces)) / faces)
    points = corners.reshape(-1, 3)[first]
    holder = np.repeat(owner, 3)[first]
    centre = sum_by(holder, points, len(faces)) / np.bincount(holder)[:, None]
    points = (points - centre[holder]) / edge[holder][:, None]
    found = search.find(
        points.astype(np.float32),
        number.reshape(-1, 3).astype(np.uint32),
        faces,
        limits.seconds,
        cancelled,
    )
    if isinstance(found, Failed):
        note = (
            f"the search for charts {found.reason}; {len(rows)} triangles were cut by their normals"
        )
        return plain, [note]
    chart = np.full(len(units.rows), -1, dtype=np.int64)
    uv = np.zeros((len(units.rows), 3, 2))
    chart[here] = found.chart
    uv[here] = found.uv * edge[owner][:, None, None]
    taken = _take(units, group >= 0, chart, uv, cone)
    # What xatlas left, or what of its charts cannot be used.
    rest = group >= 0
    rest[units.unit[taken.chart >= 0]] = False
    label, count = group_by_normals(units, rest, cone, density)
    filled = project_groups(units, label, count, cone)
    made = _join(taken, filled, taken.chart < 0)
    better = _measure_room(units, made, group, density) < _measure_room(
        units, plain, group, density
    )
    return _join(plain, made, (group >= 0)[units.unit] & better[group[units.unit]]), []


def _join(first: Patches, second: Patches, takes_second: np.ndarray) -> Patches:
    """Take the second charts for some rows, the first for the others; none may lie on both. (r,) bool"""
    return Patches(
        np.where(takes_second & (second.chart >= 0), first.count + second.chart, first.chart),
        np.where(takes_second[:, None, None], second.uv, first.uv),
        first.count + second.count,
    )


def _measure_room(units: Units, patches: Patches, group: np.ndarray, density: float) -> np.ndarray:
    """Lumels of the rectangles of groups' charts, with a margin that small charts pay for. (g,)"""
    here = np.flatnonzero(group[units.unit] >= 0)
    owner = group[units.unit[here]]
    chart, count = compress(patches.chart[here])
    uv = patches.uv[here]
    # Both ways of charting are compared at the surface's own scale.
    flat = sum_by(chart, _areas(uv), count)
    area = sum_by(chart, units.topology.area[units.rows[here]], count)
    scale = np.sqrt(area / np.where(flat > 0.0, flat, 1.0))
    turned = _turn(uv, units.topology.vertex[units.rows[here]], chart, count)
    size = _bounds(turned, chart, count)[1] * (scale * density)[:, None] + MARGIN
    holder = np.zeros(count, dtype=np.int64)
    holder[chart] = owner
    return np.bincount(holder, size[:, 0] * size[:, 1], minlength=int(group.max()) + 1)


def _take(units: Units, asked: np.ndarray, chart, uv, cone: float) -> Patches:
    """Keep polygons whole and charts in the cone, and drop charts that overlap or are stretched beyond use."""
    topology = units.topology
    uv = uv.copy()
    label, moved = _keep_units_whole(units, asked, chart, uv)
    label, count = split_apart(units, label)
    for attempt in range(2):
        label, count = split_cones(narrow(units, label >= 0), label, count, cone)
        here = np.flatnonzero(label[units.unit] >= 0)
        owner, rows = label[units.unit[here]], units.rows[here]
        faulty = find_overlapping(uv[here], topology.vertex[rows], owner, count)
        faulty |= _find_uneven(topology, rows, uv[here], owner, count)
        if not faulty.any():
            break
        bad = np.where(label >= 0, faulty[label], False)
        # At first only what was moved to another chart's border has to go.
        label = np.where(bad & (moved if attempt == 0 else True), -1, label)
        label, count = split_apart(units, label)
    made = label[units.unit]
    return Patches(made, uv, count)


def _keep_units_whole(units: Units, asked, chart, uv):
    """Move the triangles of cut polygons to the chart that holds most of them, unfolded at its border; ``uv`` in place.

    Returns
    -------
    (u,) int64 array of charts, -1: none, and (u,) bool array of units of which something was moved
    """
    topology = units.topology
    held = np.flatnonzero(chart >= 0)
    count = int(chart.max(initial=0)) + 1
    key, inverse = np.unique(units.unit[held] * count + chart[held], return_inverse=True)
    area = np.bincount(inverse.reshape(-1), topology.area[units.rows[held]])
    order = np.argsort(area, kind="stable")
    label = np.full(units.count, -1, dtype=np.int64)
    # Of several writes to one place the last counts: the largest part.
    label[key[order] // count] = key[order] % count
    label[~asked] = -1
    target = label[units.unit]
    stray = (target >= 0) & (chart != target)
    moved = np.zeros(units.count, dtype=bool)
    moved[units.unit[stray]] = True
    if not stray.any():
        return label, moved
    rows = np.flatnonzero(target >= 0)
    span = int(topology.vertex.max()) + 1
    keys, slot = np.unique(
        (target[rows][:, None] * span + topology.vertex[units.rows[rows]]).ravel(),
        return_inverse=True,
    )
    slot = slot.reshape(-1, 3)
    known, place = np.zeros(len(keys), dtype=bool), np.zeros((len(keys), 2))
    stays = ~stray[rows]
    place[slot[stays]] = uv[rows[stays]]
    known[slot[stays]] = True
    unfold(topology.corners[units.rows[rows[~stays]]], slot[~stays], known, place)
    reached = known[slot].all(axis=1)
    label[units.unit[rows[~reached]]] = -1
    uv[rows] = place[slot]
    return label, moved


def _find_uneven(topology: Topology, rows, uv, owner, count: int) -> np.ndarray:
    """Charts in which some triangle's scale is far from the mean. (count,)"""
    flat = _areas(uv)
    area = topology.area[rows]
    total = sum_by(owner, area, count)
    scale = sum_by(owner, flat, count) / np.where(total > 0.0, total, 1.0)
    share = flat / (area * np.where(scale > 0.0, scale, 1.0)[owner])
    uneven = topology.is_reliable[rows] & ((share * UNEVEN < 1.0) | (share > UNEVEN))
    found = scale <= 0.0
    found[owner[uneven]] = True
    return found


def _areas(uv: np.ndarray) -> np.ndarray:
    a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    return 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _bounds(uv: np.ndarray, chart: np.ndarray, count: int):
    """Lower corners and sizes of charts. (count, 2), (count, 2)"""
    low = np.stack(
        [-largest_by(chart, -uv[:, :, k].min(axis=1), count, -np.inf) for k in range(2)], axis=1
    )
    high = np.stack(
        [largest_by(chart, uv[:, :, k].max(axis=1), count, -np.inf) for k in range(2)], axis=1
    )
    return low, high - low


def _turn(uv: np.ndarray, vertex: np.ndarray, chart: np.ndarray, count: int) -> np.ndarray:
    """Turn charts so that their smallest rectangles lie along the axes, long side along x."""
    angle = find_rectangles(find_borders(uv, vertex, chart)[0], count)
    cos, sin = np.cos(angle)[chart][:, None], np.sin(angle)[chart][:, None]
    return np.stack(
        [uv[..., 0] * cos + uv[..., 1] * sin, uv[..., 1] * cos - uv[..., 0] * sin], axis=2
    )


def _cut_sparse(
    units: Units, chart: np.ndarray, uv: np.ndarray, cone: float, density: float
) -> np.ndarray:
    """Cut charts across that fill little of a large rectangle, such as frames and corridors round a court. (r,)"""
    topology = units.topology
    vertex, area = topology.vertex[units.rows], topology.area[units.rows]
    for _ in range(8):
        chart, count = compress(chart)
        label = np.full(units.count, -1, dtype=np.int64)
        label[units.unit] = chart
        # A polygon whose triangles lie apart belongs to no single chart.
        whole = np.ones(units.count, dtype=bool)
        whole[units.unit[label[units.unit] != chart]] = False
        several = np.bincount(label[(label >= 0) & whole], minlength=count) > 1
        filled = sum_by(chart, area, count)
        # The smallest rectangle is no larger than the one that the chart has as it lies.
        if not (several & _find_sparse(uv, chart, filled, density)).any():
            break
        turned = _turn(uv, vertex, chart, count)
        sparse = several & _find_sparse(turned, chart, filled, density)
        members = np.flatnonzero((label >= 0) & whole)
        members = members[sparse[label[members]]]
        if len(members) == 0:
            break
        middle = sum_by(units.unit, turned[..., 0].mean(axis=1) * area, units.count)
        middle /= np.where(units.area > 0.0, units.area, 1.0)
        label[~whole] = -1
        label, parts = split_apart(units, halve(label, members, middle[members]))
        # A part has a direction of its own, from which more may turn away.
        label, parts = split_cones(narrow(units, label >= 0), label, parts, cone)
        chart = np.where(whole[units.unit], label[units.unit], parts + chart)
    return chart


def _find_sparse(uv, chart, filled: np.ndarray, density: float) -> np.ndarray:
    """Charts whose area is a small share of a large upright rectangle. (count,)"""
    box = _bounds(uv, chart, len(filled))[1].prod(axis=1)
    return (filled < SPARSE * box) & (box * density**2 > SPARSE_AREA)


def _finish(units: Units, chart: np.ndarray, uv: np.ndarray, notes: tuple[str, ...]) -> Charts:
    """Make charts true to scale, turn them and bring them to the origin."""
    topology = units.topology
    rows = units.rows
    chart, count = compress(chart)
    area = topology.area[rows]
    weight = np.where(topology.is_reliable[rows], area, 0.0)
    # What projection or xatlas stretched one way is shrunk that way again: a linear map, so nothing comes to overlap.
    stretch = mean_stretch(lay_out_of(topology.corners[rows]), uv, weight, chart, count)
    value, axes = np.linalg.eigh(stretch)
    value = np.maximum(value, 1e-6 * value[:, 1:])
    undo = np.einsum("cik,ck,cjk->cij", axes, 1.0 / np.sqrt(np.where(value > 0, value, 1)), axes)
    uv = np.einsum("tci,tij->tcj", uv, undo[chart])
    flat = sum_by(chart, _areas(uv), count)
    scale = np.sqrt(sum_by(chart, area, count) / np.where(flat > 0.0, flat, 1.0))
    scale = np.where(flat > 0.0, scale, 1.0)
    uv = _turn(uv * scale[chart][:, None, None], topology.vertex[rows], chart, count)
    low, size = _bounds(uv, chart, count)
    uv -= low[chart][:, None]

    whole = np.zeros((len(topology.area), 3, 2))
    number = np.full(len(topology.area), -1, dtype=np.int32)
    whole[rows] = uv
    number[rows] = chart
    _place_flat_triangles(units, whole, number, size)
    return Charts(whole, number, np.maximum(size, 0.0), notes)


def _place_flat_triangles(units: Units, uv, chart, size) -> None:
    """Give triangles without area the places of their polygon's corners, so that its UV map stays whole; in place."""
    topology = units.topology
    flat = np.flatnonzero((chart < 0) & (units.area[topology.unit] > 0.0))
    if len(flat) == 0:
        return
    concerned = np.zeros(units.count, dtype=bool)
    concerned[topology.unit[flat]] = True
    all_rows = np.flatnonzero(concerned[topology.unit])
    span = int(topology.vertex.max()) + 1
    keys, slot = np.unique(
        (topology.unit[all_rows][:, None] * span + topology.vertex[all_rows]).ravel(),
        return_inverse=True,
    )
    slot = slot.reshape(-1, 3)
    known, place = np.zeros(len(keys), dtype=bool), np.zeros((len(keys), 2))
    has = chart[all_rows] >= 0
    place[slot[has]] = uv[all_rows[has]]
    known[slot[has]] = True
    owner = np.zeros(units.count, dtype=np.int64)
    owner[topology.unit[all_rows[has]]] = chart[all_rows[has]]
    unfold(topology.corners[all_rows[~has]], slot[~has], known, place)
    limit = size[owner[topology.unit[all_rows[~has]]]][:, None]
    uv[all_rows[~has]] = np.clip(place[slot[~has]], 0.0, limit)
