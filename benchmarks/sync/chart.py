"""Picture of the times of edits against the number of triangles, both axes logarithmic."""

import math
from pathlib import Path
from statistics import median

from ..common.chart import Picture
from .figures import SCENES

CURVES = {
    "move": "#1f77b4",
    "add": "#17becf",
    "delete": "#2ca02c",
    "deform": "#9467bd",
    "material value": "#d62728",
    "light power": "#ff7f0e",
    "camera": "#8c564b",
}
"""Edits that are drawn, and their colours."""

FULL = "#000000"

SIZE, MARGINS = (900, 520), (80, 30, 190, 60)
"""Size of the picture; free space left, above, right and below. [pixel]"""


def draw_chart(result: dict, path: Path, objects: int | None = None) -> None:
    """Draw the times of scenes with ``objects`` objects; None: with the most there are."""
    count = objects or max(row["objects"] for row in result["full"])
    curves = {"full sync": (_times(result["full"], count), FULL)}
    for edit, colour in CURVES.items():
        rows = [row for row in result["edits"] if row["edit"] == edit and row["nth"] > 1]
        curves[edit] = (_times(rows, count), colour)
    chart = _Chart([point for points, _ in curves.values() for point in points])
    chart.draw_axes(f"{count} objects: time from edit to first sample, second and later edits [ms]")
    for row, (name, (points, colour)) in enumerate(curves.items()):
        chart.draw_curve(row, name, points, colour)
    chart.save(path)


def _times(rows, objects: int) -> list[tuple[float, float]]:
    """Median times by size of scene. [triangles, ms]"""
    points = []
    for scene, triangles in SCENES.items():
        found = [r["seconds"] for r in rows if (r["scene"], r["objects"]) == (scene, objects)]
        if found:
            points.append((float(triangles), 1e3 * median(found)))
    return points


class _Chart(Picture):
    """Axes that hold all points."""

    def __init__(self, points):
        super().__init__(SIZE, 14)
        x = [math.log10(point[0]) for point in points] or [4.0]
        y = [math.log10(point[1]) for point in points] or [1.0]
        self.low = (min(x) - 0.1, math.floor(min(y)))
        self.high = (max(x) + 0.1, max(math.ceil(max(y)), math.floor(min(y)) + 1))

    def place(self, x: float, y: float) -> tuple[float, float]:
        """Pixel of a point whose logarithms are given."""
        left, top, right, bottom = MARGINS
        across = (x - self.low[0]) / (self.high[0] - self.low[0])
        up = (y - self.low[1]) / (self.high[1] - self.low[1])
        return (
            left + across * (SIZE[0] - left - right),
            SIZE[1] - bottom - up * (SIZE[1] - top - bottom),
        )

    def draw_axes(self, title: str) -> None:
        """Draw a line for every power of ten of the time and every scene."""
        for power in range(self.low[1], self.high[1] + 1):
            start, end = self.place(self.low[0], power), self.place(self.high[0], power)
            self.line([start, end], "#cccccc")
            self.write(start[0] - 8, start[1], f"{10**power:g}", "rm")
        for name, triangles in SCENES.items():
            x = math.log10(triangles)
            if self.low[0] <= x <= self.high[0]:
                start, end = self.place(x, self.low[1]), self.place(x, self.high[1])
                self.line([start, end], "#eeeeee")
                self.write(start[0], start[1] + 16, name, "mm")
        middle = self.place(0.5 * (self.low[0] + self.high[0]), self.low[1])
        self.write(middle[0], middle[1] + 40, "triangles", "mm")
        self.write(MARGINS[0], 14, title, "lm")

    def draw_curve(self, row: int, name: str, points, colour: str) -> None:
        """Draw a line with dots, and its name on the right."""
        places = [self.place(math.log10(x), math.log10(y)) for x, y in points]
        if len(places) > 1:
            self.line(places, colour, 2)
        for x, y in places:
            self.mark(x, y, colour, radius=4)
        x, y = SIZE[0] - MARGINS[2] + 20, 60 + 26 * row
        self.line([(x, y), (x + 24, y)], colour, 3)
        self.write(x + 32, y, name, "lm")
