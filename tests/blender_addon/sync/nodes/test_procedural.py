"""Procedural textures against Cycles, which shows them at the same coordinates."""

from dataclasses import dataclass, field
from itertools import product

import bpy
import numpy as np
import pytest
from material_trees import PIXELS, add_image, add_texture, evaluate, output_of

pytestmark = pytest.mark.blender

DIMENSIONS = ("1D", "2D", "3D", "4D")

NOISES = ("FBM", "MULTIFRACTAL", "HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HETERO_TERRAIN")

FEATURES = ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS")

METRICS = ("EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI")


@dataclass(frozen=True)
class Case:
    """A texture: kind, output, settings, inputs, and where coordinates lie."""

    kind: str
    output: str
    settings: dict = field(default_factory=dict)
    inputs: dict = field(default_factory=dict)
    width: float = 6.0
    middle: float = 0.0
    tolerance: float = 1e-3

    def __str__(self):
        words = [self.kind, self.output, *self.settings.values()]
        words += [f"{name}={value}" for name, value in self.inputs.items()]
        return "-".join(map(str, [*words, self.width, self.middle]))


def noises():
    for kind, dimensions, output in product(NOISES, DIMENSIONS, ("Fac", "Color")):
        settings = {"noise_type": kind, "noise_dimensions": dimensions, "normalize": True}
        inputs = {"Scale": 1.3, "Detail": 3.4, "Roughness": 0.6, "Lacunarity": 2.1}
        if kind in NOISES[2:4]:
            inputs |= {"Offset": 0.7, "Gain": 1.4}
        if kind == "HETERO_TERRAIN":
            inputs |= {"Offset": 0.7}
        yield Case("Noise", output, settings, inputs | {"Distortion": 0.8})
    for normalize, detail, middle in product((True, False), (0.0, 2.0, 15.0), (0.0, -3000.0)):
        settings = {"noise_type": "FBM", "noise_dimensions": "3D", "normalize": normalize}
        yield Case("Noise", "Color", settings, {"Scale": 1.0, "Detail": detail}, middle=middle)
    for dimensions in DIMENSIONS:
        settings = {"noise_type": "FBM", "noise_dimensions": dimensions, "normalize": True}
        yield Case("Noise", "Color", settings, {"Scale": -0.7, "Detail": 0.0}, width=5e6)


def voronois():
    for feature, dimensions, metric in product(FEATURES, DIMENSIONS, METRICS):
        is_measured = feature in FEATURES[:3] and dimensions != "1D"
        if not is_measured and metric != "EUCLIDEAN":
            continue
        settings = {"feature": feature, "voronoi_dimensions": dimensions, "distance": metric}
        inputs = {"Scale": 1.2, "Randomness": 0.9}
        if metric == "MINKOWSKI":
            inputs["Exponent"] = 1.7
        if feature == "SMOOTH_F1":
            inputs["Smoothness"] = 0.8
        if feature == "N_SPHERE_RADIUS":
            yield Case("Voronoi", "Radius", settings, inputs)
            continue
        outputs = ["Distance"] if feature == "DISTANCE_TO_EDGE" else ["Distance", "Color"]
        for output in outputs:
            yield Case("Voronoi", output, settings, inputs)
        if feature != "DISTANCE_TO_EDGE" and metric == "EUCLIDEAN":
            if dimensions != "1D":
                yield Case("Voronoi", "Position", settings, inputs)
            if dimensions in {"1D", "4D"}:
                yield Case("Voronoi", "W", settings, inputs)
    for feature, dimensions, normalize in product(FEATURES[:4], ("1D", "3D"), (True, False)):
        settings = {"feature": feature, "voronoi_dimensions": dimensions, "normalize": normalize}
        inputs = {"Scale": 0.8, "Detail": 2.3, "Roughness": 0.7, "Lacunarity": 1.9}
        outputs = ["Distance"] if feature == "DISTANCE_TO_EDGE" else ["Distance", "Color"]
        for output in outputs:
            yield Case("Voronoi", output, settings, inputs, middle=-50.0)


def waves():
    for form, direction, profile in product(
        ("BANDS", "RINGS"), ("X", "Y", "Z", "last"), ("SIN", "SAW", "TRI")
    ):
        name = "bands_direction" if form == "BANDS" else "rings_direction"
        last = "DIAGONAL" if form == "BANDS" else "SPHERICAL"
        settings = {"wave_type": form, name: last if direction == "last" else direction}
        inputs = {"Scale": 0.4, "Distortion": 1.5, "Detail": 1.5, "Detail Scale": 0.8}
        inputs |= {"Detail Roughness": 0.4, "Phase Offset": 0.6}
        yield Case("Wave", "Fac", settings | {"wave_profile": profile}, inputs)
        yield Case(
            "Wave", "Color", settings | {"wave_profile": profile}, {"Scale": 0.3}, middle=-9.0
        )


def others():
    for depth, distortion in product(range(11), (1.0, 0.6)):
        inputs = {"Scale": 0.7, "Distortion": distortion}
        yield Case("Magic", "Color", {"turbulence_depth": depth}, inputs)
    yield Case("Magic", "Fac", {"turbulence_depth": 0}, {"Scale": 2.0}, middle=30.0)
    gradients = bpy.types.ShaderNodeTexGradient.bl_rna.properties["gradient_type"].enum_items
    for form in [each.identifier for each in gradients]:
        yield Case("Gradient", "Fac", {"gradient_type": form}, width=1.5)
        yield Case("Gradient", "Color", {"gradient_type": form}, width=1.5, middle=0.4)
    for dimensions, output in product(DIMENSIONS, ("Value", "Color")):
        for width in (1.0, 1e5):
            yield Case("WhiteNoise", output, {"noise_dimensions": dimensions}, width=width)
    for kind, output, anisotropy in product(
        ("2D", "3D"), ("Value", "Phase", "Intensity"), (1.0, 0.3)
    ):
        inputs = {"Scale": 0.8, "Frequency": 2.2, "Anisotropy": anisotropy}
        inputs |= {"Orientation 2D": 0.3} if kind == "2D" else {"Orientation 3D": (0.5, -0.4, 0.8)}
        yield Case("Gabor", output, {"gabor_type": kind}, inputs)


CASES = [*noises(), *voronois(), *waves(), *others()]

QUICK = [each for number, each in enumerate(CASES) if number in {4, 13, 22, 31, 57}]


def add_places(tree, case, seed=5):
    """Add coordinates that differ from pixel to pixel, and another number, as pictures."""
    places = np.random.default_rng(seed).uniform(-0.5, 0.5, (2, PIXELS, PIXELS, 3))
    place, more = case.middle + case.width * places
    first = add_texture(tree, add_image("Places", place)).outputs["Color"]
    second = add_texture(tree, add_image("More", more)).outputs["Color"]
    # A colour would become its luminance, which is rounded otherwise.
    return first, tree.add("SeparateColor", Color=second).outputs["Red"]


def add_case(tree, case):
    """Add a texture at places that pictures hold; return its output."""
    node = tree.add(f"Tex{case.kind}", attributes=case.settings)
    place, more = add_places(tree, case)
    for socket in node.inputs:
        if socket.name in case.inputs:
            socket.default_value = case.inputs[socket.name]
    tree.set(node, "Vector", place)
    if "W" in node.inputs:
        tree.set(node, "W", more)
    return output_of(node, case.output)


def compare(tree, cycles_colour, case):
    output = add_case(tree, case)
    # Cycles shows no negative light.
    if case.output in {"Position", "W"} or case.kind == "Noise":
        raised = tree.add("VectorMath", attributes={"operation": "ADD"})
        tree.material.node_tree.links.new(output, raised.inputs[0])
        raised.inputs[1].default_value = [100.0] * 3
        output = raised.outputs[0]
    ours, _ = evaluate(tree, output)
    theirs = cycles_colour(tree, output)
    assert np.ptp(theirs) > 0.01
    return ours, theirs


def check(tree, cycles_colour, case):
    ours, theirs = compare(tree, cycles_colour, case)
    differs = np.abs(ours - theirs).max(axis=-1)
    assert differs.max() < case.tolerance


@pytest.mark.parametrize("case", QUICK, ids=str)
def test_some_textures_are_those_of_cycles(tree, cycles_colour, case):
    check(tree, cycles_colour, case)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=str)
def test_textures_are_those_of_cycles(tree, cycles_colour, case):
    check(tree, cycles_colour, case)
