"""Picture of a ray set: where its rays start, from two sides, with some of them; its luminances; its intensities."""

import math

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ..luminaires.formats.record import LuminaireFile
from ..raysets.reduction import LuminanceImage
from .canvas import DARK, LIGHT
from .false_colour import colours, nice_maximum
from .polar_diagram import draw_polar_diagram

MARGIN = 0.06
"""Of a panel, around what it shows."""

DRAWN = 160
"""Rays that are drawn."""

REACH = 0.6
"""Length of a drawn ray, over the largest extent of the source."""

SMALLEST = 1e-8
"""Extent below which a source is a point. [m]"""

POINTS = 60_000
"""Starting points that are drawn at most."""


def draw_rayset(
    position: np.ndarray,
    direction: np.ndarray,
    image: LuminanceImage,
    luminaire: LuminaireFile,
    title: str,
    size: int = 512,
    dark: bool = False,
) -> Image.Image:
    """Draw a ray set.

    Parameters
    ----------
    position, direction : (n, 3) arrays    Generated rays, or some of the file's. [m]
    image : LuminanceImage    Seen against +z.
    luminaire : LuminaireFile    Its intensities.
    title : str
    size : int    Side of each of the four panels. [pixel]
    dark : bool

    Returns
    -------
    Image    RGB, 2 x 2 panels under a title.
    """
    palette = DARK if dark else LIGHT
    head = size // 14
    picture = Image.new("RGB", (2 * size, 2 * size + head), palette.background)
    pen = ImageDraw.Draw(picture)
    pen.text((size // 24, head // 2), title, palette.text, _font(size / 28), anchor="lm")
    for number, (across, up, names) in enumerate(((0, 1, "xy"), (0, 2, "xz"))):
        panel = _draw_points(position, direction, across, up, names, size, palette)
        picture.paste(panel, (number * size, head))
    picture.paste(_draw_luminance(image, size, palette), (0, head + size))
    picture.paste(draw_polar_diagram(luminaire, (size, size), dark), (size, head + size))
    return picture


def _draw_points(position, direction, across, up, names, size, palette) -> Image.Image:
    """Starting points along two axes, with the outlines of some rays."""
    step = max(len(position) // POINTS, 1)
    low, high = position.min(axis=0), position.max(axis=0)
    centre, extent = 0.5 * (low + high), max(float((high - low).max()), 1e-9)
    wide = extent * (1.0 + 1.2 * REACH)
    scale = size * (1.0 - 2.0 * MARGIN) / wide

    def place(points):
        away = points - centre
        return 0.5 * size + scale * away[:, across], 0.5 * size - scale * away[:, up]

    panel = Image.new("RGB", (size, size), palette.background)
    pen = ImageDraw.Draw(panel)
    if extent < SMALLEST:
        where = ", ".join(f"{1e3 * value:.4g}" for value in centre)
        pen.text(
            (0.5 * size, 0.9 * size),
            f"all start at {where} mm",
            palette.text,
            _font(size / 32),
            "mm",
        )
    chosen = slice(None, None, max(len(position) // DRAWN, 1))
    start = place(position[chosen])
    end = place(position[chosen] + REACH * extent * direction[chosen])
    for x, y, u, v in zip(*start, *end, strict=True):
        pen.line((x, y, u, v), palette.axis, max(size // 512, 1))
    column, row = (np.round(value).astype(int) for value in place(position[::step]))
    inside = (column >= 0) & (column < size) & (row >= 0) & (row < size)
    pixels = np.array(panel)
    pixels[row[inside], column[inside]] = _rgb(palette.curves[0])
    panel = Image.fromarray(pixels)
    pen = ImageDraw.Draw(panel)
    font = _font(size / 40)
    edge = MARGIN * size
    pen.text((size - edge, size - edge), names[0], palette.text, font, anchor="rm")
    pen.text((edge, edge), names[1], palette.text, font, anchor="lt")
    if extent >= SMALLEST:
        length = _round_below(0.5 * wide)
        y = size - 0.5 * edge
        pen.line((edge, y, edge + scale * length, y), palette.text, max(size // 256, 1))
        pen.text((edge, y - 4), _length(length), palette.text, font, anchor="lb")
    return panel


def _draw_luminance(image: LuminanceImage, size: int, palette) -> Image.Image:
    """Luminances in false colours, with their scale."""
    lit = image.luminance[image.luminance > 0.0]
    top = nice_maximum(lit if lit.size else image.luminance)
    shown = Image.fromarray(colours(image.luminance, 0.0, top))
    side = round(size * (1.0 - 4.0 * MARGIN))
    panel = Image.new("RGB", (size, size), palette.background)
    corner = round(MARGIN * size)
    panel.paste(shown.resize((side, side), Image.Resampling.NEAREST), (corner, 2 * corner))
    scale = np.repeat(np.linspace(top, 0.0, side)[:, None], max(size // 40, 4), axis=1)
    left = corner + side + corner // 2
    panel.paste(Image.fromarray(colours(scale, 0.0, top)), (left, 2 * corner))
    pen = ImageDraw.Draw(panel)
    font = _font(size / 40)
    pen.text(
        (corner, corner),
        f"luminance against +z, 0 to {top:,.3g} cd/m2".replace(",", " "),
        palette.text,
        font,
        anchor="lt",
    )
    return panel


def _font(size: float):
    return ImageFont.load_default(max(size, 9.0))


def _rgb(text: str) -> tuple[int, int, int]:
    return tuple(int(text[i : i + 2], 16) for i in (1, 3, 5))


def _round_below(value: float) -> float:
    """1, 2 or 5 times a power of ten, not above a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(f * power for f in (1.0, 2.0, 5.0) if f * power <= value)


def _length(metres: float) -> str:
    """Length with the unit in which it is short."""
    if metres >= 1.0:
        return f"{metres:g} m"
    return f"{1e3 * metres:g} mm" if metres >= 1e-3 else f"{1e6 * metres:g} um"
