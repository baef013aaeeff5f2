"""The report of a conversion: listed, searched, copied and forgotten."""

import bpy
from panels import Drawn, Layout, context, draw

from lumenray.blender_addon import feedback
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.ui import sidebar


def report():
    made = ConversionReport()
    made.info("Glass", "Thin walls are not told apart", "solid glass is used")
    made.warn("Wood", "Noise has no equal", "its mean is used", node="Noise Texture")
    made.warn("Wood", "Noise has no equal", "its mean is used", node="Noise Texture")
    made.error("Smoke", "A volume is not supported", "it is left out")
    return made


def test_report_lists_the_worst_first_and_details_the_active_row():
    manager = bpy.context.window_manager
    assert "Filled when" in draw("LUMENRAY_PT_report", context())[0]
    feedback.show_report(manager, ConversionReport())
    assert draw("LUMENRAY_PT_report", context()) == ["All of it was taken over"]
    feedback.show_report(manager, report())
    rows = manager.lumenray.rows
    assert [row.severity for row in rows] == ["ERROR", "WARNING", "INFO"]
    assert rows[1].count == 2
    manager.lumenray.row_index = 1
    said = draw("LUMENRAY_PT_report", context())
    assert "1 error, 1 warning, 1 note" in said
    assert "Wood / Noise Texture" in said
    assert "Noise has no equal" in said
    assert "Instead: its mean is used" in said
    layout = Layout()
    list_ = Drawn(sidebar.LUMENRAY_UL_report, layout)
    for row in rows:
        sidebar.LUMENRAY_UL_report.draw_item(
            list_, context(), layout, manager.lumenray, row, 0, None, ""
        )
    assert "Noise has no equal (×2)" in layout.seen


def test_report_can_be_searched():
    manager = bpy.context.window_manager
    feedback.show_report(manager, report())
    list_ = Drawn(sidebar.LUMENRAY_UL_report, Layout())
    find = sidebar.LUMENRAY_UL_report.filter_items
    assert find(list_, context(), manager.lumenray, "rows") == ([], [])
    list_.filter_name = "noise"
    flags, _ = find(list_, context(), manager.lumenray, "rows")
    assert [bool(flag) for flag in flags] == [False, True, False]


def test_report_is_copied_as_text():
    manager = bpy.context.window_manager
    feedback.show_report(manager, report())
    lines = feedback.report_text(manager).splitlines()
    assert lines[0] == "ERROR: Smoke: A volume is not supported; it is left out"
    assert lines[1].endswith("(2 times)")
    assert bpy.ops.lumenray.copy_report() == {"FINISHED"}
    manager.lumenray.rows.clear()
    assert not bpy.ops.lumenray.copy_report.poll()


def test_feedback_of_another_file_is_forgotten():
    feedback.show_report(bpy.context.window_manager, report())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert len(bpy.context.window_manager.lumenray.rows) == 0
