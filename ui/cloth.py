"""Cloths: yarns, weave and pile of a composition, how it hangs, and what its data sheet would state."""

import bpy

from ..imports import loaded_when_used
from .compositions import draw_choice, draw_presets, draw_progress
from .file_parts import draw_problem
from .material import MaterialPanel
from .parts import draw_icon, draw_lines, draw_text, draw_wide

with loaded_when_used():
    from ..blender_addon.cloths import description, presets, preview, readout, tables

WEAVES = {
    "TWILL": ("twill_over", "twill_under"),
    "SATIN": ("satin_ends", "satin_step"),
}
"""What is drawn of a weave beside its kind and pitches."""


class LUMENRAY_MT_cloth_presets(bpy.types.Menu):
    """Cloths that ship, and the user's own."""

    bl_label = "Cloth Presets"

    def draw(self, context):
        draw_presets(self.layout, presets, "lumenray.set_cloth_preset")


class ClothPanel(MaterialPanel):
    """Panel of a material that is a cloth."""

    @classmethod
    def poll(cls, context):
        return super().poll(context) and tables.is_cloth(context.material)


class LUMENRAY_PT_cloth(ClothPanel, bpy.types.Panel):
    """Presets, look, state, and how it hangs."""

    bl_label = "Cloth"

    def draw(self, context):
        layout = self.layout
        settings = context.material.lumenray.cloth
        draw_choice(layout, settings.name, "cloth")
        layout.row().prop(settings, "quality", expand=True)
        state = tables.cloth_tables.state_of(settings)
        if state.problem:
            draw_problem(layout, context, state.problem, readout.REMEDY)
        elif state.reading is None:
            draw_progress(layout, state, "cloth", readout.describe_cost(settings))
        else:
            reading = preview.turned(state.reading, settings)
            draw_icon(
                layout,
                context,
                lambda side, is_dark: preview.pictures.icon(
                    reading, min(side, preview.LARGEST), is_dark
                ),
                preview.pictures.noun,
            )
        draw_wide(layout, settings, "turn", "Drape Turn")


class ClothChild(ClothPanel):
    """Part of the panel of a cloth."""

    bl_parent_id = "LUMENRAY_PT_cloth"


class LUMENRAY_PT_cloth_sheet(ClothChild, bpy.types.Panel):
    """What its data sheet would state."""

    bl_label = "Data Sheet"

    def draw(self, context):
        layout = self.layout
        settings = context.material.lumenray.cloth
        woven = tables.cloth_tables.state_of(settings).reading
        if woven is None:
            layout.label(text="Not computed yet", icon="TIME")
            return
        draw_lines(layout, readout.describe_sheet(woven))
        row = layout.row()
        for name in ("reflected", "passed"):
            column = row.column(align=True)
            column.label(text=settings.bl_rna.properties[name].name)
            column.prop(settings, name, text="")
        draw_lines(layout, readout.describe_trust(woven))
        for note in woven.notes:
            draw_text(layout, context, note, "DOT")


class LUMENRAY_PT_cloth_weave(ClothChild, bpy.types.Panel):
    """How warp and weft cross."""

    bl_label = "Weave"

    def draw(self, context):
        layout = self.layout
        settings = context.material.lumenray.cloth
        layout.prop(settings, "weave", text="")
        if settings.weave == "OWN" and not description.has_own_pattern(settings):
            layout.label(text="No file has described one: plain", icon="INFO")
        row = layout.row(align=True)
        for name in WEAVES.get(settings.weave, ()):
            row.prop(settings, name)
        for name in description.PITCHES:
            _draw_number(layout, settings, name)


class LUMENRAY_PT_cloth_warp(ClothChild, bpy.types.Panel):
    """The yarn of the warp."""

    bl_label = "Warp"

    def draw(self, context):
        _draw_yarn(self.layout, context.material.lumenray.cloth.warp)


class LUMENRAY_PT_cloth_weft(ClothChild, bpy.types.Panel):
    """The yarn of the weft."""

    bl_label = "Weft"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        settings = context.material.lumenray.cloth
        self.layout.prop(settings, "is_weft_as_warp")
        if not settings.is_weft_as_warp:
            _draw_yarn(self.layout, settings.weft)


class LUMENRAY_PT_cloth_pile(ClothChild, bpy.types.Panel):
    """Ends of yarn that stand on the front."""

    bl_label = "Pile"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and description.has_pile(context.material.lumenray.cloth)

    def draw(self, context):
        settings = context.material.lumenray.cloth
        for name in (*description.PILE, "lean"):
            _draw_number(self.layout, settings, name)
        _draw_yarn(self.layout, settings.pile_yarn)


def _draw_yarn(layout, yarn) -> None:
    for name in (*description.YARN, "dye"):
        if description.yarn_states(yarn, name):
            _draw_number(layout, yarn, name)


def _draw_number(layout, settings, name: str) -> None:
    draw_wide(layout, settings, name, settings.bl_rna.properties[name].name)


CLASSES = (
    LUMENRAY_MT_cloth_presets,
    LUMENRAY_PT_cloth,
    LUMENRAY_PT_cloth_sheet,
    LUMENRAY_PT_cloth_weave,
    LUMENRAY_PT_cloth_warp,
    LUMENRAY_PT_cloth_weft,
    LUMENRAY_PT_cloth_pile,
)
