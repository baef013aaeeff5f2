"""Areas of Blender's windows, and having them drawn again."""

from collections.abc import Iterator

import bpy


def areas(*kinds: str) -> Iterator:
    """Give the areas of all windows, those of some types, or of any."""
    for manager in bpy.data.window_managers:
        for window in manager.windows:
            for area in window.screen.areas:
                if not kinds or area.type in kinds:
                    yield area


def redraw(*kinds: str) -> None:
    """Have areas of some types drawn again, or all."""
    for area in areas(*kinds):
        area.tag_redraw()
