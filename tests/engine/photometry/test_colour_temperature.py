"""Correlated colour temperatures against another program."""

import colour
import numpy as np
import pytest

from lumenray.engine.photometry.colour_temperature import colour_temperature
from lumenray.engine.photometry.spectra import GRID, daylight, illuminant, observer, planck


@pytest.mark.parametrize(
    "power",
    [planck(GRID, 2700.0), daylight(GRID, 6500.0), illuminant(GRID, "FL2"), illuminant(GRID, "LED-B3")],
)  # fmt: skip
def test_colour_temperatures_are_those_of_an_independent_program(power):
    found, duv = colour_temperature(power @ observer())
    x, y, z = power @ observer()
    uv = np.array([4.0 * x, 6.0 * y]) / (x + 15.0 * y + 3.0 * z)
    expected, expected_duv = colour.temperature.uv_to_CCT_Ohno2013(uv)
    assert found == pytest.approx(expected, rel=2e-3)
    assert duv == pytest.approx(expected_duv, abs=2e-4)


def test_colours_far_from_white_have_no_colour_temperature():
    assert colour_temperature(observer()[550 - 360]) is None
    assert colour_temperature(np.zeros(3)) is None
