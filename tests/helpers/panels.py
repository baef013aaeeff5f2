"""Draws panels without a window: onto a layout that checks what is put on it."""

import time
import types
from contextlib import contextmanager
from functools import partial

import bpy

from lumenray import operators, ui
from lumenray.blender_addon import registry

ICONS = set(bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items.keys())


class Layout:
    """Takes the calls of a panel and refuses what Blender could not draw."""

    def __init__(self, seen=None):
        self.seen = [] if seen is None else seen

    def _part(self, **_):
        return Layout(self.seen)

    row = column = box = split = _part

    def panel(self, idname, default_closed=False):
        assert idname.isidentifier()
        return self._part(), self._part()

    def separator(self, factor=1.0):
        pass

    def prop(self, data, name, text=None, icon="NONE", **options):
        assert name in data.bl_rna.properties, f"{type(data).__name__} has no {name}"
        assert icon in ICONS
        kind = data.bl_rna.properties[name].type
        assert not options.get("expand") or kind == "ENUM"
        self.seen.append(name)

    def prop_enum(self, data, name, value, text=None):
        assert name in data.bl_rna.properties
        self.seen.append(f"{name}={value}")

    def label(self, text="", icon="NONE"):
        assert isinstance(text, str)
        assert icon in ICONS
        self.seen.append(text)

    def operator(self, idname, text=None, icon="NONE"):
        assert idname in {kind.bl_idname for kind in operators.CLASSES}
        assert icon in ICONS
        self.seen.append(idname)
        return types.SimpleNamespace()

    def template_preview(self, block):
        assert isinstance(block, bpy.types.Material | bpy.types.World | bpy.types.Light)
        self.seen.append("preview")

    def template_icon(self, icon_value, scale=1.0):
        assert icon_value > 0
        assert scale > 0.0
        self.seen.append("icon")

    def menu(self, name, text=None, icon="NONE"):
        assert hasattr(bpy.types, name)
        assert icon in ICONS
        self.seen.append(name)

    def template_list(self, kind, _, data, name, active, index, rows=5):
        assert hasattr(bpy.types, kind)
        assert name in data.bl_rna.properties
        assert index in active.bl_rna.properties
        self.seen.append(kind)

    def template_node_view(self, tree, node, socket):
        assert socket.node == node
        assert node.name in tree.nodes
        self.seen.append("nodes")

    def progress(self, factor, text):
        assert 0.0 <= factor <= 1.0
        self.seen.append(text)


class Drawn:
    """Stands for an instance of a panel or list, which only Blender can make."""

    bitflag_filter_item = 1 << 30
    filter_name = ""

    def __init__(self, kind, layout):
        self._kind, self.layout = kind, layout

    def __getattr__(self, name):
        found = getattr(self._kind, name)
        return partial(found, self) if isinstance(found, types.FunctionType) else found


@contextmanager
def interface():
    """Have all panels and operators registered."""
    registry.register((*operators.CLASSES, *ui.CLASSES))
    ui.attach()
    yield
    ui.detach()


def context(**attributes):
    """Return what panels read of Blender's context."""
    base = {
        "engine": "LUMENRAY",
        "light": None,
        "material": None,
        "world": None,
        "object": None,
        "selected_objects": [],
        "scene": bpy.context.scene,
        "view_layer": bpy.context.view_layer,
        "window_manager": bpy.context.window_manager,
        "preferences": bpy.context.preferences,
        "region": types.SimpleNamespace(width=300),
    }
    return types.SimpleNamespace(**(base | attributes))


def draw(name, where):
    """Draw a panel if its poll allows it and return what was put on the layout, None if not."""
    kind = getattr(bpy.types, name)
    if hasattr(kind, "poll") and not kind.poll(where):
        return None
    layout = Layout()
    stub = Drawn(kind, layout)
    if hasattr(kind, "draw_header"):
        kind.draw_header(stub, where)
    kind.draw(stub, where)
    return layout.seen


def finish_pictures(pictures):
    """Do what Blender's timer does until pictures are drawn."""
    end = time.monotonic() + 120.0
    while pictures.timer() is not None:
        assert time.monotonic() < end
        time.sleep(0.01)


def new_light(kind):
    """Return the context of a new light that is active."""
    light = bpy.data.lights.new("Lamp", kind)
    source = bpy.data.objects.new("Lamp", light)
    bpy.context.scene.collection.objects.link(source)
    return context(light=light, object=source)


def labels_of(name, where):
    """Draw a panel and return the texts that its settings are given, by name."""
    return {setting: text for _, setting, text in settings_drawn(name, where)}


def settings_drawn(name, where):
    """Draw a panel and return its settings: owner, name and the text that it is given."""
    found = []

    class Labelled(Layout):
        def _part(self, **_):
            return self

        row = column = box = split = _part

        def prop(self, data, name, text=None, **options):
            super().prop(data, name, text, **options)
            found.append((data, name, text))

    kind = getattr(bpy.types, name)
    assert not hasattr(kind, "poll") or kind.poll(where)
    kind.draw(Drawn(kind, Labelled()), where)
    return found
