"""Rectangles of charts on the pages of an atlas."""

from dataclasses import replace

import numpy as np
import pytest
from layouts import lay_out
from small_scenes import box, quad

from lumenray.engine.atlas.arrange import arrange, find_all_charts
from lumenray.engine.atlas.detail import halve_even_charts
from lumenray.engine.atlas.layout import Atlas
from lumenray.engine.atlas.packing import count_groups, pack
from lumenray.engine.atlas.texture_density import texture_density
from lumenray.engine.errors import Cancelled, SceneError
from lumenray.engine.scene.material import Diffuse, Emission, Material
from lumenray.engine.scene.texture import ImageTexture, Tile


def rectangles(count, low, high, seed=3):
    """Random rectangles, long side first. [m]"""
    sides = np.random.default_rng(seed).uniform(low, high, (count, 2))
    return np.sort(sides, axis=1)[:, ::-1]


def check(packing, margin):
    """Every chart lies on its page, and no lumel or rim of two charts is the same."""
    low = packing.place - margin
    high = packing.place + packing.lumels + margin
    assert (low >= 0).all()
    assert (high <= packing.sizes[packing.page]).all()
    for number, (width, height) in enumerate(packing.sizes):
        taken = np.zeros((height, width), np.int8)
        for chart in np.flatnonzero(packing.page == number):
            taken[low[chart, 1] : high[chart, 1], low[chart, 0] : high[chart, 0]] += 1
        assert taken.max() == 1


def fill(packing, margin):
    boxes = packing.lumels + 2 * margin
    return boxes.prod(axis=1).sum() / packing.sizes.prod(axis=1).sum()


def test_charts_keep_their_rims_and_their_density():
    size = rectangles(300, 0.3, 4.0)
    packing = pack(size, np.full(300, 10.0), largest=512, pages=0, margin=3)
    check(packing, 3)
    assert packing.shrink == 1.0
    assert np.abs(packing.lumels - size * 10.0).max() <= 0.5 + 1e-9


def test_ten_thousand_charts_fill_their_pages():
    size = rectangles(10_000, 0.2, 8.0)
    packing = pack(size, np.full(10_000, 8.0), largest=2048, pages=3, margin=4)
    check(packing, 4)
    assert len(packing.sizes) == 3
    assert fill(packing, 4) > 0.8


def test_a_short_budget_shrinks_all_charts_alike_and_little():
    size = rectangles(2000, 1.0, 20.0)
    packing = pack(size, np.full(2000, 8.0), largest=1024, pages=10, margin=4)
    check(packing, 4)
    assert len(packing.sizes) == 10
    assert 0.0 < packing.shrink < 1.0
    ratio = packing.lumels / (size * 8.0)
    assert np.abs(packing.lumels - size * 8.0 * packing.shrink).max() <= 0.5 + 1e-9
    assert np.median(ratio) == pytest.approx(packing.shrink, rel=0.01)
    # The largest factor that can be: with it the pages are nearly full.
    assert fill(packing, 4) > 0.8


def test_no_more_pages_are_used_than_there_may_be():
    size = rectangles(500, 1.0, 10.0)
    needed = len(pack(size, np.full(500, 8.0), largest=512, pages=0, margin=2).sizes)
    assert needed > 3
    for pages in (1, 2, needed, needed + 5):
        packing = pack(size, np.full(500, 8.0), largest=512, pages=pages, margin=2)
        check(packing, 2)
        assert len(packing.sizes) == min(pages, needed)
        assert (packing.shrink < 1.0) == (pages < needed)


def test_more_room_in_a_group_never_needs_more_groups():
    area = rectangles(3000, 1.0, 20.0).prod(axis=1)
    limits = np.geomspace(area.max(), 1.001 * area.sum(), 60)
    counts = [count_groups(area, limit) for limit in limits]
    assert all(a >= b for a, b in zip(counts, counts[1:], strict=False))
    assert counts[-1] == 1
    # First-fit decreasing is known to need at most 11/9 of the best, plus one (Johnson 1974).
    for limit, count in zip(limits, counts, strict=True):
        assert np.ceil(area.sum() / limit) <= count <= 11 / 9 * np.ceil(area.sum() / limit) + 2


def test_walls_fill_whole_lumels():
    size = np.array([[4.0, 2.5], [4.0 - 3e-7, 2.5 + 3e-7], [3.0, 1.0]])
    packing = pack(size, np.full(3, 8.0), largest=256, pages=0, margin=2)
    assert packing.lumels.tolist() == [[32, 20], [32, 20], [24, 8]]


def test_a_single_page_is_no_larger_than_needed():
    size = rectangles(60, 0.5, 3.0)
    packing = pack(size, np.full(60, 8.0), largest=4096, pages=0, margin=2)
    check(packing, 2)
    assert len(packing.sizes) == 1
    assert (packing.sizes % 4 == 0).all()
    assert fill(packing, 2) > 0.75


def test_a_chart_larger_than_a_page_is_made_to_fit_and_keeps_its_shape():
    size = np.array([[300.0, 30.0], [1.0, 1.0]])
    packing = pack(size, np.full(2, 10.0), largest=512, pages=0, margin=6)
    check(packing, 6)
    assert packing.cut_down.tolist() == [True, False]
    assert packing.lumels.tolist() == [[500, 50], [10, 10]]


def test_what_cannot_fit_is_refused_in_words():
    size = rectangles(1000, 0.5, 1.0)
    with pytest.raises(SceneError, match="do not fit 1 pages of 64 x 64"):
        pack(size, np.full(1000, 8.0), largest=64, pages=1, margin=2)
    with pytest.raises(SceneError, match="no room within a margin"):
        pack(size, np.full(1000, 8.0), largest=8, pages=0, margin=4)
    with pytest.raises(SceneError, match="more than 1024 pages"):
        pack(np.tile(size, (5, 1)), np.full(5000, 1e4), largest=2048, pages=0, margin=4)


def test_a_great_many_small_charts_are_packed_closely():
    size = rectangles(60_000, 0.1, 0.6)
    packing = pack(size, np.full(60_000, 8.0), largest=1024, pages=0, margin=2)
    check(packing, 2)
    assert fill(packing, 2) > 0.8


def test_the_charts_of_a_mesh_share_a_page_where_that_costs_nothing():
    size = rectangles(400, 1.0, 9.0)
    owner = np.arange(400) % 40
    packing = pack(size, np.full(400, 8.0), largest=512, pages=0, margin=2, owner=owner)
    check(packing, 2)
    alone = pack(size, np.full(400, 8.0), largest=512, pages=0, margin=2)
    assert len(packing.sizes) == len(alone.sizes) > 1

    def scattered(packed):
        return sum(len(np.unique(packed.page[owner == number])) - 1 for number in range(40))

    assert scattered(packing) < 0.3 * scattered(alone)


def test_the_same_charts_are_packed_the_same_way():
    size = rectangles(700, 0.5, 9.0)
    a, b = (pack(size, np.full(700, 8.0), largest=512, pages=3, margin=4) for _ in range(2))
    assert np.array_equal(a.place, b.place)
    assert np.array_equal(a.page, b.page)
    assert a.shrink == b.shrink


def test_an_atlas_has_fronts_then_backs_and_counts_charts_through():
    room, pane = box(4.0, 3.0, 2.5), quad("pane", (0, 0, 0), (1, 0, 0), (0, 0, 1), "paint")
    atlas = lay_out([room, pane], [8.0, 16.0], margin=2, two_sided=(1,))
    assert [(each.mesh, each.is_back) for each in atlas.layouts] == [
        (0, False),
        (1, False),
        (1, True),
    ]
    assert atlas.chart_count == 8
    numbers = np.concatenate([each.chart for each in atlas.layouts])
    assert np.unique(numbers).tolist() == list(range(8))
    assert [each.density for each in atlas.layouts] == pytest.approx([8.0, 16.0, 16.0])
    front, back = atlas.layouts[1], atlas.layouts[2]
    assert np.ptp(front.uv.reshape(-1, 2), axis=0).tolist() == [16.0, 16.0]
    assert np.abs(front.uv - back.uv).max() >= 16 + 2 * 2
    # Corners of the axis-aligned walls lie on lumel borders.
    assert np.abs(atlas.layouts[0].uv - np.round(atlas.layouts[0].uv)).max() < 1e-9


def test_the_loss_is_reported_where_the_budget_is_short():
    room = box(4.0, 3.0, 2.5)
    atlas = lay_out([room], [50.0], largest=256, pages=1, margin=2)
    reached = atlas.layouts[0].density
    assert atlas.shrink < 1.0
    assert reached == pytest.approx(50.0 * atlas.shrink, rel=0.02)
    assert atlas.layouts[0].requested_density == 50.0
    long = lay_out([quad("wall", (0, 0, 0), (100, 0, 0), (0, 2, 0), "p")], [8.0], largest=256)
    assert any("larger than a page" in note for _, note in long.notes)
    assert long.layouts[0].density < 3.0


def test_factors_halve_single_charts():
    room = box(4.0, 3.0, 2.5)
    charts = find_all_charts([room], [8.0])
    factors = np.array([1.0, 0.5, 1.0, 1.0, 0.25, 1.0])
    atlas = arrange([room], charts, [8.0], margin=2, factors=factors)
    whole = arrange([room], charts, [8.0], margin=2)
    for number, factor in enumerate(factors):
        here = whole.layouts[0].chart == number
        extent = [
            np.ptp(each.layouts[0].uv[here].reshape(-1, 2), axis=0) for each in (whole, atlas)
        ]
        assert np.abs(extent[1] - extent[0] * factor).max() <= 0.5
    with pytest.raises(ValueError, match="6 charts"):
        arrange([room], charts, [8.0], factors=factors[:5])


def test_instances_get_room_of_their_own_and_share_the_search():
    one = box(2.0, 1.0, 1.0)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moved = replace(one, vertices=one.vertices @ turn.T + 5.0)
    grown = replace(one, vertices=one.vertices * 2.0)
    charts = find_all_charts([one, moved, grown], [8.0] * 3)
    assert charts[0] is charts[1]
    assert charts[2].size.max() == pytest.approx(2.0 * charts[0].size.max())
    atlas = arrange([one, moved, grown], charts, [8.0] * 3)
    numbers = [set(each.chart.tolist()) for each in atlas.layouts]
    assert not numbers[0] & numbers[1]


def test_a_mesh_without_surface_is_noted_and_one_alone_is_refused():
    room = box(1.0, 1.0, 1.0)
    flat = replace(room, name="flat", vertices=np.zeros((8, 3)))
    atlas = lay_out([room, flat], [8.0, 8.0])
    assert ("flat", "has no surface and gets no map") in atlas.notes
    assert (atlas.layouts[1].page == -1).all()
    with pytest.raises(SceneError, match="none of the objects has a surface"):
        lay_out([flat], [8.0])
    for density in (0.0, np.nan, np.inf):
        with pytest.raises(SceneError, match="lumels per metre"):
            lay_out([room], [density])


def test_the_user_can_stop_between_meshes():
    room, asked, seen = box(1.0, 1.0, 1.0), [], []

    def cancelled():
        asked.append(0)
        return len(asked) > 2

    with pytest.raises(Cancelled):
        lay_out([room] * 5, [8.0] * 5, cancelled=cancelled, progress=lambda *at: seen.append(at))
    assert seen == [(0, "box"), (1, "box")]


def test_the_density_of_pictures_is_their_pixels_per_metre():
    wall = quad("wall", (0, 0, 0), (4, 0, 0), (0, 2, 0), "m")
    picture = ImageTexture(np.zeros((100, 400, 3), np.float32))
    materials = {"m": Material("m", "m", Diffuse(picture))}
    # 400 x 100 pixels on 8 m2.
    assert texture_density(wall, materials) == pytest.approx(np.sqrt(40_000 / 8.0))
    tiled = replace(picture, transform=np.diag([3.0, 3.0, 1.0]))
    lamp = Material("m", "m", emission=Emission(pattern=tiled))
    assert texture_density(wall, {"m": lamp}) == pytest.approx(3.0 * np.sqrt(40_000 / 8.0))
    assert texture_density(wall, {"m": Material("m", "m")}) == 0.0
    # Of tiles side by side the finest counts for all.
    many = ImageTexture(
        np.zeros((1, 40_026, 3), np.float32), tiles=(Tile(0, 0, 400, 100), Tile(1, 0, 5, 5))
    )
    shown = {"m": Material("m", "m", Diffuse(many))}
    assert texture_density(wall, shown) == pytest.approx(np.sqrt(40_000 / 8.0))


def page_of(sizes):
    """A page with charts side by side, a free column between them."""
    width, height = sum(w + 1 for w, _ in sizes), max(h for _, h in sizes)
    owner = np.full((height, width), -1)
    x = 0
    for number, (w, h) in enumerate(sizes):
        owner[:h, x : x + w] = number
        x += w + 1
    return owner


def halvings(values, owner, threshold):
    atlas = Atlas(np.array([owner.shape[::-1]]), (), int(owner.max()) + 1, 1.0)
    return halve_even_charts(atlas, [values], [owner >= 0], [owner], threshold).tolist()


def test_charts_are_halved_as_long_as_nothing_is_lost():
    owner = page_of([(16, 16), (16, 16), (16, 16), (16, 8)])
    y, x = np.indices(owner.shape)
    values = np.zeros(owner.shape)
    # Even; a slope of 1 lx a lumel; a single spot; a checkerboard that any halving would lose.
    values[owner == 0] = 100.0
    values[owner == 1] = (x - 17.0)[owner == 1]
    values[5, 34 + 3] = 50.0
    values[owner == 3] = ((x + y) % 2 * 10.0)[owner == 3]
    # On the slope the means of n x n lumels differ from those of n/2 x n/2 by n/4: below 3.0 up to n = 8.
    assert halvings(values, owner, 3.0) == [1 / 16, 1 / 8, 1.0, 1.0]
    assert halvings(values, owner, 0.4) == [1 / 16, 1.0, 1.0, 1.0]
    assert halvings(values, owner, 0.6) == [1 / 16, 1 / 2, 1.0, 1.0]


def test_blocks_are_counted_from_each_charts_own_corner():
    # Steps every second lumel, on a chart that begins at an odd column: its own blocks are even.
    owner = np.full((6, 11), -1)
    owner[1:5, 3:11] = 0
    values = np.zeros(owner.shape)
    values[:, 3:] = np.arange(8) // 2 * 100.0
    assert halvings(values, owner, 1.0) == [0.5]


def test_charts_without_lumels_keep_their_density():
    owner = page_of([(4, 4)])
    atlas = Atlas(np.array([owner.shape[::-1]]), (), 3, 1.0)
    found = halve_even_charts(atlas, [np.ones(owner.shape)], [owner >= 0], [owner], 0.1)
    assert found.tolist() == [0.25, 1.0, 1.0]
