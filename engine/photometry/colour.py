"""From X, Y, Z to the scene-linear picture and back."""

import numpy as np

XYZ_TO_REC709 = np.array(
    [
        [3.2404541621, -1.5371385128, -0.4985314096],
        [-0.9692660305, 1.8760108454, 0.0415560175],
        [0.0556434310, -0.2040259135, 1.0572251882],
    ]
)
"""Linear Rec. 709 with D65 white from CIE XYZ. (IEC 61966-2-1 primaries and white x = 0.3127, y = 0.3290)"""

REC709_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Luminance of linear Rec. 709 components. (ITU-R BT.709)"""

MIDDLE_GREY = 0.18
"""Where the automatic exposure puts the logarithmic mean luminance."""


def scene_linear(tristimulus, white_luminance):
    """Scene-linear Rec. 709 in which a D65 white of ``white_luminance`` is (1, 1, 1).

    Parameters
    ----------
    tristimulus : (..., 3) array    X, Y, Z. [cd/m2]
    white_luminance : float    [cd/m2]

    Returns
    -------
    (..., 3) float32 array    Negative components of colours outside the gamut are kept. [-]
    """
    to_linear = (XYZ_TO_REC709.T / white_luminance).astype(np.float32)
    return np.asarray(tristimulus, dtype=np.float32) @ to_linear


def automatic_white(luminance) -> float:
    """White luminance that puts the picture's logarithmic mean at middle grey. [cd/m2 -> cd/m2]"""
    seen = np.asarray(luminance)[np.asarray(luminance) > 0.0]
    if seen.size == 0:
        return 1.0
    return float(np.exp(np.mean(np.log(seen))) / MIDDLE_GREY)
