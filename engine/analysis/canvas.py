"""A pen for charts: smooth lines, arrows, letters and legends, in pixels of the finished picture."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ..errors import FileFormatError
from ..reading.whole_file import write_whole
from .letters import plain_letters

SCALE = 3
"""The picture is drawn so many times larger, for smooth lines."""

CHART = 480
"""Shorter side of a chart whose lines and letters have their nominal size. [pixel]"""

SMALLEST, LARGEST = 160, 4096
"""Sides of a chart. [pixel]"""


@dataclass(frozen=True)
class Colours:
    """Colours of a diagram as hexadecimal RGB."""

    background: str
    grid: str
    axis: str
    text: str
    caption: str
    curves: tuple[str, str, str]


LIGHT = Colours(
    "#ffffff", "#dfe3e8", "#b4bbc4", "#20252c", "#66707c", ("#d0331f", "#1d68b3", "#5f6b78")
)
DARK = Colours(
    "#1e2024", "#3a3e45", "#5a606a", "#eceef1", "#a3abb6", ("#ff7d60", "#5fb4ff", "#a8b2bd")
)


def save_picture(picture: Image.Image, path, **options) -> Path:
    """Write a picture as the kind of file that its name ends in, with options of Pillow.

    Raises
    ------
    FileFormatError    The name ends in no such kind, or the file cannot be written.
    """
    with write_whole(path) as file:
        try:
            picture.save(file, **options)
        except ValueError:
            raise FileFormatError(path, "expected a name that ends in .png") from None
    return Path(path)


def to_pixels(picture: Image.Image) -> np.ndarray:
    """A picture as Blender keeps images: (h, w, 4) float32, display-encoded RGBA 0..1, the bottom row first."""
    pixels = np.asarray(picture.convert("RGBA"))
    return np.ascontiguousarray(pixels[::-1], dtype=np.float32) / np.float32(255.0)


class Canvas:
    """The picture under way, and the pen: everything in pixels of the finished picture.

    Parameters
    ----------
    size : (int, int)    Width and height. [pixel]
    colours : Colours
    zoom : float    Width of lines and size of letters over the nominal ones. [-]
    least : int    Size of the smallest letters. [pixel]
    """

    def __init__(self, size, colours: Colours, zoom: float, least: int = 8):
        self.size, self.colours, self.zoom, self.least = size, colours, zoom, least
        scaled = tuple(side * SCALE for side in size)
        self.image = Image.new("RGB", scaled, colours.background)
        self.pen = ImageDraw.Draw(self.image)

    def finish(self) -> Image.Image:
        """The picture in its size."""
        return self.image.resize(self.size, Image.Resampling.LANCZOS)

    def line(self, path, colour: str, width: float = 1.0) -> None:
        """Draw a path (n, 2)."""
        points = [(float(x) * SCALE, float(y) * SCALE) for x, y in path]
        self.pen.line(points, colour, max(1, round(width * self.zoom * SCALE)), joint="curve")

    def curve(self, path, colour: str, width: float = 1.0) -> None:
        """Draw a path (n, 2) whose points may lie closer than pixels."""
        path = np.asarray(path, dtype=np.float64)
        # Closer points than a pixel would make wide lines rough, as they are drawn on whole ones.
        step = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
        kept = np.append(True, np.diff(np.floor(step / 1.5)) > 0.0)
        kept[-1] = True
        self.line(path[kept], colour, width)

    def dashed(self, path, colour: str, width: float, dash: tuple[float, float]) -> None:
        """Draw a path (n, 2) with dashes of a length and a gap."""
        path = np.asarray(path, dtype=np.float64)
        length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
        on, off = dash[0] * self.zoom, dash[1] * self.zoom
        for start in np.arange(0.0, length[-1], on + off):
            end = min(start + on, length[-1])
            inner = length[(length > start) & (length < end)]
            along = np.concatenate([[start], inner, [end]])
            self.line(
                np.stack([np.interp(along, length, path[:, i]) for i in (0, 1)], 1), colour, width
            )

    def dot(self, at, colour: str, radius: float = 3.5, rim: str | None = None) -> None:
        """Draw a full circle, perhaps with a rim of another colour."""
        (x, y), r = (float(c) * SCALE for c in at), radius * self.zoom * SCALE
        width = 0 if rim is None else round(1.8 * self.zoom * SCALE)
        self.pen.ellipse([x - r, y - r, x + r, y + r], colour, rim, width)

    def arrow(self, start, end, colour: str) -> None:
        """Draw an arrow that points at its end."""
        start, end = np.asarray(start), np.asarray(end)
        ahead = (end - start) / max(float(np.hypot(*(end - start))), 1e-9)
        aside, size = np.array([-ahead[1], ahead[0]]), 7.0 * self.zoom
        foot = end - 1.4 * size * ahead
        self.line([start, foot], colour, 2.0)
        corners = [end, foot + 0.6 * size * aside, foot - 0.6 * size * aside]
        self.pen.polygon([tuple(float(c) * SCALE for c in corner) for corner in corners], colour)

    def legend(self, entries, head: str = "") -> None:
        """Strokes with texts (colour, text) in rows at the bottom."""
        unit = self.zoom
        places = self._places(entries, head)
        top = self.size[1] - (30 + 17 * (max((row for _, row in places), default=0))) * unit
        if head:
            self.write((18 * unit, top), head, 11, "lm", is_caption=True)
        for (colour, text), (x, row) in zip(entries, places, strict=True):
            y = top + 17 * row * unit
            self.line([(x, y), (x + 18 * unit, y)], colour, 2.5)
            self.write((x + 23 * unit, y), text, 11, "lm")

    def count_rows(self, entries, head: str = "") -> int:
        """Rows of a legend."""
        return max((row + 1 for _, row in self._places(entries, head)), default=1)

    def _places(self, entries, head: str) -> list[tuple[float, int]]:
        """Where the entries of a legend begin, and in which row."""
        unit = self.zoom
        start = 18 * unit + (self.measure(head, 11) + 12 * unit if head else 0.0)
        x, row, places = start, 0, []
        for _, text in entries:
            wide = 23 * unit + self.measure(text, 11)
            if x + wide > self.size[0] - 18 * unit and x > start:
                x, row = start, row + 1
            places.append((x, row))
            x += wide + 14 * unit
        return places

    def measure(self, text: str, size: float) -> float:
        """Width of a text."""
        return self._font(size).getlength(plain_letters(text)) / SCALE

    def write(
        self, at, text, size, anchor, colour=None, is_caption=False, has_halo=False, room=None
    ) -> float:
        """Write a text, smaller where there is no room for it, and return where it ends on the right.

        ``has_halo`` keeps lines off it.
        """
        text = plain_letters(text)
        if room is not None:
            size *= min(1.0, room / max(self.measure(text, size), 1e-9))
        font = self._font(size)
        place = float(at[0]) * SCALE, float(at[1]) * SCALE
        colour = colour or (self.colours.caption if is_caption else self.colours.text)
        halo = (
            {"stroke_width": 2 * SCALE, "stroke_fill": self.colours.background} if has_halo else {}
        )
        self.pen.text(place, text, fill=colour, font=font, anchor=anchor, **halo)
        return self.pen.textbbox(place, text, font=font, anchor=anchor)[2] / SCALE

    def _font(self, size: float):
        return ImageFont.load_default(max(round(size * self.zoom * SCALE), self.least * SCALE))


def open_chart(size, dark: bool) -> Canvas:
    """Return the canvas of a chart; its width and height are brought within what can be drawn. [pixel]"""
    size = tuple(min(max(int(side), SMALLEST), LARGEST) for side in size)
    return Canvas(size, DARK if dark else LIGHT, min(size) / CHART, least=7)
