"""Light that must not leak, charts that must meet, and geometry that must not break a bake."""

from collections.abc import Callable

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.baking.order import BakeOrder, BakeResult
from ...engine.errors import LumenrayError
from ...engine.scene.light import Output, PointLight, Quantity, SunLight, UniformWorld
from ...engine.scene.material import Black, Diffuse, Material
from ...engine.scene.mesh import Mesh
from ...engine.scene.scene import SceneDelta
from ...engine.scene.spectrum import Constant
from ...engine.session import Session
from ..common.pieces import box, grid, make_mesh, quad
from .lumels import find_places

SEED = 401

WHITE = Material("white", "white", Diffuse(Constant(0.7)))

# ---- leaks ----

WALLS = (0.2, 0.05, 0.002)
"""Thickness of walls that must keep light out. [m]"""

SAMPLES = 256
"""Per lumel."""


def measure_leaks(say) -> list[dict]:
    """Bake what is dark beside what is lit.

    Returns
    -------
    list of dict    ``case``, ``lit``: mean of the lit side [lx], ``dark``: mean, and ``largest``: largest value of the dark
        side over the mean of the lit one [-], ``lumels`` of the dark side.
    """
    rows = [_box_in_box(thickness) for thickness in WALLS]
    rows += [_floor_under_wall(thickness) for thickness in WALLS[:2]]
    for row in rows:
        shares = f"{100 * row['dark']:.4f} % of the lit side, at most {100 * row['largest']:.3f} %"
        say(f"leak, {row['case']}: {shares}")
    return rows


def _box_in_box(thickness: float) -> dict:
    """Closed box with walls, inside a larger one; lamps shine into the gap between the two."""
    outer = make_mesh("outer", [box((0, 0, 0), (3, 3, 3), inwards=True)], "white")
    low, high = np.full(3, 0.8), np.full(3, 2.2)
    shell = make_mesh("shell", [box(low, high)], "white")
    inside = make_mesh("inside", [box(low + thickness, high - thickness, inwards=True)], "white")
    lamps = [_point(f"lamp {k}", (0.4, 0.4 + 2.2 * k, 1.5), 1000.0) for k in (0, 1)]
    result, _ = _bake((WHITE, outer, shell, inside, *lamps), ("shell", "inside"), 10.0)
    lit, dark = (result.lumels(made.number) for made in result.maps)
    return _leak(f"box in a box, walls of {1e3 * thickness:g} mm", lit, dark.illuminance, dark.area)


def _floor_under_wall(thickness: float) -> dict:
    """One floor under two rooms, one lit and one dark, with a wall on it that its lumels run under."""
    floor = make_mesh("floor", [quad((0, 0, 0), (4, 0, 0), (0, 3, 0))], "white")
    room = make_mesh("room", [box((0, 0, -0.3), (4, 3, 2.5), inwards=True)], "white")
    middle = 2.03
    wall = make_mesh("wall", [box((middle, -0.1, -0.2), (middle + thickness, 3.1, 2.6))], "white")
    lamp = _point("lamp", (1.0, 1.5, 2.0), 2000.0)
    result, session = _bake((WHITE, floor, room, wall, lamp), ("floor",), 8.0)
    places = find_places(result, {"floor": session.scene.mesh("floor")})
    x = places.positions[:, 0]
    nearest = np.minimum.reduceat(x, places.start)
    values = places.values(result)
    # Lumels all of which lies behind the wall.
    is_dark = nearest > middle + thickness
    is_lit = np.maximum.reduceat(x, places.start) < middle
    lit_mean = float(np.average(values[is_lit], weights=places.area[is_lit]))
    dark = values[is_dark]
    return {
        "case": f"floor that runs on under a wall of {1e3 * thickness:g} mm",
        "lit": lit_mean,
        "dark": float(np.average(dark, weights=places.area[is_dark])) / lit_mean,
        "largest": float(dark.max()) / lit_mean,
        "lumels": len(dark),
    }


def _leak(case: str, lit, dark, area) -> dict:
    mean = float(np.average(lit.illuminance, weights=lit.area))
    return {
        "case": case,
        "lit": mean,
        "dark": float(np.average(dark, weights=area)) / mean,
        "largest": float(dark.max()) / mean,
        "lumels": len(dark),
    }


# ---- seams ----

SIDES, HEIGHT = 48, 2.0
"""Of the cylinder: facets, and its height with a radius of half a metre. [m]"""

PLACES_ALONG = 9
"""Places on every edge between two charts at which both are read."""

SEAM_ERRORS = (0.02, 0.005)
"""Relative errors at which seams are looked at. [-]"""


def measure_seams(say) -> list[dict]:
    """Bake a smooth cylinder under an even sky and a sun, and read it on both sides of every border of charts.

    What is read is what a viewer would show: bilinear between lumels, gutters included.

    Returns
    -------
    list of dict    ``error``, ``places``, ``step``: root mean square of the steps [lx], ``noise``: of their standard errors
        [lx], ``mean`` [lx], ``charts``, and ``before``, ``after``, ``told_noise``: what the result says itself [lx].
    """
    rows = []
    for error in SEAM_ERRORS:
        cylinder = _cylinder()
        items = (
            WHITE,
            cylinder,
            UniformWorld(200.0),
            SunLight(
                "sun",
                "sun",
                Output(Quantity.ILLUMINANCE, 1500.0),
                np.array([-0.8, -0.3, -0.52]) / np.linalg.norm([0.8, 0.3, 0.52]),
                np.radians(0.53),
            ),
        )
        result, session = _bake(items, (cylinder.id,), 24.0, StopRule(error=error))
        row = _read_seams(result, session.scene.mesh(cylinder.id))
        row["error"] = error
        rows.append(row)
        say(f"seams at {100 * error:g} %: step {row['step']:.2f} lx, noise {row['noise']:.2f} lx")
    return rows


def _cylinder() -> Mesh:
    """Open cylinder, smooth, seen from outside, whose first and last facets share their vertices."""
    angles = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)
    levels = 9
    around = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    heights = np.linspace(0.0, HEIGHT, levels)
    vertices = np.concatenate([np.column_stack([0.5 * around, np.full(SIDES, z)]) for z in heights])
    level, side = np.divmod(np.arange(SIDES * (levels - 1)), SIDES)
    a, b = level * SIDES + side, level * SIDES + (side + 1) % SIDES
    triangles = np.concatenate(
        [np.stack([a, b, b + SIDES], axis=1), np.stack([a, b + SIDES, a + SIDES], axis=1)]
    )
    normals = np.column_stack([np.tile(around, (levels, 1)), np.zeros(SIDES * levels)])
    return make_mesh(
        "cylinder", [(vertices, triangles)], "white", normals[triangles].astype(np.float32)
    )


def _read_seams(result: BakeResult, mesh: Mesh) -> dict:
    (made,) = result.maps
    first, second = _shared_edges(mesh.triangles)
    layout = made.layout
    page = layout.page
    chart = _chart_of(result, layout)
    borders = (chart[first[:, 0]] != chart[second[:, 0]]) & (page[first[:, 0]] >= 0)
    borders &= page[second[:, 0]] >= 0
    steps, noises = [], []
    for share in (np.arange(PLACES_ALONG) + 0.5) / PLACES_ALONG:
        sides = [_bilinear(result, layout, rows[borders], share) for rows in (first, second)]
        steps.append(sides[0][0] - sides[1][0])
        noises.append(np.hypot(sides[0][1], sides[1][1]))
    step, noise = np.concatenate(steps), np.concatenate(noises)
    return {
        "places": len(step),
        "step": _root_mean_square(step),
        "noise": _root_mean_square(noise),
        "mean": made.mean,
        "charts": made.charts,
        "before": result.seams.before,
        "after": result.seams.after,
        "told_noise": result.seams.noise,
    }


def _shared_edges(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges of two triangles: (triangle, first corner, second corner) on both sides, running the same way. (e, 3) each"""
    corner = np.tile([[0, 1], [1, 2], [2, 0]], (len(triangles), 1))
    owner = np.repeat(np.arange(len(triangles)), 3)
    ends = triangles[owner[:, None], corner]
    turned = ends[:, 0] > ends[:, 1]
    corner[turned] = corner[turned][:, ::-1]
    ends = np.sort(ends, axis=1)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    ends, owner, corner = ends[order], owner[order], corner[order]
    pair = np.flatnonzero((ends[1:] == ends[:-1]).all(axis=1))
    rows = np.column_stack([owner, corner])
    return rows[pair], rows[pair + 1]


def _chart_of(result: BakeResult, layout) -> np.ndarray:
    """Chart of every triangle, read from its page at its middle; -1 where it has no place. (t,)"""
    made = np.full(len(layout.page), -1)
    for page in result.pages:
        rows = np.flatnonzero(layout.page == page.number)
        middle = layout.uv[rows].mean(axis=1) * [page.width, page.height]
        x = np.clip(middle[:, 0].astype(int), 0, page.width - 1)
        y = np.clip(middle[:, 1].astype(int), 0, page.height - 1)
        made[rows] = page.chart[y, x]
    return made


def _bilinear(result: BakeResult, layout, edges: np.ndarray, share: float):
    """Illuminance and standard error at a place on edges, read as a viewer does. (e,), (e,)"""
    triangle, one, two = edges.T
    uv = (1.0 - share) * layout.uv[triangle, one] + share * layout.uv[triangle, two]
    value, square = np.zeros(len(edges)), np.zeros(len(edges))
    for page in result.pages:
        mine = layout.page[triangle] == page.number
        place = uv[mine] * [page.width, page.height] - 0.5
        low = np.floor(place).astype(int)
        rest = place - low
        for dx in (0, 1):
            for dy in (0, 1):
                x = np.clip(low[:, 0] + dx, 0, page.width - 1)
                y = np.clip(low[:, 1] + dy, 0, page.height - 1)
                weight = np.abs(1 - dx - rest[:, 0]) * np.abs(1 - dy - rest[:, 1])
                value[mine] += weight * page.illuminance[y, x]
                square[mine] += (weight * page.standard_error[y, x]) ** 2
    return value, np.sqrt(square)


def _root_mean_square(values) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else 0.0


# ---- hard geometry ----

SKY = 100.0
"""Luminance all around, under which every flat surface has pi times as many lux on either side. [cd/m2]"""

HARD_SAMPLES = 4096
"""Per lumel, so that chance is small beside what a fault would do."""

Case = tuple[Mesh, float]
"""A mesh, and lumels per metre."""


def _patch(columns: int = 8, rows: int = 8, size: float = 1.0):
    return grid((0, 0, 0), (size, 0, 0), (0, size, 0), columns, rows)


def _plain_patch() -> Case:
    return make_mesh("patch", [_patch()], "black"), 16.0


def _t_vertices() -> Case:
    """Two halves with different division, whose common edge has vertices of one in the middle of edges of the other."""
    left = grid((0, 0, 0), (0.5, 0, 0), (0, 1, 0), 3, 4)
    right = grid((0.5, 0, 0), (0.5, 0, 0), (0, 1, 0), 3, 7)
    return make_mesh("t-vertices", [left, right], "black"), 16.0


def _slivers() -> Case:
    """Patch with strips a millionth of a metre wide between its columns."""
    edges = np.sort(np.concatenate([np.linspace(0, 1, 9), np.linspace(0, 1, 9)[1:-1] + 1e-6]))
    vertices, triangles = _patch(len(edges) - 1, 8)
    vertices[:, 0] = np.tile(edges, 9)
    return make_mesh("slivers", [(vertices, triangles)], "black"), 16.0


def _coincident() -> Case:
    return make_mesh("coincident", [_patch(), _patch()], "black"), 16.0


def _zero_area() -> Case:
    """Patch with triangles whose corners are one point or lie on a line."""
    vertices, triangles = _patch()
    flat = np.array([[0, 0, 0], [0, 1, 2], [3, 3, 4], [10, 11, 12]])
    return make_mesh("zero area", [(vertices, np.concatenate([triangles, flat]))], "black"), 16.0


def _flipped() -> Case:
    vertices, triangles = _patch()
    triangles = triangles.copy()
    triangles[::2] = triangles[::2, ::-1]
    return make_mesh("flipped", [(vertices, triangles)], "black"), 16.0


def _far() -> Case:
    vertices, triangles = _patch()
    vertices += np.array([1e4, -1e4, 1e4])
    return make_mesh("far", [(vertices, triangles)], "black"), 16.0


def _small() -> Case:
    return make_mesh("small", [_patch(size=1e-3)], "black"), 16_000.0


def _many_edges() -> Case:
    """Three sheets that meet in one edge, so that it has more than two triangles."""
    sheets = [
        grid((0, 0, 0), u, (0, 1, 0), 4, 4)
        for u in ((0.5, 0, 0), (-0.25, 0, 0.43), (-0.25, 0, -0.43))
    ]
    vertices = np.concatenate([part[0] for part in sheets])
    _, first, number = np.unique(
        np.round(vertices, 9), axis=0, return_index=True, return_inverse=True
    )
    triangles = np.concatenate([part[1] + 25 * k for k, part in enumerate(sheets)])
    return make_mesh("three sheets", [(vertices[first], number.ravel()[triangles])], "black"), 16.0


CASES: dict[str, tuple[str, Callable[[], Case]]] = {
    "plain": ("plain patch, for comparison", _plain_patch),
    "t": ("T-vertices", _t_vertices),
    "slivers": ("slivers of 1e-6 m", _slivers),
    "coincident": ("coincident faces", _coincident),
    "zero": ("triangles without area", _zero_area),
    "flipped": ("every other normal flipped", _flipped),
    "far": ("1e4 m from the origin", _far),
    "small": ("1e-3 m large", _small),
    "edges": ("edges of three sheets", _many_edges),
}
"""Title and mesh of every case."""

OPEN = ("edges",)
"""Cases that see themselves, so that their illuminance is not that of the sky alone."""


def measure_hard_cases(say) -> list[dict]:
    """Bake hard geometry that absorbs everything under an even sky.

    Returns
    -------
    list of dict    ``case``, ``triangles``, ``lumels``, ``charts``, ``not_finite``: numbers that are none, ``area``: share
        of the true surface that is on the maps [-], ``low``, ``high``: extremes over the exact value (None where it is not
        known) [-], ``reported``: what the result says; or ``failure``.
    """
    rows = []
    for key, (title, build) in CASES.items():
        mesh, density = build()
        row = {"case": title, "triangles": len(mesh.triangles)}
        try:
            row |= _bake_case(mesh, density, key in OPEN)
        except LumenrayError as error:
            row["failure"] = str(error)
        rows.append(row)
        say(f"{title}: {row.get('failure') or str(row['lumels']) + ' lumels'}")
    return rows


def _bake_case(mesh: Mesh, density: float, sees_itself: bool) -> dict:
    black = Material("black", "black", Black())
    rule = StopRule(samples=HARD_SAMPLES)
    result, _ = _bake((black, mesh, UniformWorld(SKY)), (mesh.id,), density, rule)
    (made,) = result.maps
    values = result.lumels(made.number)
    pages = [array for page in result.pages for array in (page.illuminance, page.standard_error)]
    exact = np.pi * SKY
    return {
        "lumels": made.lumels,
        "charts": made.charts,
        "not_finite": int(sum((~np.isfinite(array)).sum() for array in pages)),
        "area": float(values.area.sum(dtype=np.float64) / mesh.areas().sum()),
        "low": None if sees_itself else float(values.illuminance.min()) / exact,
        "high": None if sees_itself else float(values.illuminance.max()) / exact,
        "reported": [f"{row.message}; {row.remedy}" for row in result.departures],
    }


# ---- common ----


def _point(name: str, position, lumens: float) -> PointLight:
    output = Output(Quantity.LUMINOUS_FLUX, lumens)
    return PointLight(name, name, output, np.array(position, dtype=np.float64), 0.02)


def _bake(items, objects, density: float, rule: StopRule | None = None):
    """Result, and the session that made it."""
    session = Session(witness=False)
    session.apply(SceneDelta(changed=tuple(items)))
    rule = rule or StopRule(samples=SAMPLES)
    order = BakeOrder(tuple(objects), rule, density=density, seed=SEED)
    return session.bake_objects(order), session
