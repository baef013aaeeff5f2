"""Measured materials in Blender: files, settings, what becomes of them in the engine, their look and their panels."""

import threading
import time
from dataclasses import replace
from pathlib import Path

import bpy
import lumenray
import numpy as np
import pytest
from lumenray.blender_addon.foundation.report import ConversionReport, Severity
from lumenray.blender_addon.scattering import files, look_nodes, source
from lumenray.blender_addon.scattering import preview as scattering_pictures
from lumenray.blender_addon.scattering import readout as scattering_readout
from lumenray.blender_addon.sync.materials.materials import convert_material
from lumenray.blender_addon.sync.materials.overrides import convert_override
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.errors import FileFormatError, LumenrayError
from lumenray.engine.scattering.data import store
from lumenray.engine.scattering.data.record import ScatteringFile
from lumenray.engine.scattering.data.resampling import resample
from lumenray.engine.scattering.look import Look
from lumenray.engine.scene.material import Diffuse, Measured
from lumenray.engine.scene.scattering import ScatterTable
from lumenray.engine.scene.scene import Scene
from lumenray.engine.scene.spectrum import Constant
from lumenray.libraries import materials as library
from panels import context, draw, interface
from scattering_models import ggx, lambert, schlick

INCIDENCES = np.radians([0.0, 30.0, 60.0])

ASTM = """ASTM E1392 measurement
NUM_POINTS 4
"""


def matt(reflectance, wavelengths=(550.0,), rotations=(0.0,)):
    """A table of Lambert's law; ``reflectance`` a number or one for each wavelength."""
    shape = (len(rotations), 3, 2, 2, len(wavelengths))
    values = np.broadcast_to(np.asarray(reflectance, np.float32) / np.float32(np.pi), shape).copy()
    return ScatterTable(
        np.asarray(rotations, float),
        INCIDENCES,
        np.array([0.0, np.pi]),
        np.array([0.0, np.pi]),
        np.asarray(wavelengths, float),
        values,
    )


@pytest.fixture(autouse=True)
def _operators(registered):
    lumenray.register()
    yield
    files.detach()


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a scattering file and returns its path."""

    def save(name="paint.lumbsdf", **sides):
        path = tmp_path / name
        sides = sides or {"front_reflection": matt(0.5)}
        store.write_store(path, ScatteringFile(path, "test", sides, name="Paint", source="made"))
        return str(path)

    return save


def add_paint(path="", name="Paint"):
    """Return a new material that is the active one of an object; with a path, a measured one."""
    material = bpy.data.materials.new(name)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0)], [], [(0, 1, 2)])
    mesh.materials.append(material)
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    if path:
        material.lumenray.use_override, material.lumenray.model = True, "MEASURED"
        material.lumenray.measured.filepath = path
    return material


def convert(material):
    """Return the engine's surface and the rows of the report."""
    report = ConversionReport()
    return convert_material(material, "key", report, 177.83).surface, [
        row for row, _ in report.rows
    ]


def errors(rows):
    return [row.message for row in rows if row.severity is Severity.ERROR]


# ---- into the engine ----


def test_what_a_file_tells_of_one_side_both_do(write):
    surface, rows = convert(add_paint(write()))
    assert isinstance(surface, Measured)
    assert surface.front_reflection is surface.back_reflection
    assert surface.front_transmission is surface.back_transmission is None
    np.testing.assert_allclose(surface.front_reflection.values, 0.5 / np.pi, rtol=1e-3)
    # The engine remembers what follows from arrays that cannot change.
    assert not surface.front_reflection.values.flags.writeable
    assert rows == []


def test_the_other_side_is_black_on_request(write):
    paint = add_paint(write())
    paint.lumenray.measured.back = "NONE"
    surface, _ = convert(paint)
    assert surface.front_reflection is not None
    assert surface.back_reflection is None
    paint.lumenray.measured.is_turned = True
    surface, _ = convert(paint)
    assert surface.front_reflection is None
    assert surface.back_reflection is not None


def test_a_sample_that_is_turned_over_shows_its_back(write):
    sides = {
        "front_reflection": matt(0.5),
        "back_reflection": matt(0.2),
        "front_transmission": matt(0.1),
    }
    paint = add_paint(write(**sides))
    paint.lumenray.measured.rotation = 0.7
    upright, _ = convert(paint)
    assert upright.rotation == pytest.approx(0.7)
    paint.lumenray.measured.is_turned = True
    turned, _ = convert(paint)
    assert turned.front_reflection is upright.back_reflection
    assert turned.back_reflection is upright.front_reflection
    assert turned.front_transmission is turned.back_transmission is upright.front_transmission


def test_materials_with_the_same_content_share_its_arrays(write, tmp_path):
    first = add_paint(write())
    copy = tmp_path / "copy.lumbsdf"
    copy.write_bytes(Path(write()).read_bytes())
    second = add_paint(str(copy))
    assert convert(first)[0].front_reflection is convert(second)[0].front_reflection


def test_a_file_that_changed_on_disk_is_read_anew(write):
    paint = add_paint(write())
    convert(paint)
    write(front_reflection=matt([0.25, 0.5], (450.0, 650.0)))
    assert len(convert(paint)[0].front_reflection.wavelengths) == 2


def test_what_cannot_be_read_is_grey_and_says_why(write, tmp_path):
    bad = tmp_path / "bad.bsdf"
    bad.write_bytes(b"nothing of the kind")
    damaged = tmp_path / "damaged.lumbsdf"
    damaged.write_bytes(Path(write()).read_bytes()[:-400])
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
        surface, rows = convert(paint)
        assert surface == Diffuse(Constant(0.5))
        (message,) = errors(rows)
        assert words in message
        assert "\n" not in message


def test_a_fault_of_ours_is_told_instead_of_raised(write, monkeypatch):
    def fail(*_):
        raise ZeroDivisionError("of ours")

    monkeypatch.setattr(files, "fit_look", fail)
    paint = add_paint(write())
    assert "ZeroDivisionError" in errors(convert(paint)[1])[0]
    with interface():
        seen = " ".join(draw("LUMENRAY_PT_measured", context(material=paint)))
    assert "ZeroDivisionError" in seen


def test_more_light_than_comes_is_told(write):
    sides = {"front_reflection": matt(0.9), "front_transmission": matt(0.3)}
    surface, rows = convert(add_paint(write(**sides)))
    assert isinstance(surface, Measured)
    assert any("120" in row.message for row in rows if row.severity is Severity.WARNING)


def test_a_large_error_of_the_table_is_told(write):
    _, rows = convert(add_paint(write(front_reflection=replace(matt(0.5), error=0.4))))
    assert any("40 % only" in row.message for row in rows if row.severity is Severity.WARNING)


def test_grain_needs_a_uv_map(write):
    _, rows = convert(add_paint(write(front_reflection=matt(0.5, rotations=(0.0, 1.0)))))
    assert any("UV map" in row.message for row in rows)


def test_the_library_lies_in_its_own_folder(write, tmp_path, monkeypatch):
    write("silk paint.lumbsdf")
    monkeypatch.setattr(source, "FOLDER", tmp_path)
    paint = add_paint(f"{library.PREFIX}silk paint")
    assert isinstance(convert(paint)[0], Measured)
    assert source.name_of(paint.lumenray.measured) == "silk paint"
    assert "library" in scattering_readout.state_of(paint.lumenray.measured).notice


def test_the_live_view_does_not_wait(write, monkeypatch):
    allowed, read, seen = threading.Event(), files.parse_scattering, []

    def slowly(*arguments):
        seen.append(arguments)
        allowed.wait(30.0)
        return read(*arguments)

    monkeypatch.setattr(files, "parse_scattering", slowly)
    paint = add_paint(write())
    report = ConversionReport()
    surface, _ = convert_override(paint.lumenray, report, "Paint", is_patient=False)
    assert surface == Diffuse(Constant(0.5))
    assert [row.severity for row, _ in report.rows] == [Severity.INFO]
    with interface():
        assert "Reading the file…" in draw("LUMENRAY_PT_measured", context(material=paint))
        assert draw("LUMENRAY_PT_measured_cuts", context(material=paint)) is None
    allowed.set()
    assert isinstance(convert(paint)[0], Measured)
    surface, _ = convert_override(paint.lumenray, report, "Paint", is_patient=False)
    assert isinstance(surface, Measured)
    assert len(seen) == 1


def test_live_sync_brings_the_material_when_it_is_ready(write, monkeypatch):
    allowed, read = threading.Event(), files.parse_scattering

    def slowly(*arguments):
        allowed.wait(30.0)
        return read(*arguments)

    monkeypatch.setattr(files, "parse_scattering", slowly)
    paint = add_paint(write())
    sync, scene = SceneSync(final=False), Scene()
    scene.apply(sync.walk(bpy.context.evaluated_depsgraph_get()).delta)
    (surface,) = [each.surface for each in scene.materials.values()]
    assert surface == Diffuse(Constant(0.5))
    allowed.set()
    files.obtain(paint.lumenray.measured)
    paint.update_tag()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    sync.tag(depsgraph.updates)
    scene.apply(sync.walk(depsgraph).delta)
    (surface,) = [each.surface for each in scene.materials.values()]
    assert isinstance(surface, Measured)


def test_materials_are_told_of_files_that_became_ready(write):
    paint = add_paint(write())
    look_nodes.show_when_ready(paint)
    with pytest.raises(files.NotReadyError):
        files.obtain(paint.lumenray.measured, is_patient=False)
    files.obtain(paint.lumenray.measured)
    told = []
    bpy.context.view_layer.update()
    bpy.app.handlers.depsgraph_update_post.append(
        lambda _, graph: told.extend(update.id.name for update in graph.updates)
    )
    try:
        while files._shelf.timer() is not None:
            time.sleep(0.01)
        bpy.context.view_layer.update()
    finally:
        bpy.app.handlers.depsgraph_update_post.pop()
    assert "Paint" in told
    assert tuple(paint.diffuse_color) == pytest.approx((0.5, 0.5, 0.5, 1.0), abs=1e-3)


def test_a_whole_scene_takes_a_measured_material(write):
    paint = add_paint(write())
    done = convert_scene(bpy.context.evaluated_depsgraph_get())
    (made,) = [
        item
        for item in done.delta.changed
        if getattr(item, "name", "") == paint.name and hasattr(item, "surface")
    ]
    assert isinstance(made.surface, Measured)


# ---- files ----


def test_open_embed_link_and_undo_nothing_of_the_content(write, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    path = write("silk.lumbsdf")
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
    assert files.digest_of(Path(path).read_bytes()) in head
    assert max(map(len, lines)) == 76
    content = Path(path).read_bytes()
    Path(path).unlink()
    assert isinstance(convert(paint)[0], Measured)
    assert bpy.ops.lumenray.unpack_scattering_file() == {"FINISHED"}
    written = Path(bpy.path.abspath(measured.filepath))
    assert written == tmp_path / "materials" / "silk.lumbsdf"
    assert written.read_bytes() == content
    assert measured.text is None
    assert isinstance(convert(paint)[0], Measured)


def test_a_file_whose_content_is_still_there_is_linked_again(write, tmp_path):
    paint = add_paint(write())
    files.pack(paint.lumenray.measured)
    assert bpy.ops.lumenray.unpack_scattering_file() == {"FINISHED"}
    assert paint.lumenray.measured.text is None
    assert [path.name for path in tmp_path.iterdir()] == ["paint.lumbsdf"]
    files.pack(paint.lumenray.measured)
    assert bpy.ops.lumenray.unpack_scattering_file(directory=str(tmp_path / "there")) == {
        "FINISHED"
    }
    assert (tmp_path / "there" / "paint.lumbsdf").exists()
    files.pack(paint.lumenray.measured)
    Path(source.absolute_path(paint.lumenray.measured)).unlink()
    with pytest.raises(RuntimeError, match="save the Blender file first"):
        bpy.ops.lumenray.unpack_scattering_file()
    assert paint.lumenray.measured.text is not None


def test_unpacking_overwrites_nothing(write, tmp_path):
    paint = add_paint(write())
    files.pack(paint.lumenray.measured)
    other = tmp_path / "there" / "paint.lumbsdf"
    other.parent.mkdir()
    other.write_bytes(b"somebody's")
    files.unpack(paint.lumenray.measured, str(other.parent))
    assert other.read_bytes() == b"somebody's"
    assert (other.parent / "paint_2.lumbsdf").exists()


def test_a_file_of_another_format_is_embedded_in_ours_and_keeps_its_name(
    write, monkeypatch, tmp_path
):
    made = resample(lambert(0.3), [550.0], incidences=INCIDENCES)
    foreign = tmp_path / "lab.astm"
    foreign.write_text(ASTM)
    read = files.parse_scattering

    def parse(data, path, wish):
        if data.startswith(b"ASTM"):
            return ScatteringFile(Path(path), "ASTM E1392", {"front_reflection": made})
        return read(data, path, wish)

    monkeypatch.setattr(files, "parse_scattering", parse)
    paint = add_paint(str(foreign))
    files.pack(paint.lumenray.measured)
    text = paint.lumenray.measured.text
    assert text.name == "lab.astm"
    assert "ASTM E1392" in text.lines[0].body
    reading = files.obtain(paint.lumenray.measured)
    assert reading.file.format == "ASTM E1392"
    np.testing.assert_allclose(
        reading.file.sides["front_reflection"].values, made.values, rtol=1e-3
    )
    files.unpack(paint.lumenray.measured, str(tmp_path / "there"))
    assert source.name_of(paint.lumenray.measured) == "lab.lumbsdf"


def test_one_content_is_one_text_and_copies_share_it(write, tmp_path):
    first, second = add_paint(write()), add_paint(write("other.lumbsdf"))
    third = add_paint(write("third.lumbsdf", front_reflection=matt(0.4)))
    for paint in (first, second, third):
        files.pack(paint.lumenray.measured)
    text = first.lumenray.measured.text
    assert second.lumenray.measured.text == text != third.lumenray.measured.text
    copied = first.copy()
    assert copied.lumenray.measured.text == text
    assert text.users == 3
    surfaces = [convert(each)[0] for each in (first, second, copied)]
    assert len({id(surface.front_reflection) for surface in surfaces}) == 1


def test_a_saved_file_keeps_what_is_embedded(write, tmp_path):
    paint = add_paint(write())
    paint.lumenray.measured.rotation, paint.lumenray.measured.back = 0.5, "NONE"
    files.pack(paint.lumenray.measured)
    (tmp_path / "paint.lumbsdf").unlink()
    blend = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    files.detach()
    bpy.ops.wm.open_mainfile(filepath=blend)
    surface, rows = convert(bpy.data.materials["Paint"])
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
def test_an_embedded_file_that_was_changed_is_refused(write, change, words):
    paint = add_paint(write())
    files.pack(paint.lumenray.measured)
    text = paint.lumenray.measured.text
    text.from_string("\n".join(change(text.as_string().split("\n"))))
    files.forget()
    with pytest.raises(FileFormatError, match=words):
        files.obtain(paint.lumenray.measured)
    surface, rows = convert(paint)
    assert surface == Diffuse(Constant(0.5))
    assert len(errors(rows)) == 1
    # The right content is not taken for it, and makes another text.
    other = add_paint(write())
    files.pack(other.lumenray.measured)
    assert other.lumenray.measured.text != text
    assert isinstance(convert(other)[0], Measured)


def test_another_path_takes_the_embedded_files_place(write):
    paint = add_paint(write())
    files.pack(paint.lumenray.measured)
    paint.lumenray.measured.filepath = write("dark.lumbsdf", front_reflection=matt(0.1))
    assert paint.lumenray.measured.text is None
    assert convert(paint)[0].front_reflection.values.max() == pytest.approx(0.1 / np.pi, rel=1e-3)


def test_reloading_reads_the_path_and_embeds_again(write):
    paint = add_paint(write())
    files.pack(paint.lumenray.measured)
    before = paint.lumenray.measured.text
    path = write(front_reflection=matt(0.1))
    assert bpy.ops.lumenray.reload_scattering_file() == {"FINISHED"}
    assert paint.lumenray.measured.text not in {None, before}
    assert convert(paint)[0].front_reflection.values.max() == pytest.approx(0.1 / np.pi, rel=1e-3)
    assert paint.diffuse_color[0] == pytest.approx(0.1, abs=1e-3)
    Path(path).unlink()
    kept = paint.lumenray.measured.text
    with pytest.raises(RuntimeError, match="cannot be opened"):
        bpy.ops.lumenray.reload_scattering_file()
    assert paint.lumenray.measured.text == kept


def test_a_file_that_is_refused_leaves_the_material_as_it_was(write, tmp_path):
    bad = tmp_path / "bad.bsdf"
    bad.write_bytes(b"nothing of the kind")
    paint = add_paint()
    with pytest.raises(RuntimeError, match=r"bad\.bsdf"):
        bpy.ops.lumenray.load_scattering_file(filepath=str(bad))
    assert not paint.lumenray.use_override
    assert paint.lumenray.measured.filepath == ""
    bpy.ops.lumenray.load_scattering_file(filepath=write())
    bpy.ops.lumenray.pack_scattering_file()
    text = paint.lumenray.measured.text
    with pytest.raises(RuntimeError, match=r"bad\.bsdf"):
        bpy.ops.lumenray.load_scattering_file(filepath=str(bad))
    assert paint.lumenray.measured.text == text
    assert isinstance(convert(paint)[0], Measured)


def test_opening_and_embedding_can_be_undone(write):
    add_paint()
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.lumenray.load_scattering_file(filepath=write())
    bpy.ops.ed.undo_push(message="opened")
    bpy.ops.lumenray.pack_scattering_file()
    bpy.ops.ed.undo_push(message="embedded")
    bpy.ops.ed.undo()
    paint = bpy.data.materials["Paint"]
    assert paint.lumenray.measured.text is None
    assert isinstance(convert(paint)[0], Measured)
    bpy.ops.ed.undo()
    assert not bpy.data.materials["Paint"].lumenray.use_override


def test_operators_need_a_material_of_their_own():
    assert not bpy.ops.lumenray.load_scattering_file.poll()
    add_paint()
    assert bpy.ops.lumenray.load_scattering_file.poll()
    assert not bpy.ops.lumenray.reload_scattering_file.poll()
    assert not bpy.ops.lumenray.fit_scattering_look.poll()


# ---- look ----


def shader_of(material, engine="EEVEE"):
    """What an engine shows of a material."""
    return material.node_tree.get_output_node(engine).inputs["Surface"].links[0].from_node


def appearance_of(material):
    """Everything about a material that Blender itself draws by."""
    nodes = {
        node.name: [
            tuple(socket.default_value)
            if hasattr(socket.default_value, "__len__")
            else socket.default_value
            for socket in node.inputs
            if hasattr(socket, "default_value")
        ]
        for node in material.node_tree.nodes
    }
    links = {
        (link.from_node.name, link.to_node.name, link.to_socket.name)
        for link in material.node_tree.links
    }
    shown = {
        engine: material.node_tree.get_output_node(engine).name for engine in ("EEVEE", "CYCLES")
    }
    viewport = (tuple(material.diffuse_color), material.metallic, material.roughness)
    return nodes, links, shown, viewport


def glossy_file(write):
    made = resample(
        lambda wi, wo: lambert(0.3)(wi, wo) + ggx(0.09, schlick)(wi, wo),
        [550.0],
        incidences=np.radians([0.0, 8.0, 30.0, 60.0]),
    )
    return write(front_reflection=made)


def test_opening_a_file_gives_a_plain_material_its_look(write):
    paint = add_paint()
    bpy.ops.lumenray.load_scattering_file(filepath=glossy_file(write))
    inputs = shader_of(paint).inputs
    assert inputs["Roughness"].default_value == pytest.approx(0.3, abs=0.03)
    assert inputs["Base Color"].default_value[1] == pytest.approx(0.3 / 0.96, abs=0.02)
    assert inputs["IOR"].default_value == pytest.approx(1.5, abs=0.05)
    assert inputs["Metallic"].default_value == 0.0
    assert paint.roughness == pytest.approx(0.3, abs=0.03)
    assert paint.diffuse_color[1] == pytest.approx(0.3 / 0.96, abs=0.02)


def test_a_material_gets_its_own_nodes_and_values_back_when_the_override_is_off(write, tree):
    add_paint()
    paint = tree.material
    bpy.context.object.data.materials[0] = paint
    noise = tree.add("TexNoise")
    tree.surface(tree.add("BsdfPrincipled", Base_Color=noise.outputs["Color"], Roughness=0.9))
    # An output for one engine alone, and one that does not count.
    for target in ("CYCLES", "ALL"):
        tree.add("OutputMaterial").target = target
    paint.diffuse_color, paint.metallic, paint.roughness = (0.1, 0.2, 0.3, 1.0), 0.7, 0.6
    before = appearance_of(paint)
    bpy.ops.lumenray.load_scattering_file(filepath=glossy_file(write))
    assert bpy.ops.lumenray.fit_scattering_look() == {"FINISHED"}
    for engine in ("EEVEE", "CYCLES"):
        assert shader_of(paint, engine).inputs["Roughness"].default_value == pytest.approx(
            0.3, abs=0.03
        )
    assert paint.roughness == pytest.approx(0.3, abs=0.03)
    paint.lumenray.use_override = False
    assert appearance_of(paint) == before
    # And the look comes back with the override.
    paint.lumenray.use_override = True
    while files._shelf.timer() is not None:
        time.sleep(0.01)
    assert shader_of(paint).inputs["Roughness"].default_value == pytest.approx(0.3, abs=0.03)
    paint.lumenray.model = "DIFFUSE"
    assert appearance_of(paint) == before


def test_a_diffuser_gets_a_translucent_shader_and_loses_it_again():
    paint = add_paint()
    count = len(paint.node_tree.nodes)
    sheet = Look((0.4,) * 3, translucency=0.75, translucent_colour=(0.8,) * 3)
    for _ in range(2):
        look_nodes.show_look(paint, sheet)
    assert len(paint.node_tree.nodes) == count + 3
    mix = shader_of(paint)
    assert mix.inputs[0].default_value == 0.75
    assert [mix.inputs[k].links[0].from_node.bl_idname for k in (1, 2)] == [
        "ShaderNodeBsdfPrincipled",
        "ShaderNodeBsdfTranslucent",
    ]
    look_nodes.show_look(paint, Look((0.4,) * 3))
    assert shader_of(paint).bl_idname == "ShaderNodeBsdfPrincipled"
    assert len(paint.node_tree.nodes) == count + 1


def test_a_material_without_nodes_that_can_be_used_gets_some():
    paint = add_paint()
    if bpy.app.version < (5, 0, 0):
        paint.use_nodes = False
    else:
        paint.node_tree.nodes.clear()
    look_nodes.show_look(paint, Look((0.4,) * 3, roughness=0.2))
    assert shader_of(paint).bl_idname == "ShaderNodeBsdfPrincipled"
    look_nodes.hide_look(paint)
    if bpy.app.version < (5, 0, 0):
        assert not paint.use_nodes
    else:
        assert not paint.node_tree.nodes


# ---- panels ----


def lines_of(seen):
    """Values by the labels before them."""
    return dict(zip(seen, seen[1:], strict=False))


def test_panels_are_there_for_measured_materials_alone(write):
    with interface():
        paint = add_paint()
        where = context(material=paint)
        assert draw("LUMENRAY_PT_measured", where) is None
        paint.lumenray.use_override, paint.lumenray.model = True, "MEASURED"
        seen = draw("LUMENRAY_PT_measured", where)
        assert "lumenray.load_scattering_file" in seen
        assert "filepath" not in seen
        assert draw("LUMENRAY_PT_measured_cuts", where) is None
        assert "model" in draw("LUMENRAY_PT_material_override", where)


def test_panel_shows_the_figures_of_the_file(write):
    wavelengths = np.linspace(400.0, 700.0, 16)
    sides = {
        "front_reflection": matt(np.full(16, 0.4), wavelengths),
        "front_transmission": matt(np.full(16, 0.25), wavelengths),
    }
    paint = add_paint(write(**sides))
    files.obtain(paint.lumenray.measured)
    where = context(material=paint)
    with interface():
        seen = draw("LUMENRAY_PT_measured", where)
        told = lines_of(seen)
        assert told["Name"] == "Paint"
        assert told["Symmetry"] == "isotropic"
        assert told["Incidence"] == "0° to 60°, 3 angles"
        assert told["Wavelengths"] == "400 to 700 nm, 16 bands"
        assert told["Front Reflectance 8°"] == "40 %"
        assert told["Front Transmittance 8°"] == "25 %"
        assert told["Resampling Error"] == "none stated"
        assert {"back", "is_turned", "rotation", "tolerance"} <= set(seen)
        assert "lumenray.pack_scattering_file" in seen
        files.pack(paint.lumenray.measured)
        files.obtain(paint.lumenray.measured)
        assert "lumenray.unpack_scattering_file" in draw("LUMENRAY_PT_measured", where)
        colour = draw("LUMENRAY_PT_measured_colour", where)
        assert {"illuminant", "swatch"} <= set(colour)


def test_colour_is_that_under_the_chosen_illuminant(write):
    paint = add_paint(write(front_reflection=matt(0.1841865)))
    measured = paint.lumenray.measured
    reading = files.obtain(measured)
    told = dict(scattering_readout.describe_colour(reading, "A"))
    assert told["Y"] == "18.4 %"
    # CIE 15: the chromaticity of A; L* = 50 at Y = 18.42 %.
    assert told["x, y"] == "0.4476, 0.4074"
    assert told["L*, a*, b*"] == "50.0, 0.0, 0.0"
    for name in ("D65", "D50", "A", "LED-B3", "FL2", "FL11"):
        measured.illuminant = name
        # Grey is grey under any light.
        assert tuple(measured.swatch) == pytest.approx([0.1842] * 3, abs=2e-4)


def test_coloured_samples_change_with_the_light(write):
    steps = matt(np.where(np.arange(16) < 8, 0.05, 0.8), np.linspace(400.0, 700.0, 16))
    measured = add_paint(write(front_reflection=steps)).lumenray.measured
    reading = files.obtain(measured)
    values = {
        name: float(dict(scattering_readout.describe_colour(reading, name))["Y"].split()[0])
        for name in ("D65", "A")
    }
    # Red reflects more of lamp light.
    assert values["A"] > values["D65"] + 3.0
    assert measured.swatch[0] > 2.0 * measured.swatch[2]


def test_refused_file_says_what_is_wrong(tmp_path):
    bad = tmp_path / "bad.bsdf"
    bad.write_bytes(b"nothing of the kind")
    paint = add_paint(str(bad))
    with pytest.raises(LumenrayError):
        files.obtain(paint.lumenray.measured)
    with interface():
        said = " ".join(draw("LUMENRAY_PT_measured", context(material=paint)))
    assert "no scattering file of a known format" in " ".join(said.split())
    assert "plain grey" in said
    assert tuple(paint.lumenray.measured.swatch) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("kind", ["cuts", "totals"])
def test_pictures_become_icons(write, kind):
    paint = add_paint(write())
    reading = files.obtain(paint.lumenray.measured)
    scattering_pictures.close()
    with interface():
        where = context(material=paint)
        assert "Drawing the picture…" in draw(f"LUMENRAY_PT_measured_{kind}", where)
        made = scattering_pictures.pictures
        end = time.monotonic() + 30.0
        while made.timer() is not None:
            assert time.monotonic() < end
            time.sleep(0.01)
        # Without a window icons have no numbers, so they are looked for by name.
        (name,) = made._icons
        assert name.startswith(f"{reading.digest} {kind} ")
        assert draw(f"LUMENRAY_PT_measured_{kind}", where)
        assert not made._drawing
        made.close()


def test_pictures_of_a_file_of_the_back_show_the_back(write):
    reading = files.obtain(add_paint(write(back_reflection=matt(0.5))).lumenray.measured)
    for kind in scattering_pictures.DRAWN:
        dark = scattering_pictures._draw(reading, kind, 256, True)
        assert dark.shape == (256, 256, 4)
        assert np.median(dark[..., :3]) < 0.3
        light = scattering_pictures._draw(reading, kind, 256, False)
        assert np.median(light[..., :3]) > 0.9
        # Blue is the curve's: paper and grid have none.
        assert (np.ptp(light[..., :3], axis=2) > 0.3).sum() > 100
