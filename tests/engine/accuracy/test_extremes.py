"""Least and largest values of noisy maps whose true ones are known: the stated ranges hold them."""

import math

import numpy as np
import pytest
from baking_rooms import bake, furnished_room, lamp, moved
from small_scenes import paint

from lumenray.engine.accuracy.extremes import Halves, divide, find_largest, find_least, part_by_mean
from lumenray.engine.accuracy.replicates import ReplicateSums

PASSES = 8
SIDE = 48


def true_maps():
    """Maps with few and with many places near their extremes. [lx]"""
    x, y = np.meshgrid(*2 * [(np.arange(SIDE) + 0.5) / SIDE])
    spike = np.full_like(x, 100.0)
    spike[7, 30], spike[40, 9] = 160.0, 40.0
    return {
        "flat": np.full_like(x, 100.0),
        "slope": 20.0 + 300.0 * x,
        "corner": 20.0 + 200.0 * (x + y),
        "peak": 30.0 + 300.0 * np.exp(-((x - 0.4) ** 2 + (y - 0.55) ** 2) / 0.05),
        "shadow": np.where(x + y < 0.7, 30.0, 200.0) + 30.0 * y,
        "spike": spike,
    }


def normal(random, shape):
    return random.standard_normal(shape)


def rare(random, shape):
    """Few bright contributions, as of caustics: skew 7, of mean 0 and variance 1."""
    hit = 0.02
    return ((random.random(shape) < hit) / hit - 1.0) / math.sqrt(1.0 / hit - 1.0)


def halves_of(truth, error, noise, seed, passes=PASSES, pooled=12.0):
    """Estimates of a map from passes of known noise. ``error``: relative, of the whole."""
    random = np.random.default_rng(seed)
    truth = truth.ravel()
    spread = error * math.sqrt(passes) * np.sqrt(truth * truth.mean())
    sums = ReplicateSums(len(truth))
    for _ in range(passes):
        sums.add(0, truth + spread * noise(random, truth.shape), 64.0)
        sums.end_pass()
    # As lumels learn from those around them.
    variance = sums.variance()
    blocks = variance.reshape(SIDE // 8, 8, SIDE // 8, 8).mean(axis=(1, 3))
    around = np.kron(blocks, np.ones((8, 8))).ravel()
    variance = ((passes - 1) * variance + pooled * around) / (passes - 1 + pooled)
    return Halves(
        sums.mean(), np.sqrt(variance), sums.even(), sums.odd(), sums.even_share(), passes - 1 + pooled
    )  # fmt: skip


def extremes_of(halves):
    mean, error = halves.mean.mean(), np.sqrt(np.square(halves.error).sum()) / halves.mean.size
    return part_by_mean(find_least(halves), find_largest(halves), mean, error, halves.freedom)


@pytest.mark.parametrize("noise", [normal, rare])
@pytest.mark.parametrize("name", list(true_maps()))
def test_ranges_hold_the_true_extremes(name, noise):
    truth = true_maps()[name]
    held = {"least": 0, "largest": 0}
    trials = 0
    for error in (0.005, 0.02, 0.05):
        for seed in range(60):
            halves = halves_of(truth, error, noise, seed)
            least, largest = extremes_of(halves)
            held["least"] += least.low <= truth.min() <= least.high
            held["largest"] += largest.low <= truth.max() <= largest.high
            trials += 1
    # Of rare bright contributions even the interval of a single value holds the truth less often.
    wanted = 0.95 if noise is normal else 0.9
    allowed = 3.0 * math.sqrt(wanted * (1.0 - wanted) / trials)
    assert min(held.values()) / trials > wanted - allowed, held


@pytest.mark.parametrize("name", list(true_maps()))
def test_stated_extremes_lie_nearer_the_truth_than_those_of_the_estimates(name):
    truth, error = true_maps()[name], 0.02
    stated, naive = [], []
    for seed in range(40):
        halves = halves_of(truth, error, normal, seed)
        stated.append(find_largest(halves).value)
        naive.append(halves.mean.max())
    sigma = error * math.sqrt(truth.max() * truth.mean())
    bias = np.mean(stated) - truth.max()
    assert abs(bias) < 1.4 * sigma
    if name in {"flat", "slope", "shadow"}:
        # Many places compete, of which noise lifts one.
        assert np.mean(naive) - truth.max() > 2.0 * sigma
        assert abs(bias) < 0.6 * sigma


def test_a_single_bright_place_is_stated_as_it_was_found():
    truth = true_maps()["spike"]
    halves = halves_of(truth, 0.01, normal, 3)
    assert find_largest(halves).value == pytest.approx(halves.mean.max())
    assert find_least(halves).value == pytest.approx(halves.mean.min())


@pytest.mark.parametrize("name", list(true_maps()))
def test_extremes_of_a_quick_look_are_in_order(name):
    truth = true_maps()[name]
    crossed = 0
    for seed in range(40):
        halves = halves_of(truth, 2.0, rare, seed, passes=2)
        least, largest = extremes_of(halves)
        assert least.low <= least.value <= halves.mean.mean() <= largest.value <= largest.high
        assert least.value <= least.high and largest.low <= largest.value
        crossed += find_least(halves).value > find_largest(halves).value
    # What each half chooses by itself need not be.
    assert crossed > 0 or name != "flat"


def test_halves_of_unlike_size_are_read_with_their_own_errors():
    truth = np.full((SIDE, SIDE), 100.0)
    found = [
        find_largest(halves_of(truth, 0.02, normal, seed, passes=3, pooled=12.0))
        for seed in range(100)
    ]
    values = np.array([each.value for each in found])
    # Read in two passes and in one: as well known as in all three.
    assert values.mean() == pytest.approx(100.0, abs=3.0 * 2.0 / math.sqrt(100))
    assert values.std() == pytest.approx(2.0, rel=0.25)
    assert np.mean([each.low <= 100.0 <= each.high for each in found]) > 0.9


def test_without_two_halves_nothing_is_known_of_extremes():
    sums = ReplicateSums(4)
    sums.add(0, np.array([1.0, 2.0, 3.0, 4.0]), 8.0)
    sums.end_pass()
    halves = Halves(
        sums.mean(), np.zeros(4), sums.even(), sums.odd(), sums.even_share(), freedom=1.0
    )
    assert (find_least(halves).low, find_least(halves).high) == (0.0, math.inf)
    assert find_largest(halves).high == math.inf


def test_a_dark_map_is_exactly_dark():
    dark = np.zeros(9)
    made = find_least(Halves(dark, dark, dark, dark, np.full(9, 0.5), 7.0))
    assert (made.value, made.low, made.high) == (0.0, 0.0, 0.0)
    assert divide(made, 0.0, 0.0).high == math.inf


def test_what_all_values_have_in_common_widens_ranges():
    halves = halves_of(true_maps()["spike"], 0.001, normal, 1)
    alone, together = find_largest(halves), find_largest(halves, common=0.05)
    assert together.value == alone.value
    assert together.high - together.value == pytest.approx(2.09 * 0.05 * together.value, rel=0.02)
    assert together.low < alone.low
    whole = divide(find_least(halves), 100.0, 5.0)
    assert whole.value == pytest.approx(0.4, rel=0.02)
    assert whole.high - whole.value == pytest.approx(1.96 * 0.05 * 0.4, rel=0.02)


@pytest.mark.mitsuba
@pytest.mark.slow
def test_extremes_of_a_quick_bake_agree_with_those_of_a_long_one():
    # A block in the air: one that stands hides places that are dark exactly.
    room, block = furnished_room()
    items = (room, moved(block, "block", (0.0, 0.0, 0.4)), paint(0.5), lamp((0.6, 0.7, 1.5)))
    objects = ("room", "block")
    long = bake(items, objects, error=0.005, seed=99).maps
    held = []
    for seed in range(5):
        made = bake(items, objects, error=0.06, seed=seed).maps
        for quick, true in zip(made, long, strict=True):
            for name in ("least", "largest", "uniformity"):
                found, known = getattr(quick, name), getattr(true, name)
                assert found.low <= found.value <= found.high
                held.append(found.low <= known.value <= found.high)
    assert np.mean(held) > 0.9
