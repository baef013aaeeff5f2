"""Nodes on the sky: what is linear between them is exact, and real skies nearly so."""

import numpy as np
import pytest

from lumenray.engine.sky.cie import pattern_of_type
from lumenray.engine.sky.nodes import SkyNodes, _quadrature, find_projection, unit_vectors
from lumenray.engine.sky.pattern import evaluate, integrate


def random_directions(count, seed=3):
    rng = np.random.default_rng(seed)
    return unit_vectors(np.arcsin(rng.random(count)), 2.0 * np.pi * rng.random(count))


@pytest.mark.parametrize("steps", [4, 15, 30])
def test_every_direction_lies_between_nodes_around_it(steps):
    nodes = SkyNodes(steps)
    directions = np.concatenate(
        [random_directions(500), nodes.directions(), [[0, 0, 1], [1, 0, 0], [0, -1, 0]]]
    )
    around, weights = nodes.locate(directions)
    assert weights.min() >= -1e-12
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-12)
    far = np.einsum("nkx,nx->nk", nodes.directions()[around], directions)
    # None that counts is farther than the diagonal of a mesh; near the zenith meshes are wider.
    counts = weights > 1e-9
    assert np.degrees(np.arccos(np.clip(far[counts], -1, 1))).max() < 2.2 * 90.0 / steps


def test_a_node_counts_for_itself_alone():
    nodes = SkyNodes(9)
    spread = nodes.spread(nodes.directions())
    np.testing.assert_allclose(spread, np.eye(nodes.count), atol=1e-9)


def test_what_is_linear_between_nodes_is_kept():
    nodes, projection = SkyNodes(12), find_projection(12)
    rng = np.random.default_rng(5)
    values = rng.random(nodes.count)
    best, _ = projection.project((nodes.spread(projection.directions) @ values)[None])
    np.testing.assert_allclose(best[0], values, rtol=2e-4, atol=2e-4)
    assert projection.areas.sum() == pytest.approx(2.0 * np.pi)
    assert projection.node_areas.sum() == pytest.approx(2.0 * np.pi)


@pytest.fixture(scope="module")
def fine():
    """Directions so close that sums stand for integrals, their solid angles, and what nodes of 15 rows count in them."""
    directions, areas = _quadrature(SkyNodes(40))
    return directions, areas, SkyNodes(15).spread(directions)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("kind", [1, 7, 12, 14])
@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.6, -0.64, 0.48)])
def test_skies_give_sensors_what_their_formula_gives(kind, normal, fine):
    towards = unit_vectors(np.radians(35.0), np.radians(100.0))
    pattern = pattern_of_type(kind, towards)
    projection = find_projection(15)
    best, _ = projection.project(evaluate(pattern, projection.directions)[None])
    directions, areas, spread = fine
    facing = np.maximum(directions @ np.array(normal), 0.0) * areas
    exact = facing @ evaluate(pattern, directions)
    # An open sensor's coefficients, by the fine directions.
    coefficients = facing @ spread
    assert coefficients @ best[0] == pytest.approx(exact, rel=2e-3)
    if normal[2] == 1.0:
        assert exact == pytest.approx(integrate(pattern, weigh=True), rel=2e-3)
