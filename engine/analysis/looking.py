"""Pictures made for looking at: their noise is filtered, in a copy, and it is told how."""

from dataclasses import dataclass

import numpy as np

from ..errors import LumenrayError
from . import denoiser
from .block_means import keep_means

WORDS = f"denoised by {denoiser.NAME}"
"""What such a picture says of itself."""


@dataclass(frozen=True)
class Filtered:
    """A filtered copy.

    Parameters
    ----------
    colour : (h, w, 3) float32 array    Linear Rec. 709.
    words : str    How it was filtered, for people; empty: it is as computed.
    problem : str    Why it was not filtered, one sentence; empty if it was.
    """

    colour: np.ndarray
    words: str
    problem: str = ""


def filter_noise(colour, picture, is_blurred: bool = False) -> Filtered:
    """Filter a picture's noise by Open Image Denoise, but keep the mean luminance of its blocks.

    Parameters
    ----------
    colour : (h, w, 3) array    What is shown of the picture: linear Rec. 709, in any unit.
    picture : views.Picture    With guides.
    is_blurred : bool    Whether the camera's lens blurs, so that the guides have noise of their own.

    Returns
    -------
    Filtered    Where Open Image Denoise is not installed or does not work, the picture as it is, and the problem is told.
    """
    guides = picture.denoising_normal, picture.denoising_albedo
    try:
        made = denoiser.denoise(colour, *guides, has_noisy_guides=is_blurred)
    except LumenrayError as error:
        return Filtered(np.asarray(colour), "", f"{error}; the picture is shown as computed")
    return Filtered(keep_means(made, np.asarray(colour)), WORDS)


def denoise_charts(colour: np.ndarray, covered: np.ndarray, chart: np.ndarray) -> np.ndarray:
    """Return a denoised copy of light on surfaces whose charts keep their means.

    Parameters
    ----------
    colour : (h, w, 3) array    X, Y, Z.
    covered : (h, w) bool array    Lumels that were computed; others count for no mean.
    chart : (h, w) int array    Number of the chart.

    Returns
    -------
    (h, w, 3) float32 array

    Raises
    ------
    DenoiserError    Open Image Denoise is not installed, or it could not do it.
    """
    # X, Y, Z of light are never negative as colours of a display can be, and to the filter they are three bands as well.
    made = denoiser.denoise_map(colour)
    number = chart[covered]
    wanted, found = (np.bincount(number, each[covered][:, 1]) for each in (colour, made))
    factor = np.divide(wanted, found, out=np.ones_like(wanted), where=found > 0.0)
    made[covered] *= factor[number].astype(np.float32)[:, None]
    return made
