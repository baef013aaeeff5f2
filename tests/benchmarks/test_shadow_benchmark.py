"""The benchmark of shadow catchers and photomontages holds its bars."""

import pytest

from lumenray.benchmarks.environment.shadows import measure_shadows

pytestmark = [pytest.mark.mitsuba, pytest.mark.slow]


def test_shadows_are_those_of_sensors_and_montages_those_of_whole_renders():
    told = []
    made = measure_shadows(told.append)
    assert len(told) == 3
    assert made["unshadowed_change"] < 1e-3
    assert made["shadow_error_percent"] < 1.0
    assert made["direction_error_deg"] < 1.0
    assert made["composite_error_percent"] < 5.0
    assert made["mirror_error_percent"] < 5.0
    assert made["caustic_error_percent"] < 5.0
