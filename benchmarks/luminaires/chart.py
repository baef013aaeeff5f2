"""Pictures of the benchmark of luminaires: deviations from Radiance by file, and speeds, both on logarithmic axes."""

import math
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from .agreement import BOUND
from .speed import WAYS, times

SCALE = 2
"""Pictures are drawn so many times larger, for smooth lines."""

WIDTH, LEFT, RIGHT, TOP, BOTTOM = 900, 240, 30, 68, 40
"""Width of a picture and free space around its axes. [pixel]"""

ROW = 15
"""Height of a file's row. [pixel]"""

ALIKE, DIFFERENT, CURED = "#1f77b4", "#ff7f0e", "#2ca02c"

COLOURS = ("#1f77b4", "#17becf", "#2ca02c", "#ff7f0e", "#d62728")
"""Of the ways of looking up."""


class _Canvas:
    """A picture with a logarithmic axis from left to right, in whole powers of ten."""

    def __init__(self, height: int, low: int, high: int, title: str):
        self.low, self.high, self.height = low, high, height
        self.image = Image.new("RGB", (WIDTH * SCALE, height * SCALE), "white")
        self.pen = ImageDraw.Draw(self.image)
        self.font = ImageFont.load_default(12 * SCALE)
        self.write(LEFT, 16, title, "lm")

    def x(self, value: float) -> float:
        """Place of a value along the axis; those beyond its ends lie at the ends. [pixel]"""
        power = min(max(math.log10(max(value, 1e-30)), self.low), self.high)
        return LEFT + (WIDTH - LEFT - RIGHT) * (power - self.low) / (self.high - self.low)

    def write(self, x: float, y: float, text: str, anchor: str) -> None:
        self.pen.text((SCALE * x, SCALE * y), text, fill="#222222", font=self.font, anchor=anchor)

    def line(self, x0, y0, x1, y1, colour: str, width: int = 1) -> None:
        places = [SCALE * x0, SCALE * y0, SCALE * x1, SCALE * y1]
        self.pen.line(places, fill=colour, width=width * SCALE)

    def dot(self, x: float, y: float, radius: float, colour: str) -> None:
        box = [
            SCALE * (x - radius),
            SCALE * (y - radius),
            SCALE * (x + radius),
            SCALE * (y + radius),
        ]
        self.pen.ellipse(box, fill=colour)

    def bar(self, x0, y0, x1, y1, colour: str) -> None:
        self.pen.rectangle([SCALE * v for v in (x0, y0, x1, y1)], fill=colour)

    def grid(self, name) -> None:
        """Draw a line for every power of ten, with what ``name`` calls it."""
        for power in range(self.low, self.high + 1):
            x = self.x(10.0**power)
            self.line(x, TOP, x, self.height - BOTTOM, "#dddddd")
            self.write(x, self.height - BOTTOM + 14, name(power), "mm")

    def save(self, path: Path) -> None:
        size = (WIDTH, self.height)
        small = self.image.resize(size, Image.Resampling.LANCZOS)
        small.quantize(64, Image.Quantize.MAXCOVERAGE).save(path, optimize=True)


def draw_agreement(agreement: dict, path: Path) -> None:
    """Draw the deviations of all points, one row a file."""
    files = agreement["files"]
    height = TOP + BOTTOM + ROW * max(len(files), 1)
    canvas = _Canvas(height, -6, 0, "Relative deviation from Radiance: every point of every file")
    canvas.grid(lambda power: f"{10.0 ** (power + 2):g} %")
    x = canvas.x(BOUND)
    canvas.line(x, TOP, x, height - BOTTOM, "#d62728")
    canvas.write(x, TOP - 8, f"{100 * BOUND:g} %", "mm")
    for number, row in enumerate(files):
        y = TOP + ROW * (number + 0.5)
        canvas.write(LEFT - 10, y, Path(row["file"]).name, "rm")
        colour = DIFFERENT if row["reason"] else ALIKE
        for value in row["deviations"]:
            canvas.dot(canvas.x(abs(value)), y, 1.5, colour)
        if row["reason"]:
            canvas.dot(canvas.x(row["without_reason"]), y, 4.0, CURED)
    legend = (
        (ALIKE, "alike"),
        (DIFFERENT, "Radiance differs"),
        (CURED, "the reason taken away: largest"),
    )
    x = LEFT
    for colour, text in legend:
        canvas.dot(x + 4, 36, 4.0, colour)
        canvas.write(x + 14, 36, text, "lm")
        x += 30 + 7 * len(text)
    canvas.save(path)


def draw_speed(rows: list[dict], path: Path) -> None:
    """Draw the rates of all ways for every distribution."""
    thick, gap = 16, 30
    height = TOP + BOTTOM + len(rows) * (thick * len(WAYS) + gap)
    canvas = _Canvas(height, 4, 9, "Directions looked up per second")
    canvas.grid(lambda power: f"{10.0 ** (power - 6):g} M")
    y = TOP + gap / 2
    for row in rows:
        middle = y + 0.5 * thick * len(WAYS)
        columns, lines = row["grid"]
        canvas.write(10, middle - 9, row["title"], "lm")
        canvas.write(10, middle + 9, f"{columns} x {lines} values", "lm")
        for colour, (way, rate) in zip(COLOURS, row["rates"].items(), strict=True):
            if rate:
                end = canvas.x(rate)
                canvas.bar(LEFT, y + 1, end, y + thick - 2, colour)
                told = f"{rate / 1e6:.3g} M"
                if way != "vectorised":
                    told += f"; vectorised is x {times(row['rates']['vectorised'] / rate)}"
                canvas.write(end + 5, y + thick / 2, told, "lm")
            canvas.write(LEFT - 6, y + thick / 2, way, "rm")
            y += thick
        y += gap
    canvas.save(path)
