"""The amount of light of a photometric file, factor by factor."""

import numpy as np
import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.luminaires.amount import Amount, tilt_factor
from lumenray.engine.luminaires.formats.record import TiltTable


def test_every_factor_is_shown_with_its_effect():
    amount = Amount(3000.0, None, 1.1, 0.9, 0.5, 0.8)
    assert [step.factor for step in amount.steps()] == [1.0, 1.1, 0.9, 0.5, 0.8]
    assert [step.luminous_flux for step in amount.steps()] == pytest.approx(
        [3000.0, 3300.0, 2970.0, 1485.0, 1188.0]
    )
    assert amount.luminous_flux == pytest.approx(1188.0)


def test_a_stated_flux_takes_the_place_of_the_files():
    amount = Amount(3000.0, stated_flux=500.0, dimming=0.5)
    assert amount.luminous_flux == 250.0
    assert "Stated" in amount.steps()[0].label


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({"dimming": 1.2}, "dimming is 1.2, expected a number from 0 to 1"),
        ({"maintenance_factor": -0.1}, "maintenance factor is -0.1"),
        ({"lamp_factor": float("nan")}, "lamp factor is nan, expected a number of at least 0"),
        ({"stated_flux": -5.0}, "stated flux is -5"),
        ({"tilt_factor": float("inf")}, "tilt factor is inf"),
    ],
)
def test_factors_out_of_range_are_refused(numbers, words):
    with pytest.raises(SceneError, match=words):
        Amount(1000.0, **numbers)


def test_tilt_counts_where_the_lamp_tilts_along():
    angles, factors = np.array([0.0, 45.0, 90.0]), np.array([1.0, 0.9, 0.6])
    assert tilt_factor(TiltTable(1, angles, factors), -67.5) == pytest.approx(0.75)
    assert tilt_factor(TiltTable(3, angles, factors), 45.0) == pytest.approx(0.9)
    assert tilt_factor(TiltTable(2, angles, factors), 45.0) == 1.0
    assert tilt_factor(None, 45.0) == 1.0
