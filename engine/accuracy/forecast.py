"""When a bake will be done: error, time and samples are followed pass by pass and carried on."""

import math
from dataclasses import dataclass, replace

import numpy as np

from ..errors import SceneError
from .history import History, Mark
from .stopping import Progress, StopRule
from .student import t_quantile

LEAST_STEPS = 3
"""Passes that must have shown how much their errors scatter before a forecast gets bounds."""

FINEST = 0.5
"""Part of a pass that the last one may be, a power of two. Where low-discrepancy points make the variance of a pass fall
by the square of its samples, less than a half would add nothing to the passes before it. [-]"""

PART = 0.75
"""A pass with less than such a share of the samples expected counts as a part of one. [-]"""

FARTHEST = 1e12
"""Passes beyond which a rule counts as never met."""

TRUST = 0.5
"""Passes that the error foretold for new ones is worth, against those that have shown it since."""

MARK_FIELDS = 4
"""Numbers of a mark."""


@dataclass(frozen=True)
class Forecast:
    """When the rule will be met.

    Parameters
    ----------
    seconds : float    Since the start of the bake. [s]
    low, high : float or None    Bounds of ``seconds`` that hold in 95 % of cases as far as the scatter of the passes'
        errors goes; None while too few passes have been seen. [s]
    samples : float    Mean number per lumel at that time.
    error : float    Relative standard error of everything at that time; infinite while unknown. [-]
    reason : str    What will be met: ``error``, ``time`` or ``samples``.
    """

    seconds: float
    low: float | None
    high: float | None
    samples: float
    error: float
    reason: str


class Forecaster:
    """Follows a bake whose passes are independent replicates, and says when its rule will be met.

    The square of the error falls as 1 / (r + k) over k passes of the present kind, where r is how many of them the samples
    before are worth. It is scaled to the error that was measured last; for passes of a kind that has just begun also to the
    error that was foretold for it, as two passes at least must show how they differ. A pass takes as long as those before
    it. The last one may be a part, so that a bake does not go far beyond its rule.

    Parameters
    ----------
    rule : StopRule    Of error, absolute error, time and samples, whichever is met first.
    setup_seconds : float    Spent in this part of the bake before the first pass. [s]
    earlier_seconds : float    Spent in earlier parts of a resumed bake; `from_state` knows them. [s]
    finest : float    Smallest part of a pass that the last one may be, a power of two; 1: whole passes only. [-]
    planned : int    Passes after which the error should be met; the last of them is a whole one, whatever is thought to be
        missing before it. 0: there is no such plan. `replan` may tell another number.

    Raises
    ------
    SceneError    The rule speaks of single values.
    """

    def __init__(
        self,
        rule: StopRule,
        setup_seconds: float,
        earlier_seconds: float = 0.0,
        finest: float = FINEST,
        planned: int = 0,
    ):
        if rule.each is not None or rule.limits:
            raise SceneError(
                "an error of every value stops measurements at points only: give lux maps an error of the "
                "whole, a number of samples or a time"
            )
        self.rule = rule
        self.outlook: Forecast | None = None
        self._marks: list[Mark] = []
        self._setup = earlier_seconds + setup_seconds
        self._earlier = earlier_seconds
        # When the last pass ended, as this part counts its time.
        self._until = setup_seconds
        self._finest, self._planned = finest, planned
        # Of everything, which relates errors in lux to relative ones. [lx]
        self._mean: float | None = None
        self._passes = 0.0
        self._is_whole = True
        # What is worth as many passes of the present kind as were made before them.
        self._before = 0.0
        # Square of the error of a single pass, as it was foretold.
        self._foretold: float | None = None
        # Of the passes of the present kind; the first of a process also makes kernels.
        self._durations: list[float] = []
        self._first_duration: float | None = None
        self._is_timed = False
        self._pass_seconds: float | None = None
        self._pass_samples: float | None = None
        # Single contributions to the square of the error, over their mean; and the sum that they are told from.
        self._steps: list[float] = []
        self._own_steps: list[float] = []
        self._running: tuple[float, float] | None = None

    def note(
        self,
        seconds: float,
        samples: float,
        error: float,
        absolute: float | None = None,
        passes: int = 1,
        extra_seconds: float = 0.0,
    ) -> Mark:
        """Take note of finished passes.

        Parameters
        ----------
        seconds : float    Since the start of this part of the bake. [s]
        samples : float    Mean number per lumel, of all parts of the bake.
        error : float    Relative standard error of everything, infinite while unknown. [-]
        absolute : float or None    Standard error of everything, root mean square by area. [lx]
        passes : int    How many have ended since the last note.
        extra_seconds : float
            What the time since the last note holds beyond the usual, such as a check that is not made in every pass; below 0
            where it holds less. [s]

        Returns
        -------
        Mark    With the forecast that was made.
        """
        before = self._marks[-1].samples if self._marks else 0.0
        pass_seconds = max(seconds - self._until - extra_seconds, 0.0) / passes
        self._until = seconds
        added, worth = (samples - before) / passes, 1.0
        if self._pass_samples and added < PART * self._pass_samples:
            worth = added / self._pass_samples
        else:
            self._pass_samples = added
        self._passes += worth * passes
        self._is_whole = worth == 1.0
        if not self._is_timed:
            self._first_duration, self._is_timed = pass_seconds, True
        elif worth == 1.0:
            self._durations.append(pass_seconds)
        if absolute is not None and 0.0 < absolute < math.inf and 0.0 < error < math.inf:
            self._mean = absolute / error
        self._learn_scatter(error)
        now = Mark(self._earlier + seconds, samples, error, None)
        self.outlook = self._forecast(now)
        self._marks.append(replace(now, forecast=self.forecast()))
        return self._marks[-1]

    def replan(
        self,
        worth: float,
        pass_samples: float,
        pass_seconds: float | None = None,
        seconds: float | None = None,
        planned: int | None = None,
    ) -> None:
        """Say that passes from now on are of another kind.

        Parameters
        ----------
        worth : float
            How many of them all samples so far are worth: (e1 / e)^2 with the error e1 of a single one and the present
            error e.
        pass_samples : float    Mean number per lumel in a pass to come.
        pass_seconds : float or None    What a pass to come will take; None: in proportion to its samples. [s]
        seconds : float or None    Present time, as `note` counts it, where something else than passes has taken time
            since; None: unknown, and the time until the next note tells nothing of a pass. [s]
        planned : int or None    How many of these passes are planned; None: as before.
        """
        if planned is not None:
            self._planned = planned
        if seconds is None:
            self._is_timed = False
        else:
            self._until = seconds
        if pass_seconds is None and self.pass_seconds is not None:
            pass_seconds = self.pass_seconds
            if self._pass_samples:
                pass_seconds *= pass_samples / self._pass_samples
        self._pass_seconds = pass_seconds
        self._pass_samples = pass_samples
        self._durations = []
        self._before, self._passes = worth, 0.0
        self._steps = self._all_steps()
        self._own_steps, self._running, self._foretold = [], None, None
        if self._marks:
            last = self._marks[-1]
            self._foretold = self._measured(last.error)
            self._learn_scatter(last.error)
            # What is told to people after this pass is the forecast for the passes that really follow, made only now.
            now = last if seconds is None else replace(last, seconds=self._earlier + seconds)
            self.outlook = self._forecast(replace(now, seconds=self._earlier + self._until))
            self._marks[-1] = replace(now, forecast=self.forecast())

    def passes_needed(self) -> float | None:
        """Passes still to go, not rounded to parts that can be made; 0 when done, None while nothing can be said."""
        if self.is_done():
            return 0.0
        needed = self._needed(self._marks[-1]) if self._marks else {}
        least = min(needed.values(), default=math.inf)
        return max(least, 0.0) if least < FARTHEST else None

    def is_last_planned(self) -> bool:
        """Whether the next pass is the last one of the plan, after which the error should be met."""
        is_error = self.outlook is not None and self.outlook.reason == "error"
        return is_error and self._passes == self._planned - 1

    def forecast(self) -> float | None:
        """Seconds from the start at which the rule will be met; None while nothing can be said. [s]"""
        return None if self.outlook is None else self.outlook.seconds

    def is_done(self) -> bool:
        """Whether any part of the rule is met at the end of the last pass."""
        return self.reason() is not None

    def reason(self) -> str | None:
        """Part of the rule that is met: ``error``, ``samples``, ``time``, or None."""
        if not self._marks:
            return None
        last, rule = self._marks[-1], self.rule
        if last.error <= self._target():
            return "error"
        if rule.samples is not None and last.samples >= rule.samples * (1.0 - 1e-9):
            return "samples"
        if rule.seconds is not None and last.seconds >= rule.seconds:
            return "time"
        return None

    def progress(self, seconds: float, stage: str = "") -> Progress:
        """Describe the state; ``seconds`` since the start of this part of the bake. Full only when the rule is met."""
        seconds += self._earlier
        last = self._marks[-1] if self._marks else Mark(seconds, 0.0, math.inf, None)
        end = self.forecast()
        if self.is_done():
            done, left = 1.0, 0.0
        elif end is None:
            limit = self.rule.seconds
            done, left = (0.0, None) if limit is None else (seconds / limit, limit - seconds)
        else:
            done, left = seconds / max(end, 1e-9), end - seconds
        return Progress(
            done=1.0 if self.is_done() else min(done, 0.999),
            samples=round(last.samples),
            relative_error=last.error,
            seconds=seconds,
            seconds_left=None if left is None else max(left, 0.0),
            stage=stage,
            absolute_error=None if self.rule.absolute is None else last.error * (self._mean or 1.0),
            history=self.history,
        )

    @property
    def pass_seconds(self) -> float | None:
        """Duration of a pass: mean of the middle half of those that were timed, so that a hiccup does not count. [s]"""
        if self._durations:
            ordered = sorted(self._durations)
            cut = len(ordered) // 4
            middle = ordered[cut : len(ordered) - cut]
            return sum(middle) / len(middle)
        return self._first_duration if self._pass_seconds is None else self._pass_seconds

    @property
    def history(self) -> History:
        """Marks so far; an error asked for in lux stands as what it is of the present mean."""
        target = self._target()
        outlook = self.outlook
        end = None if outlook is None or not outlook.error < math.inf else outlook.error
        return History(tuple(self._marks), target if target > 0.0 else None, self._setup, end)

    def state(self) -> dict[str, np.ndarray]:
        """Everything but the rule, for a checkpoint."""
        marks = [
            (
                mark.seconds,
                mark.samples,
                mark.error,
                math.nan if mark.forecast is None else mark.forecast,
            )
            for mark in self._marks
        ]
        numbers = (
            self._setup,
            self._passes,
            self._is_whole,
            self._planned,
        )
        running = self._running or (None, None)
        known = (
            self.pass_seconds,
            self._pass_samples,
            self._mean,
            self._foretold,
            self._before,
            *running,
        )
        return {
            "marks": np.array(marks, dtype=np.float64).reshape(-1, MARK_FIELDS),
            "numbers": np.array(numbers, dtype=np.float64),
            "known": np.array([math.nan if each is None else each for each in known]),
            "steps": np.array(self._steps, dtype=np.float64),
            "own_steps": np.array(self._own_steps, dtype=np.float64),
        }

    @classmethod
    def from_state(
        cls,
        rule: StopRule,
        state: dict[str, np.ndarray],
        setup_seconds: float = 0.0,
        finest: float = FINEST,
    ) -> "Forecaster":
        """Forecaster that goes on from a state; ``setup_seconds`` were spent in the new part before its first pass.

        Raises
        ------
        SceneError    The arrays do not belong together.
        """
        wanted = {
            "marks": 2,
            "numbers": 1,
            "known": 1,
            "steps": 1,
            "own_steps": 1,
        }
        if any(
            name not in state or state[name].ndim != sides or state[name].dtype != np.float64
            for name, sides in wanted.items()
        ):
            raise SceneError("the state of the forecast is incomplete")
        marks, numbers, known = state["marks"], state["numbers"], state["known"]
        fits = (
            marks.shape[1] == MARK_FIELDS
            and (len(numbers), len(known)) == (4, 7)
            and np.isfinite(numbers).all()
            and np.isfinite(marks[:, :2]).all()
        )
        if not fits:
            raise SceneError("the state of the forecast does not fit together")
        earlier = float(marks[-1, 0]) if len(marks) else 0.0
        made = cls(rule, setup_seconds, earlier, finest)
        made._marks = [
            Mark(seconds, samples, error, None if math.isnan(forecast) else forecast)
            for seconds, samples, error, forecast in marks.tolist()
        ]
        setup, passes, is_whole, planned = numbers.tolist()
        made._setup = setup if len(marks) else made._setup
        made._passes, made._is_whole, made._planned = passes, bool(is_whole), int(planned)
        made._pass_seconds, made._pass_samples, made._mean, made._foretold, before, *running = (
            None if math.isnan(each) else each for each in known.tolist()
        )
        made._before = before or 0.0
        made._running = None if running[0] is None else tuple(running)
        made._steps, made._own_steps = state["steps"].tolist(), state["own_steps"].tolist()
        if made._marks:
            made.outlook = made._forecast(made._marks[-1])
        return made

    @property
    def _worth(self) -> float:
        """How many passes of the present kind all samples so far are worth."""
        return self._before + self._passes

    def _target(self) -> float:
        """Relative error that satisfies the rule; 0: none does."""
        targets = [self.rule.error or 0.0]
        if self.rule.absolute is not None and self._mean:
            targets.append(self.rule.absolute / self._mean)
        return max(targets)

    def _measured(self, error: float) -> float | None:
        """Square of the error of a single pass by a measured error; None while that says nothing."""
        if 0.0 < error < math.inf and self._worth > 0.0:
            return error**2 * self._worth
        return None

    def _scale(self, error: float) -> float | None:
        """Square of the error of a single pass, as measured and as foretold."""
        measured = self._measured(error)
        if self._foretold is None or self._foretold <= 0.0:
            return measured
        # A single pass beside a few small ones does not show how large its error is.
        shown = 0.0 if measured is None else max(self._passes - 1.0, 0.0)
        return (TRUST * self._foretold + shown * (measured or 0.0)) / (TRUST + shown)

    def _needed(self, now: Mark) -> dict[str, float]:
        """Passes until each part of the rule is met, from the end of the last pass."""
        rule, each = self.rule, self.pass_seconds
        needed = {}
        if rule.seconds is not None and each is not None and each > 0.0:
            needed["time"] = (rule.seconds - now.seconds) / each
        if rule.samples is not None and self._pass_samples:
            needed["samples"] = (rule.samples - now.samples) / self._pass_samples
        target, scale = self._target(), self._scale(now.error)
        if target > 0.0 and now.error <= target:
            needed["error"] = 0.0
        elif target > 0.0 and scale is not None:
            # As long as the measured error is not low enough, a part of a pass at least is due; where that has not been
            # enough, a whole one, as parts may add little.
            missing = scale / target**2 - self._worth
            needed["error"] = max(missing, self._finest if self._is_whole else 1.0)
        return needed

    def _forecast(self, now: Mark) -> Forecast | None:
        """Forecast from the state ``now``, the end of the last pass."""
        each, needed = self.pass_seconds, self._needed(now)
        if each is None or each <= 0.0 or not needed or min(needed.values()) > FARTHEST:
            return None
        reason = min(needed, key=needed.get)
        passes = self._rounded(needed[reason])
        if reason == "error" and self._planned - 1 < self._passes + passes < self._planned:
            passes = self._planned - self._passes
        scale = self._scale(now.error)
        error = math.inf
        if scale is not None:
            error = math.sqrt(scale / (self._worth + passes))
        low = high = seconds = now.seconds + passes * each
        if reason == "error":
            rest = min((value for name, value in needed.items() if name != "error"), default=None)
            latest = math.inf if rest is None else now.seconds + self._rounded(rest) * each
            width = self._half_width(passes)
            low = None if width is None else max(now.seconds, seconds - width * each)
            high = None if width is None else min(seconds + width * each, latest)
        samples = now.samples + passes * (self._pass_samples or 0.0)
        return Forecast(seconds, low, high, samples, error, reason)

    def _rounded(self, passes: float) -> float:
        """Whole passes and a last one of a half, a quarter and so on, which together are no fewer than asked for."""
        passes = max(passes - 1e-6, 0.0)
        whole = math.floor(passes)
        rest = passes - whole
        if rest <= 0.0:
            return float(whole)
        return whole + max(2.0 ** math.ceil(math.log2(rest)), self._finest)

    def _learn_scatter(self, error: float) -> None:
        """Tell the new pass's own contribution to the square of the error from the running mean.

        A running estimate y of N passes is a sum of N - 1 contributions over N - 1; these are independent where values are
        normal, so their scatter tells how far y may be off, however much the errors of neighbouring lumels go together.
        """
        measured = self._measured(error)
        number = self._worth - 1.0
        if measured is None or number <= 0.0:
            return
        total = measured * number
        if self._running is None:
            if self._passes > 1 and not self._steps:
                # Passes that were noted together, or the first two: one contribution, of their mean.
                self._own_steps.append(total / number)
        elif number > self._running[0]:
            before, sum_before = self._running
            self._own_steps.append((total - sum_before) / (number - before))
        self._running = (number, total)

    def _all_steps(self) -> list[float]:
        """Contributions over their mean, of all kinds of passes so far."""
        own = np.array(self._own_steps)
        mean = own.mean() if len(own) else 0.0
        return [*self._steps, *(own / mean).tolist()] if mean > 0.0 else list(self._steps)

    def _half_width(self, passes: float) -> float | None:
        """Half width of the 95 % interval of the number of passes still to go."""
        steps = self._all_steps()
        count = len(steps)
        if count < LEAST_STEPS:
            return None
        end = self._worth + passes
        # The end is decided by the error measured then, which holds the passes of now as well.
        variance = float(np.var(steps, ddof=1)) * max(1.0 / count - 1.0 / max(end, count), 0.0)
        return t_quantile(0.975, count - 1) * math.sqrt(variance) * end
