"""Reflection at smooth boundaries: dielectrics, metals, and stacks of thin films; unpolarised light."""

import numpy as np


def cosine_inside(cosine, index) -> np.ndarray:
    """Cosine on the far side of a boundary; complex where the index is, or where light is totally reflected."""
    squared = 1.0 - (1.0 - np.asarray(cosine, dtype=np.float64) ** 2) / np.asarray(index) ** 2
    return np.sqrt(squared.astype(np.complex128))


def reflectance(cosine, index) -> np.ndarray:
    """Reflectance of a boundary.

    Parameters
    ----------
    cosine : array    To the normal, on the side that light comes from. [-]
    index : array    Refractive index of the far side over that of the near side; n + ik for metals. Both broadcast. [-]
    """
    c, index = np.asarray(cosine, dtype=np.float64), np.asarray(index)
    t = cosine_inside(c, index)
    perpendicular = (c - index * t) / (c + index * t)
    parallel = (index * c - t) / (index * c + t)
    return 0.5 * (np.abs(perpendicular) ** 2 + np.abs(parallel) ** 2)


def stack_reflectance(cosine, wavelengths, indices, thicknesses, binder: float) -> np.ndarray:
    """Reflectance of a stack of thin films that don't absorb, with the same matter on both sides.

    Parameters
    ----------
    cosine : (n,) array    To the normal, in the matter around. [-]
    wavelengths : (w,) array    In vacuum. [nm]
    indices, thicknesses : sequences    Of the films. [-], [nm]
    binder : float    Index of the matter around. [-]

    Returns
    -------
    (n, w) array    [-]

    References
    ----------
    M. Born, E. Wolf: Principles of Optics, 7th ed., 1.6: characteristic matrices.
    """
    cosine = np.asarray(cosine, dtype=np.float64)[:, None]
    wavelengths = np.asarray(wavelengths, dtype=np.float64)
    total = 0.0
    for is_parallel in (False, True):

        def admittance(index, cos, is_parallel=is_parallel):
            return index / cos if is_parallel else index * cos

        outer = admittance(binder, cosine)
        # The row vector (B, C) of the field behind the stack, brought forward film by film.
        electric, magnetic = np.ones_like(outer + 0j * wavelengths), outer + 0j * wavelengths
        for index, thickness in zip(reversed(indices), reversed(thicknesses), strict=True):
            inside = np.sqrt(1.0 - (binder / index) ** 2 * (1.0 - cosine**2))
            phase = 2.0 * np.pi * index * thickness * inside / wavelengths
            own = admittance(index, inside)
            electric, magnetic = (
                np.cos(phase) * electric + 1j * np.sin(phase) / own * magnetic,
                1j * own * np.sin(phase) * electric + np.cos(phase) * magnetic,
            )
        amplitude = (outer * electric - magnetic) / (outer * electric + magnetic)
        total = total + 0.5 * np.abs(amplitude) ** 2
    return total
