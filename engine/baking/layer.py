"""One layer of a bake: passes of a lux map job until its rule is met, with a forecast, and with a state to go on from."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..accuracy.forecast import Forecaster
from ..accuracy.replicates import ReplicateSums
from ..accuracy.stopping import Progress, StopRule
from ..errors import Cancelled
from ..transport.lux_maps.job import CHECK_INTERVAL, Levels, LuxJob
from ..transport.lux_maps.pilot import Pilot

PASSES = 8
"""Passes in which a bake is planned to reach its rule: enough for an error of every lumel, few enough for
low-discrepancy points to pay within each."""

SPARED = 0.4
"""Part of a pass that the plan can do without: the error of what is foretold for all of them is about 4 %, so the rule is
met after the last one nine times in ten, and the bake ends when it was said to."""

FEWEST_PASSES = 2
"""From which an error can be told; then the others are planned anew."""

SHORTEST = 1
"""How often the samples of the first passes are halved for the others at most. As samples are the weights of passes, much
shorter ones, of variances that fall faster than their samples do, would only add to the error; nor are they worth their
sweeps."""

HURRY = 3
"""How often the samples of passes are halved that are made only to have an error when a bake is stopped early."""

MOST_PASSES = 4.0
"""Times the planned passes that a bake which goes on with another rule may take as they are."""

SHORT = 32
"""Up to so many samples there is no pilot: it would cost more than it saves."""

TRIED = 1.0 / 16.0
"""Share of the lumels on which a planned pass is tried, which finds how variances fall."""

MOST_TRIALS, SETTLED = 2, 1.5
"""Most such trials, and ratio between the samples of the plan that was tried and of the next within which it is the last:
variances do not fall by one power all the way."""

SMALLEST_TIME_SHARE = 0.02
"""Part of a bake's time that is not worth another pass."""

CHUNK = 1 << 22
"""Lumels that are summed up in one go."""

MOST_PILOTED = 20_000_000
"""Lumels up to which a pilot fits the memory."""

MAIN_PASSES, TRIALS = 1_000, 100_000
"""First numbers of passes and trials: no two may use the same points."""


@dataclass
class Ending:
    """Whether work is to end: a cancel counts at once, a stop as soon as there is a result with an error.

    Parameters
    ----------
    cancelled, stopped : callable
    has_result : bool
    """

    cancelled: Callable[[], bool]
    stopped: Callable[[], bool] = lambda: False
    has_result: bool = False

    def __call__(self) -> bool:
        """Whether the present pass is given up."""
        return self.cancelled() or self.is_stopped

    @property
    def is_stopped(self) -> bool:
        """Whether what there is is wanted."""
        return self.has_result and self.stopped()


@dataclass
class LayerState:
    """All that a layer needs to go on.

    Parameters
    ----------
    sums : ReplicateSums
    levels : Levels    Of the passes to come.
    passes : int    Made so far.
    cells : dict of str to array
    forecaster : Forecaster
    bias_sums : (5, m) array
        By object, of what the cells add: number, sum, sum of squares, number of passes with some, and the sum over these
        of the square of their sum over their number. [-, lx, lx2, -, lx2]
    object_passes : (passes, 1 + m) array    Samples of every pass, and the mean that it gave each object. [-, lx]
    is_done : bool
    pilot : dict of str to array    State of the pilot until passes have shown what it could only guess; empty then.
    """

    sums: ReplicateSums
    levels: Levels
    passes: int
    cells: dict[str, np.ndarray]
    forecaster: Forecaster
    bias_sums: np.ndarray
    object_passes: np.ndarray
    is_done: bool = False
    pilot: dict[str, np.ndarray] = field(default_factory=dict)

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything as arrays."""
        made = {f"sums.{name}": value for name, value in self.sums.state().items()}
        made |= {f"forecast.{name}": value for name, value in self.forecaster.state().items()}
        made |= {f"cells.{name}": value for name, value in self.cells.items()}
        made |= {f"pilot.{name}": value for name, value in self.pilot.items()}
        made |= {"levels": self.levels.columns}
        made |= {"bias": self.bias_sums, "objects": self.object_passes}
        return made | {"state": np.array([self.passes, int(self.is_done)], dtype=np.int64)}

    @classmethod
    def from_arrays(cls, rule: StopRule, arrays: dict[str, np.ndarray]) -> "LayerState":
        """Read what `arrays` wrote."""

        def part(name: str) -> dict[str, np.ndarray]:
            head = f"{name}."
            return {key[len(head) :]: v for key, v in arrays.items() if key.startswith(head)}

        passes, is_done = arrays["state"].tolist()
        return cls(
            ReplicateSums.from_state(part("sums")),
            Levels(arrays["levels"]),
            passes,
            part("cells"),
            Forecaster.from_state(rule, part("forecast")),
            arrays["bias"],
            arrays["objects"],
            bool(is_done),
            part("pilot"),
        )

    def review(self) -> None:
        """Find anew whether the rule is met, which may be another one than before."""
        marks = self.forecaster.history.marks
        # Where there is no light, an error tells nothing.
        is_dark = self.is_done and not (marks and marks[-1].error < math.inf)
        self.is_done = self.sums.passes >= FEWEST_PASSES and (
            is_dark or self.forecaster.is_done() or self.is_out_of_time()
        )

    def is_out_of_time(self) -> bool:
        """Whether the time that is left is not worth another pass."""
        limit = self.forecaster.rule.seconds
        if limit is None:
            return False
        return limit - self.forecaster.history.marks[-1].seconds < SMALLEST_TIME_SHARE * limit


@dataclass
class Layer:
    """Runs a job.

    Parameters
    ----------
    job : LuxJob
    rule : StopRule
    objects : (n,) int array    Number of the object of every lumel, for the checks of the cells.
    report : callable    Gets a `Progress`.
    save : callable    Gets a `LayerState` after passes, and decides itself whether to write it.
    object_count : int
    ending : Ending    That the job asks too.
    start : float    When the work began, by `time.perf_counter`. [s]
    """

    job: LuxJob
    rule: StopRule
    objects: np.ndarray
    report: object
    save: object
    object_count: int
    ending: Ending
    start: float = field(default_factory=time.perf_counter)

    def __post_init__(self):
        # What the last check of the cells took. [s]
        self._checking = 0.0

    def run(self, state: LayerState | None = None) -> LayerState:
        """Run to the end, from a state if there is one."""
        if state is None:
            self.job.prepare(self.rule.samples)
            state = self._begin()
        else:
            self.job.restore(state.cells)
            self._lengthen(state)
        while not state.is_done:
            self.ending.has_result = state.sums.passes >= FEWEST_PASSES
            if self.ending.is_stopped:
                break
            try:
                self._pass(state)
            except Cancelled:
                if self.ending.cancelled() or not self.ending.is_stopped:
                    raise
                # The state is that before the pass that was given up.
                break
            self.save(state)
        return state

    # ---- private ----

    @property
    def _seconds(self) -> float:
        return time.perf_counter() - self.start

    def _lengthen(self, state: LayerState) -> None:
        """Have longer passes where a rule that is stricter than the planned one would take very many."""
        needed = state.forecaster.passes_needed() or 0.0
        # With what is known of the pilot they are planned anyway.
        if needed <= MOST_PASSES * PASSES or state.pilot:
            return
        state.levels = state.levels.lowered(-int(math.log2(needed / PASSES)))
        each = state.levels.total() / max(self.job.count, 1)
        samples = state.forecaster.history.marks[-1].samples
        state.forecaster.respread(1.0, samples, each, each)

    def _begin(self) -> LayerState:
        job, rule = self.job, self.rule
        setup = self._seconds
        forecaster = Forecaster(rule, setup, planned=PASSES)
        bias = np.zeros((5, self.object_count))
        objects = np.zeros((0, 1 + self.object_count))
        self.report(Progress(0.0, 0, math.inf, self._seconds, None, "first samples"))
        is_short = rule.samples is not None and rule.samples <= SHORT
        if is_short or (not job.options.adaptive and job.count > MOST_PILOTED):
            # Passes of a power of two, at least two of them. Few, where each has to make the places of lumels anew.
            passes = PASSES if job.table.is_kept else FEWEST_PASSES
            each = (rule.samples or SHORT * passes) / passes
            levels = Levels.even(job.count, 1 << max(int(math.log2(max(each, 1.0))), 0), job.kinds)
            sums = ReplicateSums(job.count, job.channels, is_even=True)
            return LayerState(sums, levels, 0, job.state(), forecaster, bias, objects)
        sums = ReplicateSums(job.count, job.channels)
        pilot = Pilot(job)
        pilot.run(sums)
        error = self._note(forecaster, sums, 2, is_pilot=True)
        allowed = self._allowed(sums)
        levels, seconds = self._plan(pilot, None if allowed is None else allowed**2)
        square = pilot.square(levels)
        levels, steps = self._hurried(levels, seconds * PASSES, self._seconds)
        if square > 0.0 and 0.0 < error < math.inf:
            each = levels.total() / max(job.count, 1)
            share = max(square * 2.0**steps / error**2, 1e-9)
            forecaster.respread(1.0, share, 1.0, each, seconds / 2.0**steps, self._seconds)
        # So few samples tell little, and not as much for their number as those of a pass.
        sums = ReplicateSums(job.count, job.channels)
        state = LayerState(sums, levels, 0, job.state(), forecaster, bias, objects)
        if allowed is not None:
            state.pilot = pilot.state()
        self._show(state)
        return state

    def _allowed(self, sums: ReplicateSums) -> float | None:
        """Standard error at which the rule is met; None: it names none. [lx]"""
        errors = [self.rule.absolute or 0.0]
        if self.rule.error is not None:
            area = np.where(self.job.valid, self.job.area, 0.0)
            errors.append(self.rule.error * _mean(sums.mean(), area))
        return max(errors) if max(errors) > 0.0 else None

    def _plan(self, pilot: Pilot, square: float | None) -> tuple[Levels, float]:
        """Samples of the first passes, by trials, and what one of them takes. ``square``: that is allowed. [lx2, s]"""
        job = self.job

        def plan() -> Levels:
            # So much of the last pass is spared that a small error of what is foretold changes nothing.
            wanted = None if square is None else (PASSES - SPARED) * square
            return self._planned(pilot, wanted, PASSES)

        pilot.choose_ways(plan(), PASSES)
        levels = plan()
        for number in range(MOST_TRIALS):
            tried = levels.total()
            trial = pilot.try_pass(TRIALS + 2 * number, levels, TRIED)
            if number == 0:
                pilot.choose_trace_share(plan())
            levels = plan()
            if 1.0 / SETTLED < levels.total() / max(tried, 1e-9) < SETTLED:
                break
        begin = time.perf_counter()
        job.sweep(TRIALS, levels)
        seconds = time.perf_counter() - begin
        seconds += trial.seconds * levels.total() / max(trial.samples, 1e-9)
        seconds += trial.trace_seconds * job.paths(levels) / max(trial.paths, 1)
        begin = time.perf_counter()
        # Its kernel is made here, so that no pass takes longer for it.
        job.compare(TRIALS, levels)
        seconds += (time.perf_counter() - begin) / CHECK_INTERVAL
        return levels, seconds

    def _planned(self, pilot: Pilot, square: float | None, passes: int, samples=0.0) -> Levels:
        """Samples of each of so many passes with such a square of its error, beyond ``samples`` that there are. [lx2]"""
        each = max((self.rule.samples or SHORT * PASSES) - samples, 1.0) / passes
        if square is None:
            return pilot.plan(samples=each)
        levels = pilot.plan(square=square)
        if self.rule.samples is not None:
            levels = min(levels, pilot.plan(samples=each), key=Levels.total)
        return levels

    def _hurried(self, levels: Levels, seconds: float, spent: float) -> tuple[Levels, int]:
        """Samples halved so often that all passes take no more than the time that is left, and how often. [s]"""
        limit = self.rule.seconds
        if limit is None:
            return levels, 0
        left = max(limit - spent, 0.1 * limit)
        steps = math.ceil(math.log2(max(seconds / left, 1.0)))
        return levels.lowered(steps), steps

    def _settle(self, state: LayerState, error: float) -> None:
        """Plan the passes to come by what the first ones have shown. ``error``: of everything. [lx]

        All get more or less alike, as numbers of samples must not depend on the values that they weigh.
        """
        job, forecaster, first = self.job, state.forecaster, state.levels
        pilot, state.pilot = Pilot.from_state(job, state.pilot), {}
        samples = max(first.total(), 1e-9)
        if not np.allclose(state.object_passes[:, 0] * job.count, samples):
            # Somebody could not wait for passes as they were planned, which so are not known better.
            return
        allowed = self._allowed(state.sums)
        if allowed is None:
            self._lengthen(state)
        if allowed is None or not allowed < error < math.inf:
            return
        pilot.correct(first, FEWEST_PASSES * error**2)
        missing = allowed**-2 - error**-2
        passes = PASSES - FEWEST_PASSES
        last = forecaster.history.marks[-1]
        levels = self._planned(pilot, (passes - SPARED) / missing, passes, last.samples)
        seconds = forecaster.pass_seconds * levels.total() / samples
        levels, _ = self._hurried(levels, seconds * passes, last.seconds)
        state.levels = max(levels, first.lowered(SHORTEST), key=Levels.total)
        square = pilot.square(state.levels)
        seconds = forecaster.pass_seconds * state.levels.total() / samples
        passes = int(np.clip(math.ceil(missing * square), 1, passes))
        more = state.levels.total() / max(job.count, 1)
        share = max(square / error**2, 1e-9)
        forecaster.respread(1.0, share, 1.0, more, seconds, self._seconds, planned=passes)

    def _pass(self, state: LayerState) -> None:
        job, forecaster = self.job, state.forecaster
        levels = state.levels.lowered(self._steps_down(state))
        self._show(state)

        def show(share: float) -> None:
            done = forecaster.progress(self._seconds, "illuminance")
            self.report(replace(done, history=forecaster.history))

        number = MAIN_PASSES + state.passes
        job.refresh(number, levels)
        made = job.run_pass(number, levels, show)
        begin = self._seconds
        checked = job.compare(number, levels)
        extra = self._extra(self._seconds - begin, number)
        # Nothing of the state changes before the pass is whole: a cancel leaves what a checkpoint can go on from.
        for part, values in made:
            state.sums.add(part.start, values, levels.samples(part))
        state.sums.end_pass()
        means = job.object_means(made, self.objects, self.object_count)
        row = np.append(levels.total() / max(job.count, 1), means)
        state.object_passes = np.vstack([state.object_passes, row])
        self._note_checks(state, *checked)
        state.passes += 1
        state.cells = job.state()
        error = self._note(forecaster, state.sums, 1, extra=extra)
        state.is_done = forecaster.is_done() or state.is_out_of_time()
        # Where nothing scatters, no light at all for one, more passes tell no more; and one pass tells no error.
        state.is_done |= error == 0.0
        state.is_done &= state.sums.passes >= FEWEST_PASSES
        if state.pilot and state.sums.passes >= FEWEST_PASSES:
            self._settle(state, error)
        self._show(state)

    def _extra(self, seconds: float, number: int) -> float:
        """Time that a check of the cells, which is not made in every pass, took beyond its share of this one. [s]"""
        if number % CHECK_INTERVAL == 0:
            self._checking = seconds
            return seconds * (1.0 - 1.0 / CHECK_INTERVAL)
        return -self._checking / CHECK_INTERVAL

    def _steps_down(self, state: LayerState) -> int:
        """How often the samples of the next pass are halved, so that the last one does not go far beyond the rule."""
        if self.ending.stopped() or state.forecaster.is_done():
            # There is no result yet, and somebody waits for one, or the time is over.
            return HURRY
        needed = state.forecaster.passes_needed()
        if state.pilot or needed is None or needed >= 1.0 or state.forecaster.is_last_planned():
            return 0
        return 1 if needed <= 0.5 else 0

    def _note_checks(self, state: LayerState, lumels: np.ndarray, found: np.ndarray) -> None:
        """Take note of what comparing the cells with full paths has found, object by object."""
        which = self.objects[lumels]
        count, total, square = (
            np.bincount(which, values, self.object_count)
            for values in (np.ones(len(found)), found, found**2)
        )
        state.bias_sums += [count, total, square, count > 0, total**2 / np.maximum(count, 1.0)]

    def _note(
        self,
        forecaster: Forecaster,
        sums: ReplicateSums,
        passes: int,
        is_pilot: bool = False,
        extra: float = 0.0,
    ) -> float:
        """Tell the forecaster how far things are; returns the error of everything. [lx]"""
        job = self.job
        area = light = square = samples = 0.0
        for first in range(0, job.count, CHUNK):
            part = slice(first, min(first + CHUNK, job.count))
            own = np.where(job.valid[part], job.area[part], 0.0)
            known = own > 0.0
            area += float(own.sum())
            light += float((sums.mean(part) * own).sum())
            square += float((sums.variance(part)[known] * own[known]).sum())
            samples += float(sums.samples(part).sum())
        whole = math.sqrt(square / area) if area > 0.0 else 0.0
        forecaster.note(
            self._seconds,
            # What the pilot found is not kept.
            0.0 if is_pilot else samples / max(job.count, 1),
            whole * area / light if light > 0.0 else math.inf,
            absolute=whole,
            passes=passes,
            extra_seconds=extra,
        )
        return whole

    def _show(self, state: LayerState) -> None:
        made = state.forecaster.progress(self._seconds, "illuminance")
        self.report(replace(made, history=state.forecaster.history))


def _mean(values: np.ndarray, area: np.ndarray) -> float:
    total = float(area.sum())
    return float((values * area).sum()) / total if total > 0.0 else 0.0
