"""Textures and values of objects in all that materials are made of: what the camera alone sees, blends, coats, strands."""

import bpy
import numpy as np
import pytest
from conversion import converted_scene
from kept_scenes import KeptScene
from material_trees import new_tree, output_of
from seen_surfaces import see, see_by_cycles

from lumenray.engine.scene.material import Blend, Dielectric, Varnish
from lumenray.engine.scene.mesh import CHART_MAP
from lumenray.engine.scene.spectrum import Constant

pytestmark = pytest.mark.usefixtures("extension")

SHARE = 0.02
"""Share of pixels that may differ, at silhouettes. [-]"""


def add_box(material, location=(0.1, 0.2, -0.1)):
    bpy.ops.mesh.primitive_cube_add(size=1.6, location=location, rotation=(0.2, 0.1, 0.5))
    made = bpy.context.object
    made.data.materials.append(material)
    return made


def noise(tree, scale=2.0):
    where = output_of(tree.add("TexCoord"), "Generated")
    return tree.add("TexNoise", Vector=where, Scale=scale).outputs[1]


def value(tree, name):
    return output_of(tree.add("ObjectInfo"), name)


def camera_ray(tree):
    return output_of(tree.add("LightPath"), "Is Camera Ray")


def linked(tree, node, *outputs):
    """Link outputs to the first inputs of a node."""
    for number, output in enumerate(outputs):
        tree.material.node_tree.links.new(output, node.inputs[number])
    return node


def product(tree, first, second):
    node = tree.add("Math", attributes={"operation": "MULTIPLY"})
    return linked(tree, node, first, second).outputs[0]


def mixed(tree, factor, first, second):
    return linked(tree, tree.add("MixShader"), factor, first.outputs[0], second.outputs[0])


def materials_of(kept, item):
    """What the engine has of an object's materials."""
    (mesh,) = (mesh for mesh in kept.scene.meshes.values() if mesh.name == item.name)
    return [kept.scene.materials[key] for key in mesh.materials]


def test_the_camera_sees_textures_of_the_object_that_light_does_not_meet(tmp_path):
    tree = new_tree()
    plain, cloud = tree.add("Emission", Color=(0.2,) * 3), tree.add("Emission", Color=noise(tree))
    item = add_box(tree.surface(mixed(tree, camera_ray(tree), plain, cloud)))
    ours, is_met = see()
    theirs = see_by_cycles(tmp_path / "cycles.exr")
    is_wrong = (np.abs(ours - theirs).max(-1) > 0.02) & is_met
    assert is_wrong.sum() <= SHARE * is_met.sum()
    (made,) = materials_of(KeptScene.started(), item)
    assert made.seen.emission.pattern.uv_map == CHART_MAP
    assert made.emission.pattern is None


@pytest.mark.slow
def test_light_and_camera_have_pictures_on_the_same_charts_and_follow_edits():
    tree = new_tree()
    first, second = (tree.add("BsdfDiffuse", Color=noise(tree, scale)) for scale in (2.0, 9.0))
    item = add_box(tree.surface(mixed(tree, camera_ray(tree), first, second)))
    kept = KeptScene.started()
    (made,) = materials_of(kept, item)
    pictures = [each.surface.reflectance for each in (made, made.seen)]
    assert [picture.uv_map for picture in pictures] == [CHART_MAP] * 2
    assert not np.array_equal(pictures[0].pixels, pictures[1].pixels)
    node = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeTexNoise")
    node.inputs["Scale"].default_value = 3.0
    assert set(kept.sent()[0]) == {"Material", "Pixels"}


def test_colours_of_objects_reach_what_the_camera_alone_sees():
    tree = new_tree()
    first = tree.add("BsdfDiffuse", Color=(0.2,) * 3)
    second = tree.add("BsdfDiffuse", Color=value(tree, "Color"))
    material = tree.surface(mixed(tree, camera_ray(tree), first, second))
    tones = (0.3, 0.6)
    items = [add_box(material, location=(3.0 * k, 0.0, 0.0)) for k in range(2)]
    for item, tone in zip(items, tones, strict=True):
        item.color = (tone,) * 3 + (1.0,)
    kept = KeptScene.started()
    for item, tone in zip(items, tones, strict=True):
        (made,) = materials_of(kept, item)
        assert made.surface.reflectance == Constant(pytest.approx(0.2))
        assert made.seen.surface.reflectance == Constant(pytest.approx(tone))


def test_a_metal_by_the_angle_keeps_the_texture_of_its_object():
    def made_with(metallic):
        tree = new_tree()
        shader = tree.add("BsdfPrincipled", Base_Color=noise(tree), Roughness=0.2)
        tree.set(shader, "Metallic", metallic(tree))
        item = add_box(tree.surface(shader))
        (made,) = materials_of(KeptScene.started(), item)
        bpy.data.objects.remove(bpy.context.object)
        return made.surface

    blended = made_with(lambda tree: output_of(tree.add("LayerWeight"), "Facing"))
    plain, metal = made_with(lambda tree: 0.0), made_with(lambda tree: 1.0)
    assert isinstance(blended, Blend)
    ours = [each.pictures[0] for each in (blended.first, blended.second)]
    theirs = [each.pictures[0] for each in (plain, metal)]
    assert {picture.uv_map for picture in ours + theirs} == {CHART_MAP}
    for picture in ours:
        assert any(np.array_equal(picture.pixels, other.pixels) for other in theirs)


def test_a_mixture_by_the_angle_goes_by_values_of_the_object():
    tree = new_tree()
    fresnel = tree.add("Fresnel", IOR=1.5).outputs[0]
    factor = product(tree, fresnel, value(tree, "Object Index"))
    first, second = (tree.add("BsdfDiffuse", Color=(tone,) * 3) for tone in (0.2, 0.6))
    item = add_box(tree.surface(mixed(tree, factor, first, second)))
    item.pass_index = 3
    (made,) = materials_of(KeptScene.started(), item)
    # Along the normal Fresnel's formula gives ((1.5 - 1) / (1.5 + 1)) ** 2.
    assert made.surface.weights[0, 1, -1] == pytest.approx(3 * 0.04, rel=1e-3)


def test_what_depends_on_angle_and_ray_is_known_of_both():
    tree = new_tree()
    fresnel = tree.add("Fresnel", IOR=1.5).outputs[0]
    factor = product(tree, fresnel, camera_ray(tree))
    first, second = (tree.add("BsdfDiffuse", Color=(tone,) * 3) for tone in (0.2, 0.6))
    item = add_box(tree.surface(mixed(tree, factor, first, second)))
    (made,) = materials_of(KeptScene.started(), item)
    assert made.surface.reflectance == Constant(pytest.approx(0.2))
    assert made.seen.surface.weights[0, 1, -1] == pytest.approx(0.04, rel=1e-3)


def test_coats_lie_by_textures_of_the_object():
    tree = new_tree()
    shader = tree.add("BsdfPrincipled", Base_Color=(0.5,) * 3, Coat_Weight=noise(tree))
    item = add_box(tree.surface(shader))
    (made,) = materials_of(KeptScene.started(), item)
    assert isinstance(made.surface, Varnish)
    assert made.surface.weight.uv_map == CHART_MAP


def test_solids_absorb_by_values_of_the_object():
    tree = new_tree()
    material = tree.surface(tree.add("BsdfGlass", IOR=1.5))
    volume = tree.add("VolumeAbsorption", Color=value(tree, "Color"), Density=2.0)
    output = material.node_tree.get_output_node("CYCLES")
    material.node_tree.links.new(volume.outputs[0], output.inputs["Volume"])
    item = add_box(material)
    item.color = (0.25, 0.25, 0.25, 1.0)
    (made,) = materials_of(KeptScene.started(), item)
    assert isinstance(made.surface, Dielectric)
    # 2 * (1 - 0.25) per Blender unit.
    depth = -np.log(made.surface.internal.value) / made.surface.thickness
    assert depth == pytest.approx(1.5, rel=1e-5)


def test_light_in_the_colour_of_its_object_is_told():
    tree = new_tree()
    lamp = add_box(tree.surface(tree.add("Emission", Color=value(tree, "Color"))))
    lamp.color = (1.0, 0.53, 0.2, 1.0)
    floor = new_tree()
    add_box(floor.surface(floor.add("BsdfDiffuse", Color=(0.7, 0.3, 0.2))), location=(4, 0, 0))
    rows = [row.text() for row, _ in converted_scene().report.rows]
    assert any("coloured light of 'Paint'" in row for row in rows)
    lamp.color = (1.0, 1.0, 1.0, 1.0)
    rows = [row.text() for row, _ in converted_scene().report.rows]
    assert not any("coloured light of" in row for row in rows)


def add_fur(material):
    """A box with strands of its material."""
    item = add_box(material)
    item.modifiers.new("Fur", "PARTICLE_SYSTEM")
    made = item.particle_systems[0].settings
    made.type, made.count, made.hair_length, made.material = "HAIR", 5, 0.5, 1
    return item


def test_strands_have_values_of_their_object():
    tree = new_tree()
    item = add_fur(tree.surface(tree.add("BsdfDiffuse", Color=value(tree, "Color"))))
    item.color = (0.3, 0.3, 0.3, 1.0)
    kept = KeptScene.started()
    assert len(kept.scene.meshes) == 2
    for mesh in kept.scene.meshes.values():
        (key,) = mesh.materials
        assert kept.scene.materials[key].surface.reflectance == Constant(pytest.approx(0.3))


def test_strands_have_no_charts_beside_a_mesh_that_has():
    tree = new_tree()
    add_fur(tree.surface(tree.add("BsdfDiffuse", Color=noise(tree))))
    kept = KeptScene.started()
    (skin,) = (key for key, mesh in kept.scene.meshes.items() if not key.endswith("/hair"))
    (hair,) = (key for key in kept.scene.meshes if key.endswith("/hair"))
    assert CHART_MAP in kept.scene.mesh(skin).uv_maps
    assert not kept.scene.mesh(hair).uv_maps
    colours = [
        kept.scene.materials[kept.scene.meshes[key].materials[0]].surface.reflectance
        for key in (skin, hair)
    ]
    assert colours[0].uv_map == CHART_MAP
    assert not hasattr(colours[1], "uv_map")
    rows = [row.text() for row, _ in kept.step().report.rows]
    assert any("A procedural texture without a UV map" in row for row in rows)
    bpy.context.object.location.x = 2.0
    assert {"Material", "Pixels"}.isdisjoint(kept.sent()[0])


def test_a_normal_map_along_a_uv_map_counts_beside_textures_of_the_object():
    """Its tangents are those of the UV map, and what it makes lies on the charts."""
    tree = new_tree()
    picture = bpy.data.images.new("Slopes", 4, 4, float_buffer=True)
    picture.pixels.foreach_set(np.tile([0.7, 0.5, 0.9, 1.0], 16).astype(np.float32))
    picture.pixels[0] = 0.3
    slopes = tree.add("TexImage", attributes={"image": picture})
    picture.colorspace_settings.name = "Non-Color"
    normal = tree.add("NormalMap", Color=slopes.outputs["Color"])
    shader = tree.add("BsdfDiffuse", Color=noise(tree), Normal=normal.outputs[0])
    item = add_box(tree.surface(shader))
    (made,) = materials_of(KeptScene.started(), item)
    assert made.surface.surface.reflectance.uv_map == CHART_MAP
    assert made.surface.relief.vectors.uv_map == CHART_MAP


def test_textures_of_a_displaced_object_lie_on_its_displaced_surface():
    tree = new_tree()
    shader = tree.add("BsdfDiffuse", Color=noise(tree))
    material = tree.surface(shader)
    material.displacement_method = "DISPLACEMENT"
    output = material.node_tree.get_output_node("CYCLES")
    moved = tree.add("Displacement", Height=1.0, Midlevel=0.0, Scale=0.3)
    material.node_tree.links.new(moved.outputs[0], output.inputs["Displacement"])
    item = add_box(material)
    kept = KeptScene.started()
    (shape,) = (each for each in kept.scene.geometries.values() if CHART_MAP in each.uv_maps)
    # Flat faces: corners of the cube move along the normal of the first face that names them, as in Cycles.
    expected = np.tile([0.8, 0.8, 1.1], (8, 1))
    np.testing.assert_allclose(np.sort(np.abs(shape.vertices), axis=1), expected, rtol=1e-4)
    (made,) = materials_of(kept, item)
    assert made.surface.reflectance.uv_map == CHART_MAP
