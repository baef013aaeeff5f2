"""Looking at the open file when the add-on is switched on: Blender shows its data only after that."""

from collections.abc import Callable

import bpy


def look(function: Callable[[], None]) -> None:
    """Call a function that looks at the open file, at once or as soon as Blender shows it."""
    if hasattr(bpy.data, "objects"):
        function()
    elif not bpy.app.timers.is_registered(function):
        # Loading another file ends it, which has handlers of its own.
        bpy.app.timers.register(function, first_interval=0.0)


def look_no_more(function: Callable[[], None]) -> None:
    """Call the function no more."""
    if bpy.app.timers.is_registered(function):
        bpy.app.timers.unregister(function)
