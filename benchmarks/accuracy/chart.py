"""Pictures of error over time, both axes logarithmic."""

import math
from pathlib import Path

from ..common.chart import Picture
from .statistics import Curve, make_curve, slope_of

STYLES = {
    "Lumenray mono": ("#0072b2", "disk"),
    "Lumenray spectral": ("#d55e00", "square"),
    "Radiance": ("#009e73", "triangle"),
    "Cycles": ("#cc79a7", "diamond"),
    "sensors": ("#0072b2", "disk"),
    "picture": ("#d55e00", "square"),
    "live view": ("#009e73", "triangle"),
}
"""Colours, which people who see few colours tell apart (Okabe and Ito), and shapes."""

PANEL = (500, 360)
"""Size of a panel. [pixel]"""

LEFT, RIGHT, TOP, BOTTOM = 66, 18, 34, 50
"""Free space in a panel. [pixel]"""

HEAD = 40
"""Height of the legend. [pixel]"""

GRID, FINE_GRID, GUIDE = "#cccccc", "#eeeeee", "#999999"

BAND = 60
"""Opacity of bands, of 255."""


def draw_scenes(scenes: list[dict], path: Path) -> None:
    """Draw a panel for every scene."""
    panels = [(f"{scene['title']} ({scene['key']})", _used(scene["programs"])) for scene in scenes]
    _draw(panels, path)


def draw_views(views: dict, path: Path) -> None:
    """Draw the panel of pictures."""
    _draw([("Pixels and as many sensors", _used(views))], path)


def _used(rows: dict) -> dict:
    return {name: row for name, row in rows.items() if "refusal" not in row}


def _draw(panels: list[tuple[str, dict]], path: Path) -> None:
    columns = min(len(panels), 2)
    lines = -(-len(panels) // columns)
    picture = Picture((columns * PANEL[0], HEAD + lines * PANEL[1]))
    names = list(dict.fromkeys(name for _, rows in panels for name in rows))
    x = picture.legend(20.0, HEAD / 2, [(name, *STYLES[name]) for name in names])
    _dash(picture, (x, HEAD / 2), (x + 28, HEAD / 2))
    picture.write(x + 36, HEAD / 2, "slope -1/2", "lm")
    curves = [{name: make_curve(row) for name, row in rows.items()} for _, rows in panels]
    ends = _ends([curve for made in curves for curve in made.values()])
    for number, ((title, rows), made) in enumerate(zip(panels, curves, strict=True)):
        line, column = divmod(number, columns)
        panel = _Panel(picture, column * PANEL[0], HEAD + line * PANEL[1], ends)
        panel.axes(title)
        slopes = {name: slope_of(row) for name, row in rows.items()}
        for name, curve in made.items():
            panel.curve(name, curve)
        panel.slopes({name: slope.value for name, slope in slopes.items() if not slope.bound})
    picture.save(path)


def _ends(curves: list[Curve]) -> tuple[tuple[int, int], tuple[int, int]]:
    """Powers of ten that hold all curves: of seconds and of errors."""
    seconds = [s for curve in curves for s in curve.seconds]
    errors = [e for curve in curves for e in (*curve.low, *curve.high)]
    made = []
    for values in (seconds, errors):
        low = math.floor(math.log10(max(min(values), 1e-6)))
        made.append((low, max(math.ceil(math.log10(max(values))), low + 1)))
    return made[0], made[1]


def _dash(picture: Picture, start, end) -> None:
    """Draw the guide's broken line."""
    length = math.dist(start, end)
    for k in range(int(length / 9) + 1):
        parts = [min((9 * k + d) / length, 1.0) for d in (0, 5)]
        places = [
            (start[0] + t * (end[0] - start[0]), start[1] + t * (end[1] - start[1])) for t in parts
        ]
        picture.line(places, GUIDE)


class _Panel:
    """Axes in a part of a picture."""

    def __init__(self, picture: Picture, x: float, y: float, ends):
        self.picture, self.x, self.y = picture, x, y
        self.seconds, self.errors = ends

    def place(self, seconds: float, error: float) -> tuple[float, float]:
        across = _share(seconds, self.seconds) * (PANEL[0] - LEFT - RIGHT)
        down = (1.0 - _share(error, self.errors)) * (PANEL[1] - TOP - BOTTOM)
        return self.x + LEFT + across, self.y + TOP + down

    def axes(self, title: str) -> None:
        """Draw a line for every power of ten, names of the axes, the title and the guide."""
        (first, last), (low, high) = self.seconds, self.errors
        self._fine_grid()
        for power in range(first, last + 1):
            places = [self.place(10.0**power, 10.0**end) for end in (low, high)]
            self.picture.line(places, GRID)
            self.picture.write(places[0][0], places[0][1] + 13, f"{10.0**power:g}", "mm")
        for power in range(low, high + 1):
            places = [self.place(10.0**end, 10.0**power) for end in (first, last)]
            self.picture.line(places, GRID)
            self.picture.write(places[0][0] - 6, places[0][1], f"{100 * 10.0**power:g} %", "rm")
        middle = self.x + LEFT + (PANEL[0] - LEFT - RIGHT) / 2
        self.picture.write(self.x + LEFT, self.y + 18, title, "lm")
        self.picture.write(middle, self.y + PANEL[1] - 16, "time [s]", "mm")
        self.picture.write_upwards(
            self.x + 10, self.y + (TOP + PANEL[1] - BOTTOM) / 2, "RMS relative error"
        )
        decades = min(last - first, 2 * (high - low))
        start = self.place(10.0**first, 10.0**high)
        _dash(
            self.picture, start, self.place(10.0 ** (first + decades), 10.0 ** (high - decades / 2))
        )

    def _fine_grid(self) -> None:
        (first, last), (low, high) = self.seconds, self.errors
        for step in range(2, 10):
            for power in range(first, last):
                x = step * 10.0**power
                self.picture.line([self.place(x, 10.0**end) for end in (low, high)], FINE_GRID)
            for power in range(low, high):
                y = step * 10.0**power
                self.picture.line([self.place(10.0**end, y) for end in (first, last)], FINE_GRID)

    def curve(self, name: str, curve: Curve) -> None:
        """Draw the band of single rounds, the line and its points; one point where nothing can be timed."""
        colour = STYLES[name][0]
        shown = [k for k in range(len(curve.work)) if curve.is_timed[k]]
        if not shown:
            place = self.place(curve.resolution, curve.errors[-1])
            self.picture.mark(*place, *STYLES[name])
            self.picture.write(place[0] - 8, place[1], "<", "rm", colour)
            return
        lower = [self.place(curve.seconds[k], curve.low[k]) for k in shown]
        upper = [self.place(curve.seconds[k], curve.high[k]) for k in shown]
        if len(shown) > 1:
            self.picture.fill(lower + upper[::-1], colour, BAND)
        middle = [self.place(curve.seconds[k], curve.errors[k]) for k in shown]
        self.picture.line(middle, colour, 2)
        for place in middle:
            self.picture.mark(*place, *STYLES[name])

    def slopes(self, slopes: dict[str, float]) -> None:
        """Write the slopes into the upper right corner."""
        x, y = self.x + PANEL[0] - RIGHT - 8, self.y + TOP + 14
        if not slopes:
            return
        self.picture.write(x, y, "slopes", "rm")
        for name, slope in slopes.items():
            y += 18
            self.picture.write(x, y, f"{slope:.2f}", "rm")
            self.picture.mark(x - 44, y, *STYLES[name])


def _share(value: float, ends: tuple[int, int]) -> float:
    """Place between the ends of an axis, 0 to 1."""
    low, high = ends
    return (min(max(math.log10(max(value, 1e-30)), low), high) - low) / (high - low)
