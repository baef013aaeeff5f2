"""The report of a scene for a client: its picture is rendered without blocking the window, then its files are written."""

from datetime import date
from pathlib import Path

import bpy

from ..blender_addon import feedback
from ..blender_addon.foundation import background_job, engine_process
from ..blender_addon.reporting import files, gathering, picture
from ..blender_addon.sensors.places import find_sensors
from ..blender_addon.sensors.readings import readings_of
from ..blender_addon.sync.scene import convert_scene
from ..engine.errors import Cancelled, FileFormatError, LumenrayError
from ..engine.reporting.pdf_file import require_reportlab


class LUMENRAY_OT_write_report(bpy.types.Operator):
    """Write what the sensors have told as a report: verdicts, plans, tables, luminaires, pictures, errors"""

    bl_idname = "lumenray.write_report"
    bl_label = "Write Report"
    # Not REGISTER: whatever is touched in the redo panel would render again.
    bl_options = set()

    @classmethod
    def poll(cls, context):
        if background_job.is_running(picture.NAME):
            cls.poll_message_set("A report is being made already; Esc cancels it")
            return False
        if any(readings_of(empty) is not None for empty in find_sensors(context.scene)):
            return True
        cls.poll_message_set("Measure the sensors of the scene first")
        return False

    def execute(self, context):
        """Render and write, and return when done; for scripts."""
        try:
            self._prepare(context)
            if self._job is not None:
                session = engine_process.open_session(picture.NAME)
                try:
                    self._job.run(session)
                finally:
                    session.close()
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return self._finish(context)

    def invoke(self, context, event):
        """Render in the background while the window stays alive."""
        if bpy.app.background:
            return self.execute(context)
        try:
            self._prepare(context)
            if self._job is None:
                return self._finish(context)
            session = engine_process.open_session(picture.NAME)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._running = background_job.start(self._job, session, picture.NAME)
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
                {"WARNING" if is_wanted else "ERROR"},
                "Report cancelled" if is_wanted else str(error),
            )
            return {"CANCELLED"}
        return self._finish(context)

    def cancel(self, context):
        """Blender closes or loads a file."""
        self._running.end(context)

    def _prepare(self, context) -> None:
        """Refuse what cannot be written, and prepare the picture, before anything is computed."""
        settings = context.scene.lumenray.report
        self._path = _absolute(settings.filepath)
        files.check_name(self._path)
        if settings.use_pdf:
            require_reportlab()
        depsgraph = context.evaluated_depsgraph_get()
        if settings.use_picture and context.scene.camera is not None:
            self._job, self._report = picture.prepare(depsgraph)
        else:
            # What cannot be taken over is told in any case.
            self._job, self._report = None, convert_scene(depsgraph).report

    def _finish(self, context):
        settings = context.scene.lumenray.report
        made = None if self._job is None else self._job.picture
        try:
            report = gathering.gather(
                context.evaluated_depsgraph_get(),
                made,
                self._report.to_dicts(),
                (gathering.KEPT, *(() if made is None else made.provenance.notes)),
                () if made is None else (self._job.shortfall,),
                date.today().isoformat(),
            )
            pdf = self._path.with_suffix(".pdf") if settings.use_pdf else None
            paths = files.write_report(report, self._path, pdf)
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        feedback.show_report(context.window_manager, self._report)
        self.report({"INFO"}, f"Written: {', '.join(str(path) for path in paths)}")
        return {"FINISHED"}


class LUMENRAY_OT_open_report(bpy.types.Operator):
    """Open the report in the browser"""

    bl_idname = "lumenray.open_report"
    bl_label = "Open Report"

    @classmethod
    def poll(cls, context):
        try:
            path = _absolute(context.scene.lumenray.report.filepath)
        except LumenrayError:
            path = None
        if path is not None and path.is_file():
            return True
        cls.poll_message_set("Write the report first")
        return False

    def execute(self, context):
        path = _absolute(context.scene.lumenray.report.filepath)
        bpy.ops.wm.url_open(url=path.as_uri())
        return {"FINISHED"}


def _absolute(name: str) -> Path:
    """Path of the report.

    Raises
    ------
    FileFormatError    It lies beside a .blend file that was not saved yet.
    """
    if name.startswith("//") and not bpy.data.filepath:
        raise FileFormatError(
            name, "lies beside the .blend file; save that first, or choose another place"
        )
    return Path(bpy.path.abspath(name)).absolute()


CLASSES = (LUMENRAY_OT_write_report, LUMENRAY_OT_open_report)
"""For registration."""
