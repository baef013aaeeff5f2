"""Write the photometric file of the luminaire that a goniometer has measured."""

from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper

from ..engine.errors import LumenrayError
from ..imports import loaded_when_used

with loaded_when_used():
    from ..blender_addon.sensors import goniometers
    from ..blender_addon.sensors import readings as sensor_readings


class LUMENRAY_OT_write_photometric_file(bpy.types.Operator, ExportHelper):
    """Write what the active goniometer has measured as a photometric file, EULUMDAT (.ldt) or LM-63 (.ies)"""

    bl_idname = "lumenray.write_photometric_file"
    bl_label = "Write Photometric File"

    filename_ext = ".ldt"
    # Whoever types .ies gets that.
    check_extension = None
    filter_glob: StringProperty(default="*.ldt;*.ies", options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        thing = context.object
        readings = (
            sensor_readings.readings_of(thing)
            if thing is not None and thing.type == "EMPTY"
            else None
        )
        if readings is not None and readings.is_distribution:
            return True
        cls.poll_message_set("Measure the goniometer first")
        return False

    def invoke(self, context, event):
        """Ask where to write it, by the name of the goniometer."""
        self.filepath = str(Path(bpy.data.filepath).parent / f"{context.object.name}.ldt")
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        empty, path = context.object, Path(bpy.path.abspath(self.filepath))
        try:
            remarks = goniometers.write_intensities(
                sensor_readings.readings_of(empty), empty.name, path
            )
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for remark in remarks:
            self.report({"WARNING"}, remark)
        self.report({"INFO"}, f"'{path.name}' written")
        return {"FINISHED"}


CLASSES = (LUMENRAY_OT_write_photometric_file,)
"""For registration."""
