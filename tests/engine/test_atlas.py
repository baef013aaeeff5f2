"""Charts, lumels and maps."""

from dataclasses import replace

import numpy as np
import pytest
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.atlas.lumels import rasterise
from lumenray.engine.atlas.maps import dilate
from lumenray.engine.atlas.sheet import compose_sheet
from lumenray.engine.atlas.unwrap import unwrap
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.light import Output, PointLight, Quantity, UniformWorld
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.session import BakeTarget
from small_scenes import box, paint, quad, session_of


def test_charts_have_the_density_that_was_asked_for():
    room = box(3.0, 2.0, 2.5)
    charts = unwrap(room, 10.0, 1024, 2)
    lumels = rasterise(room, charts)
    # 12 + 2 * (3 + 2) * 2.5 = 37 m2 at 100 lumels a square metre, up to partly covered edges.
    assert charts.density == 10.0
    assert lumels.area.sum() == pytest.approx(37.0, rel=0.01)
    assert len(lumels.index) == pytest.approx(3700, rel=0.12)


def test_no_lumel_belongs_to_two_charts():
    room = box(3.0, 2.0, 2.5)
    charts = unwrap(room, 10.0, 1024, 2)
    lumels = rasterise(room, charts)
    normals = lumels.receivers.normals
    for start, count in zip(lumels.receivers.start, lumels.receivers.count, strict=True):
        own = normals[start : start + count]
        assert np.allclose(own, own[0])


def test_a_map_that_would_be_too_large_is_made_coarser():
    charts = unwrap(box(3.0, 2.0, 2.5), 1000.0, 256, 2)
    assert max(charts.width, charts.height) <= 256
    assert charts.density < 100.0
    assert charts.requested_density == 1000.0


def test_a_polygon_is_never_cut_by_a_chart_border():
    # A ring of strongly bent quads: each polygon's shared corners need one place in the map.
    rng = np.random.default_rng(4)
    n = 24
    angle = np.arange(n) / n * 2 * np.pi
    low = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    high = np.stack([0.3 * np.cos(angle + 0.5), 0.3 * np.sin(angle + 0.5), 1 + 0 * angle], axis=1)
    vertices = np.concatenate([low, high]) + 0.2 * rng.normal(size=(2 * n, 3))
    triangles, polygon = [], []
    for i in range(n):
        j = (i + 1) % n
        triangles += [(i, j, n + j), (i, n + j, n + i)]
        polygon += [i, i]
    mesh = Mesh(
        "ring", "ring", vertices, np.array(triangles, np.int32), ("m",),
        np.zeros(2 * n, np.int32), polygon=np.array(polygon, np.int32),
    )  # fmt: skip
    charts = unwrap(mesh, 20.0, 1024, 2)
    for i in range(n):
        a, b = charts.uv[2 * i], charts.uv[2 * i + 1]
        size = np.array([charts.width, charts.height])
        assert np.abs((a[0] - b[0]) * size).max() < 1e-2
        assert np.abs((a[2] - b[1]) * size).max() < 1e-2


def test_degenerate_input_is_refused_in_words():
    empty = replace(
        box(1, 1, 1), triangles=np.zeros((0, 3), np.int32), material_index=np.zeros(0, np.int32)
    )
    with pytest.raises(SceneError, match="no surface"):
        unwrap(empty, 10.0)
    flat = replace(box(1, 1, 1), vertices=np.zeros((8, 3)))
    with pytest.raises(SceneError, match="no surface"):
        unwrap(flat, 10.0)


def test_dilation_extends_charts_without_touching_them():
    values = np.zeros((9, 9), np.float32)
    covered = np.zeros((9, 9), bool)
    values[4, 4], covered[4, 4] = 7.0, True
    grown = dilate(values, covered, 2)
    assert grown[4, 4] == 7.0
    assert (grown[2:7, 2:7] == 7.0).all()
    assert grown[1].max() == 0.0


def test_a_baked_floor_follows_the_inverse_square_cosine_law():
    height = 2.0
    floor = quad("floor", (-2, -2, 0), (4, 0, 0), (0, 4, 0), "black")
    lamp = PointLight(
        "l", "l", Output(Quantity.LUMINOUS_INTENSITY, 1000.0), np.array([0, 0, height])
    )
    charts = unwrap(floor, 16.0, 256, 2)
    made = session_of(floor, paint(0.0, "black"), lamp).bake(
        [BakeTarget(floor, charts)], StopRule(samples=64)
    )[0]
    lumels = rasterise(floor, charts)
    start = lumels.receivers.start
    centre = np.add.reduceat(lumels.receivers.positions, start) / lumels.receivers.count[:, None]
    expected = 1000.0 * height / (centre[:, 0] ** 2 + centre[:, 1] ** 2 + height**2) ** 1.5
    found = made.illuminance.reshape(-1)[lumels.index]
    assert np.abs(found / expected - 1.0).max() < 0.01
    # Mean over the square by its closed form: flux through it = I * 4 asin(a^2 / (a^2 + h^2)), a = 2.
    flux = 1000.0 * 4.0 * np.arcsin(4.0 / (4.0 + height**2))
    assert made.mean == pytest.approx(flux / 16.0, rel=0.003)
    assert made.minimum <= made.mean <= made.maximum


def test_the_stated_error_of_a_map_is_its_true_error():
    # Known answer everywhere (furnace), so the true root mean square error can be measured.
    from lumenray.engine.scene.material import Emission
    from lumenray.engine.scene.spectrum import Constant

    room = box(2, 2, 2)
    walls = paint(0.7, emission=Emission(Constant(1.0), 50.0))
    charts = unwrap(room, 10.0, 512, 2)
    ratios = []
    for seed in range(3):
        made = session_of(room, walls).bake(
            [BakeTarget(room, charts)], StopRule(samples=128), seed
        )[0]
        expected = np.pi * 50.0 / 0.3
        area = made.area[made.covered]
        true = (
            np.sqrt((((made.illuminance[made.covered] - expected) ** 2) * area).sum() / area.sum())
            / expected
        )
        ratios.append(made.relative_standard_error / true)
    assert 0.95 < np.mean(ratios) < 1.05


def test_the_same_seed_gives_the_same_map_and_another_seed_another():
    floor = quad("floor", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "paint")
    items = (
        floor,
        paint(0.5),
        UniformWorld(100.0),
        PointLight("l", "l", Output(Quantity.LUMINOUS_FLUX, 100.0), np.array([0, 0, 1.0]), 0.2),
    )
    charts = unwrap(floor, 8.0, 64, 2)

    def bake(seed):
        return session_of(*items).bake([BakeTarget(floor, charts)], StopRule(samples=16), seed)[0]

    assert np.array_equal(bake(5).illuminance, bake(5).illuminance)
    assert not np.array_equal(bake(5).illuminance, bake(6).illuminance)


def test_maps_on_a_sheet_do_not_overlap():
    floor = quad("floor", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "paint")
    items = (floor, paint(0.5), UniformWorld(100.0))
    targets = [
        BakeTarget(replace(floor, name=f"f{i}"), unwrap(floor, 6.0 + i, 64, 2)) for i in range(7)
    ]
    maps = session_of(*items).bake(targets, StopRule(samples=4))
    sheet = compose_sheet(maps)
    assert sheet.covered.sum() == sum(m.covered.sum() for m in maps)
    for name, x, y, width, height in sheet.places:
        original = next(m for m in maps if m.name == name)
        assert np.array_equal(
            sheet.illuminance[y : y + height, x : x + width], original.illuminance
        )
