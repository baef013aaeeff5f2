"""Thin films of shader nodes."""

import numpy as np

from ....engine.scene.film import Film
from ....engine.scene.spectrum import Tabulated
from ..nodes.fields import Field
from ..nodes.graph import find_socket

THINNEST = 0.1
"""Thickness up to which Blender sees no film. [nm]"""

PRIMARIES = (465.0, 545.0, 610.0)
"""Wavelengths that blue, green and red of a refractive index stand for. [nm]"""


def find_film(at, base: Tabulated | None = None) -> Film | None:
    """Return the film on a shader's surface; None: there is none.

    Parameters
    ----------
    at : Inputs
    base : Tabulated or None    As of `Film`.
    """
    if find_socket(at.node.inputs, "Thin Film Thickness") is None:
        return None
    if at("Thin Film Thickness").is_everywhere(0):
        return None
    thickness = at.plain("Thin Film Thickness")
    if thickness <= THINNEST:
        return None
    return Film(thickness, max(at.plain("Thin Film IOR"), 1.0), base)


def index_of_metal(at) -> Tabulated:
    """Return the real part of a metal's refractive index by the three numbers of a Metallic BSDF."""
    field = at("IOR").settled()
    if not field.is_constant:
        at.note("The refractive index varies over the surface", "its mean is used")
    red, green, blue = field.mean()
    values = np.maximum([blue, green, red], 1e-3).astype(np.float64)
    return Tabulated(np.array(PRIMARIES), values)


def mean_below_film(at, colour: Field, film: Film | None) -> Field:
    """Return a colour of a metal as it is, or its mean where a film lies on it."""
    colour = colour if film is None else colour.settled()
    if film is None or colour.is_constant:
        return colour
    at.note("The colour of a metal below a thin film varies over the surface", "its mean is used")
    return Field(colour.mean())


def tell_film_on_glass(at, film: Film | None) -> None:
    """Say that light from inside meets another film in Blender."""
    if film is not None:
        at.remark(
            "Blender takes a thin film for thinner when light meets it from inside the glass",
            "it is the same film from both sides",
        )
