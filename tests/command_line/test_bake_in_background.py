"""What bakes without a window say: on the terminal, in files and by their exit codes."""

import json
import re
from dataclasses import replace
from types import SimpleNamespace

import bpy
import pytest
from blender_objects import add_quad
from fake_bakes import SHORT, FakeSession, Interrupted, make_map, make_page, make_result

from lumenray.blender_addon import assumptions
from lumenray.blender_addon.bake import job as bake
from lumenray.blender_addon.foundation import engine_process
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.command_line import bake as bake_command
from lumenray.command_line import bake_table, demo, render
from lumenray.command_line import main as command_line
from lumenray.engine.accuracy.extremes import Extreme
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.files import write_report
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.scene.scene import Scene

pytestmark = pytest.mark.usefixtures("extension")


def add_sketch():
    """Add what the engine leaves out."""
    sketch = bpy.data.objects.new("Sketch", bpy.data.grease_pencils.new("Sketch"))
    bpy.context.scene.collection.objects.link(sketch)


def quad_mesh():
    """Return the quad as the engine has it."""
    from lumenray.blender_addon.sync.scene import convert_scene

    scene = Scene()
    scene.apply(convert_scene(bpy.context.evaluated_depsgraph_get()).delta)
    return scene.mesh(next(iter(scene.meshes)))


# ---- blender -b --python ----


def test_a_bake_without_a_window_prints_the_conversion_report(monkeypatch, tmp_path, capfd):
    monkeypatch.setattr(engine_process, "open_session", lambda *_: FakeSession())
    add_quad("Floor")
    add_sketch()
    bpy.ops.lumenray.bake_illuminance(objects="Floor", folder=str(tmp_path), error=0.05)
    said = capfd.readouterr().out
    assert re.search("error: Sketch: objects of type .* are not converted; left out", said)
    assert "goal:" not in said


@pytest.mark.parametrize("stopped", ["", SHORT])
def test_a_bake_without_a_window_prints_a_missed_goal(monkeypatch, tmp_path, capfd, stopped):
    session = FakeSession()
    real = session.bake_objects
    monkeypatch.setattr(session, "bake_objects", lambda *a: replace(real(*a), shortfall=stopped))
    monkeypatch.setattr(engine_process, "open_session", lambda *_: session)
    add_quad("Floor")
    bpy.ops.lumenray.bake_illuminance(objects="Floor", folder=str(tmp_path), error=0.01, time=9.0)
    said = capfd.readouterr().out
    missed = "the wanted relative standard error of 1 % was not reached, it is 2 %"
    assert f"goal: {stopped or missed}" in said


# ---- exit codes ----


@pytest.mark.parametrize(
    ("times", "has_fur", "code"),
    [(1, False, assumptions.UNREACHED), (1, True, assumptions.ASSUMED), (2, False, 1)],
)
def test_a_bake_that_ctrl_c_ends_has_the_code_of_what_it_leaves(
    monkeypatch, tmp_path, capsys, times, has_fur, code
):
    monkeypatch.setattr("lumenray.engine.session.Session", lambda: Interrupted(times))
    add_quad("Floor")
    if has_fur:
        add_sketch()
    file = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    assert command_line.main(["bake", str(file), "-o", str(tmp_path / "lux")]) == code
    said = capsys.readouterr()
    assert (f"goal: {SHORT}" in said.err) is (times == 1)
    assert ("written to" in said.out) is (times == 1)


def test_a_file_that_cannot_be_saved_leaves_the_maps_and_is_said(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("lumenray.engine.session.Session", FakeSession)
    add_quad("Floor")
    file, lost = tmp_path / "room.blend", tmp_path / "none" / "out.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    command = ["bake", str(file), "-o", str(tmp_path / "lux"), "--samples", "4"]
    assert command_line.main([*command, "--save", str(lost)]) == assumptions.ASSUMED
    said = capsys.readouterr()
    assert "the file is not saved" in said.err
    assert "Floor" in said.out


# ---- the demo ----


def test_the_demo_keeps_the_report_of_its_bake(monkeypatch, tmp_path, capsys):
    add_quad("Floor")
    order = BakeOrder(("x",), StopRule(error=0.01, seconds=60.0), file="office.blend")
    result = make_result([make_map(quad_mesh(), 0, 0, order)], [make_page(0)])
    result = replace(result, balance={"emitted": 1000.0})
    written = []

    def bake_open(options, _):
        settings = SimpleNamespace(folder=options.output)
        job = bake.BakeJob([], {}, settings, ConversionReport(), order, result)
        write_report(options.output, order, result, ())
        written.append((options.output / "report.json").read_bytes())
        return job

    monkeypatch.setattr(demo, "open_blend", lambda _: None)
    monkeypatch.setattr(render, "render_open", lambda *_: 0)
    monkeypatch.setattr(bake_command, "bake_open", bake_open)
    assert command_line.main(["demo", "-o", str(tmp_path)]) == 0
    assert [(tmp_path / "report.json").read_bytes()] == written
    content = json.loads(written[0])
    assert content["goal"]["reached"] is False
    assert content["energy"] == {"emitted": 1000.0}
    assert "atlas" in content
    assert "goal: the wanted relative standard error of 1 %" in capsys.readouterr().err


# ---- the table ----


def shown(capsys, **changes):
    """Print the table of one surface and return its cells."""
    made = make_map(quad_mesh(), 0, 0, BakeOrder(("x",), StopRule(samples=1)))
    bake_table.print_table([replace(made, **changes)])
    heading, line = capsys.readouterr().out.splitlines()
    # Right edges stand below each other.
    assert len(heading) == len(line)
    return re.split("  +", line)


def test_small_and_large_numbers_of_the_table_keep_their_digits(capsys):
    add_quad("Floor")
    weak = {
        "mean": 0.04,
        "mean_standard_error": 0.004,
        "least": Extreme(0.011, 0.008, 0.013),
        "largest": Extreme(0.07, 0.0, 5.0),
        "relative_standard_error": 0.0004,
    }
    assert shown(capsys, **weak) == [
        "Floor", "0.0400 ± 0.0040", "0.0110 (0.0080 to 0.0130)", "0.0700 (0.0000 to 5.0000)", "0.275 (0.183 to 0.349)",
        "0.04 %", "256",
    ]  # fmt: skip
    strong = {
        "mean": 12345.678,
        "mean_standard_error": 1.2,
        "least": Extreme(1234.56, 1234.5, 1234.7),
        "largest": Extreme(98765.0, 98000.0, 99000.0),
        "relative_standard_error": 1.5,
    }
    cells = shown(capsys, **strong)
    assert cells[1] == "12345.7 ± 1.2"
    assert cells[2] == "1234.56 (1234.50 to 1234.70)"
    assert cells[3] == "98765 (98000 to 99000)"
    assert cells[5] == "150 %"


def test_the_table_says_what_is_not_known(capsys):
    add_quad("Floor")
    unknown = Extreme(0.0, 0.0, float("inf"))
    cells = shown(
        capsys,
        mean=0.0,
        mean_standard_error=float("inf"),
        least=unknown,
        relative_standard_error=float("inf"),
    )
    assert cells[1] == "0 (error not known)"
    assert cells[2] == "0 (range not known)"
    assert cells[5] == "not known"


def test_names_of_a_file_say_nothing_to_the_terminal(capsys):
    add_quad("Floor")
    name = "Desk\x1b[2J\nA\u202eB"
    assert (
        shown(capsys, name=name)[0]
        == "Desk\N{REPLACEMENT CHARACTER}[2J A\N{REPLACEMENT CHARACTER}B"
    )
    made = make_map(quad_mesh(), 0, 0, BakeOrder(("x",), StopRule(samples=1)))
    bake_table.print_bake(make_result([replace(made, name=name)], [make_page(0)]))
    said = capsys.readouterr().out
    assert "\x1b" not in said
    assert "at most (Desk\N{REPLACEMENT CHARACTER}[2J A\N{REPLACEMENT CHARACTER}B)" in said
