"""What of a scene is modelled, asked for on the command line: told by explain, and heard by the engine of every command."""

import json

import bpy
import pytest
from blender_objects import add_quad, new_paint
from commands import run_command
from weather_files import sunny_year

from lumenray.engine import session as engine_session
from lumenray.engine.errors import SceneError
from lumenray.engine.requirements.plan import DECISIONS
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.scene import Scene

pytestmark = pytest.mark.usefixtures("extension")


OFF_WHITE = (0.8, 0.79, 0.77)


@pytest.fixture
def room(tmp_path):
    """A file with a floor of off-white paint under a lamp, and a camera; sensors in a list beside it."""
    path = tmp_path / "room.blend"
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene, paint = bpy.context.scene, new_paint()
    paint.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (*OFF_WHITE, 1.0)
    add_quad("Floor", material=paint)
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    for thing in (lamp, camera):
        thing.location = (0.5, 0.5, 2.0)
        scene.collection.objects.link(thing)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("World")
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    (tmp_path / "in.csv").write_text("x,y,z,nx,ny,nz\n0.5,0.5,0.1,0,0,1\n0.5,0.2,0.5,0,0,-1\n")
    return path


def explain(capsys, path, *more):
    code, said, errors = run_command("explain", capsys, path, "--json", *more)
    assert code == 0, errors
    return json.loads(said)


def choice_of(told, name):
    return next(each["choice"] for each in told["decisions"] if each["name"] == name)


def test_explain_tells_all_decisions_and_the_budget(room, capsys):
    told = explain(capsys, room, "--error", "3%")
    assert told["asked_error"] == 0.03
    assert [each["name"] for each in told["decisions"]] == list(DECISIONS)
    for each in told["decisions"]:
        assert {"name", "choice", "reason", "bound", "saving"} <= each.keys()
        assert each["choice"] and each["reason"]
        assert each["bound"] >= 0.0 and 0.0 <= each["saving"] < 1.0
    budget = told["budget"]
    spent = sum(each["bound"] for each in told["decisions"])
    assert budget["simplifications_at_most"] == pytest.approx(spent)
    assert 0.0 < spent <= budget["simplifications_allowed"] == pytest.approx(0.01)
    # Bound and samples together are the error that is asked for.
    assert budget["sampling"] ** 2 + spent**2 == pytest.approx(0.03**2)


def test_explain_is_read_by_people(room, capsys):
    code, said, _ = run_command("explain", capsys, room, "--error", "3%")
    assert code == 0
    lines = said.splitlines()
    assert lines[0] == str(room)
    row = next(line for line in lines if line.startswith("colours"))
    assert "photometric" in row and "at most" in row and "about 25 %" in row and "auto" in row
    assert lines[-1].startswith("budget: sampling ") and "(1 % allowed)" in lines[-1]
    assert max(map(len, lines[1:])) <= 125


@pytest.mark.parametrize("choice", ["off", "force"])
def test_a_decision_is_overruled_and_so_are_all(room, capsys, choice):
    name = next(iter(DECISIONS))
    told = explain(capsys, room, "--model", f"{name}={choice}")
    switches = {each["name"]: each["switch"] for each in told["decisions"]}
    assert switches == dict.fromkeys(DECISIONS, "auto") | {name: choice}
    told = explain(capsys, room, "--model", f"all={choice}", "--model", f"{name}=auto")
    switches = {each["name"]: each["switch"] for each in told["decisions"]}
    assert switches == dict.fromkeys(DECISIONS, choice) | {name: "auto"}


def test_switches_of_the_file_count_where_nothing_else_is_said(room, capsys):
    bpy.context.scene.lumenray.modelling.share = 0.1
    bpy.context.scene.lumenray.modelling.colours = "OFF"
    bpy.ops.wm.save_mainfile()
    # Blender tells of it.
    capsys.readouterr()
    told = explain(capsys, room)
    assert choice_of(told, "colours") == "spectral"
    assert told["budget"]["simplifications_allowed"] == pytest.approx(0.001)
    told = explain(capsys, room, "--model", "colours=force")
    assert choice_of(told, "colours") == "photometric"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("nothing=off", "there is no decision 'nothing', expected unseen"),
        ("colours=maybe", "'colours=maybe' is not understood"),
        ("colours", "'colours' is not understood"),
    ],
)
def test_what_is_no_decision_is_refused_in_one_sentence(room, capsys, words, said):
    try:
        code, _, errors = run_command("explain", capsys, room, "--model", words)
    except SystemExit as end:
        code, errors = end.code, capsys.readouterr().err
    assert code in (1, 2)
    assert said in errors


class Listening:
    """A session that hears a scene and computes nothing."""

    heard: list = []

    def __init__(self, *_, **__):
        self.scene = Scene()
        self.revision = 0

    def apply(self, delta):
        self.scene.apply(delta)

    def __getattr__(self, name):
        def refuse(*_, **__):
            self.heard.append(self.scene.modelling)
            raise SceneError("nothing is computed here")

        return refuse


COMMANDS = {
    "render": ["-o", "out.exr", "--size", "16x12"],
    "bake": ["-o", "lux"],
    "measure": ["--sensors", "in.csv", "-o", "out.csv"],
    "daylight": ["--weather", "year.epw", "--floor", "Floor", "-o", "year"],
    "observe": ["--observers", "in.csv", "-o", "out.csv"],
    "sensitivity": ["--sensors", "in.csv", "-o", "out.csv"],
    "goniometer": ["-o", "out.ldt"],
}
"""Commands about a file, with what they need besides."""


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_tells_the_engine(room, capsys, monkeypatch, command):
    monkeypatch.setattr(engine_session, "Session", Listening)
    monkeypatch.chdir(room.parent)
    (room.parent / "year.epw").write_text(sunny_year(), encoding="latin-1")
    Listening.heard = []
    code, _, errors = run_command(
        command, capsys, room, *COMMANDS[command], "--model", "colours=off"
    )
    assert (code, errors.strip().splitlines()[-1]) == (1, "lumenray: nothing is computed here")
    assert Listening.heard == [Modelling((("colours", Switch.OFF),))]


def test_sensors_of_the_file_are_measured_as_was_asked_for(room, capsys, monkeypatch):
    bpy.ops.lumenray.add_sensors(layout="POINT")
    bpy.ops.wm.save_mainfile()
    monkeypatch.setattr(engine_session, "Session", Listening)
    for command, more in (("measure", ["-o", "out.csv"]), ("report", ["-o", "out.html"])):
        Listening.heard = []
        out = [more[0], room.parent / more[1]]
        assert run_command(command, capsys, room, *out, "--model", "colours=force")[0] == 1
        assert Listening.heard == [Modelling((("colours", Switch.FORCE),))]


@pytest.mark.mitsuba
@pytest.mark.slow
def test_errors_say_how_much_of_them_is_simplified(room, tmp_path, capsys):
    """Off-white paint is modelled without wavelengths; what that may cost stands beside every error."""
    parts = "simplifications at most"
    bake = ["bake", capsys, room, "-o", tmp_path / "lux", "--error", "5%", "--lumels-per-m", "8"]
    saved = tmp_path / "saved.blend"
    code, said, _ = run_command(*bake, "--save", saved, "--model", "colours=force")
    # What is forced costs more than what is asked for, which the exit code tells.
    assert code == 3 and "the error is made of: sampling and the rest" in said and parts in said
    report = json.loads((tmp_path / "lux" / "report.json").read_text())
    assert 0.05 < report["simplifications_at_most"] < 0.5
    assert any("simplifications: at most" in line for line in report["decisions"])
    # The file keeps what it said, and knows what its lux maps are.
    bpy.ops.wm.open_mainfile(filepath=str(saved))
    assert bpy.context.scene.lumenray.modelling.colours == "AUTO"
    kept = bpy.context.scene.lumenray.baked
    assert kept.simplified == pytest.approx(report["simplifications_at_most"], rel=1e-5)
    measure = [
        "measure",
        capsys,
        room,
        "--sensors",
        tmp_path / "in.csv",
        "--error",
        "5%",
        "--force",
    ]
    _, said, _ = run_command(*measure, "-o", tmp_path / "out.csv")
    assert parts in said and parts in (tmp_path / "out.csv").read_text()
    _, said, _ = run_command(*measure, "-o", tmp_path / "out.csv", "--model", "all=off")
    assert parts not in said and parts not in (tmp_path / "out.csv").read_text()
