"""Functions that Blender calls when something happens: into its lists of handlers, once each, and out again."""

from collections.abc import Callable, Mapping

import bpy


def listen(functions: Mapping[str, Callable]) -> None:
    """Have Blender call functions, by the names of its lists. Those that outlive a file are `persistent`."""
    for name, function in functions.items():
        handlers = getattr(bpy.app.handlers, name)
        if function not in handlers:
            handlers.append(function)


def leave(functions: Mapping[str, Callable]) -> None:
    """Undo `listen`."""
    for name, function in functions.items():
        handlers = getattr(bpy.app.handlers, name)
        if function in handlers:
            handlers.remove(function)
