"""From scene-linear colours to the codes of an 8-bit picture."""

import numpy as np


def limit_to_white(linear: np.ndarray) -> np.ndarray:
    """Bring colours into 0..1: what has all components there stays as it is, 1 stays 1, and brighter keeps its hue.

    Parameters
    ----------
    linear : (..., 3) array    Scene-linear Rec. 709. Negative components of colours outside the gamut become 0.

    Returns
    -------
    (..., 3) array    Colours whose largest component was above 1 are divided by it.
    """
    positive = np.maximum(linear, 0.0)
    return positive / np.maximum(positive.max(axis=-1, keepdims=True), 1.0)


def encode_srgb(linear: np.ndarray) -> np.ndarray:
    """Codes 0..255 of linear values 0..1 by the transfer function of sRGB (IEC 61966-2-1). (...) -> (...) uint8"""
    x = np.clip(linear, 0.0, 1.0)
    encoded = np.where(
        x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 0.0031308) ** (1.0 / 2.4) - 0.055
    )
    return np.round(255.0 * encoded).astype(np.uint8)
