"""Tells Blender of rays that become ready in the background: panels and views are drawn anew, and lights join."""

from dataclasses import dataclass

import bpy

TICK = 0.25
"""Between two looks. [s]"""


@dataclass
class _State:
    is_watching: bool = False


_state = _State()


def watch(is_busy, take_finished) -> None:
    """Look from time to time while something is under way; may be called from any thread.

    Parameters
    ----------
    is_busy : callable    Whether something is under way.
    take_finished : callable    How much came to an end since it was asked last.
    """
    if bpy.app.background or _state.is_watching:
        return
    _state.is_watching = True

    def look():
        # Asked first, so that what ends meanwhile is told by one more look.
        goes_on = is_busy()
        if take_finished():
            for light in bpy.data.lights:
                if light.lumenray.rayset.use_file:
                    light.update_tag()
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                if area.type in {"PROPERTIES", "VIEW_3D"}:
                    area.tag_redraw()
        _state.is_watching = goes_on
        return TICK if goes_on else None

    # Persistent: loading a file does not end what is under way.
    bpy.app.timers.register(look, first_interval=TICK, persistent=True)
