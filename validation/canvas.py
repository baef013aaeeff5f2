"""Pictures drawn with smooth lines and text, by Pillow alone: at twice the size, then reduced."""

from functools import lru_cache
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

SCALE = 2
"""The picture is drawn so many times larger, for smooth lines."""

INK, SOFT, RULE = "#222222", "#666666", "#dddddd"
"""Colours of text, of lesser text, and of rules."""


@lru_cache
def font(size: int) -> ImageFont.FreeTypeFont:
    """Return the plain font that comes with Pillow, at the drawing's scale."""
    return ImageFont.load_default(size * SCALE)


class Canvas:
    """A white sheet; all places and widths are in pixels of the finished picture."""

    def __init__(self, size: tuple[int, int], image: Image.Image | None = None):
        self.size = size
        big = (size[0] * SCALE, size[1] * SCALE)
        self.image = image if image is not None else Image.new("RGB", big, "white")
        self.pen = ImageDraw.Draw(self.image)

    def line(self, places, fill=INK, width: float = 1.0) -> None:
        """Draw a line through places."""
        self.pen.line([_big(place) for place in places], fill=fill, width=_width(width))

    def dashes(self, start, end, fill=SOFT, width: float = 1.0, dash: float = 4.0) -> None:
        """Draw a dashed line."""
        length = max(((end[0] - start[0]) ** 2 + (end[1] - start[1]) ** 2) ** 0.5, 1e-9)
        across, down = (end[0] - start[0]) / length, (end[1] - start[1]) / length
        at = 0.0
        while at < length:
            to = min(at + dash, length)
            self.line(
                [
                    (start[0] + at * across, start[1] + at * down),
                    (start[0] + to * across, start[1] + to * down),
                ],
                fill,
                width,
            )
            at += 2.0 * dash

    def arrow(self, start, end, fill=INK, width: float = 1.0, head: float = 5.0) -> None:
        """Draw an arrow; one too short for its head is a line."""
        self.line([start, end], fill, width)
        x, y = end[0] - start[0], end[1] - start[1]
        length = (x * x + y * y) ** 0.5
        if length < 0.8 * head:
            return
        x, y = x / length, y / length
        back = (end[0] - head * x, end[1] - head * y)
        side = 0.38 * head
        self.shape(
            [
                end,
                (back[0] - side * y, back[1] + side * x),
                (back[0] + side * y, back[1] - side * x),
            ],
            fill,
        )

    def dot(self, place, radius: float, fill=INK, outline=None) -> None:
        """Draw a disk."""
        x, y = place
        self.pen.ellipse(
            [*_big((x - radius, y - radius)), *_big((x + radius, y + radius))],
            fill=fill,
            outline=outline,
            width=SCALE,
        )

    def box(self, low, high, fill=None, outline=None) -> None:
        """Draw an upright rectangle."""
        self.pen.rectangle([*_big(low), *_big(high)], fill=fill, outline=outline, width=SCALE)

    def shape(self, places, fill=None, outline=None) -> None:
        """Draw a polygon."""
        self.pen.polygon([_big(place) for place in places], fill=fill, outline=outline, width=SCALE)

    def text(self, place, text: str, size=12, fill=INK, anchor="lm", halo: float = 0.0) -> None:
        """Write a line; ``halo`` is the width of a white seam round the letters."""
        self.pen.text(
            _big(place),
            text,
            fill=fill,
            font=font(size),
            anchor=anchor,
            stroke_width=round(halo * SCALE),
            stroke_fill="white",
        )

    def measure(self, text: str, size=12) -> tuple[float, float]:
        """Width and height that a line of text takes."""
        box = font(size).getbbox(text, anchor="lt")
        return box[2] / SCALE, box[3] / SCALE

    def finish(self) -> Image.Image:
        """Return the picture in its own size."""
        return self.image.resize(self.size, Image.Resampling.LANCZOS)


def save_picture(image: Image.Image, path: Path, colours: int = 256) -> Path:
    """Write a small PNG: a palette is enough for line drawings."""
    image.quantize(colours, dither=Image.Dither.NONE).save(path, optimize=True)
    return path


def _big(place) -> tuple[float, float]:
    return SCALE * float(place[0]), SCALE * float(place[1])


def _width(width: float) -> int:
    return max(1, round(width * SCALE))
