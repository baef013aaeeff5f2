"""Values of all lumels with their errors: the sum of the layers, errors pooled with those of the tiles around."""

from dataclasses import dataclass

import numpy as np

from ..accuracy.tails import tail_factor
from ..atlas.lumels import LumelTable
from ..transport.lux_maps.tiles import tile_numbers
from .layer import CHUNK
from .layer_state import LayerState
from .order import BakeOrder


@dataclass(frozen=True)
class Estimates:
    """Values of all lumels of a table, in its order.

    Parameters
    ----------
    illuminance, standard_error : (n,) array    [lx]
    layers : dict of str to (n,) array    [lx]
    exitance : (n, 3) array or None    X, Y, Z. [lm/m2]
    replicates : int
    freedom : float    Of the errors. [-]
    surplus : (k,) array
        By layout, what the squares of the errors of its lumels, times their areas, are above those that the passes show:
        single ones are stated with care, of which means of many need none. [lx2 m2]
    """

    illuminance: np.ndarray
    standard_error: np.ndarray
    layers: dict[str, np.ndarray]
    exitance: np.ndarray | None
    replicates: int
    freedom: float
    surplus: np.ndarray


TILE_FREEDOM = 12.0
"""Degrees of freedom that the mean variance of a tile counts for in that of a lumel."""

OUTLYING = 1.645
"""Standard deviations beyond which a lumel's variance is its own: chance lifts one of twenty so far."""


def estimate_lumels(
    layers: list[tuple[str, LayerState]], order: BakeOrder, table: LumelTable, layouts: int
) -> Estimates:
    """Sum of all layers; their errors are independent. ``layouts``: how many there are."""
    count = sum(table.counts)
    light, error = np.zeros((2, count), dtype=np.float32)
    surplus = np.zeros(layouts)
    replicates = min(state.sums.passes for _, state in layers)
    first = 0
    for number, many in enumerate(table.counts):
        part = slice(first, first + many)
        first += many
        light[part] = sum(state.sums.mean(part) for _, state in layers)
        facts = table.facts(number)
        tiles = tile_numbers(facts, table.width(number))
        plain = np.zeros(many)
        for _, state in layers:
            own = state.sums.variance(part)
            plain += np.where(facts.valid & np.isfinite(own), own, 0.0)
        variance = sum(pool_variance(state.sums, part, tiles, facts.valid) for _, state in layers)
        error[part] = np.sqrt(variance)
        area = np.where(facts.valid, facts.area, 0.0).astype(np.float64)
        surplus[table.layout(number)] += float(area @ (variance - plain))
    named = {name: state.sums.mean().astype(np.float32) for name, state in layers if name}
    exitance = None
    if order.exitance:
        exitance = sum(state.sums.further_means() for _, state in layers)
    freedom = max(min(state.sums.degrees_of_freedom for _, state in layers), 1.0) + TILE_FREEDOM
    return Estimates(light, error, named, exitance, replicates, freedom, surplus)


def pool_variance(sums, part: slice, tiles: np.ndarray, valid: np.ndarray) -> np.ndarray:
    """Variance of some lumels' means, from their own passes and those of their tiles. (n,) [lx2]

    Where rare bright paths make the error, the passes of most lumels have seen none of them, and would state too little
    by themselves. So the mean over the tile counts as so many degrees of freedom. Where the own passes scatter more than
    those of such a tile do by chance, as at the edge of a shadow, they count alone. To the mean k such lumels of a tile
    are sqrt(k): a single one may be the rare path that the others wait for, many are more likely of another kind.
    """
    variance = sums.variance(part)
    is_known = valid & np.isfinite(variance)
    passes = sums.replicates(part)[is_known]
    freedom = max(float(passes.mean()) - 1.0, 1.0) if len(passes) else 1.0
    own = np.where(is_known, variance, 0.0)
    known = np.maximum(np.bincount(tiles, valid.astype(np.float64)), 1.0)
    # Wilson and Hilferty's quantile of chi-square over its degrees of freedom.
    spread = 2.0 / (9.0 * freedom)
    largest = (1.0 - spread + OUTLYING * np.sqrt(spread)) ** 3
    outlies = own > largest * (np.bincount(tiles, own) / known)[tiles]
    alike = np.bincount(tiles, own * ~outlies)
    alike += np.bincount(tiles, own * outlies) / np.sqrt(
        np.maximum(np.bincount(tiles, outlies), 1.0)
    )
    pooled = (freedom * own + TILE_FREEDOM * (alike / known)[tiles]) / (freedom + TILE_FREEDOM)
    return np.where(outlies, own, pooled)


def find_whole(estimates: Estimates, table: LumelTable) -> tuple[float, float, float]:
    """Mean, root mean square and standard error of everything, by area. [lx]"""
    known = table.survey
    sums, largest = np.zeros(4), 0.0
    for first in range(0, len(known.area), CHUNK):
        part = slice(first, first + CHUNK)
        area = np.where(known.valid[part], known.area[part], 0.0).astype(np.float64)
        light, error = estimates.illuminance[part], estimates.standard_error[part]
        # An error that is not known must not make nothing of nothing.
        parts = np.where(area > 0.0, error, 0.0) ** 2 * area
        sums += [area.sum(), (light * area).sum(), (light**2 * area).sum(), parts.sum()]
        largest = max(largest, float(parts.max(initial=0.0)))
    mean, square, variance = sums[1:] / max(sums[0], 1e-300)
    variance = max(variance - float(estimates.surplus.sum()) / max(sums[0], 1e-300), 0.0)
    variance *= float(tail_factor(sums[3], largest, len(known.area))) ** 2
    return float(mean), float(np.sqrt(square)), float(np.sqrt(variance))
