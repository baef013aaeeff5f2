"""How much light surfaces send out at most of what comes from an angle, and what keeps sums of them from making light."""

from collections.abc import Callable

import numpy as np

from ..scene.colour import largest_of
from ..scene.material import (
    Black,
    Blend,
    Coated,
    Diffuse,
    Fabric,
    Glossy,
    Mix,
    Sheen,
    Surface,
    Toon,
    Transparent,
    blend_cosines,
)
from ..scene.texture import ImageTexture
from .facets import MINIMUM_ALPHA, cosines, directional_reflectance
from .fibres import sent_on


def most_sent_out(surface: Surface, of: Callable = largest_of) -> np.ndarray:
    """Bound on the share of light that is reflected and let through, 1 at most.

    Parameters
    ----------
    surface : Surface
    of : callable    From a colour to a number, or to numbers by the wavelength (k,).

    Returns
    -------
    (n, k) array    By `blend_cosines` of the eye, and by what ``of`` gives. [-]
    """
    cosine = blend_cosines()[:, None]
    match surface:
        case Black():
            share = 0.0
        case Diffuse() | Transparent() | Fabric():
            share = sum(map(of, surface.colours)) + getattr(surface, "openness", 0.0)
        case Coated() if surface.film is None:
            width = max(min(surface.roughness, 1.0) ** 2, MINIMUM_ALPHA)
            table = directional_reflectance(round(width, 4), round(max(surface.ior, 1.0001), 4))
            own = np.interp(np.sqrt(cosine), np.sqrt(cosines()), table)
            own = min(surface.specular, 1.0) * own
            share = own + (1.0 - own) * of(surface.reflectance)
        case Toon():
            share = of(surface.reflectance)
        case Sheen():
            is_even = not isinstance(surface.weight, ImageTexture)
            weight = min(max(surface.weight, 0.0), 1.0) if is_even else 1.0
            table = sent_on(round(float(surface.roughness), 4), surface.is_velvet)
            sent = weight * np.interp(np.sqrt(cosine), np.sqrt(cosines()), table)
            below = most_sent_out(surface.base, of)
            # Where fewer fibres are, more of the base shows.
            left = 1.0 - sent * min(largest_of(surface.tint), 1.0) if is_even else 1.0
            share = sent * of(surface.tint) + left * below
        case Glossy() if surface.film is None and (surface.edge is None or surface.is_mirror):
            share = of(surface.reflectance)
        case Mix():
            first, second = most_sent_out(surface.first, of), most_sent_out(surface.second, of)
            if isinstance(surface.factor, ImageTexture):
                share = np.maximum(first, second)
            else:
                share = first + min(max(surface.factor, 0.0), 1.0) * (second - first)
        case Blend():
            share = _total(surface, of).max(axis=0)
        case _:
            share = 1.0
    share = np.minimum(share, 1.0)
    return np.broadcast_to(share, np.broadcast_shapes(np.shape(share), cosine.shape))


def limits(blend: Blend, of: Callable) -> tuple[np.ndarray, np.ndarray]:
    """Return factors with which a blend sends out no more than comes.

    Returns
    -------
    (k,) array, (2, 512) array    By what ``of`` gives, and by side and `blend_cosines`; 1 where nothing is too much. [-]
    """
    total = _total(blend, of)
    colour = 1.0 / np.maximum(total[:, -1].max(axis=0), 1.0)
    return colour, 1.0 / np.maximum((total * colour).max(axis=2), 1.0)


def _total(blend: Blend, of: Callable) -> np.ndarray:
    """What both parts together send out by side, cosine and what ``of`` gives. (2, n, k)"""
    first, second = (most_sent_out(part, of) for part in (blend.first, blend.second))
    return blend.weights[:, 0, :, None] * first + blend.weights[:, 1, :, None] * second
