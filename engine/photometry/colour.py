"""From X, Y, Z to the scene-linear picture, to chromaticities and to L*a*b*."""

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


def tristimulus_of(linear, white_luminance: float) -> np.ndarray:
    """X, Y, Z of scene-linear Rec. 709 in which a D65 white of ``white_luminance`` is (1, 1, 1). (..., 3) [cd/m2]"""
    to_xyz = (np.linalg.inv(XYZ_TO_REC709).T * white_luminance).astype(np.float32)
    return np.asarray(linear, dtype=np.float32) @ to_xyz


def automatic_white(luminance) -> float:
    """White luminance that puts the picture's logarithmic mean at middle grey. [cd/m2 -> cd/m2]"""
    seen = np.asarray(luminance)[np.asarray(luminance) > 0.0]
    if seen.size == 0:
        return 1.0
    return float(np.exp(np.mean(np.log(seen))) / MIDDLE_GREY)


def chromaticity(tristimulus) -> np.ndarray:
    """Chromaticity coordinates x, y. (CIE 15:2018, 7.2)

    Parameters
    ----------
    tristimulus : (..., 3) array    X, Y, Z on any scale.

    Returns
    -------
    (..., 2) float64 array    NaN where X + Y + Z is 0, as black has no chromaticity. [-]
    """
    tristimulus = np.asarray(tristimulus, dtype=np.float64)
    total = tristimulus.sum(axis=-1, keepdims=True)
    return tristimulus[..., :2] / np.where(total == 0.0, np.nan, total)


def cie_lab(tristimulus, white) -> np.ndarray:
    """CIE 1976 L*, a*, b*. (CIE 15:2018, 8.2.1)

    Parameters
    ----------
    tristimulus : (..., 3) array    X, Y, Z of the samples.
    white : (3,) array    X, Y, Z of the white that they are seen against, on the same scale, all above 0.

    Returns
    -------
    (..., 3) float64 array    [-]
    """
    ratio = np.asarray(tristimulus, dtype=np.float64) / np.asarray(white, dtype=np.float64)
    # Below the bend the cube root is continued by its tangent.
    bend = 24.0 / 116.0
    x, y, z = np.moveaxis(
        np.where(
            ratio > bend**3,
            np.cbrt(ratio),
            ratio / (3.0 * bend**2) + 16.0 / 116.0,
        ),
        -1,
        0,
    )
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=-1)


def colour_difference(first, second) -> np.ndarray:
    """CIE 1976 colour difference Delta E*ab. (CIE 15:2018, 8.2.1)

    Parameters
    ----------
    first, second : (..., 3) array    L*, a*, b*. [-]

    Returns
    -------
    (...) float64 array    [-]
    """
    return np.linalg.norm(np.asarray(first, dtype=np.float64) - np.asarray(second), axis=-1)
