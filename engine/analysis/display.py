"""From photometric numbers to the pixels of a live view."""

import numpy as np

from ..photometry.colour import automatic_white, scene_linear, tristimulus_of
from .false_colour import colours, nice_maximum
from .tone import encode_srgb
from .tone_operators import OPERATORS, STATEMENT, apply_operator, legend_range
from .view_marks import find_marks

DECADES = 3.0
"""Range of a logarithmic scale whose lower end is not stated."""


def _make_scale() -> np.ndarray:
    """Colours of the false-colour scale at even steps, with opacity. (4096, 4) float32"""
    scale = np.ones((4096, 4), dtype=np.float32)
    scale[:, :3] = colours(np.linspace(0.0, 1.0, len(scale)), 0.0, 1.0) / np.float32(255.0)
    return scale


SCALE = _make_scale()


GREYS = 64
"""Steps of the legend of tone operators."""


def show(
    image: np.ndarray,
    display,
    denoised=None,
    view=None,
    noise: float = np.inf,
    size: tuple[int, int] | None = None,
) -> dict:
    """Turn an image into pixels.

    Parameters
    ----------
    image : (h, w, c) float32 array    X, Y, Z [cd/m2] and, for false colours of it, illuminance [lx].
    display : views.Display
    denoised : (h, w, 3) array or None
        Copy without noise that a picture shows instead, linear Rec. 709, 1 at 1 cd/m2; the image alone decides on its white.
    view : PictureView or None    How the image was taken, for what eyes see of it.
    noise : float    Relative standard error of its pixels, infinite while unknown. [-]
    size : (int, int) or None    Of the view, whose image may be coarse: width and height; None: the image's. [pixel]

    Returns
    -------
    dict    The fields ``pixels``, ``is_display_referred``, ``low``, ``high`` and ``unit`` of `views.Frame`, of
        tone operators ``greys`` and ``statement`` too, and of false colours with lines or values what these are.
    """
    mode, luminance = display.mode.value, image[..., 1]
    if mode in OPERATORS:
        light = image[..., :3] if denoised is None else tristimulus_of(denoised, 1.0)
        return _show_toned(apply_operator(mode, light, view))
    if mode.startswith("false"):
        values, unit = (luminance, "cd/m²") if mode == "false_luminance" else (image[..., 3], "lx")
        high = display.high if display.high > 0.0 else nice_maximum(values)
        low = min(display.low, high)
        if display.logarithmic:
            low = low if low > 0.0 else high / 10.0**DECADES
            share = np.log10(np.maximum(values, low) / low) / max(np.log10(high / low), 1e-9)
        else:
            share = (values - low) / max(high - low, 1e-30)
        # A table of colours is an order of magnitude faster than mixing them for every pixel.
        place = np.clip(np.nan_to_num(share) * (len(SCALE) - 1) + 0.5, 0, len(SCALE) - 1)
        pixels = SCALE[place.astype(np.int32)]
        made = _fields(pixels, True, display.logarithmic, low, high, unit)
        if display.lines or display.values:
            size = size or values.shape[::-1]
            marks = find_marks(np.nan_to_num(values), noise, size, display.lines, display.values)
            made |= {name: getattr(marks, name) for name in ("lines", "labels", "values")}
            made["statement"] = marks.words
        return made
    pixels = np.ones((*luminance.shape, 4), dtype=np.float32)
    white = display.white if display.white else automatic_white(luminance)
    if mode == "luminance":
        pixels[..., :3] = (luminance / np.float32(white))[..., None]
    elif denoised is not None:
        pixels[..., :3] = denoised / np.float32(white)
    else:
        pixels[..., :3] = scene_linear(image[..., :3], white)
    return _fields(pixels, False, False, 0.0, white, "cd/m²")


def _show_toned(toned) -> dict:
    """Turn a picture for looking into display colours, with its legend and its statement."""
    pixels = np.ones((*toned.colour.shape[:2], 4), dtype=np.float32)
    pixels[..., :3] = encode_srgb(toned.colour) / np.float32(255.0)
    low, high = legend_range(toned.curve)
    greys = encode_srgb(toned.curve(np.geomspace(low, high, GREYS))) / np.float32(255.0)
    more = {"greys": greys, "statement": f"{STATEMENT}; {toned.words}"}
    return _fields(pixels, True, True, low, high, "cd/m²") | more


def _fields(pixels, is_display_referred, is_logarithmic, low, high, unit) -> dict:
    return {
        "pixels": pixels,
        "is_display_referred": is_display_referred,
        "is_logarithmic": is_logarithmic,
        "low": float(low),
        "high": float(high),
        "unit": unit,
    }
