"""How many samples the passes of a layer get, by what a pilot and its trials have found."""

import math
import time
from dataclasses import dataclass

import numpy as np

from ..accuracy.replicates import ReplicateSums
from ..accuracy.stopping import StopRule
from ..transport.lux_maps.job import CHECK_INTERVAL, LuxJob
from ..transport.lux_maps.levels import Levels
from ..transport.lux_maps.pilot import Pilot

PASSES = 8
"""Passes in which a bake is planned to reach its rule: enough for an error of every lumel, few enough for
low-discrepancy points to pay within each."""

SPARED = 0.4
"""Part of a pass that the plan can do without: the error of what is foretold for all of them is about 4 %, so the rule is
met after the last one nine times in ten, and the bake ends when it was said to."""


SHORT = 32
"""Up to so many samples there is no pilot: it would cost more than it saves."""

TRIED = 1.0 / 16.0
"""Share of the lumels on which a planned pass is tried, which finds how variances fall."""

MOST_TRIALS, SETTLED = 2, 1.5
"""Most such trials, and ratio between the samples of the plan that was tried and of the next within which it is the last:
variances do not fall by one power all the way."""

TRIALS = 100_000
"""First number of trials: no two, nor a pass, may use the same points."""


@dataclass
class Planner:
    """Plans passes of a job for a rule.

    Parameters
    ----------
    job : LuxJob
    rule : StopRule
    """

    job: LuxJob
    rule: StopRule

    def allowed(self, sums: ReplicateSums) -> float | None:
        """Standard error at which the rule is met; None: it names none. [lx]"""
        errors = [self.rule.absolute or 0.0]
        if self.rule.error is not None:
            area = np.where(self.job.valid, self.job.area, 0.0)
            errors.append(self.rule.error * _mean(sums.mean(), area))
        return max(errors) if max(errors) > 0.0 else None

    def plan_first(self, pilot: Pilot, square: float | None) -> tuple[Levels, float]:
        """Samples of the first passes, by trials, and what one of them takes. ``square``: that is allowed. [lx2, s]"""
        job = self.job

        def plan() -> Levels:
            # So much of the last pass is spared that a small error of what is foretold changes nothing.
            wanted = None if square is None else (PASSES - SPARED) * square
            return self.plan(pilot, wanted, PASSES)

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

    def plan(self, pilot: Pilot, square: float | None, passes: int, samples=0.0) -> Levels:
        """Samples of each of so many passes with such a square of its error, beyond ``samples`` that there are. [lx2]"""
        each = max((self.rule.samples or SHORT * PASSES) - samples, 1.0) / passes
        if square is None:
            return pilot.plan(samples=each)
        levels = pilot.plan(square=square)
        if self.rule.samples is not None:
            levels = min(levels, pilot.plan(samples=each), key=Levels.total)
        return levels

    def hurry(self, levels: Levels, seconds: float, spent: float) -> tuple[Levels, int]:
        """Samples halved so often that all passes take no more than the time that is left, and how often. [s]"""
        limit = self.rule.seconds
        if limit is None:
            return levels, 0
        left = max(limit - spent, 0.1 * limit)
        steps = math.ceil(math.log2(max(seconds / left, 1.0)))
        return levels.lowered(steps), steps


def _mean(values: np.ndarray, area: np.ndarray) -> float:
    total = float(area.sum())
    return float((values * area).sum()) / total if total > 0.0 else 0.0
