"""Folders of bakes: nothing in them is lost, whoever bakes into them again."""

from pathlib import Path

import bpy
import pytest
from blender_bakes import bake_all, baked
from blender_objects import add_quad
from panels import context, draw, interface

from lumenray.blender_addon.bake import folders as bake_folders

pytestmark = pytest.mark.usefixtures("extension")


def written(monkeypatch, fake_engine):
    """Have the fake engine leave a page in the folder, and return where."""
    real, folders = fake_engine.bake_objects, []

    def bake_objects(order, progress=None):
        folder = Path(order.folder)
        (folder / "illuminance.1001.exr").write_text(str(order.density))
        folders.append(folder)
        return real(order, progress)

    monkeypatch.setattr(fake_engine, "bake_objects", bake_objects)
    return folders


def test_files_of_one_folder_have_bakes_of_their_own(fake_engine, tmp_path, monkeypatch):
    folders = written(monkeypatch, fake_engine)
    add_quad("Floor")
    for name in ("office", "shop"):
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / f"{name}.blend"))
        bake_all()
    assert folders == [tmp_path / "lux_office", tmp_path / "lux_shop"]


def test_results_of_other_settings_are_not_overwritten_unasked(fake_engine, tmp_path, monkeypatch):
    folders = written(monkeypatch, fake_engine)
    add_quad("Floor")
    settings = bpy.context.scene.lumenray
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "office.blend"))
    bake_all(density=5.0)
    bake_all(density=7.0)
    # The same again takes its own place.
    bake_all(density=5.0)
    # A coarser end is another setting: hours of work must not go for it.
    bake_all(density=5.0, error=0.5)
    first = tmp_path / "lux_office"
    assert folders == [first, tmp_path / "lux_office_2", first, tmp_path / "lux_office_3"]
    assert (first / "illuminance.1001.exr").read_text() == "5.0"
    settings.bake.overwrite = True
    bake_all(density=9.0)
    assert folders[-1] == first
    assert baked().folder == str(first)


def test_results_of_another_scene_or_of_unknown_origin_are_not_overwritten(
    fake_engine, tmp_path, monkeypatch
):
    folders = written(monkeypatch, fake_engine)
    floor = add_quad("Floor")
    bpy.context.scene.lumenray.bake.folder = "//lux"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "office.blend"))
    bake_all()
    other = bpy.data.scenes.new("Evening")
    other.collection.objects.link(floor)
    other.lumenray.bake.folder = "//lux"
    with bpy.context.temp_override(scene=other, view_layer=other.view_layers[0]):
        assert bpy.ops.lumenray.bake_illuminance(objects="Floor") == {"FINISHED"}
    # Left by a version that did not say whose it is.
    old = tmp_path / "lux_3"
    old.mkdir()
    (old / "illuminance.1001.exr").write_bytes(b"")
    bake_all(density=3.0)
    assert folders == [tmp_path / "lux", tmp_path / "lux_2", tmp_path / "lux_4"]


def test_an_interrupted_bake_of_other_settings_is_not_forgotten(fake_engine, tmp_path, monkeypatch):
    folders = written(monkeypatch, fake_engine)
    add_quad("Floor")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "office.blend"))
    bake_all(density=5.0)
    kept = folders[0] / bake_folders.CHECKPOINT
    kept.write_bytes(b"state")
    bake_all(density=7.0)
    assert kept.exists()
    bpy.ops.lumenray.bake_illuminance(objects="Floor", density=5.0, error=0.3, resume=True)
    assert folders[-1] == folders[0]
    assert kept.exists()


def test_a_file_that_was_never_saved_writes_to_the_temporary_folder_and_says_so(
    fake_engine, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    folders = written(monkeypatch, fake_engine)
    add_quad("Floor")
    for text in ("", "//lux", "lux"):
        bpy.context.scene.lumenray.bake.folder = text
        bake_all()
    assert all(folder.is_relative_to(bpy.app.tempdir) for folder in folders)
    assert list(tmp_path.iterdir()) == []
    assert bake_folders.is_temporary(folders[0])
    with interface():
        seen = " ".join(draw("LUMENRAY_PT_lux_bake_output", context()))
    assert "temporary folder" in seen


def test_hostile_claims_are_read_as_none(tmp_path):
    for content in (b"", b"[" * 70000, b'{"settings": 3}', b"\xff\xfe", b"[]"):
        (tmp_path / bake_folders.CLAIM).write_bytes(content)
        assert bake_folders._read_claim(tmp_path) in (None, 3)
