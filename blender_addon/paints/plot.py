"""What a paint scatters as an image of Blender."""

import bpy

from ...engine.paint.surface import PaintedSurface

SIZE = (960, 720)
"""Width and height. [pixel]"""


def show_cuts(context, name: str, painted: PaintedSurface):
    """Draw the scattering in the plane of incidence as an image, and show it where an image editor is open."""
    from ...engine.analysis.scattering_picture import polar_cuts

    pixels = polar_cuts(painted.surface.front_reflection, size=SIZE)
    title = f"{name} cuts"
    image = bpy.data.images.get(title)
    if image is None or tuple(image.size) != SIZE:
        image = bpy.data.images.new(title, *SIZE)
    image.pixels.foreach_set(pixels.reshape(-1))
    image.update()
    image.pack()
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image
                return image
    return image
