"""The command ``lumenray scene edit``: a copy of a .blend file with lights, visibility and materials changed by name."""

from pathlib import Path

from ...blender_addon import scene_edits
from ...engine.reading.content import read_json
from ..blend_file import open_blend, save_copy, start_blender
from ..output import add_output, check_free, say

LARGEST = 4 << 20
"""Of a file of edits. [byte]"""


def add_command(commands) -> None:
    """Describe the command to argparse."""
    edit = commands.add_parser("edit", help="copy a .blend file with changes by name")
    edit.add_argument("file", type=Path, metavar="F.blend", help="Blender file; it stays as it is")
    edit.add_argument(
        "--edits", required=True, type=Path, metavar="E.json", help="what is to be changed"
    )
    add_output(edit, "OUT.blend", "Blender file")
    edit.set_defaults(run=run)


def run(options) -> int:
    """Write the changed copy; return the exit code."""
    check_free(options, options.output)
    edits = read_json(options.edits, LARGEST)
    open_blend(options.file)
    bpy = start_blender()
    content, library = scene_edits.describe(bpy), scene_edits.library_materials()
    scene_edits.apply_edits(bpy, scene_edits.check_edits(edits, content, library), options.output)
    save_copy(options.output)
    say(f"written to {options.output}")
    return 0
