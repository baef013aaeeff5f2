"""Reflection and transmission of layers as matrices, and how layers are added.

A layer's kernels in directions with the flux weights c are taken as C^1/2 R C^1/2, so that products of matrices are what
light does one after the other, reciprocity is symmetry, and what is kept is kept exactly. By depth z light u goes down and
v up as

    du/dz = -alpha u + beta v,    -dv/dz = -alpha v + beta u

with symmetric alpha, beta. The sum u + v and the difference u - v see alpha + beta = A and alpha - beta = B alone; about the
middle of a homogeneous layer of the thickness H one of them is even and the other odd, so with A = L L^T and
L^T B L = V diag(g2) V^T

    R + T = 2 (1 + K)^-1 - 1,     K = Z^-T g tanh(g H / 2) Z^-1
    R - T = 1 - 2 (1 + K')^-1,    K' = Z tanh(g H / 2) / g Z^T,      Z = L V

which is what doubling of ever thinner layers tends to: no start, no steps, and thickness costs nothing.

References
----------
J. E. Hansen: Multiple scattering of polarized light in planetary atmospheres, Part I, J. Atmos. Sci. 28, 1971.
I. P. Grant, G. E. Hunt: Discrete space theory of radiative transfer, Proc. R. Soc. Lond. A 313, 1969.
K. Stamnes et al.: Numerically stable algorithm for discrete-ordinate-method radiative transfer, Applied Optics 27, 1988.
"""

from dataclasses import dataclass

import numpy as np

LEAST_EXTINCTION = 1e-9
"""Extinction at least, so that clear layers are no special case. [1/um]"""


@dataclass(frozen=True, eq=False)
class Rates:
    """What a layer's matter does to light along a length of the normal, in modes of the azimuth.

    Parameters
    ----------
    total, difference : (..., n, n) float64 arrays    A = alpha + beta and B = alpha - beta. [1/um]
    """

    total: np.ndarray
    difference: np.ndarray


def find_rates(extinction, back, forth, cosines, weights) -> Rates:
    """Rates of a layer.

    Parameters
    ----------
    extinction : (..., n) array    By length along the direction. [1/um]
    back, forth : (..., n, n) arrays    Modes of pi times scattering into the other and into the same half. [1/um]
    cosines, weights : (n,) arrays    Flux weights, 2 cos times those of the cosine.
    """
    root = np.sqrt(weights) / cosines
    both = np.outer(root, root)
    back, forth = back * both, forth * both
    total = back - forth
    difference = -(back + forth)
    k = np.arange(len(cosines))
    straight = np.maximum(extinction, LEAST_EXTINCTION) / cosines
    total[..., k, k] += straight
    difference[..., k, k] += straight
    return Rates(total, difference)


def find_slab(rates: Rates, thickness: float) -> tuple[np.ndarray, np.ndarray]:
    """Reflection and transmission of a layer, direct light in the transmission. [um] -> two (..., n, n) arrays"""
    lower = _root_of(rates.total)
    square = _transposed(lower) @ rates.difference @ lower
    values, vectors = np.linalg.eigh(square)
    decay = np.sqrt(np.maximum(values, 0.0))
    tangent = np.tanh(0.5 * thickness * decay)
    mixed = lower @ vectors
    half = np.where(decay > 1e-12, tangent / np.maximum(decay, 1e-12), 0.5 * thickness)
    odd = (mixed * half[..., None, :]) @ _transposed(mixed)
    k = np.arange(odd.shape[-1])
    odd[..., k, k] += 1.0
    odd = np.linalg.inv(odd)
    even = _transposed(mixed) @ mixed
    even[..., k, k] += decay * tangent
    even = mixed @ np.linalg.solve(even, _transposed(mixed))
    passed = even + odd
    passed[..., k, k] -= 1.0
    return even - odd, passed


def add_below(reflected, passed, below) -> np.ndarray:
    """Reflection of a layer on what lies below it. Three (..., n, n) arrays -> (..., n, n)"""
    loop = -(below @ reflected)
    k = np.arange(loop.shape[-1])
    loop[..., k, k] += 1.0
    return reflected + passed @ np.linalg.solve(loop, below @ passed)


def under_face(reflected, face) -> np.ndarray:
    """Light between a face and what lies below it, that comes up for each that goes down: (1 - R F)^-1 R.

    Parameters
    ----------
    reflected : (..., n, n) array
    face : (..., n) array    Share that the face sends back down.
    """
    loop = -(reflected * face[..., None, :])
    k = np.arange(loop.shape[-1])
    loop[..., k, k] += 1.0
    return np.linalg.solve(loop, reflected)


def _root_of(matrix) -> np.ndarray:
    """L with L L^T a positive matrix, (..., n, n)."""
    try:
        return np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        # Flakes that hardly reflect may do so by less than the error of their series, and that below 0.
        values, vectors = np.linalg.eigh(matrix)
        return vectors * np.sqrt(np.maximum(values, LEAST_EXTINCTION))[..., None, :]


def _transposed(matrix) -> np.ndarray:
    return np.swapaxes(matrix, -1, -2)
