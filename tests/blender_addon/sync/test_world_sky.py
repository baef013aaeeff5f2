"""Skies of the CIE in Blender's world: what is converted, what edits send, what is measured and rendered."""

import math

import bpy
import numpy as np
import pytest
from blender_skies import add_sun, compass, measure_sky, rotation_of
from conversion import converted_scene
from kept_scenes import KeptScene
from random_edits import remember
from rendered_frames import note_frames

from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.scene.light import CieSky, UniformWorld
from lumenray.engine.scene.scene import Scene
from lumenray.engine.scene.spectrum import Daylight

SIDES = {"north": (0, 1, 0), "east": (1, 0, 0), "south": (0, -1, 0), "west": (-1, 0, 0)}
"""Where upright sensors look."""


def converted_world():
    found = [i for i in converted_scene().delta.changed if isinstance(i, CieSky | UniformWorld)]
    return found[0] if found else None


def test_the_default_leaves_the_world_to_its_nodes(world):
    world.lumenray.property_unset("source")
    assert world.lumenray.source == "NODES"
    background = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    world.lumenray.sky.illuminance = 123.0
    add_sun()
    made = converted_world()
    assert isinstance(made, UniformWorld)
    assert made.luminance == pytest.approx(177.83, rel=1e-6)


def test_a_new_sky_is_overcast_with_ten_thousand_lux(world):
    sky = converted_world()
    assert (sky.type, sky.illuminance) == (16, 10000.0)
    assert sky.ground_reflectance == pytest.approx(0.2)
    assert sky.spectrum == Daylight(6500.0)
    assert sky.id == f"world:{world.lumenray.uid}"


def test_every_setting_is_taken_over(world):
    settings = world.lumenray.sky
    settings.illuminance = 8000.0
    settings.ground_reflectance = 0.35
    settings.colour_temperature = 9000.0
    settings.elevation, settings.azimuth = math.radians(35), math.radians(250)
    for number in range(1, 17):
        settings.type = str(number)
        sky = converted_world()
        assert sky.type == number
        assert sky.illuminance == 8000.0
        assert sky.ground_reflectance == pytest.approx(0.35)
        assert sky.spectrum == Daylight(9000.0)
        if number not in {1, 3, 5, 16}:
            np.testing.assert_allclose(sky.towards_sun, compass(35, 250), atol=1e-6)
    settings.illuminance = 0.0
    assert converted_world() is None


def test_the_settings_stay_where_they_have_a_meaning(world):
    settings = world.lumenray.sky
    settings.colour_temperature = 1000.0
    assert settings.colour_temperature == 4000.0
    settings.colour_temperature = 1e6
    assert settings.colour_temperature == 25000.0
    settings.elevation = math.radians(100)
    assert settings.elevation == pytest.approx(math.radians(90))
    settings.ground_reflectance = 2.0
    assert settings.ground_reflectance == 1.0


@pytest.mark.parametrize("place", [(20, 0), (35, 90), (60, 200), (5, 310)], ids=str)
def test_the_sun_light_says_where_the_sun_stands(world, place):
    world.lumenray.sky.type = "12"
    # Nothing but its direction counts.
    add_sun(rotation=rotation_of(*place), power=0.0).location = (3, 4, 5)
    np.testing.assert_allclose(converted_world().towards_sun, compass(*place), atol=1e-6)


def test_the_first_visible_sun_light_by_name_counts(world):
    world.lumenray.sky.type = "12"
    add_sun("Sun B", rotation_of(20, 90))
    first = add_sun("Sun A", rotation_of(30, 180))
    np.testing.assert_allclose(converted_world().towards_sun, compass(30, 180), atol=1e-6)
    first.hide_render = True
    np.testing.assert_allclose(converted_world().towards_sun, compass(20, 90), atol=1e-6)
    world.lumenray.sky.use_sun_lamp = False
    np.testing.assert_allclose(converted_world().towards_sun, compass(45, 180), atol=1e-6)


def test_a_sun_below_the_horizon_is_reported(world):
    world.lumenray.sky.type = "12"
    sun = add_sun(rotation=rotation_of(-10, 90))
    assert any("below the horizon" in row.message for row, _ in converted_scene().report.rows)
    np.testing.assert_allclose(converted_world().towards_sun, compass(0, 90), atol=1e-6)
    sun.rotation_euler = (math.pi, 0.0, 0.0)
    np.testing.assert_allclose(converted_world().towards_sun[2], 0.0, atol=1e-6)
    world.lumenray.sky.type = "16"
    assert not any("below the horizon" in row.message for row, _ in converted_scene().report.rows)


def test_settings_survive_saving(world, tmp_path):
    settings = world.lumenray.sky
    settings.type, settings.illuminance, settings.use_sun_lamp = "13", 7000.0, False
    settings.elevation, settings.azimuth = math.radians(25), math.radians(100)
    settings.ground_reflectance, settings.colour_temperature = 0.1, 5500.0
    before = converted_world()
    path = str(tmp_path / "sky.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, check_existing=False)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    after = converted_world()
    assert (after.id, after.type, after.illuminance) == (before.id, 13, 7000.0)
    assert after.ground_reflectance == before.ground_reflectance
    assert after.spectrum == Daylight(5500.0)
    np.testing.assert_array_equal(after.towards_sun, before.towards_sun)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("type", "13"),
        ("illuminance", 500.0),
        ("use_sun_lamp", False),
        ("ground_reflectance", 0.5),
        ("colour_temperature", 5000.0),
    ],
)
def test_an_edited_setting_sends_the_sky(world, name, value):
    world.lumenray.sky.type = "12"
    add_sun(rotation=rotation_of(20, 90))
    kept = KeptScene.started()
    setattr(world.lumenray.sky, name, value)
    assert kept.sent() == (["CieSky"], 0)
    setattr(world.lumenray.sky, name, value)
    assert kept.sent() == ([], 0)


def test_angles_send_the_sky_where_they_count(world):
    settings = world.lumenray.sky
    kept = KeptScene.started()
    settings.elevation = math.radians(30)
    assert kept.sent() == ([], 0)
    settings.type = "12"
    assert kept.sent() == (["CieSky"], 0)
    settings.elevation = math.radians(20)
    assert kept.sent() == (["CieSky"], 0)
    settings.azimuth = math.radians(20)
    assert kept.sent() == (["CieSky"], 0)
    add_sun()
    assert sorted(kept.sent()[0]) == ["CieSky", "SunLight"]
    settings.azimuth = math.radians(40)
    assert kept.sent() == ([], 0)


def test_the_sky_follows_the_sun_light(world):
    world.lumenray.sky.type = "12"
    sun = add_sun(rotation=rotation_of(20, 90))
    kept = KeptScene.started()
    sun.rotation_euler = rotation_of(40, 120)
    assert sorted(kept.sent()[0]) == ["CieSky", "SunLight"]
    sun.location.x = 5.0
    assert kept.sent()[0] in ([], ["SunLight"])
    sun.data.energy = 0.0
    assert kept.sent() == (["SunLight"], 0)
    sun.rotation_euler = rotation_of(50, 120)
    assert "CieSky" in kept.sent()[0]
    np.testing.assert_allclose(kept.scene.world.towards_sun, compass(50, 120), atol=1e-6)
    other = add_sun("Zenith", power=0.0)
    assert kept.sent() == ([], 0)
    # Now the other one is the first.
    other.name = "A"
    assert kept.sent() == (["CieSky"], 0)
    np.testing.assert_allclose(kept.scene.world.towards_sun, (0, 0, 1), atol=1e-6)
    other.hide_set(True)
    assert kept.sent() == (["CieSky"], 0)
    bpy.data.objects.remove(sun)
    assert kept.sent()[0] == ["CieSky"]
    np.testing.assert_allclose(kept.scene.world.towards_sun, compass(45, 180), atol=1e-6)


def test_a_sun_light_does_not_send_a_sky_that_is_even_all_around(world):
    sun = add_sun(rotation=rotation_of(20, 90))
    kept = KeptScene.started()
    sun.rotation_euler = rotation_of(40, 120)
    assert kept.sent() == (["SunLight"], 0)


def test_nodes_and_sky_take_turns(world):
    kept = KeptScene.started()
    background = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Strength"].default_value = 3.0
    assert kept.sent() == ([], 0)
    world.lumenray.source = "NODES"
    assert kept.sent() == (["UniformWorld"], 0)
    world.lumenray.source = "CIE"
    assert kept.sent() == (["CieSky"], 0)


def test_undo_and_redo_reach_the_engine(world):
    remember("start")
    kept = KeptScene.started()
    world.lumenray.sky.type = "12"
    bpy.context.view_layer.update()
    remember("type")
    kept.sent()
    bpy.ops.ed.undo()
    assert kept.sent() == (["CieSky"], 0)
    assert kept.scene.world.type == 16
    bpy.ops.ed.redo()
    assert kept.sent() == (["CieSky"], 0)
    assert kept.scene.world.type == 12


def test_the_sun_can_be_animated(world):
    settings = world.lumenray.sky
    settings.type = "12"
    for frame, height in ((1, 10.0), (21, 50.0)):
        settings.elevation = math.radians(height)
        settings.keyframe_insert("elevation", frame=frame)
    bpy.context.scene.frame_set(1)
    kept = KeptScene.started()
    np.testing.assert_allclose(kept.scene.world.towards_sun, compass(10, 180), atol=1e-6)
    bpy.context.scene.frame_set(21)
    assert kept.sent() == (["CieSky"], 0)
    np.testing.assert_allclose(kept.scene.world.towards_sun, compass(50, 180), atol=1e-6)


@pytest.mark.parametrize("kind", [1, 5, 12, 16])
def test_a_horizontal_plane_gets_the_stated_illuminance(world, session, kind):
    settings = world.lumenray.sky
    settings.type, settings.illuminance = str(kind), 4321.0
    settings.elevation, settings.azimuth = math.radians(35), math.radians(70)
    value, error = measure_sky(session, [(0, 0, 1), (0, 0, -1)])
    assert error[0] < 0.01 * 4321.0
    assert abs(value[0] - 4321.0) < 4 * error[0] + 1e-3 * 4321.0
    # A ground of reflectance 0.2 lights the other side.
    assert abs(value[1] - 0.2 * 4321.0) < 4 * error[1] + 1e-3 * 4321.0


@pytest.mark.parametrize("by_lamp", [False, True])
@pytest.mark.parametrize(("side", "azimuth"), [("north", 0), ("east", 90), ("south", 180)])
def test_the_side_towards_the_sun_gets_most(world, session, side, azimuth, by_lamp):
    settings = world.lumenray.sky
    settings.type = "12"
    if by_lamp:
        add_sun(rotation=rotation_of(30, azimuth), power=0.0)
    else:
        settings.elevation, settings.azimuth = math.radians(30), math.radians(azimuth)
    value, error = measure_sky(session, list(SIDES.values()), 1 << 11)
    by_side = dict(zip(SIDES, value, strict=True))
    assert max(by_side, key=by_side.get) == side
    # By the symmetry of the clear sky its flanks get the same.
    flanks = [i for i, axis in enumerate(SIDES.values()) if np.dot(axis, SIDES[side]) == 0]
    assert abs(value[flanks[0]] - value[flanks[1]]) < 4 * np.hypot(*error[flanks])
    assert by_side[side] > 1.5 * value[flanks].max()


def test_f12_shows_the_sky(extension, world, tmp_path):
    """Looking straight up at a uniform sky: its luminance is illuminance over pi."""
    world.lumenray.sky.type, world.lumenray.sky.illuminance = "5", 1000.0
    camera = bpy.data.cameras.new("Eye")
    eye = bpy.data.objects.new("Eye", camera)
    eye.rotation_euler = (math.pi, 0.0, 0.0)
    scene = bpy.context.scene
    scene.collection.objects.link(eye)
    scene.camera, scene.render.engine = eye, "LUMENRAY"
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.lumenray.render.samples = 16
    scene.lumenray.white_luminance = 1000.0 / math.pi
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = str(tmp_path / "up.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = np.array(image.pixels[:], np.float32).reshape(8, 8, -1)[..., :3]
    assert pixels @ (0.2126, 0.7152, 0.0722) == pytest.approx(1.0, rel=0.02)


def test_the_frames_of_a_render_have_the_animated_sun(world, tmp_path):
    settings = world.lumenray.sky
    settings.type = "12"
    for frame, height in ((1, 10.0), (21, 50.0)):
        settings.elevation = math.radians(height)
        settings.keyframe_insert("elevation", frame=frame)

    def sun(depsgraph):
        scene = Scene()
        scene.apply(SceneSync(final=True).walk(depsgraph).delta)
        return scene.world.towards_sun

    suns = note_frames(sun, (1, 21, 20), tmp_path)
    np.testing.assert_allclose(suns, [compass(10, 180), compass(50, 180)], atol=1e-6)
