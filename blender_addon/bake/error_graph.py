"""The graph of a bake's error over time as an icon for panels, drawn anew as the bake goes on.

The bake hands its history to `note`; panels ask for the icon at every redraw. A thread draws the graph, at most once
a second, and a timer takes it over. All but the drawing is on Blender's main thread.
"""

import time
from concurrent.futures import Future

import bpy
import bpy.utils.previews

from ...imports import loaded_when_used
from ..foundation.redraw import redraw
from ..foundation.side_thread import SideThread

with loaded_when_used():
    import numpy as np

    from ...engine.accuracy import history as accuracy_history
    from ...engine.analysis import error_graph

INTERVAL = 1.0
"""Shortest time between two graphs. [s]"""

POLL_INTERVAL = 0.1
"""How often the timer looks for a graph that is drawn. [s]"""

ASPECT = 0.75
"""Height of the graph over its width."""

HEAD = 62
"""Height of the words above the graph, which the panel tells by itself, where letters have their nominal size. [pixel]"""


class ErrorGraph:
    """The newest graph, and the history that the next one is drawn from."""

    def __init__(self):
        self._icons = None
        self._painter = None
        self._history: accuracy_history.History | None = None
        self._wanted = self._shown = None
        self._future: Future | None = None
        self._begun = 0.0
        # Blender knows a timer by the object, and every look at a method makes a new one.
        self.timer = self._take_over

    @property
    def has_history(self) -> bool:
        """Whether there is anything to show."""
        return self._history is not None

    def note(self, history: "accuracy_history.History | None") -> None:
        """Take a newer history; None: a new bake begins, which has none yet."""
        self._history = history if history is not None and history.marks else None

    def icon(self, side: float, is_dark: bool) -> int:
        """Return the number of the icon of the newest graph, 0 while there is none.

        Parameters
        ----------
        side : float    Width of the graph on the screen. [pixel]
        is_dark : bool    On a dark ground.
        """
        if self._history is None:
            return 0
        self._wanted = (self._history, int(side), is_dark)
        if self._is_outdated() and not bpy.app.timers.is_registered(self.timer):
            bpy.app.timers.register(self.timer, first_interval=POLL_INTERVAL)
        if not self._icons:
            return 0
        return next(iter(self._icons.values())).icon_id

    def close(self) -> None:
        """Let go of the graph, and of the thread."""
        if bpy.app.timers.is_registered(self.timer):
            bpy.app.timers.unregister(self.timer)
        if self._painter is not None:
            self._painter.shutdown()
        if self._icons is not None:
            bpy.utils.previews.remove(self._icons)
        self.__init__()

    def _is_outdated(self) -> bool:
        return self._shown is None or any(
            a is not b and a != b for a, b in zip(self._shown, self._wanted, strict=True)
        )

    def _take_over(self) -> float | None:
        """Have the graph drawn and make an icon of it; time until the next look, None after the last. [s]"""
        if self._future is None:
            if self._wanted is None or not self._is_outdated():
                return None
            wait = self._begun + INTERVAL - time.monotonic()
            if wait > 0.0:
                return wait
            if self._painter is None:
                self._painter = SideThread("error graph")
            self._begun, self._shown = time.monotonic(), self._wanted
            self._future = self._painter.submit(_draw, *self._wanted)
        elif self._future.done():
            future, self._future = self._future, None
            self._keep(future.result())
            redraw("PROPERTIES", "VIEW_3D")
        return POLL_INTERVAL

    def _keep(self, pixels: "np.ndarray") -> None:
        """Make the icon of a picture (h, w, 4), row 0 at the bottom."""
        if self._icons is None:
            self._icons = bpy.utils.previews.new()
        self._icons.clear()
        icon = self._icons.new("graph")
        icon.image_size = pixels.shape[1::-1]
        icon.image_pixels_float.foreach_set(pixels.reshape(-1))


def _draw(history: "accuracy_history.History", side: int, is_dark: bool) -> "np.ndarray":
    """Draw a graph. Returns (h, w, 4) float32, row 0 at the bottom."""
    height = int(ASPECT * side)
    # The words make the picture higher, and so larger themselves.
    head = round(max(HEAD * height / (error_graph.BASE - HEAD), HEAD * error_graph.LEAST_ZOOM))
    return error_graph.graph_pixels(history, size=(side, height + head), dark=is_dark)[:height]


graph = ErrorGraph()


def close():
    """Let go of the graph."""
    graph.close()
