"""True errors without a converged picture, times to an error and bias by blocks, by closed forms."""

import time
import zlib

import numpy as np
import pytest

from lumenray.benchmarks.pictures.programs import Made
from lumenray.benchmarks.pictures.race import FINER, race, reach
from lumenray.benchmarks.pictures.statistics import (
    Reference,
    block_means,
    error_of_pair,
    find_bias,
    find_moved,
    seconds_to,
)

pytestmark = pytest.mark.mitsuba

SHAPE = (150, 240)


def true_picture() -> np.ndarray:
    """Half dark, half bright, with a lamp in it."""
    picture = np.full(SHAPE, 20.0)
    picture[:, 120:] = 100.0
    picture[:20, :20] = 5000.0
    return picture


def weights() -> np.ndarray:
    """One over the larger of a pixel's own and the mean luminance."""
    picture = true_picture()
    return 1.0 / np.maximum(picture, picture.mean())


def noisy(sigma: float, seed: int) -> np.ndarray:
    """Picture of independent pixels with a relative error of ``sigma`` each."""
    rng = np.random.default_rng(seed)
    return true_picture() + sigma * rng.standard_normal(SHAPE) / weights()


@pytest.mark.parametrize("own", [0.01, 0.05, 0.2])
def test_the_true_error_is_found_whatever_the_reference_has_of_its_own(own):
    """A run of 5 % against a mean of two pictures of ``own`` each, whose error is ``own`` over the root of 2."""
    reference = Reference(noisy(own, 1), noisy(own, 2))
    assert np.sqrt(reference.variance) == pytest.approx(own / np.sqrt(2.0), rel=0.05)
    runs = [reference.variance_of(noisy(0.05, seed)) for seed in range(10, 18)]
    assert np.sqrt(np.mean(runs)) == pytest.approx(0.05, rel=0.1)


def test_a_stray_bright_pixel_of_the_reference_spoils_no_error():
    first = noisy(0.05, 1)
    first[70, 70] = 1e6
    runs = [Reference(first, noisy(0.05, 2)).variance_of(noisy(0.1, k)) for k in range(10, 14)]
    assert np.sqrt(np.mean(runs)) == pytest.approx(0.1, rel=0.05)


def test_two_pictures_of_equal_work_tell_their_error():
    assert error_of_pair(noisy(0.08, 3), noisy(0.08, 4)) == pytest.approx(0.08, rel=0.03)


SAMPLES = 2 ** np.arange(1, 8)
"""Up to 128."""


def test_times_to_an_error_follow_runs_and_go_on_by_the_power_law():
    """The error is 0.8 / sqrt(n), the time 3 s + n / 2."""
    errors, seconds = 0.8 / np.sqrt(SAMPLES), 3.0 + 0.5 * SAMPLES
    within = seconds_to(SAMPLES, seconds, errors, 0.1)
    assert within.seconds == pytest.approx(3.0 + 32.0, rel=0.05)
    assert not within.is_thought_on
    # (0.8 / 0.02)^2 = 1600 samples: what was learned once is not paid again.
    beyond = seconds_to(SAMPLES, seconds, errors, 0.02)
    assert beyond.seconds == pytest.approx(803.0, rel=1e-6)
    assert beyond.is_thought_on
    assert seconds_to(SAMPLES, seconds, errors, 0.7) == seconds_to(SAMPLES[:1], [4.0], [0.5], 0.7)
    assert seconds_to(SAMPLES, seconds, errors, 0.7).bound == "<"


def test_a_lucky_run_is_not_believed_and_an_end_is_told():
    seconds = SAMPLES.astype(float)
    lucky = [0.5, 0.04, 0.3, 0.2, 0.15, 0.1, 0.04]
    assert 64.0 < seconds_to(SAMPLES, seconds, lucky, 0.05).seconds < 128.0
    flat = [0.5, 0.2, 0.11, 0.105, 0.102, 0.101, 0.1]
    assert seconds_to(SAMPLES, seconds, flat, 0.05).bound == ">"
    # Coarse runs fall more slowly and tell nothing: the last alone counts, by the power of independent paths.
    coarse = [0.5, 0.48, 0.45, 0.4]
    reached = seconds_to(SAMPLES[:4], seconds[:4], coarse, 0.1)
    assert reached.seconds == pytest.approx(16.0 * (0.4 / 0.1) ** 2, rel=1e-6)
    # Where runs scatter too much for a power, that of independent paths is taken, with the mean square of all.
    stray = 0.8 / np.sqrt(SAMPLES) * np.array([1, 1, 1, 2.0, 0.5, 2.0, 0.5])
    # Of the last four the first is too coarse.
    level = 0.8 * np.sqrt((0.5**2 + 2.0**2 + 0.5**2) / 3.0)
    expected = (level / 0.02) ** 2
    assert seconds_to(SAMPLES, seconds, stray, 0.02).seconds == pytest.approx(expected, rel=1e-6)
    # No paths converge faster than that: 128 samples of 0.1 become 0.05 by the power of -3/4.
    steep = 0.1 * 128.0 / SAMPLES
    assert seconds_to(SAMPLES, seconds, steep, 0.05).seconds >= 128.0 * 2.0 ** (4.0 / 3.0) / 1.5


def stack(sigma: float, first: int, offset=0.0, count: int = 8) -> np.ndarray:
    """Pictures of several seeds around an even grey of 50, with something added."""
    rng = np.random.default_rng(first)
    return 50.0 + offset + 50.0 * sigma * rng.standard_normal((count, *SHAPE))


def test_block_means_are_those_of_whole_blocks():
    means = block_means(np.arange(40.0)[None, :] * np.ones((33, 1)))
    assert means.tolist() == [[7.5, 23.5], [7.5, 23.5]]


def test_no_bias_is_found_where_there_is_none():
    found = find_bias(stack(0.1, 1), stack(0.1, 2))
    # A block of 256 pixels of 10 % has 0.625 % by one seed, and two means of 8 seeds differ by half of that.
    assert found["noise"] == pytest.approx(100 * 0.1 / 16.0 / 2.0, rel=0.1)
    assert found["worst"] == 0.0
    assert found["spread"] < 0.5 * found["noise"]
    assert abs(found["mean"]) < 2.0 * found["mean_interval"]
    assert found["blocks"] == 9 * 15


def test_a_bias_that_was_put_in_is_found():
    offset = np.zeros(SHAPE)
    offset[16:32, 32:48] = 2.5
    found = find_bias(stack(0.1, 3, offset), stack(0.1, 4))
    # 5 % of the mean in one block; what is beyond chance is that less the interval.
    assert found["largest"] == pytest.approx(5.0, abs=1.0)
    assert found["worst"] == pytest.approx(5.0 - found["interval"], abs=1.0)
    assert found["spread"] == pytest.approx(5.0 / np.sqrt(135.0), rel=0.4)
    whole = find_bias(stack(0.1, 5, 0.5), stack(0.1, 6))
    assert whole["mean"] == pytest.approx(1.0, abs=3.0 * whole["mean_interval"])
    assert whole["mean_interval"] < 0.1


def test_what_is_moved_in_the_same_samples_is_found_below_their_noise():
    own, offset = stack(0.5, 7), np.zeros(SHAPE)
    offset[16:32, 32:48] = 2.5
    found = find_moved(own + offset + stack(0.01, 8) - 50.0, own)
    # Pictures of other samples would differ by 1.6 % by chance.
    assert found["largest"] == pytest.approx(5.0, abs=0.1)
    assert found["worst"] == pytest.approx(5.0, abs=0.4)
    assert found["mean"] == pytest.approx(5.0 * 256 / offset.size, abs=found["mean_interval"])


class Pretender:
    """Program with a relative error of ``constant`` / sqrt(n), that says it took ``each`` seconds a sample."""

    least = 2

    def __init__(self, name: str, constant: float, each: float, log: list, stated=None):
        self.name, self.constant, self.each, self.stated, self.log = (
            name,
            constant,
            each,
            stated,
            log,
        )

    def render(self, samples: int, seed: int) -> Made:
        self.log.append((self.name, samples, seed))
        error = self.constant / np.sqrt(samples)
        picture = noisy(error, zlib.crc32(f"{self.name} {samples} {seed}".encode()))
        stated = None if self.stated is None else self.stated * error
        return Made(picture[..., None], picture, self.each * samples, stated)

    def refer(self, samples: int, seed: int) -> Made:
        return self.render(samples, seed)


def test_programs_race_in_turn_within_their_budget():
    log, budget = [], 100.0
    programs = [Pretender("a", 0.5, 0.1, log, 0.9), Pretender("b", 1.0, 0.4, log)]
    rows, pictures = race(programs, budget, lambda _line: None)
    for program in programs:
        row = rows[program.name]
        made = [samples for name, samples, seed in log if name == program.name and seed != 1]
        assert program.each * sum(made) <= budget
        # What is left of it makes the reference finer.
        finer = made[-1] // row["samples"][-1]
        assert finer == FINER or program.each * (sum(made[:-2]) + 4 * made[-1]) > budget
        # A further run and its reference would not have fitted.
        assert program.each * (sum(made) + 4 * row["samples"][-1]) > budget
        expected = program.constant / np.sqrt(row["samples"])
        # Bright noise counts by its own luminance.
        assert row["errors"] == pytest.approx(expected, rel=0.2)
        assert row["errors"][-1] == pytest.approx(expected[-1], rel=0.05)
        assert row["mean"] == pytest.approx(true_picture().mean(), abs=4.0 * row["mean_error"])
        assert len(pictures[program.name]) == len(row["samples"])
        target = 0.1
        seconds = program.each * (program.constant / target) ** 2
        assert reach(row, target).seconds == pytest.approx(seconds, rel=0.25)
    assert [name for name, _, seed in log if seed == 2000] == ["a", "b"]
    # No picture serves twice: all seeds of a program at equal work are others.
    assert len(set(log)) == len(log)
    assert rows["b"]["stated"] == [None] * len(rows["b"]["samples"])
    assert np.array(rows["a"]["stated"]) / rows["a"]["errors"] == pytest.approx(0.9, rel=0.1)


def test_a_program_that_is_good_enough_stops():
    rows, _ = race([Pretender("a", 0.05, 1e-3, [])], 1e9, lambda _line: None)
    # 0.05 / sqrt(n) < 0.7 * 0.02
    assert rows["a"]["samples"] == [2, 4, 8, 16]


def test_forecasts_in_processor_time_know_nothing_of_waiting():
    from lumenray.benchmarks.pictures.programs import processor_time
    from lumenray.engine.accuracy.stopping import Clock, StopRule

    with processor_time():
        clock = Clock(StopRule(seconds=1.0))
        time.sleep(0.3)
        assert clock.seconds < 0.2
    clock = Clock(StopRule(seconds=1.0))
    time.sleep(0.3)
    assert clock.seconds >= 0.3
