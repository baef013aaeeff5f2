"""Lights that Blender's IES texture shapes: the same light as Cycles makes of them."""

import os

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector
from photometric_files import write_ies

from lumenray.blender_addon.foundation.report import ConversionReport, Severity
from lumenray.blender_addon.sync.lights.lights import convert_light
from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.photometry.units import BLENDER_EFFICACY
from lumenray.engine.scene.light import Luminaire, PointLight
from lumenray.engine.scene.spectrum import Illuminant, Rgb

PIXELS = 16
SIDE = 2.0
"""Of the plane that is lit. [m]"""

FULL = np.arange(0, 361, 15)
"""Horizontal angles all around. [degree]"""


def lopsided(h, v):
    """Intensity without any symmetry, different in every quadrant. [cd]"""
    return 600.0 + np.sin(v) * (250.0 * np.cos(h - 0.6) + 120.0 * np.sin(2.0 * h))


def across(h, v):
    """Intensity over the angles of types A and B, different left, right, above and below. [cd]"""
    return 600.0 + 350.0 * np.sin(2.0 * h) * np.cos(v) + 200.0 * np.sin(2.0 * v) * np.cos(h)


HALF = np.arange(-90, 91, 3)
FILES = {
    "C": write_ies(lopsided, np.arange(0, 181, 10), FULL),
    "A": write_ies(across, HALF, HALF, "A"),
    "B": write_ies(across, HALF, HALF, "B"),
}


class Lamp:
    """A light with an IES texture that drives its Emission node."""

    def __init__(self, kind="POINT", text=FILES["C"]):
        self.data = bpy.data.lights.new("Lamp", kind)
        self.data.use_nodes = True
        self.data.energy = 5.0
        if kind != "AREA":
            self.data.shadow_soft_size = 0.0
        self.source = bpy.data.objects.new("Lamp", self.data)
        bpy.context.scene.collection.objects.link(self.source)
        self.emission = next(n for n in self.tree.nodes if n.bl_idname == "ShaderNodeEmission")
        self.ies = self.tree.nodes.new("ShaderNodeTexIES")
        self.ies.mode = "INTERNAL"
        self.ies.ies = bpy.data.texts.new("profile.ies")
        self.ies.ies.from_string(text)
        self.link(self.ies.outputs["Fac"], self.emission.inputs["Strength"])

    @property
    def tree(self):
        return self.data.node_tree

    def link(self, output, socket):
        self.tree.links.new(output, socket)

    def multiply(self, factor, operation="MULTIPLY"):
        """Put a Math node between the texture and the strength."""
        node = self.tree.nodes.new("ShaderNodeMath")
        node.operation = operation
        node.inputs[1].default_value = factor
        self.link(self.ies.outputs["Fac"], node.inputs[0])
        self.link(node.outputs[0], self.emission.inputs["Strength"])
        return node

    def convert(self, efficacy=BLENDER_EFFICACY):
        """Return the engine's light and the rows of the report."""
        bpy.context.view_layer.update()
        source = self.source.evaluated_get(bpy.context.evaluated_depsgraph_get())
        report = ConversionReport()
        light = convert_light(source, "id", "Lamp", source.matrix_world, 1.0, efficacy, report)
        return light, [row for row, _ in report.rows]


def candelas(light, direction):
    """Intensity of a luminaire towards directions of the world."""
    local = np.asarray(direction) @ light.frame[:3, :3]
    share = light.output.value / flux(light.distribution)
    return share * intensity(light.distribution, local)


def lit_plane(light):
    """Illuminance by the inverse-square law at the centres of the pixels, bottom row first. [lx]"""
    places = (np.arange(PIXELS) + 0.5) / PIXELS * SIDE - 0.5 * SIDE
    x, y = np.meshgrid(places, places)
    way = np.stack([x, y, np.zeros_like(x)], axis=-1) - light.frame[:3, 3]
    distance = np.linalg.norm(way, axis=-1)
    return candelas(light, way / distance[..., None]) * -way[..., 2] / distance**3


@pytest.fixture
def cycles_illuminance(tmp_path):
    """Return a function that lets Cycles light a white plane at z = 0: illuminance, bottom row first. [lx]"""

    def render():
        mesh = bpy.data.meshes.new("Plane")
        half = 0.6 * SIDE
        mesh.from_pydata(
            [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)],
            [],
            [(0, 1, 2, 3)],
        )
        white = bpy.data.materials.new("White")
        if bpy.app.version < (5, 0, 0):
            white.use_nodes = True
        white.node_tree.nodes.clear()
        shader = white.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
        shader.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
        output = white.node_tree.nodes.new("ShaderNodeOutputMaterial")
        white.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
        mesh.materials.append(white)
        camera = bpy.data.cameras.new("Camera")
        camera.type, camera.ortho_scale = "ORTHO", SIDE
        eye = bpy.data.objects.new("Camera", camera)
        eye.location = (0.0, 0.0, 5.0)
        scene = bpy.context.scene
        for thing in (bpy.data.objects.new("Plane", mesh), eye):
            scene.collection.objects.link(thing)
        scene.camera = eye
        scene.render.engine = "CYCLES"
        scene.render.resolution_x = scene.render.resolution_y = PIXELS
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.render.image_settings.color_depth = "32"
        scene.view_settings.view_transform = "Raw"
        scene.cycles.samples = 4
        scene.cycles.max_bounces = 0
        scene.cycles.use_denoising = False
        scene.cycles.filter_width = 0.01
        scene.cycles.use_adaptive_sampling = False
        scene.cycles.sample_clamp_direct = 0.0
        path = tmp_path / "cycles.exr"
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(str(path))
        pixels = np.empty(PIXELS * PIXELS * 4, np.float32)
        image.pixels.foreach_get(pixels)
        rgb = pixels.reshape(PIXELS, PIXELS, 4)[..., :3]
        return BLENDER_EFFICACY * np.pi * rgb @ (0.2126, 0.7152, 0.0722)

    return render


def quadrants(values):
    """Mean of each quarter of a picture."""
    half = len(values) // 2
    return np.array(
        [values[a : a + half, b : b + half].mean() for a in (0, half) for b in (0, half)]
    )


FACING_DOWN = {
    "C": Euler((0.0, 0.0, 0.0)),
    "A": Euler((-np.pi / 2, 0.0, 0.0)),
    "B": Euler((0.0, -np.pi / 2, 0.0)),
}
"""Turns that bring where Cycles points the photometric types (-Z, +Y and -X) down."""


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("tilted", [(0.0, 0.0, 0.0), (0.3, -0.2, 1.1), (-0.2, 0.3, -2.5)])
@pytest.mark.parametrize("kind", ["C", "B", "A"])
def test_a_light_shines_as_it_does_in_cycles(kind, tilted, cycles_illuminance):
    lamp = Lamp(text=FILES[kind])
    turns = Euler(tilted).to_matrix() @ FACING_DOWN[kind].to_matrix()
    lamp.source.matrix_world = Matrix.Translation((0.1, -0.2, 1.0)) @ turns.to_4x4()
    light, rows = lamp.convert()
    assert rows == []
    expected, found = lit_plane(light), cycles_illuminance()
    # Cycles goes round the corners of the table by cubics, the engine by straight lines.
    np.testing.assert_allclose(found, expected, rtol=0.03)
    np.testing.assert_allclose(quadrants(found), quadrants(expected), rtol=0.005)
    assert np.ptp(quadrants(expected)) > 0.1 * expected.mean()


def test_nothing_shines_where_cycles_has_none(cycles_illuminance):
    lamp = Lamp(text=FILES["A"])
    lamp.source.location.z = 1.0
    light, _ = lamp.convert()
    expected, found = lit_plane(light), cycles_illuminance()
    # Seen from the lamp at the plane's middle line the directions end.
    assert expected[:7].max() == 0.0
    np.testing.assert_allclose(found[:7], 0.0, atol=1.0)
    np.testing.assert_allclose(found[10:], expected[10:], rtol=0.03)


def test_power_strength_colour_and_factors_give_the_level_of_cycles(cycles_illuminance):
    lamp = Lamp()
    lamp.source.location = (0.0, 0.0, 1.0)
    lamp.data.energy, lamp.data.color = 3.0, (1.0, 0.5, 0.2)
    if hasattr(lamp.data, "exposure"):
        lamp.data.exposure = 1.0
    lamp.ies.inputs["Strength"].default_value = 2.0
    lamp.multiply(0.25)
    lamp.emission.inputs["Color"].default_value = (0.9, 0.8, 0.1, 1.0)
    light, rows = lamp.convert()
    assert rows == []
    spectrum = light.output.spectrum
    assert isinstance(spectrum, Rgb)
    tint = (spectrum.red, spectrum.green, spectrum.blue)
    assert tint == pytest.approx((1.0, 0.4 / 0.9, 0.02 / 0.9), rel=1e-5)
    np.testing.assert_allclose(cycles_illuminance(), lit_plane(light), rtol=0.02)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("blend", [0.0, 0.6])
@pytest.mark.parametrize("kind", ["C", "A"])
def test_the_cone_of_a_spot_cuts_the_profile_as_in_cycles(kind, blend, cycles_illuminance):
    text = FILES[kind]
    if kind == "A":
        # Cycles points type A at +Y, which a cone about -Z meets only at its edge.
        text = write_ies(lambda h, v: 600.0 + 250.0 * np.sin(h) * np.cos(v), HALF, HALF, "A")
    lamp = Lamp("SPOT", text)
    lamp.source.location = (0.2, 0.1, 1.0)
    lamp.data.spot_size, lamp.data.spot_blend = np.deg2rad(70.0), blend
    light, _ = lamp.convert()
    expected, found = lit_plane(light), cycles_illuminance()
    away = np.abs(found - expected)
    # Where a hard edge, or that of what type A covers, crosses a pixel the two may differ.
    assert (away < 0.02 * expected.max()).mean() > (0.93 if blend == 0.0 else 0.98)
    assert (expected == 0.0).any()
    np.testing.assert_allclose(found.mean(), expected.mean(), rtol=0.03)


def test_a_mirrored_object_mirrors_its_light_as_in_cycles(cycles_illuminance):
    lamp = Lamp()
    lamp.source.location, lamp.source.scale = (0.1, 0.0, 1.0), (-1.0, 1.0, 1.0)
    light, _ = lamp.convert()
    assert np.linalg.det(light.frame[:3, :3]) == pytest.approx(1.0)
    np.testing.assert_allclose(cycles_illuminance(), lit_plane(light), rtol=0.02)


def test_c0_points_to_minus_y_and_c90_to_minus_x():
    table = np.tile([[0.0], [1.0], [2.0], [3.0], [0.0]], (1, 3)) * [0.0, 100.0, 0.0]
    lamp = Lamp(text=write_ies(table, [0, 90, 180], [0, 90, 180, 270, 360]))
    light, _ = lamp.convert()
    way = np.array([[0, -1, 0], [-1, 0, 0], [0, 1, 0], [1, 0, 0]], float)
    # 5 W at Cycles' own 177.83 lm/W: five times the file's candelas.
    np.testing.assert_allclose(candelas(light, way), [0.0, 500.0, 1000.0, 1500.0], atol=1e-9)


def test_another_efficacy_scales_the_candelas():
    lamp = Lamp(text=write_ies([[1000.0, 1000.0]], [0, 180], [0]))
    light, _ = lamp.convert(efficacy=683.002)
    assert candelas(light, [0, 0, -1]) == pytest.approx(5.0 * 1000.0 * 683.002 / 177.83)


def test_the_file_type_of_2019_is_no_factor():
    lamp = Lamp(
        text=write_ies(
            [[1000.0, 1000.0]], [0, 180], [0], edition="IES:LM-63-2019", second_factor=1.11
        )
    )
    light, _ = lamp.convert()
    assert candelas(light, [0, 0, -1]) == pytest.approx(5000.0)


def test_a_white_light_keeps_its_white():
    light, _ = Lamp().convert()
    assert light.output.spectrum == Illuminant("D65")


def test_a_file_on_disk_is_read(tmp_path):
    lamp = Lamp()
    lamp.ies.mode = "EXTERNAL"
    path = tmp_path / "one.ies"
    path.write_text(write_ies([[100.0, 100.0]], [0, 180], [0]))
    lamp.ies.filepath = str(path)
    light, rows = lamp.convert()
    assert candelas(light, [0, 0, -1]) == pytest.approx(500.0)
    assert rows == []


def test_a_path_in_a_library_is_relative_to_the_library(tmp_path):
    folder = tmp_path / "library"
    folder.mkdir()
    (folder / "one.ies").write_text(write_ies([[100.0, 100.0]], [0, 180], [0]))
    lamp = Lamp()
    lamp.ies.mode, lamp.ies.filepath = "EXTERNAL", "//one.ies"
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "library.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "user.blend"))
    with bpy.data.libraries.load(str(folder / "library.blend"), link=True) as (_, here):
        here.objects = ["Lamp"]
    lamp.source = here.objects[0]
    bpy.context.scene.collection.objects.link(lamp.source)
    light, rows = lamp.convert()
    assert rows == []
    assert candelas(light, [0, 0, -1]) == pytest.approx(500.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (FILES["C"].replace("\n1 1 10\n", "\n"), "expected"),
        ("nothing of that kind", "is not an IES LM-63 file"),
        (FILES["C"].replace("600", "NaN", 1), "NaN"),
    ],
)
def test_a_refused_file_leaves_the_light_out(text, words):
    light, rows = Lamp(text=text).convert()
    assert light is None
    assert [row.severity for row in rows] == [Severity.ERROR]
    assert words in rows[0].message
    assert rows[0].remedy == "the light is left out"


def test_a_texture_without_a_file_leaves_the_light_out():
    lamp = Lamp()
    lamp.ies.ies = None
    light, rows = lamp.convert()
    assert light is None
    assert "no text data-block" in rows[0].message
    lamp.ies.mode, lamp.ies.filepath = "EXTERNAL", "//not there.ies"
    light, rows = lamp.convert()
    assert light is None
    assert "cannot be opened" in rows[0].message
    # What has no end ended Blender.
    lamp.ies.filepath = "/dev/zero" if os.name == "posix" else os.devnull
    light, rows = lamp.convert()
    assert light is None
    assert "is a device, expected a file" in rows[0].message


@pytest.mark.parametrize("operation", ["POWER", "MINIMUM", "ADD"])
def test_nodes_that_bend_the_profile_are_refused(operation):
    lamp = Lamp()
    lamp.multiply(2.0, operation)
    light, rows = lamp.convert()
    assert light is None
    assert "more with the IES texture than multiplying" in rows[0].message


def test_a_division_by_a_constant_is_a_factor():
    lamp = Lamp(text=write_ies([[1000.0, 1000.0]], [0, 180], [0]))
    lamp.multiply(4.0, "DIVIDE")
    light, _ = lamp.convert()
    assert candelas(light, [0, 0, -1]) == pytest.approx(1250.0)


def test_a_profile_that_drives_the_colour_is_the_same():
    lamp = Lamp(text=write_ies([[1000.0, 1000.0]], [0, 180], [0]))
    lamp.tree.links.remove(lamp.emission.inputs["Strength"].links[0])
    lamp.emission.inputs["Strength"].default_value = 3.0
    lamp.link(lamp.ies.outputs["Fac"], lamp.emission.inputs["Color"])
    light, _ = lamp.convert()
    assert candelas(light, [0, 0, -1]) == pytest.approx(15000.0)


def test_directions_from_nodes_are_reported():
    lamp = Lamp()
    normal = lamp.tree.nodes.new("ShaderNodeNewGeometry")
    lamp.link(normal.outputs["Incoming"], lamp.ies.inputs["Vector"])
    light, rows = lamp.convert()
    assert isinstance(light, Luminaire)
    assert [row.severity for row in rows] == [Severity.WARNING]
    assert "directions" in rows[0].message


def test_an_area_light_takes_the_candelas_with_a_warning():
    lamp = Lamp("AREA", write_ies([[1000.0, 1000.0, 0.0]], [0, 90, 180], [0]))
    lamp.data.shape, lamp.data.size, lamp.data.size_y = "RECTANGLE", 0.3, 1.2
    light, rows = lamp.convert()
    assert candelas(light, [0, 0, -1]) == pytest.approx(5000.0)
    assert light.opening.shape == "rectangle"
    assert light.opening.size == pytest.approx((0.3, 1.2, 0.0))
    assert "area light" in rows[0].message


def test_a_radius_makes_a_sphere():
    lamp = Lamp()
    lamp.data.shadow_soft_size = 0.25
    light, _ = lamp.convert()
    assert (light.opening.shape, light.opening.size) == ("ellipsoid", (0.5, 0.5, 0.5))


def test_watts_of_a_unit_of_surface_count_as_in_cycles(cycles_illuminance):
    lamp = Lamp()
    if not hasattr(lamp.data, "normalize"):
        pytest.skip("this version has no such choice")
    lamp.source.location = (0.0, 0.0, 1.0)
    lamp.data.normalize, lamp.data.shadow_soft_size = False, 0.01
    light, _ = lamp.convert()
    np.testing.assert_allclose(cycles_illuminance().mean(), lit_plane(light).mean(), rtol=0.02)


def test_physical_parameters_state_the_amount_and_the_file_the_shape():
    lamp = Lamp()
    settings = lamp.data.lumenray
    settings.use_physical, settings.quantity, settings.value = True, "LUMINOUS_FLUX", 1234.0
    light, _ = lamp.convert()
    assert light.output.value == 1234.0
    settings.quantity = "LUMINOUS_INTENSITY"
    light, _ = lamp.convert()
    assert candelas(light, [0, 0, -1]) == pytest.approx(1234.0)
    settings.quantity = "LUMINANCE"
    assert lamp.convert()[0] is None


def test_the_tilt_of_the_luminaire_counts():
    tilt = "TILT=INCLUDE\n1\n3\n0 45 90\n1 0.8 0.6"
    lamp = Lamp(text=write_ies([[1000.0, 1000.0]], [0, 180], [0], tilt=tilt))
    lamp.source.rotation_euler = (np.deg2rad(45.0), 0.0, 0.0)
    light, _ = lamp.convert()
    assert candelas(light, [0, 0, -1]) == pytest.approx(4000.0)


def test_a_sun_and_a_light_without_the_texture_are_as_before():
    lamp = Lamp()
    lamp.tree.links.remove(lamp.emission.inputs["Strength"].links[0])
    assert isinstance(lamp.convert()[0], PointLight)


def test_on_a_surface_the_texture_is_reported_and_dark(tree):
    from lumenray.blender_addon.sync.nodes.evaluation import Context, evaluate_field
    from lumenray.blender_addon.sync.nodes.fields import as_scalar

    node = tree.add("TexIES")
    emission = tree.add("Emission", Strength=node.outputs["Fac"])
    report = ConversionReport()
    value = as_scalar(evaluate_field(emission.inputs["Strength"], Context("Paint", report)))
    assert value == 0.0
    assert [row.severity for row, _ in report.rows] == [Severity.ERROR]
    assert "IES texture" in report.rows[0][0].message


def test_vector_of_the_frame_is_the_beam():
    lamp = Lamp()
    lamp.source.rotation_euler = (0.4, 0.2, 0.9)
    light, _ = lamp.convert()
    beam = lamp.source.rotation_euler.to_matrix() @ Vector((0, 0, -1))
    np.testing.assert_allclose(-light.frame[:3, 2], beam, atol=1e-6)


def test_a_texture_of_radiant_intensities_is_no_white_light():
    text = write_ies([[100.0, 100.0]], [0, 180], [0], keywords=("[_INTENSITYUNITS] mW/sr",))
    light, rows = Lamp(text=text).convert()
    assert light is None
    assert "radiant intensities, 1.257 W without a spectrum" in rows[0].message
    assert rows[0].remedy == "it lights nothing visible"
