"""Normal maps, bumps and displacement as bump: what the engine gets of them, and what is told."""

import numpy as np
import pytest
from conversion import messages_of
from material_trees import EFFICACY, add_image

from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.materials.materials import convert_material
from lumenray.engine.scene.material import Dielectric, Diffuse, Glossy, Mix, Raised
from lumenray.engine.scene.relief import Axes, Heights, Normals
from lumenray.engine.scene.scene import content_digest

pytestmark = pytest.mark.blender

COLOURS = np.array([[[0.7, 0.4, 0.9], [0.5, 0.5, 1.0]]], np.float32)


def picture(tree, pixels=COLOURS, name="Picture"):
    """Output of a picture on the UV map."""
    attributes = {"image": add_image(name, pixels), "interpolation": "Linear"}
    return tree.add("TexImage", attributes=attributes).outputs["Color"]


def heights(tree):
    values = np.linspace(0.1, 0.8, 12, dtype=np.float32).reshape(3, 4, 1)
    return picture(tree, values.repeat(3, 2), "Heights")


def bent(tree, normal, kind="BsdfDiffuse"):
    """A material with one shader whose normal comes from a node."""
    return tree.surface(tree.add(kind, Normal=normal.outputs["Normal"]))


def test_a_normal_map_becomes_the_vectors_that_blender_reads(tree, convert):
    node = tree.add("NormalMap", Strength=0.5, Color=picture(tree))
    result, rows = convert(bent(tree, node))
    relief = result.surface.relief
    assert isinstance(relief, Normals)
    assert (relief.axes, relief.strength, rows) == (Axes.TANGENT, 1.0, [])
    # x and y are halved, z goes half of the way from 1: 2 * 0.9 - 1 = 0.8.
    assert relief.vectors.pixels[0, 0] == pytest.approx([0.2, -0.1, 0.9], abs=1e-6)
    assert relief.vectors.pixels[0, 1] == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    assert result.surface.surface == Diffuse(result.surface.surface.reflectance)


@pytest.mark.parametrize(
    ("space", "axes", "sign"),
    [("OBJECT", Axes.OBJECT, 1), ("WORLD", Axes.WORLD, 1), ("BLENDER_WORLD", Axes.WORLD, -1)],
)
def test_normals_in_other_axes_keep_their_strength(tree, convert, space, axes, sign):
    node = tree.add("NormalMap", attributes={"space": space}, Strength=0.5, Color=picture(tree))
    relief = convert(bent(tree, node))[0].surface.relief
    assert (relief.axes, relief.strength) == (axes, 0.5)
    assert relief.vectors.pixels[0, 0] == pytest.approx([0.4, -0.2 * sign, 0.8 * sign], abs=1e-6)


@pytest.mark.parametrize("invert", [False, True])
def test_a_bump_becomes_heights_in_metres(tree, invert):
    node = tree.add(
        "Bump", attributes={"invert": invert}, Strength=0.7, Distance=0.2, Height=heights(tree)
    )
    material = bent(tree, node)
    made = convert_material(material, "key", ConversionReport(), EFFICACY, metres=0.01)
    relief = made.surface.relief
    assert isinstance(relief, Heights)
    assert (relief.strength, relief.in_object, relief.is_shape) == (
        pytest.approx(0.7),
        False,
        False,
    )
    rise = relief.heights.pixels[2, 3, 0] - relief.heights.pixels[0, 0, 0]
    assert rise == pytest.approx((-1 if invert else 1) * 0.7 * 0.2 * 0.01, rel=1e-4)


def test_a_bump_lies_on_the_normal_that_it_is_given(tree, convert):
    below = tree.add("NormalMap", Color=picture(tree))
    node = tree.add("Bump", Height=heights(tree), Normal=below.outputs["Normal"])
    relief = convert(bent(tree, node))[0].surface.relief
    assert isinstance(relief, Heights)
    assert isinstance(relief.below, Normals)


@pytest.mark.parametrize(
    ("method", "space"), [("BUMP", "OBJECT"), ("BUMP", "WORLD"), ("BOTH", "WORLD")]
)
def test_displacement_as_bump_raises_all_shaders(tree, convert, method, space):
    first, second = tree.add("BsdfDiffuse"), tree.add("BsdfAnisotropic", Roughness=0.3)
    mix = tree.add("MixShader", Fac=0.4, Shader=first.outputs[0], Shader_001=second.outputs[0])
    material = tree.surface(mix)
    node = tree.add(
        "Displacement", attributes={"space": space}, Height=heights(tree), Midlevel=0.3, Scale=0.5
    )
    output = material.node_tree.get_output_node("CYCLES")
    material.node_tree.links.new(node.outputs[0], output.inputs["Displacement"])
    material.displacement_method = method
    result, rows = convert(material)
    assert rows == []
    assert isinstance(result.surface, Mix)
    for part, kind in ((result.surface.first, Diffuse), (result.surface.second, Glossy)):
        assert isinstance(part.surface, kind)
        assert part.relief.is_shape
        assert part.relief.in_object == (space == "OBJECT" or method == "BOTH")
        values = part.relief.heights.pixels
        assert values[0, 0, 0] == pytest.approx((0.1 - 0.3) * 0.5, abs=1e-5)
        assert np.ptp(values) == pytest.approx(0.35, abs=1e-5)


def test_a_mesh_that_is_displaced_has_no_bump(tree, convert):
    material = tree.surface(tree.add("BsdfDiffuse"))
    node = tree.add("Displacement", Height=heights(tree))
    output = material.node_tree.get_output_node("CYCLES")
    material.node_tree.links.new(node.outputs[0], output.inputs["Displacement"])
    material.displacement_method = "DISPLACEMENT"
    result, rows = convert(material)
    assert isinstance(result.surface, Diffuse)
    assert rows == []


@pytest.mark.parametrize(
    ("kind", "surface"),
    [
        ("BsdfAnisotropic", Glossy),
        ("BsdfMetallic", Glossy),
        ("BsdfGlass", Dielectric),
        ("BsdfTranslucent", Diffuse),
    ],
)
def test_shaders_take_their_own_normal(tree, convert, kind, surface):
    node = tree.add("NormalMap", Color=picture(tree))
    made = convert(bent(tree, node, kind))[0].surface
    assert isinstance(made, Raised)
    assert isinstance(made.surface, surface)


def test_only_the_shader_with_a_normal_is_raised(tree, convert):
    node = tree.add("NormalMap", Color=picture(tree))
    first = tree.add("BsdfDiffuse", Normal=node.outputs[0])
    second = tree.add("BsdfAnisotropic", Roughness=0.3)
    mix = tree.add("MixShader", Fac=0.4, Shader=first.outputs[0], Shader_001=second.outputs[0])
    made = convert(tree.surface(mix))[0].surface
    assert isinstance(made.first, Raised)
    assert isinstance(made.second, Glossy)


def test_even_normals_and_heights_are_no_relief(tree, convert):
    flat = tree.add("NormalMap")
    node = tree.add("Bump", Height=0.7, Normal=flat.outputs[0])
    result, rows = convert(bent(tree, node))
    assert isinstance(result.surface, Diffuse)
    assert rows == []


def test_a_constant_colour_tilts_all_normals(tree, convert):
    node = tree.add("NormalMap", Color=(0.7, 0.5, 0.9))
    relief = convert(bent(tree, node))[0].surface.relief
    assert relief.vectors.pixels.shape == (1, 1, 3)
    assert relief.vectors.pixels[0, 0] == pytest.approx([0.4, 0.0, 0.8], abs=1e-5)


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda tree: tree.add("Bump", Height=tree.add("TexNoise").outputs["Fac"]), "UV map"),
        (lambda tree: tree.add("NormalMap", Color=tree.add("TexNoise").outputs["Color"]), "UV map"),
        (lambda tree: tree.add("Bump", Height=tree.add("LayerWeight").outputs["Facing"]), "UV map"),
        (
            lambda tree: tree.add("Bump", Height=tree.add("TexChecker", Vector=tree.add("UVMap").outputs[0]).outputs["Fac"]),
            "steps",
        ),
        (lambda tree: tree.add("Normal"), "Normal"),
        (lambda tree: tree.add("Bevel"), "Bevel"),
    ],
    ids=["noise heights", "noise normals", "view", "checker", "normal node", "bevel"],
)  # fmt: skip
def test_what_cannot_be_taken_over_is_told_and_flat(tree, convert, make, word):
    result, rows = convert(bent(tree, make(tree)))
    assert isinstance(result.surface, Diffuse)
    assert word in messages_of(rows)
    assert any("normal is used" in row["instead"] or "left out" in row["instead"] for row in rows)


def test_a_vector_displacement_in_object_space_is_told_as_bump(tree, convert):
    material = tree.surface(tree.add("BsdfDiffuse"))
    node = tree.add("VectorDisplacement", attributes={"space": "OBJECT"}, Vector=picture(tree))
    output = material.node_tree.get_output_node("CYCLES")
    material.node_tree.links.new(node.outputs[0], output.inputs["Displacement"])
    result, rows = convert(material)
    assert isinstance(result.surface, Diffuse)
    assert "Displacement by a vector" in messages_of(rows)


def test_pictures_on_two_maps_are_told(tree, convert):
    where = tree.add("UVMap", attributes={"uv_map": "Other"})
    attributes = {"image": add_image("Heights", COLOURS), "interpolation": "Linear"}
    height = tree.add("TexImage", attributes=attributes, Vector=where.outputs[0])
    bump = tree.add("Bump", Height=height.outputs["Color"])
    shader = tree.add("BsdfDiffuse", Color=picture(tree), Normal=bump.outputs[0])
    assert "UV maps '', 'Other'" in messages_of(convert(tree.surface(shader))[1])


CHANGES = {
    "Bump": {
        "Strength": 0.4,
        "Distance": 0.5,
        "Filter Width": 0.7,
        "invert": True,
    },
    "NormalMap": {"Strength": 0.4, "space": "OBJECT", "uv_map": "Other"},
    "Displacement": {"Scale": 0.7, "Midlevel": 0.1, "space": "WORLD"},
}


@pytest.mark.parametrize(
    ("kind", "name"), [(kind, name) for kind, names in CHANGES.items() for name in names]
)
def test_every_setting_changes_the_relief_or_is_told(tree, kind, name):
    found = []
    for value in (None, CHANGES[kind][name]):
        tree.nodes.clear()
        node = tree.add(kind)
        source = picture(tree, name="Colours") if kind == "NormalMap" else heights(tree)
        tree.set(node, "Color" if kind == "NormalMap" else "Height", source)
        if value is not None and name in node.inputs:
            node.inputs[name].default_value = value
        elif value is not None:
            setattr(node, name, value)
        if kind == "Displacement":
            material = tree.surface(tree.add("BsdfDiffuse"))
            output = material.node_tree.get_output_node("CYCLES")
            material.node_tree.links.new(node.outputs[0], output.inputs["Displacement"])
        else:
            material = bent(tree, node)
        report = ConversionReport()
        made = convert_material(material, "key", report, EFFICACY)
        found.append((content_digest(made), sorted(row.text() for row, _ in report.rows)))
    assert found[0] != found[1]
