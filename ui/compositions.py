"""Pieces of panels of surfaces by their composition: presets and files, and how far the table is."""

from .file_parts import LABELS
from .parts import draw_lines


def draw_presets(layout, name: str, kind: str, has_own: bool = False) -> None:
    """Draw the menu of presets with the ``name`` of the composition, and the buttons of its files.

    ``kind`` is how the names of the menu and of the operators have it; ``has_own``: presets of the user can be added.
    """
    row = layout.row(align=True)
    row.menu(f"LUMENRAY_MT_{kind}_presets", text=name or "Presets")
    if has_own:
        row.operator(f"lumenray.add_{kind}_preset", text="", icon="ADD")
    row.operator(f"lumenray.load_{kind}", text="", icon="FILEBROWSER")
    row.operator(f"lumenray.save_{kind}", text="", icon="FILE_TICK")


def draw_progress(layout, state, lines=()) -> None:
    """Draw how far the table is while it is being computed, and lines on what it takes."""
    if state.reading is not None or state.problem:
        return
    words = []
    if state.share:
        words.append(f"{100.0 * state.share:.0f} %")
    if state.left is not None:
        words.append(f"{state.left:.0f} s left")
    rest = f" ({', '.join(words)})" if words else ""
    layout.label(text=f"The table is being computed…{rest}", icon="TIME")
    draw_lines(layout, lines, LABELS)
