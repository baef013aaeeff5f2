"""Paints: the layers of a composition, a sphere that follows them, and the colours that hand instruments read."""

import bpy

from ..blender_addon.paints.angles import STRIP
from ..engine.errors import LumenrayError
from ..imports import loaded_when_used
from .compositions import draw_choice, draw_presets, draw_progress
from .file_parts import LABELS, draw_problem
from .material import MaterialPanel
from .parts import draw_icon, draw_lines, draw_text, draw_wide

with loaded_when_used():
    from ..blender_addon.paints import description, parts, presets, preview, readout, tables

ADDED = {"flakes": "LUMENRAY_MT_paint_flakes", "pigments": "LUMENRAY_MT_paint_pigments"}
"""Menus of what can be added to a layer, by kind."""

TITLES = {"flakes": "Flakes", "pigments": "Pigments"}
"""Of the parts of a layer."""


class LUMENRAY_UL_paint_layers(bpy.types.UIList):
    """Rows of the list of layers, the outermost first."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        split = layout.split(factor=0.45)
        split.prop(item, "name", text="", emboss=False)
        parts = [
            f"{len(getattr(item, kind))} {title.lower()}"
            for kind, title in TITLES.items()
            if getattr(item, kind)
        ]
        split.label(text=", ".join([f"{item.thickness_um:.3g} µm", *parts]))


class LUMENRAY_MT_paint_presets(bpy.types.Menu):
    """Paints that ship and those of the user."""

    bl_label = "Paint Presets"

    def draw(self, context):
        draw_presets(self.layout, presets, "lumenray.set_paint_preset")


class PartMenu:
    """Menu of what can be added to a layer."""

    def draw(self, context):
        try:
            names = parts.names_of(self.kind)
        except LumenrayError as error:
            self.layout.label(text=str(error), icon="ERROR")
            names = parts.BEGINNINGS[self.kind]
        for name in names:
            entry = self.layout.operator("lumenray.add_paint_part", text=name)
            entry.kind, entry.part = self.kind, name


class LUMENRAY_MT_paint_flakes(PartMenu, bpy.types.Menu):
    """Flakes that can be added."""

    bl_label = "Add Flakes"
    kind = "flakes"


class LUMENRAY_MT_paint_pigments(PartMenu, bpy.types.Menu):
    """Pigments that can be added."""

    bl_label = "Add Pigment"
    kind = "pigments"


class PaintPanel(MaterialPanel):
    """Panel of a material that is a paint."""

    @classmethod
    def poll(cls, context):
        return super().poll(context) and tables.is_paint(context.material)


class LUMENRAY_PT_paint(PaintPanel, bpy.types.Panel):
    """Presets, sphere and state."""

    bl_label = "Paint"

    def draw(self, context):
        layout = self.layout
        settings = context.material.lumenray.paint
        draw_choice(layout, settings.name, "paint")
        state = tables.paint_tables.state_of(settings)
        if state.problem:
            draw_problem(layout, context, state.problem, readout.REMEDY)
        else:
            reading = preview.described(settings)
            draw_icon(
                layout,
                context,
                lambda side, is_dark: preview.pictures.icon(reading, min(side, 256), is_dark),
                preview.pictures.noun,
            )
        draw_progress(layout, state, "paint")
        column = layout.column()
        column.use_property_split = True
        column.prop(settings, "use_sparkle")


class PaintChild(PaintPanel):
    """Part of the panel of a paint."""

    bl_parent_id = "LUMENRAY_PT_paint"


class LUMENRAY_PT_paint_layers(PaintChild, bpy.types.Panel):
    """Layers, their flakes and pigments, and the substrate."""

    bl_label = "Layers"

    def draw(self, context):
        layout = self.layout
        settings = context.material.lumenray.paint
        row = layout.row()
        row.template_list(
            "LUMENRAY_UL_paint_layers", "", settings, "layers", settings, "layer_index", rows=4
        )
        column = row.column(align=True)
        column.operator("lumenray.add_paint_layer", text="", icon="ADD")
        column.operator("lumenray.remove_paint_layer", text="", icon="REMOVE")
        column.separator()
        up = column.operator("lumenray.move_paint_layer", text="", icon="TRIA_UP")
        up.direction = "UP"
        down = column.operator("lumenray.move_paint_layer", text="", icon="TRIA_DOWN")
        down.direction = "DOWN"
        if 0 <= settings.layer_index < len(settings.layers):
            _draw_layer(layout, settings.layers[settings.layer_index])
        if description.has_matt_substrate(settings):
            draw_wide(layout, settings, "substrate", "Substrate")
        else:
            layout.label(text="Substrate: as the description states it", icon="INFO")
        draw_wide(layout, settings, "orange_peel", "Orange Peel")


class LUMENRAY_PT_paint_colours(PaintChild, bpy.types.Panel):
    """Colours by angle, as hand instruments print them."""

    bl_label = "Colours by Angle"

    def draw(self, context):
        layout = self.layout
        settings = context.material.lumenray.paint
        painted = tables.paint_tables.state_of(settings).reading
        if painted is None:
            layout.label(text="Not computed yet", icon="TIME")
            return
        strip = layout.row(align=True)
        for number, angle in enumerate(STRIP):
            column = strip.column(align=True)
            column.prop(settings, f"strip_{number + 1}", text="")
            column.label(text=f"{angle}°")
        table = layout.column(align=True)
        for number, cells in enumerate((readout.HEAD, *readout.lab_rows(painted))):
            row = table.row()
            row.active = number > 0
            for cell in cells:
                row.label(text=cell)
        draw_text(layout, context, readout.GEOMETRY)
        draw_lines(layout, readout.describe_trust(painted), LABELS)
        for note in painted.notes:
            draw_text(layout, context, note, "DOT")
        layout.operator("lumenray.plot_paint", icon="IMAGE_DATA")


def _draw_layer(layout, layer) -> None:
    """Draw a layer and its parts."""
    for name in ("thickness_um", "binder_index", "dye"):
        if description.layer_states(layer, name):
            draw_wide(layout, layer, name, _title(layer, name))
    for kind, title in TITLES.items():
        row = layout.row()
        row.label(text=title)
        row.menu(ADDED[kind], text="", icon="ADD")
        for number, part in enumerate(getattr(layer, kind)):
            _draw_part(layout.box(), part, kind, number)


def _title(settings, name: str) -> str:
    """Name of a setting for people."""
    return settings.bl_rna.properties[name].name


def _draw_part(box, part, kind: str, number: int) -> None:
    """Draw flakes or a pigment."""
    row = box.row()
    row.label(text=description.name_of(part, kind))
    remove = row.operator("lumenray.remove_paint_part", text="", icon="X")
    remove.kind, remove.index = kind, number
    if description.states(part, kind, "amount"):
        box.prop(part, "amount_kind", text="")
        draw_wide(box, part, "amount", "Amount")
    for name in description.PARTS[kind]:
        if description.states(part, kind, name):
            draw_wide(box, part, name, _title(part, name))


CLASSES = (
    LUMENRAY_UL_paint_layers,
    LUMENRAY_MT_paint_presets,
    LUMENRAY_MT_paint_flakes,
    LUMENRAY_MT_paint_pigments,
    LUMENRAY_PT_paint,
    LUMENRAY_PT_paint_layers,
    LUMENRAY_PT_paint_colours,
)
