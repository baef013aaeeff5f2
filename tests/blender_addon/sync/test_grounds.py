"""Ground and photo of a world: what the engine gets, and what pictures of it are."""

import math

import bpy
import numpy as np
import pytest
from blender_objects import new_world
from conversion import converted_scene, messages_of

from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import Ground, UniformWorld
from lumenray.engine.scene.mesh import Placement
from lumenray.engine.session import Session
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.usefixtures("extension")


def ground():
    world, _ = new_world((1, 1, 1), 1.0)
    return world.lumenray.ground


def world_and_planes(made=None):
    made = converted_scene() if made is None else made
    (world,) = (item for item in made.delta.changed if isinstance(item, UniformWorld))
    return world, [item for item in made.delta.changed if isinstance(item, Placement)]


def camera(location=(0.0, -4.0, 2.0), tilt=70.0):
    data = bpy.data.cameras.new("Eye")
    item = bpy.data.objects.new("Eye", data)
    item.location, item.rotation_euler = location, (math.radians(tilt), 0.0, 0.0)
    scene = bpy.context.scene
    scene.collection.objects.link(item)
    scene.camera = item
    scene.render.resolution_x, scene.render.resolution_y = 24, 16
    return item


def photo(width=24, height=16, value=0.5):
    image = bpy.data.images.new("Photo", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    ramp = np.ones((height, width, 4), np.float32)
    ramp[..., :3] = value * (0.5 + np.arange(width)[None, :, None] / width)
    image.pixels.foreach_set(ramp.ravel())
    image.update()
    return image


def show(item, image):
    item.data.show_background_images = True
    entry = item.data.background_images.new()
    entry.image = image
    return entry


def test_a_ground_is_where_it_is_stated_in_metres_and_catches_shadows():
    settings = ground()
    assert world_and_planes() == (world_and_planes()[0], [])
    settings.use_ground = True
    settings.level, settings.camera_height, settings.radius = 0.5, 1.6, 20.0
    settings.centre = (3.0, -2.0)
    world, (plane,) = world_and_planes()
    assert isinstance(world.ground, Ground)
    assert world.ground.centre == pytest.approx([3.0, -2.0, 2.1])
    assert (world.ground.level, world.ground.radius) == pytest.approx((0.5, 20.0))
    assert (plane.is_catcher, plane.meets_light) == (True, False)
    assert plane.frame[:3, 3] == pytest.approx([3.0, -2.0, 0.5])
    bpy.context.scene.unit_settings.scale_length = 0.01
    assert world_and_planes()[0].ground.centre == pytest.approx([0.03, -0.02, 0.021])


def test_edits_of_the_ground_are_sent_and_its_end_too():
    settings, sync = ground(), SceneSync(final=True)

    def walk():
        bpy.context.view_layer.update()
        sync.tag(bpy.context.evaluated_depsgraph_get().updates)
        sync.tag_scene()
        sync._tags.shading.add(bpy.context.scene.world.session_uid)
        return sync.walk(bpy.context.evaluated_depsgraph_get()).delta

    assert not any(item.id == "ground" for item in walk().changed)
    settings.use_ground = True
    assert any(item.id == "ground" for item in walk().changed)
    assert not any(item.id == "ground" for item in walk().changed)
    settings.level = 1.0
    changed = walk().changed
    assert [item.id for item in changed if isinstance(item, Placement)] == ["ground"]
    settings.use_ground = False
    assert {"ground", "geometry:ground", "material:ground"} <= set(walk().removed)


def test_the_photo_of_the_camera_is_laid_out_from_where_the_camera_stands():
    settings, item = ground(), camera()
    settings.use_ground, settings.photo = True, "CAMERA"
    show(item, photo())
    made = converted_scene()
    world, _ = world_and_planes(made)
    assert world.seen is None
    assert world.ground.centre == pytest.approx([0.0, -4.0, 2.0])
    assert world.photo.extent_x == pytest.approx(made.camera.extent_x)
    assert world.photo.extent_y == pytest.approx(made.camera.extent_y)
    assert world.photo.luminance_per_unit == bpy.context.scene.lumenray.white_luminance
    settings.photo_luminance = 50.0
    assert world_and_planes()[0].photo.luminance_per_unit == 50.0


@pytest.mark.parametrize(
    ("method", "size"), [("STRETCH", (1.0, 1.0)), ("FIT", (1.0, 0.75)), ("CROP", (4 / 3, 1.0))]
)
def test_a_photo_fits_the_film_as_blender_shows_it(method, size):
    """One of 2 : 1 in a film of 3 : 2."""
    settings, item = ground(), camera()
    settings.photo = "CAMERA"
    show(item, photo(32, 16)).frame_method = method
    made = converted_scene()
    found = world_and_planes(made)[0].photo
    assert found.extent_x == pytest.approx(size[0] * made.camera.extent_x, rel=1e-5)
    assert found.extent_y == pytest.approx(size[1] * made.camera.extent_y, rel=1e-5)


def test_a_back_plate_is_seen_by_the_camera_alone_and_lies_level_by_its_azimuth():
    settings = ground()
    settings.photo, settings.plate = "PLATE", photo(40, 20)
    settings.plate_azimuth, settings.plate_angle = math.radians(90.0), math.radians(90.0)
    world, _ = world_and_planes()
    assert world.photo is None
    plate = world.seen.photo
    # Its middle lies to the east, its right side to the south.
    assert -plate.frame[:, 2] == pytest.approx([1.0, 0.0, 0.0], abs=1e-7)
    assert plate.frame[:, 0] == pytest.approx([0.0, -1.0, 0.0], abs=1e-7)
    assert (plate.extent_x, plate.extent_y) == pytest.approx((2.0, 1.0))


def test_what_is_lacking_is_told():
    settings = ground()
    settings.photo = "CAMERA"
    assert "needs a perspective camera" in messages_of(converted_scene().report.to_dicts())
    item = camera()
    assert "shows no background image" in messages_of(converted_scene().report.to_dicts())
    show(item, photo()).offset = (0.1, 0.0)
    assert "shifted or turned" in messages_of(converted_scene().report.to_dicts())
    settings.use_ground, settings.level = True, 5.0
    assert "stands below the ground" in messages_of(converted_scene().report.to_dicts())
    settings.photo = "PLATE"
    assert "the back plate has no image" in messages_of(converted_scene().report.to_dicts())


@pytest.mark.mitsuba
def test_a_photomontage_without_things_is_the_photo():
    """Sky and ground of it, pixel by pixel, and its ground catches no shadows where there are none."""
    settings, item = ground(), camera()
    settings.use_ground, settings.photo = True, "CAMERA"
    show(item, photo())
    made, session = converted_scene(), Session(witness=False)
    session.apply(made.delta)
    picture = session.render(made.camera, ViewSettings(StopRule(samples=256)))
    white = bpy.context.scene.lumenray.white_luminance
    expected = white * 0.5 * (0.5 + np.arange(24) / 24)
    found = picture.tristimulus[..., 1]
    assert found[2:-2, 2:-2] == pytest.approx(
        np.broadcast_to(expected, found.shape)[2:-2, 2:-2], rel=0.02
    )
