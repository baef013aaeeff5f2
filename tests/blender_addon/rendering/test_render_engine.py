"""The render engine: its passes, its header, scenes without a camera, and files from elsewhere."""

import os
import re
import types
from pathlib import Path

import bpy
import numpy as np
import pytest
from blender_objects import add_camera
from conversion import converted_scene
from panels import Layout, context

from lumenray.blender_addon.assumptions import ASSUMED
from lumenray.command_line import main as command_line
from lumenray.engine.analysis.denoiser import find_denoiser
from lumenray.engine.scene.camera import Projection
from lumenray.tools.libraries.scenes import tiny
from lumenray.ui import image_header

pytestmark = pytest.mark.usefixtures("extension")

FOREIGN = Path(os.environ.get("LUMENRAY_BLEND_FILES", "nowhere"))


def test_the_render_engine_delivers_its_passes(tmp_path):
    tiny.build_closed_box()
    scene = bpy.context.scene
    scene.render.engine = "LUMENRAY"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = (
        24,
        16,
        100,
    )
    layer = bpy.context.view_layer
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_object_index = True
    scene.lumenray.render.use_pass_illuminance = True
    scene.lumenray.render.use_spectral_file = True
    scene.lumenray.render.samples = 8
    bpy.data.objects["Floor"].pass_index = 5
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    scene.render.filepath = str(tmp_path / "box.exr")
    bpy.ops.render.render(write_still=True)
    openexr = pytest.importorskip("OpenEXR")
    with openexr.File(str(tmp_path / "box.exr"), separate_channels=True) as file:
        # Blender 5 writes a part per pass, older ones a single part.
        found = {
            name.split(".")[1]: channel.pixels.copy()
            for part in file.parts
            for name, channel in part.channels.items()
        }
    assert {"Combined", "Normal", "Luminance", "Illuminance"} <= set(found)
    assert found["Luminance"].min() >= 0
    # The mean over all walls is 83.33 lx; the part in view need not be the mean.
    assert 40 < found["Illuminance"].mean() < 200
    index = next(pixels for name, pixels in found.items() if name in {"IndexOB", "Object Index"})
    assert set(np.unique(index)) == {0.0, 5.0}
    # Spectral file beside the picture: light of equal energy at all wavelengths, as much as the luminance tells.
    spectral = next(tmp_path.glob("*_spectral.exr"))
    with openexr.File(str(spectral), separate_channels=True) as file:
        bands = [
            each.pixels.mean() for name, each in file.channels().items() if name.startswith("S0.")
        ]
    assert len(bands) == scene.lumenray.render.spectral_bands
    # The integral of V(lambda) is 106.857 nm.
    luminance = found["Luminance"].mean()
    np.testing.assert_allclose(683.002 * 106.857 * np.array(bands), luminance, rtol=2e-3)


def small_layered(scene):
    """Let a scene be rendered small, with all passes in one file."""
    scene.render.engine = "LUMENRAY"
    scene.render.resolution_x, scene.render.resolution_y = 48, 32
    scene.render.resolution_percentage = 100
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"


def rendered(scene, path):
    """Render to a file; returns its channels by name without the layer's, and what is said of it."""
    openexr = pytest.importorskip("OpenEXR")
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    with openexr.File(str(path), separate_channels=True) as file:
        channels = {
            name.split(".", 1)[1]: channel.pixels.copy()
            for part in file.parts
            for name, channel in part.channels.items()
        }
    return channels, bpy.context.window_manager.lumenray.render


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("is_cropped", [True, False])
@pytest.mark.parametrize(
    "border",
    [(0.21, 0.63, 0.13, 0.71), (0.0, 0.5, 0.3, 1.0), (0.9, 0.7, 0.97, 0.6), (0.7, 0.98, 0.9, 1.0)],
)
def test_a_region_is_the_part_of_the_picture_that_blender_cuts(tmp_path, border, is_cropped):
    tiny.build_closed_box()
    add_camera((0, 0, 0), (1.2, 0.7, 0.4), lens=24.0)
    scene = bpy.context.scene
    small_layered(scene)
    scene.view_layers[0].use_pass_z = True
    scene.lumenray.render.samples = 2
    whole, _ = rendered(scene, tmp_path / "whole.exr")
    render = scene.render
    render.use_border, render.use_crop_to_border = True, is_cropped
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = border
    try:
        part, _ = rendered(scene, tmp_path / "part.exr")
    except RuntimeError as error:
        # Blender itself refuses what has no pixels.
        assert "too small" in str(error)
        assert border[0] > border[1]
        return
    depth = next(name for name in whole if name.startswith(("Depth", "Z")))
    left, right, low, high = (
        int(np.float32(share) * np.float32(size))
        for share, size in zip(border, (48, 48, 32, 32), strict=True)
    )
    expected = whole[depth][32 - high : 32 - low, left:right]
    found = part[depth]
    if not is_cropped:
        assert found.shape == (32, 48)
        outside = np.ones(found.shape, dtype=bool)
        outside[32 - high : 32 - low, left:right] = False
        assert not part["Combined.R"][outside].any()
        found = found[32 - high : 32 - low, left:right]
    np.testing.assert_allclose(found, expected, rtol=1e-4)


@pytest.mark.skipif(find_denoiser() is None, reason="Open Image Denoise is not installed")
def test_denoising_changes_what_is_seen_but_no_luminance_and_is_told(tmp_path):
    tiny.build_closed_box()
    add_camera((0, 0, 0), (1.2, 0.0, 0.4), lens=24.0)
    scene = bpy.context.scene
    small_layered(scene)
    settings = scene.lumenray.render
    settings.samples = 4
    raw, said = rendered(scene, tmp_path / "raw.exr")
    assert "denoised" not in said
    settings.use_denoising = True
    made, said = rendered(scene, tmp_path / "made.exr")
    assert ", denoised by Open Image Denoise" in said
    name = next(name for name in raw if name.startswith("Luminance."))
    np.testing.assert_array_equal(made[name], raw[name])
    # It takes noise out, not light.
    seen, before = made["Combined.G"], raw["Combined.G"]
    assert np.abs(np.diff(seen)).mean() < 0.5 * np.abs(np.diff(before)).mean()
    assert seen.mean() == pytest.approx(before.mean(), rel=0.01)


def test_where_the_denoiser_is_missing_the_picture_is_as_computed_and_that_is_told(
    tmp_path, monkeypatch
):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    tiny.build_closed_box()
    scene = bpy.context.scene
    small_layered(scene)
    scene.lumenray.render.samples = 4
    raw, _ = rendered(scene, tmp_path / "raw.exr")
    scene.lumenray.render.use_denoising = True
    made, said = rendered(scene, tmp_path / "made.exr")
    np.testing.assert_array_equal(made["Combined.G"], raw["Combined.G"])
    assert "denoised" not in said


def test_blender_s_own_denoiser_gets_its_guides_by_the_names_that_cycles_gives_them(tmp_path):
    openexr = pytest.importorskip("OpenEXR")
    tiny.build_closed_box()
    scene = bpy.context.scene
    small_layered(scene)
    scene.lumenray.render.samples = 4
    raw, _ = rendered(scene, tmp_path / "raw.exr")
    assert not any(name.startswith("Denoising") for name in raw)
    scene.lumenray.render.use_pass_denoising = True
    found, _ = rendered(scene, tmp_path / "guides.exr")
    assert {name for name in found if name.startswith("Denoising")} == {
        *(f"Denoising Albedo.{c}" for c in "RGB"),
        *(f"Denoising Normal.{c}" for c in "XYZ"),
        "Denoising Depth.Z",
    }
    assert np.median(found["Denoising Albedo.G"]) == pytest.approx(0.5, abs=1e-3)
    length = sum(found[f"Denoising Normal.{c}"] ** 2 for c in "XYZ")
    assert np.median(length) == pytest.approx(1.0, abs=1e-3)
    assert 0.5 < found["Denoising Depth.Z"].min() < found["Denoising Depth.Z"].max() < 3.0
    np.testing.assert_array_equal(found["Combined.G"], raw["Combined.G"])

    nodes, output = compositor(scene)
    layers = nodes.nodes.new("CompositorNodeRLayers")
    filtering = nodes.nodes.new("CompositorNodeDenoise")
    for source, target in (
        ("Image", "Image"),
        ("Denoising Albedo", "Albedo"),
        ("Denoising Normal", "Normal"),
    ):
        nodes.links.new(layers.outputs[source], filtering.inputs[target])
    nodes.links.new(filtering.outputs[0], output)
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(tmp_path / "composed.exr")
    bpy.ops.render.render(write_still=True)
    with openexr.File(scene.render.filepath, separate_channels=True) as file:
        made = file.channels()["G"].pixels
    assert np.abs(np.diff(made)).mean() < 0.5 * np.abs(np.diff(raw["Combined.G"])).mean()
    assert np.median(made) == pytest.approx(np.median(raw["Combined.G"]), rel=0.1)


def compositor(scene):
    """Return a scene's tree of the compositor, emptied, and the socket that its result goes to."""
    if hasattr(scene, "compositing_node_group"):
        tree = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        scene.compositing_node_group = tree
        return tree, tree.nodes.new("NodeGroupOutput").inputs[0]
    scene.use_nodes = True
    scene.node_tree.nodes.clear()
    return scene.node_tree, scene.node_tree.nodes.new("CompositorNodeComposite").inputs[0]


def test_samples_and_error_of_a_render_stay_in_the_header_and_in_the_file(tmp_path):
    tiny.build_closed_box()
    scene = bpy.context.scene
    scene.render.engine = "LUMENRAY"
    scene.render.resolution_x, scene.render.resolution_y = 24, 16
    scene.render.resolution_percentage = 100
    scene.lumenray.render.samples = 8
    scene.lumenray.render.method = "PATHS"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = str(tmp_path / "box.exr")
    bpy.ops.render.render(write_still=True)
    said = bpy.context.window_manager.lumenray.render
    assert re.match(r"8 samples, error [0-9.]+ %, [0-9]+ s", said)
    openexr = pytest.importorskip("OpenEXR")
    with openexr.File(str(tmp_path / "box.exr")) as file:
        assert file.header()["Lumenray"] == said
        assert "full paths are asked for" in file.header()["Lumenray Decisions"]
    shown = Layout()
    image = types.SimpleNamespace(type="RENDER_RESULT")
    where = context(space_data=types.SimpleNamespace(image=image))
    image_header.draw_error(types.SimpleNamespace(layout=shown), where)
    assert shown.seen == [said]
    # Another picture in the editor, or another engine, is not spoken for.
    image.type = "IMAGE"
    image_header.draw_error(types.SimpleNamespace(layout=shown), where)
    assert shown.seen == [said]


def test_a_scene_without_camera_fails_in_words(tmp_path, capsys):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "empty.blend"))
    code = command_line.main(
        ["render", str(tmp_path / "empty.blend"), "-o", str(tmp_path / "a.exr")]
    )
    assert code == 1
    assert "no camera" in capsys.readouterr().err


@pytest.mark.parametrize(
    "name",
    [
        "ignis_lights",
        "ignis_technique_scene",
        "ignis_Office",
        "gltf_05_metallic_sphere_light",
        "armory_light_area",
    ],
)
def test_foreign_files_open_and_render(name, tmp_path):
    path = FOREIGN / f"{name}.blend"
    if not path.exists():
        pytest.skip(f"{path} is not there (set LUMENRAY_BLEND_FILES)")
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    made = converted_scene()
    if made.camera is None:
        assert name == "ignis_Office"
        return
    assert made.camera.projection is Projection.PERSPECTIVE
    code = command_line.main(
        ["render", str(path), "-o", str(tmp_path / "a.exr"), "--size", "32x24", "--samples", "4",
         "--accept-missing"]
    )  # fmt: skip
    assert code in {0, ASSUMED}
