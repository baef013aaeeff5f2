"""The report of an open file has what its sensors told, verdicts and luminaires; operator and command write it."""

import json

import bpy
import pytest
from kept_readings import measure, new_room, set_sliders
from panels import context, draw
from photometric_files import EVEN

from lumenray.blender_addon.rendering import lighting_scenes
from lumenray.blender_addon.reporting import gathering
from lumenray.blender_addon.sensors.readings import readings_of
from lumenray.command_line import main as command_line
from lumenray.engine.errors import SceneError
from lumenray.engine.judgement.verdict import State
from lumenray.engine.reporting.composition import compose
from lumenray.engine.reporting.html_file import to_html

pytestmark = pytest.mark.usefixtures("extension")

HOSTILE = "<img src=x onerror=alert(1)>"


def gather(**settings):
    bpy.context.view_layer.update()
    return gathering.gather(bpy.context.evaluated_depsgraph_get(), **settings)


@pytest.fixture
def room():
    empty = new_room(HOSTILE)
    measure()
    lighting_scenes.add(bpy.context.scene)
    set_sliders(Ceiling=0.5, Desk=0.0)
    lighting_scenes.add(bpy.context.scene, HOSTILE)
    return empty


def test_it_has_what_sensors_told_in_every_lighting_scene(room):
    report = gather(notes=("a note",), shortfalls=("not exact enough",), date="2026-01-31")
    readings = readings_of(room)
    for scene, chosen in zip(
        report.scenes, lighting_scenes.choose_all(bpy.context.scene), strict=True
    ):
        (area,) = scene.areas
        values, errors = readings.mixed(chosen.levels)
        assert (area.values == values).all()
        assert (area.errors == errors).all()
        assert area.plan is not None
        assert area.scene_hash == readings.scene_hash
    assert [scene.state for scene in report.scenes] == [State.MET, State.NOT_MET]
    assert report.remarks[0] == "goal: not exact enough"
    assert "note: a note" in report.remarks
    assert [(each.name, each.unit) for each in report.others] == [("Ceiling Lamp", "lm"), ("Desk Lamp", "lm")]  # fmt: skip
    raw = to_html(compose(report))
    assert "<img" not in raw
    assert raw.count("&lt;img src=x onerror=alert(1)&gt;") >= 4


def test_luminaires_have_numbers_diagram_and_glare(room, new_luminaire):
    new_luminaire(EVEN)
    report = gather()
    (sheet,) = report.luminaires
    assert report.schedule.count == 1
    assert sheet.diagram.size[0] > 400
    assert dict(sheet.facts)["Count"] == "1"
    assert (sheet.ugr is None) == bool(sheet.problem)


def test_what_is_out_of_date_or_not_measured_is_said(room):
    room.location.x = 3.0
    other = bpy.data.objects.new("Unmeasured", None)
    other.lumenray.sensor.is_sensor = True
    bpy.context.scene.collection.objects.link(other)
    report = gather()
    assert report.scenes[0].areas[0].changed
    assert f"sensors '{other.name}' have not been measured" in report.remarks
    assert "Out of date" in to_html(compose(report))
    for empty in (room, other):
        empty.lumenray.sensor.property_unset("kept")
    with pytest.raises(SceneError, match="no sensor of the scene has been measured"):
        gather()


def test_the_operator_writes_it_and_the_panel_shows_what_is_missing(room, tmp_path):
    settings = bpy.context.scene.lumenray.report
    with pytest.raises(RuntimeError, match="save that first"):
        bpy.ops.lumenray.write_report()
    settings.filepath = str(tmp_path / "out.txt")
    with pytest.raises(RuntimeError, match=r"ends in \.html"):
        bpy.ops.lumenray.write_report()
    settings.filepath, settings.title = str(tmp_path / "out.html"), "Town Hall"
    assert "lumenray.write_report" in draw(
        "LUMENRAY_PT_client_report", context(scene=bpy.context.scene)
    )
    assert bpy.ops.lumenray.write_report() == {"FINISHED"}
    kept = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))
    assert kept["title"] == "Town Hall"
    assert any(gathering.KEPT in remark for remark in kept["remarks"])
    assert "Town Hall" in (tmp_path / "out.html").read_text(encoding="utf-8")
    assert (tmp_path / "out.csv").exists()
    assert draw("LUMENRAY_PT_lighting_scenes_sidebar", context(scene=bpy.context.scene))


def test_the_command_tells_what_a_file_has_kept(room, tmp_path, capsys):
    pytest.importorskip("reportlab")
    blend, out = tmp_path / "room.blend", tmp_path / "room.html"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    more = ["--pdf", str(tmp_path / "room.pdf"), "--title", "Office", "--maintenance", "80%"]
    assert command_line.main(["report", str(blend), "-o", str(out), "--kept", *more]) == 0
    kept = json.loads(out.with_suffix(".json").read_text(encoding="utf-8"))
    assert kept["maintenance_factor"] == pytest.approx(0.8)
    # 600 lx times 0.8 are no 500 lx.
    assert [each["state"] for each in kept["lighting_scenes"]] == ["not met", "not met"]
    assert (tmp_path / "room.pdf").read_bytes().startswith(b"%PDF")
    assert "not met" in capsys.readouterr().out
    assert command_line.main(["report", str(blend), "-o", str(out), "--kept"]) == 1
    assert "is there already" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.mitsuba
def test_the_command_measures_and_renders(tmp_path):
    """Sensors over the floor of a closed box of one luminance, whose illuminance is known: pi L."""
    from lumenray.libraries import scenes

    bpy.ops.wm.open_mainfile(filepath=str(scenes.scene_path("closed_box")))
    empty = bpy.data.objects.new("Inside", None)
    empty.location = (0.1, 0.1, 0.0)
    empty.lumenray.sensor.is_sensor = True
    bpy.context.scene.collection.objects.link(empty)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "box.blend"))
    more = ["--samples", "64", "--size", "24x16", "--picture-samples", "2"]
    out = tmp_path / "box.html"
    assert command_line.main(["report", str(tmp_path / "box.blend"), "-o", str(out), *more]) == 0
    (area,) = json.loads(out.with_suffix(".json").read_text(encoding="utf-8"))["lighting_scenes"][0]["areas"]  # fmt: skip
    assert area["values"][0] > 0.0
    assert area["samples"] >= 64
    assert out.read_text(encoding="utf-8").count("data:image/png;base64,") >= 2


@pytest.mark.mitsuba
@pytest.mark.slow
def test_measuring_takes_the_levels_of_a_lighting_scene(room, tmp_path, capsys):
    """A lamp 2 m over a grid, whose parts at once are half of one group and none of the other."""
    blend = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    mean = {}
    for name in ("Day", HOSTILE):
        out = tmp_path / f"{len(mean)}.json"
        more = ["--lighting-scene", name, "--samples", "64", "--no-witness"]
        assert command_line.main(["measure", str(blend), "-o", str(out), *more]) == 0
        mean[name] = json.loads(out.read_text(encoding="utf-8"))["sensors"][0]["mean"]
    # Two equal lamps at one place: half of one is a quarter of both.
    assert mean[HOSTILE] == pytest.approx(0.25 * mean["Day"], rel=1e-3)
    more = ["-o", str(tmp_path / "no.json"), "--lighting-scene", "Night"]
    assert command_line.main(["measure", str(blend), *more]) == 1
    assert "there is no lighting scene 'Night'" in capsys.readouterr().err
