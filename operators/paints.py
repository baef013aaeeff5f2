"""Composition of the active material's paint: presets, layers and their parts, files, and a plot."""

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from ..blender_addon.compositions.presets import PAINTS
from ..blender_addon.scattering.settings import active_material
from ..blender_addon.surface_models import PAINT
from ..engine.errors import LumenrayError
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
    from ..blender_addon.file_assets import kind as file_kind
    from ..blender_addon.paints import description, parts, plot, presets, tables


class Paint:
    """The composition of a paint."""

    model, group, unnamed, folder = PAINT, "paint", "paint", PAINTS

    @staticmethod
    def describe(settings) -> dict:
        """Return what settings state, as a file has it."""
        return description.describe(settings)

    @staticmethod
    def tables():
        """Return what computes tables."""
        return tables.paint_tables


class LUMENRAY_OT_load_paint(Paint, LoadComposition, bpy.types.Operator):
    """Let the active material be a paint as a file describes it, by Lumenray's schema of compositions"""

    bl_idname = "lumenray.load_paint"
    bl_label = "Open Composition"

    def load(self, settings, path):
        """Take over what a file states."""
        presets.load(settings, path, parts.known())


class LUMENRAY_OT_save_paint(Paint, SaveComposition, bpy.types.Operator):
    """Write the composition of the paint as a JSON file, which other scenes and the command 'lumenray paint' read"""

    bl_idname = "lumenray.save_paint"
    bl_label = "Save Composition"


class LUMENRAY_OT_set_paint_preset(Paint, SetPreset, bpy.types.Operator):
    """Take over the composition of a preset; what was set before is gone but for undoing"""

    bl_idname = "lumenray.set_paint_preset"
    bl_label = "Paint Preset"

    @staticmethod
    def known() -> dict:
        """Return the files of presets."""
        return presets.shipped() | presets.own()

    def load(self, settings, path):
        """Take over what a file states."""
        presets.load(settings, path)


class LUMENRAY_OT_add_paint_preset(Paint, AddCompositionPreset, bpy.types.Operator):
    """Keep the composition as a preset of yours"""

    bl_idname = "lumenray.add_paint_preset"
    bl_label = "Add Paint Preset"


class LUMENRAY_OT_cancel_paint(Paint, CancelComposition, bpy.types.Operator):
    """End the computation of the paint, which is plain grey then"""

    bl_idname = "lumenray.cancel_paint"
    bl_label = "Cancel"


class LUMENRAY_OT_compute_paint(Paint, ComputeComposition, bpy.types.Operator):
    """Compute the paint after all, which was cancelled"""

    bl_idname = "lumenray.compute_paint"
    bl_label = "Compute"


class LUMENRAY_OT_add_paint_layer(Paint, CompositionOperator, bpy.types.Operator):
    """Add a layer of clear binder above the active one"""

    bl_idname = "lumenray.add_paint_layer"
    bl_label = "Add Layer"

    def work(self, context, settings):
        """Add it."""
        description.adopt_layer(settings.layers.add(), parts.new_layer())
        # Collections grow at their end.
        settings.layers.move(len(settings.layers) - 1, settings.layer_index)


class LUMENRAY_OT_remove_paint_layer(Paint, CompositionOperator, bpy.types.Operator):
    """Remove the active layer of the paint with its flakes and pigments"""

    bl_idname = "lumenray.remove_paint_layer"
    bl_label = "Remove Layer"

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        return len(active_material(context).lumenray.paint.layers) > 1

    def work(self, context, settings):
        """Remove it."""
        settings.layers.remove(settings.layer_index)
        settings.layer_index = min(settings.layer_index, len(settings.layers) - 1)


class LUMENRAY_OT_move_paint_layer(Paint, CompositionOperator, bpy.types.Operator):
    """Move the active layer outwards or inwards"""

    bl_idname = "lumenray.move_paint_layer"
    bl_label = "Move Layer"

    direction: EnumProperty(
        name="Direction",
        description="Where to. Default Outwards: up in the list",
        items=[("UP", "Outwards", "Towards the air"), ("DOWN", "Inwards", "Towards the substrate")],
    )

    def work(self, context, settings):
        """Move it."""
        place = settings.layer_index + (-1 if self.direction == "UP" else 1)
        if 0 <= place < len(settings.layers):
            settings.layers.move(settings.layer_index, place)
            settings.layer_index = place


class LUMENRAY_OT_add_paint_part(Paint, CompositionOperator, bpy.types.Operator):
    """Add flakes or a pigment to the active layer"""

    bl_idname = "lumenray.add_paint_part"
    bl_label = "Add to Layer"

    kind: EnumProperty(
        name="Kind",
        description="What is added. Default Flakes: what makes the effect",
        items=[("flakes", "Flakes", "Plates that mirror"), ("pigments", "Pigment", "Grains")],
    )
    part: StringProperty(description="Name of a constituent, or of one that is to begin with")

    def work(self, context, settings):
        """Add it."""
        content = parts.new_part(self.kind, self.part)
        layer = settings.layers[settings.layer_index]
        description.adopt_part(getattr(layer, self.kind).add(), self.kind, content)


class LUMENRAY_OT_remove_paint_part(Paint, CompositionOperator, bpy.types.Operator):
    """Remove flakes or a pigment from the active layer"""

    bl_idname = "lumenray.remove_paint_part"
    bl_label = "Remove from Layer"

    kind: EnumProperty(
        name="Kind",
        description="What is removed. Default Flakes: what makes the effect",
        items=[("flakes", "Flakes", "Plates that mirror"), ("pigments", "Pigment", "Grains")],
    )
    index: IntProperty(description="Number of it in the layer", options={"HIDDEN"})

    def work(self, context, settings):
        """Remove it."""
        getattr(settings.layers[settings.layer_index], self.kind).remove(self.index)


class LUMENRAY_OT_plot_paint(Paint, CompositionOperator, bpy.types.Operator):
    """Draw what the paint scatters in the plane of incidence, as an image of the file"""

    bl_idname = "lumenray.plot_paint"
    bl_label = "Plot Paint"

    def work(self, context, settings):
        """Draw it."""
        try:
            painted = tables.paint_tables.obtain(settings, is_patient=bpy.app.background)
        except file_kind.NotReadyError as error:
            raise LumenrayError(f"{error}; plot it then") from None
        image = plot.show_cuts(context, settings.name or settings.id_data.name, painted)
        return f"image '{image.name}'"


CLASSES = (
    LUMENRAY_OT_load_paint,
    LUMENRAY_OT_save_paint,
    LUMENRAY_OT_set_paint_preset,
    LUMENRAY_OT_add_paint_preset,
    LUMENRAY_OT_cancel_paint,
    LUMENRAY_OT_compute_paint,
    LUMENRAY_OT_add_paint_layer,
    LUMENRAY_OT_remove_paint_layer,
    LUMENRAY_OT_move_paint_layer,
    LUMENRAY_OT_add_paint_part,
    LUMENRAY_OT_remove_paint_part,
    LUMENRAY_OT_plot_paint,
)
