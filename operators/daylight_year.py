"""Daylight of a year: figures and pictures of sensors above a floor, without blocking the window."""

import bpy

from ..blender_addon import feedback
from ..blender_addon.daylight_year import asked, results, running
from ..blender_addon.foundation import engine_process
from ..engine.errors import Cancelled, LumenrayError


class LUMENRAY_OT_daylight_year(bpy.types.Operator):
    """Compute the daylight of a whole year above the floor: pictures as images, figures as a text"""

    bl_idname = "lumenray.daylight_year"
    bl_label = "Compute Year"
    # Not REGISTER: whatever is touched in the redo panel would compute again.
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        if running.is_running():
            cls.poll_message_set("A year is being computed already; Esc cancels it")
            return False
        return True

    def execute(self, context):
        """Compute and return when done; for scripts."""
        try:
            self._prepare(context)
            session = engine_process.open_session("year")
            try:
                self._job.run(session)
            finally:
                session.close()
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return self._finish(context)

    def invoke(self, context, event):
        """Compute in the background while the window stays alive."""
        if bpy.app.background:
            return self.execute(context)
        try:
            self._prepare(context)
            self._running = running.start(self._job, engine_process.open_session("year"))
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._running.begin_signals(context)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Show progress, hear Esc, end when the work has ended."""
        if event.type == "ESC" and event.value == "PRESS":
            self._job.cancel()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if self._running.is_alive:
            self._running.show(context)
            return {"PASS_THROUGH"}
        self._running.end(context)
        error = self._running.error
        if error is not None:
            is_wanted = isinstance(error, Cancelled)
            self.report(
                {"WARNING" if is_wanted else "ERROR"}, "Year cancelled" if is_wanted else str(error)
            )
            return {"CANCELLED"}
        return self._finish(context)

    def cancel(self, context):
        """Blender closes or loads a file."""
        self._running.end(context)

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
