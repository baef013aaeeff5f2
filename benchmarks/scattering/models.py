"""Materials in closed form, which tables are compared with, and tables made of them."""

from functools import cache

import numpy as np

from ...engine.scattering.data.resampling import resample

WAVELENGTHS = np.arange(400.0, 701.0, 10.0)
"""Bands of the coloured ones. [nm]"""


def schlick(cosine):
    """Reflectance of glass (4 % at normal incidence). [-]"""
    return 0.04 + 0.96 * (1.0 - cosine) ** 5


def mirror(alpha: float, fresnel=np.ones_like, across: float | None = None, is_joint: bool = True):
    """Return an evaluator of a GGX mirror. [1/sr]

    Parameters
    ----------
    alpha : float    Width along x.
    fresnel : callable    Reflectance by the cosine at the facets.
    across : float or None    Width along y; None: as along x.
    is_joint : bool    Whether masking and shadowing go by their heights together.
    """
    along, aside = alpha, alpha if across is None else across

    def evaluate(wi, wo):
        half = wi + wo
        half = half / np.maximum(np.linalg.norm(half, axis=1, keepdims=True), 1e-12)
        spread = (half[:, 0] / along) ** 2 + (half[:, 1] / aside) ** 2 + half[:, 2] ** 2
        density = 1.0 / (np.pi * along * aside * spread**2)

        def root(v):
            return np.sqrt((along * v[:, 0]) ** 2 + (aside * v[:, 1]) ** 2 + v[:, 2] ** 2)

        if is_joint:
            shadow = 0.5 / (wo[:, 2] * root(wi) + wi[:, 2] * root(wo))
        else:
            shadow = 1.0 / ((wo[:, 2] + root(wo)) * (wi[:, 2] + root(wi)))
        return (fresnel((wi * half).sum(axis=1)) * density * shadow)[:, None]

    return evaluate


def gold_like(cosine):
    """A metal that is yellow. (n,) -> (n,) at the mean of its bands."""
    return 0.7 + 0.3 * (1.0 - cosine) ** 5


def paint(alpha: float, spectrum=None):
    """A pigment under a clear coat of a width. (n, bands)"""
    coat = mirror(alpha, schlick)
    base = np.array([0.5]) if spectrum is None else spectrum

    def evaluate(wi, wo):
        inside = (1.0 - schlick(wi[:, 2])) * (1.0 - schlick(wo[:, 2]))
        return coat(wi, wo) + inside[:, None] * base / np.pi

    return evaluate


RED = 0.05 + 0.65 / (1.0 + np.exp(-(WAVELENGTHS - 590.0) / 14.0))
"""Reflectance of a red pigment. [-]"""

MATERIALS = {
    "matt": (lambda wi, wo: np.full((len(wi), 1), 0.8 / np.pi), np.array([550.0]), {}),
    "satin paint": (paint(0.25), np.array([550.0]), {}),
    "gloss paint": (paint(0.08), np.array([550.0]), {}),
    "red gloss paint": (paint(0.1, RED), WAVELENGTHS, {}),
    "rough metal": (mirror(0.3, gold_like), np.array([550.0]), {}),
    "polished metal": (mirror(0.05, gold_like), np.array([550.0]), {}),
    "brushed metal": (
        mirror(0.3, gold_like, 0.15),
        np.array([550.0]),
        {"rotations": None, "is_orthotropic": True, "is_symmetric": False},
    ),
}
"""Evaluator, wavelengths [nm] and further arguments of `resample`, by name."""


@cache
def table_of(name: str, tolerance: float):
    """Table of a material with an error."""
    exact, wavelengths, more = MATERIALS[name]
    return resample(exact, wavelengths, tolerance=tolerance, **more)


def cosine_directions(draw) -> np.ndarray:
    """Directions about +z by their cosine, from numbers (2, n) in 0..1. (n, 3)"""
    sine, turn = np.sqrt(draw[0]), 2.0 * np.pi * draw[1]
    return np.stack([sine * np.cos(turn), sine * np.sin(turn), np.sqrt(1.0 - draw[0])], axis=1)
