"""Cloths in Blender: descriptions go through settings unchanged, edits reach the engine's scene, errors are told."""

import json
from concurrent.futures import Future

import bpy
import numpy as np
import pytest
from panels import context, draw, finish_pictures, interface
from PIL import Image

from lumenray.blender_addon.cloths import preview, readout, tables
from lumenray.blender_addon.cloths.description import adopt, describe
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.materials.overrides import convert_override
from lumenray.engine.cloth.reader import parse_cloth
from lumenray.engine.cloth.surface import Sheet, WovenSurface
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.material import Diffuse, Measured
from lumenray.engine.scene.scattering import ScatterTable
from lumenray.libraries import cloths

# Everything that settings edit, and much that they do not.
CONTENT = {
    "lumenray_cloth": 1,
    "name": "Test",
    "source": "made up",
    "warp": {
        "width_mm": 0.2, "height_mm": 0.12, "index": 1.5, "roughness": 0.2,
        "scatterers": [
            {"index": 1.0, "diameter_um": 0.5, "volume_fraction": 0.03},
            {"index": 2.7, "diameter_um": 0.25, "volume_fraction": 0.001},
        ],
        "absorption_per_mm": {"wavelengths_nm": [400, 700], "values": [2.0, 0.5]},
    },
    "weft": {"width_mm": 0.1},
    "weave": {"satin": {"ends": 5, "step": 2}, "warp_pitch_mm": 0.22, "weft_pitch_mm": 0.3},
    "pile": {"yarn": {"width_mm": 0.05}, "height_mm": 0.8, "density_per_mm2": 12, "lean_deg": 10},
}  # fmt: skip

ROWS = {"rows": ["X.", ".X", "XX", ".."], "warp_pitch_mm": 0.25, "weft_pitch_mm": 0.25}


@pytest.fixture(scope="module", autouse=True)
def _interface():
    with interface():
        yield


@pytest.fixture
def material():
    material = bpy.data.materials.new("Curtain")
    settings = material.lumenray
    settings.use_override, settings.model = True, "CLOTH"
    yield material
    bpy.data.materials.remove(material)


def woven_surface(reflectance=0.3, transmittance=0.2, openness=0.1):
    """A cloth that is even over wavelengths and angles, with a direction."""
    zero, axis, turns = np.zeros(1), np.array([0.0, np.pi]), np.array([0.0, 0.5 * np.pi])

    def table(share, direct=None):
        values = np.full((2, 1, 2, 2, 1), share / np.pi, np.float32)
        straight = None if direct is None else np.full((2, 1, 1), direct, np.float32)
        return ScatterTable(
            turns, zero, axis, axis, np.array([550.0]), values, straight, is_orthotropic=True
        )

    reflection, passing = table(reflectance), table(transmittance, openness)
    both = [table(reflectance), table(transmittance, openness)]
    sheet = Sheet(
        openness, transmittance + openness, reflectance, reflectance, transmittance, 0.25, 0.35, 41.0, 43.0, 0.001, 0.002
    )  # fmt: skip
    return WovenSurface(
        Measured(reflection, both[0], passing, both[1]), sheet, np.full(3, 0.3), np.full(3, 0.2), 0.04, 612_000, 0, "f" * 64,
        ("no hairs stand off yarns",),
    )  # fmt: skip


@pytest.fixture
def engine(monkeypatch):
    """All cloths are one; gives what was asked."""
    asked = []

    def compute(text, is_draft, job):
        asked.append((json.loads(text), is_draft))
        return woven_surface()

    monkeypatch.setattr(tables, "compute", compute)
    tables.cloth_tables.forget()
    return asked


def test_a_new_cloth_begins_with_a_preset(material):
    settings = material.lumenray.cloth
    assert settings.name
    parse_cloth(describe(settings))


@pytest.mark.parametrize("name", ["test", "rows", *cloths.presets()])
def test_descriptions_go_through_settings_unchanged(material, name):
    path = cloths.presets().get(name)
    content = CONTENT if path is None else json.loads(path.read_text(encoding="utf-8"))
    if name == "rows":
        content = CONTENT | {"weave": ROWS}
    adopt(material.lumenray.cloth, content)
    assert describe(material.lumenray.cloth) == content


def test_edits_are_in_the_description_and_leave_the_rest(material):
    settings = material.lumenray.cloth
    adopt(settings, CONTENT)
    warp = settings.warp
    warp.width_mm, warp.height_mm, warp.index = 0.18, 0.1, 1.6
    warp.roughness, warp.scattering, warp.dye = 0.4, 0.05, 2.0
    settings.weft.width_mm = settings.weft.height_mm = 0.14
    settings.weave, settings.twill_over, settings.twill_under = "TWILL", 3, 1
    settings.warp_pitch_mm, settings.density_per_mm2, settings.lean = 0.24, 20.0, np.radians(25.0)
    settings.pile_yarn.roughness = 0.5
    made = describe(settings)
    parse_cloth(made)
    voids, white = CONTENT["warp"]["scatterers"]
    assert made == CONTENT | {
        "warp": {
            "width_mm": 0.18,
            "height_mm": 0.1,
            "index": 1.6,
            "roughness": 0.4,
            "scatterers": [voids | {"volume_fraction": 0.05}, white],
            "absorption_per_mm": {"wavelengths_nm": [400, 700], "values": [4.0, 1.0]},
        },
        # Round as before, so no height is stated.
        "weft": {"width_mm": 0.14},
        "weave": {"twill": [3, 1], "warp_pitch_mm": 0.24, "weft_pitch_mm": 0.3},
        "pile": CONTENT["pile"]
        | {
            "yarn": {"width_mm": 0.05, "roughness": 0.5},
            "density_per_mm2": 20.0,
            "lean_deg": 25.0,
        },
    }
    settings.is_weft_as_warp = True
    assert describe(settings)["weft"] == made["warp"]


def test_bitmaps_of_files_become_rows(material, tmp_path):
    pixels = np.array([[0, 255, 255], [255, 0, 255], [255, 255, 0]], np.uint8)
    Image.fromarray(pixels).save(tmp_path / "weave.png")
    weave = {"bitmap": "weave.png", "warp_pitch_mm": 0.25, "weft_pitch_mm": 0.25}
    file = tmp_path / "jacquard.json"
    file.write_text(json.dumps(CONTENT | {"weave": weave}), encoding="utf-8")
    with bpy.context.temp_override(material=material):
        bpy.ops.lumenray.load_cloth(filepath=str(file))
    made = describe(material.lumenray.cloth)
    # The first pick is the picture's lowest row.
    assert made["weave"]["rows"] == ["..X", ".X.", "X.."]
    assert material.lumenray.cloth.weave == "OWN"


def test_a_cloth_is_computed_once_and_hangs_as_it_is_turned(material, engine):
    settings = material.lumenray
    settings.cloth.turn = 0.5
    report = ConversionReport()
    surface, glow = convert_override(settings, report, "Curtain")
    assert isinstance(surface, Measured)
    assert glow is None
    assert surface.rotation == pytest.approx(0.5)
    assert surface.passes_straight
    assert surface.has_grain
    # Sides that are alike are one table for the engine.
    assert surface.back_reflection is surface.front_reflection
    assert surface.back_transmission is surface.front_transmission
    convert_override(settings, ConversionReport(), "Curtain")
    assert len(engine) == 1
    words = [row.text() for row, _ in report.rows]
    assert any("hairs" in text for text in words)
    assert any("along V" in text for text in words)
    settings.cloth.quality = "FINAL"
    settings.cloth.warp_pitch_mm = 0.3
    convert_override(settings, ConversionReport(), "Curtain")
    assert [is_draft for _, is_draft in engine] == [True, False]
    assert engine[1][0]["weave"]["warp_pitch_mm"] == 0.3


def test_panels_state_the_data_sheet_and_draw_the_cloth(material, engine):
    tables.cloth_tables.obtain(material.lumenray.cloth)
    seen = draw("LUMENRAY_PT_cloth_sheet", context(material=material))
    assert "30.0 % ± 0.1 %" in seen
    assert "10.0 %" in seen
    assert {"41°", "43°"} <= set(seen)
    assert readout.reflected(material.lumenray.cloth) == pytest.approx((0.3,) * 3)
    assert readout.passed(material.lumenray.cloth) == pytest.approx((0.2,) * 3)
    seen = draw("LUMENRAY_PT_cloth", context(material=material))
    assert {"turn", "quality", "lumenray.load_cloth", "lumenray.save_cloth"} <= set(seen)
    finish_pictures(preview.pictures)
    for panel in ("weave", "warp", "weft"):
        assert draw(f"LUMENRAY_PT_cloth_{panel}", context(material=material))
    assert draw("LUMENRAY_PT_cloth_pile", context(material=material)) is None
    adopt(material.lumenray.cloth, CONTENT)
    assert "lean" in draw("LUMENRAY_PT_cloth_pile", context(material=material))


def test_while_a_cloth_is_computed_the_panel_says_what_it_takes(material, monkeypatch):
    gate = Future()

    def compute(text, is_draft, job):
        job.tell(0.25, 12.0)
        return gate.result()

    monkeypatch.setattr(tables, "compute", compute)
    tables.cloth_tables.forget()
    report = ConversionReport()
    try:
        surface, _ = convert_override(material.lumenray, report, "Curtain", is_patient=False)
        while tables.cloth_tables.state_of(material.lumenray.cloth).left is None:
            pass
        seen = draw("LUMENRAY_PT_cloth", context(material=material))
        sheet = draw("LUMENRAY_PT_cloth_sheet", context(material=material))
    finally:
        # Whatever comes of it, nobody else waits for its thread.
        gate.set_result(None)
        tables.cloth_tables.forget()
    assert isinstance(surface, Diffuse)
    assert any("being computed" in row.text() for row, _ in report.rows)
    assert "25 %, 12 s left" in seen
    assert "612,000" in seen
    assert "Not computed yet" in sheet


def test_what_is_wrong_with_a_cloth_is_told(material, monkeypatch):
    def refuse(text, is_draft, job):
        raise SceneError("a repeat has 500 ends of pile")

    monkeypatch.setattr(tables, "compute", refuse)
    tables.cloth_tables.forget()
    report = ConversionReport()
    surface, _ = convert_override(material.lumenray, report, "Curtain")
    assert isinstance(surface, Diffuse)
    assert any("ends of pile" in row.text() for row, _ in report.rows)
    seen = draw("LUMENRAY_PT_cloth", context(material=material))
    assert any("ends of pile" in text for text in seen)
    tables.cloth_tables.forget()


def test_files_and_presets_hold_the_composition(material, tmp_path):
    settings = material.lumenray.cloth
    adopt(settings, CONTENT)
    with bpy.context.temp_override(material=material):
        bpy.ops.lumenray.save_cloth(filepath=str(tmp_path / "mine"))
        assert json.loads((tmp_path / "mine.json").read_text(encoding="utf-8")) == CONTENT
        bpy.ops.lumenray.set_cloth_preset(preset="voile")
        assert settings.name == "Voile, white"
        bpy.ops.lumenray.load_cloth(filepath=str(tmp_path / "mine.json"))
        assert describe(settings) == CONTENT
        (tmp_path / "broken.json").write_text('{"lumenray_cloth": 1}')
        with pytest.raises(RuntimeError, match="name"):
            bpy.ops.lumenray.load_cloth(filepath=str(tmp_path / "broken.json"))
        assert settings.name == "Test"
    assert "lumenray.set_cloth_preset" in draw("LUMENRAY_MT_cloth_presets", context())
