"""The Sun light that follows place and time: in edits, frames, renders and undo, for all engines alike."""

import math

import bpy
import numpy as np
import pytest
from blender_skies import add_sun, new_sky
from kept_scenes import KeptScene
from rendered_frames import note_frames

from lumenray.blender_addon.daylight import following
from lumenray.blender_addon.daylight.moment import find_moment
from lumenray.blender_addon.daylight.readout import describe_sun
from lumenray.engine.photometry.colour import REC709_LUMINANCE
from lumenray.engine.photometry.light_colour import light_colour
from lumenray.engine.scene.light import Quantity, SunLight
from lumenray.engine.sky.air import standard_air
from lumenray.engine.sky.sunlight import direct_illuminance, sunlight_spectrum


@pytest.fixture
def world():
    """Return a world on a June morning in Berlin, which a Sun light follows."""
    world = new_sky()
    time = world.lumenray.time
    time.month, time.hour = 6, 10.0
    following.add_lamp(bpy.context.scene, None)
    bpy.context.view_layer.update()
    return world


def lamp():
    return bpy.data.objects["Sun"]


def towards(thing):
    return np.array(thing.matrix_world, float)[:3, 2]


def test_it_stands_where_the_sun_stands_after_every_edit(world):
    def check():
        bpy.context.view_layer.update()
        moment = find_moment(world, 1)
        np.testing.assert_allclose(towards(lamp()), moment.towards_sun, atol=1e-6)

    check()
    own = world.lumenray
    for group, name, value in (
        (own.time, "hour", 15.5),
        (own.time, "month", 12),
        (own.place, "city", "Cape Town, South Africa"),
        (own.place, "north", 1.0),
        (own.place, "longitude", 0.4),
        (own.time, "use_refraction", False),
        (own.time, "hour", 1.0),
    ):
        setattr(group, name, value)
        check()


def test_its_light_is_that_of_the_air_and_the_same_in_watts(world):
    moment = find_moment(world, 1)
    pressure = standard_air(30.0).pressure
    expected = direct_illuminance(moment.elevation, 3.0, moment.distance, pressure)
    light = lamp().data
    assert light.lumenray.value == pytest.approx(expected, rel=1e-5)
    assert light.angle == pytest.approx(math.radians(0.533), rel=1e-3)
    colour = light_colour(sunlight_spectrum(round(moment.elevation, 2), 3.0))
    np.testing.assert_allclose(light.color, colour, atol=1e-5)
    efficacy = bpy.context.scene.lumenray.efficacy
    assert light.energy * efficacy * (REC709_LUMINANCE @ light.color) == pytest.approx(
        expected, rel=1e-5
    )
    # What the engine gets is the same in both terms.
    sent = KeptScene.started().scene.lights
    (sun,) = [each for each in sent.values() if isinstance(each, SunLight)]
    assert sun.output.quantity is Quantity.ILLUMINANCE
    assert sun.output.value == pytest.approx(expected, rel=1e-5)
    spectrum = sunlight_spectrum(moment.elevation, 3.0)
    np.testing.assert_allclose(sun.output.spectrum.values, spectrum.values, rtol=1e-4, atol=1e-6)
    light.lumenray.use_physical = False
    (sun,) = [e for e in KeptScene.started().scene.lights.values() if isinstance(e, SunLight)]
    assert sun.output.value == pytest.approx(expected, rel=1e-4)
    bpy.context.scene.lumenray.efficacy = 100.0
    assert light.energy * 100.0 * (REC709_LUMINANCE @ light.color) == pytest.approx(
        expected, rel=1e-5
    )


def test_it_is_dark_at_night_and_as_stated_by_day(world):
    sun = world.lumenray.sun
    sun.amount, sun.illuminance = "GIVEN", 70000.0
    assert lamp().data.lumenray.value == 70000.0
    world.lumenray.time.hour = 1.0
    assert lamp().data.lumenray.value == 0.0
    assert lamp().data.energy == 0.0
    assert not [e for e in KeptScene.started().scene.lights.values() if isinstance(e, SunLight)]


def test_its_light_can_be_stated_of_a_horizontal_plane(world):
    sun = world.lumenray.sun
    sun.amount, sun.horizontal_illuminance = "HORIZONTAL", 50000.0
    height = math.radians(find_moment(world, 1).elevation)
    assert lamp().data.lumenray.value * math.sin(height) == pytest.approx(50000.0, rel=1e-5)
    # A low sun cannot give as much: no number is better than one of nature's beyond.
    world.lumenray.time.hour = 6.0
    assert lamp().data.lumenray.value == 0.0
    assert "outside the atmosphere" in describe_sun(world, bpy.context.scene).problem


def test_hazy_air_makes_the_sun_weaker_and_redder(world):
    light = lamp().data
    before, blue = light.lumenray.value, light.color[2]
    world.lumenray.sun.turbidity = 6.0
    assert light.lumenray.value < 0.8 * before
    assert light.color[2] < blue


def test_a_sun_light_that_is_there_can_be_taken_and_let_go(world):
    other = add_sun("Mine")
    other.data.energy = 3.0
    following.add_lamp(bpy.context.scene, other)
    bpy.context.view_layer.update()
    moment = find_moment(world, 1)
    np.testing.assert_allclose(towards(other), moment.towards_sun, atol=1e-6)
    assert describe_sun(world, bpy.context.scene).problem == ""
    world.lumenray.sun.lamp = None
    before = towards(other)
    world.lumenray.time.hour = 16.0
    bpy.context.view_layer.update()
    np.testing.assert_array_equal(towards(other), before)


def test_a_light_that_something_else_turns_is_told(world):
    lamp().rotation_euler = (0.0, 0.0, 0.0)
    assert "turned by something else" in describe_sun(world, bpy.context.scene).problem
    bpy.data.objects.remove(lamp())
    assert describe_sun(world, bpy.context.scene).problem == ""
    assert world.lumenray.sun.lamp is None


def test_the_frames_of_a_render_have_their_sun(world, tmp_path):
    """Also where the clock itself is animated; the world's sky goes with it."""
    own = world.lumenray
    own.sky.type, own.sky.use_place = "12", True
    own.time.follows_frames, own.time.minutes_per_frame = True, 60.0

    def note(depsgraph):
        from lumenray.blender_addon.sync.scene_sync import SceneSync
        from lumenray.engine.scene.scene import Scene

        scene = Scene()
        scene.apply(SceneSync(final=True).walk(depsgraph).delta)
        (sun,) = [each for each in scene.lights.values() if isinstance(each, SunLight)]
        return (*-sun.direction, *scene.world.towards_sun, sun.output.value)

    notes = np.array(note_frames(note, (1, 7, 3), tmp_path))
    expected = [find_moment(world, frame).towards_sun for frame in (1, 4, 7)]
    np.testing.assert_allclose(notes[:, :3], expected, atol=1e-6)
    np.testing.assert_allclose(notes[:, 3:6], expected, atol=1e-6)
    assert len(set(notes[:, 6])) == 3
    own.time.follows_frames = False
    for frame, hour in ((1, 8.0), (7, 17.0)):
        own.time.hour = hour
        own.time.keyframe_insert("hour", frame=frame)
    notes = np.array(note_frames(note, (1, 7, 6), tmp_path))
    for row, hour in zip(notes, (8.0, 17.0), strict=True):
        own.time.hour = hour
        np.testing.assert_allclose(row[:3], find_moment(world, 1).towards_sun, atol=1e-6)
        np.testing.assert_allclose(row[3:6], row[:3], atol=1e-6)


def test_a_kept_scene_follows_the_frames(world):
    own = world.lumenray
    own.sky.type, own.sky.use_place = "12", True
    own.time.follows_frames = True
    scene = bpy.context.scene
    scene.frame_set(1)
    kept = KeptScene.started()
    scene.frame_set(20)
    assert sorted(kept.sent()[0]) == ["CieSky", "SunLight"]
    np.testing.assert_allclose(kept.scene.world.towards_sun, find_moment(world, 20).towards_sun)
    scene.frame_set(20)
    assert kept.sent() == ([], 0)


def test_undo_and_redo_bring_the_sun_back(world):
    bpy.ops.ed.undo_push(message="start")
    before = tuple(lamp().rotation_euler)
    world.lumenray.time.hour = 17.0
    bpy.ops.ed.undo_push(message="hour")
    after = tuple(lamp().rotation_euler)
    assert before != after
    bpy.ops.ed.undo()
    assert tuple(lamp().rotation_euler) == before
    bpy.ops.ed.redo()
    assert tuple(lamp().rotation_euler) == after


def test_the_date_is_burnt_into_pictures_as_blenders_note(world, tmp_path):
    render = bpy.context.scene.render
    time = world.lumenray.time
    time.use_note = True
    assert render.use_stamp
    assert render.use_stamp_note
    assert not render.use_stamp_filename
    assert render.stamp_note_text == "Berlin  2026-06-21 10:00 UTC+02:00  sun 44.1°"
    time.follows_frames, time.minutes_per_frame = True, 60.0
    texts = note_frames(lambda depsgraph: render.stamp_note_text[8:24], (1, 3, 2), tmp_path)
    assert texts == ["2026-06-21 10:00", "2026-06-21 12:00"]
    time.use_note = False
    assert not render.use_stamp_note
    assert render.stamp_note_text == ""


def test_settings_and_sun_survive_saving(world, tmp_path):
    world.lumenray.time.hour = 16.25
    path = str(tmp_path / "sun.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, check_existing=False)
    before = tuple(lamp().rotation_euler)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    world = bpy.context.scene.world
    assert world.lumenray.sun.lamp == lamp()
    assert tuple(lamp().rotation_euler) == before
    world.lumenray.time.hour = 9.0
    assert tuple(lamp().rotation_euler) != before


def rows():
    from conversion import converted_scene

    return [row.text() for row, _ in converted_scene().report.rows]


def test_the_report_says_what_is_wrong_with_it(world):
    assert not any("Outside" in text for text in rows())
    thing, sun = lamp(), world.lumenray.sun
    thing.rotation_euler.x += 0.1
    bpy.context.view_layer.update()
    assert any("turned by something else" in text for text in rows())
    sun.amount = "WEATHER"
    assert any("sky is of none; its sun gives no light" in text for text in rows())
    sun.amount = "TURBIDITY"
    assert thing.data.lumenray.value > 0.0
    assert not any("Outside" in text for text in rows())
    world.lumenray.place.zone = "Nowhere"
    assert any("'Nowhere' is not known" in text for text in rows())
    assert thing.data.lumenray.value == 0.0
    assert thing.data.energy == 0.0
