"""Skies of the CIE in Blender's world: what is converted, what edits send, what is measured, and the panel."""

import math

import bpy
import lumenray
import numpy as np
import pytest
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import CieSky, UniformWorld
from lumenray.engine.scene.material import Transparent
from lumenray.engine.scene.scene import Scene
from lumenray.engine.scene.spectrum import Daylight
from lumenray.engine.session import Session
from panels import context, draw, interface
from random_edits import differences, remember

SIDES = {"north": (0, 1, 0), "east": (1, 0, 0), "south": (0, -1, 0), "west": (-1, 0, 0)}
"""Where upright sensors look."""


@pytest.fixture
def world():
    made = bpy.data.worlds.new("Outside")
    if bpy.app.version < (5, 0, 0):
        made.use_nodes = True
    bpy.context.scene.world = made
    made.lumenray.source = "CIE"
    return made


@pytest.fixture(scope="module")
def session():
    return Session(witness=False)


def add_sun(name="Sun", rotation=(0.0, 0.0, 0.0), power=1.0):
    data = bpy.data.lights.new(name, "SUN")
    data.energy = power
    item = bpy.data.objects.new(name, data)
    item.rotation_euler = rotation
    bpy.context.scene.collection.objects.link(item)
    return item


def convert():
    bpy.context.view_layer.update()
    return convert_scene(bpy.context.evaluated_depsgraph_get())


def converted_world():
    found = [i for i in convert().delta.changed if isinstance(i, CieSky | UniformWorld)]
    return found[0] if found else None


def compass(elevation, azimuth):
    """Unit vector by angles in degrees: azimuth from north, +y, over east, +x."""
    height, turn = math.radians(elevation), math.radians(azimuth)
    east, north = math.sin(turn), math.cos(turn)
    return np.array([math.cos(height) * east, math.cos(height) * north, math.sin(height)])


def rotation_of(elevation, azimuth):
    """Euler angles [rad] of a lamp that shines from there: tipped about x, then turned about z."""
    return (-math.radians(90 - elevation), 0.0, -math.radians(azimuth))


# ---- conversion ----


def test_the_default_leaves_the_world_to_its_nodes(world):
    world.lumenray.property_unset("source")
    assert world.lumenray.source == "NODES"
    background = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    world.lumenray.sky.illuminance = 123.0
    add_sun()
    made = converted_world()
    assert isinstance(made, UniformWorld)
    assert made.luminance == pytest.approx(177.83, rel=1e-6)


def test_a_new_sky_is_overcast_with_ten_thousand_lux(world):
    sky = converted_world()
    assert (sky.type, sky.illuminance) == (16, 10000.0)
    assert sky.ground_reflectance == pytest.approx(0.2)
    assert sky.spectrum == Daylight(6500.0)
    assert sky.id == f"world:{world.lumenray.uid}"


def test_every_setting_is_taken_over(world):
    settings = world.lumenray.sky
    settings.illuminance = 8000.0
    settings.ground_reflectance = 0.35
    settings.colour_temperature = 9000.0
    settings.elevation, settings.azimuth = math.radians(35), math.radians(250)
    for number in range(1, 17):
        settings.type = str(number)
        sky = converted_world()
        assert sky.type == number
        assert sky.illuminance == 8000.0
        assert sky.ground_reflectance == pytest.approx(0.35)
        assert sky.spectrum == Daylight(9000.0)
        if number not in {1, 3, 5, 16}:
            np.testing.assert_allclose(sky.towards_sun, compass(35, 250), atol=1e-6)
    settings.illuminance = 0.0
    assert converted_world() is None


def test_the_settings_stay_where_they_have_a_meaning(world):
    settings = world.lumenray.sky
    settings.colour_temperature = 1000.0
    assert settings.colour_temperature == 4000.0
    settings.colour_temperature = 1e6
    assert settings.colour_temperature == 25000.0
    settings.elevation = math.radians(100)
    assert settings.elevation == pytest.approx(math.radians(90))
    settings.ground_reflectance = 2.0
    assert settings.ground_reflectance == 1.0


@pytest.mark.parametrize("place", [(20, 0), (35, 90), (60, 200), (5, 310)], ids=str)
def test_the_sun_light_says_where_the_sun_stands(world, place):
    world.lumenray.sky.type = "12"
    # Nothing but its direction counts.
    add_sun(rotation=rotation_of(*place), power=0.0).location = (3, 4, 5)
    np.testing.assert_allclose(converted_world().towards_sun, compass(*place), atol=1e-6)


def test_the_first_visible_sun_light_by_name_counts(world):
    world.lumenray.sky.type = "12"
    add_sun("Sun B", rotation_of(20, 90))
    first = add_sun("Sun A", rotation_of(30, 180))
    np.testing.assert_allclose(converted_world().towards_sun, compass(30, 180), atol=1e-6)
    first.hide_render = True
    np.testing.assert_allclose(converted_world().towards_sun, compass(20, 90), atol=1e-6)
    world.lumenray.sky.use_sun_lamp = False
    np.testing.assert_allclose(converted_world().towards_sun, compass(45, 180), atol=1e-6)


def test_a_sun_below_the_horizon_is_reported(world):
    world.lumenray.sky.type = "12"
    sun = add_sun(rotation=rotation_of(-10, 90))
    assert any("below the horizon" in row.message for row, _ in convert().report.rows)
    np.testing.assert_allclose(converted_world().towards_sun, compass(0, 90), atol=1e-6)
    sun.rotation_euler = (math.pi, 0.0, 0.0)
    np.testing.assert_allclose(converted_world().towards_sun[2], 0.0, atol=1e-6)
    world.lumenray.sky.type = "16"
    assert not any("below the horizon" in row.message for row, _ in convert().report.rows)


def test_settings_survive_saving(world, tmp_path):
    settings = world.lumenray.sky
    settings.type, settings.illuminance, settings.use_sun_lamp = "13", 7000.0, False
    settings.elevation, settings.azimuth = math.radians(25), math.radians(100)
    settings.ground_reflectance, settings.colour_temperature = 0.1, 5500.0
    before = converted_world()
    path = str(tmp_path / "sky.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, check_existing=False)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    after = converted_world()
    assert (after.id, after.type, after.illuminance) == (before.id, 13, 7000.0)
    assert after.ground_reflectance == before.ground_reflectance
    assert after.spectrum == Daylight(5500.0)
    np.testing.assert_array_equal(after.towards_sun, before.towards_sun)


# ---- what edits send ----


class Kept:
    """Scene of the engine that is kept current."""

    def __init__(self):
        self.sync, self.scene = SceneSync(), Scene()
        self.sent()

    def sent(self):
        """Return the kinds of items that were sent and the number of removed ones, after comparing with a full export."""
        bpy.context.view_layer.update()
        graph = bpy.context.evaluated_depsgraph_get()
        step = self.sync.walk(graph)
        self.scene.apply(step.delta)
        fresh = Scene()
        fresh.apply(SceneSync().walk(graph).delta)
        assert differences(self.scene, fresh) == []
        return [type(item).__name__ for item in step.delta.changed], len(step.delta.removed)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("type", "13"),
        ("illuminance", 500.0),
        ("use_sun_lamp", False),
        ("ground_reflectance", 0.5),
        ("colour_temperature", 5000.0),
    ],
)
def test_an_edited_setting_sends_the_sky(world, name, value):
    world.lumenray.sky.type = "12"
    add_sun(rotation=rotation_of(20, 90))
    kept = Kept()
    setattr(world.lumenray.sky, name, value)
    assert kept.sent() == (["CieSky"], 0)
    setattr(world.lumenray.sky, name, value)
    assert kept.sent() == ([], 0)


def test_angles_send_the_sky_where_they_count(world):
    settings = world.lumenray.sky
    kept = Kept()
    settings.elevation = math.radians(30)
    assert kept.sent() == ([], 0)
    settings.type = "12"
    assert kept.sent() == (["CieSky"], 0)
    settings.elevation = math.radians(20)
    assert kept.sent() == (["CieSky"], 0)
    settings.azimuth = math.radians(20)
    assert kept.sent() == (["CieSky"], 0)
    add_sun()
    assert sorted(kept.sent()[0]) == ["CieSky", "SunLight"]
    settings.azimuth = math.radians(40)
    assert kept.sent() == ([], 0)


def test_the_sky_follows_the_sun_light(world):
    world.lumenray.sky.type = "12"
    sun = add_sun(rotation=rotation_of(20, 90))
    kept = Kept()
    sun.rotation_euler = rotation_of(40, 120)
    assert sorted(kept.sent()[0]) == ["CieSky", "SunLight"]
    sun.location.x = 5.0
    assert kept.sent()[0] in ([], ["SunLight"])
    sun.data.energy = 0.0
    assert kept.sent() == (["SunLight"], 0)
    sun.rotation_euler = rotation_of(50, 120)
    assert "CieSky" in kept.sent()[0]
    np.testing.assert_allclose(kept.scene.world.towards_sun, compass(50, 120), atol=1e-6)
    other = add_sun("Zenith", power=0.0)
    assert kept.sent() == ([], 0)
    # Now the other one is the first.
    other.name = "A"
    assert kept.sent() == (["CieSky"], 0)
    np.testing.assert_allclose(kept.scene.world.towards_sun, (0, 0, 1), atol=1e-6)
    other.hide_set(True)
    assert kept.sent() == (["CieSky"], 0)
    bpy.data.objects.remove(sun)
    assert kept.sent()[0] == ["CieSky"]
    np.testing.assert_allclose(kept.scene.world.towards_sun, compass(45, 180), atol=1e-6)


def test_a_sun_light_does_not_send_a_sky_that_is_even_all_around(world):
    sun = add_sun(rotation=rotation_of(20, 90))
    kept = Kept()
    sun.rotation_euler = rotation_of(40, 120)
    assert kept.sent() == (["SunLight"], 0)


def test_nodes_and_sky_take_turns(world):
    kept = Kept()
    background = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Strength"].default_value = 3.0
    assert kept.sent() == ([], 0)
    world.lumenray.source = "NODES"
    assert kept.sent() == (["UniformWorld"], 0)
    world.lumenray.source = "CIE"
    assert kept.sent() == (["CieSky"], 0)


def test_undo_and_redo_reach_the_engine(world):
    remember("start")
    kept = Kept()
    world.lumenray.sky.type = "12"
    bpy.context.view_layer.update()
    remember("type")
    kept.sent()
    bpy.ops.ed.undo()
    assert kept.sent() == (["CieSky"], 0)
    assert kept.scene.world.type == 16
    bpy.ops.ed.redo()
    assert kept.sent() == (["CieSky"], 0)
    assert kept.scene.world.type == 12


def test_the_sun_can_be_animated(world):
    settings = world.lumenray.sky
    settings.type = "12"
    for frame, height in ((1, 10.0), (21, 50.0)):
        settings.elevation = math.radians(height)
        settings.keyframe_insert("elevation", frame=frame)
    bpy.context.scene.frame_set(1)
    kept = Kept()
    np.testing.assert_allclose(kept.scene.world.towards_sun, compass(10, 180), atol=1e-6)
    bpy.context.scene.frame_set(21)
    assert kept.sent() == (["CieSky"], 0)
    np.testing.assert_allclose(kept.scene.world.towards_sun, compass(50, 180), atol=1e-6)


# ---- measured ----


def read(session, normals, samples=1 << 13):
    session.apply(convert().delta)
    normals = np.array(normals, dtype=float)
    made = session.measure(np.zeros((len(normals), 3)), normals, StopRule(samples=samples))
    return made.illuminance, made.standard_error


@pytest.mark.parametrize("kind", [1, 5, 12, 16])
def test_a_horizontal_plane_gets_the_stated_illuminance(world, session, kind):
    settings = world.lumenray.sky
    settings.type, settings.illuminance = str(kind), 4321.0
    settings.elevation, settings.azimuth = math.radians(35), math.radians(70)
    value, error = read(session, [(0, 0, 1), (0, 0, -1)])
    assert error[0] < 0.01 * 4321.0
    assert abs(value[0] - 4321.0) < 4 * error[0] + 1e-3 * 4321.0
    # A ground of reflectance 0.2 lights the other side.
    assert abs(value[1] - 0.2 * 4321.0) < 4 * error[1] + 1e-3 * 4321.0


@pytest.mark.parametrize("by_lamp", [False, True])
@pytest.mark.parametrize(("side", "azimuth"), [("north", 0), ("east", 90), ("south", 180)])
def test_the_side_towards_the_sun_gets_most(world, session, side, azimuth, by_lamp):
    settings = world.lumenray.sky
    settings.type = "12"
    if by_lamp:
        add_sun(rotation=rotation_of(30, azimuth), power=0.0)
    else:
        settings.elevation, settings.azimuth = math.radians(30), math.radians(azimuth)
    value, error = read(session, list(SIDES.values()), 1 << 11)
    by_side = dict(zip(SIDES, value, strict=True))
    assert max(by_side, key=by_side.get) == side
    # By the symmetry of the clear sky its flanks get the same.
    flanks = [i for i, axis in enumerate(SIDES.values()) if np.dot(axis, SIDES[side]) == 0]
    assert abs(value[flanks[0]] - value[flanks[1]]) < 4 * np.hypot(*error[flanks])
    assert by_side[side] > 1.5 * value[flanks].max()


def test_f12_shows_the_sky(world, tmp_path):
    """Looking straight up at a uniform sky: its luminance is illuminance over pi."""
    lumenray.register()
    world.lumenray.sky.type, world.lumenray.sky.illuminance = "5", 1000.0
    camera = bpy.data.cameras.new("Eye")
    eye = bpy.data.objects.new("Eye", camera)
    eye.rotation_euler = (math.pi, 0.0, 0.0)
    scene = bpy.context.scene
    scene.collection.objects.link(eye)
    scene.camera, scene.render.engine = eye, "LUMENRAY"
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.lumenray.samples = 16
    scene.lumenray.white_luminance = 1000.0 / math.pi
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = str(tmp_path / "up.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = np.array(image.pixels[:], np.float32).reshape(8, 8, -1)[..., :3]
    assert pixels @ (0.2126, 0.7152, 0.0722) == pytest.approx(1.0, rel=0.02)


# ---- renders ----


class Recorder(bpy.types.RenderEngine):
    """Render engine that only notes the sky of each frame."""

    bl_idname = "LUMENRAY_TEST_SKY"
    bl_label = "Sky recorder"
    suns: list = []

    def render(self, depsgraph):
        scene = Scene()
        scene.apply(SceneSync(final=True).walk(depsgraph).delta)
        self.suns.append(scene.world.towards_sun)


def test_the_frames_of_a_render_have_the_animated_sun(world, tmp_path):
    settings = world.lumenray.sky
    settings.type = "12"
    for frame, height in ((1, 10.0), (21, 50.0)):
        settings.elevation = math.radians(height)
        settings.keyframe_insert("elevation", frame=frame)
    scene = bpy.context.scene
    scene.camera = bpy.data.objects.new("Eye", bpy.data.cameras.new("Eye"))
    scene.collection.objects.link(scene.camera)
    scene.frame_start, scene.frame_end, scene.frame_step = 1, 21, 20
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.render.filepath = str(tmp_path / "frame")
    bpy.utils.register_class(Recorder)
    try:
        scene.render.engine = Recorder.bl_idname
        bpy.ops.render.render(animation=True)
    finally:
        scene.render.engine = "LUMENRAY"
        bpy.utils.unregister_class(Recorder)
    np.testing.assert_allclose(Recorder.suns, [compass(10, 180), compass(50, 180)], atol=1e-6)


# ---- portals of Cycles ----


def add_portal(location=(0, 0, 1), size=0.5):
    """An area light that is a portal of Cycles; what a script sets there is no change to Blender."""
    data = bpy.data.lights.new("Portal", "AREA")
    data.energy, data.size = 100.0, size
    data.cycles.is_portal = True
    item = bpy.data.objects.new("Portal", data)
    item.location = location
    bpy.context.scene.collection.objects.link(item)
    return item


needs_cycles = pytest.mark.skipif(
    "cycles" not in bpy.context.preferences.addons, reason="this Blender has no Cycles"
)


@needs_cycles
def test_a_portal_is_an_opening_and_no_light(world):
    portal = add_portal((1, 2, 3))
    portal.data.shape, portal.data.size_y = "RECTANGLE", 2.0
    portal.rotation_euler.x = math.radians(90)
    made = convert()
    scene = Scene()
    scene.apply(made.delta)
    assert not scene.lights
    assert not made.objects
    mesh = scene.mesh(f"object:{portal.lumenray.uid}")
    assert not mesh.visible_to_camera
    assert isinstance(scene.materials[mesh.materials[0]].surface, Transparent)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    # The beam's direction, local -z, is now +y.
    np.testing.assert_allclose((low + high) / 2, (1, 2, 3), atol=2e-3)
    np.testing.assert_allclose(high - low, (0.5, 0, 2), atol=1e-6)
    corner, u, v = mesh.vertices[mesh.triangles[0]]
    assert np.cross(u - corner, v - corner)[1] > 0


@needs_cycles
def test_portals_are_kept_current(world):
    portal = add_portal()
    kept = Kept()
    portal.location.x = 1.0
    assert kept.sent() == (["Placement"], 0)
    portal.data.size = 2.0
    assert kept.sent() == (["Placement"], 0)
    portal.data.energy = 50.0
    assert kept.sent() == ([], 0)
    portal.data.cycles.is_portal = False
    portal.data.update_tag()
    kinds, removed = kept.sent()
    assert (kinds, removed) == (["AreaLight"], 3)
    portal.data.cycles.is_portal = True
    portal.data.update_tag()
    assert sorted(kept.sent()[0]) == ["Geometry", "Material", "Placement"]
    bpy.data.objects.remove(portal)
    assert kept.sent() == ([], 3)


@needs_cycles
def test_a_portal_changes_the_noise_and_nothing_else(world, session):
    """Below a square hole in a black box, by the configuration factor of a rectangle."""
    settings = world.lumenray.sky
    settings.type, settings.illuminance, settings.ground_reflectance = "5", 1000.0 * math.pi, 0.0
    half = 0.1
    rings = [(half, 1), (2, 1), (2, -1)]
    corners = [(x, y, z) for r, z in rings for x, y in ((-r, -r), (r, -r), (r, r), (-r, r))]
    faces = [(i, (i + 1) % 4 + i // 4 * 4, (i + 1) % 4 + i // 4 * 4 + 4, i + 4) for i in range(8)]
    box = bpy.data.meshes.new("Box")
    box.from_pydata(corners, [], [*faces, (8, 9, 10, 11)])
    black = bpy.data.materials.new("Black")
    black.lumenray.use_override = True
    black.lumenray.reflectance = 0.0
    box.materials.append(black)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Box", box))
    root = math.sqrt(1 + half**2)
    expected = 1000.0 * 4 * half / root * math.atan(half / root)
    readings = []
    for _ in range(2):
        value, error = read(session, [(0, 0, 1)])
        assert abs(value[0] - expected) < 4 * error[0]
        readings.append(error[0])
        add_portal(size=2 * half)
    assert readings[1] < 0.2 * readings[0]


# ---- panel ----


def test_the_panel_shows_what_counts(world):
    with interface():
        where = context(world=world)
        seen = draw("LUMENRAY_PT_world_sky", where)
        assert {"source", "type", "illuminance", "ground_reflectance"} <= set(seen)
        assert not {"use_sun_lamp", "elevation", "azimuth"} & set(seen)
        assert draw("LUMENRAY_PT_world_unit", where) is None
        assert draw("LUMENRAY_PT_world_surface", where) is None
        world.lumenray.sky.type = "12"
        assert {"use_sun_lamp", "elevation", "azimuth"} <= set(draw("LUMENRAY_PT_world_sky", where))
        add_sun("Noon", rotation_of(60, 180))
        bpy.context.view_layer.update()
        seen = draw("LUMENRAY_PT_world_sky", where)
        assert not {"elevation", "azimuth"} & set(seen)
        assert {"Noon", "60.0°", "180.0°"} <= set(seen)
        world.lumenray.source = "NODES"
        assert draw("LUMENRAY_PT_world_sky", where) == ["source"]
        assert draw("LUMENRAY_PT_world_unit", where)


def test_the_panel_states_the_zenith(world):
    """Moon and Spencer's sky has a horizontal illuminance of 7 pi / 9 of its zenith luminance."""
    with interface():
        world.lumenray.sky.illuminance = 7.0 * math.pi / 9.0 * 2000.0
        assert any(
            text.replace("\u2009", "") == "2000 cd/m²"
            for text in draw("LUMENRAY_PT_world_sky", context(world=world))
        )


@needs_cycles
def test_a_portal_states_no_amount_of_light(world):
    with interface():
        portal = add_portal()
        where = context(light=portal.data, object=portal)
        assert {"is_portal", "size"} <= set(draw("LUMENRAY_PT_light", where))
        assert draw("LUMENRAY_PT_light_photometry", where) is None
        assert "energy" not in draw("LUMENRAY_PT_active_light", where)


def test_every_setting_has_a_tooltip(world):
    for group in (world.lumenray, world.lumenray.sky):
        for entry in group.bl_rna.properties:
            if entry.identifier in {"rna_type", "name", "sky"} or entry.is_hidden:
                continue
            assert entry.description, entry.identifier
            if entry.type == "ENUM":
                assert all(item.description for item in entry.enum_items), entry.identifier
