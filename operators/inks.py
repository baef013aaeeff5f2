"""Composition of the active material's pigment layer: presets and files."""

import bpy

from ..blender_addon.surface_models import INK
from ..imports import loaded_when_used
from .compositions import LoadComposition, SaveComposition, SetPreset

with loaded_when_used():
    from ..blender_addon.inks import description, presets


class Ink:
    """The composition of a pigment layer."""

    model, group, unnamed = INK, "ink", "print"

    @staticmethod
    def describe(settings) -> dict:
        """Return what settings state, as a file has it."""
        return description.describe(settings)


class LUMENRAY_OT_load_ink(Ink, LoadComposition, bpy.types.Operator):
    """Let the active material be a pigment layer as a file describes it, by Lumenray's schema of compositions"""

    bl_idname = "lumenray.load_ink"
    bl_label = "Open Pigment Layer"

    def load(self, settings, path):
        """Take over what a file states."""
        presets.load(settings, path)


class LUMENRAY_OT_save_ink(Ink, SaveComposition, bpy.types.Operator):
    """Write the composition of the pigment layer as a JSON file, which other scenes and the command 'lumenray ink' read"""

    bl_idname = "lumenray.save_ink"
    bl_label = "Save Pigment Layer"


class LUMENRAY_OT_set_ink_preset(Ink, SetPreset, bpy.types.Operator):
    """Take over the composition of a preset; what was set before is gone but for undoing"""

    bl_idname = "lumenray.set_ink_preset"
    bl_label = "Pigment Layer Preset"

    @staticmethod
    def known() -> dict:
        """Return the files of presets."""
        return presets.shipped()

    def load(self, settings, path):
        """Take over what a file states."""
        presets.load(settings, path)


CLASSES = (LUMENRAY_OT_load_ink, LUMENRAY_OT_save_ink, LUMENRAY_OT_set_ink_preset)
