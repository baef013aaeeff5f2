"""False colours of a chart with the bar that explains them."""

import math
from dataclasses import dataclass

import numpy as np

from . import colour_maps, false_colour
from .canvas import SCALE, Canvas
from .polar_diagram import round_step
from .sheet import Sheet

WIDTH = 74
"""Room for the bar and its numbers. [pixel of nominal size]"""

BAR = 14
"""[pixel of nominal size]"""

MOST_TICKS = 7


@dataclass(frozen=True)
class ColourScale:
    """What colour a value has.

    Parameters
    ----------
    low, high : float    Values of the first and the last colour; what lies beyond has these.
    unit : str
    is_log : bool    Whether equal ratios, instead of equal differences, take equal parts.
    colour_map : str    One of `colour_maps.MAPS`.
    """

    low: float
    high: float
    unit: str
    is_log: bool = False
    colour_map: str = "hues"

    def colours(self, values) -> np.ndarray:
        """Colours of values. (...) -> (..., 3) uint8"""
        return colour_maps.colours_of(self.share(values), self.colour_map)

    def share(self, values) -> np.ndarray:
        """Where values lie on the scale, 0 to 1."""
        values, low, high = (np.asarray(x, dtype=np.float64) for x in (values, self.low, self.high))
        if self.is_log:
            values, low, high = (np.log(np.maximum(x, self.low)) for x in (values, low, high))
        return np.clip((values - low) / max(float(high - low), 1e-30), 0.0, 1.0)

    def value(self, share) -> np.ndarray:
        """Values at places of the scale, 0 to 1: the inverse of `share`."""
        share = np.asarray(share, dtype=np.float64)
        if self.is_log:
            return self.low * (self.high / self.low) ** share
        return self.low + (self.high - self.low) * share

    def ticks(self) -> list[float]:
        """Round numbers of the scale."""
        if not self.is_log:
            step = round_step(self.high - self.low, MOST_TICKS)
            first = math.ceil(self.low / step - 1e-9)
            count = math.floor(self.high / step + 1e-9) - first + 1
            return [step * (first + k) for k in range(count)]
        powers = range(math.floor(math.log10(self.low)), math.ceil(math.log10(self.high)) + 1)
        steps = (1.0, 2.0, 5.0) if len(powers) < 5 else (1.0,)
        ticks = [step * 10.0**power for power in powers for step in steps]
        return [tick for tick in ticks if self.low * 0.999 <= tick <= self.high * 1.001]

    def draw_on_sheet(self, sheet: Sheet, left: float, top: float, bottom: float) -> None:
        """As `draw_bar`, on a sheet. [pixel]"""
        count = max(round(bottom - top), 2)
        rows = colour_maps.colours_of(np.linspace(1.0, 0.0, count), self.colour_map)
        sheet.picture(np.repeat(rows[:, None], BAR, axis=1), (left, top), (BAR, bottom - top))
        right = left + BAR
        for tick in self.ticks():
            y = bottom - float(self.share(tick)) * (bottom - top)
            sheet.line([(right, y), (right + 4, y)], sheet.colours.axis)
            sheet.write((right + 7, y), f"{tick:g}", 10)
        words = f"{self.unit}, log" if self.is_log else self.unit
        sheet.write((left, top - 10), words, 11, colour=sheet.colours.caption)

    def draw_bar(self, canvas: Canvas, left: float, top: float, bottom: float) -> None:
        """Draw the colours from the lowest up with their numbers, and the unit above. [pixel]"""
        unit = canvas.zoom
        rows = np.linspace(1.0, 0.0, max(round((bottom - top) * SCALE), 2))
        colours = colour_maps.colours_of(rows, self.colour_map)
        right = left + BAR * unit
        for k, colour in enumerate(colours):
            y = top * SCALE + k
            canvas.pen.line([(left * SCALE, y), (right * SCALE, y)], tuple(map(int, colour)), 2)
        for tick in self.ticks():
            y = bottom - float(self.share(tick)) * (bottom - top)
            canvas.line([(right, y), (right + 4 * unit, y)], canvas.colours.axis)
            canvas.write((right + 7 * unit, y), f"{tick:g}", 10, "lm")
        canvas.write((left, top - 10 * unit), self.unit, 11, "lm", is_caption=True)


def nice_scale(values, unit: str) -> ColourScale:
    """Return a scale from 0 to a round number that nearly all values lie under."""
    return ColourScale(0.0, false_colour.nice_maximum(np.asarray(values, dtype=np.float64)), unit)
