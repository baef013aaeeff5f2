"""A frame with numbers for charts."""

from collections.abc import Callable

import numpy as np

from .canvas import Canvas


class Axes:
    """A frame with numbers across and up.

    Parameters
    ----------
    canvas : Canvas
    across, up : (float, float)    What is shown.
    is_log : bool    Whether the scale up is logarithmic.
    suffix : str    Behind the numbers across.
    """

    def __init__(self, canvas: Canvas, across, up, is_log: bool = False, suffix: str = "°"):
        unit, (width, height) = canvas.zoom, canvas.size
        self.canvas, self.across, self.up, self.is_log = canvas, across, up, is_log
        self.suffix = suffix
        self.window = 58 * unit, 58 * unit, width - 20 * unit, height - 82 * unit

    def place(self, x, value) -> np.ndarray:
        """Pixels (..., 2), within the frame."""
        left, top, right, bottom = self.window
        low, high = self.up
        if self.is_log:
            value, low, high = (np.log(np.maximum(v, self.up[0])) for v in (value, low, high))
        x = left + (np.asarray(x) - self.across[0]) / (self.across[1] - self.across[0]) * (
            right - left
        )
        y = bottom - np.clip((value - low) / (high - low), 0.0, 1.0) * (bottom - top)
        return np.stack(np.broadcast_arrays(x, y), axis=-1)

    def draw(self, ticks, levels, across_name: str, label: Callable[[float], str]) -> None:
        """Draw lines at ``ticks`` across and ``levels`` up, a name below, and numbers."""
        canvas, colours = self.canvas, self.canvas.colours
        left, top, right, bottom = self.window
        unit = canvas.zoom
        for tick in ticks:
            x = float(self.place(tick, self.up[1])[0])
            canvas.line([(x, top), (x, bottom)], colours.axis if tick == 0 else colours.grid)
            canvas.write((x, bottom + 11 * unit), f"{tick:g}{self.suffix}", 10, "mm")
        for level in levels:
            y = float(self.place(self.across[0], level)[1])
            canvas.line([(left, y), (right, y)], colours.grid)
            canvas.write((left - 6 * unit, y), label(level), 10, "rm")
        canvas.line(
            [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)], colours.axis
        )
        canvas.write(
            (0.5 * (left + right), bottom + 27 * unit), across_name, 11, "mm", is_caption=True
        )

    def title(self, text: str, caption: str) -> None:
        """Write what is shown, and a line about it."""
        unit = self.canvas.zoom
        room = self.canvas.size[0] - 36 * unit
        self.canvas.write((18 * unit, 20 * unit), text, 17, "lm", room=room)
        self.canvas.write((18 * unit, 40 * unit), caption, 11, "lm", is_caption=True, room=room)
