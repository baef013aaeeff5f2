"""Physical overrides: their models, files and faults."""

import bpy
import cgats_files
import pytest
from conversion import messages_of, rgb_of

from lumenray.engine.scene.material import (
    Black,
    Cauchy,
    Coated,
    Conductor,
    Dielectric,
    Fabric,
    IorTable,
    TabulatedPane,
    ThinGlass,
)
from lumenray.engine.scene.spectrum import Constant, Illuminant, Tabulated

pytestmark = pytest.mark.blender


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
    assert "exceeds 1" in messages_of(rows)


def test_override_fabric_states_all_its_shares(override, convert):
    material, settings = override
    settings.model = "FABRIC"
    settings.openness, settings.reflectance, settings.transmittance = 0.03, 0.4, 0.2
    result, rows = convert(material)
    assert isinstance(result.surface, Fabric)
    assert result.surface.openness == pytest.approx(0.03)
    assert result.surface.reflectance.value == pytest.approx(0.4)
    assert result.surface.transmittance.value == pytest.approx(0.2)
    assert rows == []


def test_override_fabric_is_held_to_all_light(override, convert):
    material, settings = override
    settings.model = "FABRIC"
    settings.openness, settings.reflectance, settings.transmittance = 0.5, 0.75, 0.25
    result, rows = convert(material)
    assert result.surface.openness == pytest.approx(0.25)
    assert result.surface.transmittance.value == 0.0
    result.surface.check()
    assert [row["instead"] for row in rows] == [
        "the openness is reduced to 0.25", "the transmittance is reduced to 0",
    ]  # fmt: skip


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
            assert rgb_of(result.surface.reflectance) == (0.5, 0.25, 0.125)
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


def test_an_instruments_file_gives_a_reflectance_and_its_other_samples_are_told(
    override, convert, tmp_path
):
    material, settings = override
    path = tmp_path / "chart.txt"
    settings.reflectance_source, settings.reflectance_file = "FILE", str(path)
    path.write_text(cgats_files.samples("SPECTRAL_PCT_{}", 100.0))
    result, rows = convert(material)
    assert result.surface.reflectance.values == pytest.approx(cgats_files.grey(0.2), rel=1e-5)
    assert any("has 3 samples, of which the first one ('A 1')" in row["message"] for row in rows)
    assert any("in per cent; they are read as shares" in row["message"] for row in rows)
    # Per cent that the file does not tell are refused, as in any other file.
    path.write_text(cgats_files.samples("SPECTRAL_NM{}", 100.0))
    result, rows = convert(material)
    assert result.surface.reflectance == Constant(settings.reflectance)
    assert any("perhaps per cent" in row["message"] for row in rows)


def test_relative_path_is_relative_to_the_blend_file(override, convert, tmp_path):
    material, settings = override
    (tmp_path / "paint.csv").write_text("400,0.1\n700,0.6\n")
    settings.reflectance_source, settings.reflectance_file = "FILE", "//paint.csv"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "room.blend"))
    result, rows = convert(material)
    assert isinstance(result.surface.reflectance, Tabulated), rows
