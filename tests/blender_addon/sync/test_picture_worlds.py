"""Pictures as Blender's world: their illuminance, their place as Cycles shows it, and what their files say."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from blender_objects import needs_cycles
from conversion import converted_scene
from mathutils import Vector
from picture_worlds import image_of, show
from radiance_files import XYZE, write_picture

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import ImageWorld
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.session import Session
from lumenray.engine.sky.picture import find_illuminance

REC709 = np.array([0.2126, 0.7152, 0.0722])

NORMALS = np.array([[0, 0, 1.0], [1, 0, 0], [0, -1, 0], [-0.6, 0.64, 0.48]])


@pytest.fixture(scope="module")
def session():
    return Session()


def picture(height=32, seed=2):
    """Noise in colours that is brighter above, with a bright spot."""
    made = np.random.default_rng(seed).random((height, 2 * height, 3)).astype(np.float32)
    made[height // 2 :] *= 3.0
    made[height * 3 // 4, height // 3] = 40.0
    return made


def said():
    return " | ".join(f"{row.message}; {row.remedy}" for row, _ in converted_scene().report.rows)


def shown():
    found = [item for item in converted_scene().delta.changed if isinstance(item, ImageWorld)]
    return found[0] if found else None


def measure(session, normals=NORMALS, samples=1 << 16):
    converted = converted_scene()
    fresh = Session() if session is None else session
    fresh.apply(converted.delta)
    return fresh.measure(np.zeros((len(normals), 3)), normals, StopRule(samples=samples))


@pytest.mark.mitsuba
@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.4, -0.3, 1.0)], ids=["upright", "tilted"])
def test_a_picture_that_is_scaled_to_lux_gives_these(turn):
    world, _ = show(image_of(picture()), turn)
    world.lumenray.unit, world.lumenray.illuminance = "ILLUMINANCE", 5000.0
    made = measure(None, NORMALS[:1], 1 << 18)
    assert made.standard_error[0] < 1.0
    assert made.illuminance[0] == pytest.approx(5000.0, abs=4.0 * made.standard_error[0] + 1.0)


def test_a_picture_that_is_dark_above_cannot_be_scaled_to_lux():
    pixels = picture()
    pixels[16:] = 0.0
    pixels[15] = 0.0
    world, _ = show(image_of(pixels))
    world.lumenray.unit = "ILLUMINANCE"
    assert "upper half of the environment is black" in said()
    assert shown() is None


def render_by_cycles(camera, width, height, samples):
    """Linear luminance (height, width), row 0 at the bottom."""
    scene = bpy.context.scene
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.device = samples, "CPU"
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.filter_width = 0.01
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    path = Path(bpy.app.tempdir) / "cycles.exr"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path), check_existing=False)
    pixels = np.array(image.pixels[:], np.float32).reshape(height, width, -1)[..., :3]
    bpy.data.images.remove(image)
    return pixels @ REC709


def add_camera(direction, **settings):
    data = bpy.data.cameras.new("Eye")
    for key, value in settings.items():
        setattr(data, key, value)
    item = bpy.data.objects.new("Eye", data)
    item.rotation_euler = Vector(direction).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(item)
    return item


@needs_cycles
@pytest.mark.parametrize("interpolation", ["Linear", "Closest"])
@pytest.mark.slow
def test_directions_show_what_cycles_shows(interpolation):
    turn = (0.3, 0.2, 0.9)
    _, node = show(image_of(picture(8)), turn)
    node.interpolation = interpolation
    chance = np.random.default_rng(4)
    world = shown()
    assert world.image.interpolation == interpolation.lower()
    for given in chance.normal(size=(4, 3)):
        direction = given / np.linalg.norm(given)
        camera = add_camera(direction, angle=np.radians(0.2))
        seen = render_by_cycles(camera, 2, 2, 4).mean()
        assert seen == pytest.approx(_value(world, direction), rel=0.02)


def _value(world, direction):
    """Value of a converted world in a direction by the mapping that it states."""
    x, y, z = world.rotation @ direction
    luminance = world.image.pixels @ REC709
    height, width = luminance.shape
    column = (0.5 - np.arctan2(y, x) / (2 * np.pi)) * width - 0.5
    row = np.clip((np.arcsin(z) / np.pi + 0.5) * height - 0.5, 0, height - 1)
    if world.image.interpolation == "closest":
        return luminance[round(row), round(column) % width]
    left, low = int(np.floor(column)), min(int(row), height - 2)
    s, t = column - left, row - low
    rows = [(1 - s) * line[left % width] + s * line[(left + 1) % width] for line in luminance]
    return (1 - t) * rows[low] + t * rows[low + 1]


@needs_cycles
@pytest.mark.mitsuba
@pytest.mark.slow
def test_planes_get_what_cycles_gives_them(session):
    show(image_of(picture(16)), (0.3, 0.2, 0.9))
    paint = bpy.data.materials.new("White")
    if bpy.app.version < (5, 0, 0):
        paint.use_nodes = True
    tree = paint.node_tree
    matt = tree.nodes.new("ShaderNodeBsdfDiffuse")
    matt.inputs["Color"].default_value = (1, 1, 1, 1)
    output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
    tree.links.new(matt.outputs[0], output.inputs["Surface"])
    made = measure(session, NORMALS, 1 << 16)
    for normal, ours in zip(NORMALS, made.illuminance, strict=True):
        bpy.ops.mesh.primitive_plane_add(size=1.0)
        plane = bpy.context.object
        plane.rotation_euler = Vector(normal).to_track_quat("Z", "Y").to_euler()
        plane.data.materials.append(paint)
        camera = add_camera(-normal, type="ORTHO", ortho_scale=0.2)
        camera.location = normal * 2.0
        lit = render_by_cycles(camera, 16, 16, 256).mean()
        bpy.data.objects.remove(plane)
        assert ours / bpy.context.scene.lumenray.efficacy == pytest.approx(np.pi * lit, rel=5e-3)


@pytest.mark.mitsuba
@pytest.mark.slow
def test_another_picture_and_another_strength_give_what_a_fresh_scene_gives(session):
    world, node = show(image_of(picture(16)))
    background = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    for change in (
        lambda: background.inputs["Strength"].__setattr__("default_value", 2.5),
        lambda: setattr(node, "image", image_of(picture(24, 7), "Other")),
        lambda: setattr(node, "interpolation", "Closest"),
    ):
        measure(session)
        change()
        edited, fresh = measure(session).illuminance, measure(None).illuminance
        np.testing.assert_allclose(edited, fresh, rtol=1e-5)


# ---- what files say ----


def load(tmp_path, data, name="sky.hdr"):
    (tmp_path / name).write_bytes(data)
    image = bpy.data.images.load(str(tmp_path / name), check_existing=False)
    show(image)
    return image


def illuminance(normal=(0.3, 0.5, 0.8)):
    world = shown()
    return find_illuminance(world.image, world.rotation, np.array(normal) / np.linalg.norm(normal))


def test_exposures_of_a_radiance_picture_are_taken_out_and_said(tmp_path):
    load(tmp_path, write_picture(picture()))
    true = illuminance()
    assert "EXPOSURE" not in said()
    load(tmp_path, write_picture(picture(), ["EXPOSURE=2", "EXPOSURE=4"]), "bright.hdr")
    assert illuminance() == pytest.approx(true / 8.0, rel=1e-6)
    assert "'bright.hdr' states EXPOSURE 8; its pixels are divided by it" in said()
    load(tmp_path, write_picture(picture(), ["COLORCORR=2 2 2", "GAMMA=2.2"]), "corrected.hdr")
    assert illuminance() == pytest.approx(true / 2.0, rel=1e-6)
    assert "COLORCORR 2 2 2" in said()
    assert "GAMMA 2.2; its values are read as linear" in said()
    image = load(tmp_path, write_picture(picture(), ["EXPOSURE=2"]), "packed.hdr")
    image.pack()
    (tmp_path / "packed.hdr").unlink()
    assert illuminance() == pytest.approx(true / 2.0, rel=1e-6)


@pytest.mark.parametrize("order", ["+Y +X", "-Y -X", "+X -Y"])
def test_radiance_pictures_are_turned_as_they_say(tmp_path, order):
    load(tmp_path, write_picture(picture()))
    true = illuminance()
    load(tmp_path, write_picture(picture(), order=order, packed=True), "turned.hdr")
    assert illuminance() == pytest.approx(true, rel=1e-6)


def test_pictures_in_x_y_z_keep_their_luminance_and_are_read_once(tmp_path):
    grey = picture()[..., :1] * np.array([0.95, 1.0, 1.09], np.float32)
    load(tmp_path, write_picture(grey, encoding=XYZE))
    _, stated = shown(), said()
    assert "holds CIE X, Y, Z" in stated
    assert "unit cd/m2" in stated
    true = find_illuminance(ImageTexture(grey[..., 1:2]), np.eye(3), np.array([0, 0, 1.0]))
    assert illuminance((0, 0, 1)) == pytest.approx(true, rel=0.01)


def test_a_radiance_picture_that_cannot_be_read_is_said(tmp_path):
    load(tmp_path, write_picture(picture(), ["EXPOSURE=-1"]), "wrong.hdr")
    assert "wrong.hdr, line 2: EXPOSURE is '-1', expected 1 number above 0" in said()


def test_odd_pixels_and_other_projections_are_said():
    pixels = picture(8)
    pixels[3, :2] = np.nan
    pixels[4, 5] = np.inf
    pixels[6, 7, 1] = -0.5
    _, node = show(image_of(pixels, "Odd"))
    node.interpolation = "Cubic"
    text = said()
    for words in ("'Odd' has 2 NaN", "'Odd' has 1 infinite", "'Odd' has 1 pixels", "is Cubic"):
        assert words in text
    show(image_of(np.ones((8, 8, 3)), "Fisheye"))
    assert "'Fisheye' has 8 x 8 pixels, a full sphere is twice as wide as high" in said()
