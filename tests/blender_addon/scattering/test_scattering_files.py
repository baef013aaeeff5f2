"""Scattering files of materials: opened, embedded, linked, unpacked, reloaded and refused."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from blender_scattering import INCIDENCES, add_paint, matt
from conversion import converted_material, error_messages
from scattering_models import lambert

from lumenray.blender_addon.file_assets.places import digest_of
from lumenray.blender_addon.scattering.files import scattering_files
from lumenray.engine.errors import FileFormatError
from lumenray.engine.scattering.data.record import ScatteringFile
from lumenray.engine.scattering.data.resampling import resample
from lumenray.engine.scattering.readers import reader
from lumenray.engine.scene.material import Diffuse, Measured
from lumenray.engine.scene.spectrum import Constant

pytestmark = pytest.mark.usefixtures("extension")

ASTM = """ASTM E1392 measurement
NUM_POINTS 4
"""


def test_open_embed_link_and_undo_nothing_of_the_content(write_scattering, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    path = write_scattering("silk.lumbsdf")
    paint = add_paint()
    measured = paint.lumenray.measured
    assert bpy.ops.lumenray.load_scattering_file(filepath=path) == {"FINISHED"}
    assert paint.lumenray.use_override
    assert paint.lumenray.model == "MEASURED"
    assert bpy.path.abspath(measured.filepath) == path
    assert not bpy.ops.lumenray.unpack_scattering_file.poll()
    assert bpy.ops.lumenray.pack_scattering_file() == {"FINISHED"}
    assert measured.text.name == "silk.lumbsdf"
    assert not bpy.ops.lumenray.pack_scattering_file.poll()
    head, *lines = measured.text.as_string().split("\n")
    assert digest_of(Path(path).read_bytes()) in head
    assert max(map(len, lines)) == 76
    content = Path(path).read_bytes()
    Path(path).unlink()
    assert isinstance(converted_material(paint)[0], Measured)
    assert bpy.ops.lumenray.unpack_scattering_file() == {"FINISHED"}
    written = Path(bpy.path.abspath(measured.filepath))
    assert written == tmp_path / "materials" / "silk.lumbsdf"
    assert written.read_bytes() == content
    assert measured.text is None
    assert isinstance(converted_material(paint)[0], Measured)


def test_a_file_whose_content_is_still_there_is_linked_again(write_scattering, tmp_path):
    paint = add_paint(write_scattering())
    scattering_files.pack(paint.lumenray.measured)
    assert bpy.ops.lumenray.unpack_scattering_file() == {"FINISHED"}
    assert paint.lumenray.measured.text is None
    assert [path.name for path in tmp_path.iterdir()] == ["paint.lumbsdf"]
    scattering_files.pack(paint.lumenray.measured)
    assert bpy.ops.lumenray.unpack_scattering_file(directory=str(tmp_path / "there")) == {
        "FINISHED"
    }
    assert (tmp_path / "there" / "paint.lumbsdf").exists()
    scattering_files.pack(paint.lumenray.measured)
    Path(scattering_files.absolute_path(paint.lumenray.measured)).unlink()
    with pytest.raises(RuntimeError, match="save the Blender file first"):
        bpy.ops.lumenray.unpack_scattering_file()
    assert paint.lumenray.measured.text is not None


def test_unpacking_overwrites_nothing(write_scattering, tmp_path):
    paint = add_paint(write_scattering())
    scattering_files.pack(paint.lumenray.measured)
    other = tmp_path / "there" / "paint.lumbsdf"
    other.parent.mkdir()
    other.write_bytes(b"somebody's")
    scattering_files.unpack(paint.lumenray.measured, str(other.parent))
    assert other.read_bytes() == b"somebody's"
    assert (other.parent / "paint_2.lumbsdf").exists()


def test_a_file_of_another_format_is_embedded_in_ours_and_keeps_its_name(
    write_scattering, monkeypatch, tmp_path
):
    made = resample(lambert(0.3), [550.0], incidences=INCIDENCES)
    foreign = tmp_path / "lab.astm"
    foreign.write_text(ASTM)
    read = reader.parse_scattering

    def parse(data, path, wish):
        if data.startswith(b"ASTM"):
            return ScatteringFile(Path(path), "ASTM E1392", {"front_reflection": made})
        return read(data, path, wish)

    monkeypatch.setattr("lumenray.engine.scattering.readers.reader.parse_scattering", parse)
    paint = add_paint(str(foreign))
    scattering_files.pack(paint.lumenray.measured)
    text = paint.lumenray.measured.text
    assert text.name == "lab.astm"
    assert "ASTM E1392" in text.lines[0].body
    reading = scattering_files.obtain(paint.lumenray.measured)
    assert reading.file.format == "ASTM E1392"
    np.testing.assert_allclose(
        reading.file.sides["front_reflection"].values, made.values, rtol=1e-3
    )
    scattering_files.unpack(paint.lumenray.measured, str(tmp_path / "there"))
    assert scattering_files.name_of(paint.lumenray.measured) == "lab.lumbsdf"


def test_one_content_is_one_text_and_copies_share_it(write_scattering, tmp_path):
    first, second = add_paint(write_scattering()), add_paint(write_scattering("other.lumbsdf"))
    third = add_paint(write_scattering("third.lumbsdf", front_reflection=matt(0.4)))
    for paint in (first, second, third):
        scattering_files.pack(paint.lumenray.measured)
    text = first.lumenray.measured.text
    assert second.lumenray.measured.text == text != third.lumenray.measured.text
    copied = first.copy()
    assert copied.lumenray.measured.text == text
    assert text.users == 3
    surfaces = [converted_material(each)[0] for each in (first, second, copied)]
    assert len({id(surface.front_reflection) for surface in surfaces}) == 1


def test_a_saved_file_keeps_what_is_embedded(write_scattering, tmp_path):
    paint = add_paint(write_scattering())
    paint.lumenray.measured.rotation, paint.lumenray.measured.back = 0.5, "NONE"
    scattering_files.pack(paint.lumenray.measured)
    (tmp_path / "paint.lumbsdf").unlink()
    blend = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    scattering_files.detach()
    bpy.ops.wm.open_mainfile(filepath=blend)
    surface, rows = converted_material(bpy.data.materials["Paint"])
    assert isinstance(surface, Measured)
    assert (surface.rotation, surface.back_reflection) == (0.5, None)
    assert rows == []


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda lines: [lines[0], "A" + lines[1][1:], *lines[2:]], "changed since it was embedded"),
        (lambda lines: lines[:-1], "changed since it was embedded|no base64"),
        (lambda lines: [lines[0], "é!", *lines[1:]], "no base64"),
        (lambda lines: lines[1:], "no embedded scattering file"),
        (lambda _: [], "no embedded scattering file"),
    ],
)
def test_an_embedded_file_that_was_changed_is_refused(write_scattering, change, words):
    paint = add_paint(write_scattering())
    scattering_files.pack(paint.lumenray.measured)
    text = paint.lumenray.measured.text
    text.from_string("\n".join(change(text.as_string().split("\n"))))
    scattering_files.forget()
    with pytest.raises(FileFormatError, match=words):
        scattering_files.obtain(paint.lumenray.measured)
    surface, rows = converted_material(paint)
    assert surface == Diffuse(Constant(0.5))
    assert len(error_messages(rows)) == 1
    # The right content is not taken for it, and makes another text.
    other = add_paint(write_scattering())
    scattering_files.pack(other.lumenray.measured)
    assert other.lumenray.measured.text != text
    assert isinstance(converted_material(other)[0], Measured)


def test_another_path_takes_the_embedded_files_place(write_scattering):
    paint = add_paint(write_scattering())
    scattering_files.pack(paint.lumenray.measured)
    paint.lumenray.measured.filepath = write_scattering("dark.lumbsdf", front_reflection=matt(0.1))
    assert paint.lumenray.measured.text is None
    assert converted_material(paint)[0].front_reflection.values.max() == pytest.approx(
        0.1 / np.pi, rel=1e-3
    )


def test_reloading_reads_the_path_and_embeds_again(write_scattering):
    paint = add_paint(write_scattering())
    scattering_files.pack(paint.lumenray.measured)
    before = paint.lumenray.measured.text
    path = write_scattering(front_reflection=matt(0.1))
    assert bpy.ops.lumenray.reload_scattering_file() == {"FINISHED"}
    assert paint.lumenray.measured.text not in {None, before}
    assert converted_material(paint)[0].front_reflection.values.max() == pytest.approx(
        0.1 / np.pi, rel=1e-3
    )
    assert paint.diffuse_color[0] == pytest.approx(0.1, abs=1e-3)
    Path(path).unlink()
    kept = paint.lumenray.measured.text
    with pytest.raises(RuntimeError, match="cannot be opened"):
        bpy.ops.lumenray.reload_scattering_file()
    assert paint.lumenray.measured.text == kept


def test_a_file_that_is_refused_leaves_the_material_as_it_was(write_scattering, tmp_path):
    bad = tmp_path / "bad.bsdf"
    bad.write_bytes(b"nothing of the kind")
    paint = add_paint()
    with pytest.raises(RuntimeError, match=r"bad\.bsdf"):
        bpy.ops.lumenray.load_scattering_file(filepath=str(bad))
    assert not paint.lumenray.use_override
    assert paint.lumenray.measured.filepath == ""
    bpy.ops.lumenray.load_scattering_file(filepath=write_scattering())
    bpy.ops.lumenray.pack_scattering_file()
    text = paint.lumenray.measured.text
    with pytest.raises(RuntimeError, match=r"bad\.bsdf"):
        bpy.ops.lumenray.load_scattering_file(filepath=str(bad))
    assert paint.lumenray.measured.text == text
    assert isinstance(converted_material(paint)[0], Measured)


def test_opening_and_embedding_can_be_undone(write_scattering):
    add_paint()
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.lumenray.load_scattering_file(filepath=write_scattering())
    bpy.ops.ed.undo_push(message="opened")
    bpy.ops.lumenray.pack_scattering_file()
    bpy.ops.ed.undo_push(message="embedded")
    bpy.ops.ed.undo()
    paint = bpy.data.materials["Paint"]
    assert paint.lumenray.measured.text is None
    assert isinstance(converted_material(paint)[0], Measured)
    bpy.ops.ed.undo()
    assert not bpy.data.materials["Paint"].lumenray.use_override


def test_operators_need_a_material_of_their_own():
    assert not bpy.ops.lumenray.load_scattering_file.poll()
    add_paint()
    assert bpy.ops.lumenray.load_scattering_file.poll()
    assert not bpy.ops.lumenray.reload_scattering_file.poll()
    assert not bpy.ops.lumenray.fit_scattering_look.poll()
