"""glTF files of bakes: on request, within limits, and no bake is lost for one."""

import json

import bpy
import pytest
from blender_bakes import bake_all
from blender_objects import add_quad
from fake_bakes import SIZE

pytestmark = pytest.mark.usefixtures("extension")


def test_a_gltf_file_that_cannot_be_written_costs_a_message_only(fake_engine, tmp_path, paint):
    floor = add_quad("Floor", material=paint)
    (tmp_path / "folder").write_text("no folder")
    bake_all(tmp_path, gltf=str(tmp_path / "folder" / "room.glb"))
    assert floor.lumenray.baked_image is not None
    rows = bpy.context.window_manager.lumenray.rows
    assert any("glTF file is not written" in row.remedy for row in rows)


def test_gltf_is_written_on_request(fake_engine, tmp_path, paint):
    add_quad("Floor", material=paint)
    add_quad("Wall", 2.0)
    bake_all(tmp_path, gltf=str(tmp_path / "room.glb"))
    data = (tmp_path / "room.glb").read_bytes()
    assert data[:4] == b"glTF"
    length = int.from_bytes(data[12:16], "little")
    content = json.loads(data[20 : 20 + length])
    assert {"Floor", "Wall"} <= {node.get("name") for node in content["nodes"]}
    assert content["images"]
    with pytest.raises(RuntimeError, match="glTF files end in"):
        bake_all(tmp_path, gltf=str(tmp_path / "room.obj"))


def test_the_textures_of_a_gltf_file_keep_to_the_limits(fake_engine, tmp_path, paint):
    add_quad("Floor", material=paint)
    settings = bpy.context.scene.lumenray
    settings.bake.gltf_textures, settings.bake.gltf_size = 2, SIZE // 2
    bake_all(tmp_path, gltf=str(tmp_path / "room.gltf"))
    content = json.loads((tmp_path / "room.gltf").read_text())
    pictures = [bpy.data.images.load(str(tmp_path / each["uri"])) for each in content["images"]]
    assert 1 <= len(pictures) <= 2
    assert max(max(picture.size) for picture in pictures) == SIZE // 2
    # Two looks do not fit into one texture.
    settings.bake.gltf_textures = 1
    bake_all(tmp_path, gltf=str(tmp_path / "other.gltf"))
    rows = bpy.context.window_manager.lumenray.rows
    assert any("allow more textures" in row.message for row in rows)
