"""Errors of lumels by their own passes and those of the lumels around them."""

import numpy as np
import pytest

from lumenray.engine.accuracy.replicates import ReplicateSums
from lumenray.engine.accuracy.student import t_quantile
from lumenray.engine.baking.estimates import TILE_FREEDOM, pool_variance

TILE = 64


def bake(noise, passes, seed):
    """Means and stated variances of many tiles. ``noise``: standard deviation of a pass, (TILE,)."""
    random = np.random.default_rng(seed)
    tiles = np.repeat(np.arange(500), TILE)
    spread = np.tile(noise, 500)
    sums = ReplicateSums(len(tiles))
    for _ in range(passes):
        sums.add(0, 100.0 + spread * random.standard_normal(len(tiles)), 1.0)
        sums.end_pass()
    variance = pool_variance(sums, slice(0, len(tiles)), tiles, np.ones(len(tiles), dtype=bool))
    return sums.mean() - 100.0, variance


@pytest.mark.parametrize(("passes", "least"), [(8, 0.9), (4, 0.85)])
@pytest.mark.parametrize("noisy", [1, 8])
def test_noisy_lumels_of_a_quiet_tile_state_their_own_errors(noisy, passes, least):
    noise = np.ones(TILE)
    noise[:noisy] = 10.0
    off, variance = bake(noise, passes, 5)
    held = np.abs(off) <= t_quantile(0.975, passes - 1 + TILE_FREEDOM) * np.sqrt(variance)
    held = held.reshape(-1, TILE)
    assert held[:, :noisy].mean() > least, held[:, :noisy].mean()
    assert held[:, noisy:].mean() > 0.95


@pytest.mark.parametrize("passes", [2, 4, 8])
def test_errors_of_even_tiles_stay_what_they_are(passes):
    off, variance = bake(np.ones(TILE), passes, 6)
    assert 0.98 < np.sqrt(variance.mean() * passes) < 1.07
    held = np.abs(off) <= t_quantile(0.975, passes - 1 + TILE_FREEDOM) * np.sqrt(variance)
    # The mean of a tile is known better than it counts for.
    assert 0.94 < held.mean() < 0.975
