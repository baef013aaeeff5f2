"""Frames of a render, of which something is noted in place of a picture."""

import bpy


class _Recorder(bpy.types.RenderEngine):
    """Render engine that only notes something of each frame."""

    bl_idname = "LUMENRAY_TEST_FRAMES"
    bl_label = "Recorder of frames"
    note, notes = None, ()

    def render(self, depsgraph):
        self.notes.append(type(self).note(depsgraph))


def note_frames(note, frames, folder) -> list:
    """Render frames of the scene and return what ``note(depsgraph)`` says of each; ``frames``: first, last, step."""
    scene = bpy.context.scene
    scene.camera = bpy.data.objects.new("Eye", bpy.data.cameras.new("Eye"))
    scene.collection.objects.link(scene.camera)
    scene.frame_start, scene.frame_end, scene.frame_step = frames
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.render.filepath = str(folder / "frame")
    _Recorder.note, _Recorder.notes = staticmethod(note), []
    bpy.utils.register_class(_Recorder)
    try:
        scene.render.engine = _Recorder.bl_idname
        bpy.ops.render.render(animation=True)
    finally:
        scene.render.engine = "LUMENRAY"
        bpy.utils.unregister_class(_Recorder)
    return _Recorder.notes
