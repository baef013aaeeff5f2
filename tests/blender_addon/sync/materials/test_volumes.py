"""Volumes of materials: absorption in solids by Blender's own coefficients, all else is told."""

import bpy
import numpy as np
import pytest
from conversion import converted_scene, rgb_of
from material_trees import EFFICACY, new_tree

from lumenray.blender_addon.assumptions import refuse_media
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.materials.materials import convert_material
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.material import Dielectric, Material, Raised

pytestmark = pytest.mark.blender

COLOUR, DENSITY = (0.3, 0.8, 0.5), 2.0
GLASS = {"Color": (1.0, 1.0, 1.0), "IOR": 1.5, "Roughness": 0.0}


def filled(tree, shader, volume):
    """Material of a surface and a volume."""
    material = tree.surface(shader)
    output = material.node_tree.get_output_node("CYCLES")
    material.node_tree.links.new(volume.outputs[0], output.inputs["Volume"])
    return material


def absorption(tree, **values):
    return tree.add("VolumeAbsorption", **({"Color": COLOUR, "Density": DENSITY} | values))


def passed(surface, depth):
    """Share of red, green and blue that passes so much of a body. [m -> -]"""
    return np.array(rgb_of(surface.internal)) ** (depth / surface.thickness)


def test_glass_absorbs_what_its_colour_lacks_by_density_and_depth(tree, convert):
    result, rows = convert(filled(tree, tree.add("BsdfGlass", **GLASS), absorption(tree)))
    expected = np.exp(-(1.0 - np.array(COLOUR)) * DENSITY * 0.4)
    np.testing.assert_allclose(passed(result.surface, 0.4), expected, rtol=1e-5)
    assert isinstance(result.surface, Dielectric)
    assert rows == []


def test_glass_with_a_relief_absorbs_as_well(tree, convert):
    normal = tree.add("NormalMap", Color=(0.7, 0.5, 0.9))
    glass = tree.add("BsdfGlass", Normal=normal.outputs[0], **GLASS)
    result, rows = convert(filled(tree, glass, absorption(tree)))
    assert isinstance(result.surface, Raised)
    expected = np.exp(-(1.0 - np.array(COLOUR)) * DENSITY * 0.4)
    np.testing.assert_allclose(passed(result.surface.surface, 0.4), expected, rtol=1e-5)
    assert rows == []


def test_coefficients_are_those_of_their_node(tree, convert):
    volume = tree.add("VolumeCoefficients", Absorption_Coefficients=(0.2, 1.0, 3.0))
    volume.inputs["Scatter Coefficients"].default_value = (0.0, 0.0, 0.0)
    result, rows = convert(filled(tree, tree.add("BsdfGlass", **GLASS), volume))
    np.testing.assert_allclose(passed(result.surface, 0.7), np.exp([-0.14, -0.7, -2.1]), rtol=1e-5)
    assert rows == []


@pytest.mark.parametrize("values", [{"Density": 0.0}, {"Color": (1.0, 1.0, 1.0)}])
def test_a_volume_that_absorbs_nothing_is_none(tree, convert, values):
    result, rows = convert(filled(tree, tree.add("BsdfGlass", **GLASS), absorption(tree, **values)))
    assert result.surface.internal is None
    assert rows == []


def test_light_does_not_get_into_opaque_bodies(tree, convert):
    result, rows = convert(filled(tree, tree.add("BsdfDiffuse"), absorption(tree)))
    assert result.surface.is_opaque
    assert rows == []


def test_absorption_within_other_surfaces_is_told(tree, convert):
    for make in (
        lambda t: t.add("BsdfPrincipled", Transmission_Weight=0.5),
        lambda t: t.add("BsdfTransparent"),
    ):
        fresh = new_tree()
        _, rows = convert(filled(fresh, make(fresh), absorption(fresh)))
        assert [row["severity"] for row in rows if "Absorption" in row["message"]] == ["error"]


@pytest.mark.parametrize("kind", ["VolumeScatter", "VolumePrincipled", "VolumeCoefficients"])
@pytest.mark.parametrize("shader", ["BsdfGlass", "BsdfTransparent"])
def test_scattering_volumes_are_told_and_refused_where_illuminance_is_asked_for(kind, shader):
    tree = new_tree()
    report = ConversionReport()
    material = filled(tree, tree.add(shader), tree.add(kind))
    convert_material(material, "key", report, EFFICACY)
    (row,) = [row for row, _ in report.rows if row.is_medium]
    assert row.severity.value == "error"
    assert "scatters or emits" in row.message
    with pytest.raises(SceneError, match="illuminance cannot be computed beside such a volume"):
        refuse_media(report)


def test_volumes_of_worlds_and_volume_objects_are_refused_too():
    world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    bpy.context.scene.world = world
    nodes = world.node_tree.nodes
    output = nodes.get("World Output") or nodes.new("ShaderNodeOutputWorld")
    scatter = nodes.new("ShaderNodeVolumeScatter")
    world.node_tree.links.new(scatter.outputs[0], output.inputs["Volume"])
    with pytest.raises(SceneError, match="the world has a volume"):
        refuse_media(converted_scene().report)
    bpy.context.scene.world = None
    refuse_media(converted_scene().report)
    smoke = bpy.data.objects.new("Smoke", bpy.data.volumes.new("Smoke"))
    bpy.context.scene.collection.objects.link(smoke)
    with pytest.raises(SceneError, match="Smoke"):
        refuse_media(converted_scene().report)


def test_depths_are_metres_in_scenes_of_other_units():
    tree = new_tree()
    material = filled(tree, tree.add("BsdfGlass", **GLASS), absorption(tree))
    mesh = bpy.data.meshes.new("Body")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Body", mesh))
    surfaces = []
    for scale in (1.0, 0.01):
        bpy.context.scene.unit_settings.scale_length = scale
        delta = converted_scene().delta
        (made,) = [item for item in delta.changed if isinstance(item, Material)]
        surfaces.append(made.surface)
    np.testing.assert_allclose(passed(surfaces[0], 0.5), passed(surfaces[1], 0.005), rtol=1e-5)
