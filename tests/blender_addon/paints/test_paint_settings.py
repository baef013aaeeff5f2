"""Paints in Blender: descriptions go through settings unchanged, edits reach the engine's scene, errors are told."""

import json
from concurrent.futures import Future
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from panels import context, draw, finish_pictures, interface

from lumenray.blender_addon.compositions import presets as own_presets
from lumenray.blender_addon.compositions.description import digest_of, to_text
from lumenray.blender_addon.file_assets.pictures import Pictures
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.paints import parts, preview, readout, tables
from lumenray.blender_addon.paints.description import adopt, adopt_part, describe
from lumenray.blender_addon.paints.parts import names_of
from lumenray.blender_addon.sync.materials.overrides import convert_override
from lumenray.engine.errors import FileFormatError
from lumenray.engine.paint.reader import parse_paint
from lumenray.engine.scene.material import Diffuse, Measured
from lumenray.engine.session import Session
from lumenray.libraries import paints

# Everything that settings edit, and much that they do not.
CONTENT = {
    "lumenray_paint": 1,
    "name": "Test",
    "source": "made up",
    "surface": {"orange_peel_slope_deg": 0.5},
    "layers": [
        {"name": "Clear", "thickness_um": 40, "binder": {"index": {"cauchy_um": [1.49, 0.005]}}},
        {
            "name": "Base",
            "thickness_um": 12.5,
            "binder": {"index": 1.5, "absorption_per_mm": {"wavelengths_nm": [400, 700], "values": [3, 0.1]}},
            "flakes": [
                {
                    "name": "Effect",
                    "stack": {
                        "core": {"index": "silica", "thickness_nm": 350, "thickness_spread": 0.05},
                        "coatings": [{"index": "rutile", "thickness_nm": 80}, {"index": 1.6, "thickness_nm": 20}],
                    },
                    "amount": {"mass_fraction": 0.07},
                    "tilt_deg": 4.1,
                    "tilt_measure": "mean",
                    "diameter": {"mass_percentiles_um": [8, 18, 35]},
                }
            ],
            "pigments": [
                {"medium": {"extinction_per_um": {"wavelengths_nm": [400, 700], "values": [0.2, 0.1]},
                            "albedo": 0.3, "asymmetry": 0.2}},
                {"grains": {"index": "rutile", "diameter": {"median_um": 0.25}}, "amount": {"volume_fraction": 0.01}},
            ],
        },
    ],
    "substrate": {"reflectance": 0.35},
}  # fmt: skip


def without_empty(content):
    """A description without lists that hold nothing."""
    layers = [{k: v for k, v in each.items() if v != []} for each in content["layers"]]
    return content | {"layers": layers}


@pytest.fixture(scope="module", autouse=True)
def _interface():
    with interface():
        yield


@pytest.fixture
def material():
    material = bpy.data.materials.new("Car")
    settings = material.lumenray
    settings.use_override, settings.model = True, "PAINT"
    yield material
    bpy.data.materials.remove(material)


def compute_here(text, job):
    """Compute a paint in this process."""
    return Session().compute_paint(text, lambda progress: job.tell(progress.done))


def test_constituents_of_the_user_are_added_in_full(material, tmp_path, monkeypatch):
    own = {
        "lumenray_constituents": 1,
        "indices": {"glass": {"index": 1.52}},
        "flakes": {"sheet": {"stack": {"core": {"index": "glass", "thickness_nm": 300}}}},
    }
    file = tmp_path / "mine.json"
    file.write_text(json.dumps(own))
    monkeypatch.setattr(parts.preferences, "constituents", lambda: file)
    assert "sheet" in names_of("flakes") and "sheet" not in names_of("pigments")
    adopt(material.lumenray.paint, CONTENT)
    part = material.lumenray.paint.layers[0].flakes.add()
    adopt_part(part, "flakes", parts.new_part("flakes", "sheet"))
    assert part.core_nm == 300.0
    # Without the file the paint is what it was.
    monkeypatch.setattr(parts.preferences, "constituents", lambda: None)
    paint = parse_paint(describe(material.lumenray.paint))
    assert paint.layers[0].flakes[0].optics.core.index.at([550.0])[0] == pytest.approx(1.52)
    file.write_text("{")
    monkeypatch.setattr(parts.preferences, "constituents", lambda: file)
    with pytest.raises(FileFormatError, match=r"mine\.json"):
        parts.new_part("flakes", "sheet")


@pytest.fixture(scope="module")
def painted():
    """A paint whose flakes are so uneven that it is soon computed."""
    flakes = {
        "mirror": {"index": "aluminium", "thickness_nm": 100},
        "amount": {"area_per_volume_per_um": 0.1},
        "tilt_deg": 20,
        "diameter": {"median_um": 12},
    }
    layer = {"thickness_um": 10, "binder": {"index": 1.5}, "flakes": [flakes]}
    return compute_here(
        to_text(CONTENT | {"layers": [layer], "surface": {}}), SimpleNamespace(tell=float)
    )


@pytest.fixture
def engine(monkeypatch, painted):
    """All paints are one; gives what was asked."""
    asked = []

    def compute(text, job):
        asked.append(text)
        return painted

    monkeypatch.setattr(tables, "compute", compute)
    tables.paint_tables.forget()
    return asked


def test_a_new_paint_begins_with_a_preset(material):
    settings = material.lumenray.paint
    assert settings.name and len(settings.layers) > 0
    parse_paint(describe(settings))


@pytest.mark.parametrize("name", ["test", *paints.presets()])
def test_descriptions_go_through_settings_unchanged(material, name):
    path = paints.presets().get(name)
    content = CONTENT if path is None else json.loads(path.read_text(encoding="utf-8"))
    settings = material.lumenray.paint
    adopt(settings, content)
    assert without_empty(describe(settings)) == content


def test_edits_are_in_the_description_and_leave_the_rest(material):
    settings = material.lumenray.paint
    adopt(settings, CONTENT)
    base = settings.layers[1]
    flakes = base.flakes[0]
    settings.substrate, base.thickness_um, base.binder_index, base.dye = 0.25, 20.0, 1.55, 2.0
    flakes.amount_kind, flakes.amount, flakes.tilt = "volume_fraction", 0.02, np.radians(6.0)
    flakes.median_um, flakes.core_nm, flakes.coating_nm = 14.0, 300.0, 90.0
    base.pigments[0].strength = 3.0
    made = describe(settings)
    parse_paint(made)
    layer = made["layers"][1]
    assert made["substrate"] == {"reflectance": 0.25}
    assert layer["thickness_um"] == 20.0
    assert layer["binder"]["index"] == 1.55
    assert layer["binder"]["absorption_per_mm"]["values"] == [6.0, 0.2]
    effect = layer["flakes"][0]
    assert effect["amount"] == {"volume_fraction": 0.02}
    assert (effect["tilt_deg"], effect["tilt_measure"]) == (6.0, "mean")
    assert effect["diameter"]["median_um"] == 14.0
    # ln(35 / 8) spans 2 x 1.2816 standard deviations.
    assert effect["diameter"]["log_spread"] == pytest.approx(np.log(35 / 8) / 2.563103)
    assert effect["stack"]["core"] == {
        "index": "silica",
        "thickness_nm": 300.0,
        "thickness_spread": 0.05,
    }
    assert [each["thickness_nm"] for each in effect["stack"]["coatings"]] == [90.0, 20]
    assert layer["pigments"][0]["medium"]["extinction_per_um"]["values"] == [0.6, 0.3]
    # All else is what it was.
    assert made["layers"][0] | {"flakes": [], "pigments": []} == CONTENT["layers"][0] | {
        "flakes": [], "pigments": []
    }  # fmt: skip
    flakes.median_um = 0.0
    assert "diameter" not in describe(settings)["layers"][1]["flakes"][0]


def test_a_paint_is_computed_once_and_becomes_a_surface_that_sparkles(material, engine):
    settings = material.lumenray
    report = ConversionReport()
    surface, glow = convert_override(settings, report, "Car")
    assert isinstance(surface, Measured) and glow is None
    assert surface.front_reflection is surface.back_reflection
    assert surface.sparkles and surface.has_sparkle
    again, _ = convert_override(settings, ConversionReport(), "Car")
    assert len(engine) == 1
    assert again.front_reflection is surface.front_reflection
    settings.paint.use_sparkle = False
    plain, _ = convert_override(settings, ConversionReport(), "Car")
    assert plain.sparkles == () and len(engine) == 1
    # What is left out is told.
    assert any("flakes have no size" in row.text() for row, _ in report.rows)
    seen = draw("LUMENRAY_PT_paint_colours", context(material=material))
    painted = tables.paint_tables.obtain(settings.paint)
    assert [f"{value:.1f}" for value in painted.lab[0]] == seen[seen.index("15°", 10) + 1 :][:3]
    assert readout.swatch(settings.paint, 0) != (0.0, 0.0, 0.0)
    # Another number is another paint.
    settings.paint.substrate = 0.5
    convert_override(settings, ConversionReport(), "Car")
    assert len(engine) == 2


def test_while_a_paint_is_computed_blender_goes_on_with_grey(material, monkeypatch):
    gate = Future()
    monkeypatch.setattr(tables, "compute", lambda text, job: gate.result())
    tables.paint_tables.forget()
    report = ConversionReport()
    try:
        surface, _ = convert_override(material.lumenray, report, "Car", is_patient=False)
        seen = draw("LUMENRAY_PT_paint_colours", context(material=material))
    finally:
        # Whatever comes of it, nobody else waits for its thread.
        gate.set_result(None)
        tables.paint_tables.forget()
    assert isinstance(surface, Diffuse)
    assert any("being computed" in row.text() for row, _ in report.rows)
    assert "Not computed yet" in seen


def test_what_is_wrong_with_a_paint_is_told(material, monkeypatch):
    monkeypatch.setattr(tables, "compute", compute_here)
    settings = material.lumenray
    adopt(settings.paint, CONTENT)
    settings.paint.layers[1].flakes[0].amount = 0.9
    settings.paint.layers[1].flakes[0].tilt = np.radians(0.5)
    report = ConversionReport()
    surface, _ = convert_override(settings, report, "Car")
    assert isinstance(surface, Diffuse)
    assert any("too even" in row.text() for row, _ in report.rows)
    seen = draw("LUMENRAY_PT_paint", context(material=material))
    assert any("too even" in text for text in seen)


def test_layers_and_parts_are_added_moved_and_removed(material):
    settings = material.lumenray.paint
    adopt(settings, CONTENT)
    assert settings.layer_index == 1
    settings.layer_index = 0
    with bpy.context.temp_override(material=material):
        bpy.ops.lumenray.add_paint_layer()
        assert [layer.name for layer in settings.layers] == ["Clear coat", "Clear", "Base"]
        bpy.ops.lumenray.move_paint_layer(direction="DOWN")
        assert [layer.name for layer in settings.layers] == ["Clear", "Clear coat", "Base"]
        for kind in ("flakes", "pigments"):
            for name in names_of(kind):
                bpy.ops.lumenray.add_paint_part(kind=kind, part=name)
        made = describe(settings)
        parse_paint(made)
        assert len(made["layers"][1]["flakes"]) == len(names_of("flakes"))
        bpy.ops.lumenray.remove_paint_part(kind="flakes", index=0)
        assert len(settings.layers[1].flakes) == len(names_of("flakes")) - 1
        seen = draw("LUMENRAY_PT_paint_layers", context(material=material))
        assert {
            "LUMENRAY_UL_paint_layers",
            "amount",
            "tilt",
            "core_nm",
            "strength",
            "substrate",
        } <= set(seen)
        bpy.ops.lumenray.remove_paint_layer()
        assert [layer.name for layer in settings.layers] == ["Clear", "Base"]


def test_files_and_presets_hold_the_composition(material, tmp_path, monkeypatch):
    settings = material.lumenray.paint
    adopt(settings, CONTENT)
    monkeypatch.setattr(own_presets, "folder_of", lambda kind: tmp_path / kind)
    with bpy.context.temp_override(material=material):
        bpy.ops.lumenray.save_paint(filepath=str(tmp_path / "mine"))
        assert without_empty(json.loads((tmp_path / "mine.json").read_text())) == CONTENT
        bpy.ops.lumenray.add_paint_preset(name="My paint")
        bpy.ops.lumenray.set_paint_preset(preset=next(iter(paints.presets())))
        assert settings.name != "Test"
        bpy.ops.lumenray.set_paint_preset(preset="my_paint")
        assert digest_of(without_empty(describe(settings))) == digest_of(CONTENT)
        (tmp_path / "broken.json").write_text('{"lumenray_paint": 1, "layers": []}')
        with pytest.raises(RuntimeError, match="name"):
            bpy.ops.lumenray.load_paint(filepath=str(tmp_path / "broken.json"))
        assert settings.name == "Test"
    assert "lumenray.set_paint_preset" in draw("LUMENRAY_MT_paint_presets", context())


def test_the_sphere_that_is_asked_for_last_is_drawn_whatever_a_slider_left_behind(material):
    settings, drawn = material.lumenray.paint, []

    def draw(reading, side, is_dark):
        drawn.append(reading.digest)
        return np.zeros((side, side, 4), np.float32)

    spheres = Pictures("sphere", draw, is_latest_enough=True)
    try:
        asked = []
        for thickness in (20.0, 21.0, 22.0, 23.0, 24.0, 25.0):
            settings.layers[0].thickness_um = thickness
            reading = preview.described(settings)
            asked.append(reading.digest)
            spheres.icon(reading, 32, True)
        finish_pictures(spheres)
    finally:
        spheres.close()
    assert len(set(asked)) == 6
    # Each is drawn once at most, in the order in which they were asked for, and the last one is there.
    assert drawn == [each for each in asked if each in drawn]
    assert drawn[-1] == asked[-1]


def test_the_cuts_become_an_image(material, engine):
    with bpy.context.temp_override(material=material):
        bpy.ops.lumenray.plot_paint()
    image = bpy.data.images[f"{material.lumenray.paint.name} cuts"]
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    assert pixels.reshape(-1, 4)[:, :3].std() > 0.05
