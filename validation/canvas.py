"""The product's pen on white paper, with what technical pictures need beside lines, dots and letters."""

from pathlib import Path

from PIL import Image, ImageDraw

from lumenray.engine.analysis import canvas
from lumenray.engine.analysis.canvas import LIGHT, SCALE

INK, SOFT, RULE = "#222222", "#666666", "#dddddd"
"""Colours of text, of lesser text, and of rules."""


class Canvas(canvas.Canvas):
    """A white sheet, or an ``image`` that is `SCALE` times as large; all else is in pixels of the finished picture."""

    def __init__(self, size: tuple[int, int], image: Image.Image | None = None):
        super().__init__(size, LIGHT, 1.0)
        if image is not None:
            self.image, self.pen = image, ImageDraw.Draw(image)

    def arrow(self, start, end, colour: str, width: float = 1.0, head: float = 5.0) -> None:
        """Draw an arrow; one too short for its head is a line."""
        self.line([start, end], colour, width)
        x, y = end[0] - start[0], end[1] - start[1]
        length = (x * x + y * y) ** 0.5
        if length < 0.8 * head:
            return
        x, y = head * x / length, head * y / length
        foot = end[0] - x, end[1] - y
        sides = [(foot[0] - s * y, foot[1] + s * x) for s in (0.38, -0.38)]
        self.shape([end, *sides], colour)

    def box(self, low, high, fill=None, outline=None) -> None:
        """Draw an upright rectangle."""
        self.pen.rectangle([*_big(low), *_big(high)], fill=fill, outline=outline, width=SCALE)

    def shape(self, places, fill: str) -> None:
        """Draw a polygon."""
        self.pen.polygon([_big(place) for place in places], fill=fill)


def save_picture(image: Image.Image, path: Path, colours: int = 256) -> Path:
    """Write a small PNG: a palette is enough for line drawings."""
    return canvas.save_picture(
        image.quantize(colours, dither=Image.Dither.NONE), path, optimize=True
    )


def _big(place) -> tuple[float, float]:
    return SCALE * float(place[0]), SCALE * float(place[1])
