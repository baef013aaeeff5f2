"""Open the office: the scene that ships, as a new file."""

import bpy

from ..libraries.scenes import scene_path


class LUMENRAY_OT_open_office(bpy.types.Operator):
    """Open the office that comes with Lumenray as a new file; Blender asks first what is to become of your changes"""

    bl_idname = "lumenray.open_office"
    bl_label = "Open the Office"
    # Not REGISTER: there is nothing of it in the file that it opens.
    bl_options = set()

    def invoke(self, context, event):
        self._open("INVOKE_DEFAULT")
        return {"FINISHED"}

    def execute(self, context):
        return self._open("EXEC_DEFAULT")

    def _open(self, mode: str) -> set[str]:
        """Open it as Blender opens a template: the file that ships is never the one that is saved."""
        return bpy.ops.wm.read_homefile(mode, filepath=str(scene_path("office")), load_ui=False)


CLASSES = (LUMENRAY_OT_open_office,)
