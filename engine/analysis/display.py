"""From photometric numbers to the pixels of a live view."""

import numpy as np

from ..photometry.colour import automatic_white, scene_linear
from .false_colour import colours, nice_maximum

DECADES = 3.0
"""Range of a logarithmic scale whose lower end is not stated."""


def show(image: np.ndarray, mode: str, display) -> dict:
    """Turn an image into pixels.

    Parameters
    ----------
    image : (h, w, c) float32 array    X, Y, Z [cd/m2] and, for false colours of it, illuminance [lx].
    mode : str    Value of a `session.DisplayMode`.
    display : session.Display

    Returns
    -------
    dict    The fields ``pixels``, ``is_display_referred``, ``low``, ``high`` and ``unit`` of `session.Frame`.
    """
    luminance = image[..., 1]
    pixels = np.ones((*luminance.shape, 4), dtype=np.float32)
    if mode.startswith("false"):
        values, unit = (luminance, "cd/m²") if mode == "false_luminance" else (image[..., 3], "lx")
        high = display.high if display.high > 0.0 else nice_maximum(values)
        low = min(display.low, high)
        if display.logarithmic:
            low = low if low > 0.0 else high / 10.0**DECADES
            share = np.log10(np.maximum(values, low) / low) / max(np.log10(high / low), 1e-9)
            pixels[..., :3] = colours(share, 0.0, 1.0) / np.float32(255.0)
        else:
            pixels[..., :3] = colours(values, low, high) / np.float32(255.0)
        return _fields(pixels, True, display.logarithmic, low, high, unit)
    white = display.white if display.white else automatic_white(luminance)
    if mode == "luminance":
        pixels[..., :3] = (luminance / np.float32(white))[..., None]
    else:
        pixels[..., :3] = scene_linear(image[..., :3], white)
    return _fields(pixels, False, False, 0.0, white, "cd/m²")


def _fields(pixels, is_display_referred, is_logarithmic, low, high, unit) -> dict:
    return {
        "pixels": pixels,
        "is_display_referred": is_display_referred,
        "is_logarithmic": is_logarithmic,
        "low": float(low),
        "high": float(high),
        "unit": unit,
    }
