"""Sensors of the scene: measured without blocking the window, and forgotten."""

import bpy

from ..blender_addon import feedback
from ..blender_addon.foundation.redraw import areas
from ..blender_addon.sensors import results, running
from ..blender_addon.sensors.settings import find_sensors, is_sensor
from ..imports import loaded_when_used
from .background_operator import BackgroundOperator

with loaded_when_used():
    from ..blender_addon.sensors import asked, pictures
    from ..blender_addon.sensors import readings as sensor_readings


class LUMENRAY_OT_measure_sensors(BackgroundOperator, bpy.types.Operator):
    """Measure all sensors that stand in the scene; their lux are kept with them in the file"""

    bl_idname = "lumenray.measure_sensors"
    bl_label = "Measure"
    # Not REGISTER: whatever is touched in the redo panel would measure again.
    bl_options = {"UNDO"}
    job_name, what = running.NAME, "Measuring"
    is_shared = True
    _measuring = None

    @classmethod
    def poll(cls, context):
        if running.is_running():
            cls.poll_message_set("Sensors are being measured already; Esc cancels it")
            return False
        if not any(is_sensor(thing) for thing in context.scene.objects):
            cls.poll_message_set("No sensors stand in the scene; add some with Add > Sensors")
            return False
        return True

    def _prepare(self, context) -> None:
        self._job, self._report = asked.prepare(context.evaluated_depsgraph_get())

    def _begin(self, session):
        self._measuring = running.Measuring(self._job, session)
        return self._measuring.background

    def _end(self, context) -> None:
        self._measuring.end(context)

    def _finish(self, context):
        measuring = self._measuring
        empties = results.store(self._job) if measuring is None else measuring.store()
        feedback.show_report(context.window_manager, self._report)
        count = sum(len(each.positions) for each in self._job.answer.values())
        text = (
            f"{count} sensors measured, of {len(empties)} object{'' if len(empties) == 1 else 's'}"
        )
        if self._job.shortfall:
            text = f"{text}: {self._job.shortfall}"
        self.report({"WARNING" if self._job.shortfall else "INFO"}, text)
        return {"FINISHED"}


class LUMENRAY_OT_show_sensor_plans(bpy.types.Operator):
    """Draw plans of all grids of sensors in false colours with isolux lines, as images of the file"""

    bl_idname = "lumenray.show_sensor_plans"
    bl_label = "Draw Plans"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        held = (sensor_readings.readings_of(empty) for empty in find_sensors(context.scene))
        if any(readings is not None and pictures.has_plan(readings) for readings in held):
            return True
        cls.poll_message_set("Measure a grid of sensors first")
        return False

    def execute(self, context):
        images = pictures.show_plans(context.scene)
        for area in areas("IMAGE_EDITOR"):
            area.spaces.active.image = images[0]
        names = ", ".join(f"'{image.name}'" for image in images)
        self.report({"INFO"}, f"The plans are in the images {names}")
        return {"FINISHED"}


class LUMENRAY_OT_forget_readings(bpy.types.Operator):
    """Take the readings off all sensors of the scene; the sensors stay where they stand"""

    bl_idname = "lumenray.forget_readings"
    bl_label = "Forget Readings"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        for empty in find_sensors(context.scene):
            for name in ("kept", "serial", "changed"):
                empty.lumenray.sensor.property_unset(name)
        return {"FINISHED"}


CLASSES = (
    LUMENRAY_OT_measure_sensors,
    LUMENRAY_OT_show_sensor_plans,
    LUMENRAY_OT_forget_readings,
)
"""For registration."""
