"""How an asked error is shared, and how a result says what its error is made of."""

import math

import numpy as np
import pytest

from lumenray.engine.accuracy.estimate import Estimate
from lumenray.engine.accuracy.stopping import StopRule
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


@pytest.mark.parametrize("bound", [0.0, 1e-4, 0.003, 0.005, 0.008])
def test_parts_make_the_asked_error(bound):
    assert math.hypot(left_to_samples(0.01, bound), bound) == pytest.approx(0.01)


def test_samples_are_not_spent_on_what_they_cannot_make_smaller():
    """Just above the asked error they still count; far above it they need no more than what was asked."""
    assert left_to_samples(0.01, 0.011) == pytest.approx(0.006)
    for bound in (0.015, 0.02, 0.5):
        left = left_to_samples(0.01, bound)
        assert left <= 0.01 and math.hypot(left, bound) <= 1.12 * bound
    assert left_to_samples(0.01, 0.05) == 0.01


def test_rules_leave_room_for_the_whole_and_for_every_value():
    rule = StopRule(error=0.01, each=0.02).beside(0.006, 0.016)
    assert (rule.error, rule.each) == pytest.approx((0.008, 0.012))
    assert StopRule(error=0.01, each=0.01).beside(0.006).each == pytest.approx(0.008)
    assert StopRule(samples=3).beside(0.006) == StopRule(samples=3)


def test_shares_count_before_any_light_is_found():
    dark = Estimate(np.zeros(3), np.zeros(3), 16)
    rule = StopRule(error=0.01).beside_shares(np.full(3, 0.006), dark)
    assert rule.error == pytest.approx(0.008)
