"""Procedural textures against Cycles, which shows them at the same coordinates."""

from dataclasses import dataclass, field
from itertools import product

import bpy
import numpy as np
import pytest
from material_trees import PIXELS, add_image, add_texture, evaluate, noise_image, output_of

from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.images.cache import ImageCache
from lumenray.blender_addon.sync.nodes import fields
from lumenray.blender_addon.sync.nodes.evaluation import Context, evaluate_field

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

KINDS = ("Noise", "Voronoi", "Wave", "Magic", "Gradient", "WhiteNoise", "Gabor")

QUICK = [[case for case in CASES if case.kind == kind][-5] for kind in KINDS]


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


RANGES = {
    "Scale": (0.5, 1.5),
    "Detail": (-0.5, 4.0),
    "Roughness": (0.1, 0.8),
    "Lacunarity": (1.5, 2.5),
    "Offset": (0.0, 1.0),
    "Gain": (0.5, 1.5),
    "Distortion": (0.1, 1.0),
    "Smoothness": (-0.3, 1.2),
    "Exponent": (0.7, 3.0),
    "Randomness": (-0.1, 1.1),
    "Detail Scale": (0.5, 2.0),
    "Detail Roughness": (0.1, 0.8),
    "Phase Offset": (0.0, 6.0),
    "Frequency": (0.5, 3.0),
    "Anisotropy": (-0.1, 1.1),
    "Orientation 2D": (0.0, 3.0),
    "Orientation 3D": (0.1, 1.0),
}

VARIED = [
    *(Case("Noise", "Fac", {"noise_type": kind, "noise_dimensions": "3D"}) for kind in NOISES),
    *(
        Case("Voronoi", "Distance", {"feature": feature, "distance": "MINKOWSKI"})
        for feature in FEATURES[:4]
    ),
    Case("Wave", "Fac", {"wave_profile": "SIN"}),
    Case("Magic", "Color", {"turbulence_depth": 4}),
    Case("Gabor", "Value", {"gabor_type": "2D"}),
    Case("Gabor", "Value", {"gabor_type": "3D"}),
]


@pytest.mark.slow
@pytest.mark.parametrize("case", VARIED, ids=str)
def test_all_inputs_may_vary_from_place_to_place(tree, cycles_colour, case):
    output = add_case(tree, case)
    random = np.random.default_rng(8)
    for socket in output.node.inputs:
        if not socket.enabled or socket.name not in RANGES:
            continue
        values = random.uniform(*RANGES[socket.name], (PIXELS, PIXELS, 3))
        picture = add_texture(tree, add_image(socket.name, values)).outputs["Color"]
        if socket.type != "VECTOR":
            picture = tree.add("SeparateColor", Color=picture).outputs["Red"]
        tree.material.node_tree.links.new(picture, socket)
    raised = tree.add("VectorMath", attributes={"operation": "ADD"})
    tree.material.node_tree.links.new(output, raised.inputs[0])
    raised.inputs[1].default_value = [50.0] * 3
    ours, report = evaluate(tree, raised.outputs[0])
    assert not report.rows
    assert ours == pytest.approx(cycles_colour(tree, raised.outputs[0]), abs=1e-3)


ON_A_MAP = [
    Case("Noise", "Color", {"noise_dimensions": "3D"}, {"Scale": 3.0, "Detail": 1.0}),
    Case("Voronoi", "Distance", {"feature": "SMOOTH_F1"}, {"Scale": 2.0}),
    Case("Wave", "Fac", {"wave_type": "RINGS"}, {"Scale": 0.5, "Distortion": 1.0}),
    Case("Magic", "Color", {"turbulence_depth": 2}, {"Scale": 1.0}),
    Case("Gradient", "Color", {"gradient_type": "DIAGONAL"}),
    Case("Gabor", "Value", {"gabor_type": "2D"}, {"Scale": 2.0, "Frequency": 1.0}),
]


def add_on_a_map(tree, case, **mapping):
    """Add a texture on a UV map that is moved, turned and scaled; return the node."""
    values = {"Location": (0.3, -0.7, 0.4), "Rotation": (0.2, 0.1, 0.5), "Scale": (1.2, -0.8, 1.0)}
    mapped = tree.add("Mapping", Vector=tree.add("UVMap").outputs[0], **(values | mapping))
    node = tree.add(f"Tex{case.kind}", attributes=case.settings, Vector=mapped.outputs[0])
    for name, value in case.inputs.items():
        node.inputs[name].default_value = value
    return node


def messages(report):
    return [row["message"] for row in report.to_dicts()]


@pytest.mark.parametrize("case", ON_A_MAP, ids=str)
def test_textures_on_a_uv_map_are_drawn_as_in_cycles(tree, cycles_colour, case):
    output = output_of(add_on_a_map(tree, case), case.output)
    ours, report = evaluate(tree, output)
    theirs = cycles_colour(tree, output)
    # Cycles looks at a random place near each pixel's middle, and ours is interpolated between pixels.
    assert ours == pytest.approx(theirs, abs=0.01)
    assert np.ptp(theirs) > 0.2
    assert messages(report) == ["A procedural texture never repeats"]


def test_an_input_that_varies_over_the_same_map_counts_place_by_place(tree, cycles_colour):
    case = Case("Noise", "Fac", {"noise_dimensions": "4D"}, {"Scale": 2.0, "Detail": 1.0})
    node = add_on_a_map(tree, case)
    _, more = add_places(tree, case)
    tree.set(node, "W", more)
    ours, _ = evaluate(tree, output_of(node, "Fac"))
    assert ours == pytest.approx(cycles_colour(tree, output_of(node, "Fac")), abs=0.02)


def test_a_picture_finer_than_is_affordable_counts_at_the_pixels_that_are_drawn(
    tree, cycles_colour
):
    case = Case("Voronoi", "Distance", {"feature": "SMOOTH_F1", "voronoi_dimensions": "3D"})
    node = add_on_a_map(tree, case)
    node.inputs["Scale"].default_value = 1.5
    ramp = np.broadcast_to(np.linspace(0.2, 1, 600)[:, None, None], (600, 600, 3))
    tree.set(node, "Randomness", add_texture(tree, add_image("Ramp", ramp)).outputs["Color"])
    ours, report = evaluate(tree, output_of(node, "Distance"))
    assert ours == pytest.approx(cycles_colour(tree, output_of(node, "Distance")), abs=0.01)
    assert messages(report) == ["A procedural texture never repeats"]


def test_a_texture_is_drawn_anew_only_when_it_changes(tree):
    case = Case("Noise", "Fac", {"noise_dimensions": "2D"}, {"Detail": 0.0})
    node = add_on_a_map(tree, case)
    probe = tree.add("Emission", Color=output_of(node, "Fac"))
    images = ImageCache()

    def draw():
        context = Context("Paint", ConversionReport(), images)
        return evaluate_field(probe.inputs["Color"], context).values

    first = draw()
    images.sweep(set())
    assert draw() is first
    for change in (
        lambda: setattr(node, "normalize", False),
        lambda: setattr(node.inputs["Detail"], "default_value", 1.5),
        lambda: setattr(
            node.inputs["Vector"].links[0].from_node.inputs["Scale"], "default_value", (2, 1, 1)
        ),
    ):
        before = draw()
        change()
        assert not np.array_equal(draw(), before)
    before = draw()
    images.clear()
    assert draw() is not before


def test_a_picture_of_places_counts_with_a_finer_picture_of_an_input(tree, cycles_colour):
    case = Case("Noise", "Fac", {"noise_dimensions": "3D"}, {"Detail": 1.0})
    output = add_case(tree, case)
    fine = add_texture(tree, noise_image(4, 0.5, 1.5, (4 * PIXELS, 4 * PIXELS, 3)))
    scale = tree.add("SeparateColor", Color=fine.outputs["Color"]).outputs["Red"]
    tree.set(output.node, "Scale", scale)
    ours, _ = evaluate(tree, output, 8 * PIXELS)
    theirs = cycles_colour(tree, output, 8 * PIXELS)
    assert ours == pytest.approx(theirs, abs=1e-3)


@pytest.mark.parametrize("is_placed", [True, False])
def test_inputs_that_vary_in_another_way_count_by_their_mean(tree, is_placed):
    picture = add_texture(tree, noise_image(6, 0.2, 0.8)).outputs["Color"]
    depth = tree.add("CameraData").outputs["View Distance"]
    random = tree.add("ObjectInfo").outputs["Random"]
    case = Case("Noise", "Fac", {"noise_dimensions": "3D"})
    node = add_on_a_map(tree, case) if is_placed else tree.add("TexNoise")
    tree.set(node, "Distortion", random if is_placed else picture)
    tree.set(node, "Detail", depth)
    _, report = evaluate(tree, output_of(node, "Fac"))
    (row,) = (row for row in report.to_dicts() if row["message"].startswith("Inputs vary"))
    assert ("not vary" in row["instead"]) == is_placed


def test_a_texture_at_one_place_is_one_colour_without_a_row(tree, cycles_colour):
    place = tree.add("CombineXYZ", X=0.3, Y=-0.7, Z=0.4).outputs[0]
    output = tree.add("TexNoise", Vector=place).outputs["Color"]
    ours, report = evaluate(tree, output)
    assert not report.rows
    assert ours == pytest.approx(cycles_colour(tree, output), abs=1e-4)


@pytest.mark.parametrize(
    ("kind", "settings", "inputs"),
    [
        ("WhiteNoise", {"noise_dimensions": "3D"}, {}),
        ("WhiteNoise", {"noise_dimensions": "1D"}, {"W": 1.7}),
        ("Noise", {"noise_dimensions": "1D"}, {"W": 1.7}),
        ("Voronoi", {"voronoi_dimensions": "1D"}, {"W": -3.2}),
    ],
)
def test_what_depends_on_no_place_is_one_colour_without_a_row(
    tree, cycles_colour, kind, settings, inputs
):
    output = tree.add(f"Tex{kind}", attributes=settings, **inputs).outputs["Color"]
    ours, report = evaluate(tree, output)
    assert not report.rows
    assert ours == pytest.approx(cycles_colour(tree, output), abs=1e-4)


def test_white_noise_on_a_map_is_spread_evenly_and_told(tree):
    case = Case("WhiteNoise", "Value", {"noise_dimensions": "3D"})
    ours, report = evaluate(tree, output_of(add_on_a_map(tree, case), "Value"), 128)
    counts, _ = np.histogram(ours[..., 0], bins=8, range=(0, 1))
    assert counts == pytest.approx(np.full(8, counts.sum() / 8), abs=4 * np.sqrt(counts.sum() / 8))
    assert "Every point has a value of its own" in messages(report)


def test_details_that_no_picture_can_hold_are_told(tree):
    case = Case("Voronoi", "Color", inputs={"Scale": 3000.0})
    _, report = evaluate(tree, output_of(add_on_a_map(tree, case), "Color"))
    assert any("Details of the texture" in each for each in messages(report))


@pytest.mark.parametrize(
    "case",
    [
        Case("Noise", "Fac", {"noise_type": "RIDGED_MULTIFRACTAL"}, {"Offset": 0.9, "Gain": 1.5}),
        Case("Voronoi", "Distance", {"feature": "F2"}),
        Case("Magic", "Color", {"turbulence_depth": 2}),
        Case("Wave", "Fac", {"wave_profile": "SIN"}),
        Case("Gradient", "Fac", {"gradient_type": "SPHERICAL"}),
        Case("Gabor", "Intensity", {"gabor_type": "3D"}),
    ],
    ids=str,
)
def test_what_stands_for_a_texture_without_a_map_has_its_mean(tree, cycles_colour, case):
    node = tree.add(f"Tex{case.kind}", attributes=case.settings)
    for name, value in case.inputs.items():
        node.inputs[name].default_value = value
    ours, report = evaluate(tree, output_of(node, case.output))
    assert messages(report) == ["A procedural texture without a UV map"]
    cube = np.random.default_rng(2).uniform(0, 1, (128, 128, 3))
    tree.set(node, "Vector", add_texture(tree, add_image("Cube", cube)).outputs["Color"])
    theirs = cycles_colour(tree, output_of(node, case.output), 128)
    error = 4 * theirs.std(axis=(0, 1)) / np.sqrt(fields.SAMPLES)
    assert (np.abs(ours[0, 0] - theirs.mean(axis=(0, 1))) < error + 1e-3).all()


def test_a_mapping_counts_where_coordinates_are_no_map(tree):
    generated = tree.add("TexCoord").outputs["Generated"]
    mapped = tree.add("Mapping", Vector=generated, Scale=(0.1, 1.0, 1.0), Location=(0.2, 0, 0))
    gradient = tree.add("TexGradient", Vector=mapped.outputs[0])
    ours, _ = evaluate(tree, gradient.outputs["Fac"])
    assert ours[0, 0, 0] == pytest.approx(0.25, abs=1e-3)


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE", "VECTOR", "NORMAL"])
def test_mapping_of_colours_is_that_of_cycles(tree, cycles_colour, kind):
    place, _ = add_places(tree, Case("Noise", "Fac"))
    values = {"Rotation": (0.4, -0.3, 0.9), "Scale": (1.3, -0.6, 0.5)}
    if kind in {"POINT", "TEXTURE"}:
        values["Location"] = (0.5, -0.2, 0.3)
    mapped = tree.add("Mapping", attributes={"vector_type": kind}, Vector=place, **values)
    raised = tree.add("VectorMath", attributes={"operation": "ADD"})
    tree.material.node_tree.links.new(mapped.outputs[0], raised.inputs[0])
    raised.inputs[1].default_value = [50.0] * 3
    ours, _ = evaluate(tree, raised.outputs[0])
    assert ours == pytest.approx(cycles_colour(tree, raised.outputs[0]), abs=1e-3)


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        ("Noise", {"noise_dimensions": "4D"}),
        ("Noise", {"noise_type": "HYBRID_MULTIFRACTAL"}),
        ("Voronoi", {"distance": "MINKOWSKI", "voronoi_dimensions": "2D"}),
        ("Voronoi", {"feature": "DISTANCE_TO_EDGE"}),
        ("Wave", {}),
        ("Magic", {}),
        ("Gabor", {"gabor_type": "2D"}),
    ],
)
def test_hostile_inputs_give_finite_colours(tree, kind, settings):
    place = tree.add("CombineXYZ", X=0.3, Y=-0.7, Z=0.4).outputs[0]
    node = tree.add(f"Tex{kind}", attributes=settings, Vector=place)
    numbers = [socket for socket in node.inputs if socket.enabled and socket.type == "VALUE"]
    for socket in numbers:
        before = socket.default_value
        for number in (float("nan"), float("inf"), -float("inf"), 1e30, -1e30, 0.0, -2.5):
            socket.default_value = number
            ours, report = evaluate(tree, node.outputs[0])
            assert np.isfinite(ours).all()
            if not np.isfinite(socket.default_value):
                assert "An input is not finite" in messages(report)
        socket.default_value = before


@pytest.mark.parametrize("scale", [float("nan"), float("inf"), 1e30, 0.0])
def test_a_hostile_scale_on_a_map_gives_a_picture_that_is_finite(tree, scale):
    node = add_on_a_map(tree, Case("Voronoi", "Distance", {"voronoi_dimensions": "2D"}))
    node.inputs["Scale"].default_value = scale
    ours, _ = evaluate(tree, output_of(node, "Distance"))
    assert np.isfinite(ours).all()
