"""Which values of many get the next samples: those that the error waits for.

Values have two halves of independent groups. How much the samples of a half scatter is told by the other half and by both
halves of its neighbours, never by itself, so that its mean does not depend on what it was before: a value that has seen no
bright sample yet would get no more of them, and stay too low (theory 10.9).
"""

import numpy as np

LEAST = 0.25
"""Fewest samples of a value, relative to the mean: others may not have seen yet what makes them scatter. [-]"""

NEIGHBOURS = 4
"""Values before and after one along a curve through all of them which tell of it: a scatter that few samples have told is by
chance too small or too large by a few times."""

WORTHWHILE = 1.5
"""Ratio of the samples that all alike would take to those by need from which on the latter are made: what is known of the
scatter is not exact, and well-distributed samples serve best where there are as many everywhere. [-]"""

LEVELS = 10
"""Halvings of the box of all places that the curve through them follows."""

STEP = 1.0 / 8.0
"""Share of its samples that a value gets at least which misses what is allowed it. [-]"""

ROUNDS = 60
"""Times that the interval is halved which holds the number of samples for each unit of scatter."""


def order_by_place(positions: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Values along a curve on which neighbours are neighbours in space, those that face alike together. (n,) int

    ``positions``, ``normals``: (n, 3). The curve is that of G. M. Morton (1966), whose number has the digits of all three
    coordinates in turn.
    """
    low = positions.min(axis=0)
    size = max(float((positions.max(axis=0) - low).max()), 1e-30)
    cells = np.minimum((positions - low) / size * 2**LEVELS, 2**LEVELS - 1).astype(np.int64)
    number = np.zeros(len(positions), dtype=np.int64)
    for level in range(LEVELS):
        for axis in range(3):
            number |= (cells[:, axis] >> level & 1) << (3 * level + axis)
    main = np.abs(normals).argmax(axis=1)
    facing = 2 * main + (normals[np.arange(len(normals)), main] < 0.0)
    return np.lexsort((number, facing))


def foretell(variances: np.ndarray, order: np.ndarray) -> np.ndarray:
    """Variances of single samples by what all tell but the half itself that is asked for. (2, n)

    Parameters
    ----------
    variances : (2, n) array    By half.
    order : (n,) int array    As of `order_by_place`.
    """
    along = variances.sum(axis=0)[order]
    ends = np.concatenate([[0.0], np.cumsum(along)])
    place = np.arange(len(order))
    first, last = (
        np.maximum(place - NEIGHBOURS, 0),
        np.minimum(place + NEIGHBOURS + 1, len(order)),
    )
    sums, many = np.empty(len(order)), np.empty(len(order))
    sums[order], many[order] = ends[last] - ends[first], 2.0 * (last - first) - 1.0
    return np.maximum(sums - variances, 0.0) / many


def gain_of(variances: np.ndarray) -> float:
    """Samples that all alike would take to an error of the whole over those by need. [-]

    ``variances``: of single samples, (2, n).
    """
    squares = float(np.sqrt(variances).mean()) ** 2
    return float(variances.mean()) / squares if squares > 0.0 else 1.0


def wanted_for_all(counts: np.ndarray, variances: np.ndarray, more: float) -> np.ndarray:
    """Samples by which the mean square of all errors is least: in proportion to the scatter.

    Parameters
    ----------
    counts : (2, n) array    Samples so far.
    variances : (2, n) array    Of a single sample, foretold.
    more : float    Samples to be added for each, on the mean.

    Returns
    -------
    (2, n) array    Samples to come to, nowhere below ``counts``; ``more`` above these on the mean.
    """
    scatter = np.sqrt(variances)
    mean = float(counts.mean()) + more
    floor = np.maximum(counts, LEAST * mean)
    if not scatter.any():
        return counts + more
    if floor.mean() >= mean:
        return counts + (floor - counts) * (more / float((floor - counts).mean()))
    low, high = 0.0, mean * counts.size / float(scatter.max())
    for _ in range(ROUNDS):
        middle = 0.5 * (low + high)
        is_more = np.maximum(floor, middle * scatter).mean() > mean
        low, high = (low, middle) if is_more else (middle, high)
    return np.maximum(floor, high * scatter)


def wanted_for_each(counts: np.ndarray, excess: np.ndarray, more: float) -> np.ndarray:
    """Samples with which every error is what it may be, or as much nearer to these as so many more bring.

    Each value stops by its own error, as a job of it alone would (theory 10.4).

    Parameters
    ----------
    counts : (2, n) array    Samples so far.
    excess : (n,) array    Errors over what each may be. [-]
    more : float    Samples to be added for each, on the mean, at most.

    Returns
    -------
    (2, n) array    Samples to come to, nowhere below ``counts``.
    """
    # An error that is known to a fifth of itself asks for a little more as often as not.
    missing = np.where(excess > 1.0, np.clip(excess**2 - 1.0, STEP, 1e9), 0.0) * counts
    whole = float(missing.mean())
    return counts + missing * min(more / whole, 1.0) if whole > 0.0 else counts.astype(np.float64)


def share_out(wanted: np.ndarray, counts: np.ndarray, unit: int) -> np.ndarray:
    """Units of samples that bring counts to what is wanted, on the mean of all. (2, n) int"""
    ends = np.floor(np.cumsum(np.maximum(wanted - counts, 0.0)) / unit + 0.5).astype(np.int64)
    return np.diff(ends, prepend=0).reshape(counts.shape)
