"""Illuminance at sensors by kinds of samples, with the light of matt surfaces read from cells.

Every kind gets samples where another one lowers the error most for its cost. Groups have points and cells of their own, so
how they differ is the error.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...accuracy.estimate import Estimate
from ...accuracy.stopping import Clock, StopRule, excess_of
from ...errors import Cancelled
from ..paths.illuminance import LANES, Receivers, widened_by_loss
from ..pictures.view_cells import ViewCells
from .kind_sums import KindSums
from .sensor_light import COSTS, RESIDUAL, SensorLight

FIRST_SAMPLES, FIRST_LANES = 64, 1 << 15
"""Fewest samples of a kind and receiver in the first pass of a group, and about how many of all receivers: fewer take as
long."""

FEWEST_SAMPLES = 1 << 14
"""Samples of a receiver before its own error is believed, as with full paths."""

GROWTH = 8
"""Share of the samples so far that a pass adds at most, as its inverse, where samples fill launches."""

SWEEP_SHARE = 0.15
"""Paths of later sweeps over the cells, relative to the samples of the job. [-]"""

CHECK_SHARE, FEWEST_CHECKS, MOST_CHECKS = 0.06, 1 << 17, 1 << 22
"""Samples of all receivers that compare cells with full paths, relative to those that paths would take, and bounds: what is
known of the bias is then a fixed part of the error that is asked for."""

FEWEST_OF_ONE = 4
"""Fewest of these of a receiver in a group."""

CHANCE = 2.0
"""What of a measured change is taken for chance, in its standard errors."""

ALLOWED = 0.002
"""Error of every reading that stands for what the comparison cannot tell of it: what cells change from place to place in
rooms, root mean square. [-]"""


@dataclass(frozen=True)
class Bias:
    """What cells change at receivers, relative to the mean illuminance.

    Parameters
    ----------
    mean, error : float    Of all receivers, with its standard error. [-]
    beyond : float    Of a single receiver, root mean square, as far as it is no chance. [-]
    checks : int    Samples that tell.
    """

    mean: float
    error: float
    beyond: float
    checks: int

    @property
    def held(self) -> float:
        """What errors hold of it, relative to a receiver's illuminance: what is no chance, and what chance may hide. [-]"""
        return float(np.hypot(max(self.beyond, ALLOWED), self.error))

    def note(self) -> str:
        """For people."""
        words = (
            f"cells instead of full paths change the mean illuminance of the sensors by {100.0 * self.mean:+.2g} +- "
            f"{100.0 * self.error:.1g} % (measured by {self.checks} samples)"
        )
        return f"{words}; the stated errors hold {100.0 * self.held:.2g} % for it"


class CellJob:
    """A job by cells.

    Parameters
    ----------
    scene : CompiledScene    With its lights over bends, if there are any.
    receivers : Receivers
    rule : StopRule
    seed, groups : int    As of `illuminance.compute`.
    colour : bool    Whether X and Z are wanted too.
    cells : ViewCells    Prepared.
    known : KnownDirections or None    Where the receivers get light over bends from, if it was looked for.
    clock : Clock    Begun.
    progress, cancelled : callable    As of `illuminance.compute`.
    """

    def __init__(
        self,
        scene,
        receivers: Receivers,
        rule: StopRule,
        seed: int,
        groups: int,
        colour: bool,
        cells: ViewCells,
        known,
        clock: Clock,
        progress=None,
        cancelled=lambda: False,
    ):
        self.rule, self.groups, self.cells, self.clock = rule, groups, cells, clock
        self.progress, self.cancelled = progress, cancelled
        self.light = SensorLight(scene, receivers, seed, colour, cells, known)
        self._weights, self._count = receivers.weights, len(receivers.start)

    def run(self, samples: float, budget: float, most_held: float) -> tuple[Estimate | None, Bias]:
        """Make passes until the rule is met.

        Parameters
        ----------
        samples : float    Of all receivers, as they are forecast.
        budget, most_held : float
            What cells may be off by beyond chance, and what errors may hold for it; the job ends where it is more. [-]

        Returns
        -------
        (Estimate or None, Bias)    Of shape (n, channels), with errors that hold the bias [lx]; None: it is too large.

        Raises
        ------
        Cancelled
        """
        kinds, bright = self.light.kinds, self.light.meter.bright
        sums, bias, error = self._sums(kinds), None, float("inf")
        added = dict.fromkeys(kinds, self._within_rule(self._first()))
        while True:
            if self._sweeps_due(sums):
                self.cells.refresh()
            self._add(sums, added, error)
            made = sums.estimate()
            if bias is None:
                bias = self._find_bias(samples, made.mean[:, bright])
                if bias.beyond > budget or bias.held > most_held:
                    return None, bias
            held = bias.held * made.mean[:, bright]
            scattered, made = made.channel(bright), made.widened(held)
            done, brightness = round(sums.samples), made.channel(bright)
            error = brightness.relative_error(self._weights)
            judged = scattered if self._is_out_of_reach(scattered, held) else brightness
            excess = excess_of(self.rule, judged) if done >= FEWEST_SAMPLES else None
            if self.clock.is_done(done, judged.relative_error(self._weights), excess):
                return widened_by_loss(made, self._lost_shares(sums), self._lost(sums)), bias
            if self.progress is not None:
                self.progress(self.clock.progress(done, error))
            added = self._next(sums, brightness.mean)

    # ---- private ----

    def _is_out_of_reach(self, scattered: Estimate, held: np.ndarray) -> bool:
        """Whether what errors hold of the bias alone is more than is asked for, however many samples there are.

        A job that has to read cells then ends with what samples may have, and states more than was asked.
        """
        alone = replace(scattered, standard_error=held)
        whole, excess = self.rule.error, excess_of(self.rule, alone)
        is_whole_met = whole is not None and alone.relative_error(self._weights) < whole
        return not is_whole_met and (excess is None or excess >= 1.0)

    def _sums(self, kinds) -> KindSums:
        meter = self.light.meter
        costs = {kind: COSTS[kind] for kind in kinds}
        return KindSums(costs, self.groups, self._count, meter.count, meter.bright)

    def _first(self) -> int:
        """Samples of a receiver in the first pass of a group."""
        return 1 << int(np.log2(max(FIRST_SAMPLES, FIRST_LANES // self._count)))

    def _find_bias(self, samples: float, brightness: np.ndarray) -> Bias:
        """Compare reading cells with full paths at all receivers.

        ``samples``: forecast, of all of them; ``brightness``: about what receivers have. (n,) [lx]
        """
        wanted = np.clip(CHECK_SHARE * samples, FEWEST_CHECKS, MOST_CHECKS)
        each = max(wanted / (self._count * self.groups), FEWEST_OF_ONE)
        batch = 1 << int(np.log2(each))
        sums = self._sums((RESIDUAL,))
        self._add(sums, {RESIDUAL: batch})
        bright = self.light.meter.bright
        # What cells add is what they leave out, the other way round.
        found = -sums.means(RESIDUAL)[..., bright] / max(float(brightness.mean()), 1e-30)
        of_groups = found.mean(axis=1)
        mean, error = float(of_groups.mean()), _error_of_mean(of_groups)
        own = Estimate.from_groups(found, 0)
        # Single receivers may be off where all together are not.
        squares = own.mean**2 - own.standard_error**2
        chance = CHANCE * _error_of_mean(squares) if len(squares) > 1 else np.inf
        spread = max(float(squares.mean()) - chance, 0.0)
        beyond = max(abs(mean) - CHANCE * error, np.sqrt(spread), 0.0)
        return Bias(mean, error, float(beyond), batch * self._count * self.groups)

    def _within_rule(self, batch: int) -> int:
        """Samples of a receiver in a group, at most as many as the rule has."""
        if self.rule.samples is None:
            return batch
        most = max(self.rule.samples // self.groups, 1)
        return min(batch, 1 << int(np.log2(most)))

    def _next(self, sums: KindSums, brightness: np.ndarray) -> dict[int, int]:
        """Samples that the next pass adds, by kind: powers of two."""
        scale = np.maximum(brightness, max(float(brightness.mean()), 1e-30))
        chosen = sums.choose(scale)
        full = LANES // max(self._count, 1)
        added = {}
        for kind in chosen:
            most = max(sums.counts[kind] // GROWTH, full, 1)
            added[kind] = 1 << int(np.log2(min(sums.counts[kind], most)))
        if self.rule.samples is not None:
            left = self.rule.samples - sums.samples
            # What is missing in the end is no pass of its own: rather a few more.
            most = 2.0 * left - 1.0 if left < sums.samples / GROWTH else left
            while sums.samples_of(added) > most and max(added.values()) > 1:
                added = {kind: max(more // 2, 1) for kind, more in added.items()}
        return added

    def _sweeps_due(self, sums: KindSums) -> bool:
        cells = self.cells
        spent = self._count * self.groups * sum(sums.counts.values())
        return (cells.sweeps + 1) * cells.work <= SWEEP_SHARE * spent

    def _add(self, sums: KindSums, added: dict[int, int], error: float = float("inf")) -> None:
        """Make samples of all receivers."""
        before, more = sums.samples, sums.samples_of(added)
        for group in range(self.groups):
            self.cells.use(group)
            for kind, batch in added.items():
                self._add_kind(sums, kind, group, batch)
            if self.progress is not None and RESIDUAL not in added:
                done = before + more * (group + 1) / self.groups
                self.progress(self.clock.progress(round(done), error))
        sums.extend(added)

    def _add_kind(self, sums: KindSums, kind: int, group: int, batch: int) -> None:
        each = min(batch, LANES)
        per_launch = max(LANES // each, 1)
        for first in range(0, self._count, per_launch):
            count = min(per_launch, self._count - first)
            for done in range(0, batch, each):
                if self.cancelled():
                    raise Cancelled("cancelled")
                index = sums.counts[kind] + done
                made = self.light.sum(kind, group, first, count, each, index)
                sums.add(kind, group, slice(first, first + count), *made)

    def _lost_shares(self, sums: KindSums) -> np.ndarray:
        return np.maximum(sums.lost_shares(), self.cells.lost_share)

    def _lost(self, sums: KindSums) -> int:
        return int(sum(lost.sum() for lost in sums.lost.values()) + self.cells.counts[0])


def _error_of_mean(values: np.ndarray) -> float:
    """Standard error of the mean of independent values."""
    return float(values.std(ddof=1) / np.sqrt(len(values)))
