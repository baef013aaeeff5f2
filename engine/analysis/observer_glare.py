"""Glare of an observer from several pictures of the same view, with errors: noise, and what pixels at edges change."""

from dataclasses import replace

import numpy as np

from ..errors import SceneError
from .glare_sources import THRESHOLD
from .picture_glare import PictureGlare, rate_picture
from .picture_view import PictureView

FIGURES = ("ugr", "dgp", "dgi", "illuminance", "background", "veiling")
"""Of `PictureGlare`."""

DOUBT = 0.5
"""Share of what is added for finer pixels that counts as an error of it. [-]"""


def rate_observer(
    pictures: np.ndarray,
    view: PictureView,
    threshold: float = THRESHOLD,
    undimmed: np.ndarray | None = None,
) -> dict[str, tuple[float, float]]:
    """Rate what an observer sees.

    Parameters
    ----------
    pictures : (k, h, w) array    At least two, with independent noise; width and height even. [cd/m2]
    view : PictureView    Of all of them.
    threshold : float    [cd/m2]
    undimmed : (k, c, h, w) array or None
        By which glare sources are told instead, as of `glare_sources.find_sources`, of each picture. [cd/m2]

    Returns
    -------
    dict of str to (float, float)
        By `FIGURES`: value and standard error, in the units of `PictureGlare`; NaN where one has no meaning.

    Raises
    ------
    SceneError    As of `rate_picture`, or the size is odd.

    Notes
    -----
    A pixel at the edge of a source sees some of it and some of what is beside: it is darker, dilutes the source or counts to
    the background. That changes figures in proportion to the size of pixels, so they are found with pixels of twice the size
    too, and carried on to none; half of what is added is held by the errors. Sources need a few pixels for that.
    """
    pictures = np.asarray(pictures, dtype=np.float64)
    if view.width % 2 or view.height % 2:
        raise SceneError("the pictures of an observer need an even width and height")
    full = [None] * len(pictures) if undimmed is None else undimmed
    full_mean = None if undimmed is None else np.mean(undimmed, axis=0, dtype=np.float64)
    mean = _refine(pictures.mean(axis=0), view, threshold, full_mean)
    parts = [
        _refine(each, view, threshold, its)[0] for each, its in zip(pictures, full, strict=True)
    ]
    found = {}
    for name in FIGURES:
        apart = np.array([each[name] for each in parts])
        noise = float(apart.std(ddof=1)) / np.sqrt(len(parts))
        found[name] = (mean[0][name], float(np.hypot(noise, DOUBT * abs(mean[1][name]))))
    return found


def _refine(picture, view: PictureView, threshold: float, undimmed) -> tuple[dict, dict]:
    """Figures carried on to pixels without a size, and what that has added."""
    coarse = replace(view, width=view.width // 2, height=view.height // 2)
    fine = _figures(rate_picture(picture, view, threshold, undimmed))
    full = None if undimmed is None else _halve(undimmed)
    rough = _figures(rate_picture(_halve(picture), coarse, threshold, full))
    added = {name: np.nan_to_num(fine[name] - rough[name]) for name in FIGURES}
    found = {name: fine[name] + added[name] for name in FIGURES}
    return {name: _held(name, value) for name, value in found.items()}, added


def _halve(pictures: np.ndarray) -> np.ndarray:
    """Means of two by two pixels. (..., h, w) -> (..., h / 2, w / 2)"""
    *more, height, width = pictures.shape
    return pictures.reshape(*more, height // 2, 2, width // 2, 2).mean(axis=(-3, -1))


def _held(name: str, value: float) -> float:
    """Ratings can be below 0, amounts of light cannot."""
    return value if name in {"ugr", "dgi"} or np.isnan(value) else max(value, 0.0)


def _figures(made: PictureGlare) -> dict[str, float]:
    values = {name: getattr(made, name) for name in FIGURES}
    return {name: np.nan if value is None else float(value) for name, value in values.items()}
