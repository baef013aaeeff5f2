"""Edit materials, worlds and lights beside their previews in a real window: ``--python previews.py -- previews FOLDER``.

What the previews show, how long they take after an edit, that Blender's main thread goes on meanwhile, and that the
rendered view beside them learns nothing of them. Pictures of the screen and ``previews.json`` are written to FOLDER. Blender
quits at the end.
"""

import sys
import time
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

import stage
import window
from window import region_of, take_picture, view

PART, FOLDER = sys.argv[sys.argv.index("--") + 1 :][:2]
FOLDER = Path(FOLDER)

PANELS = ("MATERIAL_PT_preview", "LUMENRAY_PT_world_preview", "DATA_PT_preview")

STRENGTH = 0.5
"""What glows and the world are given beside their colours, so that these buttons are not taken for previews."""

FEWEST = 400
"""Pixels of a colour by which a preview is known."""

LONGEST_GAP = 5.0
"""Longest time for which the main thread may be held up, drawing without a graphics card included. [s]"""

COLD = 180.0
"""How long a preview may take whose kernels have to be compiled. [s]"""

record = window.Record(FOLDER / f"{PART}.json")
ticks = []


def properties():
    """Return the properties editor."""
    return next(area for area in window.window().screen.areas if area.type == "PROPERTIES")


def set_up():
    """Build the scene, show it rendered, and open the preview beside it."""
    leave_previews_alone()
    window.prepare_window()
    stage.build()
    # What the view looks like is not what is tested here.
    bpy.context.scene.lumenray.viewport.samples, bpy.context.scene.lumenray.viewport.method = (
        2,
        "PATHS",
    )
    bpy.context.scene.view_settings.view_transform = "Standard"
    yield 0.5
    window.look_through_camera()
    window.space().shading.type = "RENDERED"
    yield from window.settle()
    bpy.app.timers.register(tick, persistent=True)


def leave_previews_alone():
    """Take other panels of these tabs away, so that previews are in view, and open them."""
    for kind in list(bpy.types.Panel.__subclasses__()):
        tab = getattr(kind, "bl_context", "")
        if tab not in {"material", "world", "data"} or "context" in kind.__name__:
            continue
        if kind.is_registered and not getattr(kind, "bl_parent_id", ""):
            bpy.utils.unregister_class(kind)
    for name in PANELS:
        kind = next(each for each in bpy.types.Panel.__subclasses__() if each.__name__ == name)
        kind.bl_options = set()
        bpy.utils.register_class(kind)


def tick():
    """Note that the main thread is free."""
    ticks.append(time.monotonic())
    return window.TICK


def show(context):
    """Show a tab of the properties editor; which there are is known after drawing."""
    properties().tag_redraw()
    yield 1.0
    properties().spaces.active.context = context
    properties().tag_redraw()
    yield 1.0


def count(colour):
    """Count the pixels of the properties editor that have about a linear colour."""
    colour = STRENGTH * np.asarray(colour)
    encoded = 255.0 * np.where(
        colour <= 0.0031308, 12.92 * colour, 1.055 * colour ** (1 / 2.4) - 0.055
    )
    shown = take_picture(FOLDER / "screen.png", region_of(properties()))
    return int((np.abs(shown - encoded).max(axis=-1) < 4.0).sum())


def wait_for_colour(colour, what, seconds=COLD):
    """Wait until a preview shows a colour, and note the time."""
    begin = time.monotonic()
    while count(colour) < FEWEST:
        if time.monotonic() - begin > seconds:
            record.check(False, f"{what}: not shown within {seconds:.0f} s")
            return
        yield 0.1
    taken = time.monotonic() - begin
    gaps = np.diff([each for each in ticks if each > begin - 0.2] or [0.0, 0.0])
    record.measure(f"{what}: seconds until it was shown", round(taken, 2))
    record.check(
        max(gaps, default=0.0) < LONGEST_GAP,
        f"{what}: the main thread was held up for {max(gaps, default=0.0):.2f} s at most",
    )


def material():
    """Edit a glowing material."""
    block = bpy.data.objects["Block"]
    bpy.context.view_layer.objects.active = block
    block.select_set(True)
    made = bpy.data.materials.new("Previewed")
    made.use_nodes = True
    node = made.node_tree.nodes.new("ShaderNodeEmission")
    node.inputs["Strength"].default_value = STRENGTH
    target = made.node_tree.nodes["Material Output"].inputs["Surface"]
    made.node_tree.links.new(node.outputs[0], target)
    block.data.materials[0] = made
    yield from window.settle()
    for name, colour in (
        ("cold", (0.5, 0.2, 0.1)),
        ("warm", (0.1, 0.4, 0.2)),
        ("again", (0.1, 0.2, 0.6)),
    ):
        node.inputs["Color"].default_value = (*colour, 1.0)
        yield from show("MATERIAL")
        yield from wait_for_colour(colour, f"material, {name}")
        take_picture(FOLDER / f"material_{name}.png")
    yield from window.settle()
    sent = view()._feed.session.revision
    tree = made.node_tree
    tree.links.new(tree.nodes["Principled BSDF"].outputs[0], target)
    yield from window.settle()
    yield 8.0
    take_picture(FOLDER / "material_principled.png")
    record.check(
        view()._feed.session.revision == sent + 1,
        f"the view was told of {view()._feed.session.revision - sent} changes, which was one edit",
    )


def world():
    """Edit the world."""
    background = bpy.context.scene.world.node_tree.nodes["Background"]
    bpy.context.scene.world.lumenray.unit = "BLENDER"
    background.inputs["Strength"].default_value = STRENGTH
    yield from show("WORLD")
    for colour in ((0.1, 0.3, 0.5), (0.4, 0.3, 0.1)):
        background.inputs["Color"].default_value = (*colour, 1.0)
        yield from wait_for_colour(colour, "world")
    take_picture(FOLDER / "world.png")


def light():
    """Show a light that states its lumens."""
    bpy.context.view_layer.objects.active = bpy.data.objects["Lamp"]
    yield from show("DATA")
    yield 10.0
    take_picture(FOLDER / "light.png")


def many_edits():
    """Edit faster than previews are made; the last is the one that is shown."""
    bpy.context.view_layer.objects.active = bpy.data.objects["Block"]
    made = bpy.data.materials["Previewed"]
    tree = made.node_tree
    node = next(each for each in tree.nodes if each.type == "EMISSION")
    tree.links.new(node.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    yield from show("MATERIAL")
    for step in range(40):
        node.inputs["Color"].default_value = (0.01 * step, 0.5, 0.3, 1.0)
        yield 0.05
    colour = (0.6, 0.1, 0.5)
    node.inputs["Color"].default_value = (*colour, 1.0)
    yield from wait_for_colour(colour, "the last of many edits")


bpy.context.preferences.view.show_splash = False
window.start((set_up, material, world, light, many_edits), record, bpy.ops.wm.quit_blender)
