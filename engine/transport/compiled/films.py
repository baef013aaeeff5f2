"""Tables of thin films for the surfaces of a scene, in the active variant."""

import mitsuba as mi
import numpy as np

from ...materials.facets import MINIMUM_ALPHA, grazing
from ...materials.film import (
    FilmOnGlass,
    FilmOnMetal,
    FilmOnPaint,
    grid,
    metal_index,
    reflectance,
)
from ...materials.rough_metal import TINTED
from ...photometry.spectra import GRID, evaluate_reflectance
from ...scene.film import Film
from ...scene.material import Coated, Dielectric, Glossy
from ...scene.spectrum import Constant, Rgb
from ...scene.texture import ImageTexture
from .textures import TextureMaker, is_spectral, refractive_index

SMALLEST_INDEX = 1.0001
"""Below this a base is no boundary to kernels."""


def film_on_paint(surface: Coated, make: TextureMaker) -> FilmOnPaint:
    """Return the film of a coat of paint, its tint included."""
    film, index = surface.film, max(float(surface.ior), SMALLEST_INDEX)
    tint = Constant(1.0) if surface.tint is None else surface.tint

    def table(cosine, wavelengths):
        less = grazing(index, np.clip(evaluate_reflectance(tint, wavelengths), 0.0, 1.0))
        own = reflectance(film, index, cosine, wavelengths)
        return np.maximum(1.0 - less * (1.0 - own), 0.0)

    scale = float(np.clip(surface.specular, 0.0, 1.0))
    return FilmOnPaint(_table(film, table, make), _width(surface.roughness), scale)


def film_on_metal(surface: Glossy, make: TextureMaker) -> FilmOnMetal:
    """Return the film of a metal that has the colours of a surface without it."""
    return FilmOnMetal(_table(surface.film, lambda *at: metal_under_film(surface, *at), make))


def metal_under_film(surface: Glossy, cosine, wavelengths) -> np.ndarray:
    """Reflectance of a metal under its film. [-]

    Parameters
    ----------
    surface : Glossy    With a film.
    cosine : array    To the normal. [-]
    wavelengths : array    [nm]
    """
    normal = _values(surface.reflectance, wavelengths)
    tint = 1.0 if surface.edge is None else _values(surface.edge, wavelengths)
    schlick = normal + (1.0 - normal) * (1.0 - TINTED) ** 5
    base = surface.film.base
    real = None if base is None else evaluate_reflectance(base, wavelengths)
    index = metal_index(normal, schlick * tint, real)
    return reflectance(surface.film, index, cosine, wavelengths)


def film_on_glass(surface: Dielectric, index: float, make: TextureMaker) -> FilmOnGlass:
    """Return the film of a body of glass. ``index``: that kernels refract by. [-]"""

    def table(cosine, wavelengths):
        base = np.full_like(wavelengths, index)
        if surface.is_dispersive and surface.is_smooth:
            base = np.maximum(refractive_index(surface.ior, wavelengths), SMALLEST_INDEX)
        return reflectance(surface.film, base, cosine, wavelengths)

    width = None if surface.is_smooth else round(max(float(surface.roughness) ** 2, 1e-4), 6)
    return FilmOnGlass(_table(surface.film, table, make), width, index)


def lay_film(made: dict, film):
    """Return the plug-in of properties with a film on it."""
    plugin = mi.load_dict(made, optimize=False)
    plugin.set_film(film)
    return plugin


def _width(roughness: float) -> float:
    return round(float(np.clip(float(roughness) ** 2, MINIMUM_ALPHA, 1.0)), 4)


def _values(colour, wavelengths) -> np.ndarray:
    """Values of a colour by wavelength, of a picture those of its mean. [-]"""
    if isinstance(colour, ImageTexture):
        colour = Rgb(*(float(c) for c in np.broadcast_to(colour.mean(), 3)))
    return np.clip(evaluate_reflectance(colour, wavelengths), 0.0, 1.0)


def _table(film: Film, values, make: TextureMaker) -> np.ndarray:
    """Values at all cosines and wavelengths of a film's grid; in photometric variants their weighed mean. (n, m)"""
    film.check()
    cosine, wavelengths = grid(film)
    if is_spectral():
        return values(cosine[:, None], wavelengths)
    return make.weigh(values(cosine[:, None], GRID), GRID)
