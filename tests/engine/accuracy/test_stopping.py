"""Rules that end a job, and the forecast of its clock."""

import math

import numpy as np
import pytest

from lumenray.engine.accuracy.estimate import Estimate
from lumenray.engine.accuracy.stopping import Clock, Fall, StopRule, format_seconds
from lumenray.engine.errors import SceneError


def test_a_rule_without_an_end_is_refused():
    with pytest.raises(SceneError, match="samples, an error or a time"):
        StopRule()
    with pytest.raises(SceneError, match="above 0"):
        StopRule(error=-0.1)


def test_the_forecast_follows_one_over_the_square_root(monkeypatch):
    now = [100.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock = Clock(StopRule(error=0.01))
    now[0] = 110.0
    assert clock.progress(50, float("inf")).seconds_left is None
    # 2 % after 10 s needs four times as long: 30 s more.
    assert not clock.is_done(100, 0.02)
    assert clock.progress(100, 0.02).seconds_left == pytest.approx(30.0)
    assert clock.is_done(400, 0.01)
    assert format_seconds(709) == "11:49 min"


@pytest.mark.parametrize("power", [0.5, 0.65, 0.8])
def test_the_forecast_learns_how_the_error_falls(monkeypatch, power):
    # 100 samples a second; the error is 10 % after 100 samples and falls as a power of their number.
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock = Clock(StopRule(each=0.001))
    for samples in (100, 200, 400, 800):
        now[0] = samples / 100.0
        error = (100 / samples) ** power
        assert not clock.is_done(samples, error, 0.1 * error / 0.001)
    needed = 100.0 * 100.0 ** (1.0 / power) / 100.0
    # In the middle of the next pass the error is still that of the last one.
    now[0] = 10.0
    assert clock.progress(1000, 1.0).seconds_left == pytest.approx(needed - 10.0)


@pytest.mark.parametrize("power", [0.5, 0.8])
def test_three_passes_tell_how_the_error_falls(monkeypatch, power):
    """Each doubles what there is; two of them are not believed in full."""
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock = Clock(StopRule(error=0.001))
    left = []
    for samples in (100, 200, 400):
        now[0] = samples / 100.0
        error = 0.1 * (samples / 100.0) ** -power
        assert not clock.is_done(samples, error)
        left.append(clock.progress(samples, error).seconds_left + now[0])
    needed = 100.0 ** (1.0 / power)
    assert left[2] == pytest.approx(needed)
    plain = 100.0 ** (1.0 / 0.5)
    assert left[0] == pytest.approx(plain)
    assert min(needed, plain) <= left[1] * 1.0001 and left[1] <= plain * 1.0001


def test_a_fast_fall_of_the_error_at_first_is_not_carried_on_to_the_end(monkeypatch):
    """As one over the samples so far; integrands with edges let well-distributed points fall by the power 3/4 at last."""
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock = Clock(StopRule(error=0.001))
    for samples in (100, 200, 400, 800):
        now[0] = samples / 100.0
        assert not clock.is_done(samples, 10.0 / samples)
    # Either on as before, or all the way from here as with edges, of which a part may be thought to be chance.
    soonest, latest = 10_000.0 / 100.0, 8.0 * 12.5 ** (4.0 / 3.0)
    left = clock.progress(800, 10.0 / 800).seconds_left
    assert 1.2 * (soonest - now[0]) < left < 1.1 * (latest - now[0])


def test_kernels_that_the_first_pass_makes_do_not_count_for_all_others(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock = Clock(StopRule(each=0.01))
    # Eight seconds for kernels, then 100 samples a second.
    for samples in (100, 200, 300, 400):
        now[0] = 8.0 + samples / 100.0
        error = 0.1 * (100 / samples) ** 0.5
        assert not clock.is_done(samples, error, error / 0.01)
    # A hundred times the samples of the first pass, whatever that took.
    assert clock.progress(400, error).seconds_left == pytest.approx(96.0)


def test_what_passes_take_beside_their_samples_is_told_from_what_these_take(monkeypatch):
    """Half a second for each pass and 50 samples a second; passes that grow by a half, after one that makes kernels."""
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock, samples, new = Clock(StopRule(samples=3000)), 0, 8
    now[0] = 20.0
    clock.begin()
    forecasts = []
    while True:
        samples += new
        now[0] += 0.5 + new / 50.0 + (7.0 if samples == new else 0.0)
        if clock.is_done(samples, 1.0):
            break
        forecasts.append(now[0] + clock.progress(samples, 1.0).seconds_left)
        new = min(samples // 2, 3000 - samples)
    assert np.allclose(forecasts[3:], now[0], rtol=0.03)


def test_a_job_that_foresees_its_samples_is_believed_and_nothing_is_told_before(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock = Clock(StopRule(error=0.01), foresees=True)
    for samples in (100, 200):
        now[0] = samples / 100.0
        assert not clock.is_done(samples, 0.1)
        assert clock.progress(samples, 0.1).seconds_left is None
    # The fall of the error, which has not begun, decides between least and most.
    clock.foresee(500.0, 1000.0)
    assert clock.progress(200, 0.1).seconds_left == pytest.approx(8.0)
    assert clock.progress(1100, 0.1).seconds_left == 0.0
    now[0] = 4.0
    assert not clock.is_done(400, 0.0125)
    clock.foresee(500.0, 600.0)
    assert 1.0 < clock.progress(400, 0.0125).seconds_left <= 2.0


def test_the_end_of_a_job_by_either_of_two_rules_is_the_nearer_one(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock = Clock(StopRule(samples=500, error=0.01), foresees=True)
    for samples in (100, 200):
        now[0] = samples / 100.0
        clock.is_done(samples, 0.1)
    assert clock.progress(200, 0.1).seconds_left == pytest.approx(3.0)
    clock.foresee(300.0, 300.0)
    assert clock.progress(200, 0.1).seconds_left == pytest.approx(1.0)


@pytest.mark.parametrize("power, most", [(0.5, 0.38), (0.75, 0.26)])
@pytest.mark.slow
def test_the_forecast_of_the_worst_of_many_sensors_is_not_thrown_off_by_chance(
    monkeypatch, power, most
):
    """Fifty sensors of known errors, whose worst one ends the job after 150 passes: forecast after three tenths."""
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    rng = np.random.default_rng(4)
    groups, sensors, batch, passes = 16, 50, 256, 150
    off = []
    for _ in range(60):
        now[0] = 0.0
        scale = np.exp(0.4 * rng.normal(size=sensors))
        allowed = scale.max() * (batch * passes) ** -power / np.sqrt(groups)
        clock, walk, forecasts, samples = Clock(StopRule(each=1.0)), 0.0, [], 0
        while True:
            samples += batch
            now[0] += 1.0
            walk = walk + rng.normal(size=(groups, sensors)) * np.sqrt(batch)
            means = scale * walk / samples * samples ** (0.5 - power)
            error = Estimate.from_groups(means, samples).standard_error
            if clock.is_done(samples, np.sqrt(np.mean(error**2)), error.max() / allowed):
                break
            forecasts.append(now[0] + clock.progress(samples, 1.0).seconds_left)
        off.append(np.log(forecasts[int(0.3 * len(forecasts))] / now[0]))
    assert np.sqrt(np.mean(np.square(off))) < most
    assert abs(np.median(off)) < 0.12


@pytest.mark.parametrize("power", [0.5, 0.7])
def test_after_a_tenth_of_the_time_the_end_for_many_sensors_is_known_within_a_tenth(
    monkeypatch, power
):
    """A hundred sensors whose errors as a whole end the job, with passes of an eighth of all samples so far."""
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    rng = np.random.default_rng(7)
    groups, sensors, end = 16, 100, 60_000
    off = []
    for _ in range(40):
        scale = np.exp(0.3 * rng.normal(size=sensors))
        wanted = np.sqrt((scale**2).mean() / groups) * end**-power
        clock, samples, walk, forecasts = Clock(StopRule(error=wanted)), 0, 0.0, []
        while True:
            more = 64 if not samples else min(samples, max(1024, samples // 8))
            # Means of a group are like those of independent samples in what they keep of their chance.
            kept = np.sqrt(samples / (samples + more))
            walk = kept * walk + np.sqrt(1.0 - kept**2) * rng.normal(size=(groups, sensors))
            samples += more
            now[0] = float(samples)
            clock.grain = more
            made = Estimate.from_groups(1.0 + scale * walk * samples**-power, samples)
            error = made.relative_error()
            if clock.is_done(samples, error):
                break
            forecasts.append((samples, samples + clock.progress(samples, error).seconds_left))
        told = next(each for at, each in forecasts if at >= 0.1 * samples)
        off.append(told / samples - 1.0)
    assert np.median(np.abs(off)) < 0.1
    assert abs(np.median(off)) < 0.08


def test_nothing_is_foretold_before_passes_span_what_the_job_asks_for(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    left = []
    for fall in (
        Fall(power=0.6, support=1e6, begins=4.0, ends=math.inf),
        Fall(power=0.6, support=1e6, begins=4.0),
    ):
        clock = Clock(StopRule(error=0.01), fall=fall)
        now[0] = 0.0
        for samples in (100, 200, 400):
            assert clock.progress(samples, 1.0).seconds_left is None
            now[0] = samples / 100.0
            clock.is_done(samples, 0.1 * (100.0 / samples) ** 0.5)
        left.append(clock.progress(400, 0.05).seconds_left)
    # From what passes have shown on by the power that the job supposes, and by theirs where that has had its time.
    assert left[1] == pytest.approx(100.0 * 10.0**2 / 100.0 - 4.0)
    assert 0.4 * left[1] < left[0] < 0.75 * left[1]


def test_what_the_power_has_beyond_a_half_may_fade(monkeypatch):
    """Light that is well sampled falls fast, until what is left falls as plain Monte Carlo; else the end comes too soon."""
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])

    def error(samples):
        well_sampled = 0.3 * (1.0 - (samples / 100.0) ** -0.4) / 0.4
        return samples**-0.5 * math.exp(-well_sampled)

    def forecast(fades):
        now[0] = 0.0
        clock = Clock(StopRule(error=error(100_000.0)), fall=Fall(fades=fades, window=100.0))
        samples = 100
        while samples <= 10_000:
            now[0] = float(samples)
            clock.is_done(samples, error(samples))
            before, samples = samples, round(1.3 * samples)
        return before + clock.progress(before, error(before)).seconds_left

    assert forecast(0.4) == pytest.approx(100_000.0, rel=0.01)
    assert forecast(0.0) < 80_000.0


def test_what_comes_after_a_job_is_part_of_what_is_left(monkeypatch):
    """Half as many samples as the job ended with, but 50 at most, at 100 a second."""
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    for rule, rest in (
        (StopRule(samples=80), 0.4),
        (StopRule(samples=1000), 0.5),
        (StopRule(seconds=10.0), 0.5),
        (StopRule(samples=1000, seconds=0.6), 0.3),
    ):
        now[0] = 0.0
        clock = Clock(rule)
        clock.after = lambda samples: min(0.5 * samples, 50.0)
        end = min((rule.samples or 10**9) / 100.0, rule.seconds or 10.0)
        for samples in (20, 40):
            now[0] = samples / 100.0
            clock.is_done(samples, 1.0)
        left = clock.progress(40, 1.0).seconds_left
        assert left == pytest.approx(end - 0.4 + rest)
        # The samples are done, but not all.
        now[0] = end
        samples = round(100 * end)
        assert clock.is_done(samples, 1.0)
        state = clock.progress(samples, 1.0, "afterwards")
        assert state.stage == "afterwards"
        assert state.seconds_left == pytest.approx(rest)
        assert state.done == pytest.approx(end / (end + rest))


def test_a_job_that_has_ended_leaves_what_comes_after_it_alone(monkeypatch):
    """However much later it foresaw that its error would be low enough, as it has got there by chance."""
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock = Clock(StopRule(error=0.05), foresees=True)
    clock.after = lambda samples: 50.0
    clock.foresee(1000.0, 1000.0)
    for samples, error in ((100, 0.4), (200, 0.28), (400, 0.2), (600, 0.049)):
        now[0] = samples / 100.0
        is_done = clock.is_done(samples, error)
    assert is_done
    assert clock.progress(600, 0.049).seconds_left == pytest.approx(0.5)
    clock.restart()
    assert clock.progress(0, math.inf).seconds_left is None
