"""Illuminance on lumels next to walls, under furniture and on faulty meshes: nothing leaks, and all numbers are finite."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.atlas.layout import Atlas, SurfaceLayout
from lumenray.engine.atlas.lumels import LumelTable
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.scene.light import Output, PointLight, Quantity, UniformWorld
from lumenray.engine.scene.mesh import Mesh

pytestmark = pytest.mark.mitsuba

DENSITY = 8.0
FLOOR = quad("floor", (-2, -2, 0), (4, 0, 0), (0, 4, 0), "paint")
LAMP = PointLight("l", "l", Output(Quantity.LUMINOUS_FLUX, 1000.0), np.array([1.6, 1.6, 2.2]), 0.05)


def without_floor(mesh):
    """Walls and lid of a box."""
    kept = mesh.vertices[mesh.triangles][..., 2].max(axis=1) > mesh.vertices[:, 2].min() + 1e-9
    return replace(mesh, triangles=mesh.triangles[kept], material_index=mesh.material_index[kept])


def measured(
    target, others, scale=1.0, offset=(0.0, 0.0, 0.0), density=DENSITY, samples=256, looks=True
):
    """Lumels of a level mesh and their illuminance, in a scene that is scaled and moved. ``looks``: whether validated."""
    placed = [
        replace(m, id=f"m{i}", name=f"m{i}", vertices=m.vertices * scale + np.asarray(offset))
        for i, m in enumerate([target, *others])
    ]
    lamp = replace(LAMP, position=LAMP.position * scale + np.asarray(offset), radius=0.05 * scale)
    flat = target.vertices[target.triangles][..., :2]
    uv = (flat - flat.reshape(-1, 2).min(axis=0)) * density + 2.0
    count = len(target.triangles)
    layout = SurfaceLayout(
        uv, np.zeros(count, np.int32), np.zeros(count, np.int32), density / scale, density / scale
    )
    table = LumelTable(placed[:1], Atlas(np.array([[64, 64]]), (layout,), 1, 1.0))
    with session_of(*placed, paint(0.8), lamp)._engine("auto") as compiled:
        from lumenray.engine.transport.paths.illuminance import compute

        if looks:
            table.validate(compiled)
        block = table.block(0)
        found = compute(compiled, block.receivers, StopRule(samples=samples)).mean
    assert np.isfinite(found).all()
    y, x = np.divmod(block.index, 64)
    low = (np.stack([x, y], axis=1) - 2.0) / density + flat.reshape(-1, 2).min(axis=0)
    return block, found, low


ROOM = replace(without_floor(box(4.0, 4.0, 2.5)), vertices=box(4.0, 4.0, 2.5).vertices - [2, 2, 0])


@pytest.mark.one_at_a_time
@pytest.mark.parametrize(
    ("scale", "offset"), [(1.0, (0, 0, 0)), (1.0, (1e4, -1e4, 1e4)), (1e-3, (0, 0, 0))]
)
@pytest.mark.parametrize("shift", [0.0, 1 / 256, 0.0371])
def test_a_box_inside_a_lit_box_is_dark(scale, offset, shift):
    # Sheets as walls, which stand on borders of lumels, exactly on their places, or anywhere.
    inner = without_floor(box(2.0, 2.0, 1.0, inwards=False))
    inner = replace(inner, vertices=inner.vertices + np.array([shift - 1, shift - 1, 0]))
    block, found, low = measured(FLOOR, [inner, ROOM], scale, offset)
    eps = 1e-6
    dark = ((low > shift - 1 - eps) & (low + 1 / DENSITY < shift + 1 + eps)).all(axis=1)
    lit = ((low + 1 / DENSITY < shift - 1 + eps) | (low > shift + 1 - eps)).any(axis=1)
    assert block.valid.all()
    assert dark.sum() >= 15 * 15
    assert found[dark].max() < 1e-3 * found[lit].mean()
    # Light reaches right up to the walls, on the side of the lamp more than on the mean.
    assert found[lit].min() > 0.1 * found[lit].mean()


@pytest.mark.slow
def test_furniture_that_is_sunk_into_the_floor_has_no_dark_rim():
    inner = box(2.0, 2.0, 1.0, inwards=False)
    inner = replace(inner, vertices=inner.vertices + np.array([-0.98, -0.98, -0.005]))
    rims = {}
    for looks in (True, False):
        block, found, low = measured(FLOOR, [inner, ROOM], samples=1 << 13, looks=looks)
        column = np.abs(low[:, 0] - 1.0) < 1e-6
        column &= np.abs(low[:, 1] - 0.5) < 0.3
        beyond = np.abs(low[:, 0] - 1.125) < 1e-6
        beyond &= np.abs(low[:, 1] - 0.5) < 0.3
        assert block.valid[column].all()
        rims[looks] = found[column].mean() / found[beyond].mean()
    # The box hides 0.02 of 0.125 m of the lumels beside it: 16 %.
    assert rims[False] / rims[True] == pytest.approx(1.0 - 0.02 / 0.125, abs=0.04)


def faulty_floor():
    """Floor with T-vertices, slivers and triangles without area."""
    points = [
        (-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0),
        # On an edge of its neighbours, which do not know of it; and beside it by a millionth.
        (0, 0, 0), (0, 1e-6, 0), (1, 1, 0), (1, 1, 0),
    ]  # fmt: skip
    triangles = [(0, 1, 2), (0, 4, 3), (4, 2, 3), (0, 4, 5), (4, 5, 2), (0, 0, 1), (4, 6, 7),
    ]  # fmt: skip
    return Mesh(
        "bad", "bad", np.array(points, float), np.array(triangles, np.int32), ("paint",),
        np.zeros(len(triangles), np.int32),
    )  # fmt: skip


def test_faulty_meshes_have_finite_illuminance():
    mesh = faulty_floor()
    block, found, _ = measured(mesh, [ROOM])
    assert found.max() > 0.0
    assert block.area.sum() == pytest.approx(mesh.areas().sum(), rel=1e-6)
    assert np.isfinite(block.receivers.positions).all()
    assert np.abs(np.linalg.norm(block.receivers.normals, axis=1) - 1.0).max() < 1e-5
    # Where the floor is sound it is as bright as a sound one.
    sound, expected, _ = measured(FLOOR, [ROOM])
    below = (sound.index % 64) - (sound.index // 64) > 4
    same = np.isin(block.index, sound.index[below])
    up = block.receivers.normals[block.receivers.start[same], 2] > 0.0
    assert up.mean() > 0.9
    close = found[same][up] / expected[below][up]
    assert np.median(np.abs(close - 1.0)) < 0.05


# ---- whole bakes ----


def baked(*items, objects, error=0.02, **more):
    order = BakeOrder(objects, StopRule(error=error, samples=4096), **more)
    return session_of(*items).bake_objects(order)


def pipe(sectors=48, rows=6):
    """Smooth cylinder of radius 1 m and 3 m high."""
    turn = np.arange(sectors) / sectors * 2 * np.pi
    z, t = (x.ravel() for x in np.meshgrid(np.linspace(0, 3, rows + 1), turn, indexing="ij"))
    vertices = np.stack([np.cos(t), np.sin(t), z], axis=1)
    i, j = (x.ravel() for x in np.meshgrid(np.arange(rows), np.arange(sectors), indexing="ij"))
    a, b = i * sectors + j, i * sectors + (j + 1) % sectors
    up = sectors
    triangles = np.concatenate(
        [np.stack([a, b, b + up], axis=1), np.stack([a, b + up, a + up], axis=1)]
    )
    normals = (vertices * [1, 1, 0])[triangles].astype(np.float32)
    return Mesh(
        "pipe", "pipe", vertices, triangles.astype(np.int32), ("paint",),
        np.zeros(len(triangles), np.int32), normals,
    )  # fmt: skip


@pytest.mark.slow
def test_a_smooth_cylinder_has_no_seams_beyond_the_noise():
    lamp = replace(LAMP, position=np.array([2.5, 1.0, 2.2]))
    made = baked(
        pipe(), FLOOR, paint(0.6), lamp, UniformWorld(30.0), objects=("pipe",), density=16.0
    )
    assert made.maps[0].charts > 1
    assert made.seams.pairs > 3 * 16
    # Before, the steps are what the noise of both sides makes them, and no more than twice that.
    assert 0.5 * made.seams.noise < made.seams.before < 2.0 * made.seams.noise
    assert made.seams.after < 0.1 * made.seams.noise


@pytest.mark.parametrize(
    ("scale", "offset"), [(1.0, (0, 0, 0)), (1.0, (1e4, -1e4, 1e4)), (1e-3, (0, 0, 0))]
)
@pytest.mark.slow
def test_a_baked_box_inside_a_lit_box_is_dark(scale, offset):
    # The floor of the inner box is an object of its own, so that its lumels are all on the dark side.
    inner = without_floor(box(2.0, 2.0, 1.0, inwards=False))
    inner = replace(inner, vertices=inner.vertices + np.array([-1, -1, 0]))
    dark = quad("dark", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "paint")
    lit = quad("lit", (1, -2, 0), (1, 0, 0), (0, 4, 0), "paint")
    placed = [
        replace(m, id=name, name=name, vertices=m.vertices * scale + np.asarray(offset))
        for m, name in ((inner, "inner"), (ROOM, "room"), (dark, "dark"), (lit, "lit"))
    ]
    lamp = replace(LAMP, position=LAMP.position * scale + np.asarray(offset), radius=0.05 * scale)
    made = baked(*placed, paint(0.8), lamp, objects=("dark", "lit"), density=DENSITY / scale)
    means = {m.id: m.mean for m in made.maps}
    assert means["lit"] > 0.0
    assert made.lumels(made.maps[0].number).illuminance.max() < 1e-3 * means["lit"]


@pytest.mark.slow
def test_hard_geometry_bakes_to_finite_numbers():
    tangled = faulty_floor()
    more = np.array([(0, 1, 2), (2, 1, 0)], np.int32)
    tangled = replace(
        tangled,
        triangles=np.concatenate([tangled.triangles, more]),
        material_index=np.zeros(len(tangled.triangles) + 2, np.int32),
    )
    flipped = box(0.5, 0.5, 0.5, inwards=True)
    flipped = replace(
        flipped, id="flipped", name="flipped", vertices=flipped.vertices - [1, 1, 0.1]
    )
    twin = replace(FLOOR, id="twin", name="twin")
    made = baked(
        tangled, flipped, FLOOR, twin, ROOM, paint(0.5), LAMP,
        objects=("bad", "flipped", "floor", "twin"), error=0.05,
    )  # fmt: skip
    assert len(made.maps) == 4
    for page in made.pages:
        for layer in (page.illuminance, page.standard_error, page.area):
            assert np.isfinite(layer).all()
            assert layer.min() >= 0.0
    means = {m.id: m for m in made.maps}
    # Two floors at one place are lit alike, neither by chance: to four of their stated errors.
    gap = means["floor"].mean - means["twin"].mean
    spread = np.hypot(means["floor"].mean_standard_error, means["twin"].mean_standard_error)
    assert abs(gap) < 4.0 * spread
