"""Files are written whole or not at all, and nothing is left beside them."""

import os
import sys

import pytest

from lumenray.engine.errors import FileFormatError
from lumenray.engine.reading import whole_file
from lumenray.engine.reading.whole_file import write_whole


def test_bytes_and_texts_arrive_as_they_are(tmp_path):
    path = tmp_path / "new" / "folder" / "a.bin"
    with write_whole(path, is_synced=True) as file:
        file.write(b"\r\n\0")
    assert path.read_bytes() == b"\r\n\0"
    with write_whole(str(path), "utf-8") as file:
        file.write("1 lx\nä\r\n")
    assert path.read_bytes() == b"1 lx\n\xc3\xa4\r\n"
    assert list(path.parent.iterdir()) == [path]


def test_the_old_file_is_there_until_the_new_one_is_whole(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("old")
    with write_whole(path, "utf-8") as file:
        file.write("new")
        file.flush()
        assert path.read_text() == "old"
        with write_whole(path, "utf-8") as other:
            other.write("another")
    assert path.read_text() == "new"


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_write_that_fails_leaves_the_old_file_alone(tmp_path, error):
    path = tmp_path / "a.csv"
    path.write_text("old")
    expected = FileFormatError if isinstance(error, OSError) else KeyboardInterrupt
    with pytest.raises(expected) as caught, write_whole(path) as file:
        file.write(b"half")
        raise error
    if expected is FileFormatError:
        assert str(caught.value) == f"{path}: cannot be written (No space left on device)"
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_so_does_one_that_cannot_take_the_place(tmp_path, monkeypatch):
    def fail(self, target):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(whole_file.Path, "replace", fail)
    with pytest.raises(FileFormatError, match="Input/output"), write_whole(tmp_path / "a") as file:
        file.write(b"all")
    assert list(tmp_path.iterdir()) == []


def test_places_where_no_file_can_be_are_told(tmp_path):
    (tmp_path / "file").write_text("")
    for path in (tmp_path / "file" / "a", tmp_path):
        with pytest.raises(FileFormatError, match="cannot be written"), write_whole(path) as file:
            file.write(b"x")


@pytest.mark.skipif(sys.platform == "win32", reason="modes and links of POSIX")
def test_modes_and_links_stay(tmp_path):
    path, link = tmp_path / "a", tmp_path / "link"
    umask = os.umask(0o027)
    try:
        with write_whole(path) as file:
            file.write(b"1")
        assert path.stat().st_mode & 0o777 == 0o640
        path.chmod(0o604)
        link.symlink_to(path)
        with write_whole(link) as file:
            file.write(b"2")
    finally:
        os.umask(umask)
    assert link.is_symlink()
    assert (path.read_bytes(), path.stat().st_mode & 0o777) == (b"2", 0o604)


@pytest.mark.skipif(sys.platform == "win32", reason="a device of POSIX")
def test_devices_are_written_to():
    with write_whole("/dev/null") as file:
        file.write(b"x")


def test_long_names_are_no_hindrance(tmp_path):
    path = tmp_path / f"{'n' * 250}.csv"
    with write_whole(path) as file:
        file.write(b"x")
    assert path.read_bytes() == b"x"
