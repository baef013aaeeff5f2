"""Rules, seeds and cancelling of pictures by both methods, and what they tell."""

import numpy as np
import pytest
from small_pictures import ROOMS, look_in
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import Clock, StopRule
from lumenray.engine.errors import Cancelled, SceneError
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

METHODS = ("cells", "paths")

CELLS_FIRST = pytest.mark.parametrize(
    "method", ["cells", pytest.param("paths", marks=pytest.mark.slow)]
)


@pytest.fixture(scope="module")
def session():
    return session_of(*ROOMS["matt"])


@pytest.fixture(params=METHODS)
def method(request):
    return request.param


def made(session, method, rule, seed=1, size=(32, 24), progress=None):
    settings = ViewSettings(rule, seed, method=method)
    return session.render(look_in(*size), settings, progress)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("size", [(32, 24), (8, 8), (13, 7)])
@pytest.mark.parametrize("samples", [100, 1, 2, 3, pytest.param(600, marks=pytest.mark.slow)])
def test_as_many_samples_are_taken_as_are_asked_for(session, method, size, samples):
    told = made(session, method, StopRule(samples=samples), size=size).provenance.samples
    assert abs(told - samples) <= max(1, 0.05 * samples)


def test_a_seed_gives_the_same_picture_whoever_looks_on_and_another_does_not(session, method):
    rule, previews = StopRule(samples=24), []

    def follow(_, preview):
        previews.append(None if preview is None else preview())

    first, again = made(session, method, rule), made(session, method, rule, progress=follow)
    assert previews
    for name in ("tristimulus", "luminance_error", "depth"):
        np.testing.assert_array_equal(getattr(first, name), getattr(again, name))
    assert first.relative_error == again.relative_error
    other = made(session, method, rule, 2)
    assert (first.tristimulus != other.tristimulus).any()


@CELLS_FIRST
def test_an_error_is_reached_and_not_overshot(session, method):
    goal, size = 0.02, (64, 48)
    reached = made(session, method, StopRule(error=goal), size=size)
    assert reached.relative_error <= goal
    # What nearly as many samples reach, by the same seed, is no better than asked for.
    fewer = round(reached.provenance.samples / 1.4)
    less = made(session, method, StopRule(samples=fewer), size=size)
    assert fewer <= 8 or less.relative_error > goal


@CELLS_FIRST
def test_the_samples_that_an_error_needs_are_foreseen(session, method):
    """By the time that is left over that of a sample so far, on a clock that goes on by samples alone."""
    states = []
    goal = {"cells": 0.003, "paths": 0.014}[method]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Clock, "_seconds_until", lambda _, end, samples, __: max(end - samples, 0.0))
        needed = made(
            session,
            method,
            StopRule(error=goal),
            size=(64, 48),
            progress=lambda state, _: states.append(state),
        ).provenance.samples
    assert needed > 160
    told = [(each.samples, each.seconds_left) for each in states if each.seconds_left is not None]
    assert told[0][0] < 32
    # Before, four pixels at the edge of the lamp make most of the error.
    off = np.array([np.log((n + left) / needed) for n, left in told if n > needed / 2.5])
    assert np.abs(np.median(off)) < np.log(1.15), np.exp(off)
    assert np.abs(off).max() < np.log(1.3), np.exp(off)


def test_a_picture_can_be_cancelled_in_the_middle(session, method):
    seen = []

    def follow(state, _):
        seen.append(state.samples)
        if state.samples >= 16:
            session.cancel()

    with pytest.raises(Cancelled):
        made(session, method, StopRule(samples=1 << 20), progress=follow)
    assert 16 <= seen[-1] < 1 << 10
    assert made(session, method, StopRule(samples=2)).provenance.samples == 2


def test_a_time_ends_a_picture(session, method):
    assert made(session, method, StopRule(seconds=0.5)).provenance.samples > 0


def test_pictures_tell_their_method_and_the_bias_of_cells(session):
    cells, paths = (made(session, each, StopRule(samples=8)).provenance for each in METHODS)
    assert any("read from cells" in each for each in cells.decisions)
    assert any("of the picture's mean (measured at" in each for each in cells.notes)
    assert any("full paths" in each for each in paths.decisions)
    assert not any("cells" in each for each in paths.notes)
    auto = made(session, "auto", StopRule(samples=8)).provenance
    assert any("so few paths" in each for each in auto.decisions)


def test_another_method_is_refused_in_a_sentence(session):
    with pytest.raises(SceneError, match="method is 'nonsense', expected auto or cells or paths"):
        made(session, "nonsense", StopRule(samples=1))
