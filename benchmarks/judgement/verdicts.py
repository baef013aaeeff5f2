"""Verdicts under simulated noise: how many are wrong, and whether the times that they foretell hold."""

import numpy as np

from ...engine.judgement.figures import find_figures
from ...engine.judgement.verdict import LOOKS, State, judge, more_of, overall, tail

GROUPS, NOISE = 16, 0.02
"""Independent groups of samples of a sensor, and its relative standard error after the time 1. [-]"""

COUNTS = (1, 9, 49)
"""Sensors of areas."""

OFFSETS = (-0.03, -0.01, -0.003, 0.0, 0.003, 0.01, 0.03)
"""Of the true mean from its limit, relative. [-]"""

UNIFORMITIES = (0.57, 0.59, 0.605, 0.63)
"""True ones; 0.6 is asked for."""

RUNS, FORECASTS = 400, 6000
"""Of each area, and areas whose forecasts are followed."""

SHARES = np.geomspace(0.25, 4.0, 33)
"""Times at which it is looked again, relative to the forecast. [-]"""

LIMIT, UNIFORMITY = 500.0, 0.6
"""Mean [lx] and uniformity that are asked for. [-]"""


def measure(say) -> dict:
    """Simulate.

    Returns
    -------
    dict    ``wrong``, ``open``, ``runs``: of the kind of area with most wrong verdicts, and of all together;
        ``time_ratio``: time within which half of what was open is decided, over the forecast. [-]
    """
    draw = np.random.default_rng(30)
    kinds = []
    for count in COUNTS:
        for offset in OFFSETS:
            for uniformity in UNIFORMITIES if count > 1 else (1.0,):
                kinds.append(_judge_many(draw, count, offset, uniformity))
    say(f"judgement: verdicts of {len(kinds)} kinds of areas")
    ratio = _time_ratio(draw)
    say("judgement: times that verdicts foretell")
    return {
        "worst_wrong": max(kind["wrong"] / RUNS for kind in kinds),
        "wrong": sum(kind["wrong"] for kind in kinds),
        "open": sum(kind["open"] for kind in kinds),
        "runs": RUNS * len(kinds),
        "kinds": len(kinds),
        "looks": LOOKS,
        "time_ratio": ratio,
    }


def _judge_many(draw, count: int, offset: float, uniformity: float) -> dict:
    made = {"wrong": 0, "open": 0}
    for _ in range(RUNS):
        truth = np.full(count, 1.0)
        if count > 1:
            truth = draw.uniform(0.7, 1.3, count)
            truth[0] = uniformity * truth[1:].sum() / (count - uniformity)
        truth = truth / truth.mean() * LIMIT * (1.0 + offset)
        meets = bool(offset >= 0.0 and truth.min() / truth.mean() >= UNIFORMITY)
        area = _Area(draw, truth)
        for _ in range(LOOKS):
            verdicts = area.verdicts()
            state, more = overall(verdicts), more_of(verdicts)
            if state is not State.UNDECIDED or more is None:
                break
            area.go_on_until(area.time * (1.0 + more))
        made["open"] += state is State.UNDECIDED
        made["wrong"] += state is not State.UNDECIDED and (state is State.MET) != meets
    return made


def _time_ratio(draw) -> float:
    decided = []
    for number in range(FORECASTS):
        count = COUNTS[number % len(COUNTS)]
        gap = draw.uniform(-8.0, 8.0) * NOISE / np.sqrt(count)
        area = _Area(draw, np.full(count, LIMIT * (1.0 + gap)))
        first = area.verdicts()[0]
        if first.state is not State.UNDECIDED or first.more is None:
            continue
        row = []
        for share in SHARES:
            area.go_on_until(1.0 + share * first.more)
            row.append(area.verdicts()[0].state is not State.UNDECIDED)
        decided.append(row)
    alone = np.array(decided).mean(axis=0)
    return float(np.exp(np.interp(0.5, alone, np.log(SHARES))))


class _Area:
    """Readings of sensors whose noise falls with time."""

    def __init__(self, draw, truth):
        self._draw, self._truth, self._sums, self.time = draw, truth, 0.0, 0.0
        self.go_on_until(1.0)

    def go_on_until(self, time: float) -> None:
        step = time - self.time
        noise = self._draw.standard_normal((GROUPS, len(self._truth)))
        self._sums = self._sums + self._truth * (step + NOISE * np.sqrt(GROUPS * step) * noise)
        self.time = time

    def verdicts(self) -> list:
        means = self._sums / self.time
        errors = means.std(axis=0, ddof=1) / np.sqrt(GROUPS)
        found = find_figures(means.mean(axis=0), errors, tail(2), GROUPS - 1.0)
        return [judge("mean", LIMIT, found.mean, 2), judge("Uo", UNIFORMITY, found.uniformity, 2)]
