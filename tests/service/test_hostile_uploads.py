"""Uploads that are made to do harm, opened by the command itself: refused in words, and the service goes on."""

import base64
import gzip
import json
import os
import resource
import struct
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
from broken_files import (
    Block,
    blend_bomb,
    break_blend,
    break_glb,
    by_gzip,
    by_zstandard,
    glb,
    png_bomb,
    read_blend,
    write_blend,
)
from served import Served, running

from lumenray.libraries import scenes as bundled
from lumenray.service import scenes
from lumenray.service.accounts import Quota
from lumenray.service.confinement import LEAST_VERSION, landlock_version
from lumenray.service.folders import UPLOADS, find_upload
from lumenray.service.supervisor import PROGRAM
from lumenray.service.web.app import LARGEST_UPLOAD

pytestmark = [
    pytest.mark.slow,
    pytest.mark.blender,
    pytest.mark.skipif(landlock_version() < LEAST_VERSION, reason="the kernel has no Landlock"),
]


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


MEMORY = 3 << 29
"""What a process may take here. [byte]"""

SHARED = 1 << 28
"""What of a process is not counted there: its programs. [byte]"""

BLEND = b"BLENDER17-01v0500"
"""How a file of Blender 5 begins."""

FINE = [
    (Path(__file__).parents[1] / "blender_addon" / "saved_files" / f"{name}.blend").read_bytes()
    for name in ("lights", "materials", "bake")
]


@pytest.fixture
def served(tmp_path, monkeypatch):
    # A process that has loaded Blender looks for modules in Blender's own folders; the service never does.
    monkeypatch.setattr(sys, "path", [each for each in sys.path if "bpy" not in Path(each).parts])
    return Served(tmp_path, count=2, seconds=120.0, quota=Quota(memory=MEMORY), program=PROGRAM)


def open_all(served, uploads, size=None):
    """What becomes of uploads, by their names, and of a sound one behind them; all with zeros up to a size. [byte]"""
    added = {
        name: served.add_scene(upload=content, kind=kind)
        for name, (kind, content) in uploads.items()
    }
    for scene in added.values() if size else ():
        os.truncate(find_upload(served.folders.scene(served.user.id, scene.id)), size)
    fine = served.add_scene(upload=WHOLE)
    with running(served):
        found = {name: served.wait_until_opened(scene, 400.0) for name, scene in added.items()}
        assert served.wait_until_opened(fine, 400.0).state == scenes.READY
    for name, scene in found.items():
        files = [path.name for path in served.folders.scene(served.user.id, scene.id).iterdir()]
        if scene.state == scenes.READY:
            assert files == ["scene.blend"], name
            continue
        assert files in ([each] for each in UPLOADS.values()), name
        # One sentence, which tells nothing of the machine and is not that of a fault of ours.
        assert scene.note, name
        assert "\n" not in scene.note, name
        assert not scene.note.startswith("its process failed"), (name, scene.note)
        for place in (served.folders.root, sys.prefix, Path(bpy.__file__).parent):
            assert str(place) not in scene.note, name
    return found


def test_hostile_uploads_are_refused_and_the_service_goes_on(served):
    for name, scene in open_all(served, UPLOADS_BY_NAME).items():
        assert name in IGNORED or scene.state == scenes.FAILED, name


def picture_document(picture):
    """A triangle with a picture on it."""
    return mesh_document() | {
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteLength": 24}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
        ],
        "images": [{"uri": "data:image/png;base64," + base64.b64encode(picture).decode()}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}
        ],
    }


def test_bombs_take_no_more_memory_than_their_user_may(served):
    """4 GiB by Zstandard in 0.2 MB, 1.5 GiB and more by gzip in 7 MB, 3.6 thousand million pixels in 0.4 MB."""
    corners = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    uploads = {
        "zstandard": ("blend", b"".join(blend_bomb(FINE[0], 16, 256, by_zstandard))),
        "gzip": ("blend", b"".join(blend_bomb(FINE[0], 7, 256, by_gzip))),
        "png": ("gltf", glb(picture_document(png_bomb(60_000)), corners)),
    }
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    found = open_all(served, uploads)
    for name in ("zstandard", "gzip"):
        assert found[name].state == scenes.FAILED
        assert "more memory than you may have" in found[name].note
    most = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    # In KiB, of the largest process until now.
    assert most <= max(before, (MEMORY + SHARED) >> 10)


def test_uploads_of_two_gigabytes_are_opened_in_their_place(served):
    """They say that they need what they have: one buffer, one block, or a scene and what no scene has behind it."""
    length = LARGEST_UPLOAD - 12 - 8 - 8
    document = json.dumps(mesh_document() | {"buffers": [{"byteLength": length}]}).encode()
    document += b" " * (-len(document) % 4)
    length -= len(document)
    head = b"glTF" + struct.pack("<IIII", 2, LARGEST_UPLOAD, len(document), 0x4E4F534A) + document
    plain = write_blend(*read_blend(FINE[0]))
    block = Block(b"DATA", 0, 1 << 40, 1, b"", LARGEST_UPLOAD - len(BLEND) - 32)
    uploads = {
        "glb": ("gltf", head + struct.pack("<I4s", length, b"BIN\0")),
        "block": ("blend", BLEND + block.head()),
        "scene": ("blend", plain),
        "gzip": ("blend", gzip.compress(plain)),
    }
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    found = open_all(served, uploads, LARGEST_UPLOAD)
    for name in ("glb", "block"):
        assert found[name].state == scenes.FAILED
    assert "more memory than you may have" in found["glb"].note
    most = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    assert most <= max(before, (MEMORY + SHARED) >> 10)


def write_glb(path):
    """A file with all that is taken over of a glTF file."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.data.materials.append(bpy.data.materials.new("Red"))
    bpy.ops.object.light_add(type="POINT")
    bpy.ops.object.camera_add()
    bpy.ops.export_scene.gltf(filepath=str(path), export_lights=True, export_cameras=True)
    return path.read_bytes()


def test_damaged_scenes_are_opened_or_refused_in_a_sentence(served, tmp_path_factory):
    """Of 24 .blend and 24 .glb files, block by block and number by number."""
    whole = write_glb(tmp_path_factory.mktemp("whole") / "whole.glb")
    uploads = {}
    for number in range(24):
        rng = np.random.default_rng([2026, number])
        uploads[f"blend {number}"] = "blend", break_blend(FINE[number % 3], rng)
        uploads[f"glb {number}"] = "gltf", break_glb(whole, rng)
    states = [scene.state for scene in open_all(served, uploads).values()]
    # Damage of all weights: some scenes survive it.
    assert {scenes.READY, scenes.FAILED} == set(states)
