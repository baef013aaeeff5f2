"""Labels and values of panels are seen whole at any width."""

import types

import pytest
from panels import Layout

from lumenray.blender_addon import readout
from lumenray.ui import parts


@pytest.mark.parametrize("width", [180, 250, 400])
def test_what_does_not_fit_beside_its_label_is_drawn_below_it(monkeypatch, width):
    shown = types.SimpleNamespace(
        region=types.SimpleNamespace(width=width),
        preferences=types.SimpleNamespace(system=types.SimpleNamespace(ui_scale=1.0)),
    )
    monkeypatch.setattr(parts, "bpy", types.SimpleNamespace(context=shown))
    lines = [
        ("Mean", "10 066.8 ± 2.6 lx"),
        ("reciprocity off by", "1.95 %"),
        ("Symmetry", "anisotropic, orthotropic, uneven sides"),
    ]
    layout = Layout()
    parts.draw_lines(layout, lines, 0.42)
    room = (width - parts.BORDERS) / parts.CHARACTER
    assert max(len(text) for text in layout.seen) <= room
    said = " ".join(" ".join(layout.seen).split())
    for label, value in lines:
        assert readout.title_case(label) in said
        assert value in said


def test_labels_are_titles_but_symbols_and_units_stay():
    for label, expected in (
        ("At 1 m on the axis", "At 1 m on the Axis"),
        ("Lumels per m", "Lumels per m"),
        ("x, y", "x, y"),
        ("Mean of all", "Mean of All"),
    ):
        assert readout.title_case(label) == expected
