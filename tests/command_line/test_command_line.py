"""The command line as a whole: every command explains itself."""

import argparse
import os
import subprocess
import sys
from pathlib import Path

import pytest

from lumenray.command_line.main import MODULES, build_parser, main
from lumenray.libraries import luminaires


def parsers(parser, words=()):
    """A parser and all below it, by the words that lead there."""
    yield " ".join(words), parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, below in action.choices.items():
                yield from parsers(below, (*words, name))


PARSERS = dict(parsers(build_parser()))


@pytest.mark.parametrize("words", PARSERS)
def test_help_is_printed(words):
    """A per cent sign that is not doubled breaks the help of the command, and of the one above it."""
    text = PARSERS[words].format_help()
    assert f"lumenray {words}".strip() in text


def test_commands_are_those_that_are_documented():
    assert {"render", "bake", "measure", "brdf info", "brdf library", "sensitivity"} <= set(PARSERS)


@pytest.mark.parametrize("name", MODULES)
def test_a_command_is_told_by_itself_as_among_all(name):
    own = dict(parsers(build_parser(name)))
    among = {words for words in PARSERS if words.split(" ")[0] == name}
    assert set(own) - {""} == among
    assert own[name].format_help() == PARSERS[name].format_help()


def test_a_command_loads_no_code_of_others():
    """Nobody who asks what a scene needs waits for readers, charts and colour."""
    code = (
        "import sys; from lumenray.command_line.main import build_parser; build_parser('explain'); "
        "print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = done.stdout.split()
    assert "lumenray.command_line.explain" in loaded
    others = (
        "raysets",
        "goniometry",
        "daylight",
        "analysis",
        "luminaires.formats",
        "scattering.readers",
    )
    ours = [f"lumenray.engine.{each}" for each in others]
    foreign = ["PIL", "contourpy", "bpy", "mitsuba", "scipy", "matplotlib"]
    assert not [name for name in loaded if name.startswith((*ours, *foreign))]


@pytest.mark.parametrize(
    "words",
    [["bake", "f.blend", "-o", "lux"], ["measure", "f.blend", "--sensors", "a.csv", "-o", "b.csv"]],
)
def test_the_second_witness_is_heard_unless_it_is_left_out(words):
    assert build_parser().parse_args(words).witness
    assert not build_parser().parse_args([*words, "--no-witness"]).witness


def test_the_version_is_told(capsys):
    from lumenray.engine import VERSION

    with pytest.raises(SystemExit, match="0"):
        build_parser().parse_args(["--version"])
    assert capsys.readouterr().out == f"lumenray {VERSION}\n"


SHARES = [
    ("render f.blend -o a.exr", "--error", "error"),
    ("bake f.blend -o lux", "--error", "error"),
    ("measure f.blend --sensors a.csv -o b.csv", "--error", "error"),
    ("measure f.blend --sensors a.csv -o b.csv", "--each", "each"),
    ("sensitivity f.blend --sensors a.csv", "--uncertainty", "uncertainty"),
    ("brdf info a.xml", "--tolerance", "tolerance"),
    ("brdf convert a.xml b.bsdf", "--tolerance", "tolerance"),
    ("validate", "--error", "error"),
]


@pytest.mark.parametrize(("command", "option", "name"), SHARES)
def test_shares_are_stated_in_per_cent_or_as_fractions(command, option, name):
    for text in ("2%", "2 %", "0.02"):
        made = build_parser().parse_args([*command.split(), option, text])
        assert getattr(made, name) == pytest.approx(0.02)


@pytest.mark.parametrize(("command", "option", "name"), SHARES)
@pytest.mark.parametrize("wrong", ["2", "0", "-1", "nan", "inf", "%", "x"])
def test_what_is_no_share_is_refused_in_one_line(capsys, command, option, name, wrong):
    """Who writes 2 may mean 2 % or all of it twice."""
    with pytest.raises(SystemExit, match="2"):
        main([*command.split(), option, wrong])
    said = capsys.readouterr()
    assert not said.out
    assert f"argument {option}: expected a share " in said.err
    assert f"such as 2% or 0.02, found '{wrong}'; " in said.err
    assert len(said.err.splitlines()) == 1


@pytest.mark.parametrize(
    "words",
    [
        "", "nonsense", "render", "render f.blend", "luminaire", "brdf info", "render f.blend -o a.exr --size 3x9",
        "render f.blend -o a.exr --size 100000x9", "render f.blend -o a.exr --seed -1", "spectrum info a --column 0",
        "render f.blend -o a.exr --samples 0", "render f.blend -o a.exr --time inf", "rayset reduce a b.ies --step 90",
        "measure f.blend --sensors a -o b --reflections -1", "rayset convert a b.dat --generate 1e9",
        "bake f.blend -o lux --margin 0", "bake f.blend -o lux --error-lx -3", "benchmark rooms --count 0",
        "luminaire plot a -o b.png --size 9000x900", "brdf plot a -o b.png --incidences 90",
    ],
)  # fmt: skip
def test_what_is_not_understood_is_refused_in_one_line_with_a_code_of_its_own(capsys, words):
    with pytest.raises(SystemExit, match="2"):
        main(words.split())
    said = capsys.readouterr()
    assert not said.out
    assert said.err.startswith("lumenray: ")
    assert "--help' tells more" in said.err
    assert len(said.err.splitlines()) == 1


LAMP = next(luminaires.FOLDER.rglob("*.ies"))

FULL = Path("/dev/full")

INFO = [sys.executable, "-m", "lumenray.command_line.main", "luminaire", "info"]


@pytest.mark.skipif(os.name != "posix", reason="pipes and devices are those of POSIX")
def test_a_reader_that_has_had_enough_ends_a_command_quietly(tmp_path):
    command = [*INFO, "--json", *[str(tmp_path / f"none{number}.ies") for number in range(2000)]]
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, text=True, check=False)
    os.close(write)
    assert done.returncode == 1
    assert all(line.endswith("(No such file or directory)") for line in done.stderr.splitlines())


@pytest.mark.skipif(not FULL.exists(), reason="there is no /dev/full")
def test_output_that_cannot_be_written_is_told_in_one_line():
    with FULL.open("w") as full:
        done = subprocess.run(
            [*INFO, str(LAMP)], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert done.returncode == 1
    assert done.stderr == "lumenray: the output cannot be used (No space left on device)\n"
