"""The look of baked light in EEVEE, judged by Cycles, and that it can be taken away again."""

import json

import bpy
import numpy as np
import pytest
from blender_bakes import add_lamp, bake_all
from blender_objects import add_quad, new_material, pixels_of
from conversion import scene_hash
from fake_bakes import illuminance_at, share_of, with_back

from lumenray.blender_addon.bake import look as baked_look
from lumenray.blender_addon.bake.nodes import PLACE
from lumenray.blender_addon.foundation import engine_process
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.analysis.false_colour import colours
from lumenray.engine.errors import LumenrayError
from lumenray.engine.scene.scene import Scene
from lumenray.engine.session import Session
from lumenray.tools.libraries.scenes import tiny

pytestmark = pytest.mark.usefixtures("extension")


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


def render(look="LIGHT", size=8):
    """Let Cycles show the middle of the first quad as EEVEE would, without any light but what is baked. (h, w, 3)"""
    scene = bpy.context.scene
    scene.lumenray.look.kind = look
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


def test_baked_light_is_base_colour_times_illuminance_over_pi_and_white(
    fake_engine, tmp_path, paint
):
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


def test_tiles_lie_where_the_layout_says(fake_engine, tmp_path, paint):
    add_quad("Other", 5.0, material=paint)
    add_quad("Floor", material=paint)
    bake_all(tmp_path)
    bpy.context.scene.lumenray.white_luminance = 100.0
    baked_look.show(bpy.context.scene)
    expected = expected_light(page=1)[..., None] * (0.6, 0.3, 0.1) / np.pi / 100.0
    np.testing.assert_allclose(render(), expected, rtol=2e-3)


def test_layers_dim_and_recolour_without_changing_the_amount(fake_engine, tmp_path, paint):
    settings = bpy.context.scene.lumenray
    add_quad("Floor", material=paint)
    add_lamp("A", "Ceiling")
    add_lamp("B", "Desk")
    settings.bake.layers, settings.white_luminance = "GROUPS", 100.0
    bake_all(tmp_path)
    bpy.data.objects.remove(bpy.data.objects["A"])
    bpy.data.objects.remove(bpy.data.objects["B"])
    baked_look.show(bpy.context.scene)
    white = expected_light()[..., None] * (0.6, 0.3, 0.1) / np.pi / 100.0
    np.testing.assert_allclose(render(), white, rtol=2e-3)
    settings.look.layers["Ceiling"].strength = 0.25
    dimmed = white * (1.0 - 0.75 * share_of(0, 3))
    np.testing.assert_allclose(render(), dimmed, rtol=2e-3)
    settings.look.layers["Desk"].colour = (1.0, 0.5, 0.2)
    luma = np.array([0.2126, 0.7152, 0.0722])
    tint = np.array([1.0, 0.5, 0.2]) / (luma @ (1.0, 0.5, 0.2))
    expected = dimmed + white * share_of(1, 3) * (tint - 1.0)
    np.testing.assert_allclose(render(), expected, rtol=2e-3)
    # The false colours are those of the dimmed illuminance.
    settings.look.low, settings.look.high = 0.0, 600.0
    lux = expected_light() * (1.0 - 0.75 * share_of(0, 3))
    _check_false_colours(render("FALSE"), lux, 600.0)


def _check_false_colours(shown, lux, high):
    linear = np.clip(shown, 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    assert np.abs(255.0 * encoded - colours(lux, 0.0, high)).max() < 4.0


def test_false_colours_are_those_of_the_scale(fake_engine, tmp_path, paint):
    add_quad("Floor", material=paint)
    bake_all(tmp_path)
    baked_look.show(bpy.context.scene)
    settings = bpy.context.scene.lumenray
    # Set by the bake to a round number that nearly all lumels lie under.
    assert settings.look.high == 500.0
    _check_false_colours(render("FALSE"), expected_light(), 500.0)


def test_exitance_is_shown_as_it_was_baked(fake_engine, tmp_path, paint):
    settings = bpy.context.scene.lumenray
    add_quad("Floor", material=paint)
    settings.bake.exitance, settings.white_luminance = True, 100.0
    bake_all(tmp_path)
    baked_look.show(bpy.context.scene)
    expected = expected_light()[..., None].repeat(3, 2) / np.pi / 100.0
    np.testing.assert_allclose(render("EXITANCE"), expected, rtol=4e-3)


def test_back_sides_show_their_own_light(fake_engine, tmp_path, paint, monkeypatch):
    floor = add_quad("Floor", material=paint)
    add_quad("Other", 5.0, material=paint)
    real = fake_engine.bake_objects
    monkeypatch.setattr(fake_engine, "bake_objects", lambda *a: with_back(real(*a)))
    bake_all(tmp_path)
    assert {"Lumenray", "Lumenray Back"} <= {layer.name for layer in floor.data.uv_layers}
    bpy.context.scene.lumenray.white_luminance = 100.0
    baked_look.show(bpy.context.scene)
    front = render().mean()
    # Turned over, the quad shows its back to the camera.
    floor.scale.z, floor.rotation_euler.x, floor.location.y = 1.0, np.pi, 1.0
    expected = expected_light(page=1).mean() / expected_light(page=0).mean()
    assert render().mean() / front == pytest.approx(expected, rel=2e-3)


def test_unbaked_objects_of_the_same_material_keep_their_look(fake_engine, tmp_path, paint):
    add_quad("Floor", material=paint)
    bake_all(tmp_path)
    bpy.data.objects["Floor"].location.x = 3.0
    add_quad("Plain", mesh=bpy.data.objects["Floor"].data)
    baked_look.show(bpy.context.scene)
    # There is no light, so that what is not baked is black.
    assert render().max() == 0.0


def test_objects_that_share_a_mesh_show_their_own_light(fake_engine, tmp_path, paint):
    first = add_quad("First", material=paint)
    second = add_quad("Second", 5.0, mesh=first.data)
    bake_all(tmp_path)
    bpy.context.scene.lumenray.white_luminance = 100.0
    baked_look.show(bpy.context.scene)
    scale = np.array([0.6, 0.3, 0.1]) / np.pi / 100.0
    np.testing.assert_allclose(render(), expected_light(0)[..., None] * scale, rtol=2e-3)
    first.location.x, second.location.x = 5.0, 0.0
    np.testing.assert_allclose(render(), expected_light(1)[..., None] * scale, rtol=2e-3)


def test_own_light_is_shown_in_the_scenes_exposure(fake_engine, tmp_path):
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


def test_mixes_keep_their_parts(fake_engine, tmp_path):
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


def test_back_takes_away_all_that_show_added(fake_engine, tmp_path, paint):
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
    assert not bpy.context.scene.lumenray.look.is_shown


def test_the_engine_does_not_see_the_look(fake_engine, tmp_path, paint):
    add_quad("Floor", material=paint)
    bake_all(tmp_path)

    before = scene_hash()
    baked_look.show(bpy.context.scene)
    assert scene_hash() == before
    # A bake does not see the material either that bare objects have for the look.
    add_quad("Bare", 3.0)
    hashes = []
    # The first bake gives the bare object a UV map, which is part of the scene.
    bake_all(tmp_path)
    for _ in range(2):
        fake_engine.scene = Scene()
        bake_all(tmp_path)
        hashes.append(fake_engine.scene.hash())
        assert bpy.context.scene.lumenray.look.is_shown
        assert bpy.data.objects["Bare"].material_slots[0].material is not None
    assert hashes[0] == hashes[1]


def test_a_new_bake_keeps_the_look_and_the_sliders(fake_engine, tmp_path, paint):
    settings = bpy.context.scene.lumenray
    add_quad("Floor", material=paint)
    add_lamp("A", "Ceiling")
    settings.bake.layers = "GROUPS"
    bake_all(tmp_path)
    baked_look.show(bpy.context.scene)
    settings.look.layers["Ceiling"].strength = 0.5
    bake_all(tmp_path)
    assert settings.look.is_shown
    assert settings.look.layers["Ceiling"].strength == 0.5
    tree = paint.node_tree.get_output_node("EEVEE").inputs["Surface"].links[0].from_node.node_tree
    images = [node.image for node in tree.nodes if node.bl_idname == "ShaderNodeTexImage"]
    assert len(images) == 2
    assert all(image is not None for image in images)


def test_nothing_can_be_shown_before_a_bake():
    add_quad("Floor")
    assert not bpy.ops.lumenray.show_baked.poll()
    with pytest.raises(LumenrayError, match="nothing to show"):
        baked_look.show(bpy.context.scene)


@pytest.mark.mitsuba
@pytest.mark.slow
def test_a_real_bake_is_shown_as_bright_as_it_was_computed(tmp_path, monkeypatch):
    session = Session()
    monkeypatch.setattr(session, "close", lambda: None, raising=False)
    monkeypatch.setattr(engine_process, "open_session", lambda *_: session)
    tiny.build_closed_box()
    scene = bpy.context.scene
    scene.lumenray.bake.layers = "EACH"
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
