"""Pictures of the benchmark of luminaires: deviations from Radiance by file, and speeds, both on logarithmic axes."""

import math
from pathlib import Path

from ..common.chart import Picture
from .agreement import BOUND
from .speed import WAYS, times

WIDTH, LEFT, RIGHT, TOP, BOTTOM = 900, 240, 30, 68, 40
"""Width of a picture and free space around its axes. [pixel]"""

ROW = 15
"""Height of a file's row. [pixel]"""

ALIKE, DIFFERENT, CURED = "#1f77b4", "#ff7f0e", "#2ca02c"

COLOURS = ("#1f77b4", "#17becf", "#2ca02c", "#ff7f0e", "#d62728")
"""Of the ways of looking up."""


class _Canvas(Picture):
    """A picture with a logarithmic axis from left to right, in whole powers of ten."""

    def __init__(self, height: int, low: int, high: int, title: str):
        super().__init__((WIDTH, height), 12)
        self.low, self.high, self.height = low, high, height
        self.write(LEFT, 16, title, "lm")

    def x(self, value: float) -> float:
        """Place of a value along the axis; those beyond its ends lie at the ends. [pixel]"""
        power = min(max(math.log10(max(value, 1e-30)), self.low), self.high)
        return LEFT + (WIDTH - LEFT - RIGHT) * (power - self.low) / (self.high - self.low)

    def grid(self, name) -> None:
        """Draw a line for every power of ten, with what ``name`` calls it."""
        for power in range(self.low, self.high + 1):
            x = self.x(10.0**power)
            self.line([(x, TOP), (x, self.height - BOTTOM)], "#dddddd")
            self.write(x, self.height - BOTTOM + 14, name(power), "mm")


def draw_agreement(agreement: dict, path: Path) -> None:
    """Draw the deviations of all points, one row a file."""
    files = agreement["files"]
    height = TOP + BOTTOM + ROW * max(len(files), 1)
    canvas = _Canvas(height, -6, 0, "Relative deviation from Radiance: every point of every file")
    canvas.grid(lambda power: f"{10.0 ** (power + 2):g} %")
    x = canvas.x(BOUND)
    canvas.line([(x, TOP), (x, height - BOTTOM)], "#d62728")
    canvas.write(x, TOP - 8, f"{100 * BOUND:g} %", "mm")
    for number, row in enumerate(files):
        y = TOP + ROW * (number + 0.5)
        canvas.write(LEFT - 10, y, Path(row["file"]).name, "rm")
        colour = DIFFERENT if row["reason"] else ALIKE
        for value in row["deviations"]:
            canvas.mark(canvas.x(abs(value)), y, colour, radius=1.5)
        if row["reason"]:
            canvas.mark(canvas.x(row["without_reason"]), y, CURED, radius=4.0)
    legend = (
        (ALIKE, "alike"),
        (DIFFERENT, "Radiance differs"),
        (CURED, "the reason taken away: largest"),
    )
    x = LEFT
    for colour, text in legend:
        canvas.mark(x + 4, 36, colour, radius=4.0)
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
                low, high = y + 1, y + thick - 2
                canvas.fill([(LEFT, low), (end, low), (end, high), (LEFT, high)], colour)
                told = f"{rate / 1e6:.3g} M"
                if way != "vectorised":
                    told += f"; vectorised is x {times(row['rates']['vectorised'] / rate)}"
                canvas.write(end + 5, y + thick / 2, told, "lm")
            canvas.write(LEFT - 6, y + thick / 2, way, "rm")
            y += thick
        y += gap
    canvas.save(path)
