"""The library's materials by name, and sums over their scattering."""

from functools import lru_cache

import numpy as np

from lumenray.engine.scattering.data import evaluation
from lumenray.engine.scattering.data.table import direct_share, interpolate, quadrature
from lumenray.engine.scattering.readers.reader import read_scattering
from lumenray.engine.scene.scattering import ScatterTable
from lumenray.libraries import materials
from lumenray.tools.libraries.materials.recipes import recipes

ENTRIES = materials.entries()

NAMES = [entry.name for entry in ENTRIES]

FILES = [entry.name for entry in ENTRIES if entry.file is not None]

RECIPES = {recipe.name: recipe for recipe in recipes()}

UP = np.array([[0.0, 0.0, 1.0]])


@lru_cache
def sides_of(name):
    return read_scattering(materials.find_entry(name).file).sides


def total(part, polar, rotation=0.0):
    """Share of light from an angle that is sent away, direct part included; by few points in every cell. [rad]"""
    if not isinstance(part, ScatterTable):
        return evaluation.total(part, polar, rotation)
    radial, azimuth, weight = quadrature(part, polar, 2)
    turn, tilt = np.full_like(radial, rotation), np.full_like(radial, polar)
    share = weight @ interpolate(part, turn, tilt, radial, azimuth)
    wi = at(np.degrees(polar), np.degrees(rotation))
    return share + (direct_share(part, wi)[0] if part.direct is not None else 0.0)


def at(polar, azimuth=0.0):
    """Directions by angles. [degree]"""
    t, a = np.broadcast_arrays(np.radians(polar), np.radians(azimuth))
    parts = (np.sin(t) * np.cos(a), np.sin(t) * np.sin(a), np.cos(t))
    return np.stack([np.atleast_1d(p) for p in parts], axis=-1)
