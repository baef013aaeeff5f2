"""Panels with axes, for charts of several curves."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from .chart import Picture

PANEL = (500, 360)
"""Size of a panel. [pixel]"""

LEFT, RIGHT, TOP, BOTTOM = 66, 26, 34, 50
"""Free space in a panel. [pixel]"""

HEAD = 40
"""Height of the legend. [pixel]"""

GRID, GUIDE = "#dddddd", "#999999"


@dataclass
class Axis:
    """Numbers along an edge.

    Parameters
    ----------
    title : str
    low, high : float    Ends.
    ticks : list of float    Where lines are.
    is_logarithmic : bool
    tell : callable    Text of a tick.
    """

    title: str
    low: float
    high: float
    ticks: list[float]
    is_logarithmic: bool = False
    tell: Callable[[float], str] = field(default=lambda value: f"{value:g}")

    def share(self, value: float) -> float:
        """Place between the ends, 0 to 1."""
        low, high = self.low, self.high
        if self.is_logarithmic:
            low, high, value = math.log(low), math.log(high), math.log(max(value, 1e-30))
        return min(max((value - low) / (high - low), 0.0), 1.0)


def decades(title: str, values: list[float], tell=lambda value: f"{value:g}") -> Axis:
    """Logarithmic axis between powers of ten that hold all values."""
    low = math.floor(math.log10(max(min(values), 1e-9)))
    high = max(math.ceil(math.log10(max(values))), low + 1)
    return Axis(title, 10.0**low, 10.0**high, [10.0**k for k in range(low, high + 1)], True, tell)


class PanelPicture(Picture):
    """Panels in rows of two under a legend."""

    def __init__(self, panels: int):
        self.columns = min(panels, 2)
        super().__init__((self.columns * PANEL[0], HEAD + -(-panels // self.columns) * PANEL[1]))


class Panel:
    """Axes in a part of a picture."""

    def __init__(self, picture: PanelPicture, number: int, title: str, across: Axis, up: Axis):
        line, column = divmod(number, picture.columns)
        self.picture, self.across, self.up = picture, across, up
        self.x, self.y = column * PANEL[0], HEAD + line * PANEL[1]
        self._draw_axes(title)

    def place(self, a: float, b: float) -> tuple[float, float]:
        """Pixel of a point."""
        width, height = PANEL[0] - LEFT - RIGHT, PANEL[1] - TOP - BOTTOM
        x = self.x + LEFT + self.across.share(a) * width
        return x, self.y + TOP + (1.0 - self.up.share(b)) * height

    def level(self, value: float) -> None:
        """Draw a line across."""
        ends = [self.place(end, value) for end in (self.across.low, self.across.high)]
        self.picture.line(ends, GUIDE)

    def line(self, points, colour: str) -> None:
        """Draw a curve."""
        if len(points) > 1:
            self.picture.line([self.place(*point) for point in points], colour, 2)

    def mark(self, a: float, b: float, colour: str, shape: str) -> None:
        """Draw a point."""
        self.picture.mark(*self.place(a, b), colour, shape)

    def _draw_axes(self, title: str) -> None:
        across, up, picture = self.across, self.up, self.picture
        for tick in across.ticks:
            ends = [self.place(tick, end) for end in (up.low, up.high)]
            picture.line(ends, GRID)
            picture.write(ends[0][0], ends[0][1] + 13, across.tell(tick), "mm")
        for tick in up.ticks:
            ends = [self.place(end, tick) for end in (across.low, across.high)]
            picture.line(ends, GRID)
            picture.write(ends[0][0] - 6, ends[0][1], up.tell(tick), "rm")
        picture.write(self.x + LEFT, self.y + 18, title, "lm")
        middle = self.x + LEFT + (PANEL[0] - LEFT - RIGHT) / 2
        picture.write(middle, self.y + PANEL[1] - 16, across.title, "mm")
        if up.title:
            picture.write_upwards(self.x + 10, self.y + (TOP + PANEL[1] - BOTTOM) / 2, up.title)
