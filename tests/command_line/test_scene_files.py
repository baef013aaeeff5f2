"""The commands `lumenray scene …`: files taken over and changed by name."""

import json

import bpy
import pytest
from commands import run_command

from lumenray.libraries import scenes

pytestmark = pytest.mark.usefixtures("extension")


def test_a_file_is_taken_over_with_its_content_and_edited(tmp_path, capsys):
    taken, content = tmp_path / "taken.blend", tmp_path / "content.json"
    source = scenes.scene_path("inverse_square")
    code, _, _ = run_command("scene", capsys, "take", source, "-o", taken, "--content", content)
    assert code == 0
    told = json.loads(content.read_text())
    point = {"name": "Point", "amount": 100.0, "unit": "lm", "count": 1, "is_on": True}
    assert told["lights"] == [point]
    edits, edited = tmp_path / "edits.json", tmp_path / "edited.blend"
    edits.write_text('{"lights": {"Point": {"flux": 250}}}')
    code, _, _ = run_command("scene", capsys, "edit", taken, "--edits", edits, "-o", edited)
    assert code == 0
    code, _, _ = run_command(
        "scene", capsys, "take", edited, "-o", taken, "--content", content, "--force"
    )
    assert json.loads(content.read_text())["lights"][0]["amount"] == 250.0


def test_gltf_files_are_taken_over(tmp_path, capsys):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.name = "Block"
    path = tmp_path / "room.glb"
    bpy.ops.export_scene.gltf(filepath=str(path))
    taken, content = tmp_path / "taken.blend", tmp_path / "content.json"
    code, _, _ = run_command("scene", capsys, "take", path, "-o", taken, "--content", content)
    assert code == 0
    assert json.loads(content.read_text())["surfaces"] == ["Block"]


@pytest.mark.parametrize("content", [b"glTF", b"glTF\x02\0\0\0\xff\xff\xff\xff", b"{}", b""])
def test_broken_gltf_files_are_refused_in_a_sentence(tmp_path, capsys, content):
    path = tmp_path / "room.glb"
    path.write_bytes(content)
    code, _, told = run_command("scene", capsys, "take", path, "-o", tmp_path / "taken.blend")
    assert code == 1
    assert "Blender cannot read this glTF file" in told
    assert len(told.splitlines()) == 1
    assert not (tmp_path / "taken.blend").exists()


def test_files_that_need_others_are_refused(tmp_path, capsys):
    image = bpy.data.images.new("Wood", 2, 2)
    image.source, image.filepath = "FILE", str(tmp_path / "wood.png")
    image.use_fake_user = True
    path = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    code, _, told = run_command("scene", capsys, "take", path, "-o", tmp_path / "taken.blend")
    assert code == 1
    assert "wood.png" in told
    assert "pack" in told


def test_edits_that_do_not_fit_are_refused(tmp_path, capsys):
    edits = tmp_path / "edits.json"
    edits.write_text('{"hidden": ["Nobody"]}')
    source = scenes.scene_path("inverse_square")
    code, _, told = run_command(
        "scene", capsys, "edit", source, "--edits", edits, "-o", tmp_path / "out.blend"
    )
    assert code == 1
    assert "no object 'Nobody'" in told
