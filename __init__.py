"""Lumenray: lighting design, daylight and appearance in Blender, in real units with a stated error.

This file is both the entry point of the Blender extension and the root of the Python package
``lumenray``. It imports without Blender, so that the engine can be used alone.
"""


def register():
    """Register all of the extension with the running Blender."""
    from . import operators, ui
    from .blender_addon import registry

    registry.register((*operators.CLASSES, *ui.CLASSES))
    ui.attach()


def unregister():
    """Take everything that `register` added out of the running Blender."""
    from . import operators, ui
    from .blender_addon import registry

    ui.detach()
    registry.unregister((*operators.CLASSES, *ui.CLASSES))
