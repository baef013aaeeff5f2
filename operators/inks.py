"""Composition of the active material's pigment layer: presets and files."""

import bpy
from bpy.props import FloatProperty, IntProperty

from ..blender_addon.compositions.presets import INKS
from ..blender_addon.surface_models import INK
from ..imports import loaded_when_used
from .compositions import (
    AddCompositionPreset,
    CancelComposition,
    CompositionOperator,
    ComputeComposition,
    LoadComposition,
    SaveComposition,
    SetPreset,
)

with loaded_when_used():
    from ..blender_addon.inks import description, presets, structure, tables


class Ink:
    """The composition of a pigment layer."""

    model, group, unnamed, folder = INK, "ink", "print", INKS

    @staticmethod
    def describe(settings) -> dict:
        """Return what settings state, as a file has it."""
        return description.describe(settings)

    @staticmethod
    def tables():
        """Return what computes tables."""
        return tables.ink_tables


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
        return presets.shipped() | presets.own()

    def load(self, settings, path):
        """Take over what a file states."""
        presets.load(settings, path)


class LUMENRAY_OT_add_ink_preset(Ink, AddCompositionPreset, bpy.types.Operator):
    """Keep the composition as a preset of yours"""

    bl_idname = "lumenray.add_ink_preset"
    bl_label = "Add Pigment Layer Preset"


class LUMENRAY_OT_cancel_ink(Ink, CancelComposition, bpy.types.Operator):
    """End the computation of the pigment layer, which is plain grey then; what was solved is kept for the next time"""

    bl_idname = "lumenray.cancel_ink"
    bl_label = "Cancel"


class LUMENRAY_OT_compute_ink(Ink, ComputeComposition, bpy.types.Operator):
    """Compute the pigment layer after all, from where it was cancelled"""

    bl_idname = "lumenray.compute_ink"
    bl_label = "Compute"


class LUMENRAY_OT_show_ink_particles(Ink, CompositionOperator, bpy.types.Operator):
    """Put a cell of the pigment layer at the 3D cursor, 1 µm as 1 cm: particles that waves meet, in a box of the binder"""

    bl_idname = "lumenray.show_ink_particles"
    bl_label = "Show Particles"

    realisation: IntProperty(
        name="Realisation",
        description="Number of the layer with particles of its own. Default 0: the first one that is solved",
        default=0,
        min=0,
    )
    magnification: FloatProperty(
        name="Magnification",
        description="Of lengths, a factor. Default 10000: a micrometre becomes a centimetre",
        default=1e4,
        min=1.0,
        soft_max=1e6,
        precision=0,
    )

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        if context.mode != "OBJECT":
            cls.poll_message_set("Particles are shown in object mode")
            return False
        if context.collection is None or context.collection.library is not None:
            cls.poll_message_set("The active collection is linked from another file")
            return False
        return True

    def work(self, context, settings):
        """Make the objects."""
        box = structure.add_structure(context, settings, self.realisation, self.magnification)
        particles = ", ".join(each.name for each in box.children) or "nothing but what is dissolved"
        return f"'{box.name}' stands at the 3D cursor: {particles}"


CLASSES = (
    LUMENRAY_OT_load_ink,
    LUMENRAY_OT_save_ink,
    LUMENRAY_OT_set_ink_preset,
    LUMENRAY_OT_add_ink_preset,
    LUMENRAY_OT_cancel_ink,
    LUMENRAY_OT_compute_ink,
    LUMENRAY_OT_show_ink_particles,
)
