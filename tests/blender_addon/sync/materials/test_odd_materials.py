"""Materials without an output, with circles, of older files: each is told, none stops a conversion."""

import os
from pathlib import Path

import bpy
import pytest
from conversion import messages_of

from lumenray.blender_addon.sync.materials.materials import default_material
from lumenray.engine.scene.material import Black, Diffuse, Material
from lumenray.engine.scene.spectrum import Constant

pytestmark = pytest.mark.blender

BLEND_FILES = os.environ.get("LUMENRAY_BLEND_FILES", "")
"""Folder of real files, old ones among them, that are too large to ship."""

LEGACY_FILES = sorted(Path(BLEND_FILES).glob("*.blend")) if BLEND_FILES else []


def test_mesh_without_material_is_blenders_grey():
    surface = default_material("none").surface
    assert surface.reflectance == Constant(0.8)
    if bpy.app.version < (5, 0, 0):
        assert surface == Diffuse(Constant(0.8))


def test_mesh_without_material_looks_as_in_cycles(tmp_path, registered):
    from lumenray.benchmarks.content import compare
    from lumenray.benchmarks.content.stage import Stage

    # The sun in line with the eye by way of the tile, where a coat would show.
    stage = Stage()
    stage.tile(None)
    stage.light("SUN", energy=3.0, turn=(1.2, 0.0, 0.0), angle=0.4)
    stage.camera((0.0, 4.0, 1.55), (1.2, 0.0, 3.14159), lens=120.0)
    made = compare.compare(tmp_path)
    assert abs(made.mean) < 0.02
    assert made.block < 0.03


def test_tree_without_output_is_black_and_reported(tree, convert):
    result, rows = convert(tree.material)
    assert result.surface == Black()
    assert "output" in messages_of(rows)


def test_output_without_surface_is_black_and_reported(tree, convert):
    tree.add("OutputMaterial")
    result, rows = convert(tree.material)
    assert result.surface == Black()
    assert len(rows) == 1


def test_volume_is_reported(tree, convert):
    material = tree.surface(tree.add("BsdfTransparent"))
    output = material.node_tree.get_output_node("CYCLES")
    links = material.node_tree.links
    links.new(tree.add("VolumeAbsorption").outputs[0], output.inputs["Volume"])
    _, rows = convert(material)
    assert "Absorption" in messages_of(rows)


def test_circle_of_shaders_ends_with_a_row(tree, convert):
    first, second = tree.add("AddShader"), tree.add("AddShader")
    tree.set(first, "Shader", second.outputs[0])
    tree.set(second, "Shader", first.outputs[0])
    result, rows = convert(tree.surface(first))
    assert result.surface == Black()
    assert "circle" in messages_of(rows)


def test_pass_index_is_kept(tree, convert):
    material = tree.surface(tree.add("BsdfDiffuse"))
    material.pass_index = 7
    assert convert(material)[0].index == 7


@pytest.mark.parametrize("path", LEGACY_FILES or [None], ids=lambda path: path and path.stem)
def test_materials_of_older_files_convert(path, convert, caplog):
    if path is None:
        pytest.skip("LUMENRAY_BLEND_FILES names no folder of .blend files")
    bpy.ops.wm.open_mainfile(filepath=str(path))
    for material in bpy.data.materials:
        if material.is_grease_pencil:
            continue
        result, rows = convert(material)
        assert isinstance(result, Material)
        assert all(row["message"] and row["instead"] for row in rows)
        assert "cannot be understood" not in messages_of(rows), caplog.text
