"""A picture without its bright sources: clipped where they are, so that picture and lights give together what it gave."""

import numpy as np

from ..photometry.colour import REC709_LUMINANCE
from ..scene.memo import recall_latest
from ..scene.texture import ImageTexture
from ..sky.picture import clean
from .sources import Coefficients, Search, find_sources


def clip_sources(image: ImageTexture, coefficients: Coefficients | None = None) -> ImageTexture:
    """Return a picture whose bright sources are clipped to the least luminance that belongs to them, in their colour.

    What is taken away is the `irradiance` of the sources: the illuminance of every plane that all of a source can be seen
    from, the horizontal one among them, is that of the picture before, to the rounding of its numbers.

    Parameters
    ----------
    image : ImageTexture    Equirectangular.
    coefficients : Coefficients or None    As of `find_sources`.

    Returns
    -------
    ImageTexture    The same where there are no sources.
    """
    search = find_sources(image, coefficients)
    if not search.sources:
        return image
    state = (image.interpolation, coefficients or Coefficients())
    (pixels,) = recall_latest(
        image.pixels, "clipped", (), state, lambda: (scale_sources(image, search, 0.0),)
    )
    return ImageTexture(pixels, interpolation=image.interpolation, name=image.name)


def scale_sources(image: ImageTexture, search: Search, factors) -> np.ndarray:
    """Return a picture's pixels with what its sources have above their edge multiplied.

    Parameters
    ----------
    image : ImageTexture
    search : Search    Of this picture.
    factors : float or sequence of float    For all of them, or for each.

    Returns
    -------
    (height, width, channels) float32 array
    """
    cleaned = clean(image.pixels)
    pixels = np.array(cleaned) if np.may_share_memory(cleaned, image.pixels) else cleaned
    if np.ndim(factors) == 0:
        factors = [factors] * len(search.sources)
    for source, factor in zip(search.sources, factors, strict=True):
        held = pixels[source.rows, source.columns].astype(np.float64)
        luminance = held @ _weights(held.shape[1])
        base = held * (search.edge / luminance)[:, None]
        pixels[source.rows, source.columns] = base + (held - base) * factor
    return pixels


def _weights(channels: int) -> np.ndarray:
    return REC709_LUMINANCE if channels == 3 else np.ones(1)
