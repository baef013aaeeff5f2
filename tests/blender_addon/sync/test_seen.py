"""What Blender shows to the camera alone, by Light Path nodes and holdouts, becomes what the engine's camera sees."""

import bpy
import pytest
from conversion import converted_scene

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.material import Black, Diffuse, Holdout, Mix, Transparent
from lumenray.engine.session import Session, ViewSettings

pytestmark = pytest.mark.blender


class Paint:
    """A material on a plane; ``mix``: two shaders by a factor."""

    def __init__(self, name="Paint"):
        bpy.ops.mesh.primitive_plane_add()
        self.item = bpy.context.object
        self.material = bpy.data.materials.new(name)
        if bpy.app.version < (5, 0, 0):
            self.material.use_nodes = True
        self.item.data.materials.append(self.material)
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        self.output = self.add("OutputMaterial").inputs["Surface"]

    def add(self, kind, **values):
        node = self.tree.nodes.new(f"ShaderNode{kind}")
        for name, value in values.items():
            node.inputs[name].default_value = value
        return node

    def diffuse(self, value):
        return self.add("BsdfDiffuse", Color=(value, value, value, 1.0)).outputs[0]

    def mix(self, factor, first, second):
        node = self.add("MixShader")
        for socket, value in zip(node.inputs, (factor, first, second), strict=True):
            if isinstance(value, float):
                socket.default_value = value
            else:
                self.tree.links.new(value, socket)
        return node.outputs[0]

    def show(self, output):
        self.tree.links.new(output, self.output)


def ray(paint, name="Is Camera Ray"):
    return paint.add("LightPath").outputs[name]


def converted():
    """Material and messages about it."""
    made = converted_scene()
    (material,) = (item for item in made.delta.changed if item.id.startswith("material:"))
    return material, [row.text() for row, _ in made.report.rows if row.datablock == "Paint"]


def test_a_mixture_by_rays_of_the_camera_is_split():
    paint = Paint()
    paint.show(paint.mix(ray(paint), paint.diffuse(0.3), paint.diffuse(0.7)))
    made, told = converted()
    assert made.surface.reflectance.value == pytest.approx(0.3)
    assert made.seen.surface.reflectance.value == pytest.approx(0.7)
    assert made.seen.id != made.id
    (text,) = told
    assert text.startswith("info: ")
    assert "the camera sees another surface than light meets" in text


def test_values_that_know_the_camera_are_split_too():
    """As a factor turned about, and as the strength of an emission."""
    paint = Paint()
    turned = paint.add("Math")
    turned.operation = "SUBTRACT"
    turned.inputs[0].default_value = 1.0
    paint.tree.links.new(ray(paint), turned.inputs[1])
    glow = paint.add("Emission")
    paint.tree.links.new(turned.outputs[0], glow.inputs["Strength"])
    paint.show(glow.outputs[0])
    made, _ = converted()
    assert made.emission.luminance > 0.0
    assert made.seen.emission is None


@pytest.mark.parametrize("name", ["Is Shadow Ray", "Is Diffuse Ray", "Is Glossy Ray", "Ray Depth"])
def test_other_rays_make_no_difference_to_the_camera(name):
    paint = Paint()
    paint.show(paint.mix(ray(paint, name), paint.diffuse(0.3), paint.diffuse(0.7)))
    made, told = converted()
    assert made.seen is None
    assert made.surface.reflectance.value == pytest.approx(0.3)
    assert [text.split(":")[0] for text in told] == ["warning"]


def test_light_paths_without_effect_are_not_told():
    paint = Paint()
    paint.show(paint.mix(ray(paint), paint.diffuse(0.4), paint.diffuse(0.4)))
    made, told = converted()
    assert made.seen is None
    assert told == []


def test_a_holdout_is_a_hole_to_the_camera_and_black_to_light():
    paint = Paint()
    paint.show(paint.add("Holdout").outputs[0])
    made, told = converted()
    assert type(made.surface) is Black
    assert type(made.seen.surface) is Holdout
    assert [text.split(":")[0] for text in told] == ["info"]


def test_a_part_of_a_holdout_is_black_and_a_warning():
    paint = Paint()
    paint.show(paint.mix(0.25, paint.add("Holdout").outputs[0], paint.diffuse(0.4)))
    made, told = converted()
    assert isinstance(made.seen.surface, Mix)
    assert any(text.startswith("warning: ") and "a holdout is mixed" in text for text in told)


def test_what_only_the_camera_sees_through_stays_in_the_way_of_light():
    paint = Paint()
    clear = paint.add("BsdfTransparent").outputs[0]
    paint.show(paint.mix(ray(paint), paint.diffuse(0.3), clear))
    made, _ = converted()
    assert isinstance(made.surface, Diffuse)
    assert isinstance(made.seen.surface, Transparent)


def placements():
    return [item for item in converted_scene().delta.changed if hasattr(item, "is_holdout")]


def test_objects_collections_and_makers_of_instances_are_holdouts():
    paint = Paint()
    paint.item.is_holdout = True
    assert [item.is_holdout for item in placements()] == [True]
    paint.item.is_holdout = False
    scene = bpy.context.scene
    group = bpy.data.collections.new("Group")
    scene.collection.children.link(group)
    group.objects.link(paint.item)
    scene.collection.objects.unlink(paint.item)
    layer = scene.view_layers[0].layer_collection.children["Group"]
    layer.holdout = True
    assert [item.is_holdout for item in placements()] == [True]
    layer.holdout, layer.exclude = False, True
    maker = bpy.data.objects.new("Maker", None)
    maker.instance_type, maker.instance_collection = "COLLECTION", group
    scene.collection.objects.link(maker)
    assert [item.is_holdout for item in placements()] == [False]
    maker.is_holdout = True
    assert [item.is_holdout for item in placements()] == [True]


def test_objects_and_makers_of_instances_are_shadow_catchers():
    paint = Paint()
    assert [item.is_catcher for item in placements()] == [False]
    paint.item.is_shadow_catcher = True
    assert [item.is_catcher for item in placements()] == [True]
    paint.item.is_shadow_catcher = False
    scene = bpy.context.scene
    group = bpy.data.collections.new("Group")
    group.objects.link(paint.item)
    scene.collection.objects.unlink(paint.item)
    maker = bpy.data.objects.new("Maker", None)
    maker.instance_type, maker.instance_collection = "COLLECTION", group
    scene.collection.objects.link(maker)
    maker.is_shadow_catcher = True
    assert [item.is_catcher for item in placements()] == [True]


@pytest.mark.mitsuba
def test_edits_of_nodes_and_holdouts_reach_the_picture():
    from lumenray.blender_addon.sync.scene_sync import SceneSync

    paint = Paint()
    world = bpy.data.worlds.new("Even")
    world.lumenray.source = "CIE"
    world.lumenray.sky.type = "5"
    scene = bpy.context.scene
    scene.world = world
    data = bpy.data.cameras.new("Eye")
    data.type, data.ortho_scale = "ORTHO", 1.0
    scene.camera = bpy.data.objects.new("Eye", data)
    scene.camera.location = (0.0, 0.0, 3.0)
    scene.collection.objects.link(scene.camera)
    scene.render.resolution_x = scene.render.resolution_y = 4
    sync, session = SceneSync(final=True), Session(witness=False)

    def look():
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        sync.tag_scene()
        sync._tags.objects.add(paint.item.session_uid)
        sync._tags.shading.add(paint.material.session_uid)
        walked = sync.walk(depsgraph)
        session.apply(walked.delta)
        camera = converted_scene().camera
        picture = session.render(camera, ViewSettings(StopRule(samples=64)))
        return picture.tristimulus[..., 1].mean(), picture.coverage

    sky = world.lumenray.sky.illuminance / 3.14159265
    paint.show(paint.diffuse(0.5))
    assert look()[0] == pytest.approx(0.5 * sky, rel=0.02)
    paint.show(paint.mix(ray(paint), paint.diffuse(0.5), paint.diffuse(0.1)))
    assert look()[0] == pytest.approx(0.1 * sky, rel=0.02)
    paint.item.is_holdout = True
    luminance, coverage = look()
    assert (luminance, coverage.max()) == (0.0, 0.0)
    paint.item.is_holdout = False
    assert look()[0] == pytest.approx(0.1 * sky, rel=0.02)
    paint.show(paint.diffuse(0.5))
    assert look()[0] == pytest.approx(0.5 * sky, rel=0.02)


def test_a_collection_that_becomes_a_holdout_is_sent_anew():
    from lumenray.blender_addon.sync.scene_sync import SceneSync

    paint = Paint()
    scene = bpy.context.scene
    group = bpy.data.collections.new("Group")
    scene.collection.children.link(group)
    group.objects.link(paint.item)
    scene.collection.objects.unlink(paint.item)
    layer = scene.view_layers[0].layer_collection.children["Group"]
    sync, found = SceneSync(final=True), []
    for value in (False, True, True, False):
        layer.holdout = value
        bpy.context.view_layer.update()
        walked = sync.walk(bpy.context.evaluated_depsgraph_get())
        found.append(
            [item.is_holdout for item in walked.delta.changed if hasattr(item, "is_holdout")]
        )
    assert found == [[False], [True], [], [False]]
