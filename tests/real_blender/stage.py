"""A small scene for tests of the rendered view: floor, back wall, red block, luminous panel, lamp, sun and sky."""

import bpy
from checkout import tool

WHITE = 250.0
"""Luminance that becomes 1 in the picture. [cd/m2]"""

PANEL = 1500.0
"""Luminance of the panel, far above all that the lamp lights. [cd/m2]"""

SAMPLES = 24
"""Paths per pixel, of the view and of F12."""

SUN = 500.0
"""Illuminance by the sun, which stands overhead but is off at first. [lx]"""


def clear():
    """Take everything out of the scene."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    for collection in list(bpy.data.collections):
        bpy.data.collections.remove(collection)


def build():
    """Build the scene in the open file."""
    clear()
    staging, shapes = tool("libraries.scenes.staging"), tool("libraries.scenes.shapes")
    assembly = tool("libraries.scenes.assembly").Assembly
    collection = staging.new_collection("Stage")
    grey = _matt(staging, "Grey", (0.5, 0.5, 0.5))
    floor = shapes.quad((-3.0, -3.0, 0.0), (6.0, 0.0, 0.0), (0.0, 5.0, 0.0))
    assembly().add(grey, floor).build("Floor", collection)
    wall = shapes.quad((-3.0, 2.0, 0.0), (6.0, 0.0, 0.0), (0.0, 0.0, 3.0))
    assembly().add(grey, wall).build("Wall", collection)
    red = _matt(staging, "Red", (0.7, 0.08, 0.04))
    block = shapes.box((0.7, 0.7, 0.7))
    assembly().add(red, block).build("Block", collection, (-1.2, 0.0, 0.36))
    glow = staging.new_material(
        "Glow", "ShaderNodeEmission", {"Color": (1.0, 1.0, 1.0), "Strength": 1.0}
    )
    staging.override(
        glow,
        "EMITTER",
        luminance=PANEL,
        two_sided=False,
        spectrum="ILLUMINANT",
        illuminant="E",
    )
    panel = shapes.quad((-0.3, 0.0, -0.2), (0.6, 0.0, 0.0), (0.0, 0.0, 0.4))
    assembly().add(glow, panel).build("Panel", collection, (1.6, 1.6, 1.7))
    lamp = staging.new_light(
        "Lamp", "POINT", collection, (0.3, -1.2, 2.6), "LUMINOUS_FLUX", 3000.0, "ILLUMINANT"
    )
    lamp.data.shadow_soft_size = 0.1
    lamp.visible_camera = False
    sun = staging.new_light("Sun", "SUN", collection, (0.0, 0.0, 4.0), "ILLUMINANCE", 0.0)
    sun.data.angle = 0.001
    staging.set_sky((0.8, 0.9, 1.0), 30.0)
    staging.new_camera((0.0, -5.2, 1.9), (78.0, 0.0, 0.0), lens=32.0)
    staging.set_render(640, 400, WHITE, samples=SAMPLES)
    scene = bpy.context.scene
    scene.render.engine = "LUMENRAY"
    # Blender's dither lifts a file's 8-bit values by half a step on the average; the window has none.
    scene.render.dither_intensity = 0.0
    scene.lumenray.viewport.samples = SAMPLES


def leave_sun_only():
    """Let the floor, an even plane now, be lit by the sun alone, so that its illuminance is known."""
    bpy.data.lights["Lamp"].lumenray.value = 0.0
    bpy.data.lights["Sun"].lumenray.value = SUN
    bpy.data.materials["Glow"].lumenray.luminance = 0.0
    bpy.context.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    for name in ("Block", "Wall"):
        bpy.data.objects[name].hide_viewport = True


def _matt(staging, name, colour):
    inputs = {"Base Color": colour, "Roughness": 1.0, "Specular IOR Level": 0.0}
    material = staging.new_material(name, "ShaderNodeBsdfPrincipled", inputs)
    return staging.override(
        material, "DIFFUSE", reflectance_source="COLOR", reflectance_color=colour
    )
