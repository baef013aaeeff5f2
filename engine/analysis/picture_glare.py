"""Glare of a luminance picture: daylight glare probability and index, unified glare rating, veiling luminance."""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .glare_sources import THRESHOLD, GlareSources, find_sources
from .picture_view import PictureView

LARGEST_INDEX = 16.0
"""Of positions: farther out sources do not disturb less. [-]"""

NEAREST = 0.1
"""Angle to the line of sight below which a source veils no more than at it. [degree] (CIE 146:2002)"""


@dataclass(frozen=True, eq=False)
class PictureGlare:
    """Glare of what an eye sees that looks along a picture's axis.

    Parameters
    ----------
    illuminance : float    At the eye, on the plane across the line of sight; of what the picture shows. [lx]
    direct_illuminance : float    Part of the sources. [lx]
    background : float    Background luminance: the rest over pi. [cd/m2]
    mean : float    Mean luminance over the solid angle. [cd/m2]
    solid_angle : float    That counts: what the picture shows before the eye. [sr]
    dgp : float    Daylight glare probability. [-]
    dgi : float or None    Daylight glare index; None without a source. [-]
    ugr : float or None    Unified glare rating; None without a source or a background. [-]
    veiling : float    Equivalent veiling luminance of the sources. [cd/m2]
    sources : GlareSources
    indices : (n,) float64 array    Position indices of the sources. [-]
    """

    illuminance: float
    direct_illuminance: float
    background: float
    mean: float
    solid_angle: float
    dgp: float
    dgi: float | None
    ugr: float | None
    veiling: float
    sources: GlareSources
    indices: np.ndarray


def rate_picture(
    luminance: np.ndarray,
    view: PictureView,
    threshold: float = THRESHOLD,
    undimmed: np.ndarray | None = None,
) -> PictureGlare:
    """Rate the glare of a picture.

    Parameters
    ----------
    luminance : (h, w) array    Row 0 is the bottom row; finite and not negative. [cd/m2]
    view : PictureView    Of this size.
    threshold : float    Luminance above which pixels are part of sources. [cd/m2]
    undimmed : (c, h, w) array or None    By which they are told instead, as of `glare_sources.find_sources`. [cd/m2]

    Raises
    ------
    SceneError    The picture is not of the view's size, is dark or holds what is no luminance, or the threshold is not
        above 0.

    References
    ----------
    DGP: J. Wienold, J. Christoffersen, Energy and Buildings 38, 2006, 743-757, doi:10.1016/j.enbuild.2006.03.017;
    DGI: R. G. Hopkinson, Applied Ergonomics 3, 1972, 206-215, with solid angles weighed by position; UGR: CIE 117:1995;
    veiling luminance: CIE 146:2002, 10 E / theta^2; positions below the line of sight: CIE 205:2013.
    """
    luminance = np.asarray(luminance, dtype=np.float64)
    if luminance.shape != (view.height, view.width):
        raise SceneError("the picture is not of the size of its view")
    if not (np.isfinite(luminance) & (luminance >= 0.0)).all():
        raise SceneError("the picture holds values that are no luminances")
    if not (np.isfinite(threshold) and threshold > 0.0):
        raise SceneError("the threshold of glare sources must be a luminance above 0")
    directions, solid = view.pixels()
    # What is behind the eye does not count.
    solid = np.where(directions[..., 2] <= 0.0, solid, 0.0)
    cosine = np.maximum(-directions[..., 2], 0.0)
    illuminance = float((solid * cosine * luminance).sum())
    if illuminance <= 0.0:
        raise SceneError("the picture is dark, so there is no glare to rate")
    sources = find_sources(luminance, view, directions, solid, threshold, undimmed)
    indices = position_indices(sources.directions)
    direct = float(sources.illuminances.sum())
    background = max(illuminance - direct, 0.0) / np.pi
    seen = float(solid.sum())
    return PictureGlare(
        illuminance,
        direct,
        background,
        float((solid * luminance).sum()) / seen,
        seen,
        _dgp(illuminance, sources, indices),
        _dgi(background, sources, indices),
        _ugr(background, sources, indices),
        _veiling(sources),
        sources,
        indices,
    )


def position_indices(directions: np.ndarray) -> np.ndarray:
    """Position indices of directions before the eye, above the line of sight after Guth, below it after Iwata.

    Parameters
    ----------
    directions : (n, 3) array    In a picture's axes, of unit length.

    Returns
    -------
    (n,) float64 array    1 to `LARGEST_INDEX`. [-]
    """
    x, y, depth = directions[:, 0], directions[:, 1], -directions[:, 2]
    off = np.degrees(np.arctan2(np.hypot(x, y), depth))
    turn = np.degrees(np.arctan2(np.abs(x), y))
    first = (35.2 - 0.31889 * turn - 1.22 * np.exp(-2.0 * turn / 9.0)) * 1e-3
    second = (21.0 + 0.26667 * turn - 0.002963 * turn**2) * 1e-5
    above = first * off + second * off**2
    squeezed = np.sqrt(1.0 + 0.3225 * np.cos(np.radians(turn)) ** 2)
    low = np.degrees(np.arctan2(np.hypot(x, y) * squeezed, depth))
    below = 6.49e-3 * low + 21e-5 * low**2
    return np.minimum(np.exp(np.where(y >= 0.0, above, below)), LARGEST_INDEX)


def _dgp(illuminance: float, sources: GlareSources, indices: np.ndarray) -> float:
    contrast = np.sum(sources.luminances**2 * sources.solid_angles / indices**2)
    log = np.log10(1.0 + contrast / illuminance**1.87)
    return float(min(5.87e-5 * illuminance + 9.18e-2 * log + 0.16, 1.0))


def _dgi(background: float, sources: GlareSources, indices: np.ndarray) -> float | None:
    solid, luminances = sources.solid_angles, sources.luminances
    if not len(solid):
        return None
    adapted = background + 0.07 * np.sqrt(solid) * luminances
    return float(
        10.0 * np.log10(np.sum(0.478 * luminances**1.6 * (solid / indices**2) ** 0.8 / adapted))
    )


def _ugr(background: float, sources: GlareSources, indices: np.ndarray) -> float | None:
    if not len(sources.luminances) or background <= 0.0:
        return None
    amount = np.sum(sources.luminances**2 * sources.solid_angles / indices**2)
    return float(8.0 * np.log10(0.25 / background * amount)) if amount > 0.0 else None


def _veiling(sources: GlareSources) -> float:
    off = np.degrees(np.arccos(np.clip(-sources.directions[:, 2], -1.0, 1.0)))
    return float(np.sum(10.0 * sources.illuminances / np.maximum(off, NEAREST) ** 2))
