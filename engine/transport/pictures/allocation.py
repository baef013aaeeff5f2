"""How many samples of each kind pixels get: where another one lowers the picture's error most for its cost.

Tiles of a few pixels get samples alike, so that how they scatter is known well enough, and always twice as many as before:
low-discrepancy points are even at powers of two. The variance of what a tile's kind adds to the picture falls as one over
its samples N, so another one is worth q / (N c), with the square q of the error that it has now and its cost c (Neyman's
allocation).
"""

import numpy as np

from ..lux_maps.levels import Units

TILE = 8
"""Side of the squares that get samples alike. [pixel]"""

OWN = 0.5
"""Share of its own scatter in what a tile is thought to scatter; the rest is that of all tiles around it. [-]"""

SPREAD = 16
"""Least samples of a tile: the mean of all over this; and least of a kind: that of all kinds over this. Light that few
samples have missed may still be there."""


MOST_DOUBLINGS, HALVINGS = 40, 30
"""Doublings of a tile's samples that are foretold at most, and steps in which the end of them is found."""


class Allocation:
    """Samples so far, and who gets more.

    Parameters
    ----------
    width, height : int    Of the picture. [pixel]
    costs : dict    By kinds of samples.
    floors : dict or None    Least samples of every tile over the mean of all, of kinds whose light is rare and bright. [-]

    Attributes
    ----------
    counts : dict    Samples of every tile's pixels in a half, by kind: (t,) int64.
    """

    def __init__(
        self,
        width: int,
        height: int,
        costs: dict[int, float],
        floors: dict[int, float] | None = None,
    ):
        across = -(-width // TILE)
        self._shape = (-(-height // TILE), across)
        y, x = np.divmod(np.arange(width * height), width)
        self.tile = (y // TILE) * across + x // TILE
        self.size = np.bincount(self.tile)
        self.costs = costs
        self._floors = np.array([(floors or {}).get(kind, 0.0) for kind in costs])
        self.counts = {kind: np.zeros(len(self.size), dtype=np.int64) for kind in costs}

    @property
    def samples(self) -> float:
        """Mean number of samples of a pixel in a half; one of each kind counts as one."""
        return self.mean(self.counts)

    def mean(self, counts: dict[int, np.ndarray]) -> float:
        """As `samples`, of other counts of tiles by kind."""
        spent = sum(cost * (counts[kind] @ self.size) for kind, cost in self.costs.items())
        return float(spent) / (sum(self.costs.values()) * len(self.tile))

    def of_pixels(self, kind: int) -> np.ndarray:
        """Samples of every pixel in a half. (n,)"""
        return self.counts[kind][self.tile]

    def begin(self) -> dict[int, np.ndarray]:
        """Give every pixel one sample of each kind; returns as `extend`."""
        return {kind: np.ones(len(self.size), dtype=np.int64) for kind in self.costs}

    def double(self) -> dict[int, np.ndarray]:
        """Double all samples; returns as `choose`."""
        return {kind: counts.copy() for kind, counts in self.counts.items()}

    def choose(
        self, squares: dict[int, np.ndarray], budget: float, most: float = np.inf
    ) -> dict[int, np.ndarray]:
        """Choose tiles whose samples are doubled.

        Parameters
        ----------
        squares : dict    Of the errors that pixels have by a kind, relative: (n,), by kind.
        budget : float    Samples of a pixel in a half, on the mean; as in `samples`. The best is doubled even beyond it.
        most : float    As many are never exceeded, but by a single sample: the best gets what there is of them.

        Returns
        -------
        dict    Samples that are added for every pixel of a tile, by kind: (t,) int64; 0 for none.
        """
        kinds = list(self.costs)
        counts = np.stack([self.counts[kind] for kind in kinds])
        price = np.array([self.costs[kind] for kind in kinds])[:, None] * counts * self.size
        worth = np.stack([self._spread(squares[kind]) * self.size for kind in kinds])
        # What has next to no samples comes first, then what lowers the error most.
        means = np.maximum(counts @ self.size / len(self.tile), self.samples / SPREAD)
        least = np.maximum(means / SPREAD, self._floors * self.samples)
        urgent = counts < least[:, None]
        worth = np.where(urgent, np.inf, worth / np.maximum(price, 1e-300)).ravel()
        order = np.argsort(-worth, kind="stable")
        spent = np.cumsum(price.ravel()[order])
        whole = sum(self.costs.values()) * len(self.tile)
        many = max(int(np.searchsorted(spent, budget * whole, side="right")), 1)
        added = np.zeros_like(counts)
        added.flat[order[:many]] = counts.flat[order[:many]]
        if spent[0] > most * whole:
            fits = int(counts.flat[order[0]] * most * whole / spent[0])
            added.flat[order[0]] = 1 << max(fits.bit_length() - 1, 0)
        return dict(zip(kinds, added, strict=True))

    def foresee(
        self,
        squares: dict[int, np.ndarray],
        errors: dict[int, np.ndarray],
        goal: float,
        powers: dict[int, float] | None = None,
    ) -> float:
        """Samples at which the error will have come down to a goal, if those who need them most are doubled.

        Parameters
        ----------
        squares : dict    As of `choose`: they tell who is doubled.
        errors : dict    Squares of the errors that count, alike.
        goal : float    What the errors' sum over the kinds has to come to on the mean of the pixels.
        powers : dict or None    Of the samples by which these squares fall, by kind; None: as one over the samples. [-]

        Returns
        -------
        float    Samples of a pixel in a half, on the mean; those that there are if the goal is met.
        """
        counts = np.stack([self.counts[kind] for kind in self.costs])
        costs = np.array(list(self.costs.values()))[:, None]
        price = costs * counts * self.size / (costs.sum() * len(self.tile))
        shares = self.size / len(self.tile)
        left = np.stack(
            [np.bincount(self.tile, errors[kind], len(self.size)) for kind in self.costs]
        )
        left /= len(self.tile)
        worth = np.stack([self._spread(squares[kind]) * shares for kind in self.costs])
        worth = np.log2(np.maximum(worth, 1e-300)) - np.log2(np.maximum(price, 1e-300))
        falls = np.array([[(powers or {}).get(kind, 1.0)] for kind in self.costs])

        def after(least: float) -> tuple[float, float]:
            """Errors and samples once nothing is worth more than two to the power of the least."""
            # Each doubling lowers the square and doubles its price.
            doublings = np.maximum(np.ceil((worth - least) / (1.0 + falls)), 0.0)
            samples = float((price * 2.0**doublings).sum())
            if self._floors.any():
                floors = np.maximum(self._floors[:, None] * samples / counts, 1.0)
                doublings = np.maximum(doublings, np.ceil(np.log2(floors)))
                samples = float((price * 2.0**doublings).sum())
            return float((left * 2.0 ** -(falls * doublings)).sum()), samples

        high = float(worth.max())
        far = after(high)
        if far[0] <= goal:
            return self.samples
        low = high - 2.0 * MOST_DOUBLINGS
        near = after(low)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            now = after(middle)
            if now[0] > goal:
                high, far = middle, now
            else:
                low, near = middle, now
        share = (far[0] - goal) / max(far[0] - near[0], 1e-300)
        return far[1] + min(share, 1.0) * (near[1] - far[1])

    def extend(self, added: dict[int, np.ndarray]) -> None:
        """Take note that samples were taken."""
        for kind, more in added.items():
            self.counts[kind] += more

    def units(self, kind: int, added: np.ndarray) -> Units | None:
        """The work that makes samples of a kind, sorted by pixels; None: there is none. ``added``: as of `choose`."""
        more, first = added[self.tile], self.of_pixels(kind)
        pixels = np.flatnonzero(more)
        if not len(pixels):
            return None
        each = int(np.gcd.reduce(more[pixels]))
        parts = more[pixels] // each
        pixel = np.repeat(pixels, parts)
        number = np.arange(len(pixel)) - np.repeat(np.cumsum(parts) - parts, parts)
        return Units(pixel, first[pixel] + each * number, each, added)

    def _spread(self, squares: np.ndarray) -> np.ndarray:
        """Mean square of a tile and the tiles around it. (t,)"""
        sums = np.bincount(self.tile, squares, len(self.size)).reshape(self._shape)
        size = self.size.reshape(self._shape)
        own = sums / size
        around = _box(sums) / _box(size.astype(np.float64))
        return (OWN * own + (1.0 - OWN) * around).ravel()


def _box(values: np.ndarray) -> np.ndarray:
    """Sum of each value and all around it."""
    padded = np.pad(values, 1)
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]
