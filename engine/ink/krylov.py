"""Complex linear equations that are known by what their operator does: restarted GMRES, and IDR(s), which keeps few fields.

References
----------
Y. Saad, M. H. Schultz: GMRES, SIAM J. Sci. Stat. Comput. 7, 1986, 856-869. M. B. van Gijzen, P. Sonneveld: Algorithm 913:
an elegant IDR(s) variant that efficiently exploits biorthogonality properties, ACM Trans. Math. Softw. 38, 2011, 5.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

SHADOWS = 4
"""Fields at random against which IDR keeps its residuals small; it holds three times as many."""

LEAST_ANGLE = 0.7
"""Cosine between a residual and what the operator makes of it below which its step is lengthened, as van Gijzen and
Sonneveld do."""

BREAKDOWN = 1e-14
"""Norm of a new direction, relative to the right side, below which the space holds the answer."""


@dataclass(frozen=True, eq=False)
class Found:
    """What an iteration came to.

    Parameters
    ----------
    answer : complex128 array    As the right side.
    iterations : int
    residual : float    Norm of what is left over, relative to the right side.
    """

    answer: np.ndarray
    iterations: int
    residual: float


def solve_linear(
    apply: Callable, right: np.ndarray, tolerance: float, restart: int, most: int
) -> Found:
    """Find x of A x = b.

    Parameters
    ----------
    apply : callable    From x to A x; it may not keep or change what it is given.
    right : complex128 array    b, of any shape; not 0.
    tolerance : float    Residual at which it ends, relative to b.
    restart : int    Directions that are kept at most, each as large as b.
    most : int    Iterations at most; `Found.residual` tells whether they were enough.
    """
    scale = float(np.linalg.norm(right))
    answer, residual, used = np.zeros_like(right), scale, 0
    left = right
    while True:
        answer, residual, used = _cycle(
            apply, left, answer, tolerance * scale, min(restart, most - used), used
        )
        if residual <= tolerance * scale or used >= most:
            return Found(answer, used, residual / scale)
        left = right - apply(answer)
        before, residual = residual, float(np.linalg.norm(left))
        # The recursion's residual is not the true one once rounding rules it.
        if residual <= tolerance * scale or residual > 10.0 * before:
            return Found(answer, used, residual / scale)


def solve_short(
    apply: Callable, right: np.ndarray, tolerance: float, most: int, seed: int = 0
) -> Found:
    """Find x of A x = b by IDR(s): iterations that cost the same however many there are; parameters as of `solve_linear`.

    ``seed``: of the fields at random.
    """
    rng = np.random.default_rng(seed)
    shadows = []
    while len(shadows) < SHADOWS:
        new = rng.standard_normal(right.shape) + 1j * rng.standard_normal(right.shape)
        for other in shadows:
            new -= np.vdot(other, new) * other
        shadows.append(new / np.linalg.norm(new))
    goal = tolerance * float(np.linalg.norm(right))
    answer, left = np.zeros_like(right), right.copy()
    steps = [np.zeros_like(right) for _ in shadows]
    changes = [np.zeros_like(right) for _ in shadows]
    known = np.eye(SHADOWS, dtype=np.complex128)
    length, used = 1.0, 0
    while True:
        seen = np.array([np.vdot(each, left) for each in shadows])
        for k in range(SHADOWS):
            shares = np.linalg.solve(known[k:, k:], seen[k:])
            step = left.copy()
            for share, change in zip(shares, changes[k:], strict=True):
                step -= share * change
            step *= length
            for share, other in zip(shares, steps[k:], strict=True):
                step += share * other
            change = apply(step)
            for j in range(k):
                share = np.vdot(shadows[j], change) / known[j, j]
                change -= share * changes[j]
                step -= share * steps[j]
            steps[k], changes[k] = step, change
            known[k:, k] = [np.vdot(each, change) for each in shadows[k:]]
            share = seen[k] / known[k, k]
            left -= share * change
            answer += share * step
            seen[k + 1 :] -= share * known[k + 1 :, k]
            used += 1
            residual = float(np.linalg.norm(left))
            if residual <= goal or used >= most:
                return Found(answer, used, residual * tolerance / goal)
        change = apply(left)
        used += 1
        size = float(np.linalg.norm(change))
        along = np.vdot(change, left)
        length = along / size**2
        cosine = abs(along) / (size * residual)
        if cosine < LEAST_ANGLE:
            length *= LEAST_ANGLE / max(cosine, BREAKDOWN)
        answer += length * left
        left -= length * change
        residual = float(np.linalg.norm(left))
        if residual <= goal or used >= most:
            return Found(answer, used, residual * tolerance / goal)


def _cycle(apply, left, answer, goal: float, count: int, used: int):
    """One run until a restart: a better answer, its residual, and the iterations so far."""
    norm = float(np.linalg.norm(left))
    basis = [left / norm]
    upper = np.zeros((count + 1, count), np.complex128)
    cosines, sines = np.zeros(count), np.zeros(count, np.complex128)
    rest = np.zeros(count + 1, np.complex128)
    rest[0] = norm
    k = 0
    while True:
        new = apply(basis[k])
        for j in range(k + 1):
            upper[j, k] = np.vdot(basis[j], new)
            new -= upper[j, k] * basis[j]
        length = float(np.linalg.norm(new))
        for j in range(k):
            a, b = upper[j, k], upper[j + 1, k]
            upper[j, k] = cosines[j] * a + sines[j] * b
            upper[j + 1, k] = -np.conj(sines[j]) * a + cosines[j] * b
        a = upper[k, k]
        size = float(np.hypot(abs(a), length))
        cosines[k] = abs(a) / size
        sines[k] = (a / abs(a) if a else 1.0) * length / size
        upper[k, k] = cosines[k] * a + sines[k] * length
        rest[k + 1] = -np.conj(sines[k]) * rest[k]
        rest[k] *= cosines[k]
        k += 1
        residual = abs(rest[k])
        if residual <= goal or k == count or length <= BREAKDOWN * norm:
            break
        basis.append(new / length)
    shares = np.linalg.solve(upper[:k, :k], rest[:k])
    for share, direction in zip(shares, basis, strict=False):
        answer = answer + share * direction
    return answer, float(residual), used + k
