"""Groups of lights: what belongs to which, and layers of single luminaires."""

import bpy
import pytest
from blender_bakes import add_lamp
from blender_objects import add_quad, new_material

from lumenray.blender_addon import light_groups
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.engine.errors import LumenrayError

pytestmark = pytest.mark.usefixtures("extension")


def find(mode):
    converted = convert_scene(bpy.context.evaluated_depsgraph_get())
    return light_groups.find_groups(converted.luminous, bpy.context.scene.world, mode)


def lamp_world(group):
    world = bpy.data.worlds.new("World")
    bpy.context.scene.world = world
    if world.node_tree is None:
        world.use_nodes = True
    world.lumenray.light_group = group


def test_groups_hold_lights_glowing_materials_and_the_world():
    lamps = [add_lamp("A", "Ceiling"), add_lamp("B", "Ceiling"), add_lamp("C")]
    # The name of what is left over.
    add_lamp("D", "rest")
    glow = new_material("Glow", "ShaderNodeEmission")
    glow.lumenray.light_group = "Signs"
    dark = new_material("Dark", "ShaderNodeBsdfDiffuse")
    dark.lumenray.light_group = "Signs"
    add_quad("Sign", material=glow)
    add_quad("Wall", 2.0, material=dark)
    lamp_world("Daylight")
    groups = {group.name: group.members for group in find("groups")}
    assert set(groups) == {"Ceiling", "Signs", "Daylight"}
    assert groups["Ceiling"] == tuple(sorted(f"light:{lamp.lumenray.uid}" for lamp in lamps[:2]))
    assert groups["Signs"] == (f"material:{glow.lumenray.uid}",)
    assert groups["Daylight"] == ("world",)
    assert find("none") == ()


def test_instances_of_a_light_belong_to_its_group():
    lamp = add_lamp("Lamp", "Row")
    row = bpy.data.collections.new("Row")
    bpy.context.scene.collection.objects.unlink(lamp)
    row.objects.link(lamp)
    for number in range(3):
        empty = bpy.data.objects.new(f"Place {number}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", row
        empty.location.x = number
        bpy.context.scene.collection.objects.link(empty)
    (group,) = find("groups")
    assert len(group.members) == 3
    assert len(find("each")) == 3


def test_each_luminaire_gets_a_layer_of_its_own_name():
    for name in ("Lamp", "Lamp.001"):
        add_lamp(name)
    lamp_world("")
    assert [group.name for group in find("each")] == ["Lamp", "Lamp.001", "World"]
    for number in range(light_groups.MOST):
        add_lamp(f"More {number}")
    with pytest.raises(LumenrayError, match="light groups"):
        find("each")


def test_blenders_own_light_groups_count_where_lumenrays_are_empty():
    layer = bpy.context.view_layer
    for name in ("Key", "Sky", "Signs"):
        layer.lightgroups.add().name = name
    lamps = [add_lamp("A"), add_lamp("B", "Ceiling"), add_lamp("C")]
    for lamp in lamps[:2]:
        lamp.lightgroup = "Key"
    glow, shared = (new_material(name, "ShaderNodeEmission") for name in ("Glow", "Shared"))
    add_quad("Sign", material=glow).lightgroup = "Signs"
    add_quad("One", material=shared).lightgroup = "Signs"
    add_quad("Two", material=shared)
    lamp_world("")
    bpy.context.scene.world.lightgroup = "Sky"
    groups = {group.name: group.members for group in find("groups")}
    assert set(groups) == {"Key", "Ceiling", "Sky", "Signs"}
    assert groups["Key"] == (f"light:{lamps[0].lumenray.uid}",)
    assert groups["Signs"] == (f"material:{glow.lumenray.uid}",)
