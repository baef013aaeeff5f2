"""Picture of a bake's error over time, as it was and as it is forecast, both axes logarithmic; and its numbers as rows."""

import math
from dataclasses import dataclass

import numpy as np
from PIL import Image

from ..accuracy.history import History, Mark
from ..accuracy.stopping import format_seconds
from . import canvas
from .canvas import Canvas, save_picture, to_pixels

BASE = 400
"""Height of a picture whose lines and letters have their nominal size. [pixel]"""

LEAST_ZOOM = 0.8
"""Letters do not become smaller than that, so that they can be read. [-]"""

SMALLEST, LARGEST = (160, 90), (8192, 8192)
"""Sizes that can be drawn. [pixel]"""

TIMES = (
    *(f * p for p in (0.001, 0.01, 0.1) for f in (1, 2, 5)), 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800,
    *(3600 * f * p for p in (1, 10, 100, 1000) for f in (1, 2, 5)),
)  # fmt: skip
"""Round times at which the axis may be marked. [s]"""

POINTS = 96
"""Points of the branch that is forecast."""

MOST_DOTS = 400
"""Most marks of a line; of more, some are left out evenly over the logarithm of time."""

NEAR = 1.25
"""Ratio to the target within which the error at the forecast end is taken to be the target itself."""

DONE = 1.0 + 1e-9
"""Ratio to the target up to which it counts as reached."""


@dataclass(frozen=True)
class Colours(canvas.Colours):
    """Colours of a graph, with those of the target and of earlier forecasts; the error has that of the second curve."""

    target: str
    earlier: str


LIGHT = Colours(**vars(canvas.LIGHT), target="#2c8a4b", earlier="#c3d3e5")
DARK = Colours(**vars(canvas.DARK), target="#63cf86", earlier="#41597a")


def draw_error_graph(
    history: History, path=None, size: tuple[int, int] = (960, 540), dark: bool = False
) -> Image.Image:
    """Draw the error so far, the forecast branch down to the target, and the forecasts that were made before.

    A faint dot stands at the end that was forecast when the error was as high as the dot; so forecasts that
    hold stand in a column.

    Parameters
    ----------
    history : History
    path : str, Path or None    PNG file that is written too; None: none.
    size : (int, int)    Width and height. [pixel]
    dark : bool    Light lines on a dark ground.

    Returns
    -------
    Image    RGB.

    Raises
    ------
    FileFormatError    The file cannot be written.
    """
    width, height = (
        min(max(int(s), low), high) for s, low, high in zip(size, SMALLEST, LARGEST, strict=True)
    )
    picture = _Graph(history, (width, height), DARK if dark else LIGHT).draw()
    if path is not None:
        save_picture(picture, path, optimize=True)
    return picture


def graph_pixels(history: History, **options) -> np.ndarray:
    """Picture of `draw_error_graph`, whose options it takes, as Blender keeps images.

    Returns
    -------
    (h, w, 4) float32 array    Display-encoded RGBA 0..1, the bottom row first.
    """
    return to_pixels(draw_error_graph(history, **options))


def to_rows(history: History) -> list[dict]:
    """Marks as rows for JSON and tables; what is unknown is None.

    Returns
    -------
    list of dict    ``seconds`` [s], ``samples``, ``relative_standard_error`` [-], ``forecast_seconds`` [s].
    """
    return [
        {
            "seconds": mark.seconds,
            "samples": mark.samples,
            "relative_standard_error": mark.error if math.isfinite(mark.error) else None,
            "forecast_seconds": mark.forecast,
        }
        for mark in history.marks
    ]


def error_ticks(low: float, high: float, most: int) -> list[float]:
    """Round values (1, 2 and 5 times powers of ten, or fewer of them) between two errors."""
    powers = range(math.floor(math.log10(low)) - 1, math.ceil(math.log10(high)) + 1)
    for factors in ((1, 2, 5), (1, 3), (1,)):
        found = [f * 10.0**p for p in powers for f in factors]
        found = [value for value in found if low * 0.999 <= value <= high * 1.001]
        if len(found) <= most:
            return found
    return _thinned(found, most)


def time_ticks(low: float, high: float, most: int) -> list[float]:
    """Round times between two times. [s]"""
    return _thinned([time for time in TIMES if low * 0.999 <= time <= high * 1.001], most)


def _thinned(values: list[float], most: int) -> list[float]:
    """At most so many values that lie evenly in the list."""
    return values[:: max(math.ceil(len(values) / max(most, 1)), 1)]


def _tick_text(seconds: float) -> str:
    """Short form of a round time."""
    for unit, length in (("h", 3600.0), ("min", 60.0), ("s", 1.0)):
        if seconds >= length:
            return f"{seconds / length:g} {unit}"
    return f"{seconds:g} s"


def _percent(error: float) -> str:
    """Three digits, without an exponent."""
    value = 100.0 * error
    if value >= 1e4:
        return f"{value:.1e} %"
    digits = max(2 - math.floor(math.log10(value)), 0) if value > 0.0 else 0
    return f"{value:.{digits}f} %"


def _round_percent(error: float) -> str:
    return f"{100.0 * error:.6g} %"


def _count(value: float) -> str:
    """Whole number, from a thousand on with three digits, thousands set off by blanks."""
    if value >= 1000.0:
        unit = 10.0 ** (math.floor(math.log10(value)) - 2)
        value = round(value / unit) * unit
    return f"{value:,.0f}".replace(",", " ")


class _Graph(Canvas):
    """The picture under way."""

    def __init__(self, history: History, size, colours: Colours):
        super().__init__(size, colours, max(size[1] / BASE, LEAST_ZOOM))
        self.history = history
        self.marks = [
            mark for mark in history.marks if 0.0 < mark.error < math.inf and mark.seconds > 0.0
        ]
        target = history.target
        self.target = target if target is not None and 0.0 < target < math.inf else None
        self.last = self.marks[-1] if self.marks else None
        self.is_done = self.last is not None and (
            (self.target is not None and self.last.error <= self.target * DONE)
            or (self.last.forecast is not None and self.last.forecast <= self.last.seconds)
        )
        self.branch = self._branch()
        self.low, self.high = self._limits()

    def draw(self) -> Image.Image:
        """Draw everything and return the picture in its size."""
        self._draw_axes()
        if self.last is not None:
            self._draw_target()
            self._draw_earlier()
            self._draw_curves()
        self._write_head()
        return self.finish()

    # ---- what is drawn ----

    def _branch(self) -> list[tuple[float, float]]:
        """Times and errors from now to the forecast end: the inverse square of the error grows evenly in time."""
        now = self.last
        if self.is_done or now is None or now.forecast is None:
            return []
        setup = min(self.history.setup_seconds, 0.999 * now.seconds)
        end = self.history.end_error
        if end is None:
            end = now.error * math.sqrt((now.seconds - setup) / (now.forecast - setup))
        # A pass with other samples than the ones before it makes the error fall faster than by the root of time.
        if self.target is not None and end <= NEAR * self.target:
            end = self.target
        times = np.geomspace(now.seconds, now.forecast, POINTS)
        share = (times - now.seconds) / (now.forecast - now.seconds)
        squares = 1.0 / now.error**2 + share * (1.0 / end**2 - 1.0 / now.error**2)
        return list(zip(times.tolist(), (squares**-0.5).tolist(), strict=True))

    def _limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Logarithms of the smallest and largest time and error that are shown."""
        points = [(mark.seconds, mark.error) for mark in self.marks] + self.branch
        if not points:
            return (0.0, -2.0), (2.0, 0.0)
        times, errors = zip(*points, strict=True)
        earlier = [m.forecast for m in self.marks if m.forecast is not None and m.forecast > 0.0]
        # Forecasts that were far too long would squeeze the rest.
        times = [*times, *(time for time in earlier if time < 3.0 * max(times))]
        errors = [*errors, *([] if self.target is None else [self.target])]
        low = [math.log10(min(each)) for each in (times, errors)]
        high = [math.log10(max(each)) for each in (times, errors)]
        for i, room in enumerate((0.04, 0.08)):
            span = max(high[i] - low[i], 0.3)
            middle = 0.5 * (high[i] + low[i])
            low[i], high[i] = middle - (0.5 + room) * span, middle + (0.5 + room) * span
        return tuple(low), tuple(high)

    @property
    def window(self) -> tuple[float, float, float, float]:
        """Left, top, right and bottom of the part in which curves are drawn."""
        unit = self.zoom
        return 52 * unit, 76 * unit, self.size[0] - 22 * unit, self.size[1] - 34 * unit

    def place(self, seconds: float, error: float) -> tuple[float, float]:
        """Pixel of a time [s] and an error."""
        left, top, right, bottom = self.window
        across = (math.log10(seconds) - self.low[0]) / (self.high[0] - self.low[0])
        up = (math.log10(error) - self.low[1]) / (self.high[1] - self.low[1])
        return left + across * (right - left), bottom - up * (bottom - top)

    def _draw_axes(self) -> None:
        left, top, right, bottom = self.window
        unit = self.zoom
        if self.last is not None:
            low, high = ([10.0**value for value in ends] for ends in (self.low, self.high))
            free = left - 15 * unit
            for time in time_ticks(low[0], high[0], int((right - left) / (58 * unit))):
                x, _ = self.place(time, high[1])
                self.line([(x, top), (x, bottom)], self.colours.grid)
                if x - free > 15 * unit:
                    text = _tick_text(time)
                    free = self.write((x, bottom + 6 * unit), text, 11, "mt", is_caption=True)
            for error in error_ticks(low[1], high[1], int((bottom - top) / (24 * unit))):
                _, y = self.place(low[0], error)
                self.line([(left, y), (right, y)], self.colours.grid)
                self.write((left - 7 * unit, y), _round_percent(error), 11, "rm", is_caption=True)
        self.line(
            [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)],
            self.colours.axis,
        )

    def _draw_target(self) -> None:
        """Line of the error that was asked for."""
        if self.target is None:
            return
        left, _, right, _ = self.window
        unit = self.zoom
        _, y = self.place(self.last.seconds, self.target)
        self.line([(left, y), (right, y)], self.colours.target, 1.5)
        text = f"target {_round_percent(self.target)}"
        self.write(
            (left + 7 * unit, y - 4 * unit), text, 11, "lb", self.colours.target, has_halo=True
        )

    def _draw_earlier(self) -> None:
        """Dots where the end was believed to be."""
        left, _, right, _ = self.window
        marks = [
            m for m in self._shown(self.marks[:-1]) if m.forecast is not None and m.forecast > 0.0
        ]
        places = [self.place(mark.forecast, mark.error) for mark in marks]
        places = [place for place in places if place[0] <= right]
        for place in places:
            self.dot(place, self.colours.earlier, 2.4)
        if len(places) < 3:
            return
        # Beside the dots, on the side that the curve leaves free.
        x, y = places[len(places) // 3]
        gap = 8 * self.zoom
        is_left = x - left > 0.6 * (right - left)
        place, anchor = ((x - gap, y), "rm") if is_left else ((x + gap, y), "lm")
        self.write(place, "earlier forecasts", 10, anchor, is_caption=True)

    def _draw_curves(self) -> None:
        """The branch that is forecast, the error so far, and where both meet."""
        unit = self.zoom
        if self.branch:
            path = np.array([self.place(*point) for point in self.branch])
            self.dashed(path, self.colours.curves[1], 1.8, (6, 5))
            x, y = path[-1]
            self.line([(x, y), (x, self.window[3])], self.colours.axis)
            self.dot((x, y), self.colours.background, 4.5, self.colours.curves[1])
        shown = self._shown(self.marks)
        places = [self.place(mark.seconds, mark.error) for mark in shown]
        if len(places) > 1:
            self.line(places, self.colours.curves[1], 2.4)
        if len(places) <= 40:
            for place in places[:-1]:
                self.dot(place, self.colours.curves[1], 2.4)
        x, y = places[-1]
        self.dot((x, y), self.colours.curves[1], 5.0, self.colours.background)
        text = "done" if self.is_done else "now"
        on_right = x < self.window[2] - 60 * unit
        shift, anchor = (9 * unit, "lb") if on_right else (-9 * unit, "rt")
        y += -5 * unit if on_right else 8 * unit
        self.write((x + shift, y), text, 12, anchor, has_halo=True)

    def _shown(self, marks: list[Mark]) -> list[Mark]:
        """Marks, or some of very many."""
        if len(marks) <= MOST_DOTS:
            return marks
        place = np.log([mark.seconds for mark in marks])
        wanted = np.linspace(place[0], place[-1], MOST_DOTS)
        return [marks[i] for i in np.unique(np.searchsorted(place, wanted).clip(0, len(marks) - 1))]

    # ---- words ----

    def _write_head(self) -> None:
        """Error and target, time and samples: done on the left, still to come on the right."""
        left, top, right, bottom = self.window
        unit, now = self.zoom, self.last
        if now is None:
            seconds = self.history.marks[-1].seconds if self.history.marks else 0.0
            middle = (0.5 * (left + right), 0.5 * (top + bottom))
            self.write(
                middle, "no error is known before the second pass", 13, "mm", is_caption=True
            )
            self.write((left, 24 * unit), "Error over time", 18, "lm")
            if seconds > 0.0:
                text = f"{format_seconds(seconds)} elapsed"
                self.write((right, 25 * unit), text, 13, "rm", is_caption=True)
            return
        end = self.write((left, 24 * unit), f"Error {_percent(now.error)}", 18, "lm")
        if self.target is not None:
            text = f"of {_round_percent(self.target)} asked for"
            self.write((end + 9 * unit, 26 * unit), text, 13, "lm", is_caption=True)
        done = f"{format_seconds(now.seconds)} elapsed, {_count(now.samples)} samples per lumel"
        self.write((left, 49 * unit), done, 12, "lm", is_caption=True)
        if self.is_done:
            self.write((right, 24 * unit), "done", 18, "rm", self.colours.target)
        elif now.forecast is None:
            self.write((right, 25 * unit), "no forecast yet", 13, "rm", is_caption=True)
        else:
            rest = now.forecast - now.seconds
            self.write((right, 24 * unit), f"{format_seconds(rest)} left", 18, "rm")
            more = f"of {format_seconds(now.forecast)}"
            if self._samples_left() >= 1.0:
                more += f", {_count(self._samples_left())} samples more"
            self.write((right, 49 * unit), more, 12, "rm", is_caption=True)

    def _samples_left(self) -> float:
        """Samples per lumel until the forecast end, at the rate of the second half of the marks."""
        now, first = self.last, self.marks[len(self.marks) // 2 - 1]
        if now.seconds > first.seconds:
            rate = (now.samples - first.samples) / (now.seconds - first.seconds)
        else:
            rate = now.samples / max(now.seconds - self.history.setup_seconds, 1e-9)
        return max(rate * (now.forecast - now.seconds), 0.0)
