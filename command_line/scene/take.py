"""The command ``lumenray scene take``: a .blend or glTF file as a .blend file that needs no other, and what is in it."""

import contextlib
import io
import json
from pathlib import Path

from ...blender_addon import scene_edits
from ...engine.errors import FileFormatError, LumenrayError
from ...engine.reading.whole_file import write_whole
from ..blend_file import open_blend, quiet, save_copy, start_blender
from ..output import add_output, check_free, say

GLTF = (".glb", ".gltf")


def add_command(commands) -> None:
    """Describe the command to argparse."""
    take = commands.add_parser(
        "take", help="keep a .blend or glTF file as a .blend file that needs no other files"
    )
    take.add_argument("file", type=Path, metavar="IN", help=".blend, .glb or .gltf")
    add_output(take, "OUT.blend", "Blender file, its textures packed")
    take.add_argument(
        "--content",
        type=Path,
        metavar="OUT.json",
        help="also write what is in it: lights with their amounts, objects, sensors, materials",
    )
    take.set_defaults(run=run)


def run(options) -> int:
    """Take a file over; return the exit code."""
    check_free(options, options.output, options.content)
    if options.file.suffix.lower() in GLTF:
        bpy = _import_gltf(options.file)
    else:
        open_blend(options.file)
        bpy = start_blender()
    _check_files(bpy, options.file)
    save_copy(options.output)
    if options.content is not None:
        content = scene_edits.describe(bpy)
        with write_whole(options.content, "utf-8") as stream:
            json.dump(content, stream, indent=1)
        say(f"written to {options.content}")
    say(f"written to {options.output}")
    return 0


def _import_gltf(path: Path):
    bpy = start_blender()
    if not path.is_file():
        raise LumenrayError(f"{path}: no such file")
    try:
        # The importer's whole way to its fault is not for users; what it was is told below.
        with quiet(), contextlib.redirect_stderr(io.StringIO()):
            bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
            bpy.ops.import_scene.gltf(filepath=str(path.resolve()))
    except Exception as error:
        # Blender's importer is a Python program that raises whatever a broken file leads it to.
        raise LumenrayError(
            f"{path}: Blender cannot read this glTF file ({_reason(error)})"
        ) from error
    return bpy


def _reason(error: Exception) -> str:
    """The last thing that Blender says of what went wrong, without where in Blender's own files."""
    lines = [line.strip() for line in str(error).splitlines()]
    told = [line for line in lines if line and not line.startswith(("Location:", "File "))]
    return told[-1][:300] if told else type(error).__name__


def _check_files(bpy, path: Path) -> None:
    """Pack textures that lie beside the file, and refuse it if it needs others."""
    outside = [each.filepath for each in bpy.data.libraries]
    for image in bpy.data.images:
        if image.source != "FILE" or image.packed_file is not None or not image.filepath:
            continue
        try:
            image.pack()
        except RuntimeError:
            outside.append(image.filepath)
    if outside:
        others = f" (and {len(outside) - 1} more)" if len(outside) > 1 else ""
        raise FileFormatError(
            path,
            f"needs '{outside[0]}'{others}, which is not there; pack what it needs in Blender: File > External Data > Pack "
            "Resources, and Pack Linked Libraries",
        )
