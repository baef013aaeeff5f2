"""From a Blender file to numbers: render engine, bake operator, command line, foreign files."""

import json
import os
import re
import types
from pathlib import Path

import bpy
import lumenray
import numpy as np
import pytest
from lumenray.blender_addon.assumptions import ASSUMED
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.command_line import main as command_line
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Projection
from lumenray.engine.scene.scene import Scene
from lumenray.engine.session import Session
from lumenray.libraries import scenes
from lumenray.libraries.scenes import tiny
from lumenray.ui import image_header
from panels import Layout, context

FOREIGN = Path(os.environ.get("LUMENRAY_BLEND_FILES", "nowhere"))


@pytest.fixture(autouse=True)
def _operators(registered):
    lumenray.register()


def convert():
    return convert_scene(bpy.context.evaluated_depsgraph_get())


def read(position, normal=(0, 0, 1), samples=1 << 14):
    session = Session(witness=False)
    session.apply(convert().delta)
    made = session.measure([position], [normal], StopRule(samples=samples))
    return made.illuminance[0], made.standard_error[0]


def add_light(kind, location=(0, 0, 1), **settings):
    data = bpy.data.lights.new("Light", kind)
    for key, value in settings.items():
        setattr(data, key, value)
    item = bpy.data.objects.new("Light", data)
    item.location = location
    bpy.context.scene.collection.objects.link(item)
    return item


# ---- Blender's own watts ----


@pytest.mark.parametrize(
    ("kind", "settings", "watts_to_irradiance"),
    [
        ("POINT", {"shadow_soft_size": 0.0}, 1 / (4 * np.pi)),
        ("POINT", {"shadow_soft_size": 0.1}, 1 / (4 * np.pi)),
        ("SPOT", {"shadow_soft_size": 0.0, "spot_size": 1.0}, 1 / (4 * np.pi)),
        ("SUN", {"angle": 0.01}, 1.0),
        ("AREA", {"size": 0.01}, 1 / np.pi),
        ("AREA", {"size": 0.01, "shape": "DISK"}, 1 / np.pi),
    ],
    ids=str,
)
def test_plain_blender_watts_keep_their_meaning(kind, settings, watts_to_irradiance):
    add_light(kind, energy=10.0, color=(1.0, 0.5, 0.25), **settings)
    luma = 0.2126 + 0.7152 * 0.5 + 0.0722 * 0.25
    expected = 10.0 * luma * 177.83 * watts_to_irradiance
    value, error = read((0, 0, 0))
    assert abs(value - expected) < 3 * error + 1e-3 * expected


def test_physical_parameters_replace_watts_and_colour_never_changes_lumens():
    light = add_light("POINT", energy=1.0, color=(1.0, 0.1, 0.1), shadow_soft_size=0.0)
    light.data.lumenray.use_physical = True
    light.data.lumenray.quantity = "LUMINOUS_FLUX"
    light.data.lumenray.value = 100.0
    value, error = read((0, 0, 0))
    assert abs(value - 100 / (4 * np.pi)) < 3 * error + 0.003


def test_scene_units_scale_distances():
    add_light("POINT", location=(0, 0, 100), energy=10.0, shadow_soft_size=0.0)
    settings = bpy.context.scene.unit_settings
    settings.system, settings.scale_length = "METRIC", 0.01
    value, _ = read((0, 0, 0))
    assert value == pytest.approx(10.0 * 177.83 / (4 * np.pi), rel=1e-3)


def test_object_scale_enlarges_area_lights():
    light = add_light("AREA", location=(0, 0, 0.5), energy=10.0, size=1.0)
    light.scale = (2.0, 2.0, 2.0)
    session = Session(witness=False)
    session.apply(convert().delta)
    area = next(iter(session.scene.lights.values()))
    assert area.size_x == pytest.approx(2.0)


def test_a_quantity_that_does_not_fit_the_light_is_reported():
    light = add_light("SUN")
    light.data.lumenray.use_physical = True
    light.data.lumenray.quantity = "LUMINOUS_FLUX"
    made = convert()
    assert any("not defined for a sun" in row.message for row, _ in made.report.rows)


# ---- geometry and world ----


def cube(location=(0, 0, 0), scale=(1, 1, 1)):
    mesh = bpy.data.meshes.new("Cube")
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh.from_pydata(corners, [], faces)
    item = bpy.data.objects.new("Cube", mesh)
    item.location, item.scale = location, scale
    bpy.context.scene.collection.objects.link(item)
    return item


def meshes():
    bpy.context.view_layer.update()
    scene = Scene()
    scene.apply(convert().delta)
    return [scene.mesh(key) for key in scene.meshes]


def signed_volume(mesh):
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0


@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (-1, -1, -1), (2, -3, 1)])
def test_mirrored_objects_keep_their_outside_outside(scale):
    item = cube(scale=scale)
    for polygon in item.data.polygons:
        polygon.use_smooth = True
    (mesh,) = meshes()
    assert signed_volume(mesh) == pytest.approx(8.0 * abs(np.prod(scale)))
    corners = mesh.vertices[mesh.triangles]
    assert (np.einsum("tcx,tcx->tc", corners, mesh.corner_normals) > 0).all()


def test_hidden_objects_stay_out_and_instances_come_in():
    hidden = cube()
    hidden.hide_render = True
    group = bpy.data.collections.new("Group")
    member = cube(location=(5, 0, 0))
    bpy.context.scene.collection.objects.unlink(member)
    group.objects.link(member)
    for i in range(3):
        empty = bpy.data.objects.new(f"Empty {i}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", group
        empty.location = (0, 10.0 * i, 0)
        bpy.context.scene.collection.objects.link(empty)
    made = meshes()
    assert len(made) == 3
    assert len({m.id for m in made}) == 3
    assert sorted(round(m.vertices[:, 1].mean()) for m in made) == [0, 10, 20]


def world_with(colour, strength=1.0):
    world = bpy.data.worlds.new("World")
    bpy.context.scene.world = world
    world.use_nodes = True
    node = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    node.inputs["Color"].default_value = (*colour, 1.0)
    node.inputs["Strength"].default_value = strength
    return world, node


def test_the_world_has_the_unit_that_is_stated():
    world, _ = world_with((1, 1, 1), 2.0)
    assert read((0, 0, 0))[0] == pytest.approx(np.pi * 2 * 177.83, rel=2e-3)
    world.lumenray.unit = "LUMINANCE"
    assert read((0, 0, 0))[0] == pytest.approx(np.pi * 2, rel=2e-3)
    world.lumenray.unit = "ILLUMINANCE"
    world.lumenray.illuminance = 5000.0
    assert read((0, 0, 0))[0] == pytest.approx(5000.0, rel=2e-3)


def directional_world():
    """An environment that is bright around one direction only, turned about z."""
    world, node = world_with((0, 0, 0))
    image = bpy.data.images.new("Sky", 64, 32, float_buffer=True)
    pixels = np.zeros((32, 64, 4), np.float32)
    pixels[..., 3] = 1.0
    pixels[20:24, 40:46, :3] = 50.0
    pixels[18:20, 10:14, :3] = (30.0, 5.0, 5.0)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    mapping = world.node_tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value[2] = 0.7
    where = world.node_tree.nodes.new("ShaderNodeTexCoord")
    links = world.node_tree.links
    links.new(where.outputs["Generated"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], node.inputs["Color"])
    return world


def render_with(engine, camera_settings=None):
    """Render 48 x 32 pixels and return linear luminance, row 0 at the bottom."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.render.resolution_x, scene.render.resolution_y = 48, 32
    scene.render.resolution_percentage = 100
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    path = Path(bpy.app.tempdir) / f"{engine}.exr"
    scene.render.filepath = str(path)
    if engine == "CYCLES":
        scene.cycles.samples = 256
        scene.cycles.use_denoising = False
        scene.cycles.use_adaptive_sampling = False
        scene.cycles.device = "CPU"
    else:
        scene.lumenray.samples = 128
        scene.lumenray.white_luminance = scene.lumenray.efficacy
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path), check_existing=False)
    pixels = np.array(image.pixels[:], np.float32).reshape(32, 48, -1)
    bpy.data.images.remove(image)
    return pixels[..., :3]


def add_camera(location, rotation, **settings):
    data = bpy.data.cameras.new("Camera")
    for key, value in settings.items():
        setattr(data, key, value)
    item = bpy.data.objects.new("Camera", data)
    item.location, item.rotation_euler = location, rotation
    bpy.context.scene.collection.objects.link(item)
    bpy.context.scene.camera = item
    return item


HAS_CYCLES = "cycles" in bpy.context.preferences.addons or hasattr(bpy.types.Scene, "cycles")
needs_cycles = pytest.mark.skipif(not HAS_CYCLES, reason="this Blender has no Cycles")


@needs_cycles
@pytest.mark.parametrize("view", ["perspective", "shifted", "orthographic", "panorama"])
def test_pictures_agree_with_cycles(view):
    cube(location=(0, 0, 0))
    floor = cube(location=(0, 0, -1.5), scale=(6, 6, 0.4))
    paint = bpy.data.materials.new("Paint")
    paint.use_nodes = True
    nodes = paint.node_tree.nodes
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.7, 0.4, 0.2, 1.0)
    paint.node_tree.links.new(diffuse.outputs[0], nodes.get("Material Output").inputs["Surface"])
    for item in (bpy.data.objects["Cube"], floor):
        item.data.materials.append(paint)
    add_light("POINT", location=(2, -3, 3), energy=300.0, shadow_soft_size=0.3)
    add_light("AREA", location=(-3, -1, 3), energy=200.0, size=1.5)
    world_with((0.2, 0.3, 0.5), 0.5)
    settings = {
        "perspective": {"lens": 30.0},
        "shifted": {"lens": 40.0, "shift_x": 0.15, "shift_y": -0.1},
        "orthographic": {"type": "ORTHO", "ortho_scale": 7.0},
        "panorama": {"type": "PANO"},
    }[view]
    add_camera((5, -6, 4), (1.1, 0, 0.7), **settings)
    if view == "panorama":
        data = bpy.context.scene.camera.data
        holder = data if hasattr(data, "panorama_type") else data.cycles
        holder.panorama_type = "EQUIRECTANGULAR"
    ours, theirs = render_with("LUMENRAY"), render_with("CYCLES")

    # Blocks of 8 x 8 pixels even out noise; upsampled spectra and RGB differ a little in colour.
    def blocks(picture):
        return picture.reshape(4, 8, 6, 8, 3).mean(axis=(1, 3))

    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.03)
    assert np.abs(blocks(ours) - blocks(theirs)).max() < 0.08 * blocks(theirs).max()


@needs_cycles
@pytest.mark.slow
def test_environments_are_turned_like_cycles_turns_them():
    directional_world()
    add_camera((0, 0, 0), (1.4, 0.0, 0.0), lens=12.0)
    compared = 0
    for angle in (0.0, 2.0, 4.0):
        bpy.context.scene.camera.rotation_euler[2] = angle
        ours, theirs = render_with("LUMENRAY"), render_with("CYCLES")
        if theirs.max() < 1.0:
            continue
        # The bright patches must fall on the same pixels.
        a, b = ours.sum(axis=2), theirs.sum(axis=2)
        assert (a * b).sum() / np.sqrt((a**2).sum() * (b**2).sum()) > 0.97
        compared += 1
    assert compared, "no view saw a bright patch"


# ---- render engine ----


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
    scene.lumenray.use_pass_illuminance = True
    scene.lumenray.use_spectral_file = True
    scene.lumenray.samples = 8
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
    assert set(np.unique(index)) <= {0.0, 5.0}
    # Spectral file beside the picture: its bands integrate to the luminance.
    spectral = next(tmp_path.glob("*_spectral.exr"))
    with openexr.File(str(spectral), separate_channels=True) as file:
        assert (
            sum(name.startswith("S0.") for name in file.channels()) == scene.lumenray.spectral_bands
        )


def test_samples_and_error_of_a_render_stay_in_the_header_and_in_the_file(tmp_path):
    tiny.build_closed_box()
    scene = bpy.context.scene
    scene.render.engine = "LUMENRAY"
    scene.render.resolution_x, scene.render.resolution_y = 24, 16
    scene.render.resolution_percentage = 100
    scene.lumenray.samples = 8
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = str(tmp_path / "box.exr")
    bpy.ops.render.render(write_still=True)
    said = bpy.context.window_manager.lumenray.render
    assert re.match(r"8 samples, error [0-9.]+ %, [0-9]+ s", said)
    openexr = pytest.importorskip("OpenEXR")
    with openexr.File(str(tmp_path / "box.exr")) as file:
        assert file.header()["Lumenray"] == said
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


# ---- bake ----


def test_the_bake_operator_writes_uv_map_image_and_files(tmp_path):
    tiny.build_closed_box()
    floor = bpy.data.objects["Floor"]
    users_own = floor.data.uv_layers.new(name="Mine")
    kept = np.array([d.vector[:] for d in users_own.uv])
    done = bpy.ops.lumenray.bake_illuminance(
        objects="Floor", density=16.0, samples=64, folder=str(tmp_path)
    )
    assert done == {"FINISHED"}
    assert {"Mine", "Lumenray"} <= {layer.name for layer in floor.data.uv_layers}
    assert np.array_equal(kept, np.array([d.vector[:] for d in floor.data.uv_layers["Mine"].uv]))
    image = floor.lumenray.baked_image
    assert image.name == "Lux atlas"
    assert image.is_float
    report = json.loads((tmp_path / "report.json").read_text())
    row = report["quantities"][0]
    # Mean over all walls is 83.33 lx (balance of flux); by symmetry the cube's floor has it too.
    assert abs(row["mean"] - 1000.0 / (24.0 * 0.5)) < 3 * row["mean_standard_error"] + 0.2
    values = np.array(image.pixels[:]).reshape(*reversed(image.size), 4)[..., 0]
    # Gutters hold what lumels hold, and nothing above them.
    low, high = row["maximum_range"]
    assert low < values.max() < high
    layer = np.array([d.vector[:] for d in floor.data.uv_layers["Lumenray"].uv])
    assert layer.min() >= 0.0
    assert layer.max() <= 1.0
    names = {path.name for path in tmp_path.iterdir()}
    assert {"report.json", "error.png"} <= names
    assert any(name.endswith(".exr") for name in names)
    assert any(name.endswith(".png") and name != "error.png" for name in names)


@pytest.mark.slow
def test_modifiers_that_change_faces_leave_the_map_on_disk_and_are_reported(tmp_path):
    tiny.build_closed_box()
    floor = bpy.data.objects["Floor"]
    floor.modifiers.new("Subdivision", "SUBSURF").subdivision_type = "SIMPLE"
    bpy.ops.lumenray.bake_illuminance(objects="Floor", density=4.0, samples=4, folder=str(tmp_path))
    assert "Lumenray" not in floor.data.uv_layers
    assert any(tmp_path.glob("*.exr"))
    rows = bpy.context.window_manager.lumenray.rows
    assert any("modifiers" in row.message for row in rows)


def test_the_bake_operator_refuses_unknown_objects_in_words(tmp_path):
    with pytest.raises(RuntimeError, match="no object named Ghost"):
        bpy.ops.lumenray.bake_illuminance(objects="Ghost", folder=str(tmp_path))


# ---- command line ----


def test_the_command_line_measures_the_inverse_square_law(tmp_path):
    (tmp_path / "in.csv").write_text("x,y,z,nx,ny,nz\n0,0,0,0,0,1\n0,0,0.5,0,0,1\n")
    code = command_line.main(
        ["measure", str(scenes.scene_path("inverse_square")), "--sensors", str(tmp_path / "in.csv"),
         "-o", str(tmp_path / "out.csv"), "--samples", "4096"]
    )  # fmt: skip
    assert code == 0
    rows = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True)
    assert rows["illuminance_lx"][0] == pytest.approx(7.9577, rel=2e-3)
    assert rows["illuminance_lx"][1] == pytest.approx(4 * 7.9577, rel=2e-3)
    assert (rows["standard_error_lx"] < 0.01).all()


@pytest.mark.slow
def test_the_command_line_bakes_and_renders(tmp_path, capsys):
    box = str(scenes.scene_path("closed_box"))
    assert (
        command_line.main(
            [
                "bake",
                box,
                "-o",
                str(tmp_path),
                "--objects",
                "Floor",
                "--density",
                "4",
                "--samples",
                "16",
                "--save",
                str(tmp_path / "saved.blend"),
            ]
        )
        == 0
    )
    assert "Floor" in capsys.readouterr().out
    assert (tmp_path / "saved.blend").exists()
    out = tmp_path / "p.exr"
    assert (
        command_line.main(["render", box, "-o", str(out), "--size", "16x12", "--samples", "4"]) == 0
    )
    assert out.exists()
    assert out.with_suffix(".png").exists()
    assert json.loads(out.with_suffix(".json").read_text())["quantities"][0]["unit"] == "cd/m2"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["render", "nowhere.blend", "-o", "a.exr"], "no such file"),
        (["bake", "BOX", "-o", "out", "--objects", "Ghost"], "no object named Ghost"),
        (["measure", "BOX", "--sensors", "none.csv", "-o", "out.csv"], "cannot be opened"),
        (["render", "NOISE", "-o", "a.exr"], "cannot open"),
    ],
)
def test_every_failure_is_one_line_and_a_code(tmp_path, capsys, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "noise.blend").write_bytes(b"this is no Blender file")
    places = {"BOX": str(scenes.scene_path("closed_box")), "NOISE": "noise.blend"}
    assert command_line.main([places.get(a, a) for a in arguments]) == 1
    error = capsys.readouterr().err.strip()
    assert words in error
    assert len(error.splitlines()) == 1


# ---- foreign files ----


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
    made = convert_scene(bpy.context.evaluated_depsgraph_get(), ConversionReport())
    if made.camera is None:
        assert name == "ignis_Office"
        return
    assert made.camera.projection is Projection.PERSPECTIVE
    code = command_line.main(
        ["render", str(path), "-o", str(tmp_path / "a.exr"), "--size", "32x24", "--samples", "4",
         "--accept-missing"]
    )  # fmt: skip
    assert code in {0, ASSUMED}
