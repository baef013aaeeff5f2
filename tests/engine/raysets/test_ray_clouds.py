"""Rays generated from a ray set: where they start, what light they make, and how that light converges."""

import functools

import numpy as np
import pytest
from ray_files import lambert_rays, zemax

from lumenray.benchmarks.common.ray_sources import (
    RADIUS,
    SOURCES,
    disk,
    even_numbers,
    helix,
    landed_shares,
    numbers,
    sphere,
)
from lumenray.engine.errors import Cancelled
from lumenray.engine.raysets import cloud as cloud_module
from lumenray.engine.raysets.body import Hull, Plane, Sphere, find_body
from lumenray.engine.raysets.cloud import Fluctuation, alias_table, hold_rays, make_cloud
from lumenray.engine.raysets.reader import read_rayset
from lumenray.engine.raysets.record import Rays
from lumenray.engine.raysets.reduction import is_rotational, reduce_rays, view_rays
from lumenray.engine.raysets.symmetry import find_axis

COUNTED = 10_000
"""Rays of the sets."""

CELLS = 10
"""Along each side of a plane on which illuminances are compared."""


@functools.cache
def cloud_of(source, count=COUNTED, seed=1, choose=even_numbers):
    """Cloud of a synthetic source of 100 lm."""
    position, direction = source(choose(count, seed))
    return make_cloud(Rays(position, direction, np.ones(count, np.float32)), 100.0)


def relative_rms(found, exact):
    return float(np.sqrt(((found - exact) ** 2).mean()) / exact.mean())


@pytest.fixture
def few_made(monkeypatch):
    """Compare fewer rays, for what does not ask how well."""
    monkeypatch.setattr(cloud_module, "MADE", 1 << 14)


# ---- the body ----


def test_a_flat_source_is_found_and_its_rays_stay_on_it():
    turn = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
    position, direction = (each @ turn.T for each in disk(numbers(2000, 1)))
    body = find_body(position + 0.3, direction)
    assert isinstance(body, Plane)
    assert body.is_one_sided
    np.testing.assert_allclose(np.abs(body.normal @ turn[:, 2]), 1.0, atol=1e-6)
    rng = np.random.default_rng(4)
    astray = position + 0.3 + 0.2 * RADIUS * rng.standard_normal(position.shape)
    skew = direction + rng.standard_normal(direction.shape)
    placed, sent = body.place(astray, skew / np.linalg.norm(skew, axis=1, keepdims=True))
    assert np.abs((placed - body.centre) @ body.normal).max() < 1e-9
    assert (sent @ body.normal).min() >= 0.0
    # The hull is a polygon around the disk.
    assert np.linalg.norm(placed - 0.3, axis=1).max() < 1.02 * RADIUS


def test_a_sphere_is_found_and_its_rays_start_on_it():
    position, direction = sphere(numbers(2000, 1))
    body = find_body(position + 0.2, direction)
    assert isinstance(body, Sphere)
    np.testing.assert_allclose(body.centre, 0.2, atol=1e-5)
    assert body.radius == pytest.approx(RADIUS, rel=1e-3)
    rng = np.random.default_rng(4)
    astray = position + 0.2 + 0.3 * RADIUS * rng.standard_normal(position.shape)
    placed, sent = body.place(astray, direction)
    np.testing.assert_allclose(np.linalg.norm(placed - body.centre, axis=1), body.radius, rtol=1e-6)
    # It leaves the sphere there, or passes by.
    outward = ((placed - body.centre) * sent).sum(axis=1)
    assert outward.min() > -1e-6


def test_rays_of_any_other_body_leave_its_hull_and_start_nowhere_else():
    position, direction = helix(numbers(4000, 1))
    body = find_body(position, direction)
    assert isinstance(body, Hull)
    rng = np.random.default_rng(4)
    astray = position + 0.3 * RADIUS * rng.standard_normal(position.shape)
    placed, sent = body.place(astray, direction)
    heights = placed @ body.normals.T
    slack = 1e-6 * RADIUS
    assert (heights < body.high + slack).mean() > 0.999
    assert (heights > body.low - slack).mean() > 0.999
    ahead = (placed + 1e-3 * RADIUS * sent) @ body.normals.T
    assert ((ahead > body.high) | (ahead < body.low)).any(axis=1).mean() > 0.99


# ---- symmetry ----


def turned(vectors, seed=11):
    """The same vectors in a frame that is turned somehow."""
    return vectors @ np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0].T


def axis_of(position, direction):
    rays = Rays(position, direction, np.ones(len(position), np.float32))
    return find_axis(rays, find_body(position, direction))


def test_a_source_that_is_even_all_around_gets_its_axis():
    position, direction = disk(numbers(4000, 1))
    axis = axis_of(turned(position) + 0.05, turned(direction))
    assert abs(axis.direction @ turned(np.array([0.0, 0.0, 1.0]))) == pytest.approx(1.0, abs=1e-6)
    np.testing.assert_allclose(axis.centre, 0.05, atol=0.02 * RADIUS)
    assert axis_of(*sphere(numbers(4000, 1))) is not None


def square(u):
    """A square chip that shines by the cosine law."""
    position = np.zeros((len(u), 3), np.float32)
    position[:, :2] = RADIUS * (2.0 * u[:, :2] - 1.0)
    return position, disk(u[:, [0, 1, 2, 3]])[1]


def narrowed(u):
    """A disk whose light is pressed towards one plane, as by a cylindrical lens."""
    position, direction = disk(u)
    direction = direction * np.array([0.8, 1.0, 1.0], np.float32)
    return position, direction / np.linalg.norm(direction, axis=1, keepdims=True)


def skew(u):
    """A disk whose one half shines to the side: positions and directions are even, but not together."""
    position, direction = disk(u)
    turn = np.arctan2(position[:, 1], position[:, 0])
    lean = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1) * np.cos(2.0 * turn)[:, None]
    direction = direction + 0.5 * lean
    direction[:, 2] = np.abs(direction[:, 2])
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return position, direction.astype(np.float32)


@pytest.mark.parametrize("source", [square, narrowed, skew, helix])
def test_a_source_that_is_not_even_gets_none(source):
    assert axis_of(*source(numbers(10_000, 1))) is None


def test_even_sources_are_seldom_taken_for_uneven_ones():
    found = [axis_of(*disk(numbers(500, seed))) is not None for seed in range(60)]
    assert np.mean(found) > 0.95


@pytest.mark.slow
def test_turned_rays_are_the_same_all_around_and_the_user_has_the_last_word():
    position, direction = disk(numbers(300, 1))
    rays = Rays(position, direction, np.ones(300, np.float32))
    made = {
        kind: make_cloud(rays, 1.0, Fluctuation(0.01, is_symmetric=kind)) for kind in (None, False)
    }
    assert made[None].axis is not None
    assert made[False].axis is None

    def unevenness(cloud):
        d = cloud.draw(200_000, np.random.default_rng(1)).direction
        share = np.bincount(((np.arctan2(d[:, 1], d[:, 0]) / np.pi + 1.0) * 8).astype(int) % 16)
        return share.std() / share.mean()

    assert unevenness(made[None]) < 0.02
    assert unevenness(made[False]) > 0.05
    forced = make_cloud(
        Rays(*square(numbers(3000, 1)), np.ones(3000, np.float32)),
        1.0,
        Fluctuation(0.01, is_symmetric=True),
    )
    assert forced.axis is not None


# ---- generation ----


def test_the_alias_table_has_exactly_the_chances_of_the_weights():
    rng = np.random.default_rng(5)
    weight = np.concatenate([rng.exponential(1.0, 500), [0.0, 1e-9, 40.0, 300.0]])
    kept, other = alias_table(weight)
    chance = kept.astype(np.float64)
    np.add.at(chance, other, 1.0 - kept.astype(np.float64))
    np.testing.assert_allclose(chance / len(weight), weight / weight.sum(), atol=1e-9, rtol=1e-6)


@pytest.mark.slow
def test_flux_is_kept_and_rays_take_little_memory():
    cloud = cloud_of(disk)
    drawn = cloud.draw(5000, np.random.default_rng(1))
    assert drawn.flux.sum() == pytest.approx(100.0)
    np.testing.assert_allclose(np.linalg.norm(drawn.direction, axis=1), 1.0, atol=1e-6)
    assert cloud.bytes_per_ray <= 40.0
    coloured = make_cloud(
        Rays(*disk(numbers(4096, 1)), np.ones(4096, np.float32), np.full(4096, 550, np.float32)),
        1.0,
    )
    assert coloured.bytes_per_ray <= 40.0


@pytest.mark.slow
def test_bright_rays_are_picked_as_often_as_they_are_bright():
    position, direction = disk(numbers(1000, 1))
    weight = np.where(position[:, 0] > 0.0, 3.0, 1.0).astype(np.float32)
    cloud = make_cloud(Rays(position, direction, weight), 1.0, Fluctuation(position=0, direction=0))
    drawn = cloud.draw(200_000, np.random.default_rng(2))
    expected = weight[position[:, 0] > 0.0].sum() / weight.sum()
    assert (drawn.position[:, 0] > 0.0).mean() == pytest.approx(expected, abs=0.004)


@pytest.mark.slow
def test_widths_of_the_user_take_the_place_of_the_sets_own():
    position, direction = disk(numbers(1024, 1))
    rays = Rays(position, direction, np.ones(1024, np.float32))
    still = make_cloud(rays, 1.0, Fluctuation(position=0.0, direction=0.0))
    drawn = still.draw(500, np.random.default_rng(1))
    apart = np.linalg.norm(drawn.position[:, None] - position, axis=2).min(axis=1)
    assert apart.max() < 1e-5 * RADIUS
    wide = make_cloud(rays, 1.0, Fluctuation(position=0.0, direction=0.1))
    moved = wide.draw(20_000, np.random.default_rng(1)).direction
    nearest = np.max(moved @ direction.T, axis=1)
    assert np.degrees(np.arccos(np.clip(nearest, -1, 1))).max() > 1.0


@pytest.mark.parametrize("name", SOURCES)
@pytest.mark.slow
def test_light_of_few_even_rays_is_right_within_two_percent(name):
    """Illuminance on planes at two and five times the source's size, against the closed form."""
    source, exact = SOURCES[name]
    errors = _plane_errors(source, exact, even_numbers, (1, 2) if source is helix else (1,))
    assert np.sqrt(errors.mean()) < 0.02


@pytest.mark.slow
def test_light_of_few_random_rays_is_smooth():
    """Some 1000 of 10 000 random rays of the filament meet the plane, so its flux alone is uncertain by three percent."""
    errors = _plane_errors(*SOURCES["helix"], numbers, (1,))
    assert np.sqrt(errors.mean()) < 0.04


def _plane_errors(source, exact, choose, seeds) -> np.ndarray:
    """Squares of the relative errors of clouds at two distances, without the part of chance."""
    errors, drawn_rays = [], 3 << 19
    for seed in seeds:
        raw = source(choose(COUNTED, seed))
        drawn = cloud_of(source, COUNTED, seed, choose).draw(drawn_rays, np.random.default_rng(7))
        for distance in (2.0, 5.0):
            height = 2.0 * RADIUS * distance + RADIUS
            true = exact(height, CELLS)
            made = landed_shares(drawn.position, drawn.direction, height, CELLS, drawn.flux)
            errors.append(relative_rms(made, true) ** 2 - 1.0 / (drawn_rays * true.mean()))
            # Rays repeated give far more noise than that.
            assert relative_rms(landed_shares(*raw, height, CELLS), true) > 0.08
    return np.array(errors)


@pytest.mark.parametrize("name", SOURCES)
def test_the_exact_light_is_what_many_rays_bring(name):
    source, exact = SOURCES[name]
    height, count = 5.0 * RADIUS, 1 << 20
    true, found = exact(height, CELLS), landed_shares(*source(numbers(count, 9)), height, CELLS)
    # Chi-square with 100 degrees of freedom, 0.1 %.
    assert (count * (found - true) ** 2 / true).sum() < 149.4


@pytest.mark.slow
def test_twice_the_rays_have_half_the_variance_beyond_those_of_the_file():
    """No plateau from repetition: variances over replicates, at 1 to 64 times as many rays as the file has."""
    cloud = cloud_of(sphere, 2000)
    height = 6.0 * RADIUS
    variances = []
    for count in (2000, 16_000, 128_000):
        cells = []
        for seed in range(24):
            drawn = cloud.draw(count, np.random.default_rng(seed))
            cells.append(landed_shares(drawn.position, drawn.direction, height, 6, drawn.flux))
        variances.append(count * np.var(cells, axis=0, ddof=1).mean())
    # 36 cells with 23 degrees of freedom each: 5 % of scatter, which three times are allowed.
    np.testing.assert_allclose(variances[1:], variances[0], rtol=0.15)


@pytest.mark.slow
def test_the_stated_error_is_that_of_other_sets_of_the_same_source():
    """Intensities of clouds of independent sets scatter as much as each cloud says of itself, within a factor."""
    stated, made = [], []
    for seed in range(6):
        cloud = cloud_of(sphere, 3000, 100 + seed, numbers)
        stated.append(cloud.information_error)
        drawn = cloud.draw(1 << 18, np.random.default_rng(3))
        band = np.minimum((6 * (1 + drawn.direction[:, 2])).astype(int), 11)
        turn = np.arctan2(drawn.direction[:, 1], drawn.direction[:, 0]) / (2 * np.pi) + 0.5
        cell = band * 16 + np.minimum((16 * turn).astype(int), 15)
        made.append(np.bincount(cell, drawn.flux, 192))
    found = np.sqrt(np.var(made, axis=0, ddof=1).mean()) / np.mean(made)
    assert 0.6 < np.mean(stated) / found < 1.6


@pytest.mark.slow
def test_the_unit_of_length_changes_nothing_but_lengths():
    position, direction = helix(numbers(2048, 1))
    ones = np.ones(2048, np.float32)
    small = make_cloud(Rays(position, direction, ones), 1.0)
    large = make_cloud(Rays(position * 1024.0, direction, ones), 1.0)
    assert large.share == small.share
    first, second = (each.draw(1000, np.random.default_rng(1)) for each in (small, large))
    np.testing.assert_allclose(first.position * 1024.0, second.position, atol=1e-3 * 1024 * RADIUS)
    np.testing.assert_allclose(first.direction, second.direction, atol=1e-4)


def test_the_same_seed_gives_the_same_rays(few_made):
    first, second = (cloud_of.__wrapped__(disk, 2000, seed=1) for _ in range(2))
    a, b = (cloud.draw(100, np.random.default_rng(5)) for cloud in (first, second))
    assert np.array_equal(a.position, b.position)
    assert np.array_equal(a.direction, b.direction)


@pytest.mark.parametrize("count", [1, 2, 3, 40])
def test_very_small_sets_work(count, few_made):
    position, direction = disk(numbers(64, 1))
    cloud = make_cloud(Rays(position[:count], direction[:count], np.ones(count, np.float32)), 5.0)
    drawn = cloud.draw(1000, np.random.default_rng(1))
    assert np.isfinite(drawn.position).all()
    assert np.isfinite(drawn.direction).all()
    assert drawn.flux.sum() == pytest.approx(5.0)


def test_a_point_source_stays_a_point(few_made):
    direction = disk(numbers(2000, 1))[1]
    point = np.full((2000, 3), 0.02, np.float32)
    drawn = make_cloud(Rays(point, direction, np.ones(2000, np.float32)), 1.0).draw(
        1000, np.random.default_rng(1)
    )
    assert np.abs(drawn.position - 0.02).max() < 1e-7


def test_of_large_files_a_part_is_held(tmp_path):
    path = tmp_path / "lamp.dat"
    path.write_bytes(zemax(lambert_rays(20_000)))
    file = read_rayset(path)
    part = hold_rays(file, 5000, seed=3)
    assert 4600 < len(part) < 5400
    again = hold_rays(file, 5000, seed=3)
    assert np.array_equal(part.position, again.position)
    assert len(hold_rays(file)) == 20_000


def test_preparation_can_be_stopped():
    position, direction = disk(numbers(4096, 1))
    with pytest.raises(Cancelled):
        make_cloud(
            Rays(position, direction, np.ones(4096, np.float32)), 1.0, cancelled=lambda: True
        )


# ---- reduction ----


def test_intensities_of_a_disk_follow_the_cosine_and_keep_the_flux():
    cloud = cloud_of(disk, 3000)
    rng = np.random.default_rng(3)
    pieces = [(d.direction, d.flux / 4) for d in (cloud.draw(1 << 17, rng) for _ in range(4))]
    reduced = reduce_rays(pieces, 2.5, 1)
    polar, table = reduced.distribution.polar, reduced.distribution.intensity[0]
    exact = 100.0 / np.pi * np.maximum(np.cos(polar), 0.0)
    # Straight ahead the cell is so small that it has few rays.
    inside = (polar > np.deg2rad(1.0)) & (polar < np.deg2rad(75.0))
    np.testing.assert_allclose(table[inside], exact[inside], atol=0.05 * exact[0])
    from lumenray.engine.luminaires.distribution import flux

    assert flux(reduced.distribution) == pytest.approx(100.0, rel=1e-9)
    assert is_rotational(reduce_rays(pieces, 5.0, 24))


def test_rays_go_to_the_side_where_the_luminaire_has_them():
    """The luminaire is turned by half a turn about x: +z becomes -z, +y becomes -y, C counts from +x."""
    towards = np.array([[np.sin(0.5) * np.cos(0.6), np.sin(0.5) * np.sin(0.6), np.cos(0.5)]])
    reduced = reduce_rays([(towards, np.ones(1))], 1.0, 360)
    column, row = np.unravel_index(
        np.argmax(reduced.distribution.intensity), reduced.distribution.intensity.shape
    )
    assert np.degrees(reduced.distribution.polar[row]) == pytest.approx(np.degrees(0.5), abs=1.0)
    turn = np.degrees(reduced.distribution.azimuth[column])
    assert turn == pytest.approx(360.0 - np.degrees(0.6), abs=1.0)
    assert not is_rotational(reduced)


def test_the_luminance_of_a_disk_is_its_exitance_over_pi():
    position, direction = disk(numbers(1 << 20, 1))
    flux = np.full(len(position), 100.0 / len(position))
    image = view_rays(
        [(position, direction, flux)], (0.0, 0.0, 1.0), np.zeros(3), 3.0 * RADIUS, 30, cone=6.0
    )
    place = (np.arange(30) + 0.5) / 30 * 3.0 - 1.5
    away = np.hypot(*np.meshgrid(place, place))
    expected = 100.0 / (np.pi * RADIUS**2) / np.pi
    inside = image.luminance[away < 0.9]
    assert inside.mean() == pytest.approx(expected, rel=0.02)
    assert image.luminance[away > 1.15].max() == 0.0
    assert image.rays == pytest.approx(len(position) * np.sin(np.deg2rad(6.0)) ** 2, rel=0.05)


def test_a_tilted_view_shows_the_disk_narrowed():
    position, direction = disk(numbers(1 << 20, 1))
    flux = np.full(len(position), 1.0 / len(position))
    towards = (np.sin(1.0), 0.0, np.cos(1.0))
    image = view_rays([(position, direction, flux)], towards, np.zeros(3), 3.0 * RADIUS, 60, 5.0)
    lit = image.luminance > 0.2 * image.luminance.max()
    wide, high = lit.any(axis=0).sum(), lit.any(axis=1).sum()
    assert wide / high == pytest.approx(np.cos(1.0), abs=0.08)
