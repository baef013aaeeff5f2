"""Integrals of what WINDOW XML holds: totals, reciprocity, the horizon, in closed form and by quadrature."""

from dataclasses import replace

import numpy as np
import pytest
from window_files import NORMAL, evaluate_window, klems, read_window, row_towards, tree

from lumenray.engine.scattering.data.patches import albedo_of_patches, reciprocity_of, transposed
from lumenray.engine.scattering.data.tree import albedo_of_tree, disk_of, square_of


def test_the_map_of_disk_and_square_keeps_areas_and_goes_both_ways():
    u, v = np.random.default_rng(4).random((2, 5000))
    x, y = disk_of(u, v)
    assert (x * x + y * y).max() <= 1.0
    back = square_of(x, y)
    assert np.allclose(back, (u, v), atol=1e-12)
    # The square's cells have equal shares of the disk: that within the radius r is r^2 of all.
    grid = (np.arange(1000) + 0.5) / 1000
    x, y = disk_of(*np.meshgrid(grid, grid))
    for radius in (0.2, 0.5, 0.9):
        assert (x * x + y * y < radius**2).mean() == pytest.approx(radius**2, abs=2e-3)
    # Shirley and Chiu: (1, 1/2) of [-1, 1]^2 lies at the azimuth pi / 8, the corner at pi / 4.
    assert np.allclose(disk_of(1.0, 0.75), (np.cos(np.pi / 8), np.sin(np.pi / 8)))
    assert np.allclose(disk_of(0.0, 0.0), (-np.sqrt(0.5), -np.sqrt(0.5)))
    assert np.allclose(disk_of(0.5, 0.5), 0.0)


@pytest.mark.parametrize("rank", [0, 3, 4])
def test_totals_are_the_integral_of_the_value_times_the_cosine(rank):
    rng = np.random.default_rng(7)
    if rank:
        text = "{" + " ".join(f"{v:.6f}" for v in rng.random(2 ** (2 * rank)) * 0.3) + "}"
        scatter = read_window(tree("Reflection Front", text, rank), "front_reflection")
    else:
        scatter = read_window(
            klems("Reflection Front", rng.random((145, 145)) * 0.3), "front_reflection"
        )
    # Even over the projected solid angle: the mean of f times pi.
    n = 1000
    square, azimuth = (np.arange(n) + 0.5) / n, 2 * np.pi * (np.arange(n) + 0.5) / n
    square, azimuth = (m.ravel() for m in np.meshgrid(square, azimuth))
    sine = np.sqrt(square)
    wo = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.sqrt(1 - square)], axis=1)
    for incidence, rotation in ((0.02, 0.4), (0.8, 2.0), (1.4, 4.0)):
        wi = row_towards(np.degrees(incidence), np.degrees(rotation))
        expected = np.pi * evaluate_window(scatter, np.broadcast_to(wi, wo.shape), wo).mean()
        total = albedo_of_tree if rank else albedo_of_patches
        assert total(scatter, incidence, rotation)[0] == pytest.approx(expected, rel=2e-3)


def test_nothing_is_scattered_below_the_horizon():
    for scatter in (
        read_window(klems("Reflection Front", np.ones((145, 145))), "front_reflection"),
        read_window(tree("Reflection Front", "{ 1 }"), "front_reflection"),
    ):
        below = np.array([[0.0, 0.6, -0.8]])
        assert evaluate_window(scatter, NORMAL, below) == 0.0
        assert evaluate_window(scatter, below, NORMAL) == 0.0


def test_reciprocity_is_measured():
    values = np.random.default_rng(8).random((145, 145, 1)).astype(np.float32)
    matrix = read_window(klems("Reflection Back", np.eye(145)), "back_reflection")
    alike = replace(matrix, values=values + values.transpose(1, 0, 2))
    assert reciprocity_of(alike) < 1e-6
    one_way = replace(matrix, values=np.triu(values[..., 0], 1)[..., None])
    assert reciprocity_of(one_way) == pytest.approx(2.0)
    assert reciprocity_of(one_way, transposed(one_way)) == 0.0
    # The mean f is 1 with deviations of 10 % in each of two opposite directions: sqrt(2) times that.
    noisy = replace(matrix, values=1.0 + 0.1 * np.sqrt(12.0) * (values - 0.5))
    assert reciprocity_of(noisy) == pytest.approx(0.1 * np.sqrt(2.0), rel=0.05)
