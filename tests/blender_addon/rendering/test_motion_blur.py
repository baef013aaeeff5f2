"""Motion blur: what moves while the shutter is open is seen where it was, for as long as it was there."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from blender_objects import add_camera, add_quad, new_material

from lumenray.blender_addon.rendering.render_engine import LumenrayRenderEngine
from lumenray.blender_addon.rendering.shutter import shutter_of
from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.command_line.render import render_open
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import Cancelled

pytestmark = pytest.mark.usefixtures("extension")

WIDTH, HEIGHT = 48, 4
"""Of the picture, which shows 6 by 0.5 units. [pixel]"""

SHOWN = 6.0

START, SPEED, SIDE = -1.5, 1.0, 1.0
"""Left edge of the square at frame 1, units that it moves in a frame, and its width."""


@pytest.fixture
def square():
    """A glowing square that moves along x by one unit a frame, seen from above."""
    bpy.ops.preferences.addon_enable(module="cycles")
    material = new_material("Glow", "ShaderNodeEmission")
    item = add_quad("Square", material=material)
    item.location.y = -0.5
    animate(item, "location", (START - SPEED, -0.5, 0.0), (START + 2.0 * SPEED, -0.5, 0.0))
    add_camera((0, 0, 3), (0, 0, 0), type="ORTHO", ortho_scale=SHOWN)
    scene = bpy.context.scene
    scene.frame_set(1)
    scene.render.engine = "LUMENRAY"
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.resolution_percentage = 100
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.lumenray.render.samples = 64
    scene.lumenray.white_luminance = scene.lumenray.efficacy
    return item


def animate(owner, path, before, after):
    """Move a value evenly from frame 0 to frame 3."""
    for frame, value in ((0, before), (3, after)):
        setattr(owner, path, value)
        owner.keyframe_insert(path, frame=frame)
    (bag,) = owner.id_data.animation_data.action.layers[0].strips[0].channelbags
    for curve in bag.fcurves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def render():
    """Return a row of the picture. (WIDTH,)"""
    scene = bpy.context.scene
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(Path(bpy.app.tempdir) / "moving.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    pixels = np.array(image.pixels[:], np.float32).reshape(HEIGHT, WIDTH, -1)
    bpy.data.images.remove(image)
    return pixels[..., 1].mean(axis=0)


def seen(left, right, moved):
    """Share of the time for which each pixel shows what lies between, and moves to the right meanwhile by so much."""
    times = np.linspace(0.0, 1.0, 2000)
    edges = np.linspace(-0.5 * SHOWN, 0.5 * SHOWN, WIDTH + 1)
    covered = np.clip(edges[:, None], left + moved * times, right + moved * times)
    return np.diff(covered, axis=0).mean(axis=1) / np.diff(edges)


def test_a_square_is_seen_where_it_was_while_the_shutter_was_open(square):
    bpy.context.scene.render.motion_blur_position = "START"
    expected = seen(START, START + SIDE, SPEED)
    row = render()
    # Edges are soft by the pixels' filter, and two times in each of eight parts are a pixel apart.
    assert abs(row - expected).max() < 0.08
    assert row.mean() == pytest.approx(expected.mean(), rel=0.015)
    assert bpy.context.scene.frame_current_final == 1.0


@pytest.mark.slow
def test_what_is_not_to_be_blurred_stands_as_halfway(square):
    square.cycles.use_motion_blur = False
    bpy.context.scene.render.motion_blur_position = "START"
    left = START + 0.5 * SPEED
    assert abs(render() - seen(left, left + SIDE, 0.0)).max() < 0.08


@pytest.mark.slow
def test_a_moving_camera_blurs_what_stands(square):
    square.animation_data_clear()
    square.location.x = -0.5
    eye = bpy.context.scene.camera
    animate(eye, "location", (1.0, 0.0, 3.0), (-2.0, 0.0, 3.0))
    assert abs(render() - seen(-1.0, 0.0, 1.0)).max() < 0.08


@pytest.mark.slow
def test_shapes_are_blurred_unless_they_are_not_to_be(square):
    square.animation_data_clear()
    square.location.x = -2.0
    square.shape_key_add(name="Basis")
    key = square.shape_key_add(name="Moved")
    for point in key.data:
        point.co.x += 3.0
    animate(key, "value", 0.0, 1.0)
    assert abs(render() - seen(-1.5, -0.5, 1.0)).max() < 0.08
    square.cycles.use_deform_motion = False
    assert abs(render() - seen(-1.0, 0.0, 0.0)).max() < 0.08


def test_the_command_line_blurs_alike_and_leaves_the_frame(square, tmp_path, capfd):
    import OpenEXR

    scene = bpy.context.scene
    options = SimpleNamespace(
        file=tmp_path / "moving.blend", size=None, accept_missing=False, light_groups=None, mix=[],
        output=tmp_path / "moving.exr", denoise=False, seed=None, transport=None, illuminance=False,
        spectral_exr=4, method=None, unbiased=None, samples=64, error=None, time=None,
        false_colour=False, tone=[], isolux_lines=None, values=False,
        cluster=None, tls_ca=None, tls_cert=None, tls_key=None,
    )  # fmt: skip
    assert render_open(options, bpy.context.evaluated_depsgraph_get()) == 0
    assert scene.frame_current_final == 1.0
    assert "motion blur: the mean of 16 moments" in "".join(capfd.readouterr())
    expected = seen(START - 0.5, START + 0.5, SPEED)
    with OpenEXR.File(str(options.output), separate_channels=True) as file:
        row = file.channels()["Luminance.Y"].pixels.mean(axis=0)
    row = row / scene.lumenray.efficacy
    assert abs(row - expected).max() < 0.08
    with OpenEXR.File(str(tmp_path / "moving_spectral.exr"), separate_channels=True) as file:
        channels = file.channels()
        bands = sum(channels[name].pixels for name in channels if name.startswith("S0"))
    bands = bands.mean(axis=0)
    assert abs(bands / bands.max() - expected / expected.max()).max() < 0.08


@pytest.mark.slow
def kept_notes(monkeypatch):
    """Return a list that gets the notes of pictures that are rendered."""
    notes = []
    deliver = LumenrayRenderEngine._write_beside

    def keep(self, scene, picture, *rest):
        notes.extend(picture.provenance.notes)
        deliver(self, scene, picture, *rest)

    monkeypatch.setattr(LumenrayRenderEngine, "_write_beside", keep)
    return notes


def test_lights_that_move_are_blurred_and_told(square, monkeypatch):
    square.animation_data_clear()
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    bpy.context.scene.collection.objects.link(lamp)
    animate(lamp, "location", (0.0, 0.0, 1.0), (1.0, 0.0, 1.0))
    bpy.context.scene.lumenray.render.samples = 16
    notes = kept_notes(monkeypatch)
    render()
    assert any("lights change while the shutter is open" in note for note in notes)


def test_a_rolling_shutter_is_told_of_blurred_pictures_and_motion_blur_of_all_others(square):
    scene, depsgraph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()
    scene.cycles.rolling_shutter_type = "TOP"
    messages = []
    for is_blurred in (False, True):
        sync = SceneSync(final=True)
        sync.is_blurred = is_blurred
        messages.append([row.message for row, _ in sync.walk(depsgraph).report.rows])
    assert messages == [
        ["motion blur is for renders"],
        ["the shutter rolls over the picture in Cycles"],
    ]


def test_a_cancelled_shutter_leaves_the_frame(square, monkeypatch):
    times = []

    def begin(shutter, settings, moment, progress):
        moment(shutter.begin, replace(settings, rule=StopRule(samples=2)), progress)
        times.append(bpy.context.scene.frame_current_final)
        raise Cancelled("cancelled")

    monkeypatch.setattr("lumenray.blender_addon.rendering.shutter.render_moments", begin)
    bpy.context.scene.render.motion_blur_position = "END"
    bpy.context.scene.render.motion_blur_shutter = 1.5
    bpy.ops.render.render()
    assert times == [-0.5]
    assert bpy.context.scene.frame_current_final == 1.0


def test_the_shutter_is_open_as_the_scene_says():
    scene = bpy.context.scene
    layer = scene.view_layers[0]
    assert shutter_of(scene, layer) is None
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.4
    scene.frame_set(7)
    made = shutter_of(scene, layer)
    assert (made.begin, made.end) == pytest.approx((6.8, 7.2))
    assert made.opening is None
    # Frames are counted before their time is remapped.
    scene.render.frame_map_old, scene.render.frame_map_new = 100, 50
    assert shutter_of(scene, layer).middle == pytest.approx(7.0)
    scene.render.frame_map_new = 100
    scene.render.motion_blur_position = "END"
    assert shutter_of(scene, layer).end == pytest.approx(7.0)
    scene.render.motion_blur_position = "CENTER"
    points = scene.render.motion_blur_shutter_curve.curves[0].points
    points[0].location, points[1].location = (0.0, 0.0), (1.0, 1.0)
    for point in points:
        point.handle_type = "VECTOR"
    scene.render.motion_blur_shutter_curve.update()
    np.testing.assert_allclose(shutter_of(scene, layer).time(0.25), 7.0, atol=2e-3)
    layer.use_motion_blur = False
    assert shutter_of(scene, layer) is None


@pytest.mark.slow
def test_what_glows_by_its_place_in_the_world_is_blurred_where_it_glows(square, monkeypatch):
    tree = square.active_material.node_tree
    where = tree.nodes.new("ShaderNodeSeparateXYZ")
    geometry, step = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeMath")
    step.operation, step.inputs[1].default_value = "GREATER_THAN", -1.0
    tree.links.new(geometry.outputs["Position"], where.inputs[0])
    tree.links.new(where.outputs["X"], step.inputs[0])
    tree.links.new(step.outputs[0], tree.nodes["Emission"].inputs["Strength"])
    left = START - 0.5 * SPEED
    middles = (np.arange(WIDTH) + 0.5) / WIDTH * SHOWN - 0.5 * SHOWN
    expected = np.where(middles > -1.0, seen(left, left + SIDE, SPEED), 0.0)
    notes = kept_notes(monkeypatch)
    assert abs(render() - expected).max() < 0.08
    # Cycles takes the place at the ray's time as well.
    assert not any("materials change" in note for note in notes)
    bpy.context.scene.render.engine = "CYCLES"
    bpy.context.scene.cycles.samples, bpy.context.scene.cycles.filter_width = 256, 0.01
    bpy.context.scene.view_settings.view_transform = "Raw"
    away = abs(middles + 1.0) > 0.15
    assert abs(render() - expected)[away].max() < 0.08


@pytest.mark.slow
def test_materials_that_change_are_told_even_where_objects_have_their_own(square, monkeypatch):
    tree = square.active_material.node_tree
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], tree.nodes["Emission"].inputs["Color"])
    animate(noise.inputs["Scale"], "default_value", 1.0, 2.0)
    bpy.context.scene.lumenray.render.samples = 16
    notes = kept_notes(monkeypatch)
    render()
    assert any("materials change while the shutter is open" in note for note in notes)
