import math

import numpy as np
import pytest

from lumenray.engine.accuracy.forecast import Forecaster
from lumenray.engine.accuracy.replicates import ReplicateSums
from lumenray.engine.accuracy.stopping import Clock, Progress, StopRule
from lumenray.engine.errors import SceneError

SETUP, COMPILING = 4.0, 3.0
"""Seconds before the first pass, and those by which that one is longer."""

TILES, SIDE = 64, 40
"""Tiles of a simulated map, and the lumels of each."""


class Bake:
    """A bake of lumels with known variances whose passes take known times with some jitter."""

    def __init__(self, rule, seed, jitter=0.02, forecaster=None):
        self.rng = np.random.default_rng(seed)
        # Errors per sample differ from tile to tile by up to two orders of magnitude, as they do in rooms.
        self.scale = np.repeat(10.0 ** np.random.default_rng(0).uniform(0.0, 2.0, TILES), SIDE)
        self.mean = np.full(TILES * SIDE, 100.0)
        self.sums = ReplicateSums(TILES * SIDE)
        self.forecaster = forecaster or Forecaster(rule, SETUP, finest=1.0)
        self.samples = np.full(TILES * SIDE, 8.0)
        self.seconds, self.jitter, self.has_compiled = SETUP, jitter, False
        self.done = 0.0

    def run_pass(self):
        noise = self.rng.normal(size=len(self.mean)) * self.scale / np.sqrt(self.samples)
        self.sums.add(0, self.mean + noise, self.samples)
        self.sums.end_pass()
        self.done += self.samples.mean()
        self.seconds += (0.05 * self.samples.mean()) * self.rng.normal(1.0, self.jitter)
        if not self.has_compiled:
            self.seconds += COMPILING
            self.has_compiled = True
        error = math.sqrt(self.sums.variance().mean())
        return self.forecaster.note(
            self.seconds,
            self.done,
            error / self.sums.mean().mean(),
            absolute=error,
        )

    def double(self):
        """From now on passes have twice the samples."""
        samples, before = self.samples[0], self.done
        self.samples = 2.0 * self.samples
        self.forecaster.replan(before / (2.0 * samples), 2.0 * samples, seconds=self.seconds)

    def run(self, doubles=True, most=100_000):
        while not self.forecaster.is_done() and self.sums.passes < most:
            self.run_pass()
            if doubles and self.sums.passes == 4:
                self.double()
        return self.forecaster.history


def at_share(history, share):
    """Forecast that stood after a share of the run."""
    marks, end = history.marks, history.marks[-1].seconds
    return next(
        mark.forecast for mark in marks[::-1] if mark.seconds <= max(share * end, marks[3].seconds)
    )


@pytest.mark.parametrize("doubles", [False, True])
@pytest.mark.slow
def test_forecasts_after_a_twentieth_of_the_run_are_right(doubles):
    """Ten runs of some 120 passes: median within 3 % of the whole time, none worse than 10 %."""
    rule = StopRule(error=0.005 if doubles else 0.007)
    misses = []
    for seed in range(10):
        history = Bake(rule, seed).run(doubles)
        assert len(history.marks) > 60
        misses.append(abs(at_share(history, 0.05) / history.marks[-1].seconds - 1.0))
    assert np.median(misses) < 0.03
    assert max(misses) < 0.1


def test_bounds_of_a_forecast_hold_the_end():
    """Passes whose lumels err together, as where all gather from the same cells: the error itself is known badly."""
    held, known = 0, 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        forecaster, sums, bounds = (
            Forecaster(StopRule(error=0.01), 0.0, finest=1.0),
            ReplicateSums(12),
            None,
        )
        while not forecaster.is_done():
            sums.add(0, rng.normal(1.0, 0.1, 12), 1.0)
            sums.end_pass()
            error = math.sqrt(sums.variance().mean()) / sums.mean().mean()
            forecaster.note(float(sums.passes), sums.passes, error)
            if sums.passes == 12:
                bounds = forecaster.outlook
        known += bounds.low is not None
        held += bounds.low <= sums.passes <= bounds.high
    assert known == 60
    assert held >= 51


def steady(rule, passes, error=0.1, seconds=2.0, samples=16.0, **more):
    """A forecaster after passes that went exactly as believed. ``error``: of one pass."""
    forecaster = Forecaster(rule, SETUP, finest=more.get("finest", 1.0))
    for number in range(1, passes + 1):
        stated = error / math.sqrt(number) if number > 1 else math.inf
        absolute = more.get("mean", 1.0) * stated
        forecaster.note(SETUP + seconds * number, samples * number, stated, absolute=absolute)
    return forecaster


def test_whichever_is_met_first_is_forecast():
    # A tenth in one pass: a hundredth takes 100 passes of 2 s after 4 s of setup.
    assert steady(StopRule(error=0.01), 5).forecast() == pytest.approx(204.0)
    assert steady(StopRule(error=0.01, seconds=300), 5).outlook.reason == "error"
    by_time = steady(StopRule(error=0.01, seconds=101.0), 5).outlook
    # The pass that is under way at 101 s ends at 102 s, with 49 passes.
    assert (by_time.reason, by_time.seconds) == ("time", pytest.approx(102.0))
    assert by_time.error == pytest.approx(0.1 / 7.0)
    by_samples = steady(StopRule(error=0.01, samples=325), 5).outlook
    assert (by_samples.reason, by_samples.seconds) == ("samples", pytest.approx(46.0))
    assert by_samples.samples == pytest.approx(336.0)


def test_an_error_in_lux_is_met_where_the_mean_makes_it_so():
    rule = StopRule(absolute=2.0)
    forecaster = steady(rule, 5, mean=500.0)
    # 2 lx of 500 lx are 0.4 %: 625 passes.
    assert forecaster.forecast() == pytest.approx(1254.0)
    assert forecaster.history.target == pytest.approx(0.004)
    assert "lx" in forecaster.progress(14.0).text()
    both = steady(StopRule(absolute=2.0, error=0.01), 5, mean=500.0)
    assert both.outlook.reason == "error"
    assert both.forecast() == pytest.approx(204.0)
    assert steady(StopRule(absolute=20.0), 7, mean=500.0).is_done()


def test_progress_is_full_only_when_the_rule_is_met():
    forecaster = steady(StopRule(error=0.05), 3)
    assert forecaster.progress(1e4).done < 1.0
    assert forecaster.progress(1e4).seconds_left == 0.0
    assert not forecaster.is_done()
    forecaster = steady(StopRule(error=0.05), 4)
    assert forecaster.reason() == "error"
    assert forecaster.progress(1e4).done == 1.0
    assert Forecaster(StopRule(seconds=10.0), 1.0).progress(2.5).done == 0.25
    assert Forecaster(StopRule(error=0.1), 1.0).progress(2.5).seconds_left is None


def test_nothing_is_forecast_from_one_replicate_or_without_light():
    forecaster = Forecaster(StopRule(error=0.01), 1.0)
    assert forecaster.note(2.0, 16, math.inf).forecast is None
    assert forecaster.note(3.0, 32, math.inf).forecast is None
    assert not forecaster.is_done()
    assert forecaster.note(4.0, 48, 0.0).forecast == 4.0
    assert forecaster.reason() == "error"


def test_only_the_error_of_a_new_pass_need_be_known():
    forecaster = steady(StopRule(error=0.01), 4)
    present, new = 0.05, 0.025
    forecaster.replan((new / present) ** 2, 32.0, 5.0)
    # Information adds: 1/0.01^2 = 1/0.05^2 + n/0.025^2 with n = 6.
    assert forecaster.forecast() == pytest.approx(SETUP + 8.0 + 6 * 5.0)
    assert forecaster.outlook.samples == pytest.approx(64.0 + 6 * 32.0)
    assert forecaster.history.marks[-1].forecast == forecaster.forecast()


def test_a_pass_after_a_change_takes_time_in_proportion_to_its_samples():
    forecaster = steady(StopRule(samples=1064), 4)
    forecaster.replan(0.64, 100.0)
    assert forecaster.forecast() == pytest.approx(SETUP + 8.0 + 10 * 2.0 * 100.0 / 16.0)


def test_hiccups_and_kernels_do_not_count_as_the_time_of_a_pass():
    forecaster = Forecaster(StopRule(samples=1000), 1.0)
    now = 1.0
    for number, seconds in enumerate((30.0, 2.0, 2.0, 2.0, 60.0, 2.0, 2.0), start=1):
        now += seconds
        forecaster.note(now, 10.0 * number, math.inf)
    assert forecaster.forecast() == pytest.approx(now + 93 * 2.0)


def test_a_check_that_is_made_now_and_then_does_not_lengthen_all_passes():
    forecaster = Forecaster(StopRule(samples=100), 0.0)
    forecaster.note(1.0, 10.0, 0.2)
    # Passes of a second, of which the second one made a check of 3 s beside it and so counts it for four.
    forecaster.note(5.0, 20.0, 0.14, extra_seconds=3.0 * (1.0 - 1.0 / 4.0))
    assert forecaster.forecast() == pytest.approx(5.0 + 8.0 * 1.75)


@pytest.mark.mitsuba
def test_over_the_passes_that_share_it_work_counts_once():
    from lumenray.engine.baking.layer import Layer

    layer = Layer(None, StopRule(samples=1), None, None, None, 1, None)
    extra = [layer._extra(seconds, number) for number, seconds in enumerate([8, 0, 0, 0])]
    assert extra == [6.0, -2.0, -2.0, -2.0]


def test_an_interrupted_bake_goes_on_with_its_forecast():
    rule = StopRule(error=0.004)
    through = Bake(rule, 3, jitter=0.0)
    for _ in range(4):
        through.run_pass()
    through.double()
    for _ in range(6):
        through.run_pass()
    before = through.forecaster
    again = Forecaster.from_state(rule, before.state(), setup_seconds=9.0, finest=1.0)
    assert again.history == before.history
    assert again.forecast() == before.forecast()
    # The next pass also makes kernels again, which tells nothing of those that follow.
    mark = again.note(9.0 + 0.4 + COMPILING, through.done + 8.0, before.history.marks[-1].error)
    expected = before.note(through.seconds + 0.4, through.done + 8.0, mark.error)
    assert mark.seconds == pytest.approx(through.seconds + 9.0 + 0.4 + COMPILING)
    assert mark.forecast == pytest.approx(expected.forecast + 9.0 + COMPILING)


def foretold(finest=0.5, planned=0):
    """A pilot of two small passes, and passes of which 16 were planned for the error asked for."""
    forecaster = Forecaster(StopRule(error=0.01), SETUP, finest=finest, planned=planned)
    forecaster.note(SETUP + 2.0, 8.0, 0.4, passes=2)
    forecaster.replan((0.04 / 0.4) ** 2, 64.0, 10.0, seconds=SETUP + 5.0)
    return forecaster


def test_a_plan_holds_until_passes_have_shown_otherwise():
    forecaster = foretold()
    # 16 passes of 10 s, less what the pilot has given already, a hundredth of a pass.
    assert forecaster.forecast() == pytest.approx(SETUP + 5.0 + 160.0)
    # Sums that begin anew after the pilot know no error after their first pass.
    assert forecaster.note(SETUP + 15.0, 64.0, math.inf).forecast == pytest.approx(169.0)
    # Nor does a single pass count beside a pilot of few samples, whose error it inherits.
    other = foretold()
    assert other.note(SETUP + 15.0, 72.0, 0.08).forecast == pytest.approx(169.0)
    # Passes that are twice as good as foretold: the plan counts less and less.
    ends = [
        forecaster.note(SETUP + 5.0 + 10.0 * n, 64.0 * n, 0.02 * math.sqrt(2 / n)).forecast
        for n in (2, 3, 4)
    ]
    assert all(after < before for before, after in zip([169.0, *ends], ends, strict=False))
    assert ends[-1] < SETUP + 5.0 + 12 * 10.0


def test_the_last_pass_may_be_a_half_once():
    forecaster = foretold()
    for n in range(1, 17):
        forecaster.note(SETUP + 5.0 + 10.0 * n, 64.0 * n, 0.0402 / math.sqrt(n))
    assert forecaster.passes_needed() == 0.5
    assert forecaster.forecast() == pytest.approx(SETUP + 170.0)
    # It was not enough: another half might never be.
    forecaster.note(SETUP + 170.0, 64.0 * 16.5, 0.01001)
    assert forecaster.passes_needed() == 1.0
    again = Forecaster.from_state(StopRule(error=0.01), forecaster.state())
    assert again.passes_needed() == 1.0
    forecaster.note(SETUP + 180.0, 64.0 * 17.5, 0.0099)
    assert forecaster.is_done()
    assert forecaster.passes_needed() == 0.0


@pytest.mark.parametrize("error", [0.0391, 0.0394, 0.0397])
def test_the_last_pass_of_a_plan_is_a_whole_one_whatever_is_missing(error):
    """So the end does not jump by a half pass with what chance adds to an error: 15.3, 15.5 and 15.8 passes would do."""
    forecaster = foretold(planned=16)
    for n in range(1, 16):
        forecaster.note(SETUP + 5.0 + 10.0 * n, 64.0 * n, error / math.sqrt(n))
        if n >= 4:
            assert forecaster.forecast() == pytest.approx(SETUP + 165.0)
        assert forecaster.is_last_planned() == (n == 15)
    again = Forecaster.from_state(StopRule(error=0.01), forecaster.state())
    assert again.is_last_planned()
    forecaster.note(SETUP + 165.0, 64.0 * 16, error / 4.0)
    assert forecaster.is_done()
    assert not forecaster.is_last_planned()


def test_beyond_a_plan_and_for_samples_parts_of_passes_do():
    forecaster = foretold(planned=16)
    for n in range(1, 17):
        forecaster.note(SETUP + 5.0 + 10.0 * n, 64.0 * n, 0.0402 / math.sqrt(n))
    assert forecaster.forecast() == pytest.approx(SETUP + 170.0)
    assert not forecaster.is_last_planned()
    rule = StopRule(samples=64 * 15 + 32)
    by_samples = Forecaster(rule, SETUP, planned=16)
    for n in range(1, 16):
        by_samples.note(SETUP + 10.0 * n, 64.0 * n, 0.1)
    assert by_samples.forecast() == pytest.approx(SETUP + 155.0)
    assert not by_samples.is_last_planned()


def test_a_state_that_does_not_fit_together_is_refused():
    rule = StopRule(error=0.01)
    state = steady(rule, 5).state()
    for name in state:
        for broken in (None, np.zeros((2, 2, 2)), np.zeros(1, dtype=np.float32)):
            changed = {key: value for key, value in state.items() if key != name}
            if broken is not None:
                changed[name] = broken
            with pytest.raises(SceneError, match="the state of the forecast"):
                Forecaster.from_state(rule, changed)


def test_rules_that_cannot_stop_a_job_are_refused():
    for rule in (StopRule(each=0.05), StopRule(error=0.1, limits=(1.0,))):
        with pytest.raises(SceneError, match="at points only"):
            Forecaster(rule, 0.0)
    with pytest.raises(SceneError, match="lux maps only"):
        Clock(StopRule(absolute=1.0))
    for value in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(SceneError, match="error in lux"):
            StopRule(absolute=value)


def test_the_line_of_progress_names_both_errors():
    line = Progress(0.5, 64, 0.0123, 10.0, 20.0, "lux maps", 5.4321).text()
    assert line == "lux maps, 64 samples, error 1.23 %, 5.43 lx, 20 s left"


def test_the_history_tells_the_error_at_the_forecast_end():
    forecaster = Forecaster(StopRule(error=0.02), 1.0)
    # A pilot of 45 %, and passes of which eight have 1.98 %.
    forecaster.note(2.0, 0.0, 0.45, absolute=45.0, passes=2)
    share = 8.0 * (0.0198 / 0.45) ** 2
    forecaster.replan(share, 100.0, 5.0, 2.5)
    history = forecaster.history
    assert history.end_error == pytest.approx(0.0198, rel=0.01)
    assert history.marks[-1].forecast == pytest.approx(2.5 + 8 * 5.0)
