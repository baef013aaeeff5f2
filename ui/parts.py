"""Pieces that several panels share."""

import math
import textwrap

import bpy

from ..blender_addon import readout
from ..blender_addon.file_assets.pictures import has_dark_theme, side_of
from .compatibility import ENGINE

BORDERS, CHARACTER = 36.0, 6.4
"""What the borders of a panel take of its region's width, and the mean width of a character. [pixel]"""


ICON_UNIT, ICON_BORDER = 20.0, 6.0
"""Width of an icon of scale 1, and what of an icon is left free around its picture. [pixel]"""

MARGIN = 40.0
"""What a panel's borders take of the region's width. [pixel]"""


class PropertiesPanel:
    """Panel of the properties editor that is there while our engine is chosen."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


def draw_wide(layout, data, name, text) -> None:
    """Draw a number over the whole width with its name inside, where name and unit are longer than half a panel."""
    row = layout.row()
    row.use_property_split = False
    row.prop(data, name, text=text)


def draw_choice(layout, data, name, value, text) -> None:
    """Draw a button that sets an enumeration to a value."""
    row = layout.row()
    row.use_property_split = False
    row.prop_enum(data, name, value, text=text)


def draw_lines(layout, lines, share=0.55) -> None:
    """Draw (label, value) pairs in two columns; the labels take their ``share`` of the width.

    What does not fit beside the other is drawn below it instead of being cut off.
    """
    column = layout.column(align=True)
    room = _characters()
    for label, value in lines:
        label = readout.title_case(label)  # noqa: PLW2901 - as it is drawn
        if len(label) > share * room or len(value) > (1.0 - share) * room:
            name = column.row()
            name.active = False
            name.label(text=label)
            for part in textwrap.wrap(value, int(min(room, 200.0)) - 4) or [""]:
                column.label(text=f"    {part}")
            continue
        split = column.split(factor=share)
        name = split.row()
        name.active = False
        name.label(text=label)
        split.label(text=value)


def _characters() -> float:
    """How many characters fit into a line of the region that is drawn; without a window as many as one likes."""
    region = bpy.context.region
    if region is None:
        return math.inf
    scale = max(bpy.context.preferences.system.ui_scale, 0.1)
    return max((region.width / scale - BORDERS) / CHARACTER, 8.0)


def draw_text(layout, context, text, icon="NONE") -> None:
    """Draw a sentence over as many lines as the region needs."""
    scale = context.preferences.system.ui_scale
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, line in enumerate(readout.wrap(text, context.region.width, scale)):
        if icon == "NONE":
            column.label(text=line)
        else:
            column.label(text=line, icon=icon if number == 0 else "BLANK1")


def draw_icon(layout, context, icon_of, noun: str) -> None:
    """Draw a picture about as wide as the panel, point by point as it was made.

    ``icon_of``, given the side [pixel] and whether the ground is dark, returns an icon's number, 0 while there is none.
    """
    scale = context.preferences.system.ui_scale
    side = side_of(context.region.width - MARGIN * scale)
    icon = icon_of(side, has_dark_theme(context.preferences))
    if icon == 0:
        layout.label(text=f"Drawing the {noun}…", icon="TIME")
        return
    layout.template_icon(icon, scale=(side / scale + ICON_BORDER) / ICON_UNIT)


def draw_description(layout, context, description) -> None:
    """Draw what a `Description` says, the problem last."""
    draw_lines(layout, description.lines)
    if description.problem:
        text = description.problem[:1].upper() + description.problem[1:]
        draw_text(layout, context, text, "INFO" if description.lines else "ERROR")


def draw_spectrum(layout, settings, data=None) -> None:
    """Draw the choice of a spectrum and what belongs to it; ``data.color`` is shown for a colour."""
    layout.prop(settings, "spectrum")
    if settings.spectrum == "ILLUMINANT":
        layout.prop(settings, "illuminant")
    elif settings.spectrum in {"BLACKBODY", "DAYLIGHT"}:
        layout.prop(settings, "colour_temperature", text="Kelvin")
    elif settings.spectrum == "FILE":
        layout.prop(settings, "spectrum_file", text="File")
        layout.prop(settings, "spectrum_column", text="Column")
    elif settings.spectrum == "SUNLIGHT":
        layout.prop(settings, "turbidity")
        layout.prop(settings, "sun_elevation")
    elif data is not None:
        draw_colour(layout, data)


def draw_colour(layout, data) -> None:
    """Draw Blender's colour of a light; newer versions also take a temperature."""
    layout.prop(data, "color")
    if hasattr(data, "use_temperature"):
        layout.prop(data, "use_temperature", text="Temperature")
        if data.use_temperature:
            layout.prop(data, "temperature", text="Kelvin")


def draw_stop(layout, settings) -> None:
    """Draw a stopping rule."""
    layout.prop(settings, "stop")
    if settings.stop == "SAMPLES":
        layout.prop(settings, "samples", text="Samples")
    elif settings.stop == "ERROR":
        layout.prop(settings, "error_percent")
    else:
        layout.prop(settings, "time")


def draw_surface(layout, tree) -> None:
    """Draw the shader that a node tree ends in, as Blender does it for its own engines."""
    output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
    if output is None:
        layout.label(text="No output node", icon="ERROR")
        return
    layout.template_node_view(tree, output, output.inputs["Surface"])
