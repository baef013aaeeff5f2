"""The wheel that carries LLVM: only what the loader needs, the same bytes each time."""

import base64
import csv
import hashlib
import io
import struct
import subprocess
import sys
import zipfile

import llvm_wheel
import pytest
from project import BuildError


def elf(loaded, rest):
    """Return a library of one loaded segment, followed by symbols and a table of sections."""
    head = bytearray(64)
    head[:7] = b"\x7fELF\x02\x01\x01"
    struct.pack_into("<QQ", head, 0x20, 64, 64 + 56 + len(loaded) + 100)
    struct.pack_into("<HHHHH", head, 0x36, 56, 1, 64, 9, 8)
    segment = struct.pack("<IIQQQQQQ", 1, 5, 0, 0, 0, 120 + len(loaded), 120 + len(loaded), 4096)
    return bytes(head) + segment + loaded + rest


def test_what_no_loader_reads_is_left_out():
    made = llvm_wheel.without_symbols(elf(b"code" * 10, b"symbols" * 100))
    assert made.endswith(b"code" * 10)
    assert b"symbols" not in made
    assert struct.unpack_from("<Q", made, 0x28) == (0,)
    assert struct.unpack_from("<HHH", made, 0x3A) == (0, 0, 0)
    assert llvm_wheel.without_symbols(made) == made


def test_other_libraries_stay_as_they_are():
    assert llvm_wheel.without_symbols(b"MZ of Windows") == b"MZ of Windows"


def fake_source(monkeypatch, folder):
    """Let the index give a wheel of a few bytes."""
    source = llvm_wheel.SOURCES["linux-x64"]
    origin = folder / "origin.whl"
    with zipfile.ZipFile(origin, "w") as archive:
        for name in (source.library, *source.beside.values()):
            archive.writestr(name, elf(name.encode(), b"symbols"))
        archive.writestr("headers.h", "not needed")
    monkeypatch.setattr(llvm_wheel, "_download", lambda source, place: origin)


def test_a_wheel_is_whole_and_the_same_each_time(monkeypatch, tmp_path):
    fake_source(monkeypatch, tmp_path)
    first = llvm_wheel.make_wheel("linux-x64", tmp_path / "a")
    second = llvm_wheel.make_wheel("linux-x64", tmp_path / "b")
    assert first.read_bytes() == second.read_bytes()
    assert first.name == "lumenray_llvm-23.1.4.post1-py3-none-manylinux_2_28_x86_64.whl"
    with zipfile.ZipFile(first) as wheel:
        names = set(wheel.namelist())
        record = "lumenray_llvm-23.1.4.post1.dist-info/RECORD"
        rows = list(csv.reader(io.StringIO(wheel.read(record).decode())))
        assert {row[0] for row in rows} == names
        for name, digest, size in rows:
            if name != record:
                content = wheel.read(name)
                sha = (
                    base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
                )
                assert (digest, int(size)) == (f"sha256={sha}", len(content))
        assert b"LLVM Exceptions" in wheel.read(
            "lumenray_llvm-23.1.4.post1.dist-info/licenses/LICENSE.txt"
        )
    assert not any("headers" in name for name in names)
    assert {name for name in names if "/lib/" in name} == {
        f"lumenray_llvm/lib/{name}"
        for name in ("libLLVM.so.23.1", "libc++.so.1", "libc++abi.so.1", "libunwind.so.1")
    }


def test_pip_installs_it_and_it_tells_where_the_library_lies(monkeypatch, tmp_path):
    fake_source(monkeypatch, tmp_path)
    wheel = llvm_wheel.make_wheel("linux-x64", tmp_path)
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index"]
    subprocess.run([*command, "--target", str(tmp_path / "site"), str(wheel)], check=True)
    ask = "import lumenray_llvm as m; print(m.LIBRARY.is_file(), m.VERSION)"
    done = subprocess.run(
        [sys.executable, "-c", ask],
        cwd=tmp_path / "site",
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == ["True", "23.1"]


def test_a_source_without_a_recorded_sum_is_refused(monkeypatch, tmp_path):
    (tmp_path / "sources.txt").write_text("something-else==1 --hash=sha256:00\n")
    monkeypatch.setattr(llvm_wheel, "FOLDER", tmp_path)
    with pytest.raises(BuildError, match="no sum of karellen-llvm-core"):
        llvm_wheel._download(llvm_wheel.SOURCES["linux-x64"], tmp_path)
