"""Pictures of scattering as icons for panels: drawn once for every content, on a thread beside Blender's own."""

from concurrent.futures import ThreadPoolExecutor

import bpy

from ...engine.analysis.scattering_picture import albedo_chart, polar_cuts
from ..luminaires.preview import POLL_INTERVAL, Pictures

DRAWN = {"cuts": polar_cuts, "totals": albedo_chart}
"""What draws each kind of picture."""


class ScatteringPictures(Pictures):
    """Icons by content and kind, and what is still to be drawn."""

    def icon(self, reading, side: float, is_dark: bool, kind: str = "cuts") -> int:
        """Return the number of the icon of a picture of a scattering file.

        While it is not drawn yet, it is that of another size, or 0 if there is none.

        Parameters
        ----------
        reading : scattering.files.Reading
        side : float    Of the picture on the screen, see `side_of`. [pixel]
        is_dark : bool    On a dark ground.
        kind : str    Of `DRAWN`.
        """
        content = f"{reading.digest} {kind} {'dark' if is_dark else 'light'}"
        name = f"{content} {side}"
        icons = self._icons or {}
        if name in icons:
            return icons[name].icon_id
        if name not in self._drawing:
            if self._painter is None:
                self._painter = ThreadPoolExecutor(1, "scattering")
            self._drawing[name] = self._painter.submit(_draw, reading, kind, side, is_dark)
        if not bpy.app.timers.is_registered(self.timer):
            bpy.app.timers.register(self.timer, first_interval=POLL_INTERVAL)
        return next((icons[other].icon_id for other in icons if other.startswith(content)), 0)


def _draw(reading, kind: str, side: int, is_dark: bool):
    """Pixels of a picture (h, w, 4), of the back where nothing is known of the front."""
    names = reading.file.sides
    shown = "front" if any(name.startswith("front") for name in names) else "back"
    return DRAWN[kind](reading.file, side=shown, size=(side, side), dark=is_dark)


pictures = ScatteringPictures()


def close():
    """Let go of all pictures."""
    pictures.close()
