"""Luminaires in Blender: their files, their settings, and what becomes of them in the engine."""

import gc
import os
from pathlib import Path
from types import SimpleNamespace

import bpy
import lumenray
import numpy as np
import pytest
from lumenray.blender_addon.foundation.report import ConversionReport, Severity
from lumenray.blender_addon.luminaires import body, files, placing
from lumenray.blender_addon.luminaires.settings import active_settings, settings_of
from lumenray.blender_addon.sync.lights.lights import convert_light
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import LumenrayError
from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.scene.light import Luminaire, PointLight, Quantity
from lumenray.engine.scene.mesh import Placement
from lumenray.engine.scene.scene import Scene, content_digest
from lumenray.engine.scene.spectrum import Blackbody, Illuminant, Rgb
from lumenray.engine.session import Session
from mathutils import Euler, Matrix
from photometric_files import write_ies
from random_edits import differences

EVEN = write_ies([[100.0, 100.0]], [0, 180], [0], size=(0.3, 1.2, 0.0))
"""100 cd in all directions from a rectangle of 0.3 m along y and 1.2 m along x."""

FULL_FLUX = 400.0 * np.pi
"""Of `EVEN`. [lm]"""

FOUR = write_ies(
    np.outer([1.0, 2.0, 3.0, 4.0, 1.0], [0.0, 100.0, 0.0]), [0, 90, 180], [0, 90, 180, 270, 360]
)
"""100, 200, 300 and 400 cd to C0, C90, C180 and C270 at the horizontal."""

SIDEWAYS = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], float)


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a file and returns its path."""

    def save(content=EVEN, name="even.ies"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return str(path)

    return save


@pytest.fixture(autouse=True)
def _operators(registered):
    lumenray.register()


def add_lamp(kind="POINT", path="", name="Lamp"):
    """Return an object: a light of a kind, or an empty."""
    data = None if kind == "EMPTY" else bpy.data.lights.new(name, kind)
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    if path:
        files.load(settings_of(made), path)
    return made


def convert(source, scale=1.0):
    """Return the engine's light and the rows of the report."""
    bpy.context.view_layer.update()
    evaluated = source.evaluated_get(bpy.context.evaluated_depsgraph_get())
    report = ConversionReport()
    light = convert_light(
        evaluated, "id", source.name, evaluated.matrix_world, scale, 177.83, report
    )
    return light, [row for row, _ in report.rows]


def candelas(light, direction):
    """Intensity towards directions of the world."""
    share = light.output.value / flux(light.distribution)
    return share * intensity(light.distribution, np.asarray(direction) @ light.frame[:3, :3])


def activate(thing):
    bpy.context.view_layer.objects.active = thing


# ---- files ----


def test_settings_and_embedded_files_survive_saving(write, tmp_path):
    lamp, empty = add_lamp("AREA", write()), add_lamp("EMPTY", write(), "Empty")
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
    light, rows = convert(lamp)
    assert light.output.value == pytest.approx(FULL_FLUX)
    assert rows == []


def test_one_content_is_one_text(write):
    first, second = add_lamp(path=write()), add_lamp(path=write(name="other name.ies"))
    third = add_lamp(path=write(FOUR))
    assert settings_of(first).text == settings_of(second).text != settings_of(third).text
    assert len(bpy.data.texts) == 2
    copied = first.copy()
    copied.data = first.data.copy()
    assert settings_of(copied).text == settings_of(first).text
    assert files.read(settings_of(first)) is files.read(settings_of(copied))
    one, other = convert(first)[0], convert(second)[0]
    assert one.distribution.intensity is other.distribution.intensity


def test_a_text_that_was_edited_is_not_taken_for_the_file(write):
    lamp = add_lamp(path=write())
    text = settings_of(lamp).text
    text.from_string(EVEN.replace("100 100", "50 50"))
    light, rows = convert(lamp)
    assert light.output.value == pytest.approx(0.5 * FULL_FLUX)
    assert "edited" in rows[0].message
    other = add_lamp(path=write())
    assert settings_of(other).text != text


@pytest.mark.parametrize(
    "content",
    [
        EVEN.replace("\n", "\r\n").encode() + b"\x1a",
        EVEN.replace("\n", "\r").encode(),
        b"\xef\xbb\xbf" + EVEN.replace("[TEST] own", "[TEST] Prüfung ²").encode(),
        EVEN.replace("[TEST] own", "[TEST] Prüfung ²").encode("latin-1"),
    ],
)
def test_an_embedded_file_comes_back_byte_by_byte(content, write, tmp_path):
    lamp = add_lamp(path=write(content))
    blend = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    bpy.ops.wm.open_mainfile(filepath=blend)
    lamp = bpy.data.objects["Lamp"]
    assert files.content_of(settings_of(lamp).text) == content
    assert not files.has_changed(settings_of(lamp), files.read(settings_of(lamp)))
    (tmp_path / "even.ies").unlink()
    written = files.unpack(settings_of(lamp))
    assert Path(written).read_bytes() == content
    assert convert(lamp)[0].output.value == pytest.approx(FULL_FLUX)


def test_what_texts_cannot_hold_is_linked(write):
    lamp = add_lamp()
    activate(lamp)
    bpy.ops.lumenray.load_luminaire_file(filepath=write(EVEN.encode() + b"\0" * 3))
    assert settings_of(lamp).text is None
    assert convert(lamp)[0].output.value == pytest.approx(FULL_FLUX)
    with pytest.raises(RuntimeError, match="has NUL characters"):
        bpy.ops.lumenray.pack_luminaire_file()
    with pytest.raises(LumenrayError, match="line of 300007 characters"):
        files.embed(b"[TEST] " + b"x" * 300000, "long.ies")


def test_another_path_takes_the_embedded_files_place(write):
    lamp = add_lamp(path=write())
    settings_of(lamp).filepath = write(FOUR, "four.ies")
    assert settings_of(lamp).text is None
    np.testing.assert_allclose(candelas(convert(lamp)[0], SIDEWAYS), [100, 200, 300, 400])


def test_a_linked_file_that_changed_is_read_anew_with_a_warning(write):
    lamp = add_lamp()
    files.load(settings_of(lamp), write(), is_embedded=False)
    assert convert(lamp)[1] == []
    write(EVEN.replace("100 100", "25 25.00"))
    light, rows = convert(lamp)
    assert light.output.value == pytest.approx(0.25 * FULL_FLUX)
    assert [row.severity for row in rows] == [Severity.WARNING]
    files.reload(settings_of(lamp))
    assert convert(lamp)[1] == []


def test_a_tilt_file_lies_beside_the_photometric_file(write):
    write("1\n2\n0 90\n1 0.5\n", "lamp.tlt")
    path = write(EVEN.replace("TILT=NONE", "TILT=lamp.tlt"))
    lamp = add_lamp(path=path)
    lamp.rotation_euler = (np.pi / 2, 0.0, 0.0)
    assert convert(lamp)[0].output.value == pytest.approx(0.5 * FULL_FLUX)


@pytest.mark.parametrize("is_embedded", [True, False])
def test_a_refused_file_leaves_the_light_out(write, is_embedded):
    lamp = add_lamp()
    files.load(settings_of(lamp), write(), is_embedded)
    broken = EVEN.replace("\n100 100\n", "\n100\n")
    if is_embedded:
        settings_of(lamp).text.from_string(broken)
    else:
        write(broken)
    light, rows = convert(lamp)
    assert light is None
    assert [row.severity for row in rows] == [Severity.ERROR]
    assert "even.ies" in rows[0].message
    assert "line" in rows[0].message
    assert rows[0].remedy == "the light is left out"


def test_a_missing_file_and_no_file_leave_the_light_out(write):
    lamp = add_lamp()
    settings_of(lamp).use_file = True
    light, rows = convert(lamp)
    assert light is None
    assert "no photometric file is chosen" in rows[0].message
    settings_of(lamp).filepath = "//missing.ies"
    light, rows = convert(lamp)
    assert light is None
    assert "cannot be opened" in rows[0].message
    settings_of(lamp).filepath = os.devnull
    light, rows = convert(lamp)
    assert light is None
    assert "is a device" in rows[0].message


RADIANT = write_ies(
    [[100.0, 100.0]], [0, 180], [0], keywords=("[LAMP] Excimer", "[_INTENSITYUNITS] mW/sr")
)
"""0.1 W/sr in all directions, 0.4 pi W."""


@pytest.mark.parametrize("kind", ["POINT", "EMPTY"])
def test_watts_without_a_spectrum_light_nothing_and_that_is_said(write, kind):
    lamp = add_lamp(kind, write(RADIANT, "uv.ies"))
    light, rows = convert(lamp)
    assert light is None
    told = [row for row in rows if row.datablock == "Lamp"]
    assert [row.severity for row in told] == [Severity.WARNING]
    assert told[0].message == "its 1.257 W have no spectrum"
    assert told[0].remedy == "it lights nothing visible"
    # Of a lamp that is not ultraviolet, light is missing.
    files.load(settings_of(lamp), write(RADIANT.replace("Excimer", "unknown"), "led.ies"))
    rows = convert(lamp)[1]
    assert Severity.ERROR in [row.severity for row in rows]


def test_a_mere_colour_makes_no_light_of_watts_but_a_spectrum_does(write, tmp_path):
    lamp = add_lamp("POINT", write(RADIANT, "uv.ies"))
    settings_of(lamp).spectrum_source = "LIGHT"
    assert convert(lamp)[0] is None
    # 555 nm and, as strong, 222 nm: half of the watts are seen, at 683 lm/W.
    table = tmp_path / "lamp.txt"
    table.write_text("221 0\n222 1\n223 0\n554 0\n555 1\n556 0\n")
    own = lamp.data.lumenray
    own.use_physical, own.spectrum, own.spectrum_file = True, "FILE", str(table)
    light, _ = convert(lamp)
    assert light.output.quantity is Quantity.LUMINOUS_FLUX
    assert light.output.value == pytest.approx(0.4 * np.pi * 341.4, rel=2e-3)
    table.write_text("221 0\n222 1\n223 0\n224 0\n")
    light, rows = convert(lamp)
    assert light is None
    assert "none of its 1.257 W is visible" in " ".join(row.message for row in rows)


@pytest.mark.parametrize("kind", ["light", "luminaire"])
def test_a_lamp_whose_spectrum_is_zero_is_left_out_with_an_error(write, tmp_path, kind):
    lamp = add_lamp("POINT", write() if kind == "luminaire" else "")
    settings_of(lamp).spectrum_source = "LIGHT"
    table = tmp_path / "lamp.txt"
    table.write_text("380 0\n580 0\n780 0\n")
    own = lamp.data.lumenray
    own.use_physical, own.spectrum, own.spectrum_file = True, "FILE", str(table)
    light, rows = convert(lamp)
    assert light is None
    assert rows[-1].severity is Severity.ERROR
    assert "no value above 0" in rows[-1].message
    assert rows[-1].remedy == "the light is left out"


def test_watts_beyond_what_counts_and_lamps_without_visible_light_are_told(tmp_path):
    lamp, table = add_lamp(), tmp_path / "lamp.txt"
    # Half of the watts at 222 nm, half at 555 nm.
    table.write_text("221 0\n222 1\n223 0\n554 0\n555 1\n556 0\n")
    own = lamp.data.lumenray
    own.use_physical, own.spectrum, own.spectrum_file = True, "FILE", str(table)
    own.quantity, own.value = "RADIANT_FLUX", 10.0
    light, rows = convert(lamp)
    assert light.output.value == 10.0
    assert "0.5 of the power of its spectrum" in rows[-1].message
    assert rows[-1].remedy == "the watts are those within"
    own.quantity = "LUMINOUS_FLUX"
    assert convert(lamp)[1] == []
    table.write_text("221 0\n222 1\n223 0\n224 0\n")
    light, rows = convert(lamp)
    assert light is None
    assert "holds no visible light" in rows[-1].message
    assert rows[-1].severity is Severity.ERROR


def test_lumens_that_are_stated_of_a_radiant_file_count(write):
    lamp = add_lamp("POINT", write(RADIANT, "uv.ies"))
    settings_of(lamp).amount, settings_of(lamp).luminous_flux = "LUMENS", 50.0
    light, rows = convert(lamp)
    assert light.output.value == 50.0
    assert "CIE D65 is used" in [row.remedy for row in rows]


def test_remarks_about_a_file_are_told_once_for_all_its_lights(write):
    path = write(EVEN.replace("TILT=NONE", "tilt=none"))
    lamps = [add_lamp(path=path) for _ in range(3)]
    report = ConversionReport()
    bpy.context.view_layer.update()
    step = SceneSync().walk(bpy.context.evaluated_depsgraph_get())
    report = [(row, count) for row, count in step.report.rows if row.datablock == "even.ies"]
    assert len(lamps) == 3
    assert [count for _, count in report] == [3]


# ---- conversion ----


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "AREA", "EMPTY"])
def test_every_kind_takes_a_file(kind, write):
    lamp = add_lamp(kind, write())
    lamp.location = (1.0, 2.0, 3.0)
    light, rows = convert(lamp)
    assert isinstance(light, Luminaire)
    assert rows == []
    assert light.output.quantity is Quantity.LUMINOUS_FLUX
    assert light.output.value == pytest.approx(FULL_FLUX)
    assert (light.opening.shape, light.opening.size) == ("rectangle", (1.2, 0.3, 0.0))
    np.testing.assert_allclose(light.frame[:3, 3], (1, 2, 3))
    np.testing.assert_allclose(light.frame[:3, :3], np.eye(3), atol=1e-7)
    settings_of(lamp).use_file = False
    before = convert(lamp)[0] if kind != "EMPTY" else None
    assert not isinstance(before, Luminaire)


def test_a_sun_takes_none():
    assert settings_of(add_lamp("SUN")) is None


@pytest.mark.parametrize(
    ("kind", "shape", "size"),
    [
        ("POINT", "ellipsoid", (0.5, 0.5, 0.5)),
        ("SPOT", "ellipsoid", (0.5, 0.5, 0.5)),
        ("AREA", "ellipse", (0.4, 0.8, 0.0)),
        ("EMPTY", "point", (0.0, 0.0, 0.0)),
    ],
)
def test_a_light_shines_from_its_own_size(kind, shape, size, write):
    lamp = add_lamp(kind, write())
    settings_of(lamp).emission = "LIGHT"
    if kind == "AREA":
        lamp.data.shape, lamp.data.size, lamp.data.size_y = "ELLIPSE", 0.2, 0.8
        lamp.scale.x = 2.0
    elif kind != "EMPTY":
        lamp.data.shadow_soft_size = 0.25
    opening = convert(lamp)[0].opening
    assert opening.shape == shape
    assert opening.size == pytest.approx(size)
    settings_of(lamp).emission = "POINT"
    assert convert(lamp)[0].opening.shape == "point"


def test_the_beam_follows_the_object_and_c0_its_x_axis(write):
    lamp = add_lamp(path=write(FOUR))
    lamp.rotation_euler = turn = Euler((0.3, -0.7, 1.9))
    light, _ = convert(lamp)
    world = SIDEWAYS @ np.array(turn.to_matrix()).T
    np.testing.assert_allclose(candelas(light, world), [100, 200, 300, 400], rtol=1e-5)
    np.testing.assert_allclose(light.frame[:3, :3], turn.to_matrix(), atol=1e-6)


def test_the_rotation_turns_c0_but_not_the_opening(write):
    lamp = add_lamp(path=write(FOUR.replace("2 0 0 0\n", "2 0.3 1.2 0\n")))
    settings_of(lamp).rotation = np.pi / 2
    light, _ = convert(lamp)
    # C0 now looks along +y, so +x sees what was C270.
    np.testing.assert_allclose(candelas(light, SIDEWAYS), [400, 100, 200, 300], rtol=1e-5)
    np.testing.assert_allclose(light.frame[:3, :3], np.eye(3), atol=1e-7)
    assert light.opening.size == (1.2, 0.3, 0.0)


def test_clockwise_files_are_mirrored(write):
    lamp = add_lamp(path=write(FOUR))
    settings_of(lamp).mirror = True
    np.testing.assert_allclose(candelas(convert(lamp)[0], SIDEWAYS), [100, 400, 300, 200])
    settings_of(lamp).rotation = np.pi / 2
    np.testing.assert_allclose(
        candelas(convert(lamp)[0], SIDEWAYS), [200, 100, 400, 300], rtol=1e-5
    )


def test_type_b_can_be_flipped_left_for_right(write):
    angles = [-90, -45, 0, 45, 90]
    text = write_ies(
        lambda h, v: 500.0 + 100.0 * np.sin(h) + 10.0 * np.sin(v) * np.cos(h), angles, angles, "B"
    )
    lamp = add_lamp(path=write(text))
    right, left, up = [1, 0, -1], [-1, 0, -1], [0, 1, -1]
    side = 100.0 * np.sin(np.pi / 4)
    above = 10.0 * np.sin(np.pi / 4)
    light, _ = convert(lamp)
    expected = [500 + side, 500 - side, 500 + above]
    np.testing.assert_allclose(candelas(light, [right, left, up]), expected, rtol=1e-5)
    settings_of(lamp).flip_h = True
    light, _ = convert(lamp)
    expected = [500 - side, 500 + side, 500 + above]
    np.testing.assert_allclose(candelas(light, [right, left, up]), expected, rtol=1e-5)
    settings_of(lamp).mirror = True
    np.testing.assert_allclose(candelas(convert(lamp)[0], [right, left, up]), expected, rtol=1e-5)


def test_a_mirrored_object_mirrors_its_light(write):
    lamp = add_lamp(path=write(FOUR))
    lamp.scale = (-1.0, 1.0, 1.0)
    light, _ = convert(lamp)
    assert np.linalg.det(light.frame[:3, :3]) == pytest.approx(1.0)
    np.testing.assert_allclose(candelas(light, SIDEWAYS), [300, 200, 100, 400], rtol=1e-5)


def test_scale_moves_but_does_not_enlarge_the_opening(write):
    lamp = add_lamp(path=write())
    lamp.location.x = 300.0
    light, rows = convert(lamp, scale=0.01)
    assert light.frame[0, 3] == pytest.approx(3.0)
    assert light.opening.size == (1.2, 0.3, 0.0)
    assert rows == []
    lamp.scale = (2.0, 2.0, 2.0)
    light, rows = convert(lamp)
    assert light.opening.size == (1.2, 0.3, 0.0)
    assert "scaled" in rows[0].message
    np.testing.assert_allclose(light.frame[:3, :3], np.eye(3), atol=1e-7)
    lamp.scale = (0.0, 1.0, 1.0)
    light, rows = convert(lamp)
    assert light is None
    assert "scale is zero" in rows[0].message


def test_a_sheared_object_keeps_a_rigid_frame(write):
    lamp = add_lamp(path=write())
    parent = add_lamp("EMPTY")
    parent.scale = (1.0, 3.0, 1.0)
    lamp.parent, lamp.rotation_euler = parent, (0.0, 0.0, 0.6)
    light, rows = convert(lamp)
    axes = light.frame[:3, :3]
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-6)
    assert any("sheared" in row.message for row in rows)


def test_every_factor_of_the_amount_counts(write):
    lamp = add_lamp(path=write())
    settings = settings_of(lamp)
    settings.dimming, settings.maintenance_factor, settings.lamp_factor = 0.5, 0.8, 1.25
    assert convert(lamp)[0].output.value == pytest.approx(0.5 * FULL_FLUX, rel=1e-6)
    settings.amount, settings.luminous_flux = "LUMENS", 3000.0
    assert convert(lamp)[0].output.value == pytest.approx(1500.0, rel=1e-6)
    settings.dimming = 0.0
    assert convert(lamp) == (None, [])


@pytest.mark.parametrize(("geometry", "factor"), [(1, 0.8), (2, 1.0), (3, 0.8)])
def test_the_tilt_of_the_object_counts_where_the_lamp_tilts(geometry, factor, write):
    text = EVEN.replace("TILT=NONE", f"TILT=INCLUDE\n{geometry}\n3\n0 45 90\n1 0.8 0.6")
    lamp = add_lamp(path=write(text))
    assert convert(lamp)[0].output.value == pytest.approx(FULL_FLUX)
    lamp.rotation_euler = (0.0, np.pi / 4, 2.0)
    assert convert(lamp)[0].output.value == pytest.approx(factor * FULL_FLUX, rel=1e-5)


def test_the_spectrum_is_the_files_or_the_lights(write):
    text = EVEN.replace("[MANUFAC] own", "[MANUFAC] own\n[LAMP] incandescent")
    lamp = add_lamp(path=write(text))
    lamp.data.color = (1.0, 0.0, 0.0)
    light, _ = convert(lamp)
    assert light.output.spectrum == Illuminant("A")
    settings_of(lamp).spectrum_source = "LIGHT"
    light, _ = convert(lamp)
    assert light.output.spectrum == Rgb(1.0, 0.0, 0.0)
    assert light.output.value == pytest.approx(FULL_FLUX)
    lamp.data.lumenray.use_physical, lamp.data.lumenray.spectrum = True, "BLACKBODY"
    lamp.data.lumenray.colour_temperature = 3000.0
    assert convert(lamp)[0].output.spectrum == Blackbody(3000.0)


def test_an_empty_has_a_spectrum_of_its_own(write):
    empty = add_lamp("EMPTY", write())
    settings = settings_of(empty)
    settings.spectrum_source, settings.color = "LIGHT", (0.5, 0.25, 0.0)
    light, _ = convert(empty)
    assert light.output.spectrum == Rgb(1.0, 0.5, 0.0)
    assert light.output.value == pytest.approx(FULL_FLUX)
    settings.spectrum = "BLACKBODY"
    assert convert(empty)[0].output.spectrum == Blackbody(4000.0)


def test_blenders_watts_and_nodes_do_not_count(write):
    lamp = add_lamp(path=write())
    one = content_digest(convert(lamp)[0])
    lamp.data.energy, lamp.data.use_nodes = 77.0, True
    assert content_digest(convert(lamp)[0]) == one


def test_dimming_can_be_animated(write):
    lamp = add_lamp("EMPTY", write())
    for frame, value in ((1, 1.0), (11, 0.0)):
        settings_of(lamp).dimming = value
        lamp.keyframe_insert("lumenray.luminaire.dimming", frame=frame)
    bpy.context.scene.frame_set(6)
    assert convert(lamp)[0].output.value == pytest.approx(0.5 * FULL_FLUX, rel=1e-3)


# ---- the scene ----


class Stage:
    """A scene of the engine that is kept current."""

    def __init__(self):
        self.sync, self.kept = SceneSync(), Scene()

    def sent(self):
        """Walk; return the items that were sent and the ids that are gone."""
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        step = self.sync.walk(depsgraph)
        self.kept.apply(step.delta)
        fresh = Scene()
        fresh.apply(SceneSync().walk(depsgraph).delta)
        assert differences(self.kept, fresh) == []
        return list(step.delta.changed), list(step.delta.removed)


def test_an_empty_is_a_light_of_the_scene_and_goes_with_its_file(write):
    empty, stage = add_lamp("EMPTY", write()), Stage()
    ((light,), removed) = stage.sent()
    assert isinstance(light, Luminaire)
    assert light.id == f"object:{empty.lumenray.uid}"
    assert removed == []
    settings_of(empty).use_file = False
    assert stage.sent() == ([], [light.id])
    settings_of(empty).use_file = True
    ((back,), _) = stage.sent()
    assert content_digest(back) == content_digest(light)
    bpy.data.objects.remove(empty)
    assert stage.sent() == ([], [light.id])


@pytest.mark.parametrize("kind", ["POINT", "EMPTY"])
@pytest.mark.parametrize("edit", ["dimming", "rotation", "emission", "text", "move"])
def test_an_edit_sends_that_light_alone(kind, edit, write):
    lamp, other = add_lamp(kind, write()), add_lamp(kind, write(), "Other")
    add_lamp("EMPTY", name="plain")
    stage = Stage()
    stage.sent()
    settings = settings_of(lamp)
    match edit:
        case "dimming":
            settings.dimming = 0.5
        case "rotation":
            settings.rotation = 0.5
        case "emission":
            settings.emission = "POINT"
        case "text":
            files.load(settings, write(FOUR, "four.ies"))
        case "move":
            lamp.location.z = 1.0
    changed, removed = stage.sent()
    assert [item.name for item in changed] == [lamp.name]
    assert removed == []
    assert settings_of(other).dimming == 1.0
    settings.show_solid = False
    assert stage.sent() == ([], [])


def test_a_hidden_luminaire_is_dark_and_comes_back(write):
    empty, stage = add_lamp("EMPTY", write()), Stage()
    stage.sent()
    empty.hide_set(True)
    ((dark,), _) = stage.sent()
    assert dark.output.value == 0.0
    empty.hide_set(False)
    ((bright,), _) = stage.sent()
    assert bright.id == dark.id
    assert bright.output.value == pytest.approx(FULL_FLUX)


def test_instances_of_luminaires_are_lights(write):
    group = bpy.data.collections.new("Group")
    empty, lamp = add_lamp("EMPTY", write()), add_lamp("SPOT", write())
    for thing in (empty, lamp):
        group.objects.link(thing)
        bpy.context.scene.collection.objects.unlink(thing)
    stage, places = Stage(), [(1, 0, 0), (0, 5, 0)]
    for place in places:
        instance = add_lamp("EMPTY", name="Instance")
        instance.instance_type, instance.instance_collection = "COLLECTION", group
        instance.location = place
    lights, _ = stage.sent()
    assert len(lights) == len({light.id for light in lights}) == 4
    found = sorted(tuple(light.frame[:3, 3]) for light in lights)
    assert found == sorted(place for place in places for _ in range(2))
    instance.location.x = 9.0
    changed, removed = stage.sent()
    assert [light.frame[0, 3] for light in changed] == [9.0, 9.0]
    assert removed == []
    settings_of(empty).dimming = 0.5
    changed, _ = stage.sent()
    assert len(changed) == 2
    assert all(light.output.value == pytest.approx(0.5 * FULL_FLUX) for light in changed)


def test_a_body_is_no_part_of_the_scene(write):
    bpy.ops.lumenray.add_luminaire(filepath=write())
    empty, stage = bpy.context.object, Stage()
    ((light,), _) = stage.sent()
    assert isinstance(light, Luminaire)
    shown = [i.object.name for i in bpy.context.evaluated_depsgraph_get().object_instances]
    assert len(shown) == 2
    shape = empty.instance_collection.objects[0]
    shape.lumenray.is_luminaire_body = False
    changed, _ = stage.sent()
    assert Placement in {type(item) for item in changed}
    shape.lumenray.is_luminaire_body = True
    assert any(key.startswith("object:") for key in stage.sent()[1])


def test_undo_brings_a_luminaire_back(write):
    bpy.context.preferences.edit.use_global_undo = True
    lamp, stage = add_lamp("POINT", write()), Stage()
    lamp.name = "Lamp"
    bpy.ops.ed.undo_push(message="before")
    stage.sent()
    settings_of(lamp).dimming = 0.25
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="dimmed")
    stage.sent()
    bpy.ops.ed.undo()
    ((light,), _) = stage.sent()
    assert light.output.value == pytest.approx(FULL_FLUX)


@pytest.mark.parametrize("seed", [0, 1])
def test_random_edits_leave_the_scene_of_a_fresh_export(seed, write):  # noqa: PLR0912 - one for each edit
    """`Stage.sent` compares after every edit."""
    draw = np.random.default_rng(seed)
    paths = [write(), write(FOUR, "four.ies"), write(EVEN.replace("100 100", "7 7"), "dim.ies")]
    for number, kind in enumerate(("POINT", "SPOT", "AREA", "EMPTY", "EMPTY", "SUN")):
        add_lamp(kind, "" if kind == "SUN" else paths[number % 3], f"{kind} {number}")
    group = bpy.data.collections.new("Group")
    group.objects.link(bpy.data.objects["EMPTY 3"])
    instance = add_lamp("EMPTY", name="Instance")
    instance.instance_type, instance.instance_collection = "COLLECTION", group
    stage = Stage()
    stage.sent()
    for _ in range(120):
        lamp = bpy.data.objects[int(draw.integers(len(bpy.data.objects)))]
        settings, edit = settings_of(lamp), int(draw.integers(12))
        if edit == 0:
            lamp.location = draw.normal(size=3)
        elif edit == 1:
            lamp.hide_set(not lamp.hide_get())
        elif edit == 2:
            lamp.scale.x *= -1.0
        elif edit == 3:
            copied = lamp.copy()
            copied.data = lamp.data.copy() if lamp.data and draw.random() < 0.5 else lamp.data
            bpy.context.scene.collection.objects.link(copied)
        elif edit == 4 and len(bpy.data.objects) > 6:
            bpy.data.objects.remove(lamp)
        elif edit == 5 and lamp.data is not None:
            lamp.data.type = str(draw.choice(["POINT", "SPOT", "SUN", "AREA"]))
        elif settings is not None and edit == 6:
            settings.use_file = not settings.use_file
        elif settings is not None and edit == 7:
            files.load(settings, str(draw.choice(paths)), bool(draw.random() < 0.5))
        elif settings is not None and edit == 8:
            settings.dimming = float(draw.choice([0.0, 0.5, 1.0]))
        elif settings is not None and edit == 9:
            settings.emission = str(draw.choice(["OPENING", "LIGHT", "POINT"]))
        elif settings is not None and edit == 10:
            settings.rotation, settings.mirror = float(draw.random()), not settings.mirror
        elif settings is not None:
            settings.filepath = "//nowhere.ies"
        stage.sent()


@pytest.mark.parametrize("kind", ["POINT", "EMPTY"])
def test_the_engine_measures_the_files_candelas(kind, write):
    """E = I cos / d^2 on the floor 2 m below, towards C0, C90, C180 and C270 of a turned luminaire."""

    def shape(h, v):
        return 1000.0 + 600.0 * np.sin(v) * np.cos(h - 0.5)

    path = write(write_ies(shape, np.arange(0, 181, 5), np.arange(0, 361, 10)))
    lamp = add_lamp(kind, path)
    settings_of(lamp).emission = "POINT"
    settings_of(lamp).rotation, settings_of(lamp).dimming = np.deg2rad(30.0), 0.5
    lamp.location, lamp.rotation_euler = (1.0, 2.0, 2.0), (0.0, 0.0, np.deg2rad(60.0))
    bpy.context.view_layer.update()
    session = Session(witness=False)
    session.apply(convert_scene(bpy.context.evaluated_depsgraph_get()).delta)
    # C0 looks along world +y: turned by 30 degrees about the beam and by 60 with the object.
    points = np.array([[1, 3, 0], [0, 2, 0], [1, 1, 0], [2, 2, 0]], float)
    # Emitters of sessions that are gone must not go while a kernel is traced: Dr.Jit ends the process of it.
    gc.collect()
    made = session.measure(points, np.tile([0.0, 0.0, 1.0], (4, 1)), StopRule(samples=64))
    expected = 0.5 * shape(np.deg2rad([0, 90, 180, 270]), np.arctan(0.5)) * 2.0 / 5.0**1.5
    np.testing.assert_allclose(made.illuminance, expected, rtol=2e-3)


# ---- linked libraries ----


@pytest.fixture
def library(write, tmp_path):
    """Path of a .blend file with an embedded and a linked luminaire, in a folder of its own."""
    folder = tmp_path / "library"
    folder.mkdir()
    (folder / "even.ies").write_text(EVEN)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "library.blend"))
    add_lamp("EMPTY", str(folder / "even.ies"), "Embedded")
    linked = add_lamp("POINT", name="Linked")
    settings_of(linked).use_file = True
    settings_of(linked).filepath = "//even.ies"
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "library.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "user.blend"))
    return folder / "library.blend"


def test_luminaires_of_a_library_shine(library):
    with bpy.data.libraries.load(str(library), link=True) as (there, here):
        here.objects = list(there.objects)
    for thing in here.objects:
        bpy.context.scene.collection.objects.link(thing)
        light, rows = convert(thing)
        assert light.output.value == pytest.approx(FULL_FLUX)
        assert rows == []
    embedded = bpy.data.objects["Embedded"]
    assert settings_of(embedded).text.library is not None
    activate(embedded)
    assert not bpy.ops.lumenray.load_luminaire_file.poll()
    assert not bpy.ops.lumenray.unpack_luminaire_file.poll()
    # What is embedded here is a text of this file, not the library's.
    own = add_lamp("POINT", str(library.parent / "even.ies"), "Own")
    assert settings_of(own).text.library is None


def test_appended_luminaires_bring_their_file(library):
    with bpy.data.libraries.load(str(library), link=False) as (_, here):
        here.objects = ["Embedded"]
    (thing,) = here.objects
    bpy.context.scene.collection.objects.link(thing)
    assert settings_of(thing).text.library is None
    assert convert(thing)[0].output.value == pytest.approx(FULL_FLUX)


def test_a_text_that_the_library_lost_leaves_the_light_out(library, tmp_path):
    with bpy.data.libraries.load(str(library), link=True) as (_, here):
        here.objects, here.texts = [], ["even.ies"]
    lamp = add_lamp("POINT", name="Own")
    settings_of(lamp).use_file, settings_of(lamp).text = True, bpy.data.texts["even.ies"]
    assert convert(lamp)[0] is not None
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "user.blend"))
    library.unlink()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "user.blend"))
    light, rows = convert(bpy.data.objects["Own"])
    assert light is None
    assert [row.severity for row in rows] == [Severity.ERROR]
    assert "missing" in rows[0].message


# ---- operators ----


def test_a_luminaire_is_added_at_the_cursor_shining_down(write):
    bpy.context.scene.cursor.location = (1.0, 2.0, 3.0)
    assert bpy.ops.lumenray.add_luminaire(filepath=write()) == {"FINISHED"}
    empty = bpy.context.object
    assert empty.type == "EMPTY"
    assert empty.name == "even"
    assert empty.select_get()
    light, _ = convert(empty)
    np.testing.assert_allclose(light.frame[:3, 3], (1, 2, 3))
    np.testing.assert_allclose(-light.frame[:3, 2], (0, 0, -1), atol=1e-7)
    assert placing.has_body(empty)
    least = np.min([v.co for v in empty.instance_collection.objects[0].data.vertices], axis=0)
    np.testing.assert_allclose(least[:2], (-0.6, -0.15), atol=1e-6)


def test_bodies_have_the_size_of_the_housing_in_the_scenes_unit(write):
    bpy.context.scene.unit_settings.scale_length = 0.01
    bpy.ops.lumenray.add_luminaire(filepath=write())
    size = bpy.context.object.instance_collection.objects[0].dimensions
    assert tuple(size) == pytest.approx((120.0, 30.0, 0.1), rel=1e-5)


@pytest.mark.parametrize(
    ("shape", "size", "axis", "area"),
    [
        ("rectangle", (0.4, 0.2, 0.0), "z", 0.08),
        ("ellipse", (0.4, 0.0, 0.4), "y", np.pi * 0.04),
        ("box", (0.4, 0.2, 0.1), "z", 0.08),
        ("cylinder", (1.2, 0.1, 0.1), "x", 0.12),
        ("ellipsoid", (0.3, 0.3, 0.3), "z", np.pi * 0.0225),
    ],
)
def test_bodies_are_closed_and_face_outwards(shape, size, axis, area):
    import bmesh
    from lumenray.engine.scene.distribution import Opening

    class Plain:
        opening = Opening(shape, size, axis)
        housing = None

    mesh = bmesh.new()
    mesh.from_mesh(body.build_body(Plain, "body", 1.0))
    assert all(edge.is_manifold for edge in mesh.edges)
    volume = mesh.calc_volume(signed=True)
    assert volume > 0.0
    down = sum(f.calc_area() * max(-f.normal.z, 0.0) for f in mesh.faces)
    assert down == pytest.approx(max(area if axis != "y" else 0.4 * body.THIN, 0.0), rel=0.02)


def test_a_housing_ends_with_the_opening():
    from lumenray.engine.scene.distribution import Opening

    class Round:
        opening = Opening("ellipse", (0.2, 0.2, 0.0))
        housing = (0.3, 0.0, 0.1)

    least, largest = body.body_extent(Round)
    np.testing.assert_allclose(least, (-0.15, -0.15, -0.5 * body.THIN))
    np.testing.assert_allclose(largest, (0.15, 0.15, 0.1 - 0.5 * body.THIN))


def test_a_refused_file_adds_nothing(write):
    count = len(bpy.data.objects)
    with pytest.raises(RuntimeError, match="is not an IES LM-63 file"):
        bpy.ops.lumenray.add_luminaire(filepath=write("nothing"))
    good = write()
    with pytest.raises(RuntimeError, match=r"bad\.ies"):
        bpy.ops.lumenray.drop_luminaire(
            directory=good.removesuffix("even.ies"),
            files=[{"name": "even.ies"}, {"name": "bad.ies"}],
        )
    assert len(bpy.data.objects) == count
    assert not bpy.data.texts


def test_dropped_on_a_ceiling_several_hang_side_by_side(write, tmp_path):
    write()
    write(FOUR, "four.ies")
    done = bpy.ops.lumenray.drop_luminaire(
        directory=str(tmp_path),
        files=[{"name": "even.ies"}, {"name": "four.ies"}],
        point=(1.0, 0.0, 2.7),
        normal=(0.0, 0.0, -1.0),
        on_surface=True,
    )
    assert done == {"FINISHED"}
    first, second = sorted(bpy.context.selected_objects, key=lambda o: o.location.x)
    assert (first.name, second.name) == ("even", "four")
    for empty in (first, second):
        corners = [empty.matrix_world @ v.co for v in _body(empty).vertices]
        top = max(corner.z for corner in corners)
        assert top == pytest.approx(2.7 - placing.CLEARANCE, abs=1e-6)
    gap = _extent(second)[0] - _extent(first)[1]
    assert gap == pytest.approx(placing.GAP, abs=1e-5)


def _body(empty):
    return empty.instance_collection.objects[0].data


def _extent(empty):
    x = [(empty.matrix_world @ vertex.co).x for vertex in _body(empty).vertices]
    return min(x), max(x)


@pytest.mark.parametrize(
    "normal", [(0, 0, -1), (0, 0, 1), (1, 0, 0), (0.6, -0.8, 0), (0, 0.6, 0.8)]
)
def test_dropped_on_a_surface_it_shines_along_the_normal(normal, write):
    bpy.ops.lumenray.drop_luminaire(
        filepath=write(), point=(1.0, 2.0, 3.0), normal=normal, on_surface=True
    )
    frame = convert(bpy.context.object)[0].frame
    np.testing.assert_allclose(-frame[:3, 2], normal, atol=1e-6)
    away = (frame[:3, 3] - (1, 2, 3)) @ normal
    assert away == pytest.approx(0.5 * body.THIN + placing.CLEARANCE, abs=1e-6)
    if abs(normal[2]) < 0.9:
        # On a wall the luminaire's y is up.
        assert frame[2, 1] > 0.5


def test_dropped_beside_everything_it_comes_to_the_cursor(write):
    bpy.context.scene.cursor.location = (4.0, 5.0, 6.0)
    bpy.ops.lumenray.drop_luminaire(filepath=write())
    assert tuple(bpy.context.object.location) == (4.0, 5.0, 6.0)


@pytest.mark.parametrize("is_perspective", [True, False])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_mouse_finds_the_surface_under_it(side, is_perspective):
    """Looking at a plane in z = 1 from above or below, with a view that is 2 units high there."""
    bpy.ops.mesh.primitive_plane_add(size=10.0, location=(0.0, 0.0, 1.0))
    bpy.context.view_layer.update()
    eye = Matrix.Translation((0.0, 0.0, 1.0 + 4.0 * side))
    if side < 0.0:
        eye = eye @ Matrix.Rotation(np.pi, 4, "X")
    lens = Matrix.Diagonal((1.0, 1.0, -0.1, 1.0))
    if is_perspective:
        lens = Matrix(((4, 0, 0, 0), (0, 4, 0, 0), (0, 0, -1, -0.2), (0, 0, -1, 0)))
    view = SimpleNamespace(
        view_matrix=eye.inverted(),
        perspective_matrix=lens @ eye.inverted(),
        window_matrix=lens,
        is_perspective=is_perspective,
        view_perspective="PERSP" if is_perspective else "ORTHO",
    )
    context = SimpleNamespace(
        region=SimpleNamespace(width=200, height=200),
        region_data=view,
        scene=bpy.context.scene,
        evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
    )
    mount = placing.mount_under(context, 150, 100)
    assert mount.is_surface
    assert mount.point == pytest.approx((0.5, 0.0, 1.0), abs=1e-4)
    # A ceiling is lit from, not through: the plane's own normal points up.
    assert mount.normal == pytest.approx((0.0, 0.0, side), abs=1e-6)
    view.view_matrix = Matrix.Translation((0.0, 0.0, -90.0)) @ eye.inverted()
    bpy.context.scene.cursor.location = (7.0, 8.0, 9.0)
    bpy.data.objects.remove(bpy.data.objects["Plane"])
    assert placing.mount_under(context, 150, 100) == placing.Mount((7.0, 8.0, 9.0))
    context.region_data = None
    assert placing.mount_under(context, 150, 100) == placing.Mount((7.0, 8.0, 9.0))


def test_luminaires_are_added_from_blenders_own_menu():
    from lumenray import ui

    draws = bpy.types.VIEW3D_MT_light_add._dyn_ui_initialize()
    ui.attach()
    assert ui.add_menu.draw_luminaire in draws
    ui.detach()
    assert ui.add_menu.draw_luminaire not in draws


def test_luminaires_are_dropped_by_blenders_file_handler():
    handler = bpy.types.FileHandler.bl_rna_get_subclass_py("LUMENRAY_FH_luminaire")
    assert handler.bl_import_operator == "lumenray.drop_luminaire"
    assert handler.bl_file_extensions == ".ies;.ldt;.xml"


def test_a_file_is_loaded_into_the_active_light_or_empty(write):
    path = write()
    with pytest.raises(RuntimeError):
        bpy.ops.lumenray.load_luminaire_file(filepath=path)
    sun = add_lamp("SUN")
    activate(sun)
    assert active_settings(bpy.context) is None
    lamp = add_lamp("SPOT")
    activate(lamp)
    assert bpy.ops.lumenray.load_luminaire_file(filepath=path) == {"FINISHED"}
    assert settings_of(lamp).use_file
    assert settings_of(lamp).text is not None
    with pytest.raises(RuntimeError, match="line"):
        bpy.ops.lumenray.load_luminaire_file(filepath=write(EVEN[:-30], "cut.ies"))
    assert convert(lamp)[0].output.value == pytest.approx(FULL_FLUX)
    bpy.ops.lumenray.load_luminaire_file(filepath=path, use_embed=False)
    assert settings_of(lamp).text is None
    assert settings_of(lamp).filepath == path


def test_another_file_gives_an_empty_another_body(write):
    bpy.ops.lumenray.add_luminaire(filepath=write())
    empty = bpy.context.object
    copied = empty.copy()
    bpy.context.scene.collection.objects.link(copied)
    before = _extent(copied)
    bpy.ops.lumenray.load_luminaire_file(filepath=write(FOUR, "four.ies"))
    assert _extent(empty) != before
    assert _extent(copied) == before
    bpy.data.objects.remove(copied)
    bpy.ops.lumenray.clear_luminaire_file()
    assert not placing.has_body(empty)
    assert not settings_of(empty).use_file
    assert settings_of(empty).text is None


def test_embedding_linking_and_reloading(write, tmp_path):
    lamp, path = add_lamp("AREA"), write()
    activate(lamp)
    assert not bpy.ops.lumenray.pack_luminaire_file.poll()
    assert not bpy.ops.lumenray.unpack_luminaire_file.poll()
    assert not bpy.ops.lumenray.reload_luminaire_file.poll()
    bpy.ops.lumenray.load_luminaire_file(filepath=path, use_embed=False)
    bpy.ops.lumenray.pack_luminaire_file()
    assert settings_of(lamp).text.name == "even.ies"
    assert settings_of(lamp).filepath == path
    bpy.ops.lumenray.unpack_luminaire_file()
    assert settings_of(lamp).text is None
    assert settings_of(lamp).filepath == path
    bpy.ops.lumenray.pack_luminaire_file()
    write(FOUR)
    bpy.ops.lumenray.reload_luminaire_file()
    np.testing.assert_allclose(candelas(convert(lamp)[0], SIDEWAYS), [100, 200, 300, 400])
    # Texts that nothing uses any more are not saved.
    assert [text.users for text in bpy.data.texts if text != settings_of(lamp).text] == [0]
    (tmp_path / "even.ies").unlink()
    with pytest.raises(RuntimeError, match="cannot be opened"):
        bpy.ops.lumenray.reload_luminaire_file()
    np.testing.assert_allclose(candelas(convert(lamp)[0], SIDEWAYS), [100, 200, 300, 400])
    with pytest.raises(RuntimeError, match="save the Blender file first"):
        bpy.ops.lumenray.unpack_luminaire_file()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    bpy.ops.lumenray.unpack_luminaire_file()
    assert settings_of(lamp).filepath.startswith("//luminaires")
    assert (tmp_path / "luminaires" / "even.ies").read_text() == FOUR


def test_an_unreadable_text_is_said_by_name():
    text = bpy.data.texts.new("words.ies")
    text.from_string("no photometric file")
    with pytest.raises(LumenrayError, match=r"words\.ies, line 1"):
        files.read_text(text)


def test_a_light_without_a_file_is_as_before():
    lamp = add_lamp()
    light, _ = convert(lamp)
    assert isinstance(light, PointLight)
    lamp.matrix_world = Matrix.Translation((0, 0, 1))
    assert isinstance(convert(lamp)[0], PointLight)
