"""Measured materials on their way into the engine: sides, what is told of their files, and when they are ready."""

import threading
import time
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
import pytest
from blender_scattering import add_paint, matt
from conversion import converted_material, error_messages
from panels import context, draw, interface

from lumenray.blender_addon.file_assets.kind import NotReadyError
from lumenray.blender_addon.file_assets.places import Library
from lumenray.blender_addon.foundation.report import ConversionReport, Severity
from lumenray.blender_addon.scattering import look_nodes
from lumenray.blender_addon.scattering.files import ScatteringFiles, scattering_files
from lumenray.blender_addon.sync.materials.overrides import convert_override
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.scattering.readers import reader
from lumenray.engine.scene.material import Diffuse, Measured
from lumenray.engine.scene.scene import Scene
from lumenray.engine.scene.spectrum import Constant
from lumenray.libraries import materials as library

pytestmark = pytest.mark.usefixtures("extension")


def test_what_a_file_tells_of_one_side_both_do(write_scattering):
    surface, rows = converted_material(add_paint(write_scattering()))
    assert isinstance(surface, Measured)
    assert surface.front_reflection is surface.back_reflection
    assert surface.front_transmission is surface.back_transmission is None
    np.testing.assert_allclose(surface.front_reflection.values, 0.5 / np.pi, rtol=1e-3)
    # The engine remembers what follows from arrays that cannot change.
    assert not surface.front_reflection.values.flags.writeable
    assert rows == []


def test_the_other_side_is_black_on_request(write_scattering):
    paint = add_paint(write_scattering())
    paint.lumenray.measured.back = "NONE"
    surface, _ = converted_material(paint)
    assert surface.front_reflection is not None
    assert surface.back_reflection is None
    paint.lumenray.measured.is_turned = True
    surface, _ = converted_material(paint)
    assert surface.front_reflection is None
    assert surface.back_reflection is not None


def test_a_sample_that_is_turned_over_shows_its_back(write_scattering):
    sides = {
        "front_reflection": matt(0.5),
        "back_reflection": matt(0.2),
        "front_transmission": matt(0.1),
    }
    paint = add_paint(write_scattering(**sides))
    paint.lumenray.measured.rotation = 0.7
    upright, _ = converted_material(paint)
    assert upright.rotation == pytest.approx(0.7)
    paint.lumenray.measured.is_turned = True
    turned, _ = converted_material(paint)
    assert turned.front_reflection is upright.back_reflection
    assert turned.back_reflection is upright.front_reflection
    assert turned.front_transmission is turned.back_transmission is upright.front_transmission


def test_materials_with_the_same_content_share_its_arrays(write_scattering, tmp_path):
    first = add_paint(write_scattering())
    copy = tmp_path / "copy.lumbsdf"
    copy.write_bytes(Path(write_scattering()).read_bytes())
    second = add_paint(str(copy))
    assert (
        converted_material(first)[0].front_reflection
        is converted_material(second)[0].front_reflection
    )


def test_a_file_that_changed_on_disk_is_read_anew(write_scattering):
    paint = add_paint(write_scattering())
    converted_material(paint)
    write_scattering(front_reflection=matt([0.25, 0.5], (450.0, 650.0)))
    assert len(converted_material(paint)[0].front_reflection.wavelengths) == 2


def test_what_cannot_be_read_is_grey_and_says_why(write_scattering, tmp_path):
    bad = tmp_path / "bad.bsdf"
    bad.write_bytes(b"nothing of the kind")
    damaged = tmp_path / "damaged.lumbsdf"
    damaged.write_bytes(Path(write_scattering()).read_bytes()[:-400])
    for path, words in (
        (str(bad), "no scattering file of a known format"),
        (str(damaged), "damaged"),
        (str(tmp_path / "gone.bsdf"), "cannot be opened"),
        ("library:nothing of this name", "cannot be opened"),
        ("library:../../secret", "cannot be opened"),
        ("", "no scattering file is chosen"),
    ):
        paint = add_paint(path or "x")
        paint.lumenray.measured.filepath = path
        surface, rows = converted_material(paint)
        assert surface == Diffuse(Constant(0.5))
        (message,) = error_messages(rows)
        assert words in message
        assert "\n" not in message


def test_a_fault_of_ours_is_told_instead_of_raised(write_scattering, monkeypatch):
    def fail(*_):
        raise ZeroDivisionError("of ours")

    monkeypatch.setattr("lumenray.engine.scattering.look.fit_look", fail)
    paint = add_paint(write_scattering())
    assert "ZeroDivisionError" in error_messages(converted_material(paint)[1])[0]
    with interface():
        seen = " ".join(draw("LUMENRAY_PT_measured", context(material=paint)))
    assert "ZeroDivisionError" in seen


def test_more_light_than_comes_is_told(write_scattering):
    sides = {"front_reflection": matt(0.9), "front_transmission": matt(0.3)}
    surface, rows = converted_material(add_paint(write_scattering(**sides)))
    assert isinstance(surface, Measured)
    assert any("120" in row.message for row in rows if row.severity is Severity.WARNING)


def test_a_large_error_of_the_table_is_told(write_scattering):
    _, rows = converted_material(
        add_paint(write_scattering(front_reflection=replace(matt(0.5), error=0.4)))
    )
    assert any("40 % only" in row.message for row in rows if row.severity is Severity.WARNING)


def test_grain_needs_a_uv_map(write_scattering):
    _, rows = converted_material(
        add_paint(write_scattering(front_reflection=matt(0.5, rotations=(0.0, 1.0))))
    )
    assert any("UV map" in row.message for row in rows)


def test_the_library_lies_in_its_own_folder(write_scattering, tmp_path, monkeypatch):
    write_scattering("silk paint.lumbsdf")
    library_here = Library(library.PREFIX, tmp_path, ".lumbsdf")
    monkeypatch.setattr(ScatteringFiles, "library", library_here)
    paint = add_paint(f"{library.PREFIX}silk paint")
    assert isinstance(converted_material(paint)[0], Measured)
    assert scattering_files.name_of(paint.lumenray.measured) == "silk paint"
    assert "library" in scattering_files.state_of(paint.lumenray.measured).notice


def test_the_live_view_does_not_wait(write_scattering, monkeypatch):
    allowed, read, seen = threading.Event(), reader.parse_scattering, []

    def slowly(*arguments):
        seen.append(arguments)
        allowed.wait(30.0)
        return read(*arguments)

    monkeypatch.setattr("lumenray.engine.scattering.readers.reader.parse_scattering", slowly)
    paint = add_paint(write_scattering())
    report = ConversionReport()
    surface, _ = convert_override(paint.lumenray, report, "Paint", is_patient=False)
    assert surface == Diffuse(Constant(0.5))
    assert [row.severity for row, _ in report.rows] == [Severity.INFO]
    with interface():
        assert "Reading the file…" in draw("LUMENRAY_PT_measured", context(material=paint))
        assert draw("LUMENRAY_PT_measured_cuts", context(material=paint)) is None
    allowed.set()
    assert isinstance(converted_material(paint)[0], Measured)
    surface, _ = convert_override(paint.lumenray, report, "Paint", is_patient=False)
    assert isinstance(surface, Measured)
    assert len(seen) == 1


def test_live_sync_brings_the_material_when_it_is_ready(write_scattering, monkeypatch):
    allowed, read = threading.Event(), reader.parse_scattering

    def slowly(*arguments):
        allowed.wait(30.0)
        return read(*arguments)

    monkeypatch.setattr("lumenray.engine.scattering.readers.reader.parse_scattering", slowly)
    paint = add_paint(write_scattering())
    sync, scene = SceneSync(final=False), Scene()
    scene.apply(sync.walk(bpy.context.evaluated_depsgraph_get()).delta)
    (surface,) = [each.surface for each in scene.materials.values()]
    assert surface == Diffuse(Constant(0.5))
    allowed.set()
    scattering_files.obtain(paint.lumenray.measured)
    paint.update_tag()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    sync.tag(depsgraph.updates)
    scene.apply(sync.walk(depsgraph).delta)
    (surface,) = [each.surface for each in scene.materials.values()]
    assert isinstance(surface, Measured)


def test_materials_are_told_of_files_that_became_ready(write_scattering):
    paint = add_paint(write_scattering())
    look_nodes.show_when_ready(paint)
    with pytest.raises(NotReadyError):
        scattering_files.obtain(paint.lumenray.measured, is_patient=False)
    scattering_files.obtain(paint.lumenray.measured)
    told = []
    bpy.context.view_layer.update()
    bpy.app.handlers.depsgraph_update_post.append(
        lambda _, graph: told.extend(update.id.name for update in graph.updates)
    )
    try:
        while scattering_files._shelf.timer() is not None:
            time.sleep(0.01)
        bpy.context.view_layer.update()
    finally:
        bpy.app.handlers.depsgraph_update_post.pop()
    assert "Paint" in told
    assert tuple(paint.diffuse_color) == pytest.approx((0.5, 0.5, 0.5, 1.0), abs=1e-3)


def test_a_whole_scene_takes_a_measured_material(write_scattering):
    paint = add_paint(write_scattering())
    done = convert_scene(bpy.context.evaluated_depsgraph_get())
    (made,) = [
        item
        for item in done.delta.changed
        if getattr(item, "name", "") == paint.name and hasattr(item, "surface")
    ]
    assert isinstance(made.surface, Measured)
