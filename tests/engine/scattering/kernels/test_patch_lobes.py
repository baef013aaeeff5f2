"""Lobes of patches and trees: sampled as their density tells, worth what the data tell, and no more than arrives."""

from dataclasses import replace

import numpy as np
import pytest
from device_values import vectors

from lumenray.engine.scattering.data.patches import albedos, evaluate_patches, patch_of
from lumenray.engine.scattering.data.tree import (
    albedos_of_tree,
    disk_of,
    evaluate_tree,
    grow_children,
    square_of,
)
from lumenray.engine.scene.scattering import PatchBasis, PatchMatrix, TensorTree
from lumenray.engine.transport import backend

pytestmark = pytest.mark.mitsuba

NEUTRAL = np.array([555.0])

QUARTER = PatchBasis(np.radians([0.0, 9.0, 27.0, 45.0, 63.0, 90.0]), np.array([1, 8, 12, 12, 8]))

HALF = PatchBasis(
    np.radians([0.0, 6.5, 19.5, 32.5, 45.5, 58.5, 71.5, 90.0]), np.array([1, 8, 12, 16, 20, 12, 8])
)

COUNT = 1 << 17


@pytest.fixture(autouse=True)
def _photometric():
    backend.start(spectral=False)


def peaked(shape, seed: int) -> np.ndarray:
    """Values of which few are large and some nothing, as of blinds."""
    values = np.random.default_rng(seed).lognormal(-3.0, 1.5, shape)
    values[values < 0.01] = 0.0
    return values.astype(np.float32)


def full_tree(rank: int, levels: int, seed: int) -> TensorTree:
    values = peaked((1 << rank * levels, 1), seed)
    return TensorTree(rank, grow_children(rank, levels), NEUTRAL, values)


def deep_tree(rank: int, levels: int) -> TensorTree:
    """One narrow peak, far finer than the grid of sampling, on even ground."""
    fan = 1 << rank
    children = np.full((levels, fan), -1, dtype=np.int32)
    # Towards the middle of the disk, and of rank 3 to the normal as well: the coordinates go to 1/2 from below.
    children[0, 0] = 1
    for level in range(1, levels - 1):
        children[level, fan - 1] = level + 1
    children[-1, fan - 1] = -2
    peak = 0.4 / np.pi * 4.0**levels
    return TensorTree(rank, children, NEUTRAL, np.array([[0.3 / np.pi], [peak]], np.float32))


MATRIX = PatchMatrix(HALF, QUARTER, NEUTRAL, peaked((77, 41, 1), 1))

SCATTERS = {
    "patches": MATRIX,
    "isotropic tree": full_tree(3, 3, 2),
    "tree": full_tree(4, 2, 3),
    "deep isotropic tree": deep_tree(3, 10),
    "deep tree": deep_tree(4, 8),
}


def keep(values, _):
    return values


def lobe_of(scatter, weigh=keep, factor=1.0):
    from lumenray.engine.scattering.kernels.patch_lobe import PatchLobe
    from lumenray.engine.scattering.kernels.tree_lobe import TreeLobe

    return (PatchLobe if isinstance(scatter, PatchMatrix) else TreeLobe)(scatter, weigh, factor)


def array(vector) -> np.ndarray:
    return np.stack([np.array(c) for c in vector], axis=1).astype(np.float64)


def towards(polar: float, azimuth: float) -> np.ndarray:
    sine = np.sin(polar)
    return np.array([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(polar)])


INCIDENTS = [towards(0.01, 0.4), towards(0.7, 2.0), towards(1.35, 4.1)]


def draw(lobe, wi, count: int = COUNT, seed: int = 5) -> np.ndarray:
    import mitsuba as mi

    stream = mi.PCG32(size=count, initstate=seed)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    return array(lobe.sample(mi.Vector3f(*map(float, wi)), sample, mi.Bool(True)))


def value_and_density(lobe, wi, wo, wavelengths=()) -> tuple[np.ndarray, np.ndarray]:
    import mitsuba as mi

    wi = vectors(np.broadcast_to(wi, wo.shape))
    value, density = lobe.evaluate(wi, vectors(wo), wavelengths, mi.Bool(True))
    return np.array(value).astype(np.float64), np.array(density).astype(np.float64)


def total_of(scatter, wi) -> float:
    if isinstance(scatter, PatchMatrix):
        return albedos(scatter)[patch_of(scatter.incoming, wi[None])[0], 0]
    return albedos_of_tree(scatter, wi[None])[0, 0]


def normal_score(chi: float, freedom: int) -> float:
    """Chi-square as a number of standard deviations, after Wilson and Hilferty."""
    spread = 2.0 / (9.0 * freedom)
    return ((chi / freedom) ** (1 / 3) - (1.0 - spread)) / np.sqrt(spread)


@pytest.mark.parametrize("name", SCATTERS)
def test_values_are_those_of_double_precision(name):
    scatter, rng = SCATTERS[name], np.random.default_rng(6)
    pairs = rng.normal(size=(2, 20000, 3))
    pairs[..., 2] = np.abs(pairs[..., 2]) + 1e-3
    wi, wo = pairs / np.linalg.norm(pairs, axis=2, keepdims=True)
    # Peaks are met too.
    wo[:1000], wi[:1000] = towards(1e-4, 3.9), towards(1e-4, 3.9)
    evaluate = evaluate_patches if isinstance(scatter, PatchMatrix) else evaluate_tree
    expected = evaluate(scatter, wi, wo)[:, 0] * wo[:, 2]
    found = value_and_density(lobe_of(scatter), wi, wo)[0].ravel()
    wrong = np.abs(found - expected) > 1e-4 * expected + 1e-7
    # Single precision takes hardly any direction across an edge.
    assert wrong.mean() < 1e-3


@pytest.fixture(params=["fine", "coarse"])
def grid(request, monkeypatch):
    """Sampling by a grid as fine as the tree, or by descent below a coarse one."""
    from lumenray.engine.scattering.kernels import tree_lobe

    if request.param == "coarse":
        monkeypatch.setattr(tree_lobe, "FINEST_GRID", {3: 1, 4: 1})
    return request.param


@pytest.mark.parametrize("number", range(3))
@pytest.mark.parametrize("name", SCATTERS)
@pytest.mark.slow
def test_sampled_directions_follow_the_stated_density(name, number, grid):
    wi = INCIDENTS[number]
    lobe = lobe_of(SCATTERS[name])
    wo = draw(lobe, wi)
    assert np.all(wo[:, 2] > 0.0)
    assert np.linalg.norm(wo, axis=1) == pytest.approx(1.0, abs=1e-5)
    # Bins of equal shares of the disk, their edges at none of the data's; expected from 24 x 24 points in each.
    bins, fine = 21, 24
    u, v = square_of(wo[:, 0], wo[:, 1])
    observed = np.histogram2d(u, v, bins=bins, range=((0, 1), (0, 1)))[0]
    axis = (np.arange(bins * fine) + 0.5) / (bins * fine)
    x, y = disk_of(*(m.ravel() for m in np.meshgrid(axis, axis, indexing="ij")))
    points = np.stack([x, y, np.sqrt(1.0 - x * x - y * y)], axis=1)
    density = value_and_density(lobe, wi, points)[1] / points[:, 2] * np.pi
    expected = density.reshape(bins, fine, bins, fine).mean(axis=(1, 3)) * COUNT / bins**2
    # Points sit across edges of cells by half their distance, 1 / 1008 of the square.
    error = np.ptp(density.reshape(bins, fine, bins, fine), axis=(1, 3)) * COUNT / bins**2 / fine
    enough = expected > 8
    chi = ((observed - expected)[enough] ** 2 / (expected + error**2)[enough]).sum()
    assert expected.sum() == pytest.approx(COUNT, rel=0.01)
    assert normal_score(chi, int(enough.sum()) - 1) < 4.0


@pytest.mark.parametrize("name", ["patches", "isotropic tree", "tree"])
def test_density_and_samples_agree_within_the_cells_of_the_data(name, grid):
    """Cells are cut in four, so that both the choice of a cell and the spread in it are tested, without any quadrature."""
    wi, scatter = INCIDENTS[1], SCATTERS[name]
    lobe = lobe_of(scatter)
    wo = draw(lobe, wi)
    if isinstance(scatter, PatchMatrix):
        cell = patch_of(scatter.outgoing, wo)
        bounds = np.sin(scatter.outgoing.bounds) ** 2
        ring = np.repeat(np.arange(5), scatter.outgoing.counts)[cell]
        place = ((wo[:, :2] ** 2).sum(axis=1) - bounds[ring]) / np.diff(bounds)[ring]
        turn = np.arctan2(wo[:, 1], wo[:, 0]) / (2 * np.pi) * scatter.outgoing.counts[ring] + 0.5
        part = 2 * (place > 0.5) + (turn % 1.0 > 0.5)
        cells = len(scatter.values[0])
    else:
        side = 8 if scatter.rank == 3 else 4
        x, y = wo[:, 0], wo[:, 1]
        if scatter.rank == 3:
            c, s = -wi[:2] / np.hypot(*wi[:2])
            x, y = c * x + s * y, c * y - s * x
        u, v = (2 * side * c for c in square_of(x, y))
        cell = (u // 2 * side + v // 2).astype(int)
        part = (2 * (u.astype(int) % 2) + v.astype(int) % 2).astype(int)
        cells = side * side
    observed = np.bincount(4 * cell + part, minlength=4 * cells)
    share = value_and_density(lobe, wi, wo)[1] / wo[:, 2]
    density = np.bincount(cell, share, cells) / np.maximum(np.bincount(cell, minlength=cells), 1)
    area = (
        np.repeat(np.pi * np.diff(bounds) / scatter.outgoing.counts, scatter.outgoing.counts)
        if isinstance(scatter, PatchMatrix)
        else np.pi / cells
    )
    expected = np.repeat(density * area * COUNT / 4, 4)
    enough = expected > 8
    chi = ((observed - expected)[enough] ** 2 / expected[enough]).sum()
    assert expected.sum() == pytest.approx(COUNT, rel=1e-3)
    assert normal_score(chi, int(enough.sum()) - 1) < 4.0


def weights_of(lobe, wi, seed: int = 7) -> np.ndarray:
    """Value over density of samples; of those that rounding takes to where nothing is scattered, 0."""
    value, density = value_and_density(lobe, wi, draw(lobe, wi, seed=seed))
    lost = density == 0.0
    assert lost.mean() < 1e-4
    assert not value.ravel()[lost].any()
    return np.where(lost, 0.0, value.ravel() / np.where(lost, 1.0, density))


@pytest.mark.parametrize("name", ["patches", "isotropic tree", "tree"])
def test_every_sample_is_worth_the_share_that_is_scattered(name):
    lobe = lobe_of(SCATTERS[name])
    for wi in INCIDENTS:
        weight, expected = weights_of(lobe, wi), total_of(SCATTERS[name], wi)
        assert weight.mean() == pytest.approx(expected, rel=2e-4)
        # As good as can be; rounding matters in the narrowest cells only.
        assert (np.abs(weight - expected) > 0.01 * expected).mean() < 1e-4


@pytest.mark.parametrize("name", ["deep isotropic tree", "deep tree"])
def test_peaks_finer_than_the_grid_are_found_and_the_ground_beside_them_too(name):
    scatter = SCATTERS[name]
    lobe = lobe_of(scatter)
    into_peak = towards(1e-3, 3.9)
    assert total_of(scatter, into_peak) == pytest.approx(0.7, rel=1e-3)
    for wi in (into_peak, *INCIDENTS):
        weight, expected = weights_of(lobe, wi), total_of(scatter, wi)
        deviation = weight.std() / np.sqrt(COUNT)
        assert abs(weight.mean() - expected) < 4.0 * deviation + 1e-3 * expected
        assert deviation < 0.02 * expected
        if wi is not into_peak:
            assert weight.max() < 0.3 / 0.1


@pytest.mark.parametrize("factor", [1.0, 0.5])
def test_lobes_tell_the_share_that_they_scatter(factor):
    import mitsuba as mi

    for name in ("patches", "isotropic tree", "tree"):
        lobe = lobe_of(SCATTERS[name], factor=factor)
        found = lobe.albedo(vectors(INCIDENTS), mi.Bool(True))
        expected = [factor * total_of(SCATTERS[name], wi) for wi in INCIDENTS]
        assert np.array(found) == pytest.approx(expected, rel=1e-4)
        assert weights_of(lobe, INCIDENTS[1]).mean() == pytest.approx(expected[1], rel=2e-4)


def test_reciprocal_data_stay_so():
    values = peaked((77, 77, 1), 8)
    matrix = PatchMatrix(HALF, HALF, NEUTRAL, values + values.transpose(1, 0, 2))
    lobe, rng = lobe_of(matrix), np.random.default_rng(9)
    a, b = rng.normal(size=(2, 2000, 3))
    a[:, 2], b[:, 2] = np.abs(a[:, 2]) + 0.05, np.abs(b[:, 2]) + 0.05
    a, b = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in (a, b))
    there = value_and_density(lobe, a, b)[0].ravel() / b[:, 2]
    again = value_and_density(lobe, b, a)[0].ravel() / a[:, 2]
    assert there == pytest.approx(again, rel=1e-5)


def test_a_white_furnace_loses_and_adds_nothing():
    matrix = PatchMatrix(HALF, QUARTER, NEUTRAL, np.full((77, 41, 1), 1 / np.pi, np.float32))
    white = TensorTree(4, np.full((1, 16), -1, np.int32), NEUTRAL, np.full((1, 1), 1 / np.pi))
    for scatter in (matrix, white, replace(white, rank=3, children=white.children[:, :8])):
        lobe = lobe_of(scatter)
        for wi in INCIDENTS:
            value, density = value_and_density(lobe, wi, draw(lobe, wi, 4096))
            assert value.ravel() / density == pytest.approx(1.0, rel=1e-5)


def test_black_directions_are_sampled_and_carry_nothing():
    values = MATRIX.values.copy()
    values[patch_of(HALF, INCIDENTS[1][None])[0]] = 0.0
    tree = TensorTree(4, np.full((1, 16), -1, np.int32), NEUTRAL, np.zeros((1, 1)))
    for scatter in (replace(MATRIX, values=values), tree):
        lobe = lobe_of(scatter)
        value, density = value_and_density(lobe, INCIDENTS[1], draw(lobe, INCIDENTS[1], 4096))
        assert not value.any()
        assert np.all(density > 0.0)


def test_bands_are_linear_in_between_and_can_be_weighed_to_one():
    wavelengths = np.array([400.0, 500.0, 700.0])
    values = np.stack([MATRIX.values[..., 0] * k for k in (1.0, 2.0, 4.0)], axis=-1)
    coloured = replace(MATRIX, wavelengths=wavelengths, values=values)
    lobe = lobe_of(coloured, lambda values, w: values @ np.full((len(w), 1), 1.0 / 3.0))
    wo = draw(lobe, INCIDENTS[1], 4096)
    value, density = value_and_density(lobe, INCIDENTS[1], wo)
    assert value.ravel() / density == pytest.approx(
        7.0 / 3.0 * total_of(MATRIX, INCIDENTS[1]), rel=1e-3
    )
    backend.start(spectral=True)
    plain = value_and_density(lobe_of(MATRIX), INCIDENTS[1], wo)[0]
    found = value_and_density(lobe_of(coloured), INCIDENTS[1], wo, (380.0, 450.0, 600.0, 800.0))[0]
    factor = np.array([1.0, 1.5, 3.0, 4.0])[:, None]
    assert found == pytest.approx(plain * factor, rel=1e-4)


def test_all_data_of_a_kind_share_a_kernel():
    import drjit as dr
    import mitsuba as mi

    def kernel(scatter):
        lobe = lobe_of(scatter)
        wi, sample = vectors([INCIDENTS[1]] * 64), mi.Point2f(dr.arange(mi.Float, 64) / 64, 0.5)
        dr.eval(wi, sample)
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            wo = lobe.sample(wi, sample, mi.Bool(True))
            value, density = lobe.evaluate(wi, wo, (), mi.Bool(True))
            dr.eval(wo, value, density)
            return {entry["hash"] for entry in dr.kernel_history([dr.KernelType.JIT])}

    for first, second in (
        (MATRIX, replace(MATRIX, values=peaked((77, 41, 1), 10))),
        (full_tree(4, 2, 3), full_tree(4, 2, 11)),
        (full_tree(3, 3, 2), full_tree(3, 3, 12)),
    ):
        assert kernel(first) == kernel(second)
