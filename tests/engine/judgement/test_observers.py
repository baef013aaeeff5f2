"""Verdicts of observers: decided by the error, shared among all, and none dazzled is no failure."""

import math

import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.judgement.observers import glare_limit, judge_observers
from lumenray.engine.judgement.reader import find_requirement
from lumenray.engine.judgement.requirement import Requirement
from lumenray.engine.judgement.verdict import State, overall


def test_observers_are_judged_by_their_errors():
    ratings = [(17.0, 0.1), (18.9, 0.1), (22.0, 0.2), (math.nan, 0.0), (17.0, math.nan)]
    states = [each.state for each in judge_observers(19.0, ratings, 3)]
    assert states == [State.MET, State.UNDECIDED, State.NOT_MET, State.MET, State.UNDECIDED]


def test_many_observers_need_smaller_errors_each():
    """Each could be wrong: of Student's t with 3 degrees of freedom 5.39 errors are passed in 1 of 160 cases."""
    rating = (19.0 - 5.4 * 0.1, 0.1)
    assert overall(judge_observers(19.0, [rating], 3)) is State.MET
    assert overall(judge_observers(19.0, [rating] * 20, 3)) is State.UNDECIDED


def test_limits_are_those_of_the_requirement():
    assert glare_limit(find_requirement("office.writing")) == 19.0
    with pytest.raises(SceneError, match="asks nothing of"):
        glare_limit(Requirement("own.dark", "Dark", "own", "", areas={"task": {"mean": 1.0}}))
