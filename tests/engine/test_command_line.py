"""The command line as a whole: every command explains itself."""

import argparse

import pytest
from lumenray.command_line.main import build_parser


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
