"""Means and standard errors of many values from independent replicates.

A replicate is an unbiased estimate of every value that owes nothing to the other replicates: it has random numbers of
its own. Its samples are its weight.
"""

import numpy as np

from ..errors import SceneError

LEAST_PART = 1e-4
"""Where a single replicate has all but such a part of the weight, nothing is known of the error. [-]"""

_ARRAYS = {
    "sums": (8, 4),
    "weights": (4,),
    "squares": (4,),
    "tilt": (4,),
    "deviation": (4,),
    "further": (4,),
}
"""Arrays of the state, and the bytes that their numbers may have."""


class ReplicateSums:
    """Weighted sums over passes, each of which gives every value one replicate.

    With the replicates x_k of the weights w_k, W their sum and m = sum w_k x_k / W, the variance of m is estimated as

        sum w_k^2 (x_k - m)^2 / (W^2 - sum w_k^2),

    which for equal weights is the usual sum (x_k - m)^2 / (R (R - 1)). It is unbiased where a replicate's variance falls as
    one over its weight, as with plain random numbers, and nearly so where it falls faster, as with low-discrepancy
    points: there a variance weighted by w_k alone would charge the small replicates of a pilot to all others.
    The sums go on from pass to pass (the update of Welford and West, for the squared weights), so that no large numbers are
    subtracted and four bytes suffice for deviations; 36 bytes per value and 4 for each further channel. Where all values
    have the same weight in every pass it is kept once, and sums of so few passes in four bytes: 16 bytes per value.

    Parameters
    ----------
    count : int    Number of values.
    channels : int    Quantities per value. The first has errors and halves; the others have means only.
    is_even : bool    Whether a pass gives all values the same weight. Means tell nothing in the middle of a pass then.
    """

    def __init__(self, count: int, channels: int = 1, is_even: bool = False):
        self.passes = 0
        # By half: even passes and odd passes. Counts of samples are exact in four bytes up to 2^24.
        self._sums = np.zeros((2, count), dtype=np.float32 if is_even else np.float64)
        weights = min(count, 1) if is_even else count
        self._weights = np.zeros((2, weights), dtype=np.float32)
        self._squares = np.zeros(weights, dtype=np.float32)
        # Weight of the pass that is going on, where all have the same.
        self._weight = np.float32(0.0)
        self._tilt = np.zeros(count, dtype=np.float32)
        self._deviation = np.zeros(count, dtype=np.float32)
        self._further = np.zeros((count, channels - 1), dtype=np.float32)

    @property
    def count(self) -> int:
        """Number of values."""
        return len(self._tilt)

    @property
    def is_even(self) -> bool:
        """Whether a pass gives all values the same weight."""
        return len(self._squares) < self.count

    def add(self, first: int, means: np.ndarray, weight) -> None:
        """Add the replicate of this pass for the values ``first`` to ``first + n``; once per pass for every value.

        Parameters
        ----------
        first : int
        means : (n,) or (n, channels) array    The replicate.
        weight : (n,) array or float    Number of its samples, at least 0; 0 where the pass left a value out.

        Raises
        ------
        SceneError    Weights differ where they were said to be the same.
        """
        means = np.asarray(means, dtype=np.float64)
        means = means.reshape(len(means), -1)
        part, half = slice(first, first + len(means)), self.passes % 2
        values = means[:, 0]
        # The same rounded weight everywhere, so that equal replicates have that very mean.
        weight = np.broadcast_to(np.asarray(weight, dtype=np.float32), values.shape)
        if self.is_even and len(weight):
            if (weight != weight[0]).any() or self._weight not in {0.0, weight[0]}:
                raise SceneError("a pass of equal weights was given different ones")
            self._weight = weight[0]
        held, before = self.samples(part), self.mean(part)
        old = self._of(self._squares, part).astype(np.float64)
        tilt = self._tilt[part].astype(np.float64)
        self._sums[half, part] += weight * values
        after = _ratio(self._total(part), held + weight)
        shift, square = after - before, weight.astype(np.float64) ** 2
        distance = values - after
        deviation = self._deviation[part] + shift * (shift * old - 2.0 * tilt)
        self._deviation[part] = np.maximum(deviation, 0.0) + square * distance**2
        self._tilt[part] = tilt - shift * old + square * distance
        if self._further.shape[1]:
            share = _ratio(weight, held + weight)[:, None]
            self._further[part] += share * (means[:, 1:] - self._further[part])
        if not self.is_even:
            self._weights[half, part] += weight
            self._squares[part] = old + square

    def end_pass(self) -> None:
        """Close a pass; the next one belongs to the other half."""
        self._weights[self.passes % 2] += self._weight
        self._squares += self._weight**2
        self._weight = np.float32(0.0)
        self.passes += 1

    @property
    def mean_samples(self) -> float:
        """Mean of the weights so far over all values; 0 without any."""
        return float(self._weights.mean(axis=1, dtype=np.float64).sum()) if self.count else 0.0

    def samples(self, part=slice(None)) -> np.ndarray:
        """Weight of each value so far. (count,)"""
        halves = (self._of(each, part) for each in self._weights)
        return np.add(*halves, dtype=np.float64)

    def mean(self, part=slice(None)) -> np.ndarray:
        """Mean over all passes; 0 where there are no samples. (count,), or those of ``part``."""
        return _ratio(self._total(part), self.samples(part))

    def even(self, part=slice(None)) -> np.ndarray:
        """Mean over the passes 0, 2, 4 and so on. (count,)"""
        return _ratio(self._sums[0, part], self._of(self._weights[0], part))

    def odd(self, part=slice(None)) -> np.ndarray:
        """Mean over the passes 1, 3, 5 and so on. (count,)"""
        return _ratio(self._sums[1, part], self._of(self._weights[1], part))

    def even_share(self, part=slice(None)) -> np.ndarray:
        """Share of each value's samples that the passes 0, 2, 4 and so on have; 0 without any. (count,) [-]"""
        return _ratio(self._of(self._weights[0], part).astype(np.float64), self.samples(part))

    def further_means(self) -> np.ndarray:
        """Mean of the channels beyond the first. (count, channels - 1) float32"""
        return self._further.copy()

    def replicates(self, part=slice(None)) -> np.ndarray:
        """Number of equal replicates that would be worth as much, W^2 / sum w_k^2. (count,)"""
        return _ratio(self.samples(part) ** 2, self._of(self._squares, part))

    def variance(self, part=slice(None)) -> np.ndarray:
        """Variance of `mean`, without bias; infinite where less than two replicates have samples. (count,)"""
        whole = self.samples(part) ** 2
        rest = whole - self._of(self._squares, part)
        known = rest > LEAST_PART * whole
        return np.where(known, self._deviation[part] / np.where(known, rest, 1.0), np.inf)

    def standard_error(self, part=slice(None)) -> np.ndarray:
        """Root of `variance`. (count,)

        Its square is unbiased, so the root mean square over a map is right as it stands. That of a single value is a root
        of few degrees of freedom, on the average 8 % too small with 4 replicates and 1.6 % with 16; intervals by Student's t
        (`student.t_quantile` with `degrees_of_freedom`) take care of that.
        """
        return np.sqrt(self.variance(part))

    @property
    def degrees_of_freedom(self) -> float:
        """Of the errors: number of replicates less one; a mean over the values where their weights are uneven."""
        return max(float(self.replicates().mean()) - 1.0, 0.0) if self.count else 0.0

    def state(self) -> dict[str, np.ndarray]:
        """Everything, for a checkpoint. The arrays are the sums' own: write them before the next `add`."""
        arrays = {name: getattr(self, f"_{name}") for name in _ARRAYS}
        return {"passes": np.array([self.passes], dtype=np.int64), **arrays}

    def _of(self, weights: np.ndarray, part) -> np.ndarray:
        """Of some values, what may be the same for all."""
        if not self.is_even:
            return weights[part]
        return np.broadcast_to(weights, self._tilt[part].shape)

    def _total(self, part) -> np.ndarray:
        return np.add(self._sums[0, part], self._sums[1, part], dtype=np.float64)

    def join(self, other: "ReplicateSums") -> None:
        """Take in the passes of other sums of the same values, which owe nothing to these; halves stay halves.

        Deviations are about the mean of all then: with s by how much a mean moves, sum w^2 (x - m)^2 becomes
        D - 2 s T + s^2 Q of the deviation D, the tilt T = sum w^2 (x - m) and the squares Q = sum w^2.

        Raises
        ------
        SceneError    They have another number of values or channels.
        """
        if (self.count, self._further.shape[1]) != (other.count, other._further.shape[1]):
            raise SceneError(
                f"sums of {other.count} values cannot be joined to those of {self.count}"
            )
        if self.is_even and not other.is_even:
            self._weights = np.repeat(self._weights, self.count, axis=1)
            self._squares = np.repeat(self._squares, self.count)
            self._sums = self._sums.astype(np.float64)
        whole = self._total(slice(None)) + other._total(slice(None))
        mean = _ratio(whole, self.samples() + other.samples())
        deviation, tilt = np.zeros((2, self.count))
        for each in (self, other):
            squares = each._of(each._squares, slice(None)).astype(np.float64)
            shift, lean = mean - each.mean(), each._tilt.astype(np.float64)
            deviation += each._deviation - 2.0 * shift * lean + shift**2 * squares
            tilt += lean - shift * squares
        if self._further.shape[1]:
            share = _ratio(other.samples(), self.samples() + other.samples())[:, None]
            self._further += share * (other._further - self._further)
        self._deviation[:] = np.maximum(deviation, 0.0)
        self._tilt[:] = tilt
        # An odd number of passes before these makes no difference: each half has passes of its own.
        self._sums += other._sums
        self._weights += other._weights
        self._squares += other._squares
        self.passes += other.passes

    @classmethod
    def from_state(cls, state: dict[str, np.ndarray]) -> "ReplicateSums":
        """Sums that go on from a state.

        Raises
        ------
        SceneError    The arrays do not belong together.
        """
        made = cls(0)
        missing = {"passes", *_ARRAYS} - set(state)
        if missing:
            raise SceneError(f"the state of the sums lacks {', '.join(sorted(missing))}")
        count, weights = state["tilt"].shape[:1], state["squares"].shape[:1]
        if weights != (1,):
            weights = count
        shapes = {
            "sums": (2, *count),
            "weights": (2, *weights),
            "squares": weights,
            "further": (*count, -1),
        }
        for name, sizes in _ARRAYS.items():
            array, wanted = state[name], shapes.get(name, count)
            fits = array.ndim == len(wanted) and all(
                want in (-1, have) for want, have in zip(wanted, array.shape, strict=True)
            )
            kinds = [np.dtype(f"f{size}") for size in sizes]
            if not fits or array.dtype not in kinds or not np.isfinite(array).all():
                raise SceneError(f"the state of the sums holds {name} that do not fit the others")
            setattr(made, f"_{name}", np.array(array))
        passes = state["passes"]
        if passes.shape != (1,) or passes.dtype.kind != "i" or passes[0] < 0:
            raise SceneError("the state of the sums holds no number of passes")
        made.passes = int(passes[0])
        return made


def _ratio(over: np.ndarray, under: np.ndarray) -> np.ndarray:
    """Quotients in double precision, 0 where there is nothing to divide by."""
    return np.divide(over, under, out=np.zeros(np.shape(over)), where=under > 0.0)
