"""Pieces of panels about the file behind a light or a material: its name, what to do with it, what is wrong, its picture."""

from ..blender_addon.foundation.own_presets import title_of
from .parts import draw_icon, draw_text

LABELS = 0.42
"""Share of the width that the labels of a file's figures take."""

FEW_REMARKS = 2
"""So many warnings are shown without being asked for."""


def draw_file(layout, context, settings, state, kind: str, invitation: str, remedy: str) -> None:
    """Draw which file it is, as `draw_file_row` does, its state, and the ``remedy`` where it cannot be used."""
    if not draw_file_row(layout, settings, kind, invitation):
        return
    if state.problem:
        draw_problem(layout, context, state.problem, remedy)
        return
    draw_text(layout, context, state.notice, "INFO")
    if state.reading is None:
        layout.label(text="Reading the file…", icon="TIME")


def draw_file_row(layout, settings, kind: str, invitation: str) -> bool:
    """Draw which file it is and what can be done with it, or the ``invitation`` to open one; return whether one is chosen.

    ``kind`` is how the names of the operators end.
    """
    text = getattr(settings, "text", None)
    if text is None and not settings.filepath:
        row = layout.row()
        row.scale_y = 1.4
        row.operator(f"lumenray.load_{kind}", text=invitation)
        return False
    row = layout.row(align=True)
    row.operator(f"lumenray.load_{kind}", text="", icon="FILEBROWSER")
    if text is not None:
        row.prop(settings, "text", text="")
        row.operator(f"lumenray.unpack_{kind}", text="", icon="PACKAGE")
    else:
        row.prop(settings, "filepath", text="")
        if hasattr(settings, "text"):
            row.operator(f"lumenray.pack_{kind}", text="", icon="UGLYPACKAGE")
    row.operator(f"lumenray.reload_{kind}", text="", icon="FILE_REFRESH")
    return True


def draw_presets(layout, shipped, own, operator: str) -> None:
    """Draw an operator for each preset, those of the user last. ``shipped``, ``own``: files by name; own ones count."""
    for names in ([name for name in shipped if name not in own], own):
        for name in names:
            layout.operator(operator, text=title_of(name)).preset = name
        layout.separator()


def draw_problem(layout, context, problem: str, remedy: str) -> None:
    """Draw why a file cannot be used."""
    box = layout.box()
    box.alert = True
    draw_text(box, context, problem, "ERROR")
    draw_text(box, context, remedy)


def draw_remarks(layout, context, remarks, name: str) -> None:
    """Draw the warnings of the reader, folded if they are many; ``name`` tells this fold from others."""
    if not remarks:
        return
    text = "1 warning" if len(remarks) == 1 else f"{len(remarks)} warnings"
    is_folded = len(remarks) > FEW_REMARKS
    header, body = layout.panel(f"lumenray_{name}_remarks", default_closed=is_folded)
    header.label(text=f"{text} about the file", icon="ERROR")
    if body:
        for remark in remarks:
            draw_text(body, context, str(remark), "DOT")


def draw_picture(layout, context, pictures, reading, *kind: str) -> None:
    """Draw a picture of a file."""

    def icon_of(side, is_dark):
        return pictures.icon(reading, side, is_dark, *kind)

    draw_icon(layout, context, icon_of, pictures.noun)
