"""Pigment layers: what a composition states, its colour, and how good it is."""

import bpy

from ..imports import loaded_when_used
from .compositions import draw_choice, draw_presets, draw_progress
from .file_parts import LABELS, draw_problem
from .material import MaterialPanel
from .parts import draw_lines, draw_text, draw_wide

with loaded_when_used():
    from ..blender_addon.inks import description, presets, readout, tables


class LUMENRAY_MT_ink_presets(bpy.types.Menu):
    """Pigment layers that ship and those of the user."""

    bl_label = "Pigment Layer Presets"

    def draw(self, context):
        draw_presets(self.layout, presets, "lumenray.set_ink_preset")


class InkPanel(MaterialPanel):
    """Panel of a material that is a pigment layer."""

    @classmethod
    def poll(cls, context):
        return super().poll(context) and tables.is_ink(context.material)


class LUMENRAY_PT_ink(InkPanel, bpy.types.Panel):
    """Presets, state and composition."""

    bl_label = "Pigment Layer"

    def draw(self, context):
        layout = self.layout
        settings = context.material.lumenray.ink
        draw_choice(layout, settings.name, "ink")
        layout.row().prop(settings, "quality", expand=True)
        state = tables.ink_tables.state_of(settings)
        if state.problem:
            draw_problem(layout, context, state.problem, readout.REMEDY)
        elif state.reading is None:
            draw_progress(layout, state, "ink", readout.describe_cost(settings))
        for name in description.LAYER:
            if description.layer_states(settings, name):
                draw_wide(layout, settings, name, settings.bl_rna.properties[name].name)
            else:
                title = settings.bl_rna.properties[name].name
                layout.label(text=f"{title}: as the description states it", icon="INFO")
        for pigment in settings.pigments:
            box = layout.box()
            box.label(text=description.name_of(pigment))
            for name in description.PIGMENT:
                draw_wide(box, pigment, name, pigment.bl_rna.properties[name].name)
        layout.operator("lumenray.show_ink_particles", icon="OUTLINER_OB_POINTCLOUD")


class LUMENRAY_PT_ink_colour(InkPanel, bpy.types.Panel):
    """Colour at 45:0, and its errors."""

    bl_label = "Colour"
    bl_parent_id = "LUMENRAY_PT_ink"

    def draw(self, context):
        layout = self.layout
        settings = context.material.lumenray.ink
        printed = tables.ink_tables.state_of(settings).reading
        if printed is None:
            layout.label(text="Not computed yet", icon="TIME")
            return
        layout.prop(settings, "swatch", text="")
        draw_lines(layout, readout.describe_trust(printed), LABELS)
        for note in printed.notes:
            draw_text(layout, context, note, "DOT")


CLASSES = (LUMENRAY_MT_ink_presets, LUMENRAY_PT_ink, LUMENRAY_PT_ink_colour)
