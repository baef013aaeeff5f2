"""Materials: node trees and overrides become the engine's surfaces, departures become rows."""

import os
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.materials.materials import convert_material, default_material
from lumenray.blender_addon.sync.materials.principled import convert_principled
from lumenray.blender_addon.sync.nodes.evaluation import Context, Inputs
from lumenray.blender_addon.sync.spectra import convert_spectrum, light_spectrum
from lumenray.engine.errors import LumenrayError
from lumenray.engine.scene.material import (
    Black,
    Cauchy,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Glossy,
    IorTable,
    Material,
    Mix,
    TabulatedPane,
    ThinGlass,
    Transparent,
)
from lumenray.engine.scene.spectrum import Blackbody, Constant, Daylight, Illuminant, Tabulated
from lumenray.engine.scene.texture import ImageTexture

pytestmark = pytest.mark.blender

EFFICACY = 177.83
BLEND_FILES = os.environ.get("LUMENRAY_BLEND_FILES", "")
"""Folder of real files, old ones among them, that are too large to ship."""

LEGACY_FILES = sorted(Path(BLEND_FILES).glob("*.blend")) if BLEND_FILES else []


@pytest.fixture
def convert():
    """Return a function that converts a material and gives the result and the rows."""

    def run(material):
        report = ConversionReport()
        return convert_material(material, "key", report, EFFICACY), report.to_dicts()

    return run


def add_image(pixels, name="Picture"):
    pixels = np.asarray(pixels, np.float32)
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(name, width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    full = np.ones((height, width, 4), np.float32)
    full[..., :3] = pixels
    image.pixels.foreach_set(full.ravel())
    image.pack()
    return image


def messages(rows):
    return " | ".join(row["message"] for row in rows)


def approx_rgb(spectrum):
    return (spectrum.red, spectrum.green, spectrum.blue)


# --------------------------------------------------------------- Principled


def test_principled_paint_is_a_coated_base_without_rows(tree, convert):
    shader = tree.add("BsdfPrincipled", Base_Color=(0.6, 0.4, 0.2), Roughness=0.3)
    result, rows = convert(tree.surface(shader))
    assert isinstance(result.surface, Coated)
    assert approx_rgb(result.surface.reflectance) == pytest.approx((0.6, 0.4, 0.2))
    assert result.surface.ior == pytest.approx(1.5, abs=1e-5)
    assert result.surface.roughness == pytest.approx(0.3)
    assert (result.id, result.name, result.emission) == ("key", "Paint", None)
    assert rows == []


def test_specular_level_scales_the_reflectance_at_normal_incidence(tree, convert):
    shader = tree.add("BsdfPrincipled", IOR=1.5, Specular_IOR_Level=1.0)
    result, _ = convert(tree.surface(shader))
    reflectance = ((result.surface.ior - 1) / (result.surface.ior + 1)) ** 2
    assert reflectance == pytest.approx(0.08, rel=1e-4)


def test_no_specular_level_leaves_plain_diffuse(tree, convert):
    shader = tree.add("BsdfPrincipled", Base_Color=(0.5, 0.5, 0.5), Specular_IOR_Level=0.0)
    result, _ = convert(tree.surface(shader))
    assert result.surface == Diffuse(Constant(0.5))


def test_full_metallic_is_glossy_alone(tree, convert):
    shader = tree.add("BsdfPrincipled", Base_Color=(0.9, 0.7, 0.3), Metallic=1.0, Roughness=0.25)
    result, rows = convert(tree.surface(shader))
    assert isinstance(result.surface, Glossy)
    assert result.surface.roughness == pytest.approx(0.25)
    assert rows == []


def test_metallic_mask_mixes_place_by_place(tree, convert):
    mask = tree.add("TexImage", attributes={"image": add_image(np.eye(2)[..., None])})
    shader = tree.add("BsdfPrincipled", Metallic=mask.outputs["Color"])
    result, rows = convert(tree.surface(shader))
    assert isinstance(result.surface, Mix)
    assert isinstance(result.surface.first, Coated)
    assert isinstance(result.surface.second, Glossy)
    assert result.surface.factor.pixels[..., 0].tolist() == [[1, 0], [0, 1]]
    assert rows == []


def test_principled_glass_is_a_dielectric_with_the_root_of_its_colour(tree, convert):
    shader = tree.add(
        "BsdfPrincipled",
        Base_Color=(0.25, 0.25, 0.25),
        Transmission_Weight=1.0,
        IOR=1.45,
        Roughness=0.0,
    )
    result, _ = convert(tree.surface(shader))
    assert isinstance(result.surface, Dielectric)
    assert result.surface.ior == Cauchy(pytest.approx(1.45), 0.0)
    # Light passes the boundary twice, and what Blender shows then is the base colour.
    assert result.surface.tint.value**2 == pytest.approx(0.25)


def test_alpha_lets_light_through(tree, convert):
    result, _ = convert(tree.surface(tree.add("BsdfPrincipled", Alpha=0.25)))
    assert isinstance(result.surface.first, Transparent)
    assert isinstance(result.surface.second, Coated)
    assert result.surface.factor == pytest.approx(0.25)


def test_emission_strength_times_efficacy_is_luminance(tree, convert):
    shader = tree.add("BsdfPrincipled", Emission_Color=(1.0, 0.5, 0.25), Emission_Strength=3.0)
    result, _ = convert(tree.surface(shader))
    relative = 0.2126 * 1.0 + 0.7152 * 0.5 + 0.0722 * 0.25
    assert result.emission.luminance == pytest.approx(EFFICACY * 3.0 * relative, rel=1e-5)
    assert approx_rgb(result.emission.spectrum) == pytest.approx((1.0, 0.5, 0.25))
    assert result.emission.two_sided


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("Coat_Weight", 0.5),
        ("Sheen_Weight", 0.5),
        ("Subsurface_Weight", 0.5),
        ("Anisotropic", 0.5),
        ("Specular_Tint", (1.0, 0.2, 0.2)),
    ],
)
def test_unsupported_part_of_principled_is_reported(tree, convert, name, value):
    _, rows = convert(tree.surface(tree.add("BsdfPrincipled", **{name: value})))
    (row,) = rows
    assert row["object"] == "Paint"
    assert row["node"] == "Principled BSDF"
    assert row["instead"]


def test_normal_map_is_reported(tree, convert):
    normal = tree.add("NormalMap")
    _, rows = convert(tree.surface(tree.add("BsdfPrincipled", Normal=normal.outputs[0])))
    assert "normal" in messages(rows)


def test_roughness_picture_of_a_coat_becomes_its_mean_with_a_row(tree, convert):
    picture = tree.add("TexImage", attributes={"image": add_image([[[0.2], [0.6]]])})
    shader = tree.add("BsdfPrincipled", Roughness=picture.outputs["Color"])
    result, rows = convert(tree.surface(shader))
    assert result.surface.roughness == pytest.approx(0.4, abs=1e-5)
    assert "0.4" in rows[0]["instead"]


def test_colour_above_one_is_held_and_reported(tree, convert):
    shader = tree.add("BsdfDiffuse", Color=(2.0, 0.5, 0.5))
    result, rows = convert(tree.surface(shader))
    assert result.surface.reflectance.red == 1.0
    assert "0..1" in messages(rows)


# ------------------------------------------------------------ other shaders


def test_simple_shaders_become_their_surfaces_without_rows(tree, convert):
    white = (1.0, 1.0, 1.0)
    for shader, surface in [
        (tree.add("BsdfDiffuse", Color=white), Diffuse(Constant(1.0))),
        (tree.add("BsdfTranslucent", Color=white), Diffuse(Constant(0.0), Constant(1.0))),
        (tree.add("BsdfTransparent", Color=white), Transparent(Constant(1.0))),
        (
            tree.add("BsdfGlass", Color=white, IOR=1.5, Roughness=0.0),
            Dielectric(Cauchy(1.5, 0.0), 0.0, Constant(1.0)),
        ),
        (
            tree.add("BsdfAnisotropic", Color=white, Roughness=0.0, Anisotropy=0.0),
            Glossy(Constant(1.0), 0.0),
        ),
    ]:
        result, rows = convert(tree.surface(shader))
        assert result.surface == surface
        assert rows == []


def test_translucent_and_diffuse_added_are_one_exact_surface(tree, convert):
    first = tree.add("BsdfDiffuse", Color=(0.5, 0.5, 0.5)).outputs[0]
    second = tree.add("BsdfTranslucent", Color=(0.3, 0.3, 0.3)).outputs[0]
    result, rows = convert(tree.surface(tree.add("AddShader", Shader=first, Shader_001=second)))
    assert result.surface.reflectance.value == pytest.approx(0.5)
    assert result.surface.transmittance.value == pytest.approx(0.3)
    assert rows == []


def test_diffuse_sum_above_one_is_reduced_in_proportion(tree, convert):
    first = tree.add("BsdfDiffuse", Color=(0.8, 0.8, 0.8)).outputs[0]
    second = tree.add("BsdfTranslucent", Color=(0.8, 0.8, 0.8)).outputs[0]
    result, rows = convert(tree.surface(tree.add("AddShader", Shader=first, Shader_001=second)))
    assert result.surface.reflectance.value == pytest.approx(0.5)
    assert result.surface.transmittance.value == pytest.approx(0.5)
    assert "more than 1" in messages(rows)


def test_two_unlike_shaders_added_are_mixed_and_reported(tree, convert):
    first = tree.add("BsdfDiffuse").outputs[0]
    second = tree.add("BsdfAnisotropic").outputs[0]
    result, rows = convert(tree.surface(tree.add("AddShader", Shader=first, Shader_001=second)))
    assert result.surface.factor == 0.5
    assert len(rows) == 1


def test_mix_of_emission_and_diffuse_shares_the_emission(tree, convert):
    light = tree.add("Emission", Color=(1.0, 1.0, 1.0), Strength=10.0).outputs[0]
    matt = tree.add("BsdfDiffuse", Color=(0.5, 0.5, 0.5)).outputs[0]
    mixed = tree.add("MixShader", Fac=0.25, Shader=light, Shader_001=matt)
    result, _ = convert(tree.surface(mixed))
    assert result.emission.luminance == pytest.approx(EFFICACY * 7.5, rel=1e-5)
    assert result.emission.spectrum == Illuminant("D65")
    assert isinstance(result.surface.first, Black)
    assert result.surface.factor == pytest.approx(0.25)


def test_emission_added_to_a_surface_leaves_the_surface_whole(tree, convert):
    light = tree.add("Emission", Color=(1.0, 1.0, 1.0), Strength=2.0).outputs[0]
    matt = tree.add("BsdfDiffuse", Color=(0.5, 0.5, 0.5)).outputs[0]
    result, rows = convert(tree.surface(tree.add("AddShader", Shader=light, Shader_001=matt)))
    assert result.surface == Diffuse(Constant(0.5))
    assert result.emission.luminance == pytest.approx(EFFICACY * 2.0)
    assert rows == []


def test_luminous_picture_keeps_its_luminance_at_every_place(tree, convert):
    pixels = np.array([[[1.0, 0.0, 0.0], [0.5, 0.5, 0.5]], [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]]])
    picture = tree.add("TexImage", attributes={"image": add_image(pixels)})
    light = tree.add("Emission", Color=picture.outputs["Color"], Strength=4.0)
    result, _ = convert(tree.surface(light))
    weights = np.array([0.2126, 0.7152, 0.0722])
    ours = result.emission.luminance * result.emission.pattern.pixels @ weights
    assert ours == pytest.approx(EFFICACY * 4.0 * pixels @ weights, rel=1e-5)


def test_blackbody_emission_keeps_plancks_spectrum(tree, convert):
    colour = tree.add("Blackbody", Temperature=2700.0).outputs[0]
    result, _ = convert(tree.surface(tree.add("Emission", Color=colour, Strength=5.0)))
    assert result.emission.spectrum == Blackbody(2700.0)
    # Blender's blackbody colours have luminance 1.
    assert result.emission.luminance == pytest.approx(EFFICACY * 5.0, rel=1e-3)


def test_constant_factor_hides_the_other_branch_and_its_rows(tree, convert):
    odd = tree.add("BsdfToon").outputs[0]
    matt = tree.add("BsdfDiffuse", Color=(0.5, 0.5, 0.5)).outputs[0]
    result, rows = convert(
        tree.surface(tree.add("MixShader", Fac=1.0, Shader=odd, Shader_001=matt))
    )
    assert result.surface == Diffuse(Constant(0.5))
    assert rows == []


def test_glass_that_hides_from_shadow_rays_stays_glass(tree, convert):
    path = tree.add("LightPath")
    glass = tree.add("BsdfGlass", Color=(1.0, 1.0, 1.0)).outputs[0]
    clear = tree.add("BsdfTransparent").outputs[0]
    mixed = tree.add("MixShader", Fac=path.outputs["Is Shadow Ray"], Shader=glass)
    tree.set(mixed, "Shader 001", clear)
    result, rows = convert(tree.surface(mixed))
    assert isinstance(result.surface, Dielectric)
    assert "Is Shadow Ray" in messages(rows)


def test_gloss_over_diffuse_by_fresnel_is_a_coated_base(tree, convert):
    mixed = tree.add(
        "MixShader",
        Fac=tree.add("Fresnel", IOR=1.4).outputs[0],
        Shader=tree.add("BsdfDiffuse", Color=(0.5, 0.5, 0.5)).outputs[0],
        Shader_001=tree.add("BsdfAnisotropic", Roughness=0.3, Anisotropy=0.0).outputs[0],
    )
    result, rows = convert(tree.surface(mixed))
    assert isinstance(result.surface, Coated)
    assert result.surface.ior == pytest.approx(1.4)
    assert result.surface.roughness == pytest.approx(0.3)
    assert len(rows) == 1


def test_mirror_over_transparent_by_fresnel_is_a_pane(tree, convert):
    mixed = tree.add(
        "MixShader",
        Fac=tree.add("Fresnel", IOR=1.5).outputs[0],
        Shader=tree.add("BsdfTransparent", Color=(0.9, 0.9, 0.9)).outputs[0],
        Shader_001=tree.add("BsdfAnisotropic", Roughness=0.0, Anisotropy=0.0).outputs[0],
    )
    result, _ = convert(tree.surface(mixed))
    assert isinstance(result.surface, ThinGlass)
    assert result.surface.transmittance.value == pytest.approx(0.9)


def test_emission_of_the_front_alone_stays_one_sided(tree, convert):
    mixed = tree.add(
        "MixShader",
        Fac=tree.add("NewGeometry").outputs["Backfacing"],
        Shader=tree.add("Emission", Color=(1.0, 1.0, 1.0), Strength=1.0).outputs[0],
        Shader_001=tree.add("BsdfDiffuse").outputs[0],
    )
    result, rows = convert(tree.surface(mixed))
    assert not result.emission.two_sided
    assert len(rows) == 1


@pytest.mark.parametrize("kind", ["BsdfToon", "BsdfSheen", "SubsurfaceScattering", "BsdfHair"])
def test_unsupported_shader_is_diffuse_of_its_colour_with_a_row(tree, convert, kind):
    shader = tree.add(kind, Color=(0.5, 0.25, 0.125))
    result, rows = convert(tree.surface(shader))
    assert approx_rgb(result.surface.reflectance) == pytest.approx((0.5, 0.25, 0.125))
    assert rows[0]["node"] == shader.name


def test_shader_group_is_entered(tree, convert):
    group = bpy.data.node_groups.new("Wall", "ShaderNodeTree")
    group.interface.new_socket("Colour", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    matt = group.nodes.new("ShaderNodeBsdfDiffuse")
    group.links.new(start.outputs[0], matt.inputs["Color"])
    group.links.new(matt.outputs[0], end.inputs[0])
    node = tree.add("Group", attributes={"node_tree": group})
    node.inputs[0].default_value = (0.25, 0.25, 0.25, 1.0)
    result, rows = convert(tree.surface(node))
    assert result.surface == Diffuse(Constant(0.25))
    assert rows == []


# ------------------------------------------------------------- odd materials


def test_mesh_without_material_is_blenders_grey():
    assert default_material("none").surface == Diffuse(Constant(0.8))


def test_tree_without_output_is_black_and_reported(tree, convert):
    result, rows = convert(tree.material)
    assert result.surface == Black()
    assert "output" in messages(rows)


def test_output_without_surface_is_black_and_reported(tree, convert):
    tree.add("OutputMaterial")
    result, rows = convert(tree.material)
    assert result.surface == Black()
    assert len(rows) == 1


def test_volume_and_displacement_are_reported(tree, convert):
    material = tree.surface(tree.add("BsdfDiffuse"))
    output = material.node_tree.get_output_node("CYCLES")
    links = material.node_tree.links
    links.new(tree.add("VolumeAbsorption").outputs[0], output.inputs["Volume"])
    links.new(tree.add("Displacement").outputs[0], output.inputs["Displacement"])
    _, rows = convert(material)
    assert "volume" in messages(rows)
    assert "Displacement" in messages(rows)


def test_circle_of_shaders_ends_with_a_row(tree, convert):
    first, second = tree.add("AddShader"), tree.add("AddShader")
    tree.set(first, "Shader", second.outputs[0])
    tree.set(second, "Shader", first.outputs[0])
    result, rows = convert(tree.surface(first))
    assert result.surface == Black()
    assert "circle" in messages(rows)


def test_pass_index_is_kept(tree, convert):
    material = tree.surface(tree.add("BsdfDiffuse"))
    material.pass_index = 7
    assert convert(material)[0].index == 7


@pytest.mark.parametrize("path", LEGACY_FILES or [None], ids=lambda path: path and path.stem)
def test_materials_of_older_files_convert(path, convert, caplog):
    if path is None:
        pytest.skip("LUMENRAY_BLEND_FILES names no folder of .blend files")
    bpy.ops.wm.open_mainfile(filepath=str(path))
    for material in bpy.data.materials:
        if material.is_grease_pencil:
            continue
        result, rows = convert(material)
        assert isinstance(result, Material)
        assert all(row["message"] and row["instead"] for row in rows)
        assert "cannot be understood" not in messages(rows), caplog.text


# ---------------------------------------------------------- physical override


@pytest.fixture
def override():
    """Return a new material with its physical override on, and its settings."""
    material = bpy.data.materials.new("Measured")
    material.lumenray.use_override = True
    return material, material.lumenray


def test_override_off_uses_the_nodes(tree, convert):
    material = tree.surface(tree.add("BsdfDiffuse", Color=(0.3, 0.3, 0.3)))
    material.lumenray.reflectance = 0.9
    assert convert(material)[0].surface.reflectance.value == pytest.approx(0.3)


def test_override_diffuse_states_reflectance_and_transmittance(override, convert):
    material, settings = override
    settings.reflectance, settings.transmittance = 0.6, 0.25
    surface = convert(material)[0].surface
    assert surface.reflectance.value == pytest.approx(0.6)
    assert surface.transmittance.value == pytest.approx(0.25)


def test_override_that_would_create_light_is_reduced_and_reported(override, convert):
    material, settings = override
    settings.reflectance, settings.transmittance = 0.75, 0.5
    result, rows = convert(material)
    assert result.surface.transmittance.value == pytest.approx(0.25)
    assert "exceeds 1" in messages(rows)


def test_override_models_become_their_surfaces(override, convert):
    material, settings = override
    settings.ior, settings.roughness, settings.transmittance = 1.6, 0.1, 0.9
    settings.reflectance_source, settings.reflectance_color = "COLOR", (0.5, 0.25, 0.125)
    settings.metal = "Cu"
    expected = {"COATED": Coated, "CONDUCTOR": Conductor, "DIELECTRIC": Dielectric}
    for model, kind in (expected | {"THIN_GLASS": ThinGlass}).items():
        settings.model = model
        result, rows = convert(material)
        assert isinstance(result.surface, kind)
        assert rows == []
        if model == "COATED":
            assert result.surface.ior == pytest.approx(1.6)
            assert approx_rgb(result.surface.reflectance) == (0.5, 0.25, 0.125)
        elif model == "CONDUCTOR":
            assert result.surface.metal == "Cu"
        elif model == "DIELECTRIC":
            assert result.surface.ior == Cauchy(pytest.approx(1.6), 0.0)
        else:
            assert result.surface.transmittance.value == pytest.approx(0.9)


def test_override_emitter_states_luminance_in_candelas_per_square_metre(override, convert):
    material, settings = override
    settings.model, settings.luminance, settings.two_sided = "EMITTER", 5000.0, False
    settings.spectrum, settings.illuminant = "ILLUMINANT", "FL11"
    result, _ = convert(material)
    assert result.surface == Black()
    assert result.emission.luminance == 5000.0
    assert result.emission.spectrum == Illuminant("FL11")
    assert not result.emission.two_sided


def test_override_reads_reflectance_and_index_from_files(override, convert, tmp_path):
    material, settings = override
    table = tmp_path / "paint.csv"
    table.write_text("400,0.1\n700,0.6\n")
    settings.reflectance_source, settings.reflectance_file = "FILE", str(table)
    reflectance = convert(material)[0].surface.reflectance
    assert isinstance(reflectance, Tabulated)
    assert reflectance.values.tolist() == [0.1, 0.6]

    glass = tmp_path / "glass.csv"
    glass.write_text("400,1.53\n700,1.51\n")
    settings.model, settings.ior_source, settings.ior_file = "DIELECTRIC", "FILE", str(glass)
    assert isinstance(convert(material)[0].surface.ior, IorTable)


@pytest.mark.parametrize(
    ("model", "source", "values"),
    [
        ("DIFFUSE", "reflectance", ("0.1,0.6", "0.2,0.7")),
        ("DIELECTRIC", "ior", ("1.5,1.7", "1.6,1.8")),
    ],
)
def test_override_warns_that_a_file_has_other_columns(
    override, convert, tmp_path, model, source, values
):
    material, settings = override
    path = tmp_path / "paints.csv"
    path.write_text("nm,light,dark\n400,{}\n700,{}\n".format(*values))
    settings.model = model
    setattr(settings, f"{source}_source", "FILE")
    setattr(settings, f"{source}_file", str(path))
    result, rows = convert(material)
    made = result.surface.reflectance if source == "reflectance" else result.surface.ior
    assert made.values.tolist() == [float(row.split(",")[0]) for row in values]
    (row,) = (row for row in rows if row["severity"] == "warning")
    assert "paints.csv has 2 columns of values, of which the first one ('light')" in row["message"]
    path.write_text("400,0.1\n700,0.6\n" if source == "reflectance" else "400,1.5\n700,1.6\n")
    assert not any(row["severity"] == "warning" for row in convert(material)[1])


def test_override_reads_a_pane_from_its_data_sheet(override, convert, tmp_path):
    material, settings = override
    sheet = tmp_path / "pane.csv"
    sheet.write_text("angle;transmittance;reflectance\n60;0,6;0,2\n0;0,8;0,1\n")
    settings.model, settings.pane_source, settings.pane_file = "THIN_GLASS", "FILE", str(sheet)
    result, rows = convert(material)
    assert rows == []
    assert isinstance(result.surface, TabulatedPane)
    assert result.surface.angles.tolist() == [0.0, 60.0]
    assert result.surface.transmittance.tolist() == [0.8, 0.6]
    assert result.surface.reflectance.tolist() == [0.1, 0.2]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "cannot be opened"),
        ("no numbers here", "found none"),
        ("0,0.8\n60,0.6\n", "found none"),
        ("0,0.8,0.1\n60,0.9,0.2\n", "more than all of it"),
        ("0,80,10\n60,60,20\n", "expected 0 to 1"),
    ],
)
def test_unusable_data_sheet_is_an_error_row_and_clear_glass_counts(
    override, convert, tmp_path, content, words
):
    material, settings = override
    path = tmp_path / "pane.csv"
    if content is not None:
        path.write_text(content)
    settings.model, settings.pane_source, settings.pane_file = "THIN_GLASS", "FILE", str(path)
    result, rows = convert(material)
    assert isinstance(result.surface, ThinGlass)
    (row,) = rows
    assert row["severity"] == "error"
    assert "pane.csv" in row["message"]
    assert words in row["message"]


@pytest.mark.parametrize("content", [None, "no numbers here", "400,40\n700,60\n"])
def test_unusable_reflectance_file_is_an_error_row_and_the_value_counts(
    override, convert, tmp_path, content
):
    material, settings = override
    path = tmp_path / "paint.csv"
    if content is not None:
        path.write_text(content)
    settings.reflectance = 0.4
    settings.reflectance_source, settings.reflectance_file = "FILE", str(path)
    result, rows = convert(material)
    assert result.surface.reflectance.value == pytest.approx(0.4)
    (row,) = (row for row in rows if row["severity"] == "error")
    assert row["severity"] == "error"
    assert "paint.csv" in row["message"]
    assert "0.4" in row["instead"]


def test_relative_path_is_relative_to_the_blend_file(override, convert, tmp_path):
    material, settings = override
    (tmp_path / "paint.csv").write_text("400,0.1\n700,0.6\n")
    settings.reflectance_source, settings.reflectance_file = "FILE", "//paint.csv"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "room.blend"))
    result, rows = convert(material)
    assert isinstance(result.surface.reflectance, Tabulated), rows


# -------------------------------------------------------------------- spectra


def test_white_light_is_d65_and_colours_keep_only_their_chromaticity():
    assert light_spectrum((0.2, 0.2, 0.2)) == Illuminant("D65")
    assert approx_rgb(light_spectrum((4.0, 2.0, 1.0))) == pytest.approx((1.0, 0.5, 0.25))
    assert light_spectrum((0.0, 0.0, 0.0)) == Illuminant("D65")


def test_daylight_outside_its_range_is_held_and_reported(override):
    _, settings = override
    settings.spectrum, settings.colour_temperature = "DAYLIGHT", 3000.0
    report = ConversionReport()
    assert convert_spectrum(settings, (1, 1, 1), report, "Lamp") == Daylight(4000.0)
    (row,) = report.to_dicts()
    assert row["object"] == "Lamp"
    assert "3000 K" in row["message"]


def test_a_spectrum_file_that_is_not_there_is_never_replaced_by_the_colour(override):
    material, settings = override
    settings.spectrum, settings.spectrum_file = "FILE", "/nowhere/lamp.spdx"
    report = ConversionReport()
    with pytest.raises(LumenrayError, match=r"/nowhere/lamp\.spdx"):
        convert_spectrum(settings, (1.0, 0.5, 0.5), report, "Lamp")
    settings.model, settings.luminance = "EMITTER", 100.0
    assert convert_material(material, "m", report, 177.83).emission is None
    (row,) = report.to_dicts()
    assert row["missing"]
    assert "/nowhere/lamp.spdx" in row["message"]


def table_file(tmp_path, *columns):
    path = tmp_path / "lamp.txt"
    rows = zip(range(380, 781, 10), *columns, strict=True)
    path.write_text("\n".join(" ".join(map(str, row)) for row in rows))
    return str(path)


def test_a_spectrum_of_zeros_is_an_error_and_never_the_colour(override, convert, tmp_path):
    material, settings = override
    settings.spectrum, settings.spectrum_file = "FILE", table_file(tmp_path, [0] * 41)
    with pytest.raises(LumenrayError, match="no value above 0"):
        convert_spectrum(settings, (1.0, 0.5, 0.5), ConversionReport(), "Lamp")
    settings.model, settings.luminance = "EMITTER", 100.0
    made, rows = convert(material)
    assert made.emission is None
    assert rows[-1]["severity"] == "error"
    assert rows[-1]["instead"] == "the material does not shine"


def test_a_column_of_a_spectrum_is_chosen_and_one_that_is_not_is_told(override, tmp_path):
    _, settings = override
    settings.spectrum = "FILE"
    settings.spectrum_file = table_file(tmp_path, [1] * 41, [2] * 41)
    report = ConversionReport()
    assert convert_spectrum(settings, (1, 1, 1), report, "Lamp").values[0] == 1
    assert any("has 2 columns of values" in row["message"] for row in report.to_dicts())
    settings.spectrum_column, report = 2, ConversionReport()
    assert convert_spectrum(settings, (1, 1, 1), report, "Lamp").values[0] == 2
    assert not any("columns" in row["message"] for row in report.to_dicts())


def test_picture_of_a_wall_keeps_its_pixels(tree, convert):
    pixels = np.random.default_rng(1).uniform(0, 1, (3, 4, 3))
    picture = tree.add("TexImage", attributes={"image": add_image(pixels, "Wall")})
    shader = tree.add("BsdfDiffuse", Color=picture.outputs["Color"])
    result, rows = convert(tree.surface(shader))
    assert isinstance(result.surface.reflectance, ImageTexture)
    assert result.surface.reflectance.pixels == pytest.approx(pixels, abs=1e-6)
    assert rows == []


def gradient_lamp(tree, kind):
    """Let a gradient that is cut by a ramp decide where a surface glows."""
    ramp = tree.add("ValToRGB", Fac=tree.add("TexGradient").outputs["Fac"])
    ramp.color_ramp.interpolation = "CONSTANT"
    ramp.color_ramp.elements[1].position = 0.75
    if kind == "factor":
        glow = tree.add("Emission", Color=(1.0, 1.0, 1.0), Strength=8.0)
        mix = tree.add("MixShader")
        for place, socket in enumerate((ramp.outputs["Color"], None, glow.outputs[0])):
            if socket is not None:
                tree.material.node_tree.links.new(socket, mix.inputs[place])
        return mix
    if kind == "strength":
        return tree.add("Emission", Color=ramp.outputs["Color"], Strength=8.0)
    return tree.add("BsdfPrincipled", Emission_Color=ramp.outputs["Color"], Emission_Strength=8.0)


@pytest.mark.parametrize("kind", ["factor", "strength", "principled"])
def test_a_lamp_behind_a_texture_that_is_replaced_keeps_its_light_and_is_an_error(
    tree, convert, kind
):
    result, rows = convert(tree.surface(gradient_lamp(tree, kind)))
    # A quarter of the surface glows with 8 W/(m2 sr).
    assert result.emission.luminance == pytest.approx(2.0 * EFFICACY, rel=0.02)
    assert result.emission.pattern is None
    (row,) = (row for row in rows if row["severity"] == "error")
    assert "emission depends on what cannot be taken over" in row["message"]


def test_a_surface_behind_a_replaced_texture_is_no_error(tree, convert):
    ramp = tree.add("ValToRGB", Fac=tree.add("TexNoise").outputs["Fac"])
    glow = tree.add("BsdfPrincipled", Base_Color=ramp.outputs["Color"], Emission_Strength=1.0)
    result, rows = convert(tree.surface(glow))
    assert result.emission.luminance == pytest.approx(EFFICACY)
    assert {row["severity"] for row in rows} == {"warning"}


@pytest.mark.parametrize(
    ("strength", "words"),
    [(-3.0, "negative"), (float("inf"), "W/(m2 sr)"), (float("nan"), "cannot be taken over")],
)
def test_an_emission_that_is_no_light_is_an_error(tree, convert, strength, words):
    material = tree.surface(tree.add("Emission", Color=(1.0, 1.0, 1.0), Strength=strength))
    result, rows = convert(material)
    assert result.emission is None
    assert any(row["severity"] == "error" and words in row["message"] for row in rows)


@pytest.mark.parametrize("roughness", [0.0, 0.5])
def test_a_thin_wall_is_a_pane_and_no_solid(tree, roughness):
    """The node has its socket from Blender 5.2 on; here one is put beside those that it has."""
    shader = tree.add(
        "BsdfPrincipled", Transmission_Weight=1.0, Base_Color=(0.5, 0.5, 0.5), Roughness=roughness
    )
    wall = SimpleNamespace(
        identifier="Thin Wall", name="Thin Wall", type="BOOLEAN", links=(), default_value=True, is_output=False
    )  # fmt: skip
    report = ConversionReport()
    context = Context("Paint", report)
    for default_value, kind in ((True, ThinGlass), (False, Dielectric)):
        wall.default_value = default_value
        node = SimpleNamespace(name=shader.name, inputs=[*shader.inputs, wall])
        made = convert_principled(Inputs(node, shader.outputs[0], context, ()))
        assert isinstance(made.surface, kind)
        if default_value:
            assert made.surface.ior == pytest.approx(1.5)
            assert made.surface.transmittance == Constant(pytest.approx(0.5))
            assert bool(report.rows) == (roughness > 0.1)
