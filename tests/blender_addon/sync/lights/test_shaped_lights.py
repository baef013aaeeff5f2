"""Points and spots that nodes or an uneven scale give a shape: candelas by direction, as Cycles has them."""

import bpy
import numpy as np
import pytest
from blender_objects import add_light
from conversion import converted_light, error_messages, measure_light

from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.photometry.spectra import (
    GRID,
    evaluate_emission,
    luminous_efficiency,
    upsample,
)
from lumenray.engine.scene.light import Luminaire, PointLight, Quantity, SpotLight
from lumenray.engine.scene.spectrum import Illuminant, Rgb

pytestmark = pytest.mark.usefixtures("extension")

EFFICACY = 177.83


class Nodes:
    """A light's node tree; `drive` links an output to an input of its Emission."""

    def __init__(self, light):
        light.data.use_nodes = True
        self.tree = light.data.node_tree
        self.emission = next(
            node for node in self.tree.nodes if node.bl_idname == "ShaderNodeEmission"
        )

    def add(self, kind, **attributes):
        node = self.tree.nodes.new(f"ShaderNode{kind}")
        for name, value in attributes.items():
            setattr(node, name, value)
        return node

    def link(self, output, to):
        self.tree.links.new(output, to)

    def drive(self, output, to="Strength"):
        self.link(output, self.emission.inputs[to])

    def part(self, vector, axis):
        node = self.add("SeparateXYZ")
        self.link(vector, node.inputs[0])
        return node.outputs[axis]

    def maths(self, operation, first, second=0.0):
        node = self.add("Math", operation=operation)
        for socket, value in zip(node.inputs, (first, second), strict=False):
            if isinstance(value, float):
                socket.default_value = value
            else:
                self.link(value, socket)
        return node.outputs[0]


def candelas(light, direction):
    """Of the engine's light towards a direction of its own axes."""
    whole = flux(light.distribution)
    return light.output.value / whole * intensity(light.distribution, np.array(direction, float))


def test_a_light_by_the_height_of_its_direction_is_one_of_that_intensity():
    """1 + z in the light's own axes, whose flux is that of an even one."""
    light = add_light("POINT", energy=10.0, shadow_soft_size=0.0)
    nodes = Nodes(light)
    height = nodes.part(nodes.add("TexCoord").outputs["Normal"], "Z")
    nodes.drive(nodes.maths("ADD", height, 1.0))
    made, rows = converted_light(light)
    assert rows == []
    assert isinstance(made, Luminaire)
    even = 10.0 * EFFICACY / (4.0 * np.pi)
    assert made.output.value == pytest.approx(10.0 * EFFICACY, rel=1e-4)
    for direction in ((0, 0, 1), (0, 0, -1), (1, 0, 0), (0.6, 0, -0.8)):
        assert candelas(made, direction) == pytest.approx(
            even * (1 + direction[2]), abs=2e-3 * even
        )


@pytest.mark.parametrize(("node", "output"), [("NewGeometry", "Normal"), ("TexCoord", "Normal")])
def test_directions_of_the_world_stay_and_those_of_the_object_turn_with_it(node, output):
    light = add_light("POINT", location=(0, 0, 1), energy=10.0, shadow_soft_size=0.0)
    light.rotation_euler = (np.pi / 2, 0.0, 0.0)
    nodes = Nodes(light)
    height = nodes.part(nodes.add(node).outputs[output], "Z")
    nodes.drive(nodes.maths("SUBTRACT", 1.0, height))
    below, _ = measure_light((0, 0, 0))
    even = 10.0 * EFFICACY / (4.0 * np.pi)
    # Down is across to the turned object.
    assert below == pytest.approx(even * (2.0 if node == "NewGeometry" else 1.0), rel=5e-3)


def test_a_slide_is_projected_to_the_edges_of_the_cone():
    """A slide whose left half is black over the UV of a spot: the light's own left side is dark."""
    light = add_light("SPOT", energy=10.0, shadow_soft_size=0.0, spot_size=1.0, spot_blend=0.0)
    slide = bpy.data.images.new("Slide", 2, 1, float_buffer=True)
    slide.pixels[:] = [0, 0, 0, 1, 0.5, 0.5, 0.5, 1]
    nodes = Nodes(light)
    picture = nodes.add("TexImage", image=slide, interpolation="Closest")
    nodes.link(nodes.add("TexCoord").outputs["UV"], picture.inputs["Vector"])
    nodes.drive(picture.outputs["Color"], "Color")
    made, rows = converted_light(light)
    assert error_messages(rows) == []
    half = 0.5 * 10.0 * EFFICACY / (4.0 * np.pi)
    sine, cosine = np.sin(0.4), -np.cos(0.4)
    assert candelas(made, (sine, 0.1, cosine)) == pytest.approx(half, rel=5e-3)
    assert candelas(made, (-sine, 0.1, cosine)) == pytest.approx(0.0, abs=1e-6)
    outside = np.sin(0.6), 0.0, -np.cos(0.6)
    assert candelas(made, outside) == pytest.approx(0.0, abs=1e-6)
    lit = half * np.pi * (1.0 - np.cos(0.5))
    assert made.output.value == pytest.approx(lit, rel=5e-3)


@pytest.mark.parametrize("stretch", [(2.0, 1.0, 1.0), (1.0, 1.0, 2.0), (3.0, 0.5, 1.0)])
def test_the_cone_of_an_unevenly_scaled_spot_is_an_ellipse(stretch):
    """Its solid angle by an even sum over directions."""
    light = add_light("SPOT", energy=10.0, shadow_soft_size=0.0, spot_size=1.2, spot_blend=0.0)
    light.scale = stretch
    made, rows = converted_light(light)
    assert error_messages(rows) == []
    z = -1.0 + (np.arange(1000) + 0.5) / 500
    azimuth = 2.0 * np.pi * (np.arange(1000) + 0.5) / 1000
    plan = np.sqrt(1.0 - z**2)[:, None]
    ray = np.stack(
        np.broadcast_arrays(plan * np.cos(azimuth), plan * np.sin(azimuth), z[:, None]), axis=-1
    ) / np.array(stretch)
    lit = (-ray[..., 2] / np.linalg.norm(ray, axis=-1) > np.cos(0.6)).mean() * 4.0 * np.pi
    even = 10.0 * EFFICACY / (4.0 * np.pi)
    assert made.output.value == pytest.approx(even * lit, rel=0.01)
    edge = np.tan(0.6) * np.array(stretch) / stretch[2]
    for axis in (0, 1):
        for share, expected in ((0.95, even), (1.05, 0.0)):
            direction = np.array([0.0, 0.0, -1.0])
            direction[axis] = share * edge[axis]
            assert candelas(made, direction) == pytest.approx(expected, abs=0.05 * even)


def test_physical_flux_is_kept_by_every_shape():
    light = add_light("SPOT", shadow_soft_size=0.0, spot_size=1.2)
    light.scale = (2.0, 1.0, 1.0)
    settings = light.data.lumenray
    settings.use_physical, settings.quantity, settings.value = True, "LUMINOUS_FLUX", 500.0
    made, _ = converted_light(light)
    assert (made.output.quantity, made.output.value) == (Quantity.LUMINOUS_FLUX, 500.0)
    settings.quantity = "LUMINOUS_INTENSITY"
    made, _ = converted_light(light)
    assert candelas(made, (0, 0, -1)) == pytest.approx(500.0, rel=1e-3)


def test_even_lights_stay_what_they_are():
    """A spot of one scale, and a point with a node of the direction that nothing asks."""
    light = add_light("SPOT", energy=10.0)
    light.scale = (2.0, 2.0, 2.0)
    assert isinstance(converted_light(light)[0], SpotLight)
    point = add_light("POINT", energy=10.0, shadow_soft_size=0.0)
    nodes = Nodes(point)
    nodes.add("TexCoord")
    nodes.drive(nodes.maths("MULTIPLY", 3.0, 1.0))
    made, rows = converted_light(point)
    assert isinstance(made, PointLight)
    assert rows == []


def test_what_depends_on_more_than_the_direction_is_still_an_error():
    light = add_light("POINT", energy=10.0, shadow_soft_size=0.0)
    nodes = Nodes(light)
    nodes.drive(nodes.part(nodes.add("TexCoord").outputs["Object"], "Z"))
    made, rows = converted_light(light)
    assert isinstance(made, PointLight) or made is None
    assert error_messages(rows)


def coloured_light():
    light = add_light("POINT", energy=10.0, shadow_soft_size=0.0)
    nodes = Nodes(light)
    shift = nodes.add("VectorMath", operation="ADD")
    shift.inputs[1].default_value = (1.0, 1.0, 1.0)
    nodes.link(nodes.add("TexCoord").outputs["Normal"], shift.inputs[0])
    nodes.drive(shift.outputs[0], "Color")
    return light


def test_colours_by_direction_are_kept_beside_their_luminance():
    """1 + x, 1 + y, 1 + z in red, green and blue."""
    made, rows = converted_light(coloured_light())
    assert rows == []
    even = 10.0 * EFFICACY / (4.0 * np.pi)
    assert candelas(made, (0, 1, 0)) == pytest.approx(even * (1.0 + 0.7152), rel=5e-3)
    shown = made.distribution
    column = np.argmin(np.abs(shown.azimuth - 0.5 * np.pi))
    row = np.argmin(np.abs(shown.polar - 0.5 * np.pi))
    colour = shown.colours[column, row]
    assert colour / colour[0] == pytest.approx([1.0, 2.0, 1.0], abs=0.02)
    assert made.output.spectrum == Illuminant("D65")


def test_a_slide_filters_the_spectrum_that_a_light_states():
    """By sums over the wavelengths at two directions: (1, 2, 1) and (2, 1, 1)."""
    light = coloured_light()
    settings = light.data.lumenray
    settings.use_physical, settings.quantity, settings.value = True, "LUMINOUS_FLUX", 500.0
    settings.spectrum, settings.illuminant = "ILLUMINANT", "A"
    made, rows = converted_light(light)
    assert rows == []
    assert (made.output.value, made.output.spectrum) == (500.0, Illuminant("A"))
    seen = evaluate_emission(Illuminant("A"), GRID) * luminous_efficiency()
    green, red = (upsample(Rgb(*c), GRID) @ seen for c in ((0.5, 1.0, 0.5), (1.0, 0.5, 0.5)))
    found = candelas(made, (0, 1, 0)) / candelas(made, (1, 0, 0))
    assert found == pytest.approx(green / red, rel=0.01)


@pytest.mark.parametrize(
    ("seen", "visible", "told"), [(0.0, False, 0), (1.0, True, 0), (2.0, True, 1)]
)
def test_what_the_camera_sees_of_a_light_by_its_nodes(seen, visible, told):
    light = add_light("POINT", energy=10.0, shadow_soft_size=0.05)
    light.visible_camera = True
    nodes = Nodes(light)
    is_camera = nodes.add("LightPath").outputs["Is Camera Ray"]
    change = nodes.maths("MULTIPLY", is_camera, seen - 1.0)
    nodes.drive(nodes.maths("ADD", change, 1.0))
    made, rows = converted_light(light)
    assert made.visible_to_camera == visible
    assert len(rows) == told
