"""Blender files that ship open in the oldest Blender that the manifest promises."""

import io
import struct
import tomllib

import pytest
import zstandard
from folders import ROOT

FILES = sorted((ROOT / "libraries").rglob("*.blend"))

HEAD = 12
"""Bytes of the file header that Blender knew until 4.5; that of 5.0 is longer, and older versions refuse it."""

BLOCK = 24
"""Bytes of the header of a block in such a file."""


def oldest_version():
    """Return the oldest version that is supported, as Blender numbers its files: 402 is 4.2."""
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    major, minor, _ = map(int, manifest["blender_version_min"].split("."))
    return 100 * major + minor


def content(path):
    """Return the bytes of a compressed Blender file."""
    with path.open("rb") as stream:
        reader = zstandard.ZstdDecompressor().stream_reader(stream, read_across_frames=True)
        return io.BufferedReader(reader).read()


def demanded_version(data):
    """Return the oldest version that a file asks for, which stands in its block of globals."""
    at = HEAD
    while (code := data[at : at + 4]) != b"GLOB":
        assert code != b"ENDB", "the file has no globals"
        at += BLOCK + struct.unpack_from("<i", data, at + 4)[0]
    _, _, version, _ = struct.unpack_from("<4shhh", data, at + BLOCK)
    return version


def test_there_are_files_of_scenes_and_of_both_libraries():
    assert {path.parent.name for path in FILES} == {"luminaires", "materials", "scenes"}


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_shipped_blender_files_open_in_the_oldest_supported_version(path):
    data = content(path)
    # Eight-byte pointers, little endian, and a version in three digits.
    assert data[:10] == b"BLENDER-v4", f"header {data[:HEAD]}: only Blender 5 can open it"
    assert demanded_version(data) <= oldest_version()
