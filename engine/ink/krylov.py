"""Restarted GMRES for complex linear equations that are known by what their operator does.

References
----------
Y. Saad, M. H. Schultz: GMRES, SIAM J. Sci. Stat. Comput. 7, 1986, 856-869.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

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
