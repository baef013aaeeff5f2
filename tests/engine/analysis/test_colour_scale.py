"""Scales of false colours: round numbers, and the colours at them."""

import numpy as np
import pytest

from lumenray.engine.analysis import false_colour
from lumenray.engine.analysis.colour_scale import ColourScale, nice_scale


@pytest.mark.parametrize(
    ("scale", "ticks"),
    [
        (ColourScale(0.0, 100.0, "%"), [0, 20, 40, 60, 80, 100]),
        (ColourScale(0.0, 3000.0, "lx"), [0, 500, 1000, 1500, 2000, 2500, 3000]),
        (ColourScale(10.0, 1000.0, "cd/m²", True), [10, 20, 50, 100, 200, 500, 1000]),
        (ColourScale(200.0, 5e4, "cd/m²", True), [200, 500, 1000, 2000, 5000, 10000, 20000, 50000]),
        (ColourScale(1.0, 1e5, "cd/m²", True), [1, 10, 100, 1000, 10000, 100000]),
    ],
)
def test_numbers_are_round(scale, ticks):
    np.testing.assert_allclose(scale.ticks(), ticks)


def test_equal_ratios_take_equal_parts():
    scale = ColourScale(10.0, 1000.0, "cd/m²", is_log=True)
    expected = false_colour.colours(np.array([0.0, 0.5, 1.0, 0.0, 1.0]), 0.0, 1.0)
    found = scale.colours([10.0, 100.0, 1000.0, 0.0, 1e9])
    # A logarithm's last digit, which is not the same on all processors, may round to the next level.
    np.testing.assert_allclose(found.astype(int), expected.astype(int), atol=1)
    np.testing.assert_array_equal(found[[0, 2]], expected[[0, 2]])


def test_dark_values_have_a_scale():
    assert nice_scale(np.zeros(4), "lx").high == 1.0
