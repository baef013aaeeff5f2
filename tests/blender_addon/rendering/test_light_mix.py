"""The light mix in Blender: passes by group, mixed pictures without rendering, panels, and what the file keeps."""

import types

import bpy
import numpy as np
import pytest
from blender_bakes import add_lamp
from blender_objects import add_camera
from panels import context, draw

from lumenray.blender_addon.rendering import light_mix, viewport
from lumenray.blender_addon.rendering.viewport import display_of, live_settings
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.engine.light_mix import Level
from lumenray.tools.libraries.scenes import tiny

pytestmark = pytest.mark.usefixtures("extension")

OWN = "Combined_"


@pytest.fixture
def scene():
    """A closed box with two lamps of which one is in a group."""
    tiny.build_closed_box()
    for source in [each for each in bpy.data.objects if each.type == "LIGHT"]:
        bpy.data.objects.remove(source)
    add_lamp("Spot", "Ceiling", 600.0).location = (0.5, 0.2, 0.3)
    add_lamp("Bulb", "", 300.0).location = (-0.5, -0.2, 0.3)
    add_camera((0, 0, 0), (1.2, 0.0, 0.4), lens=24.0)
    scene = bpy.context.scene
    scene.render.engine = "LUMENRAY"
    scene.render.resolution_x, scene.render.resolution_y = 24, 16
    scene.render.resolution_percentage = 100
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    # Finding cells for every group would take longer than the picture.
    scene.lumenray.render.samples, scene.lumenray.render.method = 16, "PATHS"
    scene.lumenray.light_mix.groups = "GROUPS"
    return scene


@pytest.fixture
def render(scene, tmp_path):
    """Return a function that renders and returns the passes in the file by name, (h, w, c)."""
    openexr = pytest.importorskip("OpenEXR")

    def render():
        scene.render.filepath = str(tmp_path / "picture.exr")
        bpy.ops.render.render(write_still=True)
        with openexr.File(scene.render.filepath, separate_channels=True) as file:
            pixels = {
                name.split(".", 1)[1]: channel.pixels.copy()
                for part in file.parts
                for name, channel in part.channels.items()
            }
        names = {name.rpartition(".")[0] for name in pixels}
        return {
            name: np.stack(
                [v for key, v in sorted(pixels.items()) if key.rpartition(".")[0] == name], axis=-1
            )
            for name in names
        }

    return render


def rows(scene):
    return {row.name: row for row in scene.lumenray.light_mix.rows}


def mixed():
    """Pixels of the image of the mix, the top row first as in files, in the order A, B, G, R."""
    image = bpy.data.images[light_mix.IMAGE]
    width, height = image.size
    pixels = np.empty(width * height * 4, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, 4)[::-1, :, ::-1]


def test_groups_are_passes_that_add_up_to_the_picture(scene, render):
    passes = render()
    assert {OWN + "Ceiling", OWN + "rest"} <= set(passes)
    total = passes[OWN + "Ceiling"][..., 1:] + passes[OWN + "rest"][..., 1:]
    np.testing.assert_allclose(total, passes["Combined"][..., 1:], rtol=1e-4, atol=1e-6)
    np.testing.assert_array_equal(passes[OWN + "rest"][..., 0], 1.0)
    assert passes[OWN + "Ceiling"][..., 1:].mean() > passes[OWN + "rest"][..., 1:].mean() > 0.0
    assert list(rows(scene)) == ["Ceiling", "rest"]
    scene.lumenray.light_mix.groups = "NONE"
    assert not any(name.startswith(OWN) for name in render())
    assert not light_mix.has_kept(scene)


def test_a_level_mixes_the_last_picture_without_rendering(scene, render):
    assert not bpy.ops.lumenray.mix_picture.poll()
    passes = render()
    said = bpy.context.window_manager.lumenray.render
    rows(scene)["Ceiling"].factor = 0.25
    ceiling, rest = (passes[OWN + name][..., 1:] for name in ("Ceiling", "rest"))
    np.testing.assert_allclose(mixed()[..., 1:], 0.25 * ceiling + rest, rtol=1e-4, atol=1e-6)
    rows(scene)["rest"].is_on = False
    np.testing.assert_allclose(mixed()[..., 1:], 0.25 * ceiling, rtol=1e-4, atol=1e-6)
    rows(scene)["Ceiling"].colour = (1.0, 0.5, 0.25)
    factors = np.array([0.25, 0.5, 1.0]) / (0.2126 + 0.7152 * 0.5 + 0.0722 * 0.25)
    np.testing.assert_allclose(mixed()[..., 1:], 0.25 * factors * ceiling, rtol=1e-3, atol=1e-5)
    assert bpy.ops.lumenray.reset_light_mix() == {"FINISHED"}
    np.testing.assert_allclose(mixed(), passes["Combined"], rtol=1e-4, atol=1e-6)
    scene.lumenray.white_luminance *= 2.0
    assert bpy.ops.lumenray.mix_picture() == {"FINISHED"}
    np.testing.assert_allclose(
        mixed()[..., 1:], 0.5 * passes["Combined"][..., 1:], rtol=1e-4, atol=1e-6
    )
    assert bpy.context.window_manager.lumenray.render == said


def test_a_render_is_mixed_as_its_levels_say_and_tells_it(scene, render):
    scene.lumenray.render.use_pass_illuminance = True
    plain = render()
    rows(scene)["Ceiling"].factor = 0.5
    again = render()
    assert "light mix: Ceiling at 50 % of its flux" in bpy.context.window_manager.lumenray.render
    for name in (OWN + "Ceiling", OWN + "rest"):
        np.testing.assert_array_equal(again[name], plain[name])
    expected = 0.5 * plain[OWN + "Ceiling"] + plain[OWN + "rest"]
    np.testing.assert_allclose(again["Combined"][..., 1:], expected[..., 1:], rtol=1e-4, atol=1e-6)
    assert again["Luminance"].mean() < plain["Luminance"].mean()
    assert again["Illuminance"].mean() < plain["Illuminance"].mean()
    told = dict(light_mix.describe(scene, rows(scene)["Ceiling"]))
    assert told["flux"] == "50 % of its lumens"
    now, _, before = told["mean illuminance"].partition(" of ")
    number = lambda text: float(text.removesuffix(" lx"))  # noqa: E731
    assert number(now) == pytest.approx(0.5 * number(before), rel=0.01)
    assert number(told["mean illuminance of all"]) == pytest.approx(
        again["Illuminance"].mean(), rel=0.01
    )


def test_the_file_keeps_levels_and_the_mix(scene, render, tmp_path):
    render()
    rows(scene)["Ceiling"].factor = 0.25
    rows(scene)["rest"].is_on = False
    before = mixed()
    bpy.data.images[light_mix.IMAGE].use_fake_user = True
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "mix.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "mix.blend"))
    scene = bpy.context.scene
    kept = rows(scene)
    assert (kept["Ceiling"].factor, kept["rest"].is_on) == (0.25, False)
    assert scene.lumenray.light_mix.groups == "GROUPS"
    assert not light_mix.has_kept(scene)
    bpy.data.images[light_mix.IMAGE].update()
    np.testing.assert_allclose(mixed(), before, rtol=1e-3, atol=1e-5)


def test_rows_follow_the_groups_and_keep_their_levels(scene):
    assert bpy.ops.lumenray.list_light_groups() == {"FINISHED"}
    assert list(rows(scene)) == ["Ceiling", "rest"]
    rows(scene)["rest"].factor = 0.5
    bpy.data.lights["Bulb"].lumenray.light_group = "Table"
    add_lamp("Third")
    bpy.ops.lumenray.list_light_groups()
    assert list(rows(scene)) == ["Ceiling", "Table", "rest"]
    assert rows(scene)["rest"].factor == 0.5
    scene.lumenray.light_mix.groups = "EACH"
    bpy.ops.lumenray.list_light_groups()
    assert list(rows(scene)) == ["Bulb", "Spot", "Third"]


def test_views_get_the_levels_as_a_matter_of_display(scene):
    bpy.ops.lumenray.list_light_groups()
    before = display_of(scene)
    rows(scene)["Ceiling"].factor = 0.5
    assert display_of(scene) != before
    assert display_of(scene).mix.level("Ceiling") == Level("Ceiling", 0.5)
    assert live_settings(scene).groups == ()
    rows(scene)["Ceiling"].colour = (0.0, 0.0, 0.0)
    # Light cannot be black.
    assert display_of(scene).mix.level("Ceiling").is_white
    scene.lumenray.light_mix.groups = "NONE"
    assert display_of(scene).mix.is_neutral


def test_lines_and_values_are_a_matter_of_display(scene):
    """They change what is drawn, not what is computed."""
    before, computed = display_of(scene), live_settings(scene)
    assert not before.lines and not before.values
    scene.lumenray.viewport.isolux_lines = True
    assert display_of(scene).lines and not display_of(scene).values
    scene.lumenray.viewport.use_values = True
    assert display_of(scene).values
    assert live_settings(scene) == computed


@pytest.mark.parametrize("panel", ["LUMENRAY_PT_light_mix", "LUMENRAY_PT_light_mix_sidebar"])
def test_panels_show_every_group(scene, panel):
    seen = draw(panel, context())
    assert "lumenray.list_light_groups" in seen
    assert any("No groups yet" in str(each) for each in seen)
    bpy.ops.lumenray.list_light_groups()
    seen = draw(panel, context())
    assert "LUMENRAY_UL_light_mix" in seen
    assert "100 % of its lumens" in seen
    scene.lumenray.light_mix.groups = "NONE"
    assert draw(panel, context()) == ["groups"]


def test_names_of_passes_are_short_enough_for_blender_and_differ():
    long = "Leuchte über dem Tresen im Flur des ersten Stocks rechts neben der Tür"
    names = light_mix.name_passes(["Ceiling", long + " A", long + " B", long])
    assert names[0] == "Combined_Ceiling"
    assert len(set(names)) == 4
    assert all(len(name.encode()) <= 63 and name.startswith(OWN) for name in names)
    assert names[2].endswith("~2")


def test_the_mix_follows_an_undo(scene, render):
    passes = render()
    bpy.ops.ed.undo_push(message="before")
    rows(scene)["Ceiling"].factor = 0.5
    dimmed = mixed()
    assert dimmed[..., 1:].mean() < 0.9 * passes["Combined"][..., 1:].mean()
    bpy.ops.ed.undo_push(message="dimmed")
    assert bpy.ops.ed.undo() == {"FINISHED"}
    scene = bpy.context.scene
    assert rows(scene)["Ceiling"].factor == 1.0
    np.testing.assert_allclose(mixed(), passes["Combined"], rtol=1e-4, atol=1e-6)
    assert bpy.ops.ed.redo() == {"FINISHED"}
    np.testing.assert_allclose(mixed(), dimmed, rtol=1e-4, atol=1e-6)


def test_a_view_keeps_the_groups_apart_that_the_scene_has(scene):
    luminous = convert_scene(bpy.context.evaluated_depsgraph_get()).luminous
    view = viewport.Viewport()
    try:
        view._feed = types.SimpleNamespace(sync=types.SimpleNamespace(luminous=luminous))
        view._find_groups(scene)
        mode, (group,) = view._groups
        assert (mode, group.name) == ("GROUPS", "Ceiling")
        # Blender's timer does it when nothing is drawn.
        viewport._list_rows(scene.session_uid, light_mix.names_of((group,), luminous))
        assert list(rows(scene)) == ["Ceiling", "rest"]
        view._feed.sync.luminous = [(f"light:{n}", f"Lamp {n}") for n in range(65)]
        scene.lumenray.light_mix.groups = "EACH"
        view._find_groups(scene)
        assert view._groups == ("EACH", ())
        assert view.status.is_error
        assert "65 groups are too many" in view.status.message
        scene.lumenray.light_mix.groups = "NONE"
        view._find_groups(scene)
        assert view._groups == ("NONE", ())
    finally:
        view._feed = None
        viewport.close_all()
