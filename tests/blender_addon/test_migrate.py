"""Files that earlier versions saved open with everything in place."""

import json
import re
import types
from pathlib import Path

import bpy
import pytest

from lumenray.blender_addon import migrate
from lumenray.blender_addon.foundation import open_file

SAVED = Path(__file__).parent / "saved_files"
"""Files of version 1, in which every setting was set to something that is not its default, and what that was."""


def read(path: str):
    """Return what the open file says of a setting, by where it stood: ``scenes['x'].lumenray.bake_size``."""
    blocks, key, place = re.fullmatch(r"(\w+)\['(.+)'\]\.lumenray\.(.+)", path).groups()
    name = re.match(r"\w+", place)[0]
    if blocks == "scenes":
        place = migrate.MOVED.get(name, name) + place.removeprefix(name)
    value = getattr(bpy.data, blocks)[key].lumenray.path_resolve(place)
    if hasattr(value, "__len__") and not isinstance(value, str | set):
        return list(value)
    return sorted(value) if isinstance(value, set) else value


def same(wanted, found) -> bool:
    """Whether a value is the one that was saved, as single precision keeps it."""
    if isinstance(wanted, float | list):
        return found == pytest.approx(wanted, rel=1e-6)
    return found == wanted


def differences(wanted: dict) -> dict:
    """Return what is other than it was, by path."""
    found = {path: read(path) for path in wanted}
    return {
        path: (wanted[path], found[path]) for path in wanted if not same(wanted[path], found[path])
    }


@pytest.mark.parametrize("name", ["lights", "bake", "materials"])
def test_a_file_of_version_1_opens_with_everything_in_place(name, tmp_path):
    wanted = json.loads((SAVED / f"{name}.json").read_text(encoding="utf-8"))
    bpy.ops.wm.open_mainfile(filepath=str(SAVED / f"{name}.blend"))
    assert differences(wanted) == {}
    again = tmp_path / "again.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(again))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(again))
    assert differences(wanted) == {}


def test_what_was_carried_over_does_not_come_back():
    bpy.ops.wm.open_mainfile(filepath=str(SAVED / "bake.blend"))
    bpy.context.scene.lumenray.bake.density = 33.0
    migrate.migrate()
    assert bpy.context.scene.lumenray.bake.density == 33.0
    assert not migrate.MOVED.keys() & set(migrate._stored(bpy.context.scene).keys())


def test_where_an_older_version_saved_a_file_again_its_values_win():
    """It knows nothing of the groups, and what it writes stands where it always did."""
    bpy.ops.wm.open_mainfile(filepath=str(SAVED / "bake.blend"))
    scene = bpy.context.scene
    stored = migrate._stored(scene)
    stored["bake_density"] = 21.0
    stored["baked_layers"] = [{"name": "Lamps", "strength": 0.5}]
    migrate.migrate()
    assert scene.lumenray.bake.density == 21.0
    assert [(row.name, row.strength) for row in scene.lumenray.look.layers] == [("Lamps", 0.5)]


@pytest.mark.skipif(
    not hasattr(bpy.app.handlers, "blend_import_post"), reason="Blender before 4.3 does not tell"
)
@pytest.mark.parametrize("link", [False, True])
def test_scenes_that_are_appended_or_linked_bring_their_settings(link):
    call = bpy.ops.wm.link if link else bpy.ops.wm.append
    call(filename="Second", directory=f"{SAVED / 'bake.blend'}/Scene/")
    (scene,) = (each for each in bpy.data.scenes if each.name.startswith("Second"))
    assert scene.lumenray.bake.density == 10.125


def test_switched_on_with_a_file_open_the_add_on_carries_its_settings_over(monkeypatch):
    """Blender shows an add-on no data while it switches it on."""
    waiting = []
    timers = types.SimpleNamespace(
        is_registered=waiting.__contains__,
        register=lambda function, first_interval: waiting.append(function),
        unregister=waiting.remove,
    )
    hidden = types.SimpleNamespace(
        data=object(), app=types.SimpleNamespace(timers=timers, handlers=bpy.app.handlers)
    )
    scene = bpy.context.scene
    migrate._stored(scene)["bake_density"] = 21.0
    monkeypatch.setattr(open_file, "bpy", hidden)
    migrate.detach()
    migrate.attach()
    (soon,) = waiting
    soon()
    assert scene.lumenray.bake.density == 21.0
    migrate.detach()
    assert not waiting
    migrate.attach()


@pytest.mark.parametrize("event", ["undo_post", "redo_post"])
def test_undo_brings_no_setting_back_to_where_it_stood(event):
    """The step before the add-on was switched on has the file as it was."""
    scene = bpy.context.scene
    migrate._stored(scene)["bake_density"] = 21.0
    for handler in getattr(bpy.app.handlers, event):
        if handler.__module__ == migrate.__name__:
            handler(scene)
    assert scene.lumenray.bake.density == 21.0


def test_settings_of_groups_are_carried_over_with_their_animation():
    scene = bpy.context.scene
    scene.lumenray.render.use_denoising = False
    # A group is stored once one of its settings was set.
    migrate._stored(scene)["render"]["use_smoothing"] = True
    scene.lumenray.render.keyframe_insert("use_denoising", frame=1)
    (curve,) = migrate._curves(scene.animation_data.action)
    curve.data_path = "lumenray.render.use_smoothing"
    migrate.migrate()
    assert scene.lumenray.render.use_denoising
    assert "use_smoothing" not in migrate._stored(scene)["render"]
    assert curve.data_path == "lumenray.render.use_denoising"


def test_every_setting_stands_where_the_table_says():
    for place in migrate.MOVED.values():
        bpy.context.scene.lumenray.path_resolve(place)


def test_animation_and_drivers_follow():
    scene = bpy.context.scene
    scene.lumenray.bake.density = 8.0
    scene.lumenray.bake.keyframe_insert("density", frame=1)
    scene.lumenray.bake.density = 16.0
    scene.lumenray.bake.keyframe_insert("density", frame=11)
    (curve,) = migrate._curves(scene.animation_data.action)
    curve.data_path = "lumenray.bake_density"
    tree = bpy.data.node_groups.new("Look", "ShaderNodeTree")
    socket = tree.nodes.new("ShaderNodeValue").outputs[0]
    driver = socket.driver_add("default_value").driver
    target = driver.variables.new().targets[0]
    target.id_type, target.id = "SCENE", scene
    target.data_path = "lumenray.baked_high"
    migrate._stored(scene)["baked_high"] = 750.0
    migrate.migrate()
    assert curve.data_path == "lumenray.bake.density"
    assert target.data_path == "lumenray.look.high"
    assert scene.lumenray.look.high == 750.0
    scene.frame_set(6)
    assert scene.lumenray.bake.density == pytest.approx(12.0)


def test_a_scene_of_nothing_old_is_left_alone():
    scene = bpy.context.scene
    scene.lumenray.render.samples = 7
    migrate.migrate()
    assert scene.lumenray.render.samples == 7
