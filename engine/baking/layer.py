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
from ..transport.lux_maps.job import CHECK_INTERVAL, LuxJob
from ..transport.lux_maps.levels import Levels
from ..transport.lux_maps.pilot import Pilot
from .layer_state import FEWEST_PASSES, Ending, LayerState
from .planning import PASSES, SHORT, SPARED, Planner

SHORTEST = 1
"""How often the samples of the first passes are halved for the others at most. As samples are the weights of passes, much
shorter ones, of variances that fall faster than their samples do, would only add to the error; nor are they worth the
iterations of their cells."""

HURRY = 3
"""How often the samples of passes are halved that are made only to have an error when a bake is stopped early."""

MOST_PASSES = 4.0
"""Times the planned passes that a bake which goes on with another rule may take as they are."""

MAIN_PASSES = 1_000
"""First number of passes: no two may use the same points, nor the trials' of `planning`."""

CHUNK = 1 << 22
"""Lumels that are summed up in one go."""

MOST_PILOTED = 20_000_000
"""Lumels up to which a pilot fits the memory."""


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
    report: Callable[[Progress], None]
    save: Callable[[LayerState], None]
    object_count: int
    ending: Ending
    start: float = field(default_factory=time.perf_counter)

    def __post_init__(self):
        self._planner = Planner(self.job, self.rule)
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
        state.forecaster.replan(samples / each, each)

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
        allowed = self._planner.allowed(sums)
        levels, seconds = self._planner.plan_first(pilot, None if allowed is None else allowed**2)
        square = pilot.square(levels)
        levels, steps = self._planner.hurry(levels, seconds * PASSES, self._seconds)
        if square > 0.0 and 0.0 < error < math.inf:
            each = levels.total() / max(job.count, 1)
            share = max(square * 2.0**steps / error**2, 1e-9)
            forecaster.replan(share, each, seconds / 2.0**steps, self._seconds)
        # So few samples tell little, and not as much for their number as those of a pass.
        sums = ReplicateSums(job.count, job.channels)
        state = LayerState(sums, levels, 0, job.state(), forecaster, bias, objects)
        if allowed is not None:
            state.pilot = pilot.state()
        self._show(state)
        return state

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
        allowed = self._planner.allowed(state.sums)
        if allowed is None:
            self._lengthen(state)
        if allowed is None or not allowed < error < math.inf:
            return
        pilot.correct(first, FEWEST_PASSES * error**2)
        missing = allowed**-2 - error**-2
        passes = PASSES - FEWEST_PASSES
        last = forecaster.history.marks[-1]
        levels = self._planner.plan(pilot, (passes - SPARED) / missing, passes, last.samples)
        seconds = forecaster.pass_seconds * levels.total() / samples
        levels, _ = self._planner.hurry(levels, seconds * passes, last.seconds)
        state.levels = max(levels, first.lowered(SHORTEST), key=Levels.total)
        square = pilot.square(state.levels)
        seconds = forecaster.pass_seconds * state.levels.total() / samples
        passes = int(np.clip(math.ceil(missing * square), 1, passes))
        more = state.levels.total() / max(job.count, 1)
        share = max(square / error**2, 1e-9)
        forecaster.replan(share, more, seconds, self._seconds, planned=passes)

    def _pass(self, state: LayerState) -> None:
        job, forecaster = self.job, state.forecaster
        levels = state.levels.lowered(self._steps_down(state))
        self._show(state)
        number = MAIN_PASSES + state.passes
        job.refresh(number, levels)
        lots = job.run_pass(number, levels, lambda _: self._show(state))
        begin = self._seconds
        checked = job.compare(number, levels)
        extra = self._extra(self._seconds - begin, number)
        # Nothing of the state changes before the pass is whole: a cancel leaves what a checkpoint can go on from.
        for part, values in lots:
            state.sums.add(part.start, values, levels.samples(part))
        state.sums.end_pass()
        state.losses.add(job.losses(), levels)
        means = job.object_means(lots, self.objects, self.object_count)
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

    def _note_checks(self, state: LayerState, lumels: np.ndarray, differences: np.ndarray) -> None:
        """Take note of what comparing the cells with full paths has found, object by object."""
        which = self.objects[lumels]
        count, total, square = (
            np.bincount(which, values, self.object_count)
            for values in (np.ones(len(differences)), differences, differences**2)
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
        progress = state.forecaster.progress(self._seconds, "illuminance")
        self.report(replace(progress, history=state.forecaster.history))
