"""Tasks of a render farm: jobs compiled by Flamenco's script, and done by hand in Blender's Python module."""

import csv

import bpy
import pytest
from flamenco import BAKE, RENDER, compile_job, do_in_bpy

from lumenray.blender_addon.farm import tasks, words
from lumenray.engine.errors import LumenrayError
from lumenray.libraries.scenes import scene_path


@pytest.fixture
def box(tmp_path):
    """A file with the closed box, in a folder with an odd name; its pictures are small."""
    bpy.ops.wm.open_mainfile(filepath=str(scene_path("closed_box")))
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.render.resolution_percentage = 100
    folder = tmp_path / "a b'c ö"
    folder.mkdir()
    path = folder / "box.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def table(path):
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_words_are_read_or_refused():
    readers = {"frames": words.read_frames, "error": float, "part": str}
    read = words.read_words(
        readers, ["blender", "--", "/out", "frames=1..3,7", "error=0.5", "part=a", "part=b=c"]
    )
    assert str(read.folder) == "/out"
    assert read.values == {"frames": (1, 2, 3, 7), "error": 0.5}
    assert read.parts == ("a", "b=c")
    for argv, fault in (
        (["blender"], "names no folder"),
        (["--", "/out", "colour=1"], "expected one of frames, error, part"),
        (["--", "/out", "error=much"], "could not convert"),
        (["--", "/out", "frames=1..99999999"], "more than 1000000 frames"),
    ):
        with pytest.raises(LumenrayError, match=fault):
            words.read_words(readers, argv)


@pytest.mark.slow
def test_an_animation_done_by_hand_has_all_frames_and_their_errors(box):
    settings = RENDER | {
        "blendfile": str(box),
        "scene": bpy.context.scene.name,
        "render_output_path": str(box.parent / "out {timestamp}" / "######"),
    }
    done = compile_job("render", settings)["tasks"]
    for task in done:
        do_in_bpy(task["commands"][0])
    folder = box.parent / "out 2026-01-02_030405"
    rows = table(folder / tasks.FRAMES)
    assert [row["file"] for row in rows] == ["000001.png", "000002.png", "000003.png"]
    assert all((folder / row["file"]).stat().st_size for row in rows)
    assert {(row["unit"], row["goal"]) for row in rows} == {("cd/m2", "reached")}
    assert all(int(row["samples"]) >= 4 and float(row["relative_standard_error"]) > 0.0 for row in rows)  # fmt: skip
    # A frame that is lost is missed, and the others are in the table.
    (folder / "000002.png").unlink()
    with pytest.raises(LumenrayError, match=r"frames are missing in .*: 2"):
        do_in_bpy(done[-1]["commands"][0])
    assert [row["frame"] for row in table(folder / tasks.FRAMES)] == ["1", "3"]


@pytest.mark.slow
def test_a_frame_that_is_not_rendered_fails_its_task(box):
    bpy.context.scene.camera = None
    for camera in list(bpy.data.cameras):
        bpy.data.cameras.remove(camera)
    bpy.ops.wm.save_as_mainfile(filepath=str(box))
    settings = RENDER | {
        "blendfile": str(box),
        "scene": bpy.context.scene.name,
        "render_output_path": str(box.parent / "out" / "######"),
    }
    with pytest.raises(LumenrayError, match="frame 1 was not rendered to"):
        do_in_bpy(compile_job("render", settings)["tasks"][0]["commands"][0])


@pytest.mark.slow
def test_a_bake_done_by_hand_has_a_table_of_all_maps(box):
    scene = bpy.context.scene
    for name in ("Ground", "More"):
        collection = bpy.data.collections.new(name)
        scene.collection.children.link(collection)
        collection.objects.link(bpy.data.objects["Floor"])
    bpy.ops.wm.save_as_mainfile(filepath=str(box))
    settings = BAKE | {
        "blendfile": str(box), "scene": scene.name, "collections": "Ground, More", "stop": "samples", "samples": 16,
        "density": 4.0, "bake_output_path": str(box.parent / "maps"),
    }  # fmt: skip
    done = compile_job("bake", settings)["tasks"]
    do_in_bpy(done[0]["commands"][0])
    # Nothing is said of what is not there yet.
    with pytest.raises(LumenrayError, match=r"bakes are missing in .*: 2_More"):
        do_in_bpy(done[2]["commands"][0])
    do_in_bpy(done[1]["commands"][0])
    do_in_bpy(done[2]["commands"][0])
    rows = table(box.parent / "maps" / tasks.MAPS)
    assert [(row["part"], row["name"], row["unit"]) for row in rows] == [
        ("1_Ground", "Floor", "lx"),
        ("2_More", "Floor", "lx"),
    ]
    assert rows[0]["mean"] == rows[1]["mean"]
    assert float(rows[0]["mean_standard_error"]) < float(rows[0]["mean"])


def test_a_bake_of_what_is_not_there_is_refused(box):
    settings = BAKE | {
        "blendfile": str(box),
        "scene": bpy.context.scene.name,
        "collections": "Nowhere",
    }
    with pytest.raises(LumenrayError, match="has no collection named Nowhere"):
        do_in_bpy(compile_job("bake", settings)["tasks"][0]["commands"][0])
