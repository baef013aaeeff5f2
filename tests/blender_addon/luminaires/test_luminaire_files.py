"""Photometric files of lights: embedded or linked, edited, refused, in watts, and what is said of them."""

import os
from pathlib import Path

import bpy
import numpy as np
import pytest
from blender_luminaires import activate, add_luminaire, candelas
from conversion import converted_light
from photometric_files import EVEN, FOUR, FULL_FLUX, SIDEWAYS, write_ies

from lumenray.blender_addon.foundation.report import ConversionReport, Severity
from lumenray.blender_addon.luminaires.files import photometric_files
from lumenray.blender_addon.luminaires.settings import settings_of
from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.errors import LumenrayError
from lumenray.engine.scene.light import Quantity

pytestmark = pytest.mark.usefixtures("extension")


def test_settings_and_embedded_files_survive_saving(write_photometry, tmp_path):
    lamp, empty = (
        add_luminaire("AREA", write_photometry()),
        add_luminaire("EMPTY", write_photometry(), "Empty"),
    )
    settings_of(lamp).rotation = 1.5
    settings_of(empty).emission = "POINT"
    settings_of(empty).color = (1.0, 0.5, 0.25)
    digest = settings_of(lamp).digest
    blend = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    (tmp_path / "even.ies").unlink()
    bpy.ops.wm.open_mainfile(filepath=blend)
    lamp, empty = bpy.data.objects["Lamp"], bpy.data.objects["Empty"]
    assert settings_of(lamp).rotation == 1.5
    assert settings_of(empty).emission == "POINT"
    assert tuple(settings_of(empty).color) == (1.0, 0.5, 0.25)
    assert settings_of(lamp).text == settings_of(empty).text
    assert settings_of(lamp).digest == settings_of(lamp).text.lumenray.digest == digest
    light, rows = converted_light(lamp)
    assert light.output.value == pytest.approx(FULL_FLUX)
    assert rows == []


def test_one_content_is_one_text(write_photometry):
    first, second = (
        add_luminaire(path=write_photometry()),
        add_luminaire(path=write_photometry(name="other name.ies")),
    )
    third = add_luminaire(path=write_photometry(FOUR))
    assert settings_of(first).text == settings_of(second).text != settings_of(third).text
    assert len(bpy.data.texts) == 2
    copied = first.copy()
    copied.data = first.data.copy()
    assert settings_of(copied).text == settings_of(first).text
    assert photometric_files.obtain(settings_of(first)) is photometric_files.obtain(
        settings_of(copied)
    )
    one, other = converted_light(first)[0], converted_light(second)[0]
    assert one.distribution.intensity is other.distribution.intensity


def test_a_text_that_was_edited_is_not_taken_for_the_file(write_photometry):
    lamp = add_luminaire(path=write_photometry())
    text = settings_of(lamp).text
    text.from_string(EVEN.replace("100 100", "50 50"))
    light, rows = converted_light(lamp)
    assert light.output.value == pytest.approx(0.5 * FULL_FLUX)
    assert "edited" in rows[0].message
    other = add_luminaire(path=write_photometry())
    assert settings_of(other).text != text


@pytest.mark.parametrize(
    "content",
    [
        EVEN.replace("\n", "\r\n").encode() + b"\x1a",
        EVEN.replace("\n", "\r").encode(),
        b"\xef\xbb\xbf" + EVEN.replace("[TEST] own", "[TEST] Prüfung ²").encode(),
        EVEN.replace("[TEST] own", "[TEST] Prüfung ²").encode("latin-1"),
        EVEN.replace("[TEST] own", "[TEST] „Prüfung“ – 2 €").encode("cp1252"),
        EVEN.encode("utf-16"),
    ],
)
def test_an_embedded_file_comes_back_byte_by_byte(content, write_photometry, tmp_path):
    lamp = add_luminaire(path=write_photometry(content))
    blend = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    bpy.ops.wm.open_mainfile(filepath=blend)
    lamp = bpy.data.objects["Lamp"]
    assert photometric_files.content_of(settings_of(lamp).text) == content
    assert not photometric_files.has_changed(
        settings_of(lamp), photometric_files.obtain(settings_of(lamp))
    )
    (tmp_path / "even.ies").unlink()
    written = photometric_files.unpack(settings_of(lamp))
    assert Path(written).read_bytes() == content
    assert converted_light(lamp)[0].output.value == pytest.approx(FULL_FLUX)


def test_what_texts_cannot_hold_is_linked(write_photometry):
    lamp = add_luminaire()
    activate(lamp)
    bpy.ops.lumenray.load_luminaire_file(filepath=write_photometry(EVEN.encode() + b"\0" * 3))
    assert settings_of(lamp).text is None
    assert converted_light(lamp)[0].output.value == pytest.approx(FULL_FLUX)
    with pytest.raises(RuntimeError, match="has NUL characters"):
        bpy.ops.lumenray.pack_luminaire_file()
    with pytest.raises(LumenrayError, match="line of 300007 characters"):
        photometric_files.embed(b"[TEST] " + b"x" * 300000, "long.ies")


def test_another_path_takes_the_embedded_files_place(write_photometry):
    lamp = add_luminaire(path=write_photometry())
    settings_of(lamp).filepath = write_photometry(FOUR, "four.ies")
    assert settings_of(lamp).text is None
    np.testing.assert_allclose(candelas(converted_light(lamp)[0], SIDEWAYS), [100, 200, 300, 400])


def test_a_linked_file_that_changed_is_read_anew_with_a_warning(write_photometry):
    lamp = add_luminaire()
    photometric_files.load(settings_of(lamp), write_photometry(), is_embedded=False)
    assert converted_light(lamp)[1] == []
    write_photometry(EVEN.replace("100 100", "25 25.00"))
    light, rows = converted_light(lamp)
    assert light.output.value == pytest.approx(0.25 * FULL_FLUX)
    assert [row.severity for row in rows] == [Severity.WARNING]
    photometric_files.reload(settings_of(lamp))
    assert converted_light(lamp)[1] == []


def test_a_tilt_file_lies_beside_the_photometric_file(write_photometry):
    write_photometry("1\n2\n0 90\n1 0.5\n", "lamp.tlt")
    path = write_photometry(EVEN.replace("TILT=NONE", "TILT=lamp.tlt"))
    lamp = add_luminaire(path=path)
    lamp.rotation_euler = (np.pi / 2, 0.0, 0.0)
    assert converted_light(lamp)[0].output.value == pytest.approx(0.5 * FULL_FLUX)


@pytest.mark.parametrize("is_embedded", [True, False])
def test_a_refused_file_leaves_the_light_out(write_photometry, is_embedded):
    lamp = add_luminaire()
    photometric_files.load(settings_of(lamp), write_photometry(), is_embedded)
    broken = EVEN.replace("\n100 100\n", "\n100\n")
    if is_embedded:
        settings_of(lamp).text.from_string(broken)
    else:
        write_photometry(broken)
    light, rows = converted_light(lamp)
    assert light is None
    assert [row.severity for row in rows] == [Severity.ERROR]
    assert "even.ies" in rows[0].message
    assert "line" in rows[0].message
    assert rows[0].remedy == "the light is left out"


def test_a_missing_file_and_no_file_leave_the_light_out(write_photometry):
    lamp = add_luminaire()
    settings_of(lamp).use_file = True
    light, rows = converted_light(lamp)
    assert light is None
    assert "no photometric file is chosen" in rows[0].message
    settings_of(lamp).filepath = "//missing.ies"
    light, rows = converted_light(lamp)
    assert light is None
    assert "cannot be opened" in rows[0].message
    settings_of(lamp).filepath = os.devnull
    light, rows = converted_light(lamp)
    assert light is None
    assert "is a device" in rows[0].message


RADIANT = write_ies(
    [[100.0, 100.0]], [0, 180], [0], keywords=("[LAMP] Excimer", "[_INTENSITYUNITS] mW/sr")
)
"""0.1 W/sr in all directions, 0.4 pi W."""


@pytest.mark.parametrize("kind", ["POINT", "EMPTY"])
def test_watts_without_a_spectrum_light_nothing_and_that_is_said(write_photometry, kind):
    lamp = add_luminaire(kind, write_photometry(RADIANT, "uv.ies"))
    light, rows = converted_light(lamp)
    assert light is None
    told = [row for row in rows if row.datablock == "Lamp"]
    assert [row.severity for row in told] == [Severity.WARNING]
    assert told[0].message == "its 1.257 W have no spectrum"
    assert told[0].remedy == "it lights nothing visible"
    # Of a lamp that is not ultraviolet, light is missing.
    photometric_files.load(
        settings_of(lamp), write_photometry(RADIANT.replace("Excimer", "unknown"), "led.ies")
    )
    rows = converted_light(lamp)[1]
    assert Severity.ERROR in [row.severity for row in rows]


def test_a_mere_colour_makes_no_light_of_watts_but_a_spectrum_does(write_photometry, tmp_path):
    lamp = add_luminaire("POINT", write_photometry(RADIANT, "uv.ies"))
    settings_of(lamp).spectrum_source = "LIGHT"
    assert converted_light(lamp)[0] is None
    # 555 nm and, as strong, 222 nm: half of the watts are seen, at 683 lm/W.
    table = tmp_path / "lamp.txt"
    table.write_text("221 0\n222 1\n223 0\n554 0\n555 1\n556 0\n")
    own = lamp.data.lumenray
    own.use_physical, own.spectrum, own.spectrum_file = True, "FILE", str(table)
    light, _ = converted_light(lamp)
    assert light.output.quantity is Quantity.LUMINOUS_FLUX
    assert light.output.value == pytest.approx(0.4 * np.pi * 341.4, rel=2e-3)
    table.write_text("221 0\n222 1\n223 0\n224 0\n")
    light, rows = converted_light(lamp)
    assert light is None
    assert "none of its 1.257 W is visible" in " ".join(row.message for row in rows)


@pytest.mark.parametrize("kind", ["light", "luminaire"])
def test_a_lamp_whose_spectrum_is_zero_is_left_out_with_an_error(write_photometry, tmp_path, kind):
    lamp = add_luminaire("POINT", write_photometry() if kind == "luminaire" else "")
    settings_of(lamp).spectrum_source = "LIGHT"
    table = tmp_path / "lamp.txt"
    table.write_text("380 0\n580 0\n780 0\n")
    own = lamp.data.lumenray
    own.use_physical, own.spectrum, own.spectrum_file = True, "FILE", str(table)
    light, rows = converted_light(lamp)
    assert light is None
    assert rows[-1].severity is Severity.ERROR
    assert "no value above 0" in rows[-1].message
    assert rows[-1].remedy == "the light is left out"


def test_watts_beyond_what_counts_and_lamps_without_visible_light_are_told(tmp_path):
    lamp, table = add_luminaire(), tmp_path / "lamp.txt"
    # Half of the watts at 222 nm, half at 555 nm.
    table.write_text("221 0\n222 1\n223 0\n554 0\n555 1\n556 0\n")
    own = lamp.data.lumenray
    own.use_physical, own.spectrum, own.spectrum_file = True, "FILE", str(table)
    own.quantity, own.value = "RADIANT_FLUX", 10.0
    light, rows = converted_light(lamp)
    assert light.output.value == 10.0
    assert "0.5 of the power of its spectrum" in rows[-1].message
    assert rows[-1].remedy == "the watts are those within"
    own.quantity = "LUMINOUS_FLUX"
    assert converted_light(lamp)[1] == []
    table.write_text("221 0\n222 1\n223 0\n224 0\n")
    light, rows = converted_light(lamp)
    assert light is None
    assert "holds no visible light" in rows[-1].message
    assert rows[-1].severity is Severity.ERROR


def test_lumens_that_are_stated_of_a_radiant_file_count(write_photometry):
    lamp = add_luminaire("POINT", write_photometry(RADIANT, "uv.ies"))
    settings_of(lamp).amount, settings_of(lamp).luminous_flux = "LUMENS", 50.0
    light, rows = converted_light(lamp)
    assert light.output.value == 50.0
    assert "CIE D65 is used" in [row.remedy for row in rows]


def test_remarks_about_a_file_are_told_once_for_all_its_lights(write_photometry):
    path = write_photometry(EVEN.replace("TILT=NONE", "tilt=none"))
    lamps = [add_luminaire(path=path) for _ in range(3)]
    report = ConversionReport()
    bpy.context.view_layer.update()
    step = SceneSync().walk(bpy.context.evaluated_depsgraph_get())
    report = [(row, count) for row, count in step.report.rows if row.datablock == "even.ies"]
    assert len(lamps) == 3
    assert [count for _, count in report] == [3]


def test_an_unreadable_text_is_said_by_name():
    text = bpy.data.texts.new("words.ies")
    text.from_string("no photometric file")
    with pytest.raises(LumenrayError, match=r"words\.ies, line 1"):
        photometric_files.obtain_text(text)
