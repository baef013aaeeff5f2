"""Pictures of files as icons for panels: drawn once for every content, on a thread beside Blender's own.

Panels ask at every redraw. The first time there is no icon yet: the thread draws it, and a timer takes it over and has the
panels drawn again. All but the drawing is on Blender's main thread.
"""

from collections.abc import Callable

import bpy
import bpy.utils.previews

from ..foundation.redraw import redraw
from ..foundation.side_thread import SideThread

STEP, SMALLEST, LARGEST = 32, 160, 480
"""Sides that pictures have: multiples of the first, between the others. [pixel]"""

KEPT = 64
"""Pictures that are kept; one more, and they are drawn anew as they are asked for."""

POLL_INTERVAL = 0.05
"""How often the timer looks for pictures that are drawn. [s]"""


class Pictures:
    """Icons by content, and what is still to be drawn.

    Parameters
    ----------
    noun : str    What people call one.
    draw : callable    Given a reading, the side [pixel], whether the ground is dark, and the kind of picture if there are
        several, returns pixels (h, w, 4), row 0 at the bottom.
    is_latest_enough : bool    Whether only what is asked for last is drawn, and the picture before is shown until then.
    """

    def __init__(self, noun: str, draw: Callable, is_latest_enough: bool = False):
        self.noun, self._draw, self._is_latest_enough = noun, draw, is_latest_enough
        self._latest = ""
        self._icons = None
        self._painter = None
        self._drawing = {}
        # Blender knows a timer by the object, and every look at a method makes a new one.
        self.timer = self._take_over

    def icon(self, reading, side: float, is_dark: bool, *kind: str) -> int:
        """Return the number of the icon of a file's picture.

        While it is not drawn yet, it is that of another size, or 0 if there is none.

        Parameters
        ----------
        reading : object    With a ``digest`` of the content.
        side : float    Of the picture on the screen, see `side_of`. [pixel]
        is_dark : bool    On a dark ground.
        *kind : str    Of the picture, where there are several.
        """
        content = " ".join((reading.digest, *kind, "dark" if is_dark else "light"))
        name = f"{content} {side}"
        icons = self._icons or {}
        if name in icons:
            return icons[name].icon_id
        if name not in self._drawing:
            if self._is_latest_enough:
                # What a slider has left behind is not drawn any more.
                for other in [n for n, picture in self._drawing.items() if picture.cancel()]:
                    del self._drawing[other]
            if self._painter is None:
                self._painter = SideThread(self.noun)
            self._drawing[name] = self._painter.submit(self._draw, reading, side, is_dark, *kind)
        if not bpy.app.timers.is_registered(self.timer):
            bpy.app.timers.register(self.timer, first_interval=POLL_INTERVAL)
        known = next((icons[other].icon_id for other in icons if other.startswith(content)), 0)
        if known == 0 and self._is_latest_enough and self._latest in icons:
            return icons[self._latest].icon_id
        return known

    def close(self) -> None:
        """Let go of all pictures, and of the thread."""
        if bpy.app.timers.is_registered(self.timer):
            bpy.app.timers.unregister(self.timer)
        if self._painter is not None:
            self._painter.shutdown()
            self._painter = None
        self._drawing.clear()
        if self._icons is not None:
            bpy.utils.previews.remove(self._icons)
            self._icons = None

    def _take_over(self) -> float | None:
        """Make icons of the pictures that are drawn; time until the next look, None after the last. [s]"""
        done = [name for name, picture in self._drawing.items() if picture.done()]
        for name in done:
            self._add(name, self._drawing.pop(name).result())
        if done:
            redraw("PROPERTIES", "VIEW_3D")
        return POLL_INTERVAL if self._drawing else None

    def _add(self, name, pixels) -> None:
        """Keep a picture (h, w, 4), row 0 at the bottom."""
        if self._icons is None:
            self._icons = bpy.utils.previews.new()
        if len(self._icons) >= KEPT:
            self._icons.clear()
        icon = self._icons.new(name)
        icon.image_size = pixels.shape[1::-1]
        icon.image_pixels_float.foreach_set(pixels.reshape(-1))
        self._latest = name


def side_of(room: float) -> int:
    """Return the largest side of a picture that fits into a width. [pixel]"""
    return min(max(int(room) // STEP * STEP, SMALLEST), LARGEST)


def has_dark_theme(preferences) -> bool:
    """Whether texts in panels are lighter than what they stand on."""
    return sum(preferences.themes[0].user_interface.wcol_regular.text) > 1.5
