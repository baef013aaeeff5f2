"""Composition of the active material's cloth: presets and files."""

import bpy

from ..blender_addon.compositions.presets import CLOTHS
from ..blender_addon.surface_models import CLOTH
from ..imports import loaded_when_used
from .compositions import (
    AddCompositionPreset,
    CancelComposition,
    ComputeComposition,
    LoadComposition,
    SaveComposition,
    SetPreset,
)

with loaded_when_used():
    from ..blender_addon.cloths import description, presets, tables


class Cloth:
    """The composition of a cloth."""

    model, group, unnamed, folder = CLOTH, "cloth", "cloth", CLOTHS

    @staticmethod
    def describe(settings) -> dict:
        """Return what settings state, as a file has it."""
        return description.describe(settings)

    @staticmethod
    def tables():
        """Return what computes tables."""
        return tables.cloth_tables


class LUMENRAY_OT_load_cloth(Cloth, LoadComposition, bpy.types.Operator):
    """Let the active material be a cloth as a file describes it, by Lumenray's schema of compositions"""

    bl_idname = "lumenray.load_cloth"
    bl_label = "Open Cloth"

    def load(self, settings, path):
        """Take over what a file states."""
        presets.load(settings, path)


class LUMENRAY_OT_save_cloth(Cloth, SaveComposition, bpy.types.Operator):
    """Write the composition of the cloth as a JSON file, which other scenes and the command 'lumenray cloth' read"""

    bl_idname = "lumenray.save_cloth"
    bl_label = "Save Cloth"


class LUMENRAY_OT_set_cloth_preset(Cloth, SetPreset, bpy.types.Operator):
    """Take over the composition of a preset; what was set before is gone but for undoing"""

    bl_idname = "lumenray.set_cloth_preset"
    bl_label = "Cloth Preset"

    @staticmethod
    def known() -> dict:
        """Return the files of presets."""
        return presets.shipped() | presets.own()

    def load(self, settings, path):
        """Take over what a file states."""
        presets.load(settings, path)


class LUMENRAY_OT_add_cloth_preset(Cloth, AddCompositionPreset, bpy.types.Operator):
    """Keep the cloth as a preset of yours"""

    bl_idname = "lumenray.add_cloth_preset"
    bl_label = "Add Cloth Preset"


class LUMENRAY_OT_cancel_cloth(Cloth, CancelComposition, bpy.types.Operator):
    """End the computation of the cloth, which is plain grey then"""

    bl_idname = "lumenray.cancel_cloth"
    bl_label = "Cancel"


class LUMENRAY_OT_compute_cloth(Cloth, ComputeComposition, bpy.types.Operator):
    """Compute the cloth after all, which was cancelled"""

    bl_idname = "lumenray.compute_cloth"
    bl_label = "Compute"


CLASSES = (
    LUMENRAY_OT_load_cloth,
    LUMENRAY_OT_save_cloth,
    LUMENRAY_OT_set_cloth_preset,
    LUMENRAY_OT_add_cloth_preset,
    LUMENRAY_OT_cancel_cloth,
    LUMENRAY_OT_compute_cloth,
)
