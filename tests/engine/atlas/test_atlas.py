"""Charts, lumels and maps together: from a mesh to the values on its pages."""

from dataclasses import replace

import numpy as np
import pytest
from layouts import lay_out
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.atlas.lumels import LumelTable
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.light import Output, PointLight, Quantity, UniformWorld
from lumenray.engine.scene.material import Emission
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.spectrum import Constant


def table_of(mesh, density, **more):
    atlas = lay_out([mesh], [density], **more)
    table = LumelTable([mesh], atlas)
    return atlas, [table.block(number) for number in range(len(table.counts))]


def test_charts_have_the_density_that_was_asked_for():
    atlas, blocks = table_of(box(3.0, 2.0, 2.5), 10.0, margin=2)
    # 12 + 2 * (3 + 2) * 2.5 = 37 m2 at 100 lumels a square metre, whole lumels each.
    assert atlas.layouts[0].density == pytest.approx(10.0)
    assert sum(block.area.sum() for block in blocks) == pytest.approx(37.0, rel=1e-6)
    assert sum(len(block.index) for block in blocks) == pytest.approx(3700, rel=0.03)


def test_no_lumel_belongs_to_two_charts():
    _, blocks = table_of(box(3.0, 2.0, 2.5), 10.0, margin=2)
    for block in blocks:
        places = block.receivers
        for start, count in zip(places.start, places.count, strict=True):
            own = places.normals[start : start + count]
            assert np.allclose(own, own[0])


def test_a_map_that_would_be_too_large_is_made_coarser():
    atlas, _ = table_of(box(3.0, 2.0, 2.5), 1000.0, largest=256, pages=1, margin=2)
    assert len(atlas.sizes) == 1
    assert atlas.sizes.max() <= 256
    # 37 m2 have room for 42 lumels a metre at the very most.
    assert 20.0 < atlas.layouts[0].density < 256 / np.sqrt(37.0)
    assert atlas.layouts[0].requested_density == 1000.0


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
    layout = lay_out([mesh], [20.0], margin=2).layouts[0]
    for i in range(n):
        a, b = layout.uv[2 * i], layout.uv[2 * i + 1]
        assert layout.page[2 * i] == layout.page[2 * i + 1]
        assert np.abs(a[0] - b[0]).max() < 1e-2
        assert np.abs(a[2] - b[1]).max() < 1e-2


def test_degenerate_input_is_refused_in_words():
    none = np.zeros(0, np.int32)
    empty = replace(box(1, 1, 1), triangles=none.reshape(0, 3), material_index=none)
    flat = replace(box(1, 1, 1), vertices=np.zeros((8, 3)))
    order = BakeOrder(("box",), StopRule(samples=4))
    for mesh in (empty, flat):
        with pytest.raises(SceneError, match="surface"):
            lay_out([mesh], [10.0])
        with pytest.raises(SceneError, match="surface"):
            session_of(mesh, paint(0.5)).bake_objects(order)


@pytest.mark.mitsuba
def test_a_baked_floor_follows_the_inverse_square_cosine_law():
    height, density = 2.0, 16.0
    floor = quad("floor", (-2, -2, 0), (4, 0, 0), (0, 4, 0), "black")
    lamp = PointLight(
        "l", "l", Output(Quantity.LUMINOUS_INTENSITY, 1000.0), np.array([0, 0, height])
    )
    order = BakeOrder(("floor",), StopRule(samples=64), density=density)
    result = session_of(floor, paint(0.0, "black"), lamp).bake_objects(order)
    made, (page,) = result.maps[0], result.pages
    assert page.covered.sum() == made.lumels == 64 * 64
    # The chart may be turned by quarters, but the light is the same both ways: compare in order of brightness.
    x, y = np.meshgrid(*2 * [(np.arange(64) + 0.5) / density - 2.0])
    expected = np.sort((1000.0 * height / (x**2 + y**2 + height**2) ** 1.5).ravel())
    found = np.sort(page.illuminance[page.covered])
    assert np.abs(found / expected - 1.0).max() < 0.01
    # Mean over the square by its closed form: flux through it = I * 4 asin(a^2 / (a^2 + h^2)), a = 2.
    flux = 1000.0 * 4.0 * np.arcsin(4.0 / (4.0 + height**2))
    assert made.mean == pytest.approx(flux / 16.0, rel=0.003)
    assert made.least.low <= made.mean <= made.largest.high


@pytest.mark.mitsuba
@pytest.mark.parametrize("method", [pytest.param("cells", marks=pytest.mark.slow), "paths"])
def test_the_stated_error_of_a_map_is_its_true_error(method):
    # Known answer everywhere (furnace), so the true root mean square error can be measured.
    room = box(2, 2, 2)
    walls = paint(0.7, emission=Emission(Constant(1.0), 50.0))
    expected = np.pi * 50.0 / 0.3
    ratios, offsets = [], []
    for seed in range(3):
        order = BakeOrder(("box",), StopRule(samples=64), density=8.0, seed=seed, method=method)
        result = session_of(room, walls).bake_objects(order)
        made, values = result.maps[0], result.lumels(0)
        share = values.area / values.area.sum()
        true = np.sqrt((share * (values.illuminance - expected) ** 2).sum()) / expected
        ratios.append(made.relative_standard_error / true)
        offsets.append((made.mean - expected) / made.mean_standard_error)
    # The mean by some four standard errors of 15 degrees of freedom.
    assert np.abs(offsets).max() < 5.0
    assert 0.95 < np.mean(ratios) < 1.05


@pytest.mark.mitsuba
def test_the_same_seed_gives_the_same_map_and_another_seed_another():
    floor = quad("floor", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "paint")
    items = (
        floor,
        paint(0.5),
        UniformWorld(100.0),
        PointLight("l", "l", Output(Quantity.LUMINOUS_FLUX, 100.0), np.array([0, 0, 1.0]), 0.2),
    )

    def bake(seed):
        order = BakeOrder(("floor",), StopRule(samples=16), seed=seed)
        return session_of(*items).bake_objects(order).pages[0].illuminance

    assert np.array_equal(bake(5), bake(5))
    assert not np.array_equal(bake(5), bake(6))


@pytest.mark.mitsuba
def test_objects_on_a_page_do_not_overlap():
    floor = quad("floor", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "paint")
    floors = [
        replace(
            floor, id=f"f{i}", name=f"f{i}", vertices=floor.vertices + np.array([0, 0, 10.0 * i])
        )
        for i in range(7)
    ]
    names = tuple(each.id for each in floors)
    densities = {name: 6.0 + i for i, name in enumerate(names)}
    order = BakeOrder(names, StopRule(samples=4), densities=densities, largest=64, margin=2)
    result = session_of(*floors, paint(0.0), UniformWorld(100.0)).bake_objects(order)
    for made in result.maps:
        # 2 m by 2 m, by whole lumels; every lumel has a place of its own.
        assert made.lumels == (2 * round(made.density)) ** 2 == (2 * densities[made.id]) ** 2
        values = result.lumels(made.number)
        assert len(values.area) == made.lumels
        assert values.area.sum() == pytest.approx(4.0, rel=1e-6)
    assert sum(page.covered.sum() for page in result.pages) == sum(m.lumels for m in result.maps)
