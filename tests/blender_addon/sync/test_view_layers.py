"""What a view layer puts in place of materials and world, and what it leaves out."""

import bpy
import pytest
from kept_scenes import KeptScene

pytestmark = pytest.mark.blender


@pytest.fixture
def layer():
    return bpy.context.view_layer


@pytest.fixture
def kept():
    """Two floors, one of them with two materials, a lamp and a world."""
    for number, count in ((0, 1), (1, 2), (2, 0)):
        mesh = bpy.data.meshes.new(f"Floor {number}")
        mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, number)], [], [(0, 1, 2)])
        for slot in range(count):
            mesh.materials.append(bpy.data.materials.new(f"Paint {number} {slot}"))
        link(mesh)
    lamp = bpy.data.lights.new("Lamp", "POINT")
    lamp.energy = 10.0
    link(lamp)
    bpy.context.scene.world = bpy.data.worlds.new("Sky")
    return KeptScene.started()


def link(data):
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(data.name, data))


def names_of_materials(scene):
    return {
        mesh.name: [scene.materials[key].name for key in mesh.materials]
        for mesh in scene.meshes.values()
    }


def test_a_material_takes_the_place_of_all_others(kept, layer):
    before = names_of_materials(kept.scene)
    layer.material_override = bpy.data.materials.new("Clay")
    kinds, _ = kept.sent()
    assert sorted(kinds) == ["Material", "Placement", "Placement", "Placement"]
    assert names_of_materials(kept.scene) == {
        "Floor 0": ["Clay"],
        "Floor 1": ["Clay", "Clay"],
        "Floor 2": ["Clay"],
    }
    layer.material_override = None
    kept.sent()
    assert names_of_materials(kept.scene) == before


def test_a_world_takes_the_place_of_the_scenes(kept, layer):
    if not hasattr(layer, "world_override"):
        pytest.skip("this Blender has no world overrides")
    layer.world_override = bpy.data.worlds.new("Other")
    layer.world_override.color = (0.5, 0.5, 0.5)
    own = bpy.context.scene.world.lumenray.uid
    kinds, _ = kept.sent()
    assert kinds == ["UniformWorld"]
    assert kept.scene.world.id != f"world:{own}"
    layer.world_override = None
    assert kept.sent()[0] == ["UniformWorld"]
    assert kept.scene.world.id == f"world:{own}"


def test_a_layer_may_be_without_the_world(kept, layer):
    layer.use_sky = False
    assert kept.sent() == ([], 1)
    assert kept.scene.world is None
    layer.use_sky = True
    assert kept.sent() == (["UniformWorld"], 0)


def test_a_layer_may_be_without_surfaces(kept, layer):
    layer.use_solid = False
    changed, removed = kept.sent()
    assert (changed, len(kept.scene.meshes), len(kept.scene.lights)) == ([], 0, 1)
    assert removed >= 3
    layer.use_solid = True
    kept.sent()
    assert len(kept.scene.meshes) == 3
