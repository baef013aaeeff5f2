"""How many samples a picture will need, as passes before have shown how errors fall.

Doubling the samples of a tile halves the square of its error only where samples are independent and all their scatter is
known. Where pixels share light they do so less the less noise there is, and bright samples that few have met yet come. What
both come to is told by the passes so far: each kind of samples has a power of its own by which its squares fall.
"""

from dataclasses import dataclass

import numpy as np

from .allocation import Allocation
from .pixel_light import VIEW

EASE, EASE_APART, EASE_SUPPORT = 0.1, 0.2, 40.0
"""By how much less steeply squares of errors are supposed to fall than as one over the samples of a tile, as a power: those
of light in view, and of the light of matt surfaces, which pixels share most; and how much that counts beside what passes
tell, as a sum of squares of doublings. [-]"""

LEAST_EASE, MOST_EASE = -0.3, 0.8
"""Within which it is believed."""

POWER, POWER_SUPPORT, STEEPEST = -0.05, 4.0, 0.2
"""Power of the samples by which the square of the error falls beside that of independent ones, as low-discrepancy points do
better the more there are, and what sharing smooths away falls too: what is supposed, how much it counts, as a sum of squares
of logarithms of ratios of samples, and the most that is believed, either way."""

SPAN = 4.0
"""Ratio of samples to those of the first pass that tells how errors of tiles fall: what was long ago says little. [-]"""

STEPS = 4
"""Times that the part of the errors at the end is found anew from the samples there."""

TOWARDS_OTHERS = 0.15
"""Where between what errors relative to a pixel's own light tell and relative to that of the other half is the least that is
needed, as a share of the logarithm. [-]"""


@dataclass(frozen=True, eq=False)
class _Pass:
    """State after a pass.

    Parameters
    ----------
    samples : float    Of a pixel, on the mean.
    counts : (k, t) array    Samples of tiles in a half, by kind.
    errors : (k, t) array    Sums of the squares of errors of their pixels, relative.
    part : float    Square of the stated error over the mean of these. [-]
    """

    samples: float
    counts: np.ndarray
    errors: np.ndarray
    part: float


class Foresight:
    """Foretells the samples at which the error of a picture will be the wanted one.

    Parameters
    ----------
    allocation : Allocation    Whose samples are followed.
    groups : int    Halves.
    goal : float    Wanted relative error. [-]
    """

    def __init__(self, allocation: Allocation, groups: int, goal: float):
        self._allocation, self._groups, self._goal = allocation, groups, goal
        self._passes: list[_Pass] = []

    def note(self, errors: dict[int, np.ndarray], error: float) -> None:
        """Take note of a pass.

        Parameters
        ----------
        errors : dict    Squares of the errors of pixels as single samples scatter, relative to their light: (n,), by kind.
        error : float    Of the picture, as it is stated. [-]
        """
        made = self._allocation
        counts = np.stack([made.counts[kind] for kind in made.costs])
        tiles = np.stack(
            [np.bincount(made.tile, errors[kind], len(made.size)) for kind in made.costs]
        )
        mean = float(tiles.sum()) / len(made.tile)
        if mean > 0.0 and 0.0 < error < np.inf:
            samples = self._groups * made.samples
            self._passes.append(_Pass(samples, counts, tiles, error**2 / mean))

    def span(
        self,
        squares: dict[int, np.ndarray],
        own: dict[int, np.ndarray],
        others: dict[int, np.ndarray],
    ) -> tuple[float, float] | None:
        """Least and most samples per pixel at which the error will be the wanted one; None while no pass tells.

        A pixel that a bright sample has met by chance is bright itself, and its error relative to it is small. So the error
        of few samples is too small, and falls more slowly than it will. Relative to what the other half shows the scatter of
        a half is not, but where such samples are rare this goes on to the end, and the error stays small.

        Parameters
        ----------
        squares : dict    As of `Allocation.choose`: they tell who gets samples.
        own, others : dict    As of `note`, relative to a pixel's own light and to that of the other half.
        """
        if not self._passes:
            return None
        powers = self.powers()
        low, high = sorted(self._end_of(squares, errors, powers) for errors in (own, others))
        return low ** (1.0 - TOWARDS_OTHERS) * high**TOWARDS_OTHERS, high

    def powers(self) -> dict[int, float]:
        """Powers of the samples of tiles by which squares of errors fall, by kind.

        What they would have come to since a pass before if they fell as one over the samples is compared with what they are.
        """
        now = self._passes[-1]
        supposed = [EASE if kind == VIEW else EASE_APART for kind in self._allocation.costs]
        products = np.array(supposed) * EASE_SUPPORT
        support = np.full(len(now.counts), float(EASE_SUPPORT))
        for each in self._passes[:-1]:
            if SPAN * each.samples < now.samples:
                continue
            doublings = np.log2(now.counts / each.counts)
            expected = each.errors / 2.0**doublings
            whole, found = expected.sum(axis=1), now.errors.sum(axis=1)
            known = (whole > 0.0) & (found > 0.0)
            along = (expected * doublings).sum(axis=1)[known] / whole[known]
            products[known] += along * np.log2(found[known] / whole[known])
            support[known] += along**2
        eases = np.clip(products / support, LEAST_EASE, MOST_EASE)
        return dict(zip(self._allocation.costs, (1.0 - eases).tolist(), strict=True))

    def _end_of(self, squares, errors, powers: dict[int, float]) -> float:
        """Samples per pixel at which the part of the errors that is stated is the wanted one."""
        now = self._passes[-1].samples
        part, power = self._part()
        end = now
        for _ in range(STEPS):
            goal = self._goal**2 / (part * (end / now) ** power)
            end = self._groups * self._allocation.foresee(squares, errors, goal, powers)
        return end

    def _part(self) -> tuple[float, float]:
        """Square of the stated error over those by which samples scatter, now, and the power of samples by which it changes.

        By all passes: where few pixels make most of the error, the difference of the halves is much by chance.
        """
        samples = np.array([each.samples for each in self._passes])
        parts = np.log([each.part for each in self._passes])
        along = np.log(samples / samples[-1])
        apart = along - along.mean()
        power = (POWER_SUPPORT * POWER + apart @ parts) / (POWER_SUPPORT + apart @ apart)
        power = float(np.clip(power, -STEEPEST, STEEPEST))
        return float(np.exp(parts - power * along).mean()), power
