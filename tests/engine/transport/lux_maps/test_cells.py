"""Cells of matt surfaces: how they divide triangles, and the light that sweeps find on them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from baking_rooms import lamp, moved
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.scene.light import Output, PointLight, Quantity, UniformWorld
from lumenray.engine.scene.material import Coated, Emission, Material
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.spectrum import Constant

pytestmark = pytest.mark.mitsuba


def prepare(*items, transport="auto"):
    """Session, which has to stay, and its compiled scene."""
    session = session_of(*items)
    compiled = session._prepare(transport, False)
    compiled.settle()
    return session, compiled


def alike(numbers):
    """All shapes are looked at as often."""
    return np.full(len(numbers), 1.0 / len(numbers))


def sweep(compiled, count, places=None):
    """Cells with their light (sides,) [lx] on fronts and backs in turns.

    ``places``: (n, 3), whence a job looks at them; None: all are looked at by their areas. [m]
    """
    from lumenray.engine.transport.lux_maps.cell_iterations import Sweeper
    from lumenray.engine.transport.lux_maps.cells import CellSet
    from lumenray.engine.transport.paths.visible_surfaces import Sight

    cells = CellSet(compiled, count, alike)
    sides, looks = cells.sides, None
    if places is not None:
        up = np.tile([0.0, 0.0, 1.0], (len(places), 1))
        sides, looks = Sight(compiled, compiled.local(places), up, 3).sides(cells)
    sweeper = Sweeper(compiled, cells, sides, 3, looks=looks)
    sweeper.find()
    ratios = sweeper.state()["values"].reshape(-1, cells.bands.count).astype(float)
    return cells, ratios @ cells.bands.luminous() * cells.bands.illuminance()


def centres(cells, compiled):
    """Middles of the points of every side. (sides, 3) [m]"""
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.transport.lux_maps.cell_division import PLACES

    sides = dr.arange(mi.UInt32, 2 * cells.count)
    places = [cells.place(sides, mi.UInt32(number))[0].p for number in range(PLACES)]
    origin = compiled.local(np.zeros((1, 3)))[0]
    return np.mean([np.array(each).T for each in places], axis=0) - origin


def soup(seed, count=40, largest=3.0):
    """Triangles of all shapes and sizes."""
    rng = np.random.default_rng(seed)
    size = largest * rng.uniform(0.02, 1.0, (count, 1, 1)) ** 2
    return (rng.normal(size=(count, 1, 3)) + size * rng.normal(size=(count, 3, 3))).astype("f4")


def areas_of(triangles):
    edges = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return 0.5 * np.linalg.norm(edges.astype(float), axis=1)


def look_up(made, prim, uv):
    """Cells at places of triangles."""
    from lumenray.engine.transport.lux_maps.cell_division import unpack_grid

    across, up, corner = unpack_grid(made.grid[prim].astype(int))
    # Coordinates are those of the two corners after the one that the grid begins at.
    weights = np.stack([1.0 - uv.sum(axis=1), uv[:, 0], uv[:, 1]], axis=1)
    u, v = (weights[np.arange(len(uv)), (corner + k) % 3] for k in (1, 2))
    i = np.minimum((u * across).astype(int), across - 1)
    j = np.minimum((v * up).astype(int), up - 1)
    return made.first[prim].astype(int) + j * across + i


def random_places(triangles, count, seed=1):
    """Evenly spread places: triangles (count,) and barycentric coordinates (count, 2)."""
    rng = np.random.default_rng(seed)
    areas = areas_of(triangles)
    prim = rng.choice(len(triangles), count, p=areas / areas.sum())
    uv = rng.random((count, 2))
    over = uv.sum(axis=1) > 1.0
    uv[over] = 1.0 - uv[over]
    return prim, uv


def in_space(triangles, prim, uv):
    a, b, c = np.moveaxis(triangles[prim].astype(float), -2, 0)
    return a + uv[..., :1] * (b - a) + uv[..., 1:] * (c - a)


# ---- division ----


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("size", [0.1, 0.4])
def test_the_areas_of_cells_add_up_to_their_triangles(seed, size):
    from lumenray.engine.transport.lux_maps.cell_division import divide, unpack_grid

    triangles = soup(seed)
    made = divide(triangles, 0, size, 0)
    areas = areas_of(triangles)
    assert made.area.sum() == pytest.approx(areas.sum(), rel=1e-5)
    across, up, _ = unpack_grid(made.grid.astype(int))
    for k in np.flatnonzero(across * up > 1):
        own = made.area[made.first[k] : made.first[k] + across[k] * up[k]]
        assert own.sum() == pytest.approx(areas[k], rel=1e-5)
        assert own.max() <= 2.0 * areas[k] / (across[k] * up[k]) * (1.0 + 1e-6)


@pytest.mark.parametrize("size", [0.15, 0.5])
def test_even_light_falls_on_cells_by_their_areas(size):
    from lumenray.engine.transport.lux_maps.cell_division import divide

    triangles = soup(5)
    made = divide(triangles, 0, size, 0)
    count = 2_000_000
    found = np.bincount(look_up(made, *random_places(triangles, count)), minlength=len(made.area))
    assert found[made.area == 0.0].sum() == 0
    expected = count * made.area / areas_of(triangles).sum()
    many = expected > 20.0
    assert many.sum() > 100
    chi_square = ((found - expected)[many] ** 2 / expected[many]).sum()
    # Mean m and variance 2 m of the sum of m squares.
    assert abs(chi_square - many.sum()) < 5.0 * np.sqrt(2.0 * many.sum())


@pytest.mark.parametrize("seed", range(2))
def test_every_place_lies_among_the_points_of_its_cell(seed):
    from lumenray.engine.transport.lux_maps.cell_division import divide

    size, triangles = 0.3, soup(seed)
    made = divide(triangles, 0, size, 0)
    # The points of a cell belong to it.
    some = np.flatnonzero(made.area > 0.0)
    own = look_up(made, made.prim[some].ravel(), made.uv[some].reshape(-1, 2).astype(float))
    np.testing.assert_array_equal(own, np.repeat(some, made.prim.shape[1]))
    assert made.uv.sum(axis=2)[some].max() <= 1.0 + 1e-6
    # And no place is far from all points of its cell: a quarter of the cell, for divided triangles.
    prim, uv = random_places(triangles, 20_000)
    cell = look_up(made, prim, uv)
    points = in_space(triangles, made.prim[cell].astype(int), made.uv[cell].astype(float))
    away = np.linalg.norm(points - in_space(triangles, prim, uv)[:, None], axis=2)
    divided = made.grid[prim].astype(int) & 0x3FFFFFFF > 1 + (1 << 16)
    assert divided.mean() > 0.9
    # In the corners of triangles a cell's few points may be further off, but never out of it.
    assert np.percentile(away[divided].min(axis=1), 98.0) < 0.36 * size
    # Cells of blunt triangles are askew: no longer than their height allows.
    assert away[divided].max() < 4.0 * size


def test_kernels_find_the_same_cells():
    """Corners and borders too; and surfaces at their points are seen from the side that was asked for."""
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.transport.lux_maps.cell_division import PLACES
    from lumenray.engine.transport.lux_maps.cells import CellSet

    triangles = soup(2, 12)
    mesh = Mesh(
        "m", "m", triangles.reshape(-1, 3).astype(float), np.arange(36, dtype=np.int32).reshape(-1, 3),
        ("paint",), np.zeros(12, np.int32),
    )  # fmt: skip
    _session, compiled = prepare(mesh, paint(0.5), UniformWorld(1.0))
    cells = CellSet(compiled, 300, alike)
    ((_, part, _),) = compiled.parts()
    stored = compiled.triangles(part)
    _, first, grid = cells._host_table
    made = SimpleNamespace(first=first, grid=grid)
    assert 100 < (cells.area > 0.0).sum() < 600
    prim, uv = random_places(stored, 5_000)
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.5]])
    prim = np.concatenate([prim, np.repeat(np.arange(12), 4)])
    uv = np.concatenate([uv, np.tile(corners, (12, 1))]).astype(np.float32)
    shape = dr.reinterpret_array(mi.ShapePtr, dr.full(mi.UInt32, part.number, len(prim)))
    found = {
        is_back: np.array(
            cells.side(shape, mi.UInt32(prim), mi.Point2f(uv.T.copy()), mi.Bool(is_back), True)
        )
        for is_back in (False, True)
    }
    expected = look_up(made, prim, uv)
    np.testing.assert_array_equal(found[False], 2 * expected)
    np.testing.assert_array_equal(found[True], 2 * expected + 1)
    for is_back in (False, True):
        sides = mi.UInt32(2 * np.repeat(expected[:500], PLACES) + int(is_back))
        si, _ = cells.place(sides, mi.UInt32(np.tile(np.arange(PLACES), 500)))
        seen = np.array(si.p).T.reshape(500, PLACES, 3)
        own = in_space(stored, prim[:500], uv[:500])[:, None]
        cell = np.sqrt(cells.area[expected[:500]])
        assert np.median(np.linalg.norm(seen - own, axis=2).min(axis=1) / cell) < 0.25
        edges = stored[prim[:500]]
        normal = np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0])
        facing = np.einsum("nx,nkx->nk", normal, np.array(si.n).T.reshape(500, PLACES, 3))
        grouped = made.grid[prim[:500]] == 1 + (1 << 16)
        assert ((facing[~grouped] < 0.0) == is_back).all()


def grid(steps, side=2.0, name="fine", material="paint"):
    """Level square of many triangles."""
    x, y = (c.ravel() for c in np.meshgrid(*2 * [np.linspace(0.0, side, steps + 1)], indexing="ij"))
    i, j = (c.ravel() for c in np.mgrid[0:steps, 0:steps])
    a = i * (steps + 1) + j
    b, c, d = a + steps + 1, a + steps + 2, a + 1
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh(
        name, name, np.stack([x, y, 0.0 * x], axis=1), triangles.astype(np.int32), (material,),
        np.zeros(len(triangles), np.int32),
    )  # fmt: skip


def test_small_triangles_that_lie_together_and_face_alike_share_a_cell():
    from lumenray.engine.transport.lux_maps.cell_division import divide

    mesh = grid(64)
    lower = mesh.vertices[mesh.triangles].astype("f4")
    # The same square again from below: another direction, so other cells.
    triangles = np.concatenate([lower, lower[:, ::-1]])
    made = divide(triangles, 0, 0.25, 0)
    assert (made.grid == 1 + (1 << 16)).all()
    assert 2 * 8 * 8 <= len(made.area) <= 2 * 9 * 9
    assert made.area.sum() == pytest.approx(8.0, rel=1e-5)
    upper, under = np.split(made.first, 2)
    assert not np.isin(upper, under).any()
    centre = triangles.mean(axis=1)
    for cell in np.unique(made.first):
        own = centre[made.first == cell]
        assert np.ptp(own, axis=0).max() < 0.2501
    # Their points are spread by area over the members.
    points = in_space(triangles, made.prim.astype(int), made.uv.astype(float))
    whole = made.area > 0.9 * 0.25**2
    assert np.ptp(points[whole], axis=1)[:, :2].min() > 0.12


def test_points_are_even_over_all_triangles_that_share_a_cell():
    """Also of two objects beside divided triangles, and where triangles differ in size."""
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.transport.lux_maps.cells import CellSet

    def bent(name, power, height):
        mesh = grid(40, name=name)
        vertices = 2.0 * (mesh.vertices / 2.0) ** [power, 1.0, 1.0] + [0.0, 0.0, height]
        return replace(mesh, vertices=vertices)

    meshes = (
        bent("low", 1.5, 0.0),
        bent("high", 2.0, 1.0),
        moved(box(1.0, 1.0, 1.0), "box", (5, 0, 0)),
    )
    _session, compiled = prepare(*meshes, paint(0.5), UniformWorld(1.0))
    cells = CellSet(compiled, 700, alike)
    offsets, first, grids = cells._host_table
    count, checked = 1 << 12, 0
    for _, part, _ in compiled.parts():
        triangles = compiled.triangles(part).astype(float)
        own = slice(offsets[part.number], offsets[part.number] + len(triangles))
        for cell in np.unique(first[own][grids[own] == 1 + (1 << 16)])[:12]:
            members = triangles[first[own] == cell]
            area = areas_of(members)
            assert cells.whole[cell] == pytest.approx(area.sum(), rel=1e-5)
            sample = np.random.default_rng(int(cell)).random((2, count)).astype("f4")
            si, _, inside = cells.point(
                dr.full(mi.UInt32, 2 * int(cell), count), mi.Point2f(sample)
            )
            assert np.array(inside).all()
            points = np.array(si.p).T
            # Mean and spread over a triangle: of its corners, with weights of one twelfth and the whole.
            mean = area @ members.mean(axis=1) / area.sum()
            square = (
                area @ ((members**2).sum(axis=1) + members.sum(axis=1) ** 2) / 12.0 / area.sum()
            )
            spread = np.sqrt(np.maximum(square - mean**2, 0.0))
            error = spread / np.sqrt(count) + 1e-6
            assert (np.abs(points.mean(axis=0) - mean) < 4.5 * error).all()
            np.testing.assert_allclose(points.std(axis=0), spread, rtol=0.06, atol=1e-5)
            checked += len(members) > 4
    assert checked >= 20


@pytest.mark.parametrize(
    ("middle", "radius"),
    [((0.513, 0.31), 0.01), ((0.8, 0.803), 0.02), ((1.21, 0.79), 0.03), ((1.0, 1.0), 1.0)],
)
def test_traced_light_lies_where_it_landed_and_keeps_its_flux(middle, radius):
    """Within a cell, across its borders, at the edge that parts two triangles, and spread over all cells."""
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.transport.lux_maps.cells import CellSet

    floor = quad("floor", (0, 0, 0), (2, 0, 0), (0, 2, 0), "paint")
    _session, compiled = prepare(floor, paint(0.5), UniformWorld(1.0))
    cells = CellSet(compiled, 200, alike)
    ((_, part, _),) = compiled.parts()
    triangles = compiled.triangles(part).astype(float)
    draw = np.random.default_rng(3)

    def scatter(count, reach):
        """Even places around the middle: triangle and barycentric coordinates."""
        places = middle + reach * (2.0 * draw.random((count, 2)) - 1.0)
        # Scenes lie around their own origin.
        places += triangles.min(axis=(0, 1))[:2]
        prim, uv = np.zeros(count, np.int64), np.full((count, 2), np.nan)
        for number, (a, b, c) in enumerate(triangles):
            edges = np.stack([b - a, c - a], axis=1)[:2]
            found = np.linalg.solve(edges, (places - a[:2]).T).T
            here = (found >= 0.0).all(axis=1) & (found.sum(axis=1) <= 1.0)
            prim[here], uv[here] = number, found[here]
        assert np.isfinite(uv).all()
        return prim, uv

    prim, uv = scatter(1 << 14, radius)
    each = np.ones(len(prim))
    cells.put_traced(
        SimpleNamespace(shape=np.full(len(prim), part.number), prim=prim, uv=uv, flux=3.0 * each / len(prim),
                        cosine=each, back=np.zeros(len(prim), np.int64))
    )  # fmt: skip
    reach = min(1.5 * radius, 1.0)
    prim, uv = scatter(1 << 17, reach)
    shape = dr.reinterpret_array(mi.ShapePtr, dr.full(mi.UInt32, part.number, len(prim)))
    point = mi.Point2f(uv.T.astype("f4"))
    side, local = cells.locate(shape, mi.UInt32(prim), point, mi.Bool(False), True)
    light = np.array(dr.gather(mi.Float, cells.traced, side), dtype=float)
    light *= np.array(cells.concentration(side, local, mi.Bool(True))) * cells.bands.illuminance()
    assert light.mean() * (2.0 * reach) ** 2 == pytest.approx(3.0, rel=0.02)


# ---- light ----


@pytest.mark.parametrize("count", [2_000, 3_000, 5_000])
def test_cells_that_reach_under_a_wall_leave_the_room_behind_it_dark(count):
    """Before they are known as uneven they light that room, and there all light comes from such cells."""
    wall = moved(box(0.05, 3.2, 2.8, inwards=False), "wall", (2.03, -0.1, -0.2))
    _session, compiled = prepare(
        moved(box(4.0, 3.0, 2.8), "room", (0.0, 0.0, -0.3)),
        quad("floor", (0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (0.0, 3.0, 0.0), "paint"),
        wall,
        lamp((1.0, 1.5, 2.0)),
        paint(0.8),
    )
    places = np.random.default_rng(1).uniform((0.0, 0.0, 0.01), (4.0, 3.0, 0.01), (8 * count, 3))
    places = places[np.abs(places[:, 0] - 2.055) > 0.03]
    cells, light = sweep(compiled, count, places)
    middle = centres(cells, compiled)
    inside = np.repeat(cells.area, 2) > 0.0
    inside &= (np.abs(middle[:, 2]) < 1e-3) & (np.arange(len(inside)) % 2 == 0)
    lit, dark = inside & (middle[:, 0] < 1.9), inside & (middle[:, 0] > 2.3)
    assert light[dark].mean() < 1e-3 * light[lit].mean()


@pytest.mark.parametrize("reflectance", [0.5, 0.9])
@pytest.mark.slow
def test_cells_of_a_furnace_hold_its_closed_form(transport, reflectance):
    luminance = 40.0
    walls = paint(reflectance, emission=Emission(Constant(1.0), luminance))
    _session, compiled = prepare(box(3.0, 2.0, 2.5), walls, transport=transport)
    cells, light = sweep(compiled, 1_500)
    expected = np.pi * luminance / (1.0 - reflectance)
    inside, outside = light[0::2], light[1::2]
    known = cells.area > 0.0
    mean = (inside * cells.area).sum() / cells.area.sum()
    assert mean == pytest.approx(expected, rel=0.004)
    # Single cells: 32 samples, of which few leave something to chance.
    assert np.sqrt(np.mean((inside[known] / expected - 1.0) ** 2)) < 0.03
    assert outside.max() == 0.0


def test_sweeps_of_passes_that_follow_each_other_share_no_noise():
    """Else all lumels that read them err together in all passes, and the scatter of passes states too little."""
    from lumenray.engine.transport.lux_maps.cell_iterations import Sweeper
    from lumenray.engine.transport.lux_maps.cells import CellSet

    items = (box(3.0, 2.0, 2.5), lamp((1.0, 0.7, 1.9)), paint(0.7))
    _session, compiled = prepare(*items)
    cells = CellSet(compiled, 600, alike)
    sweeper = Sweeper(compiled, cells, cells.sides, 3)
    sweeper.find()
    found = []
    for number in range(40):
        sweeper.refresh(number, 1)
        ratios = sweeper.state()["values"].reshape(-1, cells.bands.count).astype(float)
        found.append(ratios @ cells.bands.luminous())
    noise = np.array(found) - np.mean(found, axis=0)
    square = (noise**2).mean()
    assert square > 0.0
    for lag in (1, 2):
        # Forty values less their mean go together by -1/40 where they are independent.
        alike_by = (noise[lag:] * noise[:-lag]).mean() / square + 1.0 / 40.0
        assert abs(alike_by) < 0.05


def test_a_bright_plain_outside_does_not_hide_that_the_light_of_a_room_still_grows():
    """Its light is a thousand times that of the room, whose later reflections would pass for nothing."""
    luminance, reflectance = 40.0, 0.9
    walls = paint(reflectance, emission=Emission(Constant(1.0), luminance))
    plain = quad("plain", (-2e3, -2e3, -1.0), (4e3, 0, 0), (0, 4e3, 0), "grass")
    grass = paint(0.2, name="grass")
    _session, compiled = prepare(box(3.0, 2.0, 2.5), walls, plain, grass, UniformWorld(1e4))
    rng = np.random.default_rng(2)
    inside = rng.uniform((0.0, 0.0, 0.01), (3.0, 2.0, 0.01), (1 << 15, 3))
    outside = rng.uniform((-5.0, -5.0, -0.99), (0.0, 0.0, -0.99), (1 << 11, 3))
    cells, light = sweep(compiled, 3_000, np.concatenate([inside, outside]))
    middle = centres(cells, compiled)[0::2]
    walls = np.flatnonzero((middle[:, 2] > -0.5) & (cells.area > 0.0))
    assert 0 < len(walls) < (cells.area > 0.0).sum()
    mean = (light[2 * walls] * cells.area[walls]).sum() / cells.area[walls].sum()
    assert mean == pytest.approx(np.pi * luminance / (1.0 - reflectance), rel=0.006)


def test_the_two_sides_of_a_sheet_hold_their_own_light():
    height, half = 1.0, 2.0
    floor = quad("floor", (-half, -half, 0), (2 * half, 0, 0), (0, 2 * half, 0), "paint")
    above = PointLight(
        "a", "a", Output(Quantity.LUMINOUS_INTENSITY, 100.0), np.array([0, 0, height])
    )
    below = replace(above, id="b", position=np.array([0, 0, -height]),
                    output=Output(Quantity.LUMINOUS_INTENSITY, 3.0))  # fmt: skip
    _session, compiled = prepare(floor, paint(0.5), above, below)
    cells, light = sweep(compiled, 2_000)
    # Flux of a point through a square under it.
    steradian = 4.0 * np.arcsin(half**2 / (half**2 + height**2))
    front, back = (float((light[k::2] * cells.area).sum()) for k in (0, 1))
    assert front == pytest.approx(100.0 * steradian, rel=0.005)
    assert back == pytest.approx(3.0 * steradian, rel=0.03)


@pytest.mark.parametrize(("roughness", "ior", "specular"), [(0.3, 1.5, 1.0), (0.7, 1.8, 0.5)])
def test_what_passes_a_coat_is_what_its_surface_does_not_mirror(roughness, ior, specular):
    """Over a black base all that a coated surface reflects is the coat's; the base of another gets the rest."""
    from lumenray.engine.transport.compiled.diffuse import DiffuseTable

    varnish = Coated(Constant(0.0), ior, roughness, specular)
    session, compiled = prepare(
        quad("floor", (0, 0, 0), (1, 0, 0), (0, 1, 0), "varnish"),
        Material("varnish", "varnish", varnish),
        UniformWorld(1.0),
    )
    ((_, part, _),) = compiled.parts()
    angles = np.array([0.0, 20.0, 40.0, 60.0, 75.0, 85.0])
    table = DiffuseTable(compiled)
    passing = table.passing(np.full(6, part.number), np.cos(np.radians(angles)))
    mirrored = session.probe(varnish, angles, 1 << 16, transport="mono")
    error = 5.0 * mirrored.reflectance_error
    assert (np.abs(passing + mirrored.reflectance - 1.0) < error + 0.006).all()
    # The base's light: rho (1 - C(i)) (1 - mean C) / (1 - mean C) comes out again.
    white = session.probe(replace(varnish, reflectance=Constant(0.8)), angles, 1 << 16,
                          transport="mono")  # fmt: skip
    error = 5.0 * np.hypot(white.reflectance_error, mirrored.reflectance_error)
    base = white.reflectance - mirrored.reflectance
    assert (np.abs(base - 0.8 * passing) < error + 0.006).all()


@pytest.mark.slow
def test_a_room_behind_a_wall_that_stands_on_a_shared_floor_stays_dark():
    """Floor, ceiling and two walls are single polygons of both rooms; the wall stands across the cells anyhow."""
    rooms = box(4.0, 2.0, 2.0)
    wall = box(0.07, 2.0, 2.0, inwards=False)
    wall = replace(wall, id="wall", name="wall", vertices=wall.vertices + np.array([2.03, 0, 0]))
    lamp = PointLight("l", "l", Output(Quantity.LUMINOUS_FLUX, 1000.0), np.array([1.0, 1.0, 1.5]))
    screens = [
        replace(quad(name, (x, 0.1, 0.001), (1.7, 0, 0), (0, 1.8, 0), "paint"), id=name)
        for name, x in (("lit", 0.1), ("dark", 2.2))
    ]
    session = session_of(rooms, wall, *screens, paint(0.8), lamp)
    order = BakeOrder(("lit", "dark"), StopRule(samples=256), density=6.0, method="cells")
    lit, dark = session.bake_objects(order).maps
    assert lit.mean > 100.0
    assert dark.largest.value < 1e-3 * lit.mean


def marked_of(light, bands, luminous):
    """Which sides are found to be uneven, by their light (sides, nodes, quarters, halves)."""
    from lumenray.engine.transport.lux_maps.cell_iterations import Sweeper

    sweeper = object.__new__(Sweeper)
    none = np.zeros(0, dtype=np.int64)
    sweeper.cells = SimpleNamespace(count=len(light) // 2, neighbours=(none, none), bands=bands)
    sweeper._sides, sweeper._weights = np.arange(len(light)), np.ones(len(light))
    sweeper._luminous = luminous
    sweeper._mark_uneven(light)
    return np.array(sweeper.cells.uneven)


@pytest.mark.parametrize("noise", [0.1, 0.2])
def test_even_cells_are_not_taken_for_uneven_by_chance(noise):
    """Of cells whose quarters differ by noise alone few are marked, of those that are lit by halves nearly all."""
    prepare()
    draw = np.random.default_rng(4)
    light = 1.0 + noise * draw.standard_normal((8000, 1, 4, 2))
    light[:1000] *= np.array([1.0, 1.0, 5.0, 5.0])[:, None]
    marked = marked_of(light, SimpleNamespace(count=1, turns=1), np.ones(1))
    assert marked[:1000].mean() > 0.98
    assert marked[1000:].mean() < 0.02


def test_every_other_turn_tells_as_much_as_halves_of_the_samples():
    """Of a smooth spectrum both halves of the wavelengths have the same light, so no noise is seen where there is none."""
    from lumenray.engine.transport.lux_maps.bands import Bands
    from lumenray.engine.transport.lux_maps.cell_iterations import Sweeper

    prepare(transport="spectral")
    bands = Bands(np.linspace(0.2, 1.0, 471))
    colour = np.exp(-(((bands.nodes - 620.0) / 90.0) ** 2))
    made = np.ones((2, bands.count, 4, 1)) * colour[:, None, None]
    sweeper = SimpleNamespace(cells=SimpleNamespace(bands=bands), _luminous=bands.luminous())
    light = Sweeper._light_of_halves(sweeper, made)
    assert light.shape == (2, 4, 2)
    np.testing.assert_allclose(light, colour @ bands.luminous(), rtol=0.005)
