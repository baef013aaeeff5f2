"""What the header of Blender's image editor says of a render: samples, error and time, which stay there when it is done."""

import bpy

from .compatibility import ENGINE


def draw_error(self, context):
    """Say how well the last picture is known, where the render's result is shown."""
    image = getattr(context.space_data, "image", None)
    text = context.window_manager.lumenray.render
    if text and image is not None and image.type == "RENDER_RESULT" and context.engine == ENGINE:
        self.layout.label(text=text)


def attach():
    """Add to the header, once."""
    detach()
    bpy.types.IMAGE_HT_header.append(draw_error)


def detach():
    """Take it off again."""
    bpy.types.IMAGE_HT_header.remove(draw_error)
