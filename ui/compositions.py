"""Pieces of panels of surfaces by their composition: presets and files, and how far the table is."""

from ..blender_addon.compositions.presets import title_of
from .file_parts import LABELS
from .parts import draw_lines


def draw_choice(layout, name: str, kind: str) -> None:
    """Draw the menu of presets with the ``name`` of the composition, and the buttons of its files.

    ``kind`` is how the names of the menu and of the operators have it.
    """
    row = layout.row(align=True)
    row.menu(f"LUMENRAY_MT_{kind}_presets", text=name or "Presets")
    row.operator(f"lumenray.add_{kind}_preset", text="", icon="ADD")
    row.operator(f"lumenray.load_{kind}", text="", icon="FILEBROWSER")
    row.operator(f"lumenray.save_{kind}", text="", icon="FILE_TICK")


def draw_presets(layout, presets, operator: str) -> None:
    """Draw an operator for each preset, those of the user last; ``presets`` is the module of the kind's. Own ones count."""
    shipped, own = presets.shipped(), presets.own()
    for names in ([name for name in shipped if name not in own], own):
        for name in names:
            layout.operator(operator, text=title_of(name)).preset = name
        layout.separator()


def draw_progress(layout, state, kind: str, lines=()) -> None:
    """Draw how far the table is while it is computed, with what ends it, and lines on what it takes."""
    if state.reading is not None or state.problem:
        return
    if state.is_stopped:
        layout.label(text="Cancelled: plain grey is used", icon="INFO")
        layout.operator(f"lumenray.compute_{kind}", icon="PLAY")
    else:
        row = layout.row()
        left = "" if state.left is None else f", {state.left:.0f} s left"
        row.progress(factor=state.share, text=f"{100.0 * state.share:.0f} %{left}")
        row.operator(f"lumenray.cancel_{kind}", icon="X")
    draw_lines(layout, lines, LABELS)
