"""Files that are there: no command writes over one that it was told the name of, unless it is told to."""

import argparse

import pytest

from lumenray.command_line import bake as bake_command
from lumenray.command_line.main import build_parser, main
from lumenray.libraries import scenes

pytestmark = pytest.mark.usefixtures("empty_file")

BOX = str(scenes.scene_path("closed_box"))

# Command, and what it would write. What it reads is not there, so that it fails once it may write.
COMMANDS = [
    ("render none.blend -o a.exr", "a.exr a.png a.json a_spectral.exr"),
    ("measure none.blend --sensors in.csv -o out.csv", "out.csv"),
    ("observe none.blend --observers in.csv -o out.csv", "out.csv"),
    ("sensitivity none.blend --sensors in.csv -o out.json", "out.json"),
    ("luminaire plot none.ies -o a.png", "a.png"),
    ("luminaire convert none.ies a.ldt", "a.ldt"),
    ("rayset plot none.ray -o a.png", "a.png"),
    ("rayset reduce none.ray a.ies", "a.ies"),
    ("rayset convert none.ray a.dat", "a.dat"),
    ("brdf plot none.xml -o a.png", "a.png"),
    ("brdf convert none.xml a.lumbsdf", "a.lumbsdf"),
    ("brdf process none.csv a.lumbsdf --report a.png", "a.lumbsdf a.png"),
    ("brdf library none --sheet a.png", "a.png"),
    ("spectrum plot none.spdx -o a.png", "a.png"),
    ("sky plot --weather none.epw --time 2026-06-21T12:00 -o a.png", "a.png"),
    ("benchmark luminaires --files none -o docs --json a.json", "docs/luminaires.md a.json"),
    ("validate --family none -o docs", "docs/validation.json"),
]

BAKES = "lux/illuminance.1001.exr lux/illuminance_Ceiling.1001.exr lux/report.json lux/bake.checkpoint room.glb room.blend"


def place(folder, name):
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text("precious")
    return path


def each(table):
    return [(command, name) for command, names in table for name in names.split()]


@pytest.mark.parametrize(("command", "name"), each(COMMANDS))
def test_a_file_is_replaced_only_by_force(tmp_path, monkeypatch, capsys, command, name):
    monkeypatch.chdir(tmp_path)
    path = place(tmp_path, name)
    assert main(command.split()) == 1
    said = capsys.readouterr().err
    assert said == f"lumenray: {name}: is there already; --force replaces it\n"
    assert main([*command.split(), "--force"]) == 1
    said = capsys.readouterr().err
    assert "is there already" not in said
    assert len(said.splitlines()) == 1
    assert path.read_text() == "precious"


@pytest.mark.parametrize("name", BAKES.split())
def test_a_bake_replaces_results_only_by_force_or_where_it_goes_on(
    tmp_path, monkeypatch, capsys, name
):
    monkeypatch.chdir(tmp_path)
    path = place(tmp_path, name)
    command = ["bake", BOX, "-o", "lux", "--gltf", "room.glb", "--save", "room.blend"]
    assert main(command) == 1
    assert f"lumenray: {name}: is there already; --force replaces it" in capsys.readouterr().err
    for agreed in ("--force", "--resume"):
        bake_command.check_files(build_parser().parse_args([*command, agreed]))
    assert path.read_text() == "precious"


def test_a_file_is_not_taken_for_the_folder_of_a_bake(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    place(tmp_path, "lux")
    assert main(["bake", BOX, "-o", "lux", "--force"]) == 1
    said = capsys.readouterr().err
    assert said == "lumenray: lux: is a file, expected a folder to write into\n"


@pytest.mark.parametrize("name", ["office.exr", "report.json"])
def test_the_demo_replaces_results_only_by_force(tmp_path, monkeypatch, capsys, name):
    monkeypatch.chdir(tmp_path)
    path = place(tmp_path, f"shown/{name}")
    assert main(["demo", "-o", "shown"]) == 1
    assert f"lumenray: shown/{name}: is there already" in capsys.readouterr().err
    assert path.read_text() == "precious"


@pytest.mark.parametrize("command", [command for command, _ in COMMANDS if " -o a" in command])
def test_a_folder_is_not_taken_for_a_file(tmp_path, monkeypatch, capsys, command):
    monkeypatch.chdir(tmp_path)
    assert main([*command.split(), "-o", "."]) == 1
    assert capsys.readouterr().err == "lumenray: .: is a folder, expected the name of a file to write\n"  # fmt: skip


def test_every_command_that_is_told_where_to_write_may_be_forced():
    def written(parser):
        names = {"output", "report", "sheet", "gltf", "save"}
        return any(action.dest in names and action.nargs is None for action in parser._actions)

    def commands(parser, words=()):
        subs = [a for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
        if not subs:
            yield " ".join(words), parser
        for name, below in [pair for sub in subs for pair in sub.choices.items()]:
            yield from commands(below, (*words, name))

    found = {words: parser for words, parser in commands(build_parser()) if written(parser)}
    assert {"render", "bake", "measure", "demo", "brdf library", "benchmark atlas"} <= set(found)
    assert [words for words, parser in found.items() if "--force" not in parser.format_help()] == []
