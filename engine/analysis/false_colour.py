"""Pictures of maps: false colours with a legend in the map's unit, and display pictures."""

from pathlib import Path

import numpy as np

STOPS = np.array(
    [
        [0.050, 0.030, 0.200],
        [0.120, 0.150, 0.560],
        [0.070, 0.400, 0.720],
        [0.060, 0.620, 0.560],
        [0.360, 0.760, 0.300],
        [0.850, 0.830, 0.180],
        [0.980, 0.600, 0.130],
        [0.880, 0.240, 0.130],
        [0.990, 0.900, 0.880],
    ]
)
"""Colours of the scale from low to high, display-encoded; lightness mostly rises, hues stay told apart."""

LEGEND_WIDTH = 110
"""Room for the legend. [pixel]"""

BACKGROUND = (32, 34, 38)
"""Colour around charts."""


def colours(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Map values linearly to the scale; what lies outside takes the end colours. (...) -> (..., 3) uint8"""
    share = np.clip((np.nan_to_num(values) - low) / max(high - low, 1e-30), 0.0, 1.0)
    place = share * (len(STOPS) - 1)
    below = np.minimum(place.astype(int), len(STOPS) - 2)
    part = (place - below)[..., None]
    return np.round(255.0 * (STOPS[below] * (1.0 - part) + STOPS[below + 1] * part)).astype(
        np.uint8
    )


def nice_maximum(values: np.ndarray) -> float:
    """Round number that nearly all values lie under: the 99.5th percentile, up to 1, 1.5, 2, 3, 4, 5, 6 or 8 times 10^n."""
    finite = values[np.isfinite(values)]
    top = float(np.percentile(finite, 99.5)) if finite.size else 1.0
    if top <= 0.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(top))
    for step in (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0):
        if top <= step * power * 1.0001:
            return step * power
    return 10.0 * power


def write_false_colour(
    path,
    values: np.ndarray,
    shown: np.ndarray,
    title: str,
    unit: str = "lx",
    high: float | None = None,
    captions=(),
) -> Path:
    """Write a map as a PNG with legend; ``path``: str or Path, the others as of `draw_false_colour`."""
    from .canvas import save_picture

    picture = draw_false_colour(values, shown, title, unit, high, captions)
    return save_picture(picture, path)


def draw_false_colour(
    values: np.ndarray,
    shown: np.ndarray,
    title: str,
    unit: str = "lx",
    high: float | None = None,
    captions=(),
):
    """Draw a map with legend.

    Parameters
    ----------
    values : (h, w) array    Row 0 is the bottom row.
    shown : (h, w) bool array    Elsewhere the background is left.
    title : str    Over the legend.
    unit : str
    high : float or None    Top of the scale; None: a round number from the values.
    captions : list of (text, x, y)    Texts whose lower left corner is at a pixel of the map.

    Returns
    -------
    PIL.Image.Image    RGB.
    """
    from PIL import Image, ImageDraw, ImageFont

    high = nice_maximum(values[shown]) if high is None else high
    picture = colours(values, 0.0, high)
    picture[~shown] = BACKGROUND
    picture = picture[::-1]
    factor = max(1, int(np.ceil(360 / max(picture.shape[:2]))))
    picture = picture.repeat(factor, axis=0).repeat(factor, axis=1)
    height = max(picture.shape[0], 280)
    canvas = Image.new("RGB", (picture.shape[1] + LEGEND_WIDTH, height + 26), BACKGROUND)
    canvas.paste(Image.fromarray(picture), (0, 26))
    draw = ImageDraw.Draw(canvas)
    font = ImageFont.load_default(12)
    draw.text((6, 6), f"{title} [{unit}]", fill=(230, 230, 230), font=font)
    for text, x, y in captions:
        place = (x * factor, 26 + (values.shape[0] - y) * factor - 14)
        draw.text(place, text, fill=(230, 230, 230), font=font)
    left, top, bar = picture.shape[1] + 14, 44, height - 40
    ramp = colours(np.linspace(high, 0.0, bar)[:, None].repeat(18, axis=1), 0.0, high)
    canvas.paste(Image.fromarray(ramp), (left, top))
    for i in range(9):
        y = top + round(bar * (1.0 - i / 8.0))
        draw.line((left + 18, y, left + 23, y), fill=(230, 230, 230))
        draw.text((left + 27, y - 7), f"{high * i / 8.0:.4g}", fill=(230, 230, 230), font=font)
    return canvas


def write_display(path, linear: np.ndarray, words: str = "") -> Path:
    """Write scene-linear Rec. 709 (h, w, 3), row 0 at the bottom, as an sRGB PNG, see `encode_display`.

    ``words``: what the file says of itself, as its description.
    """
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    from .canvas import save_picture

    facts = PngInfo()
    if words:
        facts.add_text("Description", words)
    return save_picture(Image.fromarray(encode_display(linear)), path, pnginfo=facts)


def encode_display(linear: np.ndarray) -> np.ndarray:
    """Encode scene-linear Rec. 709 (h, w, 3), row 0 at the bottom, as sRGB for files, row 0 at the top. (h, w, 3) uint8

    Values up to 0.8 are kept as they are; brighter ones are rolled off towards white, so that lamps do not end in a
    hard edge. Colours outside the gamut are clipped.
    """
    x = np.maximum(np.nan_to_num(linear[::-1]), 0.0)
    peak = x.max(axis=2, keepdims=True)
    knee = 0.8
    rolled = np.where(
        peak > knee, knee + (1.0 - knee) * (1.0 - np.exp(-(peak - knee) / (1.0 - knee))), peak
    )
    x = x * (rolled / np.maximum(peak, 1e-9))
    encoded = np.where(
        x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1.0 / 2.4) - 0.055
    )
    return np.round(255.0 * np.clip(encoded, 0.0, 1.0)).astype(np.uint8)
