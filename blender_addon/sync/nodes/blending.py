"""How two colours are blended and how one is changed: the arithmetic of Blender's colour nodes.

Colours are arrays whose last axis holds red, green and blue, or one channel for a grey.

References
----------
Blender source, ``intern/cycles/kernel/svm/mix.h``, ``color_util.h`` and ``brightness.h``: the
formulas are the definition of the nodes.
"""

import numpy as np

from .fields import rgb


def blend(mode: str, factor, first, second) -> np.ndarray:
    """Blend `second` over `first` as Blender's Mix node does.

    Parameters
    ----------
    mode : str    Blender's identifier, such as ``MULTIPLY``.
    factor : array    Share of the effect. [-]
    first, second : arrays    Colours; they broadcast.
    """
    if mode in _BY_CHANNEL:
        return _BY_CHANNEL[mode](factor, first, second)
    return _BY_HUE[mode](factor, rgb(first), rgb(second))


def _lerp(first, second, factor):
    return first * (1 - factor) + second * factor


def _burn(t, a, b):
    base = 1 - t + t * b
    burnt = 1 - (1 - a) / np.where(base > 0, base, 1)
    return np.where(base > 0, np.clip(burnt, 0, 1), 0)


def _dodge(t, a, b):
    base = 1 - t * b
    dodged = np.minimum(a / np.where(base > 0, base, 1), 1)
    return np.where(a == 0, 0, np.where(base > 0, dodged, 1))


def _overlay(t, a, b):
    dark = a * (1 - t + 2 * t * b)
    light = 1 - (1 - t + 2 * t * (1 - b)) * (1 - a)
    return np.where(a < 0.5, dark, light)


def _soft_light(t, a, b):
    screen = 1 - (1 - b) * (1 - a)
    return (1 - t) * a + t * ((1 - a) * b * a + a * screen)


def _divide(t, a, b):
    return np.where(b != 0, (1 - t) * a + t * a / np.where(b != 0, b, 1), a)


_BY_CHANNEL = {
    "MIX": lambda t, a, b: _lerp(a, b, t),
    "DARKEN": lambda t, a, b: _lerp(a, np.minimum(a, b), t),
    "MULTIPLY": lambda t, a, b: _lerp(a, a * b, t),
    "BURN": _burn,
    "LIGHTEN": lambda t, a, b: _lerp(a, np.maximum(a, b), t),
    "SCREEN": lambda t, a, b: 1 - (1 - t + t * (1 - b)) * (1 - a),
    "DODGE": _dodge,
    "ADD": lambda t, a, b: _lerp(a, a + b, t),
    "OVERLAY": _overlay,
    "SOFT_LIGHT": _soft_light,
    "LINEAR_LIGHT": lambda t, a, b: a + t * (2 * b - 1),
    "DIFFERENCE": lambda t, a, b: _lerp(a, np.abs(a - b), t),
    "EXCLUSION": lambda t, a, b: np.maximum(_lerp(a, a + b - 2 * a * b, t), 0),
    "SUBTRACT": lambda t, a, b: _lerp(a, a - b, t),
    "DIVIDE": _divide,
}


def _hue(t, a, b):
    hsv_a, hsv_b = rgb_to_hsv(a), rgb_to_hsv(b)
    mixed = hsv_to_rgb(np.concatenate([hsv_b[..., :1], hsv_a[..., 1:]], axis=-1))
    return np.where(hsv_b[..., 1:2] != 0, _lerp(a, mixed, t), a)


def _saturation(t, a, b):
    hsv_a, hsv_b = np.broadcast_arrays(rgb_to_hsv(a), rgb_to_hsv(b))
    saturation = _lerp(hsv_a[..., 1:2], hsv_b[..., 1:2], t)
    mixed = np.concatenate(np.broadcast_arrays(hsv_a[..., :1], saturation, hsv_a[..., 2:]), axis=-1)
    return np.where(hsv_a[..., 1:2] != 0, hsv_to_rgb(mixed), a)


def _value(t, a, b):
    hsv_a, hsv_b = np.broadcast_arrays(rgb_to_hsv(a), rgb_to_hsv(b))
    value = _lerp(hsv_a[..., 2:], hsv_b[..., 2:], t)
    return hsv_to_rgb(
        np.concatenate(np.broadcast_arrays(hsv_a[..., :1], hsv_a[..., 1:2], value), axis=-1)
    )


def _colour(t, a, b):
    hsv_a, hsv_b = np.broadcast_arrays(rgb_to_hsv(a), rgb_to_hsv(b))
    mixed = hsv_to_rgb(np.concatenate([hsv_b[..., :2], hsv_a[..., 2:]], axis=-1))
    return np.where(hsv_b[..., 1:2] != 0, _lerp(a, mixed, t), a)


_BY_HUE = {"HUE": _hue, "SATURATION": _saturation, "VALUE": _value, "COLOR": _colour}


def rgb_to_hsv(colour) -> np.ndarray:
    """Turn linear colours (..., 3) into hue, saturation and value."""
    largest, span = colour.max(axis=-1), np.ptp(colour, axis=-1)
    saturation = np.divide(span, largest, out=np.zeros_like(span), where=largest != 0)
    return np.stack([_hue_of(colour, largest, span), saturation, largest], axis=-1)


def rgb_to_hsl(colour) -> np.ndarray:
    """Turn linear colours (..., 3) into hue, saturation and lightness."""
    largest, span = colour.max(axis=-1), np.ptp(colour, axis=-1)
    lightness = largest - span / 2
    base = np.where(lightness > 0.5, 2 - 2 * lightness, 2 * lightness)
    saturation = np.divide(span, base, out=np.zeros_like(span), where=(span != 0) & (base != 0))
    return np.stack([_hue_of(colour, largest, span), saturation, np.minimum(lightness, 1)], axis=-1)


def _hue_of(colour, largest, span):
    red, green, blue = np.moveaxis(colour, -1, 0)
    base = np.where(span > 0, span, 1)
    sector = np.where(
        red == largest,
        (green - blue) / base,
        np.where(green == largest, 2 + (blue - red) / base, 4 + (red - green) / base),
    )
    return np.where(span > 0, np.mod(sector / 6, 1.0), 0.0)


def hsv_to_rgb(hsv) -> np.ndarray:
    """Turn hue, saturation and value (..., 3) into linear colours."""
    return hsv[..., 2:] * (1 - hsv[..., 1:2] + hsv[..., 1:2] * _pure_hue(hsv[..., 0]))


def hsl_to_rgb(hsl) -> np.ndarray:
    """Turn hue, saturation and lightness (..., 3) into linear colours."""
    chroma = (1 - np.abs(2 * hsl[..., 2:] - 1)) * hsl[..., 1:2]
    return (_pure_hue(hsl[..., 0]) - 0.5) * chroma + hsl[..., 2:]


def _pure_hue(hue):
    around = np.mod(hue, 1.0) * 6
    red = np.abs(around - 3) - 1
    green = 2 - np.abs(around - 2)
    blue = 2 - np.abs(around - 4)
    return np.clip(np.stack([red, green, blue], axis=-1), 0, 1)


def shift_hue(colour, hue, saturation, value, factor) -> np.ndarray:
    """Apply the Hue/Saturation/Value node; 0.5, 1 and 1 leave a colour as it is."""
    colour = rgb(colour)
    hsv = rgb_to_hsv(colour)
    parts = np.broadcast_arrays(
        np.mod(hsv[..., :1] + hue + 0.5, 1.0),
        np.clip(hsv[..., 1:2] * saturation, 0, 1),
        hsv[..., 2:] * value,
    )
    shifted = hsv_to_rgb(np.concatenate(parts, axis=-1))
    return np.maximum(_lerp(colour, shifted, factor), 0)


def adjust_contrast(colour, brightness, contrast) -> np.ndarray:
    """Apply the Brightness/Contrast node."""
    return np.maximum((1 + contrast) * colour + brightness - contrast * 0.5, 0)
