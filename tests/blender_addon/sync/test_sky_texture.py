"""Sky Textures of worlds: as Cycles shows them by direction, and their suns as lights."""

import bpy
import numpy as np
import pytest
from blender_objects import needs_cycles
from conversion import converted_scene, measure_light

from lumenray.blender_addon.light_groups import find_groups
from lumenray.blender_addon.sync import world as world_module
from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.scene.light import ImageWorld, SunLight
from lumenray.engine.scene.light_groups import WORLD
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.sky.atmosphere.directions import towards
from lumenray.engine.sky.atmosphere.scattered_sky import ScatteredSky, find_colours
from lumenray.engine.sky.picture import find_illuminance

pytestmark = pytest.mark.blender

KINDS = [
    item.identifier for item in bpy.types.ShaderNodeTexSky.bl_rna.properties["sky_type"].enum_items
]

SCATTERED = [kind for kind in KINDS if kind not in {"PREETHAM", "HOSEK_WILKIE"}]

DUST = "aerosol_density" if bpy.app.version >= (5, 0, 0) else "dust_density"

HEIGHT = 64

ROTATION = 0.7


class Sky:
    """A world that shows a Sky Texture, its nodes within reach."""

    def __init__(self, strength=1.0, vector=None, **settings):
        self.world = bpy.context.scene.world = bpy.data.worlds.new("Outside")
        if bpy.app.version < (5, 0, 0):
            self.world.use_nodes = True
        self.tree = self.world.node_tree
        self.tree.nodes.clear()
        self.node = self.add("TexSky")
        for name, value in settings.items():
            setattr(self.node, name, value)
        self.background = self.add("Background")
        self.background.inputs["Strength"].default_value = strength
        self.output = self.add("OutputWorld")
        self.link(self.node, self.background, "Color")
        self.link(self.background, self.output, "Surface")
        if vector is not None:
            turned = self.add("Mapping")
            turned.inputs["Rotation"].default_value = vector
            self.link(self.add("TexCoord"), turned, "Vector")
            self.link(turned, self.node, "Vector")

    def add(self, kind):
        return self.tree.nodes.new(f"ShaderNode{kind}")

    def link(self, source, target, name):
        self.tree.links.new(source.outputs[0], target.inputs[name])


def converted():
    """The world, its suns, and the rows of the report."""
    made = converted_scene()
    items = made.delta.changed
    worlds = [item for item in items if isinstance(item, ImageWorld)]
    suns = [item for item in items if isinstance(item, SunLight)]
    return worlds[0] if worlds else None, suns, [row for row, _ in made.report.rows], items


def picture_of(world, items):
    """Radiance of a world's picture as the nodes have it, with a function that looks it up."""
    pixels = world.image.pixels
    if isinstance(pixels, str):
        pixels = next(item for item in items if item.id == pixels).values
    return pixels * (world.luminance_per_unit / bpy.context.scene.lumenray.efficacy)


def render(path, width, height, **camera):
    """Linear colours that Cycles shows, from the lowest row up."""
    scene = bpy.context.scene
    data = bpy.data.cameras.new("Eye")
    scene.camera = bpy.data.objects.new("Eye", data)
    scene.collection.objects.link(scene.camera)
    if "view" in camera:
        elevation, data.angle = camera["view"]
        scene.camera.rotation_euler = (0.5 * np.pi + elevation, 0.0, -ROTATION)
    else:
        data.type = "PANO"
        owner = data if hasattr(data, "panorama_type") else data.cycles
        owner.panorama_type = "EQUIRECTANGULAR"
        scene.camera.rotation_euler = (0.5 * np.pi, 0.0, -0.5 * np.pi)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.device = 1, "CPU"
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.filter_width = 0.01
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path), check_existing=False)
    return np.array(image.pixels[:], np.float64).reshape(height, width, -1)[..., :3]


def scattered(kind, **settings):
    return {"sky_type": kind, "sun_disc": False, "sun_rotation": ROTATION} | settings


SETTINGS = [
    *(
        {"sky_type": "PREETHAM", "sun_direction": sun, "turbidity": turbidity}
        for sun, turbidity in [((0.5, 0.3, 0.6), 3.0), ((0.1, -0.9, 0.1), 8.0)]
    ),
    *(
        {"sky_type": "HOSEK_WILKIE", "sun_direction": sun, "turbidity": turbidity, "ground_albedo": albedo}
        for sun, turbidity, albedo in [((0.5, 0.3, 0.6), 3.4, 0.3), ((-0.5, 0.7, 0.05), 10.0, 0.9)]
    ),
    *(
        scattered(kind, **settings)
        for kind in SCATTERED
        for settings in [
            {"sun_elevation": 0.3},
            {"sun_elevation": -0.05, "altitude": 3000.0, "air_density": 2.0, DUST: 4.0},
            {"sun_elevation": 2.2, "ozone_density": 6.0, "altitude": 20000.0},
        ]
    ),
]  # fmt: skip

QUICK = (*SETTINGS[:5], SETTINGS[-2])
"""Of the two slow kinds one sky each: a clear one, and one of much dust below a sun that has set."""


@pytest.fixture
def coarse(monkeypatch):
    """Pixels of the world's picture stand where those of Cycles do."""
    monkeypatch.setattr(world_module, "SKY_HEIGHT", HEIGHT)
    monkeypatch.setattr(world_module, "LEAST_HEIGHT", HEIGHT)


@needs_cycles
@pytest.mark.parametrize(
    "settings",
    [pytest.param(s, marks=[pytest.mark.slow] * (s not in QUICK)) for s in SETTINGS],
    ids=lambda each: each["sky_type"],
)
def test_a_world_shows_the_sky_of_cycles_in_every_direction(settings, coarse, tmp_path):
    Sky(**settings)
    world, suns, rows, items = converted()
    assert rows == suns == []
    ours, theirs = picture_of(world, items), render(tmp_path / "sky.exr", 2 * HEIGHT, HEIGHT)
    # Their matrix to Rec. 709 has fewer digits.
    assert ours.sum() == pytest.approx(theirs.sum(), rel=3e-4)
    assert np.abs(ours - theirs).max() < 5e-4 * theirs.max()


@needs_cycles
def test_a_sky_is_turned_by_what_is_linked_to_it(coarse, tmp_path):
    Sky(vector=(0.3, 0.2, 0.9), **scattered(SCATTERED[-1], sun_elevation=0.4))
    world, _, rows, items = converted()
    assert rows == []
    ours, theirs = picture_of(world, items), render(tmp_path / "sky.exr", 2 * HEIGHT, HEIGHT)
    far = np.abs(ours - theirs).max(axis=-1) > 1e-3 * theirs.max()
    # At the horizon a pixel shows what is above or below by its last digits.
    assert far.mean() < 1e-3
    assert ours.mean() == pytest.approx(theirs.mean(), rel=1e-3)


@pytest.mark.one_at_a_time
@needs_cycles
@pytest.mark.parametrize("kind", SCATTERED)
@pytest.mark.parametrize(("elevation", "size"), [(0.26, 0.0095), (0.002, 0.0095), (0.3, 0.4)])
def test_the_disk_is_that_of_cycles(kind, elevation, size, tmp_path):
    """Limb darkening, what the air takes from its lower half, and where the horizon cuts it."""
    sky = Sky(**scattered(kind, sun_elevation=elevation, sun_size=size, sun_disc=True))
    side = 48
    theirs = render(tmp_path / "sun.exr", side, side, view=(elevation, 1.3 * size))
    step = np.tan(0.65 * size) * ((np.arange(side) + 0.5) / side * 2.0 - 1.0)
    middle = towards(elevation, ROTATION)
    right = np.array([np.cos(ROTATION), -np.sin(ROTATION), 0.0])
    made = middle + step[:, None] * right + step[:, None, None] * np.cross(right, middle)
    made /= np.linalg.norm(made, axis=-1, keepdims=True)
    given = sky.node
    settings = ScatteredSky(
        kind, elevation, ROTATION, given.altitude, 1.0, 1.0, 1.0, given.sun_size, 1.0
    )
    ours = find_colours(settings, made, True)
    lit = [each.max(axis=-1) > 0.01 * theirs.max() for each in (ours, theirs)]
    # Pixels at the very edge may fall to either side.
    assert (lit[0] != lit[1]).mean() < 0.005
    both = lit[0] & lit[1]
    assert np.abs(ours - theirs)[both].max() < 2e-3 * theirs.max()
    assert ours[both].mean() == pytest.approx(theirs[both].mean(), rel=1e-3)


def illuminance_of_disk(kind, efficacy, **settings):
    """Of a plane that faces it, from even places over the square that it lies in. [lx]"""
    sky = ScatteredSky(kind, 0.5, ROTATION, 100.0, 1.0, 1.0, 1.0, 0.02, **settings)
    side = 300
    step = np.tan(0.0105) * ((np.arange(side) + 0.5) / side * 2.0 - 1.0)
    middle = sky.towards_sun
    right = np.array([np.cos(ROTATION), -np.sin(ROTATION), 0.0])
    made = middle + step[:, None] * right + step[:, None, None] * np.cross(right, middle)
    made /= np.linalg.norm(made, axis=-1, keepdims=True)
    added = find_colours(sky, made, True) - find_colours(sky, made)
    area = (2.0 * np.tan(0.0105) / side) ** 2
    return float((added @ (0.2126, 0.7152, 0.0722) * (made @ middle) ** 4).sum() * area * efficacy)


@pytest.mark.parametrize("kind", SCATTERED)
def test_the_sun_is_a_light_of_its_own_with_the_light_of_the_disk(kind):
    settings = {"sun_elevation": 0.5, "sun_size": 0.02, "sun_disc": True, "sun_intensity": 0.7}
    Sky(0.4, **scattered(kind, **settings))
    world, (sun,), rows, items = converted()
    efficacy = bpy.context.scene.lumenray.efficacy
    expected = 0.4 * illuminance_of_disk(kind, efficacy, sun_intensity=0.7)
    assert sun.output.value == pytest.approx(expected, rel=3e-3)
    assert sun.angle == pytest.approx(0.02)
    np.testing.assert_allclose(-sun.direction, towards(0.5, ROTATION), atol=1e-4)
    assert picture_of(world, items).max() < 1e-2 * sun.output.value / efficacy / 3e-4
    assert sun.limb_darkening == 0.6
    assert rows == []


def test_what_nodes_make_of_the_disk_counts():
    """A gamma of 2 squares the radiance: of a disk even but for the limb this is known."""
    settings = {"sun_elevation": 1.2, "sun_size": 0.01, "sun_disc": True, "air_density": 0.0}
    settings |= {DUST: 0.0, "ozone_density": 0.0}
    sky = Sky(**scattered(SCATTERED[-1], **settings))
    plain = converted()[1][0]
    gamma = sky.add("Gamma")
    gamma.inputs["Gamma"].default_value = 2.0
    sky.link(sky.node, gamma, "Color")
    sky.link(gamma, sky.background, "Color")
    _, (squared,), rows, _ = converted()
    given = np.array(
        [plain.output.spectrum.red, plain.output.spectrum.green, plain.output.spectrum.blue]
    )
    weights = np.array([0.2126, 0.7152, 0.0722])
    radiance = given * plain.output.value / (given @ weights)
    radiance /= bpy.context.scene.lumenray.efficacy * np.pi * 0.005**2 * 0.8
    # The mean of (1 - 0.6 (1 - c))^2 over a disk with c its profile.
    mean = 0.16 + 2 * 0.4 * 0.6 * 2 / 3 + 0.36 / 2
    expected = weights @ radiance**2 * mean * np.pi * 0.005**2
    expected *= bpy.context.scene.lumenray.efficacy
    assert squared.output.value == pytest.approx(expected, rel=5e-3)
    assert [row.message for row in rows] == [
        "the disk of its sun is not as bright everywhere as the true sun's"
    ]


@pytest.mark.mitsuba
def test_surfaces_get_what_sky_and_sun_give_together():
    settings = {"sun_elevation": 0.6, "sun_size": 0.01, "sun_disc": True}
    Sky(**scattered(SCATTERED[-1], **settings))
    _, (sun,), _, _ = converted()
    both, error = measure_light((0.0, 0.0, 0.0))
    bpy.context.scene.world.node_tree.nodes["Sky Texture"].sun_disc = False
    alone, other = measure_light((0.0, 0.0, 0.0))
    expected = sun.output.value * -sun.direction[2]
    assert both - alone == pytest.approx(expected, abs=4.0 * np.hypot(error, other))
    # Against the sky itself, summed over the upper half by places that crowd at the horizon.
    sky = ScatteredSky(SCATTERED[-1], 0.6, ROTATION, 100.0, 1.0, 1.0, 1.0)
    place = (np.arange(400) + 0.5) / 400
    height, azimuth = 0.5 * np.pi * place[:, None] ** 2, np.pi * (np.arange(400) + 0.5) / 200
    plan = np.cos(height)
    made = np.broadcast_arrays(plan * np.cos(azimuth), plan * np.sin(azimuth), np.sin(height))
    light = find_colours(sky, np.stack(made, axis=-1)) @ (0.2126, 0.7152, 0.0722)
    areas = plan * np.sin(height) * np.pi * place[:, None] / 400 * (np.pi / 200)
    wanted = float((light * areas).sum()) * bpy.context.scene.lumenray.efficacy
    assert alone == pytest.approx(wanted, rel=1e-3, abs=4.0 * other)


def test_an_illuminance_that_is_asked_for_holds_for_sky_and_sun_together():
    Sky(**scattered(SCATTERED[-1], sun_elevation=0.6, sun_disc=True))
    world, (sun,), _, _ = converted()
    settings = bpy.context.scene.world.lumenray
    settings.unit, settings.illuminance = "ILLUMINANCE", 50_000.0
    scaled, (bright,), _, _ = converted()
    factor = scaled.luminance_per_unit / world.luminance_per_unit
    assert bright.output.value == pytest.approx(factor * sun.output.value, rel=1e-6)
    from_sun = bright.output.value * -bright.direction[2]
    assert 0.0 < from_sun < 50_000.0
    pixels = ImageTexture(picture_of(scaled, converted()[3]).astype(np.float32))
    efficacy = bpy.context.scene.lumenray.efficacy
    from_sky = find_illuminance(pixels, np.eye(3), (0.0, 0.0, 1.0)) * efficacy
    assert from_sun + from_sky == pytest.approx(50_000.0, rel=1e-4)


def test_edits_of_the_sun_send_it_and_its_end_takes_it_away():
    sky = Sky(**scattered(SCATTERED[-1], sun_elevation=0.6, sun_disc=True))
    sync = SceneSync()

    def walk():
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        sync.tag(depsgraph.updates)
        sync.tag_scene()
        return sync.walk(depsgraph).delta

    first = walk()
    (sun,) = [item for item in first.changed if isinstance(item, SunLight)]
    assert walk().changed == ()
    sky.node.sun_intensity = 0.5
    (dimmed,) = walk().changed
    assert dimmed.id == sun.id
    assert dimmed.output.value == pytest.approx(0.5 * sun.output.value, rel=1e-4)
    assert {key for key, _ in sync.luminous} >= {WORLD, sun.id}
    sky.node.sun_disc = False
    assert walk().removed == (sun.id,)
    assert sun.id not in {key for key, _ in sync.luminous}


def test_a_sun_joins_the_light_group_of_its_world():
    Sky(**scattered(SCATTERED[-1], sun_elevation=0.6, sun_disc=True))
    bpy.context.scene.world.lumenray.light_group = "Day"
    (sun,) = converted()[1]
    (group,) = find_groups(
        [(WORLD, "World"), (sun.id, sun.name)], bpy.context.scene.world, "groups"
    )
    assert set(group.members) == {WORLD, sun.id}


def test_suns_that_the_camera_does_not_see_are_told():
    sky = Sky(**scattered(SCATTERED[-1], sun_elevation=0.6, sun_disc=True))
    mix, plain = sky.add("MixShader"), sky.add("Background")
    sky.tree.links.new(sky.add("LightPath").outputs["Is Camera Ray"], mix.inputs[0])
    sky.tree.links.new(sky.background.outputs[0], mix.inputs[1])
    sky.tree.links.new(plain.outputs[0], mix.inputs[2])
    sky.link(mix, sky.output, "Surface")
    _, suns, rows, _ = converted()
    assert len(suns) == 1
    assert "the nodes hide the sun from the camera" in [row.message for row in rows]


def test_a_disk_that_a_texture_mapping_moves_is_an_error():
    sky = Sky(**scattered(SCATTERED[-1], sun_elevation=0.6, sun_disc=True))
    sky.node.texture_mapping.rotation = (0.0, 0.0, 0.5)
    # Blender tells nobody of that setting by itself.
    sky.node.sun_intensity = 0.9
    _, suns, rows, _ = converted()
    assert suns == []
    assert [row.message for row in rows] == ["the texture mapping of the node moves the sun's disk"]


@pytest.mark.parametrize("settings", [{"sun_intensity": 0.0}, {"sun_elevation": -0.5}])
def test_a_sun_that_is_off_or_down_is_none(settings):
    given = {"sun_elevation": 0.5, "sun_disc": True} | settings
    Sky(**scattered(SCATTERED[-1], **given))
    _, suns, rows, _ = converted()
    assert suns == rows == []
