"""How an asked error is shared, and how a result says what its error is made of."""

import math

import pytest

from lumenray.engine.requirements.budget import left_to_samples, tell_parts


def test_an_error_is_told_in_its_parts():
    assert tell_parts(0.01, 0.003) == "sampling and the rest 0.95 %, simplifications at most 0.3 %"
    assert tell_parts(0.01, 0.0) == ""
    assert (
        tell_parts(math.inf, 0.003)
        == "sampling and the rest not known, simplifications at most 0.3 %"
    )


def test_rounding_makes_no_root_of_less_than_nothing():
    assert tell_parts(0.003, 0.003 * (1.0 + 1e-12)).startswith("sampling and the rest 0 %")


@pytest.mark.parametrize("bound", [0.0, 1e-4, 0.003, 0.005])
def test_parts_make_the_asked_error(bound):
    assert math.hypot(left_to_samples(0.01, bound), bound) == pytest.approx(0.01)
