"""Add a preset: keep the settings of the scene under a name, or remove one that was kept."""

import bpy
from bl_operators.presets import AddPresetBase

from ..blender_addon.setting_presets import OWNER, SUBFOLDER, VALUES


class LUMENRAY_OT_add_preset(AddPresetBase, bpy.types.Operator):
    """Keep exposure, ends of renders and bakes, density and scales of the scene as a preset, or remove one of yours"""

    bl_idname = "lumenray.add_preset"
    bl_label = "Add Preset"

    preset_menu = "LUMENRAY_PT_presets"
    preset_subdir = SUBFOLDER
    preset_defines = (OWNER,)
    preset_values = VALUES


CLASSES = (LUMENRAY_OT_add_preset,)
