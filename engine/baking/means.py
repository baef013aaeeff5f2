"""Means of objects over their maps, with their errors and what the cells add to them."""

from dataclasses import dataclass

import numpy as np

from ..accuracy.tails import tail_factor
from ..atlas.lumels import LumelTable
from .estimates import Estimates
from .layer_state import LayerState

LEAST_FREEDOM = 0.5
"""Of what passes tell beyond the degrees of freedom at which the variance of Student's distribution ends."""


@dataclass(frozen=True)
class ObjectMean:
    """What gathering found on the maps of one layout.

    Parameters
    ----------
    number : int    Of the layout.
    count : int    Lumels in all.
    area : float    Of all of them. [m2]
    rows : (n,) array    Lumels that light can reach.
    areas : (n,) array    Of these. [m2]
    reached : (n,) array    What of the area light can reach. [m2]
    mean, error : float    Mean illuminance by area and its standard error. [lx]
    reached_mean : float    The mean over what light can reach. [lx]
    bias, bias_error : float    What the cells add to the mean, and the standard error of that. [lx]
    """

    number: int
    count: int
    area: float
    rows: np.ndarray
    areas: np.ndarray
    reached: np.ndarray
    mean: float
    error: float
    reached_mean: float
    bias: float
    bias_error: float


def find_means(
    count: int, table: LumelTable, estimates: Estimates, states: list[LayerState]
) -> list[ObjectMean]:
    """Means of all layouts. ``count``: how many there are."""
    first = np.concatenate([[0], np.cumsum(table.counts)])
    blocks: list[list[np.ndarray]] = [[] for _ in range(count)]
    for block in range(len(table.counts)):
        blocks[table.layout(block)].append(np.arange(first[block], first[block + 1]))
    return [_find_mean(n, own, table.survey, estimates, states) for n, own in enumerate(blocks)]


def _find_mean(number: int, parts, survey, estimates, states) -> ObjectMean:
    every = np.concatenate([np.zeros(0, dtype=np.int64), *parts])
    rows = every[survey.valid[every]]
    area, reached = (each[rows].astype(np.float64) for each in (survey.area, survey.reached))
    light = estimates.illuminance[rows]
    shifts = [_bias(state.bias_sums, number) for state in states]
    return ObjectMean(
        number,
        len(every),
        float(survey.area[every].sum(dtype=np.float64)),
        rows,
        area,
        reached,
        float((light * area).sum() / max(area.sum(), 1e-300)),
        _mean_error(states, number, rows, area),
        float((light * reached).sum() / max(reached.sum(), 1e-300)),
        sum(value for value, _ in shifts),
        float(np.sqrt(sum(each**2 for _, each in shifts))),
    )


def _mean_error(states: list[LayerState], number: int, rows: np.ndarray, area: np.ndarray) -> float:
    """Standard error of an object's mean. [lx]

    The scatter of the passes' means has two parts. That of the lumels themselves is known from their own variances, which
    are many. The rest comes from the cells, which all lumels share. Only the few passes tell it, so it counts as much more
    as the variance of Student's distribution is more than one.
    """
    total = max(float(area.sum()), 1e-150)
    square = 0.0
    for state in states:
        weights, means = state.object_passes[:, 0], state.object_passes[:, 1 + number]
        rest = weights.sum() ** 2 - (weights**2).sum()
        if rest <= 0.0:
            return float("inf")
        centre = (weights * means).sum() / weights.sum()
        whole = float((weights**2 * (means - centre) ** 2).sum() / rest)
        variance = state.sums.variance(rows)
        parts = np.where(np.isfinite(variance), variance, 0.0) * area**2
        own = float(parts.sum()) / total**2
        own *= float(tail_factor(parts.sum(), parts.max(initial=0.0), len(parts))) ** 2
        # Passes of uneven weights are worth fewer of even ones.
        passes = weights.sum() ** 2 / (weights**2).sum()
        surplus = 1.0 + 2.0 / max(passes - 3.0, LEAST_FREEDOM)
        square += own + max(whole - own, 0.0) * surplus
    return float(np.sqrt(square))


def _bias(sums: np.ndarray, number: int) -> tuple[float, float]:
    """Mean of an object's differences and its standard error; not known where others were compared and it was not.

    All of a pass read the same cells, so what these err by shows in the scatter between passes alone.
    """
    count, total, square, passes, of_passes = (float(each) for each in sums[:, number])
    if count < 2:
        return 0.0, float("inf") if sums[0].any() else 0.0
    mean = total / count
    variance = max(square / count - mean**2, 0.0) / (count - 1)
    if passes > 1:
        between = max(of_passes - total**2 / count, 0.0) / (passes - 1)
        variance = max(variance, between / count)
    return mean, float(np.sqrt(variance))
