"""The look of measured materials in Blender: nodes that come with a file and go with it."""

import time

import bpy
import numpy as np
import pytest
from blender_scattering import add_paint
from scattering_models import ggx, lambert, schlick

from lumenray.blender_addon.scattering import look_nodes
from lumenray.blender_addon.scattering.files import scattering_files
from lumenray.engine.scattering.data.resampling import resample
from lumenray.engine.scattering.look import Look

pytestmark = pytest.mark.usefixtures("extension")


def shader_of(material, engine="EEVEE"):
    """What an engine shows of a material."""
    return material.node_tree.get_output_node(engine).inputs["Surface"].links[0].from_node


def appearance_of(material):
    """Everything about a material that Blender itself draws by."""
    nodes = {
        node.name: [
            tuple(socket.default_value)
            if hasattr(socket.default_value, "__len__")
            else socket.default_value
            for socket in node.inputs
            if hasattr(socket, "default_value")
        ]
        for node in material.node_tree.nodes
    }
    links = {
        (link.from_node.name, link.to_node.name, link.to_socket.name)
        for link in material.node_tree.links
    }
    shown = {
        engine: material.node_tree.get_output_node(engine).name for engine in ("EEVEE", "CYCLES")
    }
    viewport = (tuple(material.diffuse_color), material.metallic, material.roughness)
    return nodes, links, shown, viewport


def glossy_file(write_scattering):
    made = resample(
        lambda wi, wo: lambert(0.3)(wi, wo) + ggx(0.09, schlick)(wi, wo),
        [550.0],
        incidences=np.radians([0.0, 8.0, 30.0, 60.0]),
    )
    return write_scattering(front_reflection=made)


def test_opening_a_file_gives_a_plain_material_its_look(write_scattering):
    paint = add_paint()
    bpy.ops.lumenray.load_scattering_file(filepath=glossy_file(write_scattering))
    inputs = shader_of(paint).inputs
    assert inputs["Roughness"].default_value == pytest.approx(0.3, abs=0.03)
    assert inputs["Base Color"].default_value[1] == pytest.approx(0.3 / 0.96, abs=0.02)
    assert inputs["IOR"].default_value == pytest.approx(1.5, abs=0.05)
    assert inputs["Metallic"].default_value == 0.0
    assert paint.roughness == pytest.approx(0.3, abs=0.03)
    assert paint.diffuse_color[1] == pytest.approx(0.3 / 0.96, abs=0.02)


def test_a_material_gets_its_own_nodes_and_values_back_when_the_override_is_off(
    write_scattering, tree
):
    add_paint()
    paint = tree.material
    bpy.context.object.data.materials[0] = paint
    noise = tree.add("TexNoise")
    tree.surface(tree.add("BsdfPrincipled", Base_Color=noise.outputs["Color"], Roughness=0.9))
    # An output for one engine alone, and one that does not count.
    for target in ("CYCLES", "ALL"):
        tree.add("OutputMaterial").target = target
    paint.diffuse_color, paint.metallic, paint.roughness = (0.1, 0.2, 0.3, 1.0), 0.7, 0.6
    before = appearance_of(paint)
    bpy.ops.lumenray.load_scattering_file(filepath=glossy_file(write_scattering))
    assert bpy.ops.lumenray.fit_scattering_look() == {"FINISHED"}
    for engine in ("EEVEE", "CYCLES"):
        assert shader_of(paint, engine).inputs["Roughness"].default_value == pytest.approx(
            0.3, abs=0.03
        )
    assert paint.roughness == pytest.approx(0.3, abs=0.03)
    paint.lumenray.use_override = False
    assert appearance_of(paint) == before
    # And the look comes back with the override.
    paint.lumenray.use_override = True
    while scattering_files._shelf.timer() is not None:
        time.sleep(0.01)
    assert shader_of(paint).inputs["Roughness"].default_value == pytest.approx(0.3, abs=0.03)
    paint.lumenray.model = "DIFFUSE"
    assert appearance_of(paint) == before


def test_a_diffuser_gets_a_translucent_shader_and_loses_it_again():
    paint = add_paint()
    count = len(paint.node_tree.nodes)
    sheet = Look((0.4,) * 3, translucency=0.75, translucent_colour=(0.8,) * 3)
    for _ in range(2):
        look_nodes.show_look(paint, sheet)
    assert len(paint.node_tree.nodes) == count + 3
    mix = shader_of(paint)
    assert mix.inputs[0].default_value == 0.75
    assert [mix.inputs[k].links[0].from_node.bl_idname for k in (1, 2)] == [
        "ShaderNodeBsdfPrincipled",
        "ShaderNodeBsdfTranslucent",
    ]
    look_nodes.show_look(paint, Look((0.4,) * 3))
    assert shader_of(paint).bl_idname == "ShaderNodeBsdfPrincipled"
    assert len(paint.node_tree.nodes) == count + 1


def test_a_material_without_nodes_that_can_be_used_gets_some():
    paint = add_paint()
    if bpy.app.version < (5, 0, 0):
        paint.use_nodes = False
    else:
        paint.node_tree.nodes.clear()
    look_nodes.show_look(paint, Look((0.4,) * 3, roughness=0.2))
    assert shader_of(paint).bl_idname == "ShaderNodeBsdfPrincipled"
    look_nodes.hide_look(paint)
    if bpy.app.version < (5, 0, 0):
        assert not paint.use_nodes
    else:
        assert not paint.node_tree.nodes
