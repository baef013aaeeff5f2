"""Find the workers of the user's cluster."""

import bpy

from ..blender_addon import feedback
from ..blender_addon.foundation import cluster_place, engine_process
from .background_operator import BackgroundOperator

NAME = "cluster"
"""Of the session that asks."""


class _Question:
    """Asks who computes there, as a job."""

    def __init__(self):
        self.workers: tuple = ()

    def run(self, session, progress=None) -> None:
        """Ask. Raises `LumenrayError` where nobody answers."""
        self.workers = session.list_workers()

    def cancel(self) -> None:
        """Nothing can be cut short: the answer comes within seconds, or the word that none will."""


class LUMENRAY_OT_find_workers(BackgroundOperator, bpy.types.Operator):
    """Ask the scheduler of your cluster which workers are there"""

    bl_idname = "lumenray.find_workers"
    bl_label = "Find Workers"
    # Not REGISTER: Blender would repeat it while the window waits.
    bl_options = set()
    job_name, what = NAME, "Finding workers"

    def _prepare(self, context) -> None:
        self._place = cluster_place.named_place()
        self._job = _Question()

    def _open_session(self, context):
        session = engine_process.open_session(NAME)
        session.join(self._place)
        return session

    def _finish(self, context):
        workers = self._job.workers
        feedback.show_workers(context.window_manager, self._place[0], workers)
        if workers:
            count = "1 worker" if len(workers) == 1 else f"{len(workers)} workers"
            self.report({"INFO"}, f"{count} at {self._place[0]}")
        else:
            self.report({"WARNING"}, f"No worker is at {self._place[0]}; start some")
        return {"FINISHED"}

    def _refuse(self, error):
        bpy.context.window_manager.lumenray.property_unset("cluster")
        return super()._refuse(error)


CLASSES = (LUMENRAY_OT_find_workers,)
"""For registration."""
