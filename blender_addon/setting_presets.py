"""Presets of the settings of a scene: which settings a preset has, and the folder of those that ship."""

import os
from pathlib import Path

import bpy

from .. import libraries

SUBFOLDER = "lumenray"
"""Of Blender's folders of presets: those of the user, and ours."""

OWNER = "settings = bpy.context.scene.lumenray"
"""First line of a preset, which names what it sets."""

VALUES = (
    "settings.exposure",
    "settings.white_luminance",
    "settings.ev100",
    "settings.render.stop",
    "settings.render.samples",
    "settings.render.error",
    "settings.render.time",
    "settings.render.use_denoising",
    "settings.render.use_pass_luminance",
    "settings.render.use_pass_illuminance",
    "settings.bake.density",
    "settings.bake.use_error",
    "settings.bake.error",
    "settings.bake.use_absolute",
    "settings.bake.absolute",
    "settings.bake.use_time",
    "settings.bake.time",
    "settings.bake.use_samples",
    "settings.bake.samples",
    "settings.viewport.automatic",
    "settings.viewport.low",
    "settings.viewport.high",
    "settings.viewport.logarithmic",
    "settings.look.low",
    "settings.look.high",
)
"""What every preset sets, so that nothing is left of the one before. Folders, files and seeds are of the scene alone."""

ROOT = Path(libraries.__file__).parent
"""Folder with our ``presets``."""


def attach():
    """Let Blender find the presets that ship."""
    if not _is_known():
        bpy.utils.register_preset_path(str(ROOT))


def detach():
    """Undo `attach`; presets of the user stay."""
    if _is_known():
        bpy.utils.unregister_preset_path(str(ROOT))


def _is_known() -> bool:
    folder = os.path.normpath(ROOT / "presets" / SUBFOLDER)
    return folder in map(os.path.normpath, bpy.utils.preset_paths(SUBFOLDER))
