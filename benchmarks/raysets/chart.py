"""Pictures of the benchmark of ray sets: errors over the size of the file and over the rays that are generated."""

import math
from pathlib import Path

from ..common.chart import INK, SCALE, Picture

PANEL, MARGIN, GAP = (270, 250), (70, 46), 30
"""Size of a panel's axes, free space left and above, and between panels. [pixel]"""

BELOW, LEGEND = 60, 40
"""Free space below the axes: for numbers, and for the legend. [pixel]"""

DISTANCE_COLOURS = {0.5: "#9467bd", 1.0: "#1f77b4", 2.0: "#2ca02c", 5.0: "#ff7f0e", 20.0: "#d62728"}

GREY = "#dddddd"


class Panels(Picture):
    """Panels side by side with the same axes. ``across``, ``up``: logarithms of their ends."""

    def __init__(self, titles, across, up, unit: str):
        self.low, self.high = (across[0], up[0]), (across[1], up[1])
        width = MARGIN[0] + len(titles) * (PANEL[0] + GAP)
        super().__init__((width, MARGIN[1] + PANEL[1] + BELOW + LEGEND), 12)
        for number, title in enumerate(titles):
            self._draw_axes(number, title, unit)

    def place(self, number: int, x: float, y: float) -> tuple[float, float]:
        """Pixel of a point of a panel; what lies beyond the axes lies at their ends."""
        spot = []
        for axis, value in enumerate((x, y)):
            power = math.log10(max(value, 1e-30))
            share = (power - self.low[axis]) / (self.high[axis] - self.low[axis])
            spot.append(min(max(share, 0.0), 1.0))
        left = MARGIN[0] + number * (PANEL[0] + GAP)
        return left + spot[0] * PANEL[0], MARGIN[1] + (1.0 - spot[1]) * PANEL[1]

    def curve(self, number: int, points, colour: str, is_dashed: bool = False) -> None:
        """Draw a line with dots."""
        places = [self.place(number, *point) for point in points]
        for (x0, y0), (x1, y1) in zip(places, places[1:], strict=False):
            steps = 24 if is_dashed else 1
            for k in range(0, steps, 2):
                a, b = k / steps, (k + 1) / steps
                ends = [(x0 + t * (x1 - x0), y0 + t * (y1 - y0)) for t in (a, b)]
                self.line(ends, colour, 2)
        for x, y in places:
            box = [SCALE * v for v in (x - 3, y - 3, x + 3, y + 3)]
            self.pen.ellipse(
                box, fill="white" if is_dashed else colour, outline=colour, width=SCALE
            )

    def name(self, entries) -> None:
        """Name the lines: (text, colour, whether dashed)."""
        x, y = MARGIN[0], self.size[1] - LEGEND / 2
        for text, colour, is_dashed in entries:
            for k in range(0, 3 if is_dashed else 1, 2):
                end = x + 8 + 8 * k if is_dashed else x + 24
                self.line([(x + 8 * k, y), (end, y)], colour, 3)
            self.write(x + 30, y, text, "lm")
            x += 44 + 7 * len(text)

    def _draw_axes(self, number: int, title: str, unit: str) -> None:
        for power in range(math.ceil(self.low[1]), math.floor(self.high[1]) + 1):
            start = self.place(number, 10.0 ** self.low[0], 10.0**power)
            end = self.place(number, 10.0 ** self.high[0], 10.0**power)
            self.line([start, end], GREY)
            if number == 0:
                self.write(start[0] - 8, start[1], f"{100 * 10.0**power:g} %", "rm")
        for power in range(math.ceil(self.low[0]), math.floor(self.high[0]) + 1):
            start = self.place(number, 10.0**power, 10.0 ** self.low[1])
            end = self.place(number, 10.0**power, 10.0 ** self.high[1])
            self.line([start, end], GREY)
            self.write(start[0], start[1] + 12, f"{10**power:,}".replace(",", " "), "mm")
        left = MARGIN[0] + number * (PANEL[0] + GAP)
        self.write(left, MARGIN[1] - 16, title, "lm")
        self.write(left + PANEL[0] / 2, MARGIN[1] + PANEL[1] + 32, unit, "mm")


def draw_errors(rows: list[dict], path: Path) -> None:
    """Draw errors of even numbers over the size of the file, a panel for every source."""
    sources = list(dict.fromkeys(row["source"] for row in rows))
    panels = Panels(sources, (2.8, 6.2), (-3.0, 0.3), "rays of the file")
    for number, source in enumerate(sources):
        for distance, colour in DISTANCE_COLOURS.items():
            own = [
                row
                for row in rows
                if (row["source"], row["numbers"], row["distance"]) == (source, "even", distance)
            ]
            for name, is_dashed in (("repeated", True), ("generated", False)):
                panels.curve(number, [(r["rays"], r[name]) for r in own], colour, is_dashed)
    names = [(f"{d:g} sizes", colour, False) for d, colour in DISTANCE_COLOURS.items()]
    panels.name([*names, ("rays of the file alone", INK, True)])
    panels.save(path)


def draw_convergence(result: dict, path: Path) -> None:
    """Draw errors over the number of generated rays."""
    rows = result["rows"]
    panels = Panels(
        ["error against the exact light", "scatter of repetitions"], (3.2, 5.8), (-2.5, 0.5), "rays"
    )
    for name, colour, is_dashed in (("generated", "#2ca02c", False), ("repeated", "#d62728", True)):
        panels.curve(0, [(r["rays"], r[f"{name}_error"]) for r in rows], colour, is_dashed)
        points = [(r["rays"], math.sqrt(r[f"{name}_variance"])) for r in rows]
        panels.curve(1, points, colour, is_dashed)
    ends = [(rows[0]["rays"], result["stated"]), (rows[-1]["rays"], result["stated"])]
    panels.curve(0, ends, "#1f77b4", True)
    panels.name(
        [
            ("generated", "#2ca02c", False),
            ("repeated", "#d62728", True),
            ("stated information error", "#1f77b4", True),
        ]
    )
    panels.save(path)
