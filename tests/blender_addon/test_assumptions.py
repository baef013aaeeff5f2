"""What a run on the command line assumed is refused, or stands beside its numbers."""

import csv
import json
import re

import bpy
import pytest

from lumenray.blender_addon import assumptions
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.command_line import main as command_line
from lumenray.tools.libraries.scenes import tiny

pytestmark = pytest.mark.usefixtures("extension")


@pytest.fixture
def box(tmp_path):
    """Return a function that saves the closed box as it stands, and a list of one sensor in it."""
    tiny.build_closed_box()
    sensors = tmp_path / "in.csv"
    sensors.write_text("x,y,z,nx,ny,nz\n0.5,0.5,0.1,0,0,1\n")

    def save():
        path = tmp_path / "room.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        return str(path)

    return save


def measure(path, folder, *options):
    return command_line.main(
        ["measure", path, "--sensors", str(folder / "in.csv"), "-o", str(folder / "out.csv"), "--force",
         *options]
    )  # fmt: skip


def environment(path):
    world = bpy.data.worlds.new("Surroundings")
    bpy.context.scene.world = world
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    output, background = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("OutputWorld", "Background")
    )
    picture = tree.nodes.new("ShaderNodeTexEnvironment")
    picture.image = bpy.data.images.load(str(path), check_existing=False)
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    tree.links.new(picture.outputs[0], background.inputs["Color"])


def lose_environment(folder):
    image = bpy.data.images.new("Sky", 4, 2)
    image.filepath_raw, image.file_format = str(folder / "sky.png"), "PNG"
    image.save()
    environment(folder / "sky.png")
    (folder / "sky.png").unlink()


def lose_luminaire(folder):
    light = next(data for data in bpy.data.lights)
    light.lumenray.luminaire.use_file = True
    light.lumenray.luminaire.filepath = str(folder / "none.ies")


def lose_rays(folder):
    light = next(data for data in bpy.data.lights)
    light.lumenray.rayset.use_file = True
    light.lumenray.rayset.filepath = str(folder / "none.ray")


def lose_scattering(folder):
    settings = bpy.data.objects["Floor"].active_material.lumenray
    settings.use_override, settings.model = True, "MEASURED"
    settings.measured.filepath = str(folder / "none.bsdf")


def lose_spectrum(folder):
    own = next(data for data in bpy.data.lights).lumenray
    own.use_physical, own.spectrum = True, "FILE"
    own.spectrum_file = str(folder / "none.spd")


@pytest.mark.parametrize(
    "lose", [lose_environment, lose_luminaire, lose_rays, lose_scattering, lose_spectrum]
)
def test_a_scene_that_lacks_a_file_is_refused_in_one_line(box, lose, tmp_path, capsys):
    lose(tmp_path)
    path = box()
    for command in (
        ["measure", path, "--sensors", str(tmp_path / "in.csv"), "-o", str(tmp_path / "out.csv")],
        ["render", path, "-o", str(tmp_path / "a.exr"), "--size", "8x8"],
        ["bake", path, "-o", str(tmp_path / "lux"), "--objects", "Floor", "--lumels-per-m", "2"],
    ):
        assert command_line.main([*command, "--samples", "4"]) == 1
        said = capsys.readouterr().err.strip()
        assert "--accept-missing" in said
        assert len(said.splitlines()) == 1
    assert not (tmp_path / "out.csv").exists()
    assert not (tmp_path / "a.exr").exists()


@pytest.mark.mitsuba
@pytest.mark.slow
def test_what_stands_for_an_accepted_missing_picture_is_beside_the_numbers(box, tmp_path, capsys):
    lose_environment(tmp_path)
    path = box()
    assert measure(path, tmp_path, "--samples", "16", "--accept-missing") == 0
    assert "sky.png" in capsys.readouterr().err
    lines = (tmp_path / "out.csv").read_text().splitlines()
    (told,) = (line for line in lines if "sky.png" in line)
    assert told.startswith("# error: Surroundings")
    assert "uniform grey 0.5" in told
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert float(rows[0]["illuminance_lx"]) > 0.0
    out = tmp_path / "a.exr"
    command = ["render", path, "-o", str(out), "--size", "8x8", "--samples", "4"]
    assert command_line.main([*command, "--accept-missing"]) == 0
    (row,) = (
        row for row in json.loads(out.with_suffix(".json").read_text())["conversion"] if row["missing"]
    )  # fmt: skip
    assert "sky.png" in row["message"]


@pytest.mark.parametrize("values", ["0", "-1"])
def test_a_lamp_whose_spectrum_holds_no_light_never_shines_in_its_colour(
    box, values, tmp_path, capsys
):
    table = tmp_path / "dark.csv"
    table.write_text("".join(f"{nm},{values}\n" for nm in range(380, 790, 10)))
    for data in bpy.data.lights:
        data.lumenray.use_physical, data.lumenray.spectrum = True, "FILE"
        data.lumenray.spectrum_file = str(table)
    assert measure(box(), tmp_path, "--samples", "16") == 1
    assert "dark.csv" in capsys.readouterr().err
    from lumenray.blender_addon.sync.scene import convert_scene

    made = convert_scene(bpy.context.evaluated_depsgraph_get())
    assert not any(hasattr(item, "output") for item in made.delta.changed)


@pytest.mark.mitsuba
@pytest.mark.slow
def test_an_error_that_was_not_reached_in_time_is_said(box, tmp_path, capsys):
    path = box()
    assert measure(path, tmp_path, "--error", "1e-9", "--time", "0.2") == assumptions.UNREACHED
    words = "wanted relative standard error of 1e-07 % was not reached"
    assert words in capsys.readouterr().err
    assert words in (tmp_path / "out.csv").read_text().splitlines()[0]

    out = tmp_path / "a.exr"
    picture = ["render", path, "-o", str(out), "--size", "8x8", "--force"]
    code = command_line.main([*picture, "--error", "1e-9", "--samples", "4"])
    assert code == assumptions.UNREACHED
    assert words in capsys.readouterr().err
    goal = json.loads(out.with_suffix(".json").read_text())["goal"]
    assert not goal["reached"]
    assert words in goal["shortfall"]
    assert command_line.main([*picture, "--error", "0.9", "--samples", "64"]) == 0
    assert json.loads(out.with_suffix(".json").read_text())["goal"]["reached"]

    lux = ["bake", path, "-o", str(tmp_path / "lux"), "--objects", "Floor", "--lumels-per-m", "2"]
    code = command_line.main([*lux, "--error", "1e-9", "--samples", "8"])
    assert code == assumptions.UNREACHED
    assert words in capsys.readouterr().err
    made = json.loads((tmp_path / "lux" / "report.json").read_text())
    assert words in made["goal"]["shortfall"]
    assert any(words in row["message"] for row in made["conversion"])
    table = (tmp_path / "lux" / "report.csv").read_text()
    assert words in table.splitlines()[0]
    # What a bake notes in its report as well is not said twice.
    assert table.count(words) == 1


@pytest.mark.mitsuba
def test_a_sensor_list_says_when_single_values_fall_short(box, tmp_path, capsys):
    assert measure(box(), tmp_path, "--each", "1e-9", "--time", "0.2") == assumptions.UNREACHED
    assert "error of every value" in capsys.readouterr().err


def unlight_but(name):
    """Let the lamp of the box light one object only, which the engine does not do."""
    lamp = next(item for item in bpy.data.objects if item.type == "LIGHT")
    chosen = bpy.data.collections.new("Lit")
    chosen.objects.link(bpy.data.objects[name])
    lamp.light_linking.receiver_collection = chosen


@pytest.mark.mitsuba
@pytest.mark.parametrize("lose", [None, lose_environment])
@pytest.mark.slow
def test_what_was_left_out_of_the_scene_has_an_exit_code_of_its_own(box, lose, tmp_path, capsys):
    unlight_but("Floor")
    if lose is not None:
        # That is agreed to, the linking is not.
        lose(tmp_path)
    path, lux = box(), tmp_path / "lux"
    for command in (
        ["measure", path, "--sensors", str(tmp_path / "in.csv"), "-o", str(tmp_path / "out.csv")],
        ["render", path, "-o", str(tmp_path / "a.exr"), "--size", "8x8"],
        ["bake", path, "-o", str(lux), "--objects", "Floor", "--lumels-per-m", "2", "--no-witness"],
    ):
        code = command_line.main([*command, "--samples", "4", "--accept-missing"])
        assert code == assumptions.ASSUMED == 4, command[0]
        assert "light linking" in capsys.readouterr().err
    for table in (tmp_path / "out.csv", lux / "report.csv"):
        heads = [line for line in table.read_text().splitlines() if line.startswith("#")]
        assert any(line.startswith("# error: Point: light linking") for line in heads)
        assert any("sky.png" in line for line in heads) is (lose is not None)
    for report in (tmp_path / "a.json", lux / "report.json"):
        rows = json.loads(report.read_text())["conversion"]
        assert any("light linking" in row["message"] for row in rows)


@pytest.mark.mitsuba
def test_a_volume_that_scatters_is_refused_for_lux_and_told_of_pictures(box, tmp_path, capsys):
    data = bpy.data.volumes.new("Smoke")
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Smoke", data))
    path = box()
    for command in (
        ["measure", path, "--sensors", str(tmp_path / "in.csv"), "-o", str(tmp_path / "out.csv")],
        ["bake", path, "-o", str(tmp_path / "lux"), "--objects", "Floor", "--lumels-per-m", "2"],
    ):
        assert command_line.main([*command, "--samples", "4"]) == 1
        said = capsys.readouterr().err.strip()
        assert "Smoke" in said
        assert "illuminance cannot be computed beside such a volume" in said
    assert not (tmp_path / "out.csv").exists()
    picture = ["render", path, "-o", str(tmp_path / "a.exr"), "--size", "8x8", "--samples", "4"]
    assert command_line.main(picture) == assumptions.ASSUMED
    assert "Smoke" in capsys.readouterr().err
    rows = json.loads((tmp_path / "a.json").read_text())["conversion"]
    assert [row["severity"] for row in rows if row["object"] == "Smoke"] == ["error"]


def test_an_error_in_lux_is_reached_where_there_is_no_light(box, tmp_path, capsys):
    # Outside of the closed box.
    next(item for item in bpy.data.objects if item.type == "LIGHT").location.z = 5.0
    lux = tmp_path / "lux"
    command = ["bake", box(), "-o", str(lux), "--objects", "Floor", "--lumels-per-m", "2"]
    assert command_line.main([*command, "--error-lx", "1", "--samples", "64"]) == 0
    made = json.loads((lux / "report.json").read_text())
    assert made["atlas"]["mean"] == 0.0
    assert made["goal"] == {"reached": True, "shortfall": ""}
    said = capsys.readouterr()
    assert "nan" not in said.out
    assert "-0.0000 " not in said.out
    assert re.search(r"mean 0 lx, error not known \(\S+ lx\)", said.out)


def test_lines_beside_numbers_are_those_of_the_report(tmp_path):
    report = ConversionReport()
    report.warn("Lamp", "it is odd", "it is left as it is", "Emission")
    report.error("Wall", "it is gone", "nothing is there")
    report.error("Wall", "it is gone", "nothing is there")
    report.info("Floor", "it is plain", "it stays so")
    assert assumptions.lines_of(report, ["a line\nand another"], "fell short") == [
        "goal: fell short",
        "error: Wall: it is gone; nothing is there (2 times)",
        "warning: Lamp / Emission: it is odd; it is left as it is",
        "note: a line and another",
    ]


def test_help_documents_the_exit_codes(capsys):
    for command in ("measure", "render", "bake"):
        with pytest.raises(SystemExit):
            command_line.main([command, "--help"])
        said = capsys.readouterr().out
        assert f"{assumptions.UNREACHED}  the results are written" in said
        assert f"{assumptions.ASSUMED}  the results are written" in said
        assert "or Ctrl-C stopped a" in said


@pytest.fixture
def frame(tmp_path, monkeypatch):
    """Return a function that renders a frame as ``blender -b`` does, in this process."""
    from lumenray.blender_addon.foundation import engine_process
    from lumenray.engine.session import Session

    class Near(Session):
        def render(self, camera, settings, *_, **__):
            return super().render(camera, settings)

        def close(self):
            pass

    monkeypatch.setattr(engine_process, "open_session", lambda *_: Near())

    def render():
        scene = bpy.context.scene
        camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(camera)
        scene.camera = camera
        scene.render.engine = "LUMENRAY"
        scene.render.resolution_x = scene.render.resolution_y = 8
        scene.lumenray.render.samples = 4
        scene.render.filepath = str(tmp_path / "frame")
        bpy.ops.render.render(write_still=True)

    return render


@pytest.mark.mitsuba
def test_a_render_without_a_window_prints_the_conversion_report(box, frame, capfd):
    smoke = bpy.data.objects.new("Smoke", bpy.data.volumes.new("Smoke"))
    bpy.context.scene.collection.objects.link(smoke)
    frame()
    said = capfd.readouterr()
    assert "Smoke" in said.out
    assert "Traceback" not in said.err


@pytest.mark.mitsuba
def test_a_render_without_a_window_tells_a_missed_goal(box, frame, tmp_path, capfd, monkeypatch):
    from dataclasses import replace

    from lumenray.blender_addon.rendering import render_engine
    from lumenray.engine.accuracy.stopping import StopRule

    real = render_engine.view_settings
    rule = StopRule(error=1e-9, samples=4)
    monkeypatch.setattr(
        render_engine, "view_settings", lambda *scene: replace(real(*scene), rule=rule)
    )
    frame()
    words = "wanted relative standard error of 1e-07 % was not reached"
    assert words in capfd.readouterr().out
    (report,) = tmp_path.glob("frame*_report.json")
    goal = json.loads(report.read_text())["goal"]
    assert not goal["reached"]
    assert words in goal["shortfall"]
