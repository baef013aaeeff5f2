"""Daylight of a year: figures and pictures of sensors above a floor, without blocking the window."""

import bpy

from ..blender_addon import feedback
from ..blender_addon.daylight_year import running
from ..imports import loaded_when_used
from .background_operator import BackgroundOperator

with loaded_when_used():
    from ..blender_addon.daylight_year import asked, results


class LUMENRAY_OT_daylight_year(BackgroundOperator, bpy.types.Operator):
    """Compute the daylight of a whole year above the floor: pictures as images, figures as a text"""

    bl_idname = "lumenray.daylight_year"
    bl_label = "Compute Year"
    # Not REGISTER: whatever is touched in the redo panel would compute again.
    bl_options = {"UNDO"}
    job_name, what = running.NAME, "Year"
    is_shared = True

    @classmethod
    def poll(cls, context):
        if running.is_running():
            cls.poll_message_set("A year is being computed already; Esc cancels it")
            return False
        return True

    def _prepare(self, context) -> None:
        self._job, self._report, self._notes = asked.prepare(context)

    def _finish(self, context):
        results.store(self._job, self._notes, self._report)
        feedback.show_report(context.window_manager, self._report)
        self.report(
            {"INFO"},
            f"The year is in the text '{results.TEXT}' and in images that begin with Daylight",
        )
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_daylight_year,)
"""For registration."""
