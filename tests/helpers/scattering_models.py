"""Scattering that is known in closed form, to make tables of."""

import numpy as np

from lumenray.engine.scene.scattering import ScatterTable


def lambert(reflectance=0.5):
    """Return an evaluator of Lambert's law. [1/sr]"""
    return lambda wi, wo: np.full((len(wi), 1), reflectance / np.pi)


def schlick(cosine):
    """Reflectance of glass (4 % at normal incidence) by Schlick's formula. [-]"""
    return 0.04 + 0.96 * (1.0 - cosine) ** 5


def ggx(alpha, fresnel=np.ones_like, along=None, is_joint=True):
    """Return an evaluator of a GGX mirror. [1/sr]

    ``alpha``: its width across x, and along x unless ``along`` is given; ``is_joint``: whether masking and shadowing go by
    their heights together.
    """
    across = alpha if along is None else along

    def evaluate(wi, wo):
        half = wi + wo
        half = half / np.linalg.norm(half, axis=1, keepdims=True)
        spread = (half[:, 0] / across) ** 2 + (half[:, 1] / alpha) ** 2 + half[:, 2] ** 2
        density = 1.0 / (np.pi * alpha * across * spread**2)

        def root(v):
            return np.sqrt((across * v[:, 0]) ** 2 + (alpha * v[:, 1]) ** 2 + v[:, 2] ** 2)

        if is_joint:
            joint = 0.5 / (wo[:, 2] * root(wi) + wi[:, 2] * root(wo))
        else:
            joint = 1.0 / ((wo[:, 2] + root(wo)) * (wi[:, 2] + root(wi)))
        return (fresnel((wi * half).sum(axis=1)) * density * joint)[:, None]

    return evaluate


def directions(count, seed, lowest=0.05):
    """Unit vectors spread by solid angle over the hemisphere, z above ``lowest``. (n, 3)"""
    rng = np.random.default_rng(seed)
    z = lowest + (1.0 - lowest) * rng.random(count)
    turn = 2.0 * np.pi * rng.random(count)
    sine = np.sqrt(1.0 - z**2)
    return np.stack([sine * np.cos(turn), sine * np.sin(turn), z], axis=1)


def towards(angle, azimuth=0.0):
    """Directions at angles to the normal and azimuths. (..., 3) [degree]"""
    theta, phi = np.radians(angle), np.radians(azimuth)
    parts = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def random_table(seed=1, rotations=3, is_symmetric=False, bands=3, is_orthotropic=False):
    """A table with steep, random values on random axes."""
    rng = np.random.default_rng(seed)

    def axis(count, low, high):
        inner = np.sort(rng.uniform(low + 0.01, high - 0.01, count - 2))
        return np.concatenate([[low], inner, [high]])

    end = np.pi if is_symmetric else 2.0 * np.pi
    if is_orthotropic:
        turns = axis(rotations, 0.0, 0.5 * np.pi)
    else:
        turns = np.sort(rng.uniform(0.0, 2.0 * np.pi, rotations)) if rotations > 1 else np.zeros(1)
    axes = [
        turns,
        axis(4, 0.1, 1.4),
        axis(7, 0.0, np.pi),
        axis(6, 0.0, end),
        axis(bands, 400.0, 700.0) if bands > 1 else np.array([550.0]),
    ]
    shape = tuple(len(a) for a in axes)
    values = rng.exponential(0.2, shape).astype(np.float32)
    return ScatterTable(*axes, values, is_orthotropic=is_orthotropic)
