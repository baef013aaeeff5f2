"""When to stop, and the forecast of when that will be."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..errors import SceneError
from ..requirements.budget import left_to_samples
from .history import History


@dataclass(frozen=True)
class StopRule:
    """Stop at a number of samples per point, at a standard error, or after seconds; the first that is met.

    Parameters
    ----------
    samples : int or None    Per point.
    error : float or None    Relative standard error of the whole: root mean square over the mean. [-]
    seconds : float or None    [s]
    each : float or None    Relative standard error that every single value must reach. [-]
    floor : float    Values below it count as large as it for ``each``. [lx]
    limits : tuple of float    Standard error that each value must reach, one for each; instead of ``each``. [lx]
    absolute : float or None    Standard error of the whole: root mean square by area. For lux maps. [lx]
    """

    samples: int | None = None
    error: float | None = None
    seconds: float | None = None
    each: float | None = None
    floor: float = 0.0
    limits: tuple[float, ...] = ()
    absolute: float | None = None

    def __post_init__(self):
        """Refuse rules that never stop or make no sense."""
        if not self.limits and all(
            value is None
            for value in (self.samples, self.error, self.seconds, self.each, self.absolute)
        ):
            raise SceneError("no stopping rule: give a number of samples, an error or a time")
        for name, value in (
            ("samples", self.samples),
            ("error", self.error),
            ("time", self.seconds),
            ("error of every value", self.each),
            ("error in lux", self.absolute),
        ):
            if value is not None and not 0 < value < math.inf:
                raise SceneError(
                    f"the stopping rule's {name} is {value}, expected a number above 0"
                )
        for name, value in (("floor", self.floor), *(("limit", each) for each in self.limits)):
            if not 0 <= value < math.inf:
                raise SceneError(
                    f"the stopping rule's {name} is {value}, expected a number of at least 0"
                )

    @property
    def relative_goal(self) -> float | None:
        """Smallest relative error that is asked for, None if none is. [-]"""
        return min((goal for goal in (self.error, self.each) if goal is not None), default=None)

    def beside(self, bound: float, each: float | None = None) -> "StopRule":
        """The rule for samples, where results may be off by what these do not lower. [-]

        ``bound``: root mean square over the mean; ``each``: the largest of single values over these, None: all are alike.
        """

        def left(goal, bound):
            return None if goal is None else left_to_samples(goal, bound)

        each = bound if each is None else each
        return replace(self, error=left(self.error, bound), each=left(self.each, each))

    def beside_shares(self, shares: np.ndarray, made) -> "StopRule":
        """The rule for samples of values that may be off by shares of them, which more samples do not lower.

        Parameters
        ----------
        shares : (n,) array    [-]
        made : Estimate    The values, by few samples at least, with the errors by these alone. (n,)
        """
        if not shares.any():
            return self
        mean, largest = float(made.mean.mean()), float(shares.max())
        if not mean > 0.0:
            # Nothing was found yet that could weigh them.
            return self.beside(largest)
        # The square of an estimate is too large by that of its error.
        square = float((shares**2 * (made.mean**2 - made.standard_error**2)).mean())
        return self.beside(math.sqrt(max(square, 0.0)) / mean, largest)

    def shortfall(self, relative: float, absolute: float = math.inf, each: float = math.inf) -> str:
        """Say which error was wanted and not reached, because samples or time ended before, or more samples do not lower it.

        Parameters
        ----------
        relative, absolute, each : float
            Standard error of the whole [-] [lx] and the largest relative one of a single value [-], as they are.

        Returns
        -------
        str    Empty if one of the wanted errors was reached, as any of them ends a job, or if none was wanted.
        """
        wanted = [
            (self.error, relative, "relative standard error", 100.0, "%"),
            (self.absolute, absolute, "standard error", 1.0, "lx"),
            (self.each, each, "relative standard error of every value", 100.0, "%"),
        ]
        wanted = [entry for entry in wanted if entry[0] is not None]
        if not wanted or any(reached <= goal for goal, reached, *_ in wanted):
            return ""
        said = " and ".join(
            f"the wanted {name} of {unit_size * goal:.3g} {unit} was not reached, it is "
            + (f"{unit_size * reached:.3g} {unit}" if math.isfinite(reached) else "not known")
            for goal, reached, name, unit_size, unit in wanted
        )
        ends = [f"the time of {self.seconds:g} s"] if self.seconds is not None else []
        ends += [f"the {self.samples} samples"] if self.samples is not None else []
        return (
            f"{said}: {' or '.join(ends)} ended before"
            if ends
            else f"{said}: more samples do not lower it"
        )


@dataclass(frozen=True)
class Progress:
    """State of a running job.

    Parameters
    ----------
    done : float    Share of the time. [-]
    samples : int    Per point.
    relative_error : float    Infinite while unknown. [-]
    seconds : float    Since the start. [s]
    seconds_left : float or None    A forecast, None while none can be made. [s]
    stage : str    What is being done.
    absolute_error : float or None    Standard error of the whole, where it is of interest. [lx]
    history : History or None    Error over time, of lux maps.
    """

    done: float
    samples: int
    relative_error: float
    seconds: float
    seconds_left: float | None
    stage: str = ""
    absolute_error: float | None = None
    history: History | None = None

    def text(self) -> str:
        """One line for a status bar."""
        parts = [self.stage] if self.stage else []
        if self.samples or not parts:
            parts.append(f"{self.samples} samples")
        if self.relative_error < 1e6:
            parts.append(f"error {100.0 * self.relative_error:.2f} %")
        if self.absolute_error is not None and self.absolute_error < 1e12:
            parts.append(f"{self.absolute_error:.3g} lx")
        if self.seconds_left is not None:
            parts.append(f"{format_seconds(self.seconds_left)} left")
        return ", ".join(parts)


def format_seconds(seconds: float) -> str:
    """Human form of a duration."""
    seconds = round(seconds)
    if seconds < 60:
        return f"{seconds} s"
    if seconds < 3600:
        return f"{seconds // 60}:{seconds % 60:02d} min"
    return f"{seconds // 3600}:{seconds % 3600 // 60:02d} h"


def excesses_of(rule: StopRule, made) -> np.ndarray | None:
    """Errors of single values over what the rule allows them, None when it says nothing of these. (n,) [-]

    ``made``: an `Estimate`. (n,)
    """
    if rule.limits:
        allowed = np.array(rule.limits)
    elif rule.each is not None:
        allowed = rule.each * np.maximum(np.abs(made.mean), rule.floor)
    else:
        return None
    is_known = allowed > 0.0
    # A value of 0 without error counts as known.
    unknown = np.where(made.standard_error > 0.0, np.inf, 0.0)
    return np.where(is_known, made.standard_error / np.where(is_known, allowed, 1.0), unknown)


def excess_of(rule: StopRule, made) -> float | None:
    """The largest of `excesses_of`, None when the rule says nothing of single values."""
    excesses = excesses_of(rule, made)
    return None if excesses is None else float(excesses.max(initial=0.0))


SLOWEST, FASTEST = 0.4, 0.9
"""Bounds on the power of the samples by which an error is believed to go on falling: 1/2 for plain Monte Carlo.
Well-distributed samples make it fall faster at first, but by 3/4 only in the end where the integrand has edges."""

INDEPENDENT = 0.5
"""That power of plain Monte Carlo."""

STEP = 1.2
"""Ratio of samples between passes of which note is taken."""


@dataclass(frozen=True)
class Fall:
    """How the error of a kind of jobs is supposed to fall.

    Parameters
    ----------
    power : float    Of the samples. [-]
    support : float    How much that counts beside what passes tell, as a sum of squares of logarithms of ratios of samples.
    begins : float    Ratio of samples that passes have to span before anything is foretold.
    ends : float    Such a ratio from which on what passes tell counts alone.
    fades : float    Power of the samples by which what the present power has beyond 1/2 fades. [-]
    window : float    Ratio of samples over which the power is taken at most, as what was long ago says little.
    """

    power: float = INDEPENDENT
    support: float = 0.5
    begins: float = 1.0
    ends: float = 3.9
    fades: float = 0.0
    window: float = 64.0

    def law(self, now: float, power: float):
        """How the logarithm of an error falls, up to a constant, as a function of that of the samples, (n,) to (n,).

        Parameters
        ----------
        now : float    Logarithm of the present samples.
        power : float    By which the error falls there. [-]
        """
        return lambda along: INDEPENDENT * along + (power - INDEPENDENT) * self.bend(along - now)

    def bend(self, along):
        """Integral of what is left of the power beyond 1/2, from the present on; by logarithms of ratios of samples."""
        return -np.expm1(-self.fades * along) / self.fades if self.fades > 0.0 else along


PLAIN = Fall()
"""Of independent samples."""


FEWEST, UNLIKE = 3, 2.0
"""Passes, and ratio of the longest to the shortest of them in samples, from which on what each takes beside its samples is
told apart."""

LONGEST = 100.0
"""Logarithm of most samples that are foretold."""

ROUNDS = 50
"""Times that the interval which holds the samples needed is halved."""


def read_clock() -> float:
    """Time by which jobs are followed and forecasts are made. [s]"""
    return time.perf_counter()


class Clock:
    """Follows a job against its rule.

    The time left follows from the samples that are still needed, by how the error has fallen so far and within what the job
    foresees, and from what passes have taken: each for itself, and each of its samples.

    Parameters
    ----------
    rule : StopRule
    stage : str    What is being done.
    foresees : bool    Whether the job foresees its samples, so that none are foretold before it does.
    fall : Fall

    Attributes
    ----------
    grain : int    Samples of the passes to come; the job ends with one of them. 0: it may end anywhere.
    after : callable or None    How many samples as the job makes them what comes after it is worth, by those it ends with.

    Raises
    ------
    SceneError    The rule names an error in lux, which is for lux maps: their `forecast.Forecaster` knows it.
    """

    def __init__(self, rule: StopRule, stage: str = "", foresees: bool = False, fall: Fall = PLAIN):
        self.grain = 0
        self.after: Callable[[float], float] | None = None
        if rule.absolute is not None:
            raise SceneError(
                "an error in lux of the whole stops lux maps only: give a relative error, an error of "
                "every value, a number of samples or a time"
            )
        self.rule = rule
        self.stage, self._foresees, self._fall = stage, foresees, fall
        self._start = read_clock()
        # Samples, error of the whole and error over what is allowed, infinite where it is not believed, after passes that
        # lie apart; and the present state, once it is.
        self._history: list[tuple[int, float, float]] = []
        self._present: tuple[int, float, float] | None = None
        # Samples and seconds after all passes; the first one may have to make kernels.
        self._times: list[tuple[int, float]] = []
        self._begun = 0.0
        self._foreseen: tuple[float, float] | None = None
        self._is_met = False

    @property
    def seconds(self) -> float:
        """Seconds since the start."""
        return read_clock() - self._start

    def begin(self) -> None:
        """Take note that samples are taken from now on: what was prepared before is done once."""
        self._begun = self.seconds

    def foresee(self, least: float, most: float) -> None:
        """Take note between which samples the error will come to what is allowed, as the job foresees it."""
        self._foreseen = least, most

    @property
    def samples_needed(self) -> float | None:
        """Samples with which the rule will be met by number or error; None while nothing can be said."""
        needed = [] if self.rule.samples is None else [float(self.rule.samples)]
        if self._present is not None and (self._foreseen or self._can_tell):
            least, most = self._foreseen or (0.0, math.inf)
            needed.append(self._to_whole_passes(min(max(self._samples_needed(), least), most)))
        return min(needed, default=None)

    @property
    def _can_tell(self) -> bool:
        """Whether passes tell how many samples are needed."""
        return not self._foresees and self._present[0] >= self._fall.begins * self._history[0][0]

    def restart(self) -> None:
        """Forget how the error has fallen: from now on samples are others. Time goes on."""
        self._history, self._present = [], None
        self._times, self.grain = [(0, self.seconds)], 0
        self._begun, self._foreseen, self._is_met = self.seconds, None, False

    def progress(self, samples: int, error: float, stage: str | None = None) -> Progress:
        """Describe the state after so many samples; the error is that of the last finished pass.

        ``stage``: what is being done; None: what the job is.
        """
        seconds = self.seconds
        # A forecast knows less of the end than what has ended.
        ends = [0.0] if self._is_met else []
        if self.rule.seconds is not None:
            ends.append(self.rule.seconds - seconds)
        needed = self.samples_needed
        if needed is not None and samples > 0:
            ends.append(self._seconds_until(needed, samples, seconds))
        left = max(min(ends), 0.0) if ends else None
        if left is not None and samples > 0 and self.after is not None:
            each = self._pace(samples, seconds)[1]
            end = samples + (left / each if each > 0.0 else 0.0)
            left += each * self.after(end)
        done = 0.0
        if left is not None:
            done = seconds / (seconds + left) if seconds + left > 0.0 else 1.0
        return Progress(done, samples, error, seconds, left, stage or self.stage)

    def is_done(self, samples: int, error: float, excess: float | None = None) -> bool:
        """Take note of a finished pass and tell whether any part of the rule is met.

        Parameters
        ----------
        samples : int
        error : float    Relative error of the whole.
        excess : float or None    Largest error of a single value over what the rule allows it; None: not to be believed.
        """
        rule = self.rule
        excesses = [] if excess is None else [excess]
        if rule.error is not None:
            excesses.append(error / rule.error)
        excess = min(excesses, default=math.inf)
        self._times.append((samples, self.seconds))
        if 0.0 < error < math.inf and excess > 0.0:
            state = (samples, error, excess)
            if excess < math.inf:
                self._present = state
            if not self._history or samples >= STEP * self._history[-1][0]:
                self._history.append(state)
        self._is_met = (
            (rule.samples is not None and samples >= rule.samples)
            or (rule.seconds is not None and self.seconds >= rule.seconds)
            or excess <= 1.0
        )
        return self._is_met

    def _to_whole_passes(self, samples: float) -> float:
        """Samples at the end of the pass in which so many are reached, on the mean."""
        present = self._present[0]
        if samples <= present:
            return samples
        return max(samples + 0.5 * self.grain, present + self.grain)

    def _seconds_until(self, end: float, samples: int, seconds: float) -> float:
        """Seconds from the present samples to those at the end. [s]"""
        more = end - samples
        if more <= 0.0:
            return 0.0
        single, each = self._pace(samples, seconds)
        if single == 0.0:
            return more * each
        before, last = self._passes()[-2:, 0]
        many = more / last
        if last > before:
            # Passes grow: as many as it takes if all that is done grows by each as it did by the last one.
            done = self._times[-1][0]
            many = math.log(end / samples) / math.log(done / (done - last))
        return more * each + single * many

    def _pace(self, samples: int, seconds: float) -> tuple[float, float]:
        """What a pass takes beside its samples, 0 where that is not told apart, and what each of them takes. [s]"""
        passes = self._passes()
        if len(passes) < FEWEST or passes[:, 0].max() < UNLIKE * passes[:, 0].min():
            return 0.0, self._seconds_each(samples, seconds)
        return _fit_passes(*passes.T)

    def _passes(self) -> np.ndarray:
        """Samples and seconds of passes but the first. (n, 2)"""
        times = [each for each in self._times if each[0] > 0]
        passes = np.diff(np.array(times, dtype=np.float64).reshape(-1, 2), axis=0)
        return passes[(passes > 0.0).all(axis=1)]

    def _seconds_each(self, samples: int, seconds: float) -> float:
        """What a sample takes, by the later half of them. [s]"""
        before = [each for each in self._times if 2 * each[0] <= samples] or self._times[:1]
        if before and samples > before[-1][0]:
            return max(seconds - before[-1][1], 0.0) / (samples - before[-1][0])
        return (seconds - self._begun) / samples

    def _samples_needed(self) -> float:
        """Samples at which the error will be what is allowed, if it goes on falling as it has.

        The power is that of the error of the whole, which many values tell, by all passes in the window. What an error lies
        beside the law, which a few groups tell, is by chance: squares of sums of N and M samples have N / M of it in common.
        """
        fall = self._fall
        entries = [each for each in self._history if each[0] * fall.window >= self._present[0]]
        if not entries or entries[-1] != self._present:
            entries.append(self._present)
        samples, whole, excess = (np.log([entry[k] for entry in entries]) for k in range(3))
        low = now = float(samples[-1])
        along = fall.bend(samples - now)
        beyond = whole + INDEPENDENT * samples
        one, along, fallen = (_independent(each, samples) for each in (samples**0, along, beyond))
        apart = along - one * float(one @ along) / float(one @ one)
        is_alone = now - samples[0] >= math.log(fall.ends)
        support = 0.0 if is_alone else fall.support
        power = (fall.power - INDEPENDENT) * support - float(apart @ fallen)
        power = INDEPENDENT + power / (support + float(apart @ apart))
        law = fall.law(now, min(max(power, SLOWEST), FASTEST))
        # Errors of single values are not believed from the first pass on.
        is_known = np.isfinite(excess)
        levels, of_level = (excess + law(samples))[is_known], samples[is_known]
        one, levels_apart = (_independent(each, of_level) for each in (of_level**0, levels))
        level = float(one @ levels_apart) / float(one @ one)
        chance = float(levels[-1]) - level
        high = max(now + (float(excess[-1]) + abs(chance)) / SLOWEST, now)
        for _ in range(ROUNDS):
            end = 0.5 * (low + high)
            falls_short = level + chance * math.exp(now - end) > law(end)
            low, high = (end, high) if falls_short else (low, end)
        return math.exp(min(high, LONGEST))


def _independent(values: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """Combinations of values whose chances are independent and alike, if those of two have exp(-d) in common.

    ``samples``: logarithms of how many each value comes from, ascending; d is their difference.
    """
    common = np.exp(-np.diff(samples))
    rest = np.sqrt(np.maximum(1.0 - common**2, 1e-12))
    return np.concatenate([values[:1], (values[1:] - common * values[:-1]) / rest])


def _fit_passes(samples: np.ndarray, seconds: np.ndarray) -> tuple[float, float]:
    """What a pass takes beside its samples, and what each of them takes, both at least 0. [s]

    ``samples``, ``seconds``: of passes, (n,) each. Chance adds up along a pass, so its square counts by the time.
    """
    weights = 1.0 / seconds
    mean = np.average(samples, weights=weights)
    apart = samples - mean
    each = float((weights * apart) @ seconds / ((weights * apart) @ apart))
    single = float(np.average(seconds, weights=weights) - each * mean)
    if single < 0.0 or each <= 0.0:
        return 0.0, float(seconds.sum() / samples.sum())
    return single, each
