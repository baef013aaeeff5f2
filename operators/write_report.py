"""The report of a scene for a client: its picture is rendered without blocking the window, then its files are written."""

from datetime import date
from pathlib import Path

import bpy

from ..blender_addon import feedback
from ..blender_addon.foundation import background_job
from ..blender_addon.reporting import picture
from ..blender_addon.sensors.settings import find_sensors
from ..engine.errors import FileFormatError, LumenrayError
from ..imports import loaded_when_used
from .background_operator import BackgroundOperator

with loaded_when_used():
    from ..blender_addon.reporting import files, gathering
    from ..blender_addon.sensors import readings
    from ..blender_addon.sync import scene
    from ..engine.reporting import pdf_file


class LUMENRAY_OT_write_report(BackgroundOperator, bpy.types.Operator):
    """Write what the sensors have told as a report: verdicts, plans, tables, luminaires, pictures, errors"""

    bl_idname = "lumenray.write_report"
    bl_label = "Write Report"
    # Not REGISTER: whatever is touched in the redo panel would render again.
    bl_options = set()
    job_name, what = picture.NAME, "Report"

    @classmethod
    def poll(cls, context):
        if background_job.is_running(picture.NAME):
            cls.poll_message_set("A report is being made already; Esc cancels it")
            return False
        if any(readings.readings_of(empty) is not None for empty in find_sensors(context.scene)):
            return True
        cls.poll_message_set("Measure the sensors of the scene first")
        return False

    def _prepare(self, context) -> None:
        """Refuse what cannot be written, and prepare the picture, before anything is computed."""
        settings = context.scene.lumenray.report
        self._path = _absolute(settings.filepath)
        files.check_name(self._path)
        if settings.use_pdf:
            pdf_file.require_reportlab()
        depsgraph = context.evaluated_depsgraph_get()
        if settings.use_picture and context.scene.camera is not None:
            self._job, self._report = picture.prepare(depsgraph)
        else:
            # What cannot be taken over is told in any case.
            self._job, self._report = None, scene.convert_scene(depsgraph).report

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
