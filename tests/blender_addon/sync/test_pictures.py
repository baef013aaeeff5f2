"""Images between edits: what is read, what is sent, and that nothing stale stays."""

import random

import bpy
import numpy as np
import pytest
from kept_scenes import KeptScene, differences
from random_edits import remember

from lumenray.blender_addon.sync.images import cache as image_cache
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.blender_addon.sync.step import split
from lumenray.engine.scene.light import ImageWorld
from lumenray.engine.scene.scene import Scene
from lumenray.engine.scene.texture import Pixels

SIZE = 160


def fill(image, seed):
    values = np.random.default_rng(seed).random((SIZE, SIZE, 4), dtype=np.float32)
    image.pixels.foreach_set(values.ravel())
    image.update_tag()


def new_image(name="Picture", seed=0):
    image = bpy.data.images.new(name, SIZE, SIZE, alpha=True)
    fill(image, seed)
    return image


def principled(material):
    return material.node_tree.nodes["Principled BSDF"].inputs


def add_picture(material, image, into="Base Color"):
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    material.node_tree.links.new(node.outputs[0], principled(material)[into])
    return node


class Stage(KeptScene):
    """Two triangles with materials of their own, one with a picture, and a scene of the engine kept current."""

    def __init__(self):
        super().__init__()
        self.image = new_image()
        self.first, self.second = self.add("First"), self.add("Second")
        self.node = add_picture(self.first, self.image)
        remember("start")
        self.step()

    def add(self, name):
        material = bpy.data.materials.new(name)
        if bpy.app.version < (5, 0, 0):
            material.use_nodes = True
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
        mesh.materials.append(material)
        bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, mesh))
        return material

    def sent(self):
        """Return the kinds of items that a step sends, and the number of removed ones."""
        made = self.step()
        fresh = SceneSync().walk(bpy.context.evaluated_depsgraph_get())
        scene = Scene()
        scene.apply(fresh.delta)
        assert differences(self.scene, scene) == []
        assert set(made.report.rows) == set(fresh.report.rows)
        assert self.scene.pixels.keys() == scene.pixels.keys()
        return [type(item).__name__ for item in made.delta.changed], len(made.delta.removed)


@pytest.fixture
def stage():
    return Stage()


@pytest.fixture
def reads(monkeypatch):
    """Names of the images that the syncs read from here on."""
    names, read = [], image_cache.read_pixels

    def count(image, *others):
        names.append(image.name)
        return read(image, *others)

    monkeypatch.setattr(image_cache, "read_pixels", count)
    return names


def reads_of(stage, reads):
    reads.clear()
    stage.step()
    return list(reads)


def test_a_value_beside_a_picture_sends_the_material_alone(stage, reads):
    (key,) = stage.scene.pixels
    array = stage.scene.materials[f"material:{stage.first.lumenray.uid}"].surface.reflectance.pixels
    assert array is stage.scene.pixels[key].values
    for value in (0.2, 0.3):
        principled(stage.first)["Roughness"].default_value = value
        assert stage.sent() == (["Material"], 0)
    principled(stage.first)["Roughness"].default_value = 0.4
    assert reads_of(stage, reads) == []
    material = stage.scene.materials[f"material:{stage.first.lumenray.uid}"]
    assert material.surface.reflectance.pixels is array


def test_new_pixels_send_picture_and_material(stage, reads):
    fill(stage.image, 1)
    assert stage.sent() == (["Pixels", "Material"], 1)
    assert len(stage.scene.pixels) == 1
    # The same again: it is read, but it is no news.
    fill(stage.image, 1)
    assert stage.sent() == ([], 0)
    stage.image.update_tag()
    assert reads_of(stage, reads) == ["Picture"]


def test_an_image_of_two_materials_is_sent_and_read_once(stage, reads):
    node = add_picture(stage.second, stage.image)
    node.interpolation = "Closest"
    assert stage.sent() == (["Material"], 0)
    assert len(stage.scene.pixels) == 1
    reads.clear()
    delta = convert_scene(bpy.context.evaluated_depsgraph_get()).delta
    assert sum(isinstance(item, Pixels) for item in delta.changed) == 1
    assert reads == ["Picture"]
    parts = list(split(delta, 100))
    assert isinstance(parts[0].changed[0], Pixels)
    scene = Scene()
    for part in parts:
        scene.apply(part)
    assert differences(scene, stage.scene) == []


def test_a_picture_goes_with_its_last_user(stage):
    add_picture(stage.second, stage.image)
    stage.step()
    stage.first.node_tree.nodes.remove(stage.node)
    assert stage.sent() == (["Material"], 0)
    mesh = bpy.data.meshes["Second"]
    mesh.materials.clear()
    stage.step()
    bpy.data.materials.remove(stage.second)
    stage.step()
    assert not stage.scene.pixels
    assert not stage.sync._sent.images._readings


def test_small_pictures_stay_in_their_materials(stage):
    stage.image.scale(32, 32)
    stage.image.update_tag()
    assert stage.sent() == (["Material"], 1)
    assert not stage.scene.pixels


@pytest.mark.parametrize("edit", ["alpha", "space", "straight", "name", "other"])
def test_what_reading_depends_on_is_noticed(stage, edit):
    match edit:
        case "alpha":
            stage.image.alpha_mode = "NONE"
            # Blender reports this for images of files only.
            stage.image.update_tag()
        case "space":
            stage.image.colorspace_settings.name = "Non-Color"
        case "straight":
            tree = stage.first.node_tree
            tree.links.new(stage.node.outputs["Alpha"], principled(stage.first)["Alpha"])
        case "name":
            stage.image.colorspace_settings.name = "ACEScg"
            stage.step()
            stage.image.name = "Other"
            stage.image.update_tag()
            assert "Pixels" not in stage.sent()[0]
            return
        case "other":
            stage.node.image = new_image("Other", 7)
    kinds, _ = stage.sent()
    assert "Pixels" in kinds


def test_a_file_that_is_loaded_again_is_read_again(stage, tmp_path):
    def save(seed):
        image = new_image("File", seed)
        image.filepath_raw, image.file_format = str(tmp_path / "picture.png"), "PNG"
        image.save()
        bpy.data.images.remove(image)

    save(1)
    stage.node.image = loaded = bpy.data.images.load(str(tmp_path / "picture.png"))
    assert stage.sent() == (["Pixels", "Material"], 1)
    save(2)
    loaded.reload()
    assert stage.sent() == (["Pixels", "Material"], 1)


def test_what_reading_has_to_say_is_said_again(stage):
    stage.image.colorspace_settings.name = "ACEScg"
    rows = stage.step().report.rows
    assert any("colour space" in row.message for row, _ in rows)
    principled(stage.first)["Roughness"].default_value = 0.9
    assert stage.step().report.rows == rows


def test_undo_brings_the_old_pixels_back(stage, reads):
    stage.node.image = new_image("Other", 7)
    remember("other")
    stage.step()
    bpy.ops.ed.undo()
    assert reads_of(stage, reads)[:1] == ["Picture"]
    assert stage.sent() == ([], 0)


def test_opening_another_file_takes_the_pictures_away(stage):
    assert stage.scene.pixels
    bpy.ops.wm.read_factory_settings(use_empty=True)
    stage.step()
    assert not stage.scene.pixels


def test_a_picture_of_the_world_is_sent_once(stage, reads):
    world = bpy.context.scene.world = bpy.data.worlds.new("Sky")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    background = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    node = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = new_image("Sky", 3)
    world.node_tree.links.new(node.outputs[0], background.inputs[0])
    assert stage.sent() == (["Pixels", "ImageWorld"], 0)
    background.inputs[1].default_value = 3.0
    assert reads_of(stage, reads) == []
    assert isinstance(stage.scene.world, ImageWorld)
    bpy.context.scene.world = None
    assert stage.sent() == ([], 2)


def test_memory_is_bounded(stage, monkeypatch, reads):
    add_picture(stage.second, new_image("Other", 7))
    stage.step()
    assert len(stage.sync._sent.images._readings) == 2
    monkeypatch.setattr(image_cache, "LARGEST", SIZE * SIZE * 4 * 6)
    principled(stage.first)["Roughness"].default_value = 0.1
    assert reads_of(stage, reads) == []
    assert len(stage.sync._sent.images._readings) == 1
    principled(stage.second)["Roughness"].default_value = 0.1
    assert reads_of(stage, reads) == ["Other"]


@pytest.mark.parametrize("kind", ["ramp", "curves", "maths", "mix"])
def test_what_nodes_make_of_a_picture_is_kept_until_one_of_them_changes(stage, kind, monkeypatch):
    from lumenray.blender_addon.sync.nodes import evaluation as nodes

    tree = stage.first.node_tree
    match kind:
        case "ramp":
            node, into = tree.nodes.new("ShaderNodeValToRGB"), 0
        case "curves":
            node, into = tree.nodes.new("ShaderNodeRGBCurve"), 1
        case "maths":
            node, into = tree.nodes.new("ShaderNodeMath"), 0
        case "mix":
            node, into = tree.nodes.new("ShaderNodeMix"), 6
            node.data_type = "RGBA"
    tree.links.new(stage.node.outputs[0], node.inputs[into])
    output = node.outputs[2 if kind == "mix" else 0]
    tree.links.new(output, principled(stage.first)["Base Color"])
    assert stage.sent() == (["Pixels", "Material"], 1)
    count, make = [], nodes.map_fields

    def counted(function, *fields, note):
        count.extend(1 for field in fields if not field.is_constant)
        return make(function, *fields, note=note)

    monkeypatch.setattr(nodes, "map_fields", counted)
    principled(stage.first)["Roughness"].default_value = 0.1
    assert [type(item).__name__ for item in stage.step().delta.changed] == ["Material"]
    assert count == []
    match kind:
        case "ramp":
            node.color_ramp.elements[1].color = (0.2, 0.3, 0.4, 1)
        case "curves":
            node.mapping.curves[0].points[1].location = (1, 0.5)
            node.mapping.update()
        case "maths":
            node.operation = "MULTIPLY"
        case "mix":
            node.inputs[7].default_value = (1, 0, 0, 1)
    tree.update_tag()
    assert stage.sent() == (["Pixels", "Material"], 1)


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_random_edits_of_pictures_leave_the_scene_of_a_fresh_export(stage, seed):
    chance = random.Random(seed)  # noqa: S311 - nothing secret
    done = []

    def materials():
        return sorted(bpy.data.materials, key=lambda each: each.name)

    def images():
        return sorted(bpy.data.images, key=lambda each: each.name)

    def picture_nodes():
        return [
            node
            for material in materials()
            for node in material.node_tree.nodes
            if node.bl_idname == "ShaderNodeTexImage"
        ]

    def rough():
        principled(chance.choice(materials()))["Roughness"].default_value = chance.random()

    def paint():
        if images():
            fill(chance.choice(images()), chance.randrange(4))

    def swap():
        for node in picture_nodes()[:1]:
            node.image = chance.choice([*images(), None])

    def lay():
        for node in picture_nodes()[-1:]:
            node.extension = chance.choice(["REPEAT", "EXTEND", "CLIP", "MIRROR"])
            node.interpolation = chance.choice(["Linear", "Closest", "Cubic"])

    def insert():
        material = chance.choice(materials())
        into = chance.choice(["Base Color", "Roughness", "Metallic", "Alpha", "Emission Color"])
        node = add_picture(material, chance.choice(images()), into)
        if chance.random() < 0.4:
            ramp = material.node_tree.nodes.new("ShaderNodeValToRGB")
            ramp.color_ramp.elements[0].color = (chance.random(), 0.2, 0.3, 1)
            material.node_tree.links.new(node.outputs[0], ramp.inputs[0])
            material.node_tree.links.new(ramp.outputs[0], principled(material)[into])
        if into == "Emission Color":
            principled(material)["Emission Strength"].default_value = chance.random()

    def cut():
        nodes = picture_nodes()
        if nodes:
            node = chance.choice(nodes)
            node.id_data.nodes.remove(node)

    def add():
        if len(images()) < 4:
            new_image(f"Image {chance.randrange(99)}", chance.randrange(4))

    def set_up():
        image = chance.choice(images())
        image.alpha_mode = chance.choice(["NONE", "STRAIGHT", "CHANNEL_PACKED"])
        image.colorspace_settings.name = chance.choice(["sRGB", "Non-Color", "ACEScg"])

    def undo():
        if bpy.ops.ed.undo.poll():
            bpy.ops.ed.undo()

    edits = (rough, rough, paint, swap, lay, insert, cut, add, set_up, undo)
    for number in range(1, 101):
        edit = chance.choice(edits)
        done.append(edit.__name__)
        edit()
        bpy.context.view_layer.update()
        if edit is not undo:
            remember(done[-1])
        stage.step()
        if number % 5 == 0:
            made = stage.sync.walk(bpy.context.evaluated_depsgraph_get())
            fresh = SceneSync().walk(bpy.context.evaluated_depsgraph_get())
            scene = Scene()
            scene.apply(fresh.delta)
            assert differences(stage.scene, scene) == [], f"after {done}"
            assert set(made.report.rows) == set(fresh.report.rows), f"after {done}"
            assert scene.pixels.keys() <= stage.scene.pixels.keys()
