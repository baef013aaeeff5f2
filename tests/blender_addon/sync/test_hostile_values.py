"""Values out of all proportion cost one thing and one row that names it, never the whole scene."""

from functools import partial

import bpy
import numpy as np
import pytest
from blender_objects import add_light, new_world
from conversion import converted_scene

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import UniformWorld
from lumenray.engine.scene.mesh import Placement
from lumenray.engine.session import Session
from lumenray.tools.libraries.scenes import tiny

INFINITE, NONE = float("inf"), float("nan")


@pytest.fixture(autouse=True)
def _box(_empty_file):
    tiny.build_closed_box()


def errors(made):
    return [row for row, _ in made.report.rows if row.severity.value == "error"]


def illuminance(made):
    session = Session()
    session.apply(made.delta)
    return session.measure([(0.5, 0.5, 0.1)], [(0, 0, 1)], StopRule(samples=1 << 13)).illuminance[0]


def names(made, kind):
    return {item.name for item in made.delta.changed if isinstance(item, kind)}


def lamps(made):
    return {item.name for item in made.delta.changed if hasattr(item, "output")}


def add_triangle(corner=(3.0, 3.0, 5.0), location=(0.0, 0.0, 0.0)):
    mesh = bpy.data.meshes.new("Sliver")
    mesh.from_pydata([(3.0, 3.0, 3.0), (4.0, 3.0, 3.0), corner], [], [(0, 1, 2)])
    item = bpy.data.objects.new("Sliver", mesh)
    item.location = location
    bpy.context.scene.collection.objects.link(item)
    return item


add_odd = partial(add_light, location=(5.0, 5.0, 5.0), name="Odd")


@pytest.mark.mitsuba
@pytest.mark.parametrize(
    "where",
    [
        {"corner": (3.0, 3.0, 1e30)},
        {"corner": (INFINITE, 3.0, 3.0)},
        {"corner": (3.0, NONE, 3.0)},
        {"location": (1e30, 0.0, 0.0)},
        {"location": (0.0, INFINITE, 0.0)},
        {"location": (0.0, NONE, 0.0)},
    ],
    ids=str,
)
@pytest.mark.slow
def test_an_object_out_of_reach_is_left_out_by_its_name_and_the_rest_stays(where):
    before = illuminance(converted_scene())
    add_triangle(**where)
    made = converted_scene()
    assert "Sliver" not in names(made, Placement)
    (row,) = errors(made)
    assert row.datablock == "Sliver"
    assert "left out" in row.remedy
    assert illuminance(made) == before


def test_an_object_that_comes_back_into_reach_is_there_again():
    from lumenray.blender_addon.sync.scene_sync import SceneSync

    item = add_triangle(location=(1e30, 0.0, 0.0))
    sync = SceneSync(final=True)

    def step(*location):
        item.location = location
        bpy.context.view_layer.update()
        sync.tag_scene()
        return sync.walk(bpy.context.evaluated_depsgraph_get())

    assert errors(step(1e30, 0.0, 0.0))
    back = step(1.0, 0.0, 0.0)
    assert not errors(back)
    assert "Sliver" in names(back, Placement)
    gone = step(-1e30, 0.0, 0.0)
    assert errors(gone)
    assert gone.delta.removed


@pytest.mark.mitsuba
@pytest.mark.parametrize("location", [(1e30, 0, 0), (0, INFINITE, 0), (0, 0, NONE)], ids=str)
@pytest.mark.parametrize("kind", ["POINT", "SPOT", "AREA"])
@pytest.mark.slow
def test_a_light_out_of_reach_is_left_out_by_its_name_and_the_rest_stays(kind, location):
    before = illuminance(converted_scene())
    add_odd(kind, energy=10.0).location = location
    made = converted_scene()
    assert "Odd" not in lamps(made)
    assert [row.datablock for row in errors(made)] == ["Odd"]
    assert illuminance(made) == before


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        ("AREA", {"size": 1e30, "energy": 10.0}),
        ("POINT", {"shadow_soft_size": 1e30, "energy": 10.0}),
        ("POINT", {"energy": INFINITE}),
        ("POINT", {"energy": NONE}),
        ("POINT", {"energy": -10.0}),
        ("SUN", {"energy": -1.0}),
        ("AREA", {"energy": INFINITE}),
        ("SPOT", {"energy": 1e30}),
    ],
    ids=str,
)
def test_light_that_is_none_or_endless_is_left_out_by_its_name(kind, settings):
    add_odd(kind, **settings)
    made = converted_scene()
    assert "Odd" not in lamps(made)
    (row,) = errors(made)
    assert row.datablock == "Odd"


@pytest.mark.parametrize("strength", [INFINITE, NONE, -2.0, 1e30])
def test_a_world_without_a_usable_strength_is_black_and_an_error(strength):
    new_world((1.0, 1.0, 1.0), strength, "Odd")
    made = converted_scene()
    assert not any(isinstance(item, UniformWorld) for item in made.delta.changed)
    assert [row.datablock for row in errors(made)] == ["Odd"]


@pytest.mark.parametrize("red", [INFINITE, NONE])
def test_a_world_without_a_usable_colour_is_black_and_an_error(red):
    new_world((red, 0.1, 0.1), name="Odd")
    made = converted_scene()
    assert not any(isinstance(item, UniformWorld) for item in made.delta.changed)
    assert [row.datablock for row in errors(made)] == ["Odd"]


def test_pixels_that_are_no_numbers_are_told_and_count_as_nothing(tree):
    image = bpy.data.images.new("Broken", 2, 2, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    values = np.full((4, 4), 0.5, np.float32)
    values[0, :3], values[1, 0] = NONE, INFINITE
    image.pixels.foreach_set(values.ravel())
    picture = tree.add("TexImage", attributes={"image": image})
    tree.surface(tree.add("BsdfDiffuse", Color=picture.outputs["Color"]))
    bpy.data.objects["Floor"].data.materials[0] = tree.material
    made = converted_scene()
    (row,) = errors(made)
    assert "'Broken' has 2 pixels" in row.message
    (paint,) = (item for item in made.delta.changed if getattr(item, "name", "") == "Paint")
    assert paint.surface.reflectance.pixels.sum() == pytest.approx(2 * 3 * 0.5 + 2 * 0.5)


@pytest.mark.parametrize("depth", [40, 600])
@pytest.mark.slow
def test_a_mix_of_great_depth_is_refused_in_words(tree, depth):
    shader = tree.add("BsdfDiffuse")
    for number in range(depth):
        mix = tree.add("MixShader")
        other = tree.add("BsdfGlossy", Roughness=0.3 + number / 1000)
        tree.material.node_tree.links.new(shader.outputs[0], mix.inputs[1])
        tree.material.node_tree.links.new(other.outputs[0], mix.inputs[2])
        shader = mix
    tree.surface(shader)
    bpy.data.objects["Floor"].data.materials[0] = tree.material
    (row,) = errors(converted_scene())
    assert row.datablock == "Paint"
    assert "mixed into each other" in row.message


def light_tree(light):
    if bpy.app.version < (5, 0, 0):
        light.data.use_nodes = True
    tree = light.data.node_tree
    if tree is None:
        light.data.use_nodes = True
        tree = light.data.node_tree
    return tree, next(n for n in tree.nodes if n.bl_idname == "ShaderNodeEmission")


def test_a_spot_whose_beam_a_texture_shapes_by_its_place_is_an_error():
    light = add_odd("SPOT", energy=10.0)
    tree, emission = light_tree(light)
    texture = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
    made = converted_scene()
    assert "Odd" in lamps(made)
    assert any("cannot be taken over" in row.message for row in errors(made))


def test_an_area_light_that_a_picture_shapes_is_an_error():
    light = add_odd("AREA", energy=10.0)
    tree, emission = light_tree(light)
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.new("Gobo", 4, 4)
    texture.image.pixels.foreach_set(np.tile(np.repeat([0.0, 1.0], 4), 8).astype(np.float32))
    tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
    assert any("picture shapes the light" in row.message for row in errors(converted_scene()))


def test_a_picture_that_is_no_number_shapes_no_light():
    light = add_odd("SPOT", energy=10.0)
    tree, emission = light_tree(light)
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.new("Gobo", 4, 4, float_buffer=True)
    texture.image.pixels.foreach_set(np.full(64, np.nan, np.float32))
    tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
    made = converted_scene()
    for item in made.delta.changed:
        if getattr(item, "name", "") == "Odd":
            assert np.isfinite(item.output.value)


@pytest.mark.parametrize("scale", [(2.0, 1.0, 1.0), (1e-6, 1.0, 1.0), (1e6, 1e-6, 1.0)])
def test_a_spot_may_be_scaled_as_unevenly_as_it_likes(scale):
    light = add_odd("SPOT", energy=10.0)
    light.scale = scale
    made = converted_scene()
    assert errors(made) == []
    (light,) = (item for item in made.delta.changed if getattr(item, "name", "") == "Odd")
    assert np.isfinite(light.output.value)


def test_a_scale_of_the_units_that_blender_leaves_out_is_told():
    add_odd(energy=10.0)
    add_odd("SUN", energy=10.0)
    settings = bpy.context.scene.unit_settings
    settings.system, settings.scale_length = "METRIC", 0.01
    ((row, count),) = (
        (r, n) for r, n in converted_scene().report.rows if r.datablock == "Unit scale"
    )
    assert count == 1
    assert "1e+04 times" in row.remedy
