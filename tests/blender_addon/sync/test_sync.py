"""What each edit sends to the engine, and that the scene kept current equals a fresh export."""

import os

import bpy
import numpy as np
import pytest
from kept_scenes import KeptScene, differences
from random_edits import RandomEdits, remember

from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.blender_addon.sync.step import array_bytes, split
from lumenray.engine.scene.light import SpotLight
from lumenray.engine.scene.material import Material
from lumenray.engine.scene.mesh import Geometry, Placement
from lumenray.engine.scene.scene import Scene

SEEDS = range(20 if os.environ.get("LUMENRAY_ALL_SEEDS") else 2)
"""Seeds of the random edits; set LUMENRAY_ALL_SEEDS for all twenty."""


class Stage(KeptScene):
    """Three triangles (two share a mesh), a lamp, a world, and a scene of the engine kept current."""

    def __init__(self, final=False):
        super().__init__(final)
        self.material = bpy.data.materials.new("Paint")
        self.mesh = bpy.data.meshes.new("Shared")
        self.mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
        self.mesh.materials.append(self.material)
        self.first, self.second = self.add(self.mesh, "First"), self.add(self.mesh, "Second")
        self.third = self.add(self.mesh.copy(), "Third")
        self.light = self.add(bpy.data.lights.new("Lamp", "POINT"), "Lamp")
        self.light.data.energy = 10.0
        bpy.context.scene.world = bpy.data.worlds.new("Sky")
        if bpy.app.version < (5, 0, 0):
            self.material.use_nodes = bpy.context.scene.world.use_nodes = True
        remember("start")
        self.step()

    def add(self, data, name="Added"):
        made = bpy.data.objects.new(name, data)
        bpy.context.scene.collection.objects.link(made)
        return made


@pytest.fixture
def stage():
    return Stage()


def base_colour(material):
    return material.node_tree.nodes["Principled BSDF"].inputs[0]


def test_the_first_walk_sends_everything_and_shares_geometry(stage):
    fresh = SceneSync().walk(bpy.context.evaluated_depsgraph_get())
    kinds = [type(item) for item in fresh.delta.changed]
    assert kinds.count(Geometry) == 2
    assert kinds.count(Placement) == 3
    assert kinds.count(Material) == 1
    assert fresh.stats.sent["geometry"] == 2
    assert fresh.stats.changed == "everything"


def test_without_tags_there_is_no_walk(stage):
    made = stage.step()
    assert not made.delta
    assert made.stats.visited == 0


@pytest.mark.parametrize("edit", ["select", "rename", "outliner", "rename material", "value again"])
def test_edits_that_change_no_light_send_nothing(stage, edit):
    match edit:
        case "select":
            stage.first.select_set(True)
            bpy.context.view_layer.objects.active = stage.first
        case "rename":
            stage.first.name = stage.first.data.name = stage.light.name = "Other"
        case "rename material":
            stage.material.name = "Other"
        case "outliner":
            drawer = bpy.data.collections.new("Drawer")
            bpy.context.scene.collection.children.link(drawer)
            drawer.objects.link(stage.first)
            bpy.context.scene.collection.objects.unlink(stage.first)
        case "value again":
            stage.light.data.energy = 10.0
            stage.mesh.vertices[0].co = (0, 0, 0)
            stage.mesh.update()
    made = stage.step()
    assert not made.delta
    assert not made.stats.changed
    assert stage.differences() == []


def test_moving_sends_one_placement(stage):
    stage.first.location.x = 3
    assert stage.sent() == (["Placement"], 0)
    stage.first.scale.x = -1
    made = stage.step()
    assert made.stats.changed == "1 object moved"
    assert stage.differences() == []


def test_a_material_edit_sends_that_material(stage):
    base_colour(stage.material).default_value = (1, 0, 0, 1)
    made = stage.step()
    assert [item.name for item in made.delta.changed] == ["Paint"]
    assert made.stats.changed == "material 'Paint'"
    stage.material.lumenray.use_override = True
    assert stage.sent() == (["Material"], 0)


def test_a_group_inside_a_group_sends_the_materials_that_use_it(stage):
    inner, outer = (bpy.data.node_groups.new(name, "ShaderNodeTree") for name in ("In", "Out"))
    for group in (inner, outer):
        group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    colour, end = inner.nodes.new("ShaderNodeRGB"), inner.nodes.new("NodeGroupOutput")
    inner.links.new(colour.outputs[0], end.inputs[0])
    node, end = outer.nodes.new("ShaderNodeGroup"), outer.nodes.new("NodeGroupOutput")
    node.node_tree = inner
    outer.links.new(node.outputs[0], end.inputs[0])
    tree = stage.material.node_tree
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = outer
    tree.links.new(node.outputs[0], base_colour(stage.material))
    stage.step()
    colour.outputs[0].default_value = (0, 1, 0, 1)
    assert stage.sent() == (["Material"], 0)


def test_pixels_of_an_image_send_the_materials_that_use_it(stage):
    image = bpy.data.images.new("Picture", 2, 2)
    tree = stage.material.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    tree.links.new(node.outputs[0], base_colour(stage.material))
    stage.step()
    image.pixels.foreach_set(np.full(16, 0.25, np.float32))
    # Blender does not report pixels that a script writes.
    image.update_tag()
    assert stage.sent() == (["Material"], 0)


@pytest.mark.parametrize("edit", ["energy", "color", "type", "value", "move"])
def test_an_edit_of_a_light_sends_that_light(stage, edit):
    data = stage.light.data
    data.lumenray.use_physical = edit == "value"
    stage.step()
    match edit:
        case "energy":
            data.energy = 20.0
        case "color":
            data.color = (1, 0.5, 0.2)
        case "type":
            data.type = "SPOT"
        case "value":
            data.lumenray.value = 5.0
        case "move":
            stage.light.location.x = 1
    made = stage.step()
    assert [item.name for item in made.delta.changed] == ["Lamp"]
    assert made.stats.changed == "light 'Lamp'"
    assert isinstance(made.delta.changed[0], SpotLight) == (edit == "type")
    assert stage.differences() == []


def test_a_hidden_light_is_dark_and_comes_back(stage):
    stage.light.hide_set(True)
    (dark,) = stage.step().delta.changed
    assert dark.output.value == 0
    stage.light.hide_set(False)
    (bright,) = stage.step().delta.changed
    assert bright.id == dark.id
    assert bright.output.value > 0
    stage.light.data.energy = 0.0
    (dark,) = stage.step().delta.changed
    assert dark.output.value == 0
    key = bright.id
    bpy.data.objects.remove(stage.light)
    assert stage.step().delta.removed == (key,)


@pytest.mark.parametrize("way", ["hide_set", "hide_viewport", "collection"])
def test_a_hidden_object_goes_and_comes_back_without_its_geometry(stage, way):
    drawer = bpy.data.collections.new("Drawer")
    bpy.context.scene.collection.children.link(drawer)
    drawer.objects.link(stage.third)
    bpy.context.scene.collection.objects.unlink(stage.third)
    stage.step()

    def hide(is_hidden):
        match way:
            case "hide_set":
                stage.third.hide_set(is_hidden)
            case "hide_viewport":
                stage.third.hide_viewport = is_hidden
            case "collection":
                drawer.hide_viewport = is_hidden

    hide(True)
    assert stage.sent() == ([], 1)
    hide(False)
    assert stage.sent() == (["Placement"], 0)


def test_geometry_that_was_edited_while_hidden_is_sent_when_it_is_shown(stage):
    for hide in ("hide_viewport", "hide_render"):
        setattr(stage.third, hide, True)
        stage.step()
        stage.third.data.vertices[0].co.z += 1
        stage.third.data.update()
        stage.step()
        setattr(stage.third, hide, False)
        stage.step()
        assert stage.differences() == []


@pytest.mark.parametrize("final", [False, True])
def test_objects_hidden_in_renders_matter_to_final_renders_only(final):
    stage = Stage(final)
    stage.third.hide_render = True
    assert stage.sent() == ([], int(final))
    stage.third.hide_render = False
    assert stage.sent() == (["Placement"] * final, 0)


def test_objects_of_collections_disabled_in_renders_are_left_out_of_final_renders_only():
    def names(final):
        stage = Stage(final)
        scene = bpy.context.scene
        outer, inner = (bpy.data.collections.new(name) for name in ("Outer", "Inner"))
        scene.collection.children.link(outer)
        outer.children.link(inner)
        mesh = stage.mesh
        alone, shared, copied = (
            bpy.data.objects.new(n, mesh) for n in ("Alone", "Shared", "Copied")
        )
        for item in (alone, shared):
            inner.objects.link(item)
        scene.collection.objects.link(shared)
        library = bpy.data.collections.new("Library")
        library.objects.link(copied)
        empties = [bpy.data.objects.new(name, None) for name in ("Here", "Off")]
        for empty, collection in zip(empties, (scene.collection, inner), strict=True):
            empty.instance_type, empty.instance_collection = "COLLECTION", library
            collection.objects.link(empty)
        outer.hide_render = True
        stage.step()
        shown = (each.name.split()[0] for each in stage.scene.meshes.values())
        return sorted(each for each in shown if each in {"Alone", "Shared", "Copied"})

    assert names(True) == ["Copied", "Shared"]
    assert names(False) == ["Alone", "Copied", "Copied", "Shared"]


def test_editing_a_shared_mesh_sends_it_once(stage):
    stage.mesh.vertices[0].co.z = 1
    stage.mesh.update()
    assert stage.sent() == (["Geometry"], 0)


def test_a_modifier_takes_an_object_from_the_shared_mesh(stage):
    modifier = stage.first.modifiers.new("Thick", "SOLIDIFY")
    assert stage.sent() == (["Geometry", "Placement"], 0)
    modifier.thickness = 0.3
    assert stage.sent() == (["Geometry"], 0)
    stage.first.modifiers.clear()
    assert stage.sent() == (["Placement"], 1)


def test_a_mesh_without_faces_is_no_object_until_it_has_some(stage):
    stage.third.data.clear_geometry()
    assert stage.sent() == ([], 2)
    stage.third.data.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 1)], [], [(0, 1, 2)])
    stage.third.data.update()
    assert stage.sent() == (["Geometry", "Placement"], 0)


def test_slots_of_an_object_do_not_touch_the_shared_mesh(stage):
    stage.first.material_slots[0].link = "OBJECT"
    stage.first.material_slots[0].material = bpy.data.materials.new("Other")
    assert stage.sent() == (["Material", "Placement"], 0)


def test_adding_and_deleting_touch_nothing_else(stage):
    stage.add(stage.mesh)
    assert stage.sent() == (["Placement"], 0)
    mesh = stage.mesh.copy()
    made = stage.add(mesh)
    assert stage.sent() == (["Geometry", "Placement"], 0)
    bpy.data.objects.remove(made)
    bpy.data.meshes.remove(mesh)
    assert stage.sent() == ([], 2)


def test_world_edits_send_the_world(stage):
    world = bpy.context.scene.world
    node = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    node.inputs[0].default_value = (1, 1, 1, 1)
    assert stage.sent() == (["UniformWorld"], 0)
    world.lumenray.unit = "LUMINANCE"
    assert stage.sent() == (["UniformWorld"], 0)
    bpy.context.scene.world = None
    assert stage.sent() == ([], 1)
    bpy.context.scene.world = world
    assert stage.sent() == (["UniformWorld"], 0)
    assert stage.scene.world.id == f"world:{world.lumenray.uid}"


def test_units_move_things_but_send_no_geometry(stage):
    stage.light.location.x = 2
    stage.step()
    settings = bpy.context.scene.unit_settings
    settings.system, settings.scale_length = "METRIC", 0.01
    kinds, _ = stage.sent()
    assert sorted(kinds) == ["Placement"] * 3 + ["PointLight"]


def test_lumens_per_watt_change_what_shines(stage):
    bpy.context.scene.lumenray.efficacy = 683.0
    assert stage.sent() == (["PointLight", "UniformWorld"], 0)


def test_object_settings_send_the_placement(stage):
    stage.first.visible_camera = False
    assert stage.sent() == (["Placement"], 0)
    stage.first.pass_index = 7
    assert stage.sent() == (["Placement"], 0)


def test_moving_frames_move_animated_objects(stage):
    stage.first.keyframe_insert("location", frame=1)
    stage.first.location.x = 5
    stage.first.keyframe_insert("location", frame=20)
    stage.step()
    bpy.context.scene.frame_set(10)
    assert stage.sent() == (["Placement"], 0)


def test_instances_follow_their_object_and_their_parent(stage):
    group = bpy.data.collections.new("Group")
    group.objects.link(stage.third)
    bpy.context.scene.collection.objects.unlink(stage.third)
    empty = stage.add(None, "Empty")
    empty.instance_type, empty.instance_collection = "COLLECTION", group
    assert stage.sent() == (["Placement"], 1)
    empty.location.x = 1
    assert stage.sent() == (["Placement"], 0)
    stage.third.location.y = 1
    assert stage.sent() == (["Placement"], 0)
    stage.third.data.vertices[0].co.z = 1
    stage.third.data.update()
    assert stage.sent() == (["Geometry"], 0)


def test_undo_sends_only_what_differs(stage):
    remember("before")
    stage.first.location.x = 3
    bpy.context.view_layer.update()
    remember("moved")
    stage.step()
    bpy.ops.ed.undo()
    assert stage.sent() == (["Placement"], 0)


def test_opening_another_file_replaces_everything(stage, tmp_path):
    before = set(stage.scene.meshes)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    stage.step()
    assert before
    assert not (stage.scene.meshes or stage.scene.geometries or stage.scene.materials)
    assert not stage.scene.lights
    assert stage.scene.world is None


class Recorder(bpy.types.RenderEngine):
    """Render engine that only walks the scene that it is given."""

    bl_idname = "LUMENRAY_TEST_RECORDER"
    bl_label = "Recorder"
    sync = None
    steps: list = []

    def render(self, depsgraph):
        self.steps.append(self.sync.walk(depsgraph))


@pytest.fixture
def render(stage):
    """Return a function that renders a frame and returns what a sync for final renders sends."""
    bpy.utils.register_class(Recorder)
    scene = bpy.context.scene
    scene.camera = stage.add(bpy.data.cameras.new("Eye"), "Eye")
    scene.render.engine = Recorder.bl_idname
    scene.render.resolution_x = scene.render.resolution_y = 8
    Recorder.sync = SceneSync(final=True)

    def run():
        bpy.ops.render.render()
        made = Recorder.steps.pop()
        return sorted(type(item).__name__ for item in made.delta.changed), len(made.delta.removed)

    yield run
    Recorder.sync = None
    scene.render.engine = "LUMENRAY"
    bpy.utils.unregister_class(Recorder)


def test_final_renders_send_what_changed_since_the_last_one(stage, render):
    assert len(render()[0]) == 2 + 3 + 1 + 1 + 1
    assert render() == ([], 0)
    stage.first.location.x = 2
    assert render() == (["Placement"], 0)
    stage.first.hide_viewport = True
    assert render() == ([], 0)
    stage.third.hide_viewport = True
    stage.third.data.vertices[0].co.z = 1
    stage.third.data.update()
    assert render() == (["Geometry"], 0)


def test_a_render_tells_a_viewport_nothing(stage, render):
    stage.step()
    render()
    assert not stage.step().delta


def test_the_report_stays_complete(stage):
    stage.light.data.lumenray.use_physical = True
    stage.light.data.type = "SUN"
    first = stage.step().report.rows
    assert any("not defined for a sun" in row.message for row, _ in first)
    stage.first.location.x = 1
    assert stage.step().report.rows == first
    stage.light.data.lumenray.quantity = "ILLUMINANCE"
    assert not any("not defined" in row.message for row, _ in stage.step().report.rows)


def test_a_visibility_test_hides_what_it_refuses(stage):
    stage.sync.tag_scene()
    made = stage.step(visible=lambda instance: instance.object.name != "First")
    assert made.delta.removed == (f"object:{stage.first.lumenray.uid}",)


def test_a_split_delta_leads_to_the_same_scene(stage):
    delta = convert_scene(bpy.context.evaluated_depsgraph_get()).delta
    limit = 200
    parts, scene = list(split(delta, limit)), Scene()
    assert len(parts) > 1
    for part in parts:
        assert len(part.changed) == 1 or sum(array_bytes(item) for item in part.changed) <= limit
        scene.apply(part)
        for item in scene.meshes.values():
            assert item.geometry in scene.geometries
            assert set(item.materials) <= scene.materials.keys()
    whole = Scene()
    whole.apply(delta)
    assert differences(scene, whole) == []


def test_a_full_export_names_its_objects(stage):
    made = convert_scene(bpy.context.evaluated_depsgraph_get())
    assert made.objects["First"] == f"object:{stage.first.lumenray.uid}"
    assert set(made.objects) == {"First", "Second", "Third"}


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.slow
def test_five_hundred_random_edits_leave_the_scene_of_a_fresh_export(seed, tmp_path):
    edits, done = RandomEdits(seed, tmp_path), []
    sync, kept = SceneSync(final=bool(seed % 2)), Scene()
    for number in range(1, 501):
        done.append(edits.edit())
        step = sync.walk(bpy.context.evaluated_depsgraph_get())
        kept.apply(step.delta)
        if number % 50 == 0:
            fresh = Scene()
            whole = SceneSync(sync.final).walk(bpy.context.evaluated_depsgraph_get())
            fresh.apply(whole.delta)
            assert differences(kept, fresh) == [], f"after {done[-50:]}"
            assert set(step.report.rows) == set(whole.report.rows), f"after {done[-50:]}"


def test_the_comparison_finds_what_was_missed(tmp_path):
    edits, kept = RandomEdits(1, tmp_path), Scene()
    kept.apply(SceneSync().walk(bpy.context.evaluated_depsgraph_get()).delta)
    for _ in range(20):
        edits.edit()
    fresh = Scene()
    fresh.apply(SceneSync().walk(bpy.context.evaluated_depsgraph_get()).delta)
    assert differences(kept, fresh)
