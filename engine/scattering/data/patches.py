"""Scattering by pairs of patches (Klems): evaluation, integrals and checks, in double precision."""

import numpy as np

from ...errors import SceneError
from ...scene.scattering import PatchBasis, PatchMatrix

MOST_PATCHES = 10_000
"""Patches that a basis may have."""


def check_patches(matrix: PatchMatrix) -> None:
    """Refuse a matrix that breaks its own rules.

    Raises
    ------
    SceneError    Says what is wrong with it.
    """
    for basis in (matrix.incoming, matrix.outgoing):
        _check_basis(basis)
    wavelengths = matrix.wavelengths
    if wavelengths.ndim != 1 or not wavelengths.size or not np.isfinite(wavelengths).all():
        raise SceneError("a scattering matrix has no wavelength, or one that is no number")
    if np.any(np.diff(wavelengths) <= 0.0):
        raise SceneError("a scattering matrix's wavelengths must ascend strictly")
    shape = (*(int(b.counts.sum()) for b in (matrix.incoming, matrix.outgoing)), len(wavelengths))
    if matrix.values.shape != shape:
        raise SceneError(
            f"a scattering matrix has values of shape {matrix.values.shape}, expected {shape} by its patches"
        )
    if not np.isfinite(matrix.values).all() or matrix.values.min() < 0.0:
        raise SceneError("a scattering matrix has a value that is negative or no finite number")


def _check_basis(basis: PatchBasis) -> None:
    bounds, counts = basis.bounds, basis.counts
    if counts.ndim != 1 or not counts.size or bounds.shape != (len(counts) + 1,):
        raise SceneError("a basis of patches needs one polar angle more than it has rings")
    if not np.isfinite(bounds).all() or np.any(np.diff(bounds) <= 0.0):
        raise SceneError("a basis of patches has polar angles that do not ascend strictly")
    if bounds[0] != 0.0 or abs(bounds[-1] - 0.5 * np.pi) > 1e-6:
        raise SceneError("a basis of patches must reach from the pole to the horizon")
    if counts.min() < 1 or counts.sum() > MOST_PATCHES:
        raise SceneError(f"a basis has a ring without patches, or more than {MOST_PATCHES} of them")


def starts_of(basis: PatchBasis) -> np.ndarray:
    """Number of the first patch of each ring. (r,) int64"""
    return np.cumsum(basis.counts, dtype=np.int64) - basis.counts


def patch_of(basis: PatchBasis, directions) -> np.ndarray:
    """Numbers of the patches in which directions above the horizon lie. (n, 3) -> (n,) int64"""
    x, y = np.asarray(directions, dtype=np.float64)[..., :2].T
    ring = np.searchsorted(np.sin(basis.bounds[1:-1]) ** 2, x * x + y * y, side="right")
    count = basis.counts[ring]
    place = np.floor(np.arctan2(y, x) * count / (2.0 * np.pi) + 0.5).astype(np.int64)
    return starts_of(basis)[ring] + place % count


def solid_angles(basis: PatchBasis) -> np.ndarray:
    """Projected solid angles of the patches; they add up to pi. (p,) [sr]"""
    rings = np.pi * np.diff(np.sin(basis.bounds) ** 2) / basis.counts
    return np.repeat(rings, basis.counts)


def centre(basis: PatchBasis) -> np.ndarray:
    """Directions of the patches' centres; of a ring with one patch the pole. (p, 3)"""
    middle = np.where(basis.counts > 1, 0.5 * (basis.bounds[1:] + basis.bounds[:-1]), 0.0)
    polar = np.repeat(middle, basis.counts)
    azimuth = np.concatenate([np.arange(n) * (2.0 * np.pi / n) for n in basis.counts])
    sine = np.sin(polar)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(polar)], axis=1)


def evaluate_patches(matrix: PatchMatrix, wi, wo) -> np.ndarray:
    """Values for pairs of directions at the matrix's wavelengths. (n, 3), (n, 3) -> (n, w) float64 [1/sr]"""
    wi, wo = np.asarray(wi, dtype=np.float64), np.asarray(wo, dtype=np.float64)
    found = matrix.values[patch_of(matrix.incoming, wi), patch_of(matrix.outgoing, wo)]
    above = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
    return np.where(above[:, None], found.astype(np.float64), 0.0)


def albedos(matrix: PatchMatrix) -> np.ndarray:
    """Share of light from each patch that is scattered: integral of f cos. (i, w) float64 [-]"""
    return np.einsum("iow,o->iw", matrix.values, solid_angles(matrix.outgoing))


def albedo_of_patches(matrix: PatchMatrix, incidence: float, rotation: float = 0.0) -> np.ndarray:
    """Share of light from one direction that is scattered: integral of f cos. (w,) float64 [-]"""
    sine = np.sin(incidence)
    wi = np.array([[sine * np.cos(rotation), sine * np.sin(rotation), np.cos(incidence)]])
    return solid_angles(matrix.outgoing) @ matrix.values[patch_of(matrix.incoming, wi)[0]]


def transposed(matrix: PatchMatrix) -> PatchMatrix:
    """What the matrix tells of light on the way back: by reciprocity, transmission of the other side."""
    values = np.ascontiguousarray(matrix.values.transpose(1, 0, 2))
    return PatchMatrix(matrix.outgoing, matrix.incoming, matrix.wavelengths, values)


def pairs_of(matrix: PatchMatrix, back: PatchMatrix | None = None) -> tuple[np.ndarray, ...]:
    """Values of all pairs of patches, of the same the other way, and their projected solid angles. (n, w), (n, w), (n,)

    ``back`` as of `reciprocity_of`.
    """
    incoming, outgoing = centre(matrix.incoming), centre(matrix.outgoing)
    i, o = (m.ravel() for m in np.indices(matrix.values.shape[:2]))
    weight = solid_angles(matrix.incoming)[i] * solid_angles(matrix.outgoing)[o]
    there = matrix.values[i, o].astype(np.float64)
    return there, evaluate_patches(back or matrix, outgoing[o], incoming[i]), weight


def reciprocity_of(matrix: PatchMatrix, back: PatchMatrix | None = None) -> float:
    """How far a matrix is from reciprocity: root mean square of f(i, o) - g(o, i), relative to that of their mean.

    Parameters
    ----------
    back : PatchMatrix or None    g, with as many wavelengths; of transmission, that of the other side. None: the same.

    Returns
    -------
    float    0: reciprocal, 2: light passes one way only. Pairs of patches count by their projected solid angles.
    """
    there, again, weight = pairs_of(matrix, back)
    weight = weight[:, None]
    mean = 0.25 * (weight * (there + again) ** 2).sum()
    return float(np.sqrt((weight * (there - again) ** 2).sum() / mean)) if mean > 0.0 else 0.0
