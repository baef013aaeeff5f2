"""Worlds whose nodes do more than show a turned picture, as Cycles' panoramas show them."""

import bpy
import numpy as np
import pytest
from blender_objects import needs_cycles
from conversion import converted_scene

from lumenray.blender_addon.sync import world as world_module
from lumenray.blender_addon.sync.nodes.directions import directions, sample_picture
from lumenray.engine.scene.light import ImageWorld, UniformWorld

pytestmark = pytest.mark.blender

HEIGHT = 24


class World:
    """A world's node tree under construction."""

    def __init__(self):
        self.world = bpy.context.scene.world = bpy.data.worlds.new("Outside")
        if bpy.app.version < (5, 0, 0):
            self.world.use_nodes = True
        self.tree = self.world.node_tree
        self.tree.nodes.clear()
        self.output = self.tree.nodes.new("ShaderNodeOutputWorld")

    def add(self, kind, attributes=None, **values):
        """Add a node; `values` are set, or linked if they are sockets, by input name."""
        node = self.tree.nodes.new(f"ShaderNode{kind}")
        for name, value in (attributes or {}).items():
            setattr(node, name, value)
        for name, value in values.items():
            socket = node.inputs[int(name[1:]) if name[0] == "_" else name]
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            else:
                socket.default_value = value
        return node.outputs[0]

    def direction(self):
        return self.add("TexCoord")

    def environment(self, vector, **attributes):
        return self.add("TexEnvironment", {"image": picture(), **attributes}, Vector=vector)

    def background(self, colour, strength=1.0):
        return self.add("Background", Color=colour, Strength=strength)

    def show(self, shader):
        self.tree.links.new(shader, self.output.inputs["Surface"])


def picture():
    """Smooth colours, brighter above."""
    height, width = 16, 32
    x, y = np.meshgrid(np.arange(width) / width, np.arange(height) / height)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., 0] = 1.0 + 0.5 * np.sin(2 * np.pi * x)
    pixels[..., 1] = 0.5 + y
    pixels[..., 2] = 0.7 + 0.3 * np.cos(2 * np.pi * x) * y
    image = bpy.data.images.new("Sky", width, height, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


def vivid(world):
    """A colour that depends on the direction."""
    return world.environment(world.direction())


def scaled(world):
    moved = world.add(
        "Mapping",
        Vector=world.direction(),
        Scale=(1.0, 2.0, 0.7),
        Location=(0.2, 0.0, -0.1),
        Rotation=(0.3, 0.1, 0.5),
    )
    return world.background(world.environment(moved))


def mirror_ball(world):
    turned = world.add("Mapping", Vector=world.direction(), Rotation=(0.3, 0.2, 0.9))
    return world.background(world.environment(turned, projection="MIRROR_BALL"))


def tinted(world):
    mixed = world.add(
        "MixRGB",
        {"blend_type": "MULTIPLY"},
        Fac=1.0,
        Color1=vivid(world),
        Color2=(0.2, 0.5, 0.9, 1.0),
    )
    return world.background(world.add("Gamma", Color=mixed, Gamma=1.5), 2.0)


def two_backgrounds(world):
    plain = world.background((0.2, 0.4, 1.0, 1.0), 0.5)
    return world.add("MixShader", Fac=0.3, _1=world.background(vivid(world)), _2=plain)


def added(world):
    plain = world.background((0.2, 0.4, 1.0, 1.0), 0.5)
    return world.add("AddShader", _0=world.background(vivid(world)), _1=plain)


def height_ramp(world):
    apart = world.add("SeparateXYZ", Vector=world.direction()).node.outputs["Z"]
    factor = world.add("MapRange", Value=apart, _1=-1.0)
    ground, sky = (
        world.background(colour) for colour in ((0.1, 0.05, 0.0, 1.0), (0.3, 0.6, 1.0, 1.0))
    )
    return world.add("MixShader", Fac=factor, _1=ground, _2=sky)


def strength_by_direction(world):
    apart = world.add("SeparateXYZ", Vector=world.direction()).node.outputs["X"]
    power = world.add("Math", {"operation": "MULTIPLY_ADD"}, _0=apart, _1=0.5, _2=1.0)
    return world.background((0.5, 0.4, 0.3, 1.0), power)


def clouds(world):
    """Once with coordinates, once without, where Cycles takes the direction."""
    moved = world.add("Mapping", Vector=world.direction(), Scale=(1.0, 1.0, 2.0))
    smooth = {"Scale": 1.0, "Detail": 0.0}
    first = world.background(world.add("TexNoise", Vector=moved, **smooth).node.outputs["Color"])
    second = world.background(world.add("TexNoise", **smooth).node.outputs["Color"])
    return world.add("AddShader", _0=first, _1=second)


def turned_as_of_old(world):
    """By the mapping that textures had themselves before Blender 2.81."""
    colour = world.environment(world.direction())
    colour.node.texture_mapping.rotation = (0.2, 0.1, 0.8)
    return world.background(colour)


GRAPHS = (
    turned_as_of_old,
    clouds,
    scaled,
    mirror_ball,
    tinted,
    two_backgrounds,
    added,
    height_ramp,
    strength_by_direction,
)

REPEATED = (clouds, scaled, tinted, added)
"""Those whose nodes others have too, or whose textures are compared by themselves."""


def converted():
    """The world, and what the report says."""
    made = converted_scene()
    worlds = [i for i in made.delta.changed if isinstance(i, ImageWorld | UniformWorld)]
    return worlds[0] if worlds else None, [row.message for row, _ in made.report.rows]


def panorama_of_cycles(path):
    """Linear colours by direction, laid out as our pictures."""
    scene = bpy.context.scene
    data = bpy.data.cameras.new("Eye")
    data.type = "PANO"
    (data if hasattr(data, "panorama_type") else data.cycles).panorama_type = "EQUIRECTANGULAR"
    scene.camera = bpy.data.objects.new("Eye", data)
    scene.camera.rotation_euler = (0.5 * np.pi, 0.0, -0.5 * np.pi)
    scene.collection.objects.link(scene.camera)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.device = 1, "CPU"
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.filter_width = 0.01
    scene.render.resolution_x, scene.render.resolution_y = 2 * HEIGHT, HEIGHT
    scene.render.resolution_percentage = 100
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path), check_existing=False)
    return np.array(image.pixels[:], np.float32).reshape(HEIGHT, 2 * HEIGHT, -1)[..., :3]


@needs_cycles
@pytest.mark.parametrize(
    "graph",
    [pytest.param(g, marks=[pytest.mark.slow] * (g in REPEATED)) for g in GRAPHS],
    ids=lambda graph: graph.__name__,
)
def test_a_world_shows_what_cycles_shows(graph, tmp_path):
    world = World()
    world.show(graph(world))
    made, messages = converted()
    assert messages == []
    pixels = made.image.pixels
    if isinstance(pixels, str):
        pixels = next(i for i in converted_scene().delta.changed if i.id == pixels).values
    u, v = np.meshgrid(
        (np.arange(2 * HEIGHT) + 0.5) / (2 * HEIGHT), (np.arange(HEIGHT) + 0.5) / HEIGHT
    )
    ours = sample_picture(pixels, u, v, True)
    ours = ours * made.luminance_per_unit / bpy.context.scene.lumenray.efficacy
    theirs = panorama_of_cycles(tmp_path / "world.exr")
    # Beyond the middles of the outer rows Cycles mixes pictures with their other end.
    ours, theirs = ours[1:-1], theirs[1:-1]
    far = np.abs(ours - theirs).max(axis=-1) > 0.005 * theirs.max()
    # Some lie on a picture's rim, where a mirror ball shows all that is behind it.
    assert far.mean() < 0.02
    assert ours.mean() == pytest.approx(theirs.mean(), rel=3e-3)


def test_edits_of_a_mapping_and_of_a_picture_count():
    world = World()
    moved = world.add("Mapping", Vector=world.direction(), Scale=(1.0, 2.0, 1.0))
    image = world.environment(moved).node.image
    world.show(world.background(world.tree.nodes["Environment Texture"].outputs[0]))
    digests = {converted()[0].image.pixels}
    moved.node.inputs["Rotation"].default_value[2] = 0.5
    digests.add(converted()[0].image.pixels)
    image.pixels.foreach_set(np.linspace(0.0, 1.0, 16 * 32 * 4, dtype=np.float32))
    image.update()
    digests.add(converted()[0].image.pixels)
    assert len(digests) == 3


def test_pictures_that_are_too_fine_to_be_evaluated_are_an_error(monkeypatch):
    world = World()
    world.show(tinted(world))
    monkeypatch.setattr(world_module, "LEAST_HEIGHT", 4)
    monkeypatch.setattr(world_module, "LARGEST_HEIGHT", 16)
    assert converted()[1] == []
    monkeypatch.setattr(world_module, "LARGEST_HEIGHT", 8)
    assert "a picture of 16 rows" in converted()[1][0]


def test_what_the_camera_alone_sees_is_no_light_and_told():
    world = World()
    is_camera = world.add("LightPath")
    plain = world.background((1.0, 0.0, 0.0, 1.0))
    lit = world.background((0.2, 0.2, 0.2, 1.0), 3.0)
    world.show(world.add("MixShader", Fac=is_camera, _1=lit, _2=plain))
    made, messages = converted()
    assert isinstance(made, UniformWorld)
    assert made.luminance == pytest.approx(0.6 * bpy.context.scene.lumenray.efficacy, rel=1e-6)
    assert made.seen.spectrum.red == 1.0
    assert made.seen.luminance == pytest.approx(
        0.2126 * bpy.context.scene.lumenray.efficacy, rel=1e-3
    )
    assert messages == ["the camera sees another world than what lights surfaces"]
    world.tree.nodes["Background"].inputs["Color"].default_value = (0.6, 0.6, 0.6, 1.0)
    made, messages = converted()
    assert made.seen is None
    assert messages == []


def test_a_picture_with_a_backdrop_for_the_camera_stays_as_it_is():
    world = World()
    plain = world.background((1.0, 0.0, 0.0, 1.0))
    lit = world.background(vivid(world))
    world.show(world.add("MixShader", Fac=world.add("LightPath"), _1=lit, _2=plain))
    made, messages = converted()
    assert len(messages) == 1
    assert isinstance(made, ImageWorld)


def test_shaders_that_are_none_of_a_world_are_told():
    world = World()
    world.show(world.add("BsdfDiffuse"))
    made, messages = converted()
    assert made is None
    assert messages[0] == "Diffuse BSDF is not converted in a world"


def test_what_is_known_by_samples_only_counts_by_its_mean_and_is_an_error():
    world = World()
    world.show(world.background(world.add("LayerWeight").node.outputs["Facing"]))
    made, messages = converted()
    assert isinstance(made, UniformWorld)
    assert "The world's light depends on what cannot be taken over" in messages


def test_directions_are_even_and_of_unit_length():
    made = directions(32)
    np.testing.assert_allclose(np.linalg.norm(made, axis=-1), 1.0, rtol=1e-6)
    # The pixel in the middle looks along x, the one to its right towards negative y.
    assert made[16, 32] @ (1.0, 0.0, 0.0) > 0.99
    assert made[16, 40, 1] < -0.5
    assert made[31, :, 2].min() > 0.99
