"""Pigment layers in Blender: descriptions go through settings unchanged, edits reach the engine's scene, errors are told."""

import json
import threading
from concurrent.futures import Future

import bpy
import numpy as np
import pytest
from panels import context, draw, interface

from lumenray.blender_addon.compositions import presets as own_presets
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.inks import readout, tables
from lumenray.blender_addon.inks.description import adopt, describe
from lumenray.blender_addon.sync.materials.overrides import convert_override
from lumenray.engine.errors import Cancelled, SceneError
from lumenray.engine.ink.particles import chain_of
from lumenray.engine.ink.plan import make_plan
from lumenray.engine.ink.reader import parse_ink
from lumenray.engine.ink.realisation import face_of, pack_ink
from lumenray.engine.ink.surface import PrintedSurface
from lumenray.engine.scene.material import Diffuse, Measured
from lumenray.engine.scene.scattering import ScatterTable
from lumenray.libraries import inks

# Everything that settings edit, and much that they do not.
CONTENT = {
    "lumenray_ink": 1,
    "name": "Test",
    "source": "made up",
    "thickness_um": 0.8,
    "thickness_spread": 0.2,
    "binder": {"index": 1.5},
    "pigments": [
        {"name": "red", "index": {"wavelengths_nm": [400, 700], "n": [1.4, 1.4], "k": [0.3, 0.01]},
         "volume_fraction": 0.2, "median_um": 0.1, "shape": "rice", "alignment": 5},
        {"index": 1.6, "volume_fraction": 0.05},
    ],
    "relief": {"height_um": 0.05, "length_um": 0.6},
    "substrate": {"reflectance": 0.7, "contact_index": 1.5},
    "solution": {"cell_um": 1.5, "seed": 3},
}  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def _interface():
    with interface():
        yield


@pytest.fixture
def material():
    material = bpy.data.materials.new("Print")
    settings = material.lumenray
    settings.use_override, settings.model = True, "INK"
    yield material
    bpy.data.materials.remove(material)


def printed_surface(shade):
    """A print that is even over wavelengths and angles."""
    zero, axis = np.zeros(1), np.array([0.0, np.pi])
    values = np.full((1, 1, 2, 2, 1), shade / np.pi, np.float32)
    table = ScatterTable(zero, zero, axis, axis, np.array([550.0]), values)
    bands = np.array([450.0, 550.0, 650.0])
    return PrintedSurface(
        Measured(table, table), bands, np.full(3, shade), np.full(3, 0.01), np.array([76.1, 0.0, 0.0]), 0.3, 0.002, 4, 3,
        "f" * 64, ("the wave equation is scalar",),
    )  # fmt: skip


@pytest.fixture
def engine(monkeypatch):
    """All prints are one; gives what was asked."""
    asked = []

    def compute(text, is_draft, job):
        asked.append((json.loads(text), is_draft))
        return printed_surface(0.5)

    monkeypatch.setattr(tables, "compute", compute)
    tables.ink_tables.forget()
    return asked


def test_a_new_print_begins_with_a_preset(material):
    settings = material.lumenray.ink
    assert settings.name
    assert len(settings.pigments) == 1
    parse_ink(describe(settings))


@pytest.mark.parametrize("name", ["test", *inks.presets()])
def test_descriptions_go_through_settings_unchanged(material, name):
    path = inks.presets().get(name)
    content = CONTENT if path is None else json.loads(path.read_text(encoding="utf-8"))
    adopt(material.lumenray.ink, content)
    assert describe(material.lumenray.ink) == content


def test_edits_are_in_the_description_and_leave_the_rest(material):
    settings = material.lumenray.ink
    adopt(settings, CONTENT)
    settings.thickness_um, settings.binder_index, settings.substrate = 1.2, 1.45, 0.9
    pigment = settings.pigments[0]
    pigment.volume_fraction, pigment.median_um, pigment.shape = 0.3, 0.15, "sphere"
    made = describe(settings)
    parse_ink(made)
    first, second = CONTENT["pigments"]
    assert made == CONTENT | {
        "thickness_um": 1.2,
        "binder": {"index": 1.45},
        "substrate": {"reflectance": 0.9, "contact_index": 1.5},
        "pigments": [
            first | {"volume_fraction": 0.3, "median_um": 0.15, "shape": "sphere"},
            second,
        ],
    }


def test_a_print_is_computed_once_for_each_composition_and_quality(material, engine):
    settings = material.lumenray
    report = ConversionReport()
    surface, glow = convert_override(settings, report, "Print")
    assert isinstance(surface, Measured)
    assert glow is None
    convert_override(settings, ConversionReport(), "Print")
    assert len(engine) == 1
    assert any("scalar" in row.text() for row, _ in report.rows)
    seen = draw("LUMENRAY_PT_ink_colour", context(material=material))
    assert "± 0.3" in seen
    assert "4, seed 3" in seen
    assert readout.swatch(settings.ink) == pytest.approx((0.5, 0.5, 0.5), abs=0.01)
    settings.ink.quality = "FINAL"
    settings.ink.substrate = 0.5
    convert_override(settings, ConversionReport(), "Print")
    assert [is_draft for _, is_draft in engine] == [True, False]
    assert engine[1][0]["substrate"] == {"reflectance": 0.5}


def test_while_a_print_is_computed_the_panel_says_what_it_takes(material, monkeypatch):
    gate = Future()
    monkeypatch.setattr(tables, "compute", lambda text, is_draft, job: gate.result())
    tables.ink_tables.forget()
    report = ConversionReport()
    try:
        surface, _ = convert_override(material.lumenray, report, "Print", is_patient=False)
        seen = draw("LUMENRAY_PT_ink", context(material=material))
        colour = draw("LUMENRAY_PT_ink_colour", context(material=material))
    finally:
        # Whatever comes of it, nobody else waits for its thread.
        gate.set_result(None)
        tables.ink_tables.forget()
    assert isinstance(surface, Diffuse)
    assert any("being computed" in row.text() for row, _ in report.rows)
    assert any("MB per process" in text for text in seen)
    assert {"thickness_um", "volume_fraction", "shape", "quality"} <= set(seen)
    assert "Not computed yet" in colour


def test_a_computation_can_be_cancelled_and_begun_again(material, monkeypatch):
    begun, is_under_way = [], threading.Event()

    def compute(text, is_draft, job):
        begun.append(text)
        if len(begun) == 1:
            is_under_way.set()
            assert job.stop.wait(60.0)
            raise Cancelled("stopped")
        return printed_surface(0.5)

    monkeypatch.setattr(tables, "compute", compute)
    tables.ink_tables.forget()
    settings = material.lumenray
    convert_override(settings, ConversionReport(), "Print", is_patient=False)
    # What has not begun is not computed at all.
    assert is_under_way.wait(60.0)
    with bpy.context.temp_override(material=material):
        assert "lumenray.cancel_ink" in draw("LUMENRAY_PT_ink", context(material=material))
        bpy.ops.lumenray.cancel_ink()
        # A render that waits for the layer is let go.
        surface, _ = convert_override(settings, ConversionReport(), "Print")
        assert isinstance(surface, Diffuse)
        assert "lumenray.compute_ink" in draw("LUMENRAY_PT_ink", context(material=material))
        bpy.ops.lumenray.compute_ink()
        surface, _ = convert_override(settings, ConversionReport(), "Print")
    assert isinstance(surface, Measured)
    assert len(begun) == 2
    tables.ink_tables.forget()


def test_what_is_wrong_with_a_print_is_told(material, monkeypatch):
    def refuse(text, is_draft, job):
        raise SceneError("particles of 70 % of the volume do not fit")

    monkeypatch.setattr(tables, "compute", refuse)
    tables.ink_tables.forget()
    report = ConversionReport()
    surface, _ = convert_override(material.lumenray, report, "Print")
    assert isinstance(surface, Diffuse)
    assert any("do not fit" in row.text() for row, _ in report.rows)
    assert any("do not fit" in text for text in draw("LUMENRAY_PT_ink", context(material=material)))
    tables.ink_tables.forget()


def test_files_and_presets_hold_the_composition(material, tmp_path, monkeypatch):
    settings = material.lumenray.ink
    monkeypatch.setattr(own_presets, "folder_of", lambda kind: tmp_path / kind)
    adopt(settings, CONTENT)
    with bpy.context.temp_override(material=material):
        bpy.ops.lumenray.save_ink(filepath=str(tmp_path / "mine"))
        assert json.loads((tmp_path / "mine.json").read_text(encoding="utf-8")) == CONTENT
        bpy.ops.lumenray.add_ink_preset(name="My print")
        bpy.ops.lumenray.set_ink_preset(preset="carbon_black")
        assert settings.name == "Carbon black"
        bpy.ops.lumenray.set_ink_preset(preset="my_print")
        assert describe(settings) == CONTENT
        bpy.ops.lumenray.set_ink_preset(preset="carbon_black")
        bpy.ops.lumenray.load_ink(filepath=str(tmp_path / "mine.json"))
        assert describe(settings) == CONTENT
        (tmp_path / "broken.json").write_text('{"lumenray_ink": 1}')
        with pytest.raises(RuntimeError, match="name"):
            bpy.ops.lumenray.load_ink(filepath=str(tmp_path / "broken.json"))
        assert settings.name == "Test"
    assert "lumenray.set_ink_preset" in draw("LUMENRAY_MT_ink_presets", context())


@pytest.fixture
def shown():
    """Gives what is in the scene that was not there, and takes it away."""
    before = set(bpy.data.objects)
    yield lambda: [each for each in bpy.data.objects if each not in before]
    for item in set(bpy.data.objects) - before:
        bpy.data.objects.remove(item)


def test_particles_are_shown_where_waves_meet_them(material, shown):
    settings = material.lumenray.ink
    content = CONTENT | {"solution": {"cell_um": 0.7, "seed": 3}}
    adopt(settings, content)
    ink = parse_ink(content)
    plan = make_plan(ink, draft=True)
    packing = pack_ink(ink, plan.width, plan.seed, 3)
    bpy.context.scene.cursor.location = 1.0, 2.0, 3.0
    with bpy.context.temp_override(material=material):
        bpy.ops.lumenray.show_ink_particles(realisation=3, magnification=2e4)
    box = next(each for each in shown() if "magnification" in each)
    (points,) = box.children
    assert len(shown()) == 2
    assert "1 µm = 2 cm" in box.name
    depsgraph = bpy.context.evaluated_depsgraph_get()
    frames = np.array(
        [
            each.matrix_world.copy()
            for each in depsgraph.object_instances
            if each.is_instance and each.parent.original == points
        ]
    )
    # Spheres of every chain, as nodes have placed them, over those that are packed.
    chain = chain_of("rice")
    spots = np.stack([0.0 * chain.places, 0.0 * chain.places, chain.places], axis=1)
    seen = np.einsum("nij,mj->nmi", frames[:, :3, :3], spots) + frames[:, None, :3, 3]
    flat = (np.array([1.0, 1.0, -1.0]) * seen.reshape(-1, 3) - [1.0, 2.0, -3.0]) / 0.02
    flat += np.array([0.5, 0.5, 0.0]) * plan.width + np.array([0.0, 0.0, packing.thickness])
    flat[:, :2] %= plan.width
    centres, radii, _ = packing.spheres()
    apart = flat[:, None] - centres[None]
    apart[..., :2] -= plan.width * np.round(apart[..., :2] / plan.width)
    nearest = np.linalg.norm(apart, axis=-1)
    assert len(flat) == len(centres)
    assert nearest.min(axis=0).max() < 1e-5
    lengths = np.linalg.norm(frames[:, :3, 2], axis=1)
    assert np.sort(np.outer(lengths, chain.radii).ravel()) == pytest.approx(
        np.sort(0.02 * radii), rel=1e-5
    )
    hills = face_of(ink, plan, 3)
    top = 0.02 * (packing.thickness + hills.max())
    assert tuple(box.dimensions) == pytest.approx(
        (0.02 * plan.width, 0.02 * plan.width, top), rel=0.02
    )


def test_too_many_particles_are_not_shown(material, shown):
    pigment = {"index": 1.4, "volume_fraction": 0.5, "median_um": 0.03}
    adopt(material.lumenray.ink, CONTENT | {"pigments": [pigment], "solution": {"cell_um": 3.0}})
    with (
        bpy.context.temp_override(material=material),
        pytest.raises(RuntimeError, match="too many to show"),
    ):
        bpy.ops.lumenray.show_ink_particles()
    assert not shown()
