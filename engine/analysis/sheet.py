"""A drawing that is written as pixels (PNG) or as shapes (SVG): areas, lines, texts and pictures. [pixel]"""

import base64
import io
from dataclasses import dataclass, field
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np
from PIL import Image

from ..errors import FileFormatError
from ..reading.printable import printable
from ..reading.whole_file import write_whole
from .canvas import LIGHT, SCALE, Canvas, Colours, save_picture

ANCHORS = {"l": "start", "m": "middle", "r": "end"}
"""Where a text stands beside its place, as Pillow and as SVG call it."""


@dataclass(frozen=True, eq=False)
class Area:
    """A polygon (n, 2) in one colour."""

    corners: np.ndarray
    colour: str


@dataclass(frozen=True, eq=False)
class Line:
    """A path (n, 2)."""

    path: np.ndarray
    colour: str
    width: float


@dataclass(frozen=True, eq=False)
class Text:
    """A text about a place; ``anchor``: left, middle or right of it. ``halo``: colour of what is around the letters."""

    place: tuple[float, float]
    text: str
    size: float
    anchor: str
    colour: str
    halo: str | None


@dataclass(frozen=True, eq=False)
class Raster:
    """A picture (h, w, 3) uint8, the top row first, whose pixels are seen as squares."""

    pixels: np.ndarray
    corner: tuple[float, float]
    size: tuple[float, float]


@dataclass
class Sheet:
    """A drawing under way.

    Parameters
    ----------
    size : (int, int)    Width and height. [pixel]
    colours : Colours
    """

    size: tuple[int, int]
    colours: Colours = LIGHT
    shapes: list = field(default_factory=list)

    def area(self, corners, colour: str) -> None:
        """Fill a polygon (n, 2)."""
        self.shapes.append(Area(np.asarray(corners, dtype=np.float64), colour))

    def line(self, path, colour: str, width: float = 1.0) -> None:
        """Draw a path (n, 2)."""
        self.shapes.append(Line(np.asarray(path, dtype=np.float64), colour, width))

    def write(self, place, text: str, size=11.0, anchor="l", colour=None, halo=None) -> None:
        """Write a text in the middle of a height."""
        colour = colour or self.colours.text
        self.shapes.append(
            Text(tuple(map(float, place)), printable(text), size, anchor, colour, halo)
        )

    def picture(self, pixels, corner, size) -> None:
        """Show a picture (h, w, 3) uint8 with its upper left corner at a place, in a size."""
        self.shapes.append(Raster(np.asarray(pixels), tuple(corner), tuple(size)))

    def to_picture(self) -> Image.Image:
        """Return the drawing as pixels."""
        canvas = Canvas(self.size, self.colours, 1.0)
        for shape in self.shapes:
            _PAINTERS[type(shape)](canvas, shape)
        return canvas.finish()

    def to_svg(self) -> str:
        """Return the drawing as the text of an SVG file, which needs nothing beside it."""
        width, height = self.size
        rows = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
            f'viewBox="0 0 {width} {height}" font-family="sans-serif">',
            f'<rect width="{width}" height="{height}" fill="{self.colours.background}"/>',
        ]
        rows += [_WRITERS[type(shape)](shape) for shape in self.shapes]
        return "\n".join([*rows, "</svg>"]) + "\n"

    def save(self, path) -> Path:
        """Write the drawing as the kind of file that its name ends in: .svg or .png.

        Raises
        ------
        FileFormatError    The name ends in neither, or the file cannot be written.
        """
        path = Path(path)
        if path.suffix.lower() == ".svg":
            with write_whole(path, "utf-8") as file:
                file.write(self.to_svg())
            return path
        if path.suffix.lower() != ".png":
            raise FileFormatError(path, "expected a name that ends in .png or .svg")
        return save_picture(self.to_picture(), path)


def hexadecimal(colour) -> str:
    """Return a colour of three numbers 0..255 as CSS writes it."""
    return "#" + "".join(f"{int(part):02x}" for part in colour)


# ---- pixels ----


def _paint_area(canvas: Canvas, shape: Area) -> None:
    canvas.pen.polygon([tuple(corner) for corner in SCALE * shape.corners], shape.colour)


def _paint_line(canvas: Canvas, shape: Line) -> None:
    canvas.line(shape.path, shape.colour, shape.width)


def _paint_text(canvas: Canvas, shape: Text) -> None:
    halo = {} if shape.halo is None else {"has_halo": True}
    canvas.write(shape.place, shape.text, shape.size, f"{shape.anchor}m", shape.colour, **halo)


def _paint_raster(canvas: Canvas, shape: Raster) -> None:
    size = tuple(max(round(side * SCALE), 1) for side in shape.size)
    picture = Image.fromarray(shape.pixels).resize(size, Image.Resampling.NEAREST)
    canvas.image.paste(picture, tuple(round(side * SCALE) for side in shape.corner))


_PAINTERS = {Area: _paint_area, Line: _paint_line, Text: _paint_text, Raster: _paint_raster}


# ---- shapes ----


def _points(path) -> str:
    return " ".join(f"{x:.2f},{y:.2f}" for x, y in path)


def _write_area(shape: Area) -> str:
    return f'<polygon points="{_points(shape.corners)}" fill="{shape.colour}"/>'


def _write_line(shape: Line) -> str:
    return (
        f'<polyline points="{_points(shape.path)}" fill="none" stroke="{shape.colour}" '
        f'stroke-width="{shape.width:g}" stroke-linejoin="round"/>'
    )


def _write_text(shape: Text) -> str:
    x, y = shape.place
    halo = (
        f' stroke="{shape.halo}" stroke-width="3" paint-order="stroke" stroke-linejoin="round"'
        if shape.halo
        else ""
    )
    return (
        f'<text x="{x:.2f}" y="{y + 0.35 * shape.size:.2f}" font-size="{shape.size:g}" '
        f'text-anchor="{ANCHORS[shape.anchor]}" fill="{shape.colour}"{halo}>{escape(shape.text)}</text>'
    )


def _write_raster(shape: Raster) -> str:
    stream = io.BytesIO()
    Image.fromarray(shape.pixels).save(stream, "PNG")
    data = base64.b64encode(stream.getvalue()).decode()
    (x, y), (width, height) = shape.corner, shape.size
    return (
        f'<image x="{x:.2f}" y="{y:.2f}" width="{width:.2f}" height="{height:.2f}" preserveAspectRatio="none" '
        f'style="image-rendering:pixelated" href="data:image/png;base64,{data}"/>'
    )


_WRITERS = {Area: _write_area, Line: _write_line, Text: _write_text, Raster: _write_raster}
