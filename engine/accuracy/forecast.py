"""When a bake will be done: error, time and samples are followed pass by pass and carried on."""

import math
from dataclasses import dataclass, replace

import numpy as np

from ..errors import SceneError
from .calibration import t_quantile
from .history import History, Mark
from .stopping import Progress, StopRule

GROUPS = 512
"""Groups into which parts of a map are put by how much their earlier samples are worth."""

LEAST_STEPS = 3
"""Passes that must have shown how much their errors scatter before a forecast gets bounds."""

FARTHEST = 1e12
"""Passes beyond which a rule counts as never met."""

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


class Spread:
    """How the square of the error falls while every pass spreads its samples alike.

    With v_t the share of the square of the error that part t of the maps holds at the beginning, W_t its samples by then and
    w_t those of every further pass, the square is after k passes in proportion to

        f(k) = sum v_t W_t / (W_t + k w_t) = sum q_t / (r_t + k),   r_t = W_t / w_t,  q_t = v_t r_t.

    Parts that get no more samples keep their share. Without earlier samples f(k) = 1 / k.

    Parameters
    ----------
    numerators, offsets : (n,) array    q and r.
    constant : float    Sum of the shares of parts without further samples.
    """

    def __init__(self, numerators=(1.0,), offsets=(0.0,), constant: float = 0.0):
        self.numerators = np.asarray(numerators, dtype=np.float64)
        self.offsets = np.asarray(offsets, dtype=np.float64)
        self.constant = float(constant)

    @classmethod
    def after(cls, variances, samples, per_pass) -> "Spread":
        """Spread of maps whose parts have samples already; parameters as of `Forecaster.respread`."""
        shares, before, more = np.broadcast_arrays(
            *(
                np.atleast_1d(np.asarray(each, dtype=np.float64))
                for each in (variances, samples, per_pass)
            )
        )
        counts = np.isfinite(shares) & (shares > 0.0) & (before > 0.0)
        goes_on = counts & (more > 0.0)
        constant = shares[counts & ~goes_on].sum()
        if not goes_on.any():
            return cls((), (), constant)
        shares, offsets = shares[goes_on], before[goes_on] / more[goes_on]
        # Parts count in the hundred thousands, but only the ratio of their samples matters.
        place = np.log(offsets)
        low, width = place.min(), max(float(np.ptp(place)), 1e-9)
        group = np.minimum((place - low) / width * GROUPS, GROUPS - 1).astype(np.int64)
        total = np.bincount(group, shares, GROUPS)
        used = total > 0.0
        mean = np.bincount(group, shares * offsets, GROUPS)[used] / total[used]
        return cls(total[used] * mean, mean, constant)

    def square(self, passes: float) -> float:
        """f(k), in the scale of the shares; infinite before any sample."""
        under = self.offsets + passes
        if (under <= 0.0).any():
            return math.inf
        return float((self.numerators / under).sum()) + self.constant

    def worth(self, passes: float) -> float:
        """Number of passes of this kind that all samples so far are worth: -f / f'."""
        under = self.offsets + passes
        slope = float((self.numerators / under**2).sum())
        return self.square(passes) / slope if slope > 0.0 else math.inf

    def passes_to(self, square: float, start: float) -> float:
        """Number k from ``start`` on at which f(k) has come down to ``square``; infinite if it never does."""
        if self.square(start) <= square:
            return start
        high = max(start, 1.0)
        while self.square(high) > square:
            high *= 2.0
            if high > FARTHEST:
                return math.inf
        low = start
        while high - low > 1e-9 * high:
            middle = 0.5 * (low + high)
            if self.square(middle) > square:
                low = middle
            else:
                high = middle
        return high


class Forecaster:
    """Follows a bake whose passes are independent replicates, and says when its rule will be met.

    The square of the error falls as `Spread` says, scaled to the error that was measured last; a pass takes as long
    as those before it. A bake ends at the end of a pass.

    Parameters
    ----------
    rule : StopRule    Of error, absolute error, time and samples, whichever is met first.
    setup_seconds : float    Spent in this part of the bake before the first pass. [s]
    earlier_seconds : float    Spent in earlier parts of a resumed bake; `from_state` knows them. [s]

    Raises
    ------
    SceneError    The rule speaks of single values.
    """

    def __init__(self, rule: StopRule, setup_seconds: float, earlier_seconds: float = 0.0):
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
        self._absolute = math.inf
        self._passes = 0
        self._spread = Spread()
        # Of the passes of the present spread; the first of a process also makes kernels.
        self._durations: list[float] = []
        self._first_duration: float | None = None
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
        pass_seconds: float | None = None,
        absolute: float | None = None,
        passes: int = 1,
    ) -> Mark:
        """Take note of finished passes.

        Parameters
        ----------
        seconds : float    Since the start of this part of the bake. [s]
        samples : float    Mean number per lumel, of all parts of the bake.
        error : float    Relative standard error of everything, infinite while unknown. [-]
        pass_seconds : float or None    What a pass took; None: the time since the last note. [s]
        absolute : float or None    Standard error of everything, root mean square by area. [lx]
        passes : int    How many have ended since the last note.

        Returns
        -------
        Mark    With the forecast that was made.
        """
        before = self._marks[-1].samples if self._marks else 0.0
        if pass_seconds is None:
            pass_seconds = (seconds - self._until) / passes
        self._until = seconds
        self._passes += passes
        self._pass_samples = (samples - before) / passes
        if self._first_duration is None:
            self._first_duration = pass_seconds
        else:
            self._durations.append(pass_seconds)
        self._absolute = math.inf if absolute is None else absolute
        self._learn_scatter(error)
        now = Mark(self._earlier + seconds, samples, error, None)
        self.outlook = self._forecast(now)
        self._marks.append(replace(now, forecast=self.forecast()))
        return self._marks[-1]

    def respread(
        self,
        variances,
        samples,
        per_pass,
        pass_samples: float | None = None,
        pass_seconds: float | None = None,
    ) -> None:
        """Say that passes from now on spread their samples otherwise.

        Parameters
        ----------
        variances : (t,) array or float
            What each part of the maps adds to the square of the error at present, in any scale: its area times the mean
            square of its lumels' errors.
        samples, per_pass : (t,) array or float
            Samples of a lumel of each part so far, and in every pass to come. Where only the error e1 of a single new pass
            is known, 1, (e1 / e)^2 and 1 say so, with the present error e.
        pass_samples : float or None    Mean number per lumel in a pass to come; None: as before.
        pass_seconds : float or None    What a pass to come will take; None: in proportion to its samples. [s]
        """
        if pass_seconds is None and self._known_seconds() is not None:
            scale = 1.0
            if pass_samples is not None and self._pass_samples:
                scale = pass_samples / self._pass_samples
            pass_seconds = self._known_seconds() * scale
        self._pass_seconds = pass_seconds
        self._pass_samples = self._pass_samples if pass_samples is None else pass_samples
        self._durations = []
        self._spread, self._passes = Spread.after(variances, samples, per_pass), 0
        self._steps = self._all_steps()
        self._own_steps, self._running = [], None
        if self._marks:
            last = self._marks[-1]
            self._learn_scatter(last.error)
            self.outlook = self._forecast(last)
            # What is told to people after this pass is the forecast for the passes that really follow.
            self._marks[-1] = replace(last, forecast=self.forecast())

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
        if last.error <= self._target(last.error):
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
            absolute_error=None if self.rule.absolute is None else self._absolute,
        )

    @property
    def history(self) -> History:
        """Marks so far; an error asked for in lux stands as what it is of the present mean."""
        error = self._marks[-1].error if self._marks else math.inf
        target = self._target(error)
        return History(tuple(self._marks), target if target > 0.0 else None, self._setup)

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
        numbers = (self._setup, self._absolute, self._passes, self._spread.constant)
        known = (self._known_seconds(), self._pass_samples, *(self._running or (None, None)))
        return {
            "marks": np.array(marks, dtype=np.float64).reshape(-1, MARK_FIELDS),
            "numbers": np.array(numbers, dtype=np.float64),
            "known": np.array([math.nan if each is None else each for each in known]),
            "numerators": self._spread.numerators,
            "offsets": self._spread.offsets,
            "steps": np.array(self._steps, dtype=np.float64),
            "own_steps": np.array(self._own_steps, dtype=np.float64),
        }

    @classmethod
    def from_state(
        cls, rule: StopRule, state: dict[str, np.ndarray], setup_seconds: float = 0.0
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
            "numerators": 1,
            "offsets": 1,
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
            and len(numbers) == len(known) == 4
            and state["numerators"].shape == state["offsets"].shape
            and np.isfinite(numbers[[0, 2, 3]]).all()
            and np.isfinite(marks[:, :2]).all()
        )
        if not fits:
            raise SceneError("the state of the forecast does not fit together")
        made = cls(rule, setup_seconds, float(marks[-1, 0]) if len(marks) else 0.0)
        made._marks = [
            Mark(seconds, samples, error, None if math.isnan(forecast) else forecast)
            for seconds, samples, error, forecast in marks.tolist()
        ]
        setup, made._absolute, passes, constant = numbers.tolist()
        made._setup = setup if len(marks) else made._setup
        made._passes = int(passes)
        made._spread = Spread(state["numerators"], state["offsets"], constant)
        made._pass_seconds, made._pass_samples, *running = (
            None if math.isnan(each) else each for each in known.tolist()
        )
        made._running = None if running[0] is None else tuple(running)
        made._steps, made._own_steps = state["steps"].tolist(), state["own_steps"].tolist()
        if made._marks:
            made.outlook = made._forecast(made._marks[-1])
        return made

    def _target(self, error: float) -> float:
        """Relative error that satisfies the rule; 0: none does."""
        targets = [0.0 if self.rule.error is None else self.rule.error]
        if self.rule.absolute is not None and 0.0 < self._absolute < math.inf:
            # Both errors fall alike, as the mean stays what it is.
            targets.append(error * self.rule.absolute / self._absolute)
        return max(targets)

    def _known_seconds(self) -> float | None:
        """Duration of a pass: mean of the middle half of those that were timed, so that a hiccup does not count."""
        if self._durations:
            ordered = sorted(self._durations)
            cut = len(ordered) // 4
            middle = ordered[cut : len(ordered) - cut]
            return sum(middle) / len(middle)
        return self._first_duration if self._pass_seconds is None else self._pass_seconds

    def _forecast(self, now: Mark) -> Forecast | None:
        """Forecast from the state ``now``, the end of the last pass."""
        rule, each = self.rule, self._known_seconds()
        if each is None or each <= 0.0:
            return None
        needed = {}
        if rule.seconds is not None:
            needed["time"] = (rule.seconds - now.seconds) / each
        if rule.samples is not None and self._pass_samples:
            needed["samples"] = (rule.samples - now.samples) / self._pass_samples
        target = self._target(now.error)
        square = self._spread.square(self._passes)
        is_known = 0.0 < now.error < math.inf and 0.0 < square < math.inf
        if target > 0.0 and now.error <= target:
            needed["error"] = 0.0
        elif target > 0.0 and is_known:
            wanted = square * (target / now.error) ** 2
            needed["error"] = self._spread.passes_to(wanted, self._passes) - self._passes
        if not needed or min(needed.values()) > FARTHEST:
            return None
        reason = min(needed, key=needed.get)
        passes = max(math.ceil(needed[reason] - 1e-6), 0)
        error = math.inf
        if is_known:
            error = now.error * math.sqrt(self._spread.square(self._passes + passes) / square)
        low = high = seconds = now.seconds + passes * each
        if reason == "error":
            width = self._half_width(passes)
            rest = [value for name, value in needed.items() if name != "error"]
            latest = (
                now.seconds + max(math.ceil(min(rest, default=math.inf)), 0) * each
                if rest
                else math.inf
            )
            low = None if width is None else max(now.seconds, seconds - width * each)
            high = None if width is None else min(seconds + width * each, latest)
        return Forecast(
            seconds, low, high, now.samples + passes * (self._pass_samples or 0.0), error, reason
        )

    def _learn_scatter(self, error: float) -> None:
        """Tell the new pass's own contribution to the square of the error from the running mean.

        A running estimate y of N passes is a sum of N - 1 contributions over N - 1; these are independent where values are
        normal, so their scatter tells how far y may be off, however much the errors of neighbouring lumels go together.
        """
        square = self._spread.square(self._passes)
        if not (0.0 < error < math.inf and 0.0 < square < math.inf):
            return
        number = self._spread.worth(self._passes) - 1.0
        if not 0.0 < number < math.inf:
            return
        total = error**2 / square * number
        if self._running is None:
            if self._passes > 1 and not self._steps:
                # Passes that were noted together, or the first two: one contribution, of their mean.
                self._own_steps.append(total / number)
        elif number > self._running[0]:
            before, sum_before = self._running
            self._own_steps.append((total - sum_before) / (number - before))
        self._running = (number, total)

    def _all_steps(self) -> list[float]:
        """Contributions over their mean, of all spreads so far."""
        own = np.array(self._own_steps)
        mean = own.mean() if len(own) else 0.0
        return [*self._steps, *(own / mean).tolist()] if mean > 0.0 else list(self._steps)

    def _half_width(self, passes: int) -> float | None:
        """Half width of the 95 % interval of the number of passes still to go."""
        steps = self._all_steps()
        count = len(steps)
        number = self._spread.worth(self._passes)
        if count < LEAST_STEPS or not number < math.inf:
            return None
        end = self._spread.worth(self._passes + passes)
        # The end is decided by the error measured then, which holds the passes of now as well.
        variance = float(np.var(steps, ddof=1)) * max(1.0 / count - 1.0 / max(end, count), 0.0)
        return t_quantile(0.975, count - 1) * math.sqrt(variance) * end
