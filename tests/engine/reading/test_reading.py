"""Files from outside: devices, pipes and files without end are refused in a sentence, and text cannot command a terminal."""

import contextlib
import os
import signal
import threading
from pathlib import Path

import numpy as np
import pytest

from lumenray.command_line import main as command_line
from lumenray.engine.errors import FileFormatError
from lumenray.engine.formats.checkpoint import read_checkpoint
from lumenray.engine.formats.data_sheet import read_data_sheet
from lumenray.engine.formats.sensors import read_sensors
from lumenray.engine.formats.spd import read_spectrum
from lumenray.engine.luminaires.formats.reader import read_luminaire
from lumenray.engine.raysets.reader import read_rayset
from lumenray.engine.reading.content import holds, read_bytes
from lumenray.engine.reading.lines import read_lines
from lumenray.engine.reading.printable import REPLACEMENT, printable
from lumenray.engine.reading.text import decode_text, find_encoding
from lumenray.engine.scattering.readers.reader import read_scattering
from lumenray.engine.sky.measured import read_measured_sky
from lumenray.engine.sky.weather_file import read_weather
from lumenray.libraries import luminaires, materials
from lumenray.libraries.luminaires.catalogue import LIST as LUMINAIRES
from lumenray.libraries.materials.catalogue import LIST as MATERIALS

READERS = (
    read_luminaire,
    read_measured_sky,
    read_rayset,
    read_scattering,
    read_spectrum,
    read_data_sheet,
    read_sensors,
    read_weather,
    read_checkpoint,
)

on_posix = pytest.mark.skipif(os.name != "posix", reason="devices and pipes are those of POSIX")


@contextlib.contextmanager
def within(seconds: float):
    """Raise TimeoutError in whatever waits or goes on for longer."""

    def stop(*_):
        raise TimeoutError(f"not done after {seconds} s")

    kept = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, kept)


@on_posix
@pytest.mark.parametrize("read", READERS, ids=lambda read: read.__name__)
@pytest.mark.parametrize(("path", "kind"), [("/dev/zero", "a device"), ("pipe", "a pipe")])
def test_a_device_or_a_pipe_is_refused_at_once_by_every_reader(tmp_path, read, path, kind):
    if path == "pipe":
        path = str(tmp_path / "pipe.ies")
        os.mkfifo(path)
    with within(5.0), pytest.raises(FileFormatError, match=f"is {kind}, expected a file"):
        read(path)


@on_posix
@pytest.mark.parametrize("command", [["luminaire", "info"], ["rayset", "info"], ["brdf", "info"]])
def test_commands_refuse_a_device_in_one_line(command, capsys):
    with within(5.0):
        code = command_line.main([*command, "/dev/zero"])
    assert code == 1
    assert "is a device, expected a file" in capsys.readouterr().err


@on_posix
@pytest.mark.parametrize(
    ("library", "name"),
    [(luminaires, "lamp.json"), (luminaires, LUMINAIRES), (materials, MATERIALS)],
)
@pytest.mark.parametrize(("source", "words"), [("/dev/null", "is a device"), ("", "is a pipe")])
def test_a_description_in_a_library_that_is_a_device_or_a_pipe_is_told_and_left_out(
    tmp_path, library, name, source, words
):
    (tmp_path / "lamp.ies").write_text("text")
    if source:
        (tmp_path / name).symlink_to(source)
    else:
        os.mkfifo(tmp_path / name)
    with within(5.0):
        found = library.read_library(tmp_path)
    (problem,) = found.problems
    assert problem.path == tmp_path / name
    assert f"{words}, expected a file" in problem.message


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="there is no /proc")
@pytest.mark.parametrize(
    ("module", "limit", "name"),
    [
        (luminaires.catalogue, "LARGEST_JSON", LUMINAIRES),
        (materials.catalogue, "LARGEST_LIST", MATERIALS),
    ],
)
def test_a_list_of_a_library_that_holds_more_than_its_size_says_is_not_read_beyond_the_limit(
    tmp_path, monkeypatch, module, limit, name
):
    monkeypatch.setattr(module, limit, 100)
    (tmp_path / name).symlink_to("/proc/self/maps")
    (problem,) = module.read_library(tmp_path).problems
    assert "has no end within" in problem.message


@pytest.mark.parametrize("path", ["a\0b.ies", ""])
def test_what_is_no_path_is_refused(path):
    with pytest.raises(FileFormatError, match="cannot be opened"):
        read_bytes(path)


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="there is no /proc")
def test_a_file_that_holds_more_than_its_size_says_is_not_read_beyond_the_limit():
    # The size of what lies in /proc is 0.
    with pytest.raises(FileFormatError, match="has no end within 0 MiB"):
        read_bytes("/proc/self/maps", 100)
    assert not holds("/proc/self/maps", b"a")


def test_lines_end_where_the_file_ended_when_it_was_opened(tmp_path):
    path = tmp_path / "growing.txt"
    path.write_bytes(b"1\n2\n3")
    found = []
    for _, line in read_lines(path, 10):
        found.append(line.strip())
        with path.open("ab") as file:
            file.write(b"4\n" * 10_000)
    assert found == ["1", "2", "3"]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_have_the_ends_of_all_systems_and_a_longest_length(tmp_path, end):
    path = tmp_path / "lines.txt"
    path.write_bytes(end.join(["one", "two", "x" * 20]).encode())
    lines = read_lines(path, 10)
    assert [next(lines)[1].strip() for _ in range(2)] == ["one", "two"]
    with pytest.raises(FileFormatError, match="line 3: has more than 10 characters"):
        next(lines)


def test_content_is_compared_without_reading_more_than_its_length(tmp_path):
    path = tmp_path / "a.bin"
    path.write_bytes(b"abc")
    assert holds(path, b"abc")
    assert not holds(path, b"ab")
    assert not holds(path, b"abcd")
    assert not holds(tmp_path / "none", b"")


# ---- text and its encoding ----

WORDS = "Straße – 3 000 K, ø 12 mm\r\nE\tlx\r\n"


@pytest.mark.parametrize(
    ("data", "encoding", "text"),
    [
        (WORDS.encode(), "utf-8", WORDS),
        (WORDS.encode("utf-8-sig"), "utf-8", WORDS),
        (WORDS.encode("cp1252"), "cp1252", WORDS),
        (WORDS.encode("utf-16-le"), "utf-16-le", WORDS),
        (WORDS.encode("utf-16-be"), "utf-16-be", WORDS),
        (f"\ufeff{WORDS}λ".encode("utf-16-le"), "utf-16-le", f"{WORDS}λ"),
        (f"\ufeff{WORDS}λ".encode("utf-16-be"), "utf-16-be", f"{WORDS}λ"),
        # Bytes that Windows-1252 leaves undefined, and a mark of UTF-16 before what is none.
        (b"Stra\xdfe \x81", "latin-1", "Straße \x81"),
        (b"\xff\xfea", "cp1252", "ÿþa"),
        (b"a\rb\x1ac\0", "utf-8", "a\nb"),
        (b"a\0b", "utf-8", "ab"),
        (b"", "utf-8", ""),
    ],
)
def test_the_bytes_tell_the_encoding_and_come_back(data, encoding, text):
    assert find_encoding(data) == encoding
    assert data.decode(encoding).encode(encoding) == data
    assert decode_text(data) == text.replace("\r\n", "\n")


def test_every_content_is_text_that_becomes_the_same_content():
    rng = np.random.default_rng(5)
    for _ in range(500):
        data = rng.integers(0, 256, rng.integers(1, 40), dtype=np.uint8).tobytes()
        encoding = find_encoding(data)
        assert data.decode(encoding).encode(encoding) == data


def test_the_beginning_of_a_text_may_end_within_a_character():
    data = "Größe ² λ".encode()
    assert [decode_text(data, most) for most in (3, 4, 5)] == ["Gr", "Grö", "Grö"]
    assert decode_text(data[:3]) == "GrÃ"


@pytest.mark.parametrize("encoding", ["utf-8-sig", "cp1252", "utf-16"])
def test_lines_and_lists_are_read_in_all_encodings(tmp_path, encoding):
    path = tmp_path / "a.csv"
    path.write_bytes("x,y,z,nx,ny,nz,Höhe –\r\n1,2,3,0,0,1,\r\n".encode(encoding))
    assert next(iter(read_lines(path, 100))) == (1, "x,y,z,nx,ny,nz,Höhe –\r\n")
    assert read_sensors(path).tolist() == [[1, 2, 3, 0, 0, 1]]
    rays = tmp_path / "a.txt"
    rays.write_bytes("# Strahlen – 2\n0 0 0 0 0 1 1\n0 0 1 0 0 1 2\n".encode(encoding))
    assert read_rayset(rays).count == 2


# ---- text that is shown ----

ESCAPES = "a\x1b[2J\x1b]0;title\x07b\x9b31m\u202ec\r"


def test_control_characters_are_not_shown_and_all_else_is():
    shown = printable(ESCAPES)
    assert not set(shown) & set("\x1b\x07\x9b\u202e\r")
    assert shown.startswith(f"a{REPLACEMENT}[2J")
    kept = "Straße 3 000 K, ø 12′ ρ = 0.5\n\tµW/sr 灯"
    assert printable(kept) == kept


IES = """IESNA:LM-63-2002
[TEST] \x1b[2J\x1b]0;pwn\x07
[TESTLAB] a
[ISSUEDATE] a
[MANUFAC] \x1b[31mred
TILT=NONE
1 -1 1 3 1 1 2 0 0 0
1 1 10
0 45 90
0
100 80 {}
"""


@pytest.mark.parametrize("last", ["0", "\x1b[2Jx"])
def test_escapes_in_a_file_reach_no_terminal_by_the_command_line(tmp_path, capsys, last):
    path = tmp_path / "esc.ies"
    path.write_text(IES.format(last), encoding="latin-1")
    command_line.main(["luminaire", "info", str(path)])
    # What is refused is told on standard error by this one.
    command_line.main(["luminaire", "plot", str(path), "-o", str(tmp_path / "x.png")])
    captured = capsys.readouterr()
    assert "[2J" in captured.out + captured.err
    assert "\x1b" not in captured.out + captured.err
    assert "\x07" not in captured.out + captured.err


@on_posix
def test_a_pipe_is_refused_though_somebody_writes_to_it(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    kept = os.open(path, os.O_RDWR)
    writer = threading.Thread(target=os.write, args=(kept, b"x" * 100))
    writer.start()
    with within(5.0), pytest.raises(FileFormatError, match="is a pipe"):
        read_bytes(path)
    writer.join()
    os.close(kept)
