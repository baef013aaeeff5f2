"""Files that commands are told of by name, folder and pattern: all that read several take them alike."""

import json
import os
import sys
from pathlib import Path

import pytest

from lumenray.command_line import file_list
from lumenray.command_line.main import main

COMMANDS = [
    ("luminaire", "info", ".ies"),
    ("rayset", "info", ".ray"),
    ("rayset", "prepare", ".ray"),
    ("brdf", "info", ".bsdf"),
    ("brdf", "check", ".bsdf"),
    ("spectrum", "info", ".spdx"),
]

ENDINGS = (".ies", ".ldt")


def names(*found, endings=ENDINGS):
    """Names that were found, and those of what is wrong."""
    pairs = list(file_list.find_files([str(name) for name in found], endings))
    return [name for name, error in pairs if error is None], [str(e) for _, e in pairs if e]


@pytest.fixture
def tree(tmp_path):
    for name in ("b.IES", "deep/c.ies", "deep/er/a.ldt", "notes.txt", ".hidden.ies", ".git/x.ies"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("text")
    return tmp_path


def test_folders_are_searched_in_order_and_without_what_is_hidden(tree):
    good, bad = names(tree)
    assert good == [str(tree / name) for name in ("b.IES", "deep/c.ies", "deep/er/a.ldt")]
    assert not bad


@pytest.mark.parametrize(
    ("pattern", "found"),
    [
        ("*.IES", ["b.IES"]),
        ("**/*.ies", ["deep/c.ies"]),
        ("**/[ac].*", ["deep/c.ies", "deep/er/a.ldt"]),
        ("deep/**", ["deep/c.ies", "deep/er/a.ldt"]),
        # A shell would write the folder there.
        ("de*", ["deep/c.ies", "deep/er/a.ldt"]),
    ],
)
def test_patterns_stand_for_files_and_folders(tree, monkeypatch, pattern, found):
    assert names(tree / pattern)[0] == [str(tree / name) for name in found]
    monkeypatch.chdir(tree)
    assert names(pattern)[0] == found


def test_a_file_whose_name_looks_like_a_pattern_is_that_file(tree):
    (tree / "[ab].ies").write_text("text")
    assert names(tree / "[ab].ies")[0] == [str(tree / "[ab].ies")]


def test_links_that_go_round_are_not_followed(tree):
    (tree / "deep" / "up").symlink_to(tree)
    (tree / "deep" / "er" / "up").symlink_to(tree)
    (tree / "self.ies").symlink_to("self.ies")
    expected = [str(tree / name) for name in ("b.IES", "deep/c.ies", "deep/er/a.ldt")]
    assert names(tree)[0] == expected
    assert names(tree / "**" / "*")[0] == [*expected, str(tree / "notes.txt")]


def test_folders_may_lie_deeper_than_functions_may_call_each_other(tmp_path, monkeypatch):
    depth = sys.getrecursionlimit() + 100
    monkeypatch.chdir(tmp_path)
    for _ in range(depth):
        Path("d").mkdir()
        os.chdir("d")
    Path("lamp.ies").write_text("text")
    good, bad = names(tmp_path)
    Path("lamp.ies").unlink()
    for _ in range(depth):
        os.chdir("..")
        Path("d").rmdir()
    assert [Path(name).name for name in good] == ["lamp.ies"]
    assert not bad


def test_a_folder_with_too_much_in_it_is_refused(tree, monkeypatch):
    monkeypatch.setattr(file_list, "MOST_ENTRIES", 4)
    assert names(tree) == ([], [f"{tree}: holds more than 4 files and folders; name folders in it one by one"])  # fmt: skip


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may read everything")
def test_a_folder_that_cannot_be_read_leaves_the_others(tree):
    (tree / "deep").chmod(0)
    good, bad = names(tree)
    (tree / "deep").chmod(0o700)
    assert good == [str(tree / "b.IES")]
    assert "cannot be read (Permission denied)" in bad[0]


@pytest.mark.parametrize(("group", "task", "ending"), COMMANDS)
def test_every_refused_file_of_a_folder_is_one_line_and_the_code_says_so(
    capsys, tmp_path, group, task, ending
):
    for name in ("one", "two"):
        (tmp_path / f"{name}{ending}").write_text("this is nothing of the kind")
    (tmp_path / "picture.png").write_text("nor this")
    assert main([group, task, str(tmp_path), str(tmp_path / "none")]) == 1
    out, err = capsys.readouterr()
    assert not out
    lines = err.splitlines()
    assert len(lines) == 3
    for line, name in zip(lines, (f"one{ending}", f"two{ending}", "none"), strict=True):
        assert line.startswith(f"lumenray: {tmp_path / name}")
    assert main([group, task, "--json", str(tmp_path)]) == 1
    out, err = capsys.readouterr()
    rows = json.loads(out)
    assert [set(row) for row in rows] == [{"file", "error"}] * 2
    assert err.splitlines() == lines[:2]


@pytest.mark.parametrize(("group", "task", "ending"), COMMANDS)
def test_an_empty_folder_is_refused(capsys, tmp_path, group, task, ending):
    assert main([group, task, str(tmp_path)]) == 1
    out, err = capsys.readouterr()
    assert not out
    assert ending in err
    assert len(err.splitlines()) == 1
