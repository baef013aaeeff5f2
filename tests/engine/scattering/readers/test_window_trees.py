"""WINDOW XML with trees: grids and branches, cells, and turns of isotropic ones."""

import numpy as np
import pytest
from scattering_models import directions
from window_files import GRID, evaluate_window, read_window, tree

from lumenray.engine.scattering.data.tree import albedo_of_tree, check_tree, levels_of, raster_of

NESTED = " ".join(f"{{ {(k & 1) << 3 | (k & 2) << 1 | (k & 4) >> 1 | k >> 3} }}" for k in range(16))
"""The same with braces: there the first coordinate is the lowest bit of a branch's number."""


def test_grids_and_branches_are_told_apart():
    trees = [
        read_window(tree("Reflection Back", f"{{ {text} }}"), "back_reflection")
        for text in (GRID, NESTED)
    ]
    wi, wo = directions(2000, 3, 0.0), directions(2000, 4, 0.0)
    assert np.array_equal(evaluate_window(trees[0], wi, wo), evaluate_window(trees[1], wi, wo))
    # In the file's frame, a half turn about y away: in x and y of where light travels to, then out x and y.
    x, y, u, v = -wi[:, 0] * -1, -wi[:, 1], -wo[:, 0], wo[:, 1]
    number = sum((value > 0.0) * bit for value, bit in ((x, 8), (y, 4), (u, 2), (v, 1)))
    assert np.array_equal(evaluate_window(trees[0], wi, wo), number)


@pytest.mark.parametrize("rank", [3, 4])
def test_fine_grids_are_their_cells(rank):
    size = 4
    values = np.random.default_rng(5).random((size,) * rank).astype(np.float32)
    text = "{" + ", ".join(f"{value:.9g}" for value in values.ravel()) + "}"
    found = read_window(tree("Transmission Front", text, rank), "front_transmission")
    check_tree(found)
    assert len(levels_of(found)) == 2
    # In x and out x are turned round against the file, in x and in y once more.
    turned = (1, 2) if rank == 4 else (2,)
    assert np.array_equal(raster_of(found, 2)[..., 0], np.flip(values, turned))
    assert raster_of(found, 1)[(0,) * rank][0] == pytest.approx(
        np.flip(values, turned)[(slice(2),) * rank].mean(), rel=1e-6
    )


def test_mixed_depths_and_a_single_value():
    inner = "{ " + " ".join(["{ 0.5 }"] * 8) + " }"
    text = "{" + inner + "{ 1 2 3 4 5 6 7 8 }" + "{ 3 }" * 6 + "}"
    found = read_window(tree("Reflection Back", text, 3), "back_reflection")
    check_tree(found)
    assert len(levels_of(found)) == 2
    plain = read_window(tree("Reflection Back", "{ 0.25 }", 3), "back_reflection")
    assert albedo_of_tree(plain, 0.3)[0] == pytest.approx(0.25 * np.pi)


def test_isotropic_trees_do_not_change_when_both_directions_turn():
    values = np.random.default_rng(6).random(512)
    text = "{" + " ".join(f"{value:.6f}" for value in values) + "}"
    found = read_window(tree("Reflection Front", text, 3), "front_reflection")
    wi, wo = directions(500, 7, 0.0), directions(500, 8, 0.0)
    angle = 1.1
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    alike = evaluate_window(found, wi, wo) == evaluate_window(found, wi @ turn.T, wo @ turn.T)
    # Rounding moves hardly any across an edge.
    assert alike.mean() > 0.995
