"""The command ``lumenray bake``: what it orders and says."""

import json
import signal

import bpy
import pytest
from blender_bakes import add_lamp
from blender_objects import add_quad
from fake_bakes import SIZE, FakeSession, Interrupted, make_page

from lumenray.blender_addon.assumptions import UNREACHED
from lumenray.command_line import main as command_line

pytestmark = pytest.mark.usefixtures("extension")


def test_the_command_line_orders_what_it_is_told(monkeypatch, tmp_path, capsys):
    fake_engine = FakeSession()
    from lumenray.engine import session

    monkeypatch.setattr(session, "Session", lambda: fake_engine)
    add_quad("Floor")
    add_lamp("Lamp", "Ceiling")
    file = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    code = command_line.main(
        ["bake", str(file), "-o", str(tmp_path / "lux"), "--lumels-per-m", "11", "--page-size", "256", "--most-pages", "2",
         "--margin", "3", "--error-lx", "4", "--time", "7", "--layers", "groups", "--exitance", "--denoise-exitance",
         "--method", "cells", "--caustics", "on", "--isolux-lines", "--arrays", "--save", str(tmp_path / "out.blend")]
    )  # fmt: skip
    # What the fake_engine one gives is less exact than that.
    assert code == UNREACHED
    order = fake_engine.order
    assert (order.density, order.largest, order.pages, order.margin) == (11.0, 256, 2, 3)
    assert (order.exitance, order.denoise, order.method, order.caustics) == (
        True,
        True,
        "cells",
        "on",
    )
    assert order.isolux
    assert order.arrays
    assert (order.rule.absolute, order.rule.seconds, order.rule.error) == (4.0, 7.0, None)
    assert [group.name for group in order.groups] == ["Ceiling"]
    said = capsys.readouterr().out
    assert "after 1.0 s the forecast was 12 s (-4.2 %)" in said
    assert "seams: 120 places" in said
    assert "0.1 ± 0.2 lx at most (Floor)" in said
    assert "density lowered to 80 %" in said
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    assert bpy.data.objects["Floor"].lumenray.baked_image.size[0] == SIZE
    assert "Lux atlas: Ceiling" in bpy.data.images


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--resume"], "no interrupted bake"),
        (["--gltf", "room.obj"], "glTF files end in"),
    ],
)
def test_wrong_orders_end_in_words(monkeypatch, tmp_path, capsys, options, words):
    add_quad("Floor")
    file = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    assert command_line.main(["bake", str(file), "-o", str(tmp_path / "lux"), *options]) == 1
    error = capsys.readouterr().err.strip()
    assert words in error
    assert len(error.splitlines()) == 1


pytestmark = pytest.mark.usefixtures("extension")


def saved_room(tmp_path):
    add_quad("Floor")
    file = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    return file


def test_ctrl_c_keeps_what_a_bake_has_and_says_so(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("lumenray.engine.session.Session", lambda: Interrupted(1))
    before = signal.getsignal(signal.SIGINT)
    code = command_line.main(["bake", str(saved_room(tmp_path)), "-o", str(tmp_path / "lux")])
    said = capsys.readouterr()
    assert code == 3
    assert "the results so far are kept" in said.err
    assert "stopped at an error of 0.16 %" in said.err
    assert "--resume" in said.err
    assert "Floor" in said.out
    assert signal.getsignal(signal.SIGINT) is before


def test_a_second_ctrl_c_cancels_and_says_what_is_left(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("lumenray.engine.session.Session", lambda: Interrupted(2))
    code = command_line.main(["bake", str(saved_room(tmp_path)), "-o", str(tmp_path / "lux")])
    said = capsys.readouterr()
    assert code == 1
    assert "nothing was written; --resume goes on" in said.err
    assert "Floor" not in said.out


def test_verdicts_on_maps_are_written_down(monkeypatch, tmp_path):
    monkeypatch.setattr("lumenray.engine.session.Session", FakeSession)
    given = ["bake", str(saved_room(tmp_path)), "-o", str(tmp_path / "lux")]
    command_line.main([*given, "--require", "office.writing", "--maintenance", "0.5"])
    told = json.loads((tmp_path / "lux" / "verdicts.json").read_text())
    (floor,) = told["areas"]
    assert (told["key"], floor["object"], floor["area"]) == ("office.writing", "Floor", "task")
    limits = {each["name"]: each for each in floor["limits"]}
    assert limits["mean"]["limit"] == 500.0
    assert limits["mean"]["value"] == pytest.approx(0.5 * float(make_page(0).illuminance.mean()))
    low, high = limits["mean"]["range"]
    assert low < limits["mean"]["value"] < high
    assert floor["state"] == "not met"
