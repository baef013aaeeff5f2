"""Try devices: jobs with known answers on everything that the engine could compute on."""

import json

import bpy

from ..blender_addon.foundation import running_trials
from ..imports import loaded_when_used

with loaded_when_used():
    from ..blender_addon.foundation import device_trials

TEXT = "Lumenray Devices"
"""Name of the text that holds the answers."""


class LUMENRAY_OT_try_devices(bpy.types.Operator):
    """Compute sensors, a lux map and a picture with known answers on every device, and write what came out into a text"""

    bl_idname = "lumenray.try_devices"
    bl_label = "Try Devices"
    # Not REGISTER: Blender would repeat it while the window waits.
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        if running_trials.are_running():
            cls.poll_message_set("Devices are being tried already; Esc stops that")
            return False
        return True

    def execute(self, context):
        """Try them and return when done; for scripts."""
        return self._tell(list(device_trials.run_trials()))

    def invoke(self, context, event):
        """Try them in the background while the window stays alive."""
        if bpy.app.background:
            return self.execute(context)
        self._running = running_trials.start()
        self._running.begin_signals(context)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Hear Esc, wait for the answers."""
        if event.type == "ESC" and event.value == "PRESS":
            self._running.ask_to_end()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if self._running.is_alive:
            self._running.show(context)
            return {"PASS_THROUGH"}
        self._running.end(context)
        return self._tell(self._running.trials)

    def cancel(self, context):
        """Blender closes the window or loads a file."""
        self._running.end(context)

    def _tell(self, trials):
        if not trials:
            return {"CANCELLED"}
        text = bpy.data.texts.get(TEXT) or bpy.data.texts.new(TEXT)
        lines = [line for trial in trials for line in device_trials.to_lines(trial)]
        record = json.dumps(device_trials.to_record(trials), indent=1)
        text.from_string("\n".join([*lines, "", record, ""]))
        here = [trial for trial in trials if not trial.is_absent]
        bad = [trial for trial in here if not trial.passed]
        for trial in bad:
            self.report(
                {"WARNING"}, f"{trial.found}, {trial.kind}: {trial.fault or 'a wrong answer'}"
            )
        if not here:
            self.report({"WARNING"}, f"No device could be tried; see the text '{TEXT}'")
        elif not bad:
            self.report({"INFO"}, f"All answers are right; see the text '{TEXT}'")
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_try_devices,)
"""For registration."""
