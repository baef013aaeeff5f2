"""Particles in layers: none overlap, all are there, and what is stated of them is so."""

import numpy as np
import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.ink.packing import SLACK, depth_profile, pack, pair_correlation
from lumenray.engine.ink.particles import Population, chain_of, union_volume
from lumenray.engine.ink.voxels import fill_shares


def _worst_overlap(packing):
    centres, radii, owners = packing.spheres()
    apart = centres[:, None] - centres[None]
    apart[..., :2] -= packing.width * np.round(apart[..., :2] / packing.width)
    gap = np.linalg.norm(apart, axis=2) - radii[:, None] - radii[None]
    gap[owners[:, None] == owners[None]] = np.inf
    walls = np.minimum(centres[:, 2], packing.thickness - centres[:, 2]) - radii
    return -min(float(gap.min()), float(walls.min()))


@pytest.mark.parametrize(
    ("share", "shape", "spread"),
    [(0.5, "sphere", 0.0), (0.3, "cylinder", 0.0), (0.3, "rice", 0.2)],
)
def test_particles_do_not_overlap(share, shape, spread):
    packing = pack([Population(share, 0.3, spread, shape)], 1.6, 1.0, 3)
    assert _worst_overlap(packing) <= 1.01 * SLACK * 2.0 * packing.spheres()[1].max()
    assert np.pi / 6.0 * (packing.diameters**3).sum() == pytest.approx(share * 1.6**2)


@pytest.mark.slow
def test_sixty_percent_of_the_volume_can_be_filled():
    packing = pack([Population(0.6, 0.1)], 0.7, 0.8, 1)
    assert _worst_overlap(packing) <= 1.01 * SLACK * 0.1


def test_the_same_seed_gives_the_same_particles():
    one, two, other = (pack([Population(0.3, 0.3)], 1.5, 1.0, seed) for seed in (5, 5, 6))
    assert np.array_equal(one.centres, two.centres)
    assert not np.array_equal(one.centres, other.centres)


def test_aligned_rods_lie_or_stand():
    orders = [
        pack([Population(0.15, 0.25, 0.0, "cylinder", energy)], 1.6, 1.2, 2).order(0)
        for energy in (20.0, 0.0, -20.0)
    ]
    assert orders[0] < -0.3 < orders[1] < 0.3 < orders[2]


def test_clusters_bring_neighbours_near():
    plain, clustered = (
        pack([Population(0.08, 0.2, 0.0, "sphere", 0.0, size, 0.25)], 3.0, 1.0, 4)
        for size in (1.0, 12.0)
    )
    edges = [0.19, 0.32]
    assert pair_correlation(clustered, edges)[0] > 1.5 * pair_correlation(plain, edges)[0]


def test_dense_spheres_touch_more_than_in_equilibrium():
    """Contact of hard spheres in equilibrium by Carnahan and Starling at 30 %: 2.48."""
    packing = pack([Population(0.3, 0.2)], 2.0, 1.0, 7)
    assert pair_correlation(packing, [0.196, 0.206])[0] > 2.48


def test_rods_have_the_volume_of_their_diameter():
    """A chain of 5 spheres a radius apart has 5 pi r^3 (closed form)."""
    assert union_volume(np.arange(5.0) - 2.0, np.ones(5)) == pytest.approx(5.0 * np.pi, rel=1e-5)
    for shape in ("rice", "cylinder"):
        chain = chain_of(shape)
        assert union_volume(chain.places, chain.radii) == pytest.approx(np.pi / 6.0, rel=1e-5)


def test_grids_hold_the_shares_of_the_volume_where_particles_are():
    populations = [Population(0.2, 0.3), Population(0.1, 0.2)]
    packing = pack(populations, 1.6, 1.0, 1)
    shares = fill_shares(packing, (30, 48))
    np.testing.assert_allclose(shares.mean(axis=(1, 2, 3)), [0.2, 0.1])
    assert shares.sum(axis=0).max() < 1.05
    profile = shares.sum(axis=0).mean(axis=(1, 2)).reshape(5, 6).mean(axis=1)
    np.testing.assert_allclose(profile, depth_profile(packing, 5), atol=0.02)


def test_what_does_not_fit_is_refused_in_one_sentence():
    with pytest.raises(SceneError, match="60 % at most"):
        pack([Population(0.65, 0.2)], 1.0, 1.0, 0)
    with pytest.raises(SceneError, match="does not fit into a layer"):
        pack([Population(0.3, 1.2)], 3.0, 1.0, 0)
