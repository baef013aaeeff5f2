"""Pictures of the benchmark of the atlas: error over time, true over stated error, time over size."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from .bars import CALIBRATION
from .race import OURS, RIVALS, ways_of

STYLES = {
    OURS: ("#0072b2", "disk"),
    "plain_gather": ("#d55e00", "square"),
    "cycles": ("#cc79a7", "diamond"),
    "radiance": ("#009e73", "triangle"),
    "radiance, cached": ("#56b4e9", "triangle"),
}
"""Colours, which people who see few colours tell apart (Okabe and Ito), and shapes."""

SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")

SCALE = 2
"""Pictures are drawn so many times larger, for smooth lines."""

PANEL = (500, 360)
"""Size of a panel. [pixel]"""

LEFT, RIGHT, TOP, BOTTOM = 66, 26, 34, 50
"""Free space in a panel. [pixel]"""

HEAD = 40
"""Height of the legend. [pixel]"""

INK, GRID, GUIDE = "#222222", "#dddddd", "#999999"


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


def draw_races(races: list[dict], path: Path) -> None:
    """Draw error over time, a panel for every scene."""
    picture = _Picture(len(races))
    names = [name for name in STYLES if any(_curves(race).get(name) for race in races)]
    titles = {"radiance": "Radiance", "radiance, cached": "Radiance with cache", **RIVALS}
    picture.legend([(titles.get(name, name), *STYLES[name]) for name in names])
    points = [p for race in races for curve in _curves(race).values() for p in curve]
    x = decades("time [s]", [seconds for seconds, _ in points])
    y = decades(
        "RMS relative error", [error for _, error in points], lambda value: f"{100 * value:g} %"
    )
    for number, race in enumerate(races):
        panel = _Panel(picture, number, f"{race['title']} ({race['key']})", x, y)
        panel.level(0.01)
        panel.level(0.02)
        for name, curve in _curves(race).items():
            panel.line(curve, STYLES[name][0])
            for point in curve:
                panel.mark(*point, *STYLES[name])
    picture.save(path)


def _curves(race: dict) -> dict[str, list]:
    made = {}
    for name, row in race["programs"].items():
        if "refusal" in row:
            continue
        for way, runs in ways_of(row).items():
            made[f"{name}, cached" if way == "cached" else name] = runs["points"]
    return made


def draw_calibration(scenes: list[dict], path: Path) -> None:
    """Draw true over stated error of every bake, scene by scene, and the share of intervals that hold."""
    picture = _Picture(2)
    shapes = ("disk", "square", "triangle", "diamond")
    levels = sorted({run["level"] for scene in scenes for run in scene["runs"]}, reverse=True)
    styles = {
        level: (colour, shape) for level, colour, shape in zip(levels, SERIES, shapes, strict=False)
    }
    picture.legend([(f"asked for {100 * level:g} %", *styles[level]) for level in levels])
    names = [scene["key"] for scene in scenes]
    x = Axis(
        "",
        -0.5,
        len(names) - 0.5,
        [float(k) for k in range(len(names))],
        tell=lambda value: names[round(value)],
    )
    ratios = [run["ratio"] for scene in scenes for run in scene["runs"]]
    high = max(1.4, 0.1 * math.ceil(10 * max(ratios)))
    low = min(0.6, 0.1 * math.floor(10 * min(ratios)))
    step = 0.1 if high - low < 1.2 else 0.5
    ticks = [step * k for k in range(math.ceil(low / step), math.floor(high / step) + 1)]
    panel = _Panel(picture, 0, "True over stated error", x, Axis("", low, high, ticks, tell=_short))
    for value in (*CALIBRATION, 1.0):
        panel.level(value)
    covered = _Panel(
        picture,
        1,
        "Lumels whose 95 % interval holds",
        x,
        Axis("", 85.0, 100.0, [85.0, 90.0, 93.0, 95.0, 97.0, 100.0], tell=lambda v: f"{v:g} %"),
    )
    covered.level(95.0)
    for number, scene in enumerate(scenes):
        for k, run in enumerate(scene["runs"]):
            place = number + 0.5 * ((k + 0.5) / len(scene["runs"]) - 0.5)
            panel.mark(place, run["ratio"], *styles[run["level"]])
            covered.mark(place, 100 * run["covered"], *styles[run["level"]])
    picture.save(path)


def draw_scale(scale: dict, path: Path) -> None:
    """Draw time and memory over lumels."""
    picture = _Picture(2)
    rows = scale["runs"]
    kinds = sorted({round(row["triangles"] / 1e6, 1) for row in rows})
    colours = dict(zip(kinds, SERIES, strict=False))
    picture.legend([(f"{kind:g} M triangles", colour, "disk") for kind, colour in colours.items()])
    x = decades("lumels", [row["lumels"] for row in rows], lambda value: f"{value / 1e6:g} M")
    for number, (name, title) in enumerate((("seconds", "time [s]"), ("memory", "memory [GiB]"))):
        y = decades(title, [row[name] for row in rows])
        panel = _Panel(picture, number, f"{title} over lumels", x, y)
        for kind, colour in colours.items():
            mine = [
                (row["lumels"], row[name])
                for row in rows
                if round(row["triangles"] / 1e6, 1) == kind
            ]
            panel.line(sorted(mine), colour)
            for point in mine:
                panel.mark(*point, colour, "disk")
    picture.save(path)


def _short(value: float) -> str:
    return f"{value:.1f}"


class _Picture:
    """What is drawn on: panels in rows of two, in pixels of the finished picture."""

    def __init__(self, panels: int):
        columns = min(panels, 2)
        self.size = (columns * PANEL[0], HEAD + -(-panels // columns) * PANEL[1])
        self.columns = columns
        self.image = Image.new("RGB", (self.size[0] * SCALE, self.size[1] * SCALE), "white")
        self.pen = ImageDraw.Draw(self.image)
        self.font = ImageFont.load_default(13 * SCALE)

    def write(self, x: float, y: float, text: str, anchor: str) -> None:
        self.pen.text((SCALE * x, SCALE * y), text, fill=INK, font=self.font, anchor=anchor)

    def write_upwards(self, x: float, y: float, text: str) -> None:
        """Write about a middle, turned by a quarter."""
        if not text:
            return
        left, top, right, bottom = (round(v) for v in self.font.getbbox(text))
        strip = Image.new("L", (right - left + 4, bottom - top + 4))
        ImageDraw.Draw(strip).text((2 - left, 2 - top), text, fill=255, font=self.font)
        strip = strip.rotate(90, expand=True)
        place = (round(SCALE * x - strip.width / 2), round(SCALE * y - strip.height / 2))
        self.image.paste(Image.new("RGB", strip.size, INK), place, strip)

    def line(self, places, colour: str, width: float = 1.0) -> None:
        scaled = [(SCALE * x, SCALE * y) for x, y in places]
        self.pen.line(scaled, fill=colour, width=round(width * SCALE), joint="curve")

    def mark(self, x: float, y: float, colour: str, shape: str, radius: float = 4.5) -> None:
        corners = {
            "square": [(-0.85, -0.85), (0.85, -0.85), (0.85, 0.85), (-0.85, 0.85)],
            "triangle": [(0.0, -1.15), (1.05, 0.75), (-1.05, 0.75)],
            "diamond": [(0.0, -1.2), (1.0, 0.0), (0.0, 1.2), (-1.0, 0.0)],
        }
        if shape == "disk":
            box = [SCALE * (v + s * radius) for s in (-1, 1) for v in (x, y)]
            self.pen.ellipse(box, fill=colour)
            return
        places = [(SCALE * (x + radius * u), SCALE * (y + radius * v)) for u, v in corners[shape]]
        self.pen.polygon(places, fill=colour)

    def legend(self, entries: list[tuple[str, str, str]]) -> None:
        """Name curves: text, colour, shape."""
        x = 20.0
        for text, colour, shape in entries:
            self.line([(x, HEAD / 2), (x + 28, HEAD / 2)], colour, 2)
            self.mark(x + 14, HEAD / 2, colour, shape)
            self.write(x + 36, HEAD / 2, text, "lm")
            x += 36 + self.font.getlength(text) / SCALE + 22

    def save(self, path: Path) -> None:
        small = self.image.resize(self.size, Image.Resampling.LANCZOS)
        small.quantize(256, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(
            path, optimize=True
        )


class _Panel:
    """Axes in a part of a picture."""

    def __init__(self, picture: _Picture, number: int, title: str, across: Axis, up: Axis):
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
        picture.write_upwards(self.x + 10, self.y + (TOP + PANEL[1] - BOTTOM) / 2, up.title)
