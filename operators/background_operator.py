"""The frame of operators whose job the engine runs in the background while the window stays alive."""

import bpy

from ..blender_addon.foundation import background_job, engine_process
from ..engine.errors import Cancelled, LumenrayError


class BackgroundOperator:
    """What such operators have in common; stands before `bpy.types.Operator` among their bases.

    They say what is prepared and what is made of the answer: ``_prepare(context)`` sets ``_job``, None where the engine has
    nothing to do, and ``_finish(context)`` ends the operator. Both may raise `LumenrayError` before anything is computed.

    Attributes
    ----------
    job_name : str    Of the job and of its engine's process.
    what : str    Told where it is cancelled.
    is_shared : bool    Whether a cluster does the job, where the scene wants one.
    """

    job_name = what = ""
    is_shared = False
    _job = _running = None

    def execute(self, context):
        """Compute and return when done; for scripts."""
        try:
            self._prepare(context)
            if self._job is not None:
                session = self._open_session(context)
                try:
                    self._job.run(session)
                finally:
                    session.close()
        except LumenrayError as error:
            return self._refuse(error)
        return self._finish(context)

    def invoke(self, context, event):
        """Compute in the background while the window stays alive."""
        if bpy.app.background:
            return self.execute(context)
        try:
            self._prepare(context)
            if self._job is None:
                return self._finish(context)
            self._running = self._begin(self._open_session(context))
        except LumenrayError as error:
            return self._refuse(error)
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
        self._end(context)
        error = self._running.error
        if isinstance(error, Cancelled):
            self.report({"WARNING"}, f"{self.what} cancelled")
            return {"CANCELLED"}
        return self._finish(context) if error is None else self._refuse(error)

    def cancel(self, context):
        """Blender closes or loads a file."""
        self._end(context)

    def _open_session(self, context):
        return engine_process.open_session(self.job_name, context.scene if self.is_shared else None)

    def _begin(self, session) -> background_job.BackgroundJob:
        """Begin the job in an empty session, which is closed at the end."""
        return background_job.start(self._job, session, self.job_name)

    def _end(self, context) -> None:
        """Take it away, cancelled if it still works."""
        self._running.end(context)

    def _refuse(self, error):
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}
