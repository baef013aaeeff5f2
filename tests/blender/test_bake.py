"""What a bake leaves in Blender: UV maps, images, light groups, and a look in EEVEE that can be taken away again."""

import json
import time
from dataclasses import replace
from types import SimpleNamespace

import bpy
import lumenray
import numpy as np
import pytest
from fake_bakes import (
    ERROR,
    SIZE,
    FakeSession,
    illuminance_at,
    lay_out,
    make_map,
    make_page,
    make_result,
    share_of,
    with_back,
)
from lumenray.blender_addon.assumptions import UNREACHED
from lumenray.blender_addon.bake import folders as bake_folders
from lumenray.blender_addon.bake import images as baked_images
from lumenray.blender_addon.bake import job as bake
from lumenray.blender_addon.bake import light_groups
from lumenray.blender_addon.bake import look as baked_look
from lumenray.blender_addon.bake import uv_maps as baked_layout
from lumenray.blender_addon.bake.error_graph import ErrorGraph
from lumenray.blender_addon.bake.nodes import PLACE
from lumenray.blender_addon.foundation import engine_process
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.command_line import main as command_line
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.analysis.false_colour import colours
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.errors import Cancelled, LumenrayError
from lumenray.engine.scene.scene import Scene
from lumenray.engine.session import Session
from lumenray.libraries.scenes import tiny
from panels import context, draw, interface


@pytest.fixture(autouse=True)
def _operators(registered):
    lumenray.register()


@pytest.fixture
def fake(monkeypatch):
    """Let a fake engine bake, and return it."""
    session = FakeSession()
    monkeypatch.setattr(engine_process, "open_session", lambda _: session)
    return session


def add_quad(name, x=0.0, material=None, mesh=None):
    """Add a unit square that faces up, with its lower left corner at x."""
    if mesh is None:
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
        if material is not None:
            mesh.materials.append(material)
    item = bpy.data.objects.new(name, mesh)
    item.location.x = x
    bpy.context.scene.collection.objects.link(item)
    bpy.context.view_layer.update()
    return item


def add_light(name, group="", value=1000.0):
    light = bpy.data.lights.new(name, "POINT")
    light.lumenray.use_physical = True
    light.lumenray.value = value
    light.lumenray.light_group = group
    item = bpy.data.objects.new(name, light)
    item.location.z = 2.0
    bpy.context.scene.collection.objects.link(item)
    return item


def new_material(name, *shaders):
    """A material of one shader, or of two mixed half and half."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    made = [tree.nodes.new(kind) for kind in shaders]
    if len(made) == 2:
        mix = tree.nodes.new("ShaderNodeMixShader")
        for socket, shader in zip(mix.inputs[1:], made, strict=True):
            tree.links.new(shader.outputs[0], socket)
        made = [mix]
    tree.links.new(made[0].outputs[0], output.inputs["Surface"])
    return material


def bake_all(folder, **options):
    names = ",".join(item.name for item in bpy.context.scene.objects if item.type == "MESH")
    assert bpy.ops.lumenray.bake_illuminance(objects=names, folder=str(folder), **options) == {
        "FINISHED"
    }


def uv_of(item, name=baked_layout.UV_MAP):
    layer = item.data.uv_layers[name]
    values = np.empty(2 * len(layer.uv), np.float32)
    layer.uv.foreach_get("vector", values)
    return values.reshape(-1, 2)


def pixels_of(image):
    width, height = image.size
    values = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(height, width, 4)


def dump(tree):
    """All that a node tree says, as text."""
    nodes = []
    for node in tree.nodes:
        sockets = [
            (s.identifier, str(s.default_value[:] if hasattr(s.default_value, "__len__") else s.default_value))
            for s in node.inputs
            if hasattr(s, "default_value")
        ]  # fmt: skip
        active = getattr(node, "is_active_output", None), getattr(node, "target", None)
        nodes.append((node.name, node.bl_idname, tuple(node.location), sockets, active))
    links = [
        (k.from_node.name, k.from_socket.identifier, k.to_node.name, k.to_socket.identifier)
        for k in tree.links
    ]
    return json.dumps([nodes, sorted(links)])


# ---- results in the file ----


def test_one_page_becomes_one_image_and_the_uv_map_is_the_layout(fake, tmp_path):
    floor = add_quad("Floor")
    bake_all(tmp_path)
    (mesh,) = [fake.scene.mesh(key) for key in fake.scene.meshes]
    layout = lay_out(mesh, 0)
    uv = uv_of(floor)
    # Corners of the quad by vertex, as its only polygon has each once.
    pairs = zip(layout.triangles.ravel(), layout.uv.reshape(-1, 2), strict=True)
    expected = {int(vertex): tuple(place) for vertex, place in pairs}
    for corner, place in zip(floor.data.loops, uv, strict=True):
        assert place == pytest.approx(expected[corner.vertex_index], abs=1e-6)
    image = floor.lumenray.baked_image
    assert image.name == "Lux atlas"
    assert image.is_float
    assert image.colorspace_settings.name == "Non-Color"
    assert image.packed_file is not None
    np.testing.assert_array_equal(pixels_of(image)[..., 0], make_page(0).illuminance)
    facts = image["lumenray"]
    assert facts["unit"] == "lx"
    assert facts["quantity"] == "illuminance"
    assert facts["scene_hash"] == "hash"
    assert facts["relative_standard_error"] == ERROR
    assert facts["samples"] == 64.0


def test_several_pages_become_tiles_that_survive_saving(fake, tmp_path):
    quads = [add_quad(f"Quad {number:02d}", 2.0 * number) for number in range(12)]
    bake_all(tmp_path / "lux")
    image = quads[0].lumenray.baked_image
    assert [tile.number for tile in image.tiles] == [1001 + number for number in range(12)]
    for number, quad in enumerate(quads):
        uv = uv_of(quad)
        assert (np.floor(uv) == (number % 10, number // 10)).all()
    path = tmp_path / "kept.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    image = bpy.data.objects["Quad 11"].lumenray.baked_image
    assert len(image.packed_files) == 12
    folder = tmp_path / "unpacked"
    folder.mkdir()
    for packed in image.packed_files:
        (folder / packed.filepath.rpartition("/")[2]).write_bytes(packed.packed_file.data)
    for number in (0, 11):
        (file,) = folder.glob(f"*{1001 + number}.exr")
        loaded = bpy.data.images.load(str(file))
        loaded.colorspace_settings.name = "Non-Color"
        np.testing.assert_array_equal(pixels_of(loaded)[..., 0], make_page(number).illuminance)


def test_layers_and_exitance_become_images_and_add_up(fake, tmp_path):
    scene = bpy.context.scene
    floor = add_quad("Floor")
    add_light("Lamp A", "Ceiling")
    add_light("Lamp B", "Desk")
    scene.lumenray.bake_layers, scene.lumenray.bake_exitance = "GROUPS", True
    bake_all(tmp_path)
    layers = baked_images.layers_of(floor.lumenray.baked_image)
    assert list(layers) == ["Ceiling", "Desk", "rest"]
    assert layers["Desk"].name == "Lux atlas: Desk"
    total = sum(pixels_of(image)[..., 0] for image in layers.values())
    np.testing.assert_allclose(total, make_page(0).illuminance, rtol=1e-6)
    exitance = pixels_of(bpy.data.images["Exitance atlas"])[..., :3]
    # Equal X : Y : Z as daylight has: white, of the luminance Y.
    np.testing.assert_allclose(
        exitance, make_page(0).illuminance[..., None].repeat(3, 2), rtol=2e-3
    )
    assert exitance @ (0.2126, 0.7152, 0.0722) == pytest.approx(make_page(0).illuminance, rel=1e-3)
    assert [row.name for row in scene.lumenray.baked_layers] == ["Ceiling", "Desk", "rest"]


def test_many_layers_are_put_together_without_losing_light(fake, tmp_path):
    floor = add_quad("Floor")
    for number in range(9):
        add_light(f"Lamp {number}")
    bpy.context.scene.lumenray.bake_layers = "EACH"
    bake_all(tmp_path)
    layers = baked_images.layers_of(floor.lumenray.baked_image)
    assert len(layers) == baked_images.MOST_LAYERS
    assert baked_images.OTHERS in layers
    total = sum(pixels_of(image)[..., 0] for image in layers.values())
    np.testing.assert_allclose(total, make_page(0).illuminance, rtol=1e-5)
    rows = bpy.context.window_manager.lumenray.rows
    assert any("layers are more than" in row.message for row in rows)


def test_a_second_bake_of_other_objects_leaves_the_first_atlas_where_it_lies(fake, tmp_path):
    first, second = add_quad("First"), add_quad("Second", 3.0)
    for names in ("First", "Second"):
        bpy.ops.lumenray.bake_illuminance(objects=names, folder=str(tmp_path))
    images = [item.lumenray.baked_image for item in (first, second)]
    assert images[0] != images[1]
    bake_all(tmp_path)
    # Nothing lies on the old ones any more.
    assert first.lumenray.baked_image == second.lumenray.baked_image
    assert len([image for image in bpy.data.images if baked_images.facts_of(image)]) == 1


def test_polygons_whose_triangles_lie_apart_are_reported():
    floor = add_quad("Floor")
    order = BakeOrder(("x",), StopRule(samples=1))
    scene = Scene()
    scene.apply(convert_scene(bpy.context.evaluated_depsgraph_get()).delta)
    (mesh,) = [scene.mesh(key) for key in scene.meshes]
    made = make_map(mesh, 0, 0, order)
    made.layout.uv[1] += 0.3
    report = ConversionReport()
    result = make_result([made], [make_page(0)])
    baked_layout.store_layouts(result, {mesh.id: floor}, report)
    assert any("1 faces with more than three corners" in row.message for row, _ in report.rows)


def test_triangles_without_a_place_do_not_spoil_their_neighbours(fake, tmp_path):
    floor = add_quad("Floor")
    scene = Scene()
    scene.apply(convert_scene(bpy.context.evaluated_depsgraph_get()).delta)
    (mesh,) = [scene.mesh(key) for key in scene.meshes]
    layout = lay_out(mesh, 0)
    whole = baked_layout.match_corners(floor.data, layout, layout.uv)
    layout.page[0], layout.uv[0] = -1, 0.0
    part = baked_layout.match_corners(floor.data, layout, layout.uv)
    placed = {int(v) for v in layout.triangles[1]}
    for corner, (a, b) in zip(floor.data.loops, zip(whole.uv, part.uv, strict=True), strict=True):
        if corner.vertex_index in placed:
            assert b == pytest.approx(a)
    assert part.split == 0


def test_a_mesh_without_room_for_a_uv_map_is_reported(fake, tmp_path):
    floor = add_quad("Floor")
    for number in range(8):
        floor.data.uv_layers.new(name=f"Map {number}")
    bake_all(tmp_path)
    rows = bpy.context.window_manager.lumenray.rows
    assert any("8 UV maps already" in row.message for row in rows)
    assert floor.lumenray.baked_image is None


# ---- the order ----


def test_settings_reach_the_engine(fake, tmp_path):
    settings = bpy.context.scene.lumenray
    floor = add_quad("Floor")
    floor.lumenray.density, floor.lumenray.two_sided = 3.0, True
    for name, value in {
        "bake_density": 7.0, "bake_from_textures": True, "bake_size": 512, "bake_pages": 3, "bake_margin": 6,
        "bake_cone": 0.5, "bake_detail": 0.1, "bake_exitance": True, "bake_smooth": True, "bake_method": "PATHS",
        "bake_caustics": "OFF", "bake_use_error": True, "bake_error": 0.01, "bake_use_absolute": True,
        "bake_absolute": 4.0, "bake_use_time": True, "bake_time": 9.0, "seed": 5,
    }.items():  # fmt: skip
        setattr(settings, name, value)
    bake_all(tmp_path)
    order = fake.order
    (key,) = order.objects
    assert order.densities == {key: 3.0}
    assert order.two_sided == (key,)
    wanted = (
        7.0,
        True,
        512,
        3,
        6,
        pytest.approx(0.5),
        pytest.approx(0.1),
        True,
        True,
        "paths",
        "off",
        5,
    )
    found = (order.density, order.from_textures, order.largest, order.pages, order.margin, order.cone, order.detail,
             order.exitance, order.smooth, order.method, order.caustics, order.seed)  # fmt: skip
    assert found == wanted
    rule = order.rule
    assert (rule.samples, rule.error, rule.seconds, rule.absolute) == (
        None, pytest.approx(0.01), pytest.approx(9.0), 4.0,
    )  # fmt: skip
    assert order.checkpoint == str(tmp_path / bake_folders.CHECKPOINT)


def test_a_rule_of_a_script_stands_alone(fake, tmp_path):
    add_quad("Floor")
    bake_all(tmp_path, absolute=2.0, density=5.0)
    rule = fake.order.rule
    assert (rule.samples, rule.error, rule.seconds, rule.absolute) == (None, None, None, 2.0)
    assert fake.order.density == 5.0


def test_a_rule_with_nothing_on_is_refused_in_words(fake, tmp_path):
    add_quad("Floor")
    bpy.context.scene.lumenray.bake_use_error = False
    with pytest.raises(RuntimeError, match="no stopping rule"):
        bake_all(tmp_path)


def test_only_a_bake_that_is_there_is_resumed(fake, tmp_path):
    add_quad("Floor")
    with pytest.raises(RuntimeError, match="no interrupted bake"):
        bake_all(tmp_path, resume=True)
    kept = tmp_path / bake_folders.CHECKPOINT
    kept.write_bytes(b"state")
    bpy.context.scene.lumenray.bake_checkpoint = False
    bake_all(tmp_path, resume=True)
    assert kept.read_bytes() == b"state"
    assert fake.order.checkpoint == str(kept)


def test_a_new_bake_forgets_the_interrupted_one(fake, tmp_path, monkeypatch):
    add_quad("Floor")
    bake_all(tmp_path)
    kept = tmp_path / bake_folders.CHECKPOINT
    kept.write_bytes(b"state")
    seen = []
    real = fake.bake_objects
    monkeypatch.setattr(fake, "bake_objects", lambda *a: (seen.append(kept.exists()), real(*a))[1])
    bake_all(tmp_path)
    assert seen == [False]


# ---- light groups ----


def find(mode):
    converted = convert_scene(bpy.context.evaluated_depsgraph_get())
    return light_groups.find_groups(converted.delta.changed, bpy.context.scene.world, mode)


def lamp_world(group):
    world = bpy.data.worlds.new("World")
    bpy.context.scene.world = world
    if world.node_tree is None:
        world.use_nodes = True
    world.lumenray.light_group = group


def test_groups_hold_lights_glowing_materials_and_the_world():
    lamps = [add_light("A", "Ceiling"), add_light("B", "Ceiling"), add_light("C")]
    # The name of what is left over.
    add_light("D", "rest")
    glow = new_material("Glow", "ShaderNodeEmission")
    glow.lumenray.light_group = "Signs"
    dark = new_material("Dark", "ShaderNodeBsdfDiffuse")
    dark.lumenray.light_group = "Signs"
    add_quad("Sign", material=glow)
    add_quad("Wall", 2.0, material=dark)
    lamp_world("Daylight")
    groups = {group.name: group.members for group in find("groups")}
    assert set(groups) == {"Ceiling", "Signs", "Daylight"}
    assert groups["Ceiling"] == tuple(sorted(f"light:{lamp.lumenray.uid}" for lamp in lamps[:2]))
    assert groups["Signs"] == (f"material:{glow.lumenray.uid}",)
    assert groups["Daylight"] == ("world",)
    assert find("none") == ()


def test_instances_of_a_light_belong_to_its_group():
    lamp = add_light("Lamp", "Row")
    row = bpy.data.collections.new("Row")
    bpy.context.scene.collection.objects.unlink(lamp)
    row.objects.link(lamp)
    for number in range(3):
        empty = bpy.data.objects.new(f"Place {number}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", row
        empty.location.x = number
        bpy.context.scene.collection.objects.link(empty)
    (group,) = find("groups")
    assert len(group.members) == 3
    assert len(find("each")) == 3


def test_each_luminaire_gets_a_layer_of_its_own_name():
    for name in ("Lamp", "Lamp.001"):
        add_light(name)
    lamp_world("")
    assert [group.name for group in find("each")] == ["Lamp", "Lamp.001", "World"]
    for number in range(light_groups.MOST):
        add_light(f"More {number}")
    with pytest.raises(LumenrayError, match="light groups"):
        find("each")


# ---- the look in EEVEE ----


def render(look="LIGHT", size=8):
    """Let Cycles show the middle of the first quad as EEVEE would, without any light but what is baked. (h, w, 3)"""
    scene = bpy.context.scene
    scene.lumenray.baked_look = look
    for material in bpy.data.materials:
        for node in material.node_tree.nodes:
            if node.bl_idname == "ShaderNodeOutputMaterial" and node.target == "EEVEE":
                node.target = "CYCLES"
    if scene.camera is None:
        camera = bpy.data.cameras.new("Camera")
        camera.type, camera.ortho_scale = "ORTHO", 1.0
        scene.camera = bpy.data.objects.new("Camera", camera)
        scene.camera.location = (0.5, 0.5, 1.0)
        scene.collection.objects.link(scene.camera)
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    scene.cycles.samples = 1
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.filter_width = 0.01
    scene.render.filepath = f"{bpy.app.tempdir}look.exr"
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    values = pixels_of(image)[..., :3].copy()
    bpy.data.images.remove(image)
    return values


def expected_light(page=0, size=8):
    """Illuminance over the quad, which covers 0.1 .. 0.9 of its page. (h, w)"""
    places = 0.1 + 0.8 * (np.arange(size) + 0.5) / size
    return illuminance_at(page, places[None, :], places[:, None])


@pytest.fixture
def paint():
    material = new_material("Paint", "ShaderNodeBsdfDiffuse")
    material.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0.6, 0.3, 0.1, 1.0)
    return material


def test_baked_light_is_base_colour_times_illuminance_over_pi_and_white(fake, tmp_path, paint):
    add_quad("Floor", material=paint)
    bake_all(tmp_path)
    settings = bpy.context.scene.lumenray
    settings.white_luminance = 150.0
    assert bpy.ops.lumenray.show_baked() == {"FINISHED"}
    shown = render()
    expected = expected_light()[..., None] * (0.6, 0.3, 0.1) / np.pi / 150.0
    np.testing.assert_allclose(shown, expected, rtol=2e-3)
    # Exposure is a slider, not a new wiring.
    settings.exposure, settings.ev100 = "EV100", 8.0
    from lumenray.engine.photometry.units import luminance_from_ev100

    np.testing.assert_allclose(render(), expected * 150.0 / luminance_from_ev100(8.0), rtol=2e-3)


def test_tiles_lie_where_the_layout_says(fake, tmp_path, paint):
    add_quad("Other", 5.0, material=paint)
    add_quad("Floor", material=paint)
    bake_all(tmp_path)
    bpy.context.scene.lumenray.white_luminance = 100.0
    baked_look.show(bpy.context.scene)
    expected = expected_light(page=1)[..., None] * (0.6, 0.3, 0.1) / np.pi / 100.0
    np.testing.assert_allclose(render(), expected, rtol=2e-3)


def test_layers_dim_and_recolour_without_changing_the_amount(fake, tmp_path, paint):
    settings = bpy.context.scene.lumenray
    add_quad("Floor", material=paint)
    add_light("A", "Ceiling")
    add_light("B", "Desk")
    settings.bake_layers, settings.white_luminance = "GROUPS", 100.0
    bake_all(tmp_path)
    bpy.data.objects.remove(bpy.data.objects["A"])
    bpy.data.objects.remove(bpy.data.objects["B"])
    baked_look.show(bpy.context.scene)
    white = expected_light()[..., None] * (0.6, 0.3, 0.1) / np.pi / 100.0
    np.testing.assert_allclose(render(), white, rtol=2e-3)
    settings.baked_layers["Ceiling"].strength = 0.25
    dimmed = white * (1.0 - 0.75 * share_of(0, 3))
    np.testing.assert_allclose(render(), dimmed, rtol=2e-3)
    settings.baked_layers["Desk"].colour = (1.0, 0.5, 0.2)
    luma = np.array([0.2126, 0.7152, 0.0722])
    tint = np.array([1.0, 0.5, 0.2]) / (luma @ (1.0, 0.5, 0.2))
    expected = dimmed + white * share_of(1, 3) * (tint - 1.0)
    np.testing.assert_allclose(render(), expected, rtol=2e-3)
    # The false colours are those of the dimmed illuminance.
    settings.baked_low, settings.baked_high = 0.0, 600.0
    lux = expected_light() * (1.0 - 0.75 * share_of(0, 3))
    _check_false_colours(render("FALSE"), lux, 600.0)


def _check_false_colours(shown, lux, high):
    linear = np.clip(shown, 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    assert np.abs(255.0 * encoded - colours(lux, 0.0, high)).max() < 4.0


def test_false_colours_are_those_of_the_scale(fake, tmp_path, paint):
    add_quad("Floor", material=paint)
    bake_all(tmp_path)
    baked_look.show(bpy.context.scene)
    settings = bpy.context.scene.lumenray
    # Set by the bake to a round number that nearly all lumels lie under.
    assert settings.baked_high == 500.0
    _check_false_colours(render("FALSE"), expected_light(), 500.0)


def test_exitance_is_shown_as_it_was_baked(fake, tmp_path, paint):
    settings = bpy.context.scene.lumenray
    add_quad("Floor", material=paint)
    settings.bake_exitance, settings.white_luminance = True, 100.0
    bake_all(tmp_path)
    baked_look.show(bpy.context.scene)
    expected = expected_light()[..., None].repeat(3, 2) / np.pi / 100.0
    np.testing.assert_allclose(render("EXITANCE"), expected, rtol=4e-3)


def test_back_sides_show_their_own_light(fake, tmp_path, paint, monkeypatch):
    floor = add_quad("Floor", material=paint)
    add_quad("Other", 5.0, material=paint)
    real = fake.bake_objects
    monkeypatch.setattr(fake, "bake_objects", lambda *a: with_back(real(*a)))
    bake_all(tmp_path)
    assert {"Lumenray", "Lumenray Back"} <= {layer.name for layer in floor.data.uv_layers}
    bpy.context.scene.lumenray.white_luminance = 100.0
    baked_look.show(bpy.context.scene)
    front = render().mean()
    # Turned over, the quad shows its back to the camera.
    floor.scale.z, floor.rotation_euler.x, floor.location.y = 1.0, np.pi, 1.0
    expected = expected_light(page=1).mean() / expected_light(page=0).mean()
    assert render().mean() / front == pytest.approx(expected, rel=2e-3)


def test_unbaked_objects_of_the_same_material_keep_their_look(fake, tmp_path, paint):
    add_quad("Floor", material=paint)
    bake_all(tmp_path)
    bpy.data.objects["Floor"].location.x = 3.0
    add_quad("Plain", mesh=bpy.data.objects["Floor"].data)
    baked_look.show(bpy.context.scene)
    # There is no light, so that what is not baked is black.
    assert render().max() == 0.0


def test_objects_that_share_a_mesh_show_their_own_light(fake, tmp_path, paint):
    first = add_quad("First", material=paint)
    second = add_quad("Second", 5.0, mesh=first.data)
    bake_all(tmp_path)
    bpy.context.scene.lumenray.white_luminance = 100.0
    baked_look.show(bpy.context.scene)
    scale = np.array([0.6, 0.3, 0.1]) / np.pi / 100.0
    np.testing.assert_allclose(render(), expected_light(0)[..., None] * scale, rtol=2e-3)
    first.location.x, second.location.x = 5.0, 0.0
    np.testing.assert_allclose(render(), expected_light(1)[..., None] * scale, rtol=2e-3)


def test_own_light_is_shown_in_the_scenes_exposure(fake, tmp_path):
    glow = new_material("Glow", "ShaderNodeEmission")
    glow.node_tree.nodes["Emission"].inputs["Strength"].default_value = 2.0
    add_quad("Sign", material=glow)
    bake_all(tmp_path)
    settings = bpy.context.scene.lumenray
    settings.white_luminance = 100.0
    baked_look.show(bpy.context.scene)
    np.testing.assert_allclose(render(), 2.0 * settings.efficacy / 100.0, rtol=1e-3)
    baked_look.hide()
    own = glow.lumenray
    own.use_override, own.model, own.luminance = True, "EMITTER", 250.0
    own.spectrum, own.reflectance_color = "RGB", (1.0, 0.5, 0.5)
    baked_look.show(bpy.context.scene)
    shown = render()
    np.testing.assert_allclose(shown @ (0.2126, 0.7152, 0.0722), 2.5, rtol=1e-3)
    np.testing.assert_allclose(shown[..., 1] / shown[..., 0], 0.5, rtol=1e-3)


def test_mixes_keep_their_parts(fake, tmp_path):
    """Half of a surface that is half a hole is seen."""
    sheet = new_material("Sheet", "ShaderNodeBsdfTransparent", "ShaderNodeBsdfDiffuse")
    sheet.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0.5, 0.5, 0.5, 1.0)
    sheet.node_tree.nodes["Mix Shader"].inputs[0].default_value = 0.25
    add_quad("Sheet", material=sheet)
    bake_all(tmp_path)
    bpy.context.scene.lumenray.white_luminance = 100.0
    baked_look.show(bpy.context.scene)
    expected = 0.25 * expected_light()[..., None].repeat(3, 2) * 0.5 / np.pi / 100.0
    # One ray a pixel takes one part or the other.
    bpy.context.scene.cycles.samples = 1
    values = np.mean([_seeded_render(seed) for seed in range(24)], axis=0)
    assert values.mean() == pytest.approx(expected.mean(), rel=0.1)


def _seeded_render(seed):
    bpy.context.scene.cycles.seed = seed
    return render()


def test_back_takes_away_all_that_show_added(fake, tmp_path, paint):
    mixed = new_material("Mixed", "ShaderNodeBsdfPrincipled", "ShaderNodeBsdfGlass")
    own = new_material("Own output", "ShaderNodeBsdfPrincipled")
    user = own.node_tree.nodes.new("ShaderNodeOutputMaterial")
    user.target = "EEVEE"
    shader = own.node_tree.nodes["Principled BSDF"]
    own.node_tree.links.new(shader.outputs[0], user.inputs["Surface"])
    glass = new_material("Glass", "ShaderNodeBsdfGlass")
    bare = add_quad("Bare")
    empty = add_quad("Empty", 2.0)
    empty.data.materials.append(None)
    for number, material in enumerate((paint, mixed, own, glass), start=2):
        add_quad(f"Quad {number}", 2.0 * number, material=material)
    bake_all(tmp_path)
    kept = [paint, mixed, own, glass]
    before = [dump(material.node_tree) for material in kept]
    materials, groups = len(bpy.data.materials), len(bpy.data.node_groups)
    seen = [material.node_tree.get_output_node("CYCLES").name for material in kept]
    assert bpy.ops.lumenray.show_baked() == {"FINISHED"}
    for material in (paint, mixed, own):
        output = material.node_tree.get_output_node("EEVEE")
        assert output.get("lumenray_baked"), material.name
        assert output.inputs["Surface"].is_linked
    # Renders do not see it.
    assert [m.node_tree.get_output_node("CYCLES").name for m in kept] == seen
    assert glass.node_tree.get_output_node("EEVEE").name == "Material Output"
    assert bare.material_slots[0].material is not None
    assert bpy.ops.lumenray.hide_baked() == {"FINISHED"}
    assert [dump(material.node_tree) for material in kept] == before
    assert len(bpy.data.materials) == materials
    assert len(bpy.data.node_groups) == groups
    assert len(bare.material_slots) == 0
    assert [slot.material for slot in empty.material_slots] == [None]
    assert all(PLACE not in item for item in bpy.data.objects)
    assert not bpy.context.scene.lumenray.is_baked_shown


def test_the_engine_does_not_see_the_look(fake, tmp_path, paint):
    add_quad("Floor", material=paint)
    bake_all(tmp_path)

    def scene_hash():
        scene = Scene()
        scene.apply(convert_scene(bpy.context.evaluated_depsgraph_get()).delta)
        return scene.hash()

    before = scene_hash()
    baked_look.show(bpy.context.scene)
    assert scene_hash() == before
    # A bake does not see the material either that bare objects have for the look.
    add_quad("Bare", 3.0)
    hashes = []
    # The first bake gives the bare object a UV map, which is part of the scene.
    bake_all(tmp_path)
    for _ in range(2):
        fake.scene = Scene()
        bake_all(tmp_path)
        hashes.append(fake.scene.hash())
        assert bpy.context.scene.lumenray.is_baked_shown
        assert bpy.data.objects["Bare"].material_slots[0].material is not None
    assert hashes[0] == hashes[1]


def test_a_new_bake_keeps_the_look_and_the_sliders(fake, tmp_path, paint):
    settings = bpy.context.scene.lumenray
    add_quad("Floor", material=paint)
    add_light("A", "Ceiling")
    settings.bake_layers = "GROUPS"
    bake_all(tmp_path)
    baked_look.show(bpy.context.scene)
    settings.baked_layers["Ceiling"].strength = 0.5
    bake_all(tmp_path)
    assert settings.is_baked_shown
    assert settings.baked_layers["Ceiling"].strength == 0.5
    tree = paint.node_tree.get_output_node("EEVEE").inputs["Surface"].links[0].from_node.node_tree
    images = [node.image for node in tree.nodes if node.bl_idname == "ShaderNodeTexImage"]
    assert len(images) == 2
    assert all(image is not None for image in images)


def test_nothing_can_be_shown_before_a_bake():
    add_quad("Floor")
    assert not bpy.ops.lumenray.show_baked.poll()
    with pytest.raises(LumenrayError, match="nothing to show"):
        baked_look.show(bpy.context.scene)


# ---- panels ----


def test_panels_draw_what_is_there(fake, tmp_path, paint):
    with interface():
        add_quad("Floor", material=paint)
        add_light("A", "Ceiling")
        settings = bpy.context.scene.lumenray
        settings.bake_layers = "GROUPS"
        shading = bpy.types.View3DShading
        view = SimpleNamespace(shading=SimpleNamespace(type="MATERIAL", bl_rna=shading.bl_rna))
        assert draw("LUMENRAY_PT_baked_light", context(space_data=view)) is None
        bake_all(tmp_path)
        assert "lumenray.show_baked" in draw("LUMENRAY_PT_baked_light", context(space_data=view))
        baked_look.show(bpy.context.scene)
        seen = draw("LUMENRAY_PT_baked_light", context(space_data=view))
        assert {"lumenray.hide_baked", "baked_look", "LUMENRAY_UL_layers"} <= set(seen)
        settings.baked_look = "FALSE"
        assert "baked_high" in draw("LUMENRAY_PT_baked_light", context(space_data=view))
        said = draw("LUMENRAY_PT_results_whole", context())
        assert "to 80 %" in said
        for name in ("layout", "light", "output"):
            assert draw(f"LUMENRAY_PT_lux_bake_{name}", context())


def test_a_luminaire_that_is_an_empty_has_its_group_in_a_panel():
    with interface():
        empty = bpy.data.objects.new("Luminaire", None)
        bpy.context.scene.collection.objects.link(empty)
        assert draw("LUMENRAY_PT_luminaire_group", context(object=empty)) is None
        empty.lumenray.luminaire.use_file = True
        assert "light_group" in draw("LUMENRAY_PT_luminaire_group", context(object=empty))
        assert draw("LUMENRAY_PT_luminaire_group", context(object=empty, engine="CYCLES")) is None


def test_resume_is_offered_where_the_folder_holds_a_state(tmp_path):
    with interface():
        settings = bpy.context.scene.lumenray
        settings.bake_folder = str(tmp_path)
        item = add_quad("Floor")
        where = context(selected_objects=[item], object=item)
        assert draw("LUMENRAY_PT_bake", where).count("lumenray.bake_illuminance") == 1
        (tmp_path / bake_folders.CHECKPOINT).write_bytes(b"state")
        assert draw("LUMENRAY_PT_bake", where).count("lumenray.bake_illuminance") == 2


def test_the_graph_is_drawn_once_for_a_history():
    made = ErrorGraph()
    result = make_result([], [make_page(0)])
    assert made.icon(200, True) == 0
    made.note(result.history)
    assert made.icon(200, True) == 0
    end = time.monotonic() + 30.0
    while made.timer() is not None:
        assert time.monotonic() < end
        time.sleep(0.01)
    (icon,) = made._icons.values()
    assert tuple(icon.image_size) == (200, 150)
    made.icon(200, True)
    assert made.timer() is None
    made.note(None)
    assert not made.has_history
    made.close()


# ---- command line ----


def test_the_command_line_orders_what_it_is_told(monkeypatch, tmp_path, capsys):
    fake = FakeSession()
    from lumenray.engine import session

    monkeypatch.setattr(session, "Session", lambda: fake)
    add_quad("Floor")
    add_light("Lamp", "Ceiling")
    file = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    code = command_line.main(
        ["bake", str(file), "-o", str(tmp_path / "lux"), "--density", "11", "--size", "256", "--pages", "2",
         "--margin", "3", "--absolute", "4", "--time", "7", "--layers", "groups", "--exitance", "--smooth",
         "--method", "cells", "--caustics", "on", "--save", str(tmp_path / "out.blend")]
    )  # fmt: skip
    # What the fake one gives is less exact than that.
    assert code == UNREACHED
    order = fake.order
    assert (order.density, order.largest, order.pages, order.margin) == (11.0, 256, 2, 3)
    assert (order.exitance, order.smooth, order.method, order.caustics) == (
        True,
        True,
        "cells",
        "on",
    )
    assert (order.rule.absolute, order.rule.seconds, order.rule.error) == (4.0, 7.0, None)
    assert [group.name for group in order.groups] == ["Ceiling"]
    said = capsys.readouterr().out
    assert "after 1.0 s the forecast was 12 s (-4.2 %)" in said
    assert "seams: 120 places" in said
    assert "0.1 ± 0.2 lx at most (Floor)" in said
    assert "density lowered to 80 %" in said
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    assert bpy.data.objects["Floor"].lumenray.baked_image.size[0] == SIZE
    assert "Lux atlas: Ceiling" in bpy.data.images


def test_a_gltf_file_that_cannot_be_written_costs_a_message_only(fake, tmp_path, paint):
    floor = add_quad("Floor", material=paint)
    (tmp_path / "folder").write_text("no folder")
    bake_all(tmp_path, gltf=str(tmp_path / "folder" / "room.glb"))
    assert floor.lumenray.baked_image is not None
    rows = bpy.context.window_manager.lumenray.rows
    assert any("glTF file is not written" in row.remedy for row in rows)


def test_gltf_is_written_on_request(fake, tmp_path, paint):
    add_quad("Floor", material=paint)
    add_quad("Wall", 2.0)
    bake_all(tmp_path, gltf=str(tmp_path / "room.glb"))
    data = (tmp_path / "room.glb").read_bytes()
    assert data[:4] == b"glTF"
    length = int.from_bytes(data[12:16], "little")
    content = json.loads(data[20 : 20 + length])
    assert {"Floor", "Wall"} <= {node.get("name") for node in content["nodes"]}
    assert content["images"]
    with pytest.raises(RuntimeError, match="glTF files end in"):
        bake_all(tmp_path, gltf=str(tmp_path / "room.obj"))


def test_the_textures_of_a_gltf_file_keep_to_the_limits(fake, tmp_path, paint):
    add_quad("Floor", material=paint)
    settings = bpy.context.scene.lumenray
    settings.bake_gltf_textures, settings.bake_gltf_size = 2, SIZE // 2
    bake_all(tmp_path, gltf=str(tmp_path / "room.gltf"))
    content = json.loads((tmp_path / "room.gltf").read_text())
    pictures = [bpy.data.images.load(str(tmp_path / each["uri"])) for each in content["images"]]
    assert 1 <= len(pictures) <= 2
    assert max(max(picture.size) for picture in pictures) == SIZE // 2
    # Two looks do not fit into one texture.
    settings.bake_gltf_textures = 1
    bake_all(tmp_path, gltf=str(tmp_path / "other.gltf"))
    rows = bpy.context.window_manager.lumenray.rows
    assert any("allow more textures" in row.message for row in rows)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--resume"], "no interrupted bake"),
        (["--gltf", "room.obj"], "glTF files end in"),
        (["--absolute", "-3"], "expected a number above 0"),
    ],
)
def test_wrong_orders_end_in_words(monkeypatch, tmp_path, capsys, options, words):
    add_quad("Floor")
    file = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    assert command_line.main(["bake", str(file), "-o", str(tmp_path / "lux"), *options]) == 1
    error = capsys.readouterr().err.strip()
    assert words in error
    assert len(error.splitlines()) == 1


# ---- with the engine ----


@pytest.mark.mitsuba
@pytest.mark.slow
def test_a_real_bake_is_shown_as_bright_as_it_was_computed(tmp_path, monkeypatch):
    session = Session()
    monkeypatch.setattr(session, "close", lambda: None, raising=False)
    monkeypatch.setattr(engine_process, "open_session", lambda _: session)
    tiny.build_closed_box()
    scene = bpy.context.scene
    scene.lumenray.bake_layers = "EACH"
    bpy.ops.lumenray.bake_illuminance(
        objects="Floor,Walls", density=8.0, error=0.01, folder=str(tmp_path)
    )
    floor = bpy.data.objects["Floor"]
    facts = floor.lumenray.baked_image["lumenray"]
    # Mean over all walls of the closed box by the balance of flux. [lx]
    mean = 1000.0 / (24.0 * 0.5)
    assert facts["mean"] == pytest.approx(mean, rel=0.03)
    # An eye 1 cm above the floor that sees one square decimetre of it, right below the lamp's middle: what the atlas says
    # there is what the engine measures.
    place = (0.3, 0.4)
    made = session.measure([(*place, floor.location.z)], [(0.0, 0.0, 1.0)], StopRule(error=0.003))
    for item in bpy.data.objects:
        item.hide_render = item.type == "LIGHT"
    scene.lumenray.white_luminance = 100.0
    camera = bpy.data.cameras.new("Near")
    camera.type, camera.ortho_scale, camera.clip_start = "ORTHO", 0.1, 1e-4
    scene.camera = bpy.data.objects.new("Near", camera)
    scene.camera.location = (*place, floor.location.z + 0.01)
    scene.collection.objects.link(scene.camera)
    baked_look.show(scene)
    # The box is of reflectance 0.5.
    shown = render().mean() * np.pi * 100.0 / 0.5
    assert shown == pytest.approx(made.illuminance[0], rel=0.03)


@pytest.mark.mitsuba
@pytest.mark.slow
def test_a_cancelled_bake_goes_on_to_the_same_map(tmp_path):
    tiny.build_closed_box()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    objects = [bpy.data.objects["Floor"]]
    rule = StopRule(samples=2048)

    def prepared(folder, resume=False):
        settings = bake.read_settings(bpy.context.scene.lumenray, objects, rule, tmp_path / folder)
        return bake.prepare(depsgraph, objects, replace(settings, density=8.0, resume=resume))

    whole = prepared("whole").run(Session()).pages[0]
    job = prepared("halves")

    def stop_half_way(progress):
        if progress.samples > 256:
            job.cancel()

    with pytest.raises(Cancelled):
        job.run(Session(), stop_half_way)
    assert bake_folders.checkpoint_path(tmp_path / "halves").is_file()
    page = prepared("halves", resume=True).run(Session()).pages[0]
    assert not bake_folders.checkpoint_path(tmp_path / "halves").exists()
    np.testing.assert_array_equal(page.illuminance, whole.illuminance)
    np.testing.assert_array_equal(page.standard_error, whole.standard_error)
