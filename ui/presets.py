"""Presets of the settings of a scene, in the headers of the panels that have such settings."""

import bpy
from bl_ui.utils import PresetPanel

from ..blender_addon.setting_presets import SUBFOLDER
from .compatibility import ENGINE


class LUMENRAY_PT_presets(PresetPanel, bpy.types.Panel):
    """Presets that ship and those of the user."""

    bl_idname = "LUMENRAY_PT_presets"
    bl_label = "Lumenray Presets"
    preset_subdir = SUBFOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "lumenray.add_preset"

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE


def draw_presets(layout, context) -> None:
    """Draw the button of the presets into a panel's header."""
    if context.engine == ENGINE:
        LUMENRAY_PT_presets.draw_panel_header(layout)


CLASSES = (LUMENRAY_PT_presets,)
