"""Suns that stand for others."""

import numpy as np
import pytest

from lumenray.engine.daylight.coefficients import gather_suns
from lumenray.engine.sky.nodes import unit_vectors


def arc(count=400, seed=1):
    rng = np.random.default_rng(seed)
    return unit_vectors(np.radians(60.0 * rng.random(count)), np.radians(240.0 * rng.random(count)))


def test_every_sun_has_near_ones_that_stand_for_it():
    suns = arc()
    middles, neighbours, shares = gather_suns(suns, 5.0)
    assert len(middles) < len(suns)
    np.testing.assert_allclose(shares.sum(axis=1), 1.0)
    np.testing.assert_allclose(np.linalg.norm(middles, axis=1), 1.0)
    nearest = np.einsum("kx,kx->k", middles[neighbours[:, 0]], suns)
    assert np.degrees(np.arccos(np.clip(nearest, -1.0, 1.0))).max() < 5.0
    # The nearest counts most.
    assert (shares[:, 0] >= shares[:, 1] - 1e-12).all()


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_few_suns_stand_for_themselves(count):
    suns = arc(count)
    middles, neighbours, shares = gather_suns(suns, 1.0)
    assert neighbours.shape == shares.shape == (count, 3)
    made = np.einsum("kjx,kj->kx", middles[neighbours], shares) if count else suns
    np.testing.assert_allclose(made, suns, atol=1e-5)
