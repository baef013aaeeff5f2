"""What Blender shows to some rays only is taken over, or told."""

import bpy
import numpy as np
import pytest
from conversion import converted_scene

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.session import Session, ViewSettings
from lumenray.tools.libraries.scenes import tiny

LIGHT_RAYS = ("visible_diffuse", "visible_glossy", "visible_transmission", "visible_shadow")


def session_of(made):
    session = Session()
    session.apply(made.delta)
    return session


def rows(made, *severities):
    return [row for row, _ in made.report.rows if row.severity.value in severities]


def add_plane(height=0.8, size=2.0):
    """Add a measuring plane that fills the box."""
    mesh = bpy.data.meshes.new("Plane")
    half = 0.5 * size
    corners = [(x, y, 0.0) for x, y in ((-half, -half), (half, -half), (half, half), (-half, half))]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    item = bpy.data.objects.new("Plane", mesh)
    item.location.z = height
    bpy.context.scene.collection.objects.link(item)
    return item


def switch_off(item, names=LIGHT_RAYS):
    for name in names:
        setattr(item, name, False)


def illuminance(made, place=(0.5, 0.5, 0.0)):
    found = session_of(made).measure([place], [(0, 0, 1)], StopRule(samples=1 << 15), seed=1)
    return found.illuminance[0], found.standard_error[0]


@pytest.fixture
def box():
    tiny.build_closed_box()


@pytest.mark.mitsuba
@pytest.mark.parametrize("is_glowing", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_measuring_plane_that_light_does_not_meet_changes_no_number(box, is_glowing):
    before, error = illuminance(converted_scene())
    plane = add_plane()
    if is_glowing:
        material = bpy.data.materials.new("Glow")
        settings = material.lumenray
        settings.use_override, settings.model, settings.luminance = True, "EMITTER", 1000.0
        plane.data.materials.append(material)
    covered, _ = illuminance(converted_scene())
    assert abs(covered - before) > 0.2 * before
    switch_off(plane)
    made = converted_scene()
    after, other = illuminance(made)
    assert abs(after - before) < 4 * np.hypot(error, other)
    assert rows(made, "error", "warning") == []


@pytest.mark.mitsuba
@pytest.mark.slow
def test_what_light_does_not_meet_is_seen_by_the_camera_and_can_be_baked(box, tmp_path):
    plane = add_plane()
    switch_off(plane)
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Eye", bpy.data.cameras.new("Eye"))
    camera.location = (0.0, 0.0, 1.9)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = 8

    def look():
        made = converted_scene()
        picture = session_of(made).render(made.camera, ViewSettings(StopRule(samples=64)))
        return picture.depth.mean(), picture.tristimulus[..., 1].mean()

    depth, luminance = look()
    assert depth == pytest.approx(1.1, rel=1e-3)
    assert luminance > 1.0
    plane.visible_camera = False
    assert look()[0] == pytest.approx(1.9, rel=1e-3)
    plane.visible_camera = True

    from lumenray.blender_addon.bake import job as bake

    settings = bake.read_settings(scene.lumenray, [plane], StopRule(samples=512), tmp_path)
    job = bake.prepare(bpy.context.evaluated_depsgraph_get(), [plane], settings)
    made = job.run(Session()).maps[0]
    points = np.random.default_rng(1).uniform(-1, 1, (256, 2))
    places = np.column_stack([points, np.full(len(points), 0.8)])
    found = session_of(converted_scene()).measure(places, np.tile((0, 0, 1.0), (256, 1)), StopRule(samples=512))  # fmt: skip
    spread = found.illuminance.std() / 16
    assert made.mean == pytest.approx(found.illuminance.mean(), abs=4 * spread)


def plane_of(made):
    (placement,) = (item for item in made.delta.changed if getattr(item, "name", "") == "Plane")
    return placement


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (LIGHT_RAYS[:1], "diffuse"),
        (LIGHT_RAYS[3:], "shadow"),
        (LIGHT_RAYS[1:3], "glossy and transmission"),
        (LIGHT_RAYS[:3], "diffuse, glossy and transmission"),
        (LIGHT_RAYS[1:], "glossy, transmission and shadow"),
    ],
)
def test_light_that_meets_an_object_in_part_is_an_error_that_names_it(box, names, words):
    plane = add_plane()
    switch_off(plane, names)
    made = converted_scene()
    (row,) = rows(made, "error", "warning")
    assert row.severity.value == "error"
    assert row.datablock == "Plane"
    assert row.message == f"light meets the object but for {words} rays"
    assert plane_of(made).meets_light


def test_light_that_meets_an_object_not_at_all_is_no_error_but_a_note(box):
    plane = add_plane()
    switch_off(plane)
    made = converted_scene()
    assert rows(made, "error", "warning") == []
    (row,) = (row for row in rows(made, "info") if row.datablock == "Plane")
    assert row.remedy == "the camera alone sees it; light passes it"
    assert not plane_of(made).meets_light
    assert plane_of(made).visible_to_camera
    plane.visible_camera = False
    (row,) = (row for row in rows(converted_scene(), "info") if row.datablock == "Plane")
    assert row.remedy == "it can only be measured and baked; light passes it"


def test_rays_that_the_maker_of_instances_and_what_it_shows_are_off_for_count_together(box):
    """Neither is out of the light by itself, the instance is."""
    plane = add_plane()
    group = bpy.data.collections.new("Group")
    group.objects.link(plane)
    maker = bpy.data.objects.new("Maker", None)
    maker.instance_type, maker.instance_collection = "COLLECTION", group
    bpy.context.scene.collection.objects.link(maker)
    switch_off(maker, LIGHT_RAYS[:2])
    switch_off(plane, LIGHT_RAYS[2:])
    made = converted_scene()
    (copy,) = (item for item in made.delta.changed if "Maker" in getattr(item, "name", ""))
    assert not copy.meets_light
    assert plane_of(made).meets_light


def test_instances_keep_the_visibility_of_what_makes_them(box):
    add_plane()
    group = bpy.data.collections.new("Group")
    group.objects.link(bpy.data.objects["Plane"])
    maker = bpy.data.objects.new("Maker", None)
    maker.instance_type, maker.instance_collection = "COLLECTION", group
    bpy.context.scene.collection.objects.link(maker)
    switch_off(maker)
    made = converted_scene()
    (copy,) = (item for item in made.delta.changed if "Maker" in getattr(item, "name", ""))
    assert not copy.meets_light


@pytest.mark.mitsuba
def test_an_object_that_light_meets_again_is_traced_again(box):
    from lumenray.blender_addon.sync.scene_sync import SceneSync

    plane = add_plane()
    sync, session = SceneSync(final=True), Session()
    found = []
    for value in (True, False, True):
        for name in LIGHT_RAYS:
            setattr(plane, name, value)
        plane.update_tag()
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        sync.tag_scene()
        sync._tags.objects.add(plane.session_uid)
        session.apply(sync.walk(depsgraph).delta)
        found.append(session.measure([(0.5, 0.5, 0.0)], [(0, 0, 1)], StopRule(samples=4096)).illuminance[0])  # fmt: skip
    assert found[0] == pytest.approx(found[2], rel=0.2)
    assert found[1] > 2 * found[0]


def test_a_light_that_lights_nothing_by_its_visibility_is_dark(box):
    (light,) = (item for item in bpy.data.objects if item.type == "LIGHT")
    switch_off(light, LIGHT_RAYS[:3])
    made = converted_scene()
    assert not any(hasattr(item, "output") for item in made.delta.changed)
    light.visible_diffuse = True
    made = converted_scene()
    assert any(hasattr(item, "output") for item in made.delta.changed)
    (row,) = rows(made, "error")
    assert (row.datablock, "glossy and transmission" in row.message) == (light.name, True)


@pytest.mark.parametrize(
    ("kind", "words"),
    [("receiver_collection", "light linking"), ("blocker_collection", "shadow linking")],
)
def test_linked_lights_and_shadows_are_errors_that_name_the_light(box, kind, words):
    (light,) = (item for item in bpy.data.objects if item.type == "LIGHT")
    plane = add_plane()
    chosen = bpy.data.collections.new("Chosen")
    setattr(light.light_linking, kind, chosen)
    setattr(plane.light_linking, kind, chosen)
    (row,) = rows(converted_scene(), "error")
    assert row.datablock == light.name
    assert words in row.message
    glow = bpy.data.materials.new("Glow")
    glow.lumenray.use_override, glow.lumenray.model, glow.lumenray.luminance = True, "EMITTER", 10.0
    plane.data.materials.append(glow)
    assert {row.datablock for row in rows(converted_scene(), "error")} == {light.name, "Plane"}


def test_catchers_and_shadowless_lights_are_told(box):
    before = rows(converted_scene(), "error", "warning", "info")
    plane = add_plane()
    plane.is_shadow_catcher = True
    (light,) = (item for item in bpy.data.objects if item.type == "LIGHT")
    light.data.use_shadow = False
    told = {
        (row.severity.value, row.datablock, row.message)
        for row in rows(converted_scene(), "error", "warning", "info")
        if row not in before
    }
    assert told == {
        ("info", "Plane", "the object is a shadow catcher"),
        ("error", light.name, "the light casts no shadows in Blender"),
    }


def test_a_world_that_lights_in_part_is_told_and_one_that_does_not_is_black(box):
    world = bpy.data.worlds.new("Sky")
    bpy.context.scene.world = world
    world.lumenray.source = "CIE"
    rays = world.cycles_visibility
    assert any(hasattr(item, "ground_reflectance") for item in converted_scene().delta.changed)
    rays.camera = rays.glossy = False
    made = converted_scene()
    (sky,) = (item for item in made.delta.changed if hasattr(item, "ground_reflectance"))
    assert sky.seen.luminance == 0.0
    assert [row.message for row in rows(made, "error")] == [
        "the world does not light by glossy rays"
    ]
    assert rows(made, "warning") == []
    rays.diffuse = rays.transmission = False
    assert not any(hasattr(item, "ground_reflectance") for item in converted_scene().delta.changed)
    rays.camera = True
    (dark,) = (item for item in converted_scene().delta.changed if item.id.startswith("world"))
    assert dark.luminance == 0.0
    assert dark.seen.illuminance == world.lumenray.sky.illuminance


@pytest.mark.mitsuba
def test_a_transparent_film_shows_no_world_and_measures_it_all_the_same():
    """Half of the picture is a matt plane that the camera sees, a quarter of it a pane, the rest the world."""
    from lumenray.blender_addon.rendering.render_engine import picture_layers, view_settings

    world = bpy.data.worlds.new("Even")
    world.lumenray.unit = "LUMINANCE"
    scene = bpy.context.scene
    scene.world = world
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    background = next(n for n in world.node_tree.nodes if n.bl_idname == "ShaderNodeBackground")
    background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    background.inputs["Strength"].default_value = 100.0
    plane = add_plane(0.0, 4.0)
    plane.location.x = -2.0
    veil = add_plane(0.0, 2.0)
    veil.location = (1.0, -1.0, 0.0)
    material = bpy.data.materials.new("Veil")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    clear = tree.nodes.new("ShaderNodeBsdfTransparent")
    clear.inputs["Color"].default_value = (0.25, 0.25, 0.25, 1.0)
    tree.links.new(clear.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs[0])
    veil.data.materials.append(material)
    data = bpy.data.cameras.new("Eye")
    data.type, data.ortho_scale = "ORTHO", 2.0
    scene.camera = bpy.data.objects.new("Eye", data)
    scene.camera.location = (0.0, 0.0, 3.0)
    scene.collection.objects.link(scene.camera)
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.lumenray.render.samples = 64
    scene.render.film_transparent = True

    made = converted_scene()
    picture = session_of(made).render(made.camera, view_settings(scene))
    layers = picture_layers(picture, 100.0)
    alpha, shown = layers["Combined"][..., 3], layers["Combined"][..., 1]
    # Row 0 is below: the veil covers the lower right; edges of pixels at the middle are left out.
    assert alpha[:, :3] == pytest.approx(1.0)
    assert alpha[:3, 5:] == pytest.approx(0.75, abs=1e-3)
    assert alpha[5:, 5:] == pytest.approx(0.0, abs=1e-6)
    assert shown[5:, 5:] == pytest.approx(0.0, abs=1e-6)
    assert shown[:3, 5:].mean() == pytest.approx(0.0, abs=0.03)
    assert shown[:, :3].mean() == pytest.approx(0.8, rel=0.05)
    assert layers["Luminance"][5:, 5:] == pytest.approx(100.0, rel=1e-3)
    scene.render.film_transparent = False
    picture = session_of(made).render(made.camera, view_settings(scene))
    assert picture.coverage is None
    assert picture_layers(picture, 100.0)["Combined"][..., 3].min() == 1.0
