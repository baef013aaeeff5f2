"""Uploads that are made to do harm, opened by the command itself: refused in words, and the service goes on."""

import json
import struct
import sys
from pathlib import Path

import pytest
from served import Served, running

from lumenray.libraries import scenes as bundled
from lumenray.service import scenes
from lumenray.service.confinement import LEAST_VERSION, landlock_version
from lumenray.service.folders import UPLOADS
from lumenray.service.supervisor import PROGRAM

pytestmark = [
    pytest.mark.slow,
    pytest.mark.blender,
    pytest.mark.skipif(landlock_version() < LEAST_VERSION, reason="the kernel has no Landlock"),
]


def glb(document, binary=b""):
    """A binary glTF file of a document."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def mesh_document(**accessor):
    """A document with one triangle's accessor changed."""
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"} | accessor
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }


OUTSIDE = mesh_document() | {
    "buffers": [{"byteLength": 36, "uri": "../../../../service.sqlite"}],
}

WHOLE = bundled.scene_path("closed_box").read_bytes()

UPLOADS_BY_NAME = {
    "cut short": ("blend", WHOLE[: len(WHOLE) // 2]),
    "head alone": ("blend", b"BLENDER17-01v0500"),
    "block of 2 GiB": ("blend", b"BLENDER-v405" + b"GLOB" + struct.pack("<iQii", 0x7FFFFFFF, 1, 0, 1)),
    "noise": ("blend", b"BLENDER-v405" + bytes(range(256)) * 400),
    "no chunks": ("gltf", b"glTF" + struct.pack("<II", 2, 12)),
    "four thousand million corners": ("gltf", glb(mesh_document(count=0xFFFFFFFF), bytes(36))),
    "negative count": ("gltf", glb(mesh_document(count=-5), bytes(36))),
    "file of the service": ("gltf", glb(OUTSIDE)),
    "node in itself": (
        "gltf",
        glb({"asset": {"version": "2.0"}, "nodes": [{"children": [0]}], "scenes": [{"nodes": [0]}]}),
    ),
}  # fmt: skip


IGNORED = ("negative count",)
"""What Blender may read over."""


def test_hostile_uploads_are_refused_and_the_service_goes_on(tmp_path, monkeypatch):
    # A process that has loaded Blender looks for modules in Blender's own folders; the service never does.
    monkeypatch.setattr(sys, "path", [each for each in sys.path if "bpy" not in Path(each).parts])
    served = Served(tmp_path, count=2, seconds=120.0, program=PROGRAM)
    uploads = {}
    for name, (kind, content) in UPLOADS_BY_NAME.items():
        scene = served.add_scene(upload=content, kind=kind)
        uploads[name] = scene
    fine = served.add_scene(upload=WHOLE)
    with running(served):
        found = {name: served.wait_until_opened(scene, 400.0) for name, scene in uploads.items()}
        for name, scene in found.items():
            if name in IGNORED and scene.state == scenes.READY:
                continue
            assert scene.state == scenes.FAILED, name
            assert scene.note, name
            assert str(tmp_path) not in scene.note, name
            left = served.folders.scene(served.user.id, scene.id)
            assert [path.name for path in left.iterdir()] in ([each] for each in UPLOADS.values())
        assert served.wait_until_opened(fine, 400.0).state == scenes.READY
