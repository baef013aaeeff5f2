"""A picture of the surroundings for people: developed, its bright sources marked, with what they give and the verdict."""

import numpy as np
from PIL import Image

from ..analysis.canvas import SCALE, Canvas, open_chart
from ..analysis.false_colour import encode_display
from ..analysis.letters import plain_letters
from ..reading.printable import printable
from ..scene.texture import ImageTexture
from ..sky.picture import clean
from .analysis import Analysis, format_range, format_ratio

GREY = 0.35
"""Display value, linear, that the mean luminance is shown as. [-]"""

LEAST_CIRCLE = np.radians(2.0)
"""Radius of the smallest circle about a source. [rad]"""

LISTED = 6
"""Sources that have a line of their own."""

SUN, LAMP = "#e0532b", "#1f7fd1"
"""Colours of circles about the sun and other sources."""


def draw_marked(
    image: ImageTexture,
    analysis: Analysis,
    title: str = "",
    size: tuple[int, int] = (900, 680),
    dark: bool = False,
) -> Image.Image:
    """Draw a picture of the surroundings with its sources.

    Parameters
    ----------
    image : ImageTexture    Equirectangular.
    analysis : Analysis    Of it.
    title : str
    size : (int, int)    Width and height. [pixel]
    dark : bool    Light letters on a dark ground.

    Returns
    -------
    Image    RGB.
    """
    canvas = open_chart(size, dark)
    unit, (width, height) = canvas.zoom, canvas.size
    rows = min(len(analysis.sources), LISTED)
    below = (30 + 15 * (rows + len(analysis.verdict) + 2)) * unit
    left, top = 18 * unit, 52 * unit
    wide = max(min(width - 2 * left, 2 * (height - top - below)), 8.0)
    room = width - 2 * left
    canvas.write((left, 20 * unit), printable(title), 16, "lm", room=room)
    words = (
        f"{analysis.width} x {analysis.height}, horizontal {_lux(analysis.horizontal)}, all but the sources "
        f"{_lux(analysis.rest)}, range {format_range(analysis.range)}"
    )
    canvas.write((left, 39 * unit), words, 11, "lm", is_caption=True, room=room)
    _paste(canvas, image, analysis, (left, top), wide)
    for number, row in enumerate(analysis.sources, start=1):
        _mark(canvas, row, number, analysis, (left, top), wide)
    y = top + 0.5 * wide + 18 * unit
    for number, row in enumerate(analysis.sources[:LISTED], start=1):
        canvas.write(
            (left, y), _tell(number, row), 11, "lm", SUN if row.is_sun else LAMP, room=room
        )
        y += 15 * unit
    if len(analysis.sources) > LISTED:
        words = f"and {len(analysis.sources) - LISTED} more"
        canvas.write((left, y), words, 11, "lm", is_caption=True)
        y += 15 * unit
    if analysis.ratio is not None:
        words = f"sun : all else {format_ratio(analysis.ratio)}, on a horizontal plane"
        canvas.write((left, y), words, 11, "lm", room=room)
        y += 15 * unit
    for sentence in analysis.verdict:
        canvas.write((left, y), sentence[:1].upper() + sentence[1:], 11, "lm", room=room)
        y += 15 * unit
    return canvas.finish()


def _paste(canvas: Canvas, image: ImageTexture, analysis: Analysis, corner, wide: float) -> None:
    """Paste the developed picture, twice as wide as high."""
    side = (round(wide * SCALE), round(0.5 * wide * SCALE))
    height, width = image.pixels.shape[:2]
    # Every so many pixels alone: nobody counts them here, and large pictures would need their memory twice.
    step = max(height // side[1], width // side[0], 1)
    pixels = clean(image.pixels[::step, ::step])
    if pixels.shape[2] == 1:
        pixels = np.repeat(pixels, 3, axis=2)
    mean = analysis.mean / analysis.per_unit if analysis.mean > 0.0 else 1.0
    shown = encode_display(pixels * np.float32(GREY / mean))
    picture = Image.fromarray(shown).resize(side, Image.Resampling.BILINEAR)
    canvas.image.paste(picture, tuple(round(each * SCALE) for each in corner))


def _mark(canvas: Canvas, row, number: int, analysis: Analysis, corner, wide: float) -> None:
    """Draw a circle of the sphere about a source, and its number."""
    colour = SUN if row.is_sun else LAMP
    turn = (row.column / analysis.width - 0.5) * 2.0 * np.pi
    up = (0.5 - row.row / analysis.height) * np.pi
    middle = np.array([np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up)])
    across = np.cross(middle, np.eye(3)[int(np.argmin(np.abs(middle)))])
    across /= np.linalg.norm(across)
    beside = np.cross(middle, across)
    radius = max(0.5 * np.radians(row.diameter) * 1.5, LEAST_CIRCLE)
    angle = np.linspace(0.0, 2.0 * np.pi, 181)[:, None]
    ring = np.cos(radius) * middle
    ring = ring + np.sin(radius) * (np.cos(angle) * across + np.sin(angle) * beside)
    x = (np.arctan2(ring[:, 1], ring[:, 0]) / (2.0 * np.pi) + 0.5) * wide
    y = (0.5 - np.arcsin(np.clip(ring[:, 2], -1.0, 1.0)) / np.pi) * 0.5 * wide
    points = np.stack([x, y], axis=1) + np.asarray(corner)
    # Round the picture's border it goes on at the other side.
    breaks = np.flatnonzero(np.abs(np.diff(x)) > 0.5 * wide) + 1
    for piece in np.split(points, breaks):
        if len(piece) > 1:
            canvas.line(piece, "#ffffff", 3.4)
            canvas.line(piece, colour, 1.6)
    at = (
        np.asarray(corner)
        + np.array([row.column / analysis.width, 0.5 * row.row / analysis.height]) * wide
    )
    offset = radius / np.pi * 0.5 * wide + 9.0 * canvas.zoom
    at[0] += offset if at[0] + 2.0 * offset < corner[0] + wide else -offset
    canvas.write(at, str(number), 12, "mm", colour, has_halo=True)


def _tell(number: int, row) -> str:
    kind = "sun" if row.is_sun else "source"
    return plain_letters(
        f"{number}  {kind}: {row.elevation:.1f}° high, azimuth {row.azimuth:.1f}°, {row.diameter:.2f}° wide, up to "
        f"{row.luminance:.3g} cd/m², {_lux(row.illuminance)} facing it, {_lux(row.horizontal)} horizontal"
    )


def _lux(value: float) -> str:
    return f"{value:,.0f} lx".replace(",", " ") if value >= 100.0 else f"{value:.3g} lx"
