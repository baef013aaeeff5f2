"""Connected parts of meshes, and points that are one."""

import numpy as np

from lumenray.engine.atlas.topology import find_components, weld


def test_connected_parts_are_those_of_a_plain_search():
    rng = np.random.default_rng(3)
    ends = rng.integers(0, 300, (220, 2))
    found = find_components(300, ends)
    parent = list(range(300))

    def root(node):
        while parent[node] != node:
            node = parent[node]
        return node

    for a, b in ends:
        parent[root(int(a))] = root(int(b))
    plain = np.array([root(node) for node in range(300)])
    same = found[:, None] == found[None]
    assert np.array_equal(same, plain[:, None] == plain[None])
    # A long chain in bad order takes few rounds, not one per link.
    order = rng.permutation(100_000)
    assert find_components(100_000, np.stack([order[:-1], order[1:]], axis=1)).max() == 0


def test_points_are_welded_by_distance_and_not_by_chains_along_one_axis():
    grid = np.stack(np.meshgrid(*[np.arange(20) * 1.0] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    near = np.concatenate([grid, grid + 1e-7])
    label = weld(near, 1e-6)
    assert np.array_equal(label[: len(grid)], label[len(grid) :])
    assert len(np.unique(label)) == len(grid)
    # Points of a slanted plane, whose heights alone lie closer than the distance.
    slanted = np.stack([np.arange(2000.0), np.arange(2000.0)[::-1], np.arange(2000) * 5e-7], axis=1)
    assert len(np.unique(weld(slanted, 1e-6))) == 2000
