"""Tables of bakes: they last, go out of date by what concerns the light, and by that alone."""

import bpy
import numpy as np
import pytest
from blender_bakes import add_lamp, bake_all, baked
from blender_objects import add_quad
from conversion import scene_hash
from panels import context, draw, interface

from lumenray.blender_addon.bake import look as baked_look
from lumenray.blender_addon.bake import results as baked_results
from lumenray.blender_addon.sync.scene import convert_scene

pytestmark = pytest.mark.usefixtures("extension")


def test_tables_are_there_after_saving_and_opening(fake_engine, tmp_path):
    add_quad("Floor")
    add_quad("Desk", 2.0)
    bake_all(tmp_path / "lux")
    before = [(row.name, row.mean, row.minimum_low, row.maximum_high) for row in baked().rows]
    assert len(before) == 2
    path = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(path))
    after = [(row.name, row.mean, row.minimum_low, row.maximum_high) for row in baked().rows]
    assert after == before
    assert baked().changed == ""
    assert baked().folder == str(tmp_path / "lux")
    with interface():
        assert "Floor" in [row.name for row in bpy.context.scene.lumenray.baked.rows]
        assert draw("LUMENRAY_PT_results", context()) is not None
        assert "2 %" in draw("LUMENRAY_PT_results_whole", context())
    # Edits of the opened file are noticed too.
    bpy.data.objects["Desk"].location.x = 3.0
    assert baked().changed == "Desk"
    bpy.data.objects["Floor"].visible_shadow = False
    assert baked().changed == "Desk, Floor"


def swap_slot():
    bpy.data.objects["Floor"].material_slots[0].material = bpy.data.materials["Varnish"]


def own_slot():
    """Give the object a material of its own, which its mesh does not have."""
    slot = bpy.data.objects["Floor"].material_slots[0]
    slot.link = "OBJECT"
    slot.material = bpy.data.materials["Varnish"]


def set_shelf(name, value=True):
    shelf = bpy.context.view_layer.layer_collection.children["Shelf"]
    return setattr(shelf, name, value)


def set_ray(name, thing="Floor", value=False):
    return lambda: setattr(bpy.data.objects[thing], f"visible_{name}", value)


RAYS = ("camera", "diffuse", "glossy", "transmission", "shadow")

EDITS = {
    "move": (lambda: setattr(bpy.data.objects["Floor"].location, "x", 0.5), "Floor"),
    "mesh": (lambda: bpy.data.meshes["Floor"].transform(np.eye(4) * 2.0), "Floor"),
    "light": (lambda: setattr(bpy.data.lights["Lamp"], "energy", 77.0), "Lamp"),
    "physical": (lambda: setattr(bpy.data.lights["Lamp"].lumenray, "use_physical", True), "Lamp"),
    "efficacy": (lambda: setattr(bpy.context.scene.lumenray, "efficacy", 100.0), "Scene"),
    "unit": (lambda: setattr(bpy.context.scene.unit_settings, "scale_length", 0.5), "Scene"),
    "remove": (lambda: bpy.data.objects.remove(bpy.data.objects["Lamp"]), "Collection"),
    "hide": (lambda: setattr(bpy.data.objects["Lamp"], "hide_render", True), "Collection"),
    "slot": (swap_slot, "Floor"),
    "own slot": (own_slot, "Floor"),
    "world": (lambda: setattr(bpy.context.scene, "world", bpy.data.worlds["Night"]), "Scene"),
    "no world": (lambda: setattr(bpy.context.scene, "world", None), "Scene"),
    "exclude": (lambda: set_shelf("exclude"), "Board"),
    "indirect": (lambda: set_shelf("indirect_only"), "Board"),
    "eye": (lambda: bpy.data.objects["Board"].hide_set(True), "Board"),
    "shown again": (lambda: bpy.data.objects["Box"].hide_set(False), "Box"),
    **{f"{ray} rays": (set_ray(ray), "Floor") for ray in RAYS},
    "rays of a light": (set_ray("diffuse", "Lamp"), "Lamp"),
    "rays of instances": (set_ray("shadow", "Maker"), "Maker"),
    "rays of what is instanced": (set_ray("shadow", "Chair"), "Chair"),
    "instanced": (lambda: setattr(bpy.data.objects["Chair"].location, "x", 0.5), "Chair"),
}


def furnish():
    """Add what can be edited: a collection, another world and material, an object that is hidden, and instances."""
    scene = bpy.context.scene
    floor = add_quad("Floor")
    floor.data.materials.append(bpy.data.materials.new("Paint"))
    bpy.data.materials.new("Varnish")
    scene.world = bpy.data.worlds.new("Day")
    bpy.data.worlds.new("Night")
    add_lamp("Lamp").data.lumenray.use_physical = False
    shelf, chairs = (bpy.data.collections.new(name) for name in ("Shelf", "Chairs"))
    scene.collection.children.link(shelf)
    for name, group in (("Board", shelf), ("Chair", chairs)):
        item = add_quad(name, 3.0)
        scene.collection.objects.unlink(item)
        group.objects.link(item)
    add_quad("Box", 6.0).hide_set(True)
    maker = bpy.data.objects.new("Maker", None)
    maker.instance_type, maker.instance_collection = "COLLECTION", chairs
    scene.collection.objects.link(maker)
    bpy.context.view_layer.update()


@pytest.mark.parametrize("name", list(EDITS))
def test_an_edit_of_what_is_lit_or_gives_light_is_said(fake_engine, tmp_path, name):
    furnish()
    bake_all(tmp_path)
    assert baked().changed == ""
    edit, said = EDITS[name]
    edit()
    bpy.context.scene.update_tag()
    assert said in baked().changed
    with interface():
        seen = draw("LUMENRAY_PT_results", context())
    assert any(text.startswith("Out of date") for text in seen)
    assert "lumenray.check_baked" in seen


def test_what_does_not_concern_the_light_leaves_tables_current(fake_engine, tmp_path):
    floor = add_quad("Floor")
    material = bpy.data.materials.new("Paint")
    if material.node_tree is None:
        material.use_nodes = True
    floor.data.materials.append(material)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    bpy.context.scene.collection.objects.link(camera)
    bake_all(tmp_path)
    settings = bpy.context.scene.lumenray
    camera.location.x = 5.0
    floor.select_set(True)
    floor.name = "Ground"
    settings.bake.density, settings.white_luminance = 99.0, 20.0
    floor.color, camera.visible_diffuse = (1.0, 0.0, 0.0, 1.0), False
    floor.vertex_groups.new(name="Group")
    bpy.context.scene.camera = camera
    assert baked().changed == ""
    # Nor does our own look.
    assert bpy.ops.lumenray.show_baked() == {"FINISHED"}
    settings.look.high = 750.0
    settings.look.kind = "FALSE"
    assert baked().changed == ""
    material.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 1.0
    assert baked().changed == "Paint"
    material.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 0.0
    bpy.ops.lumenray.check_baked()
    assert baked().changed == ""
    assert bpy.ops.lumenray.hide_baked() == {"FINISHED"}
    assert baked().changed == ""


def test_sliders_of_shown_layers_leave_tables_current(fake_engine, tmp_path):
    floor = add_quad("Floor")
    floor.data.materials.append(bpy.data.materials.new("Paint"))
    add_lamp("Lamp").data.lumenray.light_group = "Ceiling"
    settings = bpy.context.scene.lumenray
    settings.bake.layers = "GROUPS"
    bake_all(tmp_path)
    bpy.ops.lumenray.show_baked()
    settings.look.layers["Ceiling"].strength = 0.3
    assert baked().changed == ""


def test_what_was_set_back_is_current_again_after_a_check(fake_engine, tmp_path):
    floor = add_quad("Floor")
    bake_all(tmp_path)
    floor.location.x = 0.5
    assert baked().changed == "Floor"
    bpy.ops.lumenray.check_baked()
    assert baked().changed == "Floor"
    floor.location.x = 0.0
    assert baked().changed == "Floor"
    bpy.ops.lumenray.check_baked()
    assert baked().changed == ""


def test_undo_does_not_make_tables_current_that_are_not(fake_engine, tmp_path):
    floor = add_quad("Floor")
    bpy.context.preferences.edit.use_global_undo = True
    bake_all(tmp_path)
    bpy.ops.ed.undo_push(message="baked")
    floor.location.x = 0.5
    # Blender pushes its undo step before handlers hear of the edit.
    bpy.ops.ed.undo_push(message="moved")
    assert baked().changed == "Floor"
    bpy.context.scene.frame_end = 77
    bpy.ops.ed.undo_push(message="something else")
    bpy.ops.ed.undo()
    assert bpy.data.objects["Floor"].location.x == 0.5
    assert baked().changed == "Floor"


@pytest.mark.parametrize("name", ["move", "shadow rays", "eye"])
def test_what_is_edited_while_a_bake_runs_makes_its_tables_out_of_date(
    fake_engine, tmp_path, monkeypatch, name
):
    furnish()
    edit, said = EDITS[name]
    real = fake_engine.bake_objects

    def bake_objects(*arguments):
        edit()
        bpy.context.view_layer.update()
        return real(*arguments)

    monkeypatch.setattr(fake_engine, "bake_objects", bake_objects)
    bake_all(tmp_path)
    assert baked().changed == said


def test_a_bake_leaves_the_scene_as_it_was_for_the_engine(fake_engine, tmp_path):
    """The UV map of the lux map must not become the one that pictures lie by."""
    floor = add_quad("Floor")
    before = scene_hash()
    bake_all(tmp_path)
    assert floor.data.uv_layers[0].name == "Lumenray"
    assert scene_hash() == before
    bpy.ops.lumenray.show_baked()
    with baked_look.hidden(bpy.context.scene):
        assert scene_hash() == before
    bpy.ops.lumenray.hide_baked()
    # Somebody asks for it.
    material = bpy.data.materials.new("Paint")
    if material.node_tree is None:
        material.use_nodes = True
    material.node_tree.nodes.new("ShaderNodeUVMap").uv_map = "Lumenray"
    floor.data.materials.append(material)
    converted = convert_scene(bpy.context.evaluated_depsgraph_get())
    assert any("Lumenray" in getattr(item, "uv_maps", ()) for item in converted.delta.changed)


def test_watches_end_with_their_jobs():
    watch = baked_results.Watch()
    add_quad("Floor")
    assert "Floor" in watch.names
    del watch
    assert len(baked_results._tracker.watches) == 0
