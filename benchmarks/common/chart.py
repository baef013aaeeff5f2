"""What charts of benchmarks are drawn on, in pixels of the finished picture."""

from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

SCALE = 2
"""Pictures are drawn so many times larger, for smooth lines."""

INK = "#222222"

CORNERS = {
    "square": [(-0.85, -0.85), (0.85, -0.85), (0.85, 0.85), (-0.85, 0.85)],
    "triangle": [(0.0, -1.15), (1.05, 0.75), (-1.05, 0.75)],
    "diamond": [(0.0, -1.2), (1.0, 0.0), (0.0, 1.2), (-1.0, 0.0)],
}
"""Of shapes of radius 1."""


class Picture:
    """A white picture and its pen. ``size``: width and height; ``letters``: of the one size of letters. [pixel]"""

    def __init__(self, size: tuple[int, int], letters: int = 13):
        self.size = size
        self.image = Image.new("RGB", (size[0] * SCALE, size[1] * SCALE), "white")
        self.pen = ImageDraw.Draw(self.image, "RGBA")
        self.font = ImageFont.load_default(letters * SCALE)

    def write(self, x: float, y: float, text: str, anchor: str, colour: str = INK) -> None:
        self.pen.text((SCALE * x, SCALE * y), text, fill=colour, font=self.font, anchor=anchor)

    def write_upwards(self, x: float, y: float, text: str) -> None:
        """Write about a middle, turned by a quarter."""
        left, top, right, bottom = (round(v) for v in self.font.getbbox(text))
        strip = Image.new("L", (right - left + 4, bottom - top + 4))
        ImageDraw.Draw(strip).text((2 - left, 2 - top), text, fill=255, font=self.font)
        strip = strip.rotate(90, expand=True)
        place = (round(SCALE * x - strip.width / 2), round(SCALE * y - strip.height / 2))
        self.image.paste(Image.new("RGB", strip.size, INK), place, strip)

    def line(self, places, colour: str, width: float = 1.0) -> None:
        scaled = [(SCALE * x, SCALE * y) for x, y in places]
        self.pen.line(scaled, fill=colour, width=round(width * SCALE), joint="curve")

    def fill(self, places, colour: str, opacity: int = 255) -> None:
        """Fill a polygon; what is below may show."""
        red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
        self.pen.polygon([(SCALE * x, SCALE * y) for x, y in places], (red, green, blue, opacity))

    def mark(self, x: float, y: float, colour: str, shape: str = "disk", radius=4.5) -> None:
        """Draw a point of a curve."""
        if shape == "disk":
            box = [SCALE * (v + s * radius) for s in (-1, 1) for v in (x, y)]
            self.pen.ellipse(box, fill=colour)
        else:
            self.fill([(x + radius * u, y + radius * v) for u, v in CORNERS[shape]], colour)

    def legend(self, x: float, y: float, entries: list[tuple[str, str, str]]) -> float:
        """Name curves in a row from a place on: text, colour, shape; return where it ends."""
        for text, colour, shape in entries:
            self.line([(x, y), (x + 28, y)], colour, 2)
            self.mark(x + 14, y, colour, shape)
            self.write(x + 36, y, text, "lm")
            x += 36 + self.font.getlength(text) / SCALE + 22
        return x

    def paste(self, pixels, x: float, y: float) -> None:
        """Put a picture in, (h, w, 3) bytes from above, whose pixels become pixels."""
        picture = Image.fromarray(pixels).resize(
            (pixels.shape[1] * SCALE, pixels.shape[0] * SCALE), Image.Resampling.NEAREST
        )
        self.image.paste(picture, (round(SCALE * x), round(SCALE * y)))

    def save(self, path: Path, colours: int = 256) -> None:
        """Write a small PNG: a palette is enough for charts."""
        small = self.image.resize(self.size, Image.Resampling.LANCZOS)
        small = small.quantize(colours, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
        small.save(path, optimize=True)
