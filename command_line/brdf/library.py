"""The command ``lumenray brdf library``: a Blender asset library of a folder of materials.

It needs Blender's Python module.
"""

from pathlib import Path

from ...libraries.materials import read_library
from ..asset_library import command
from ..blend_file import start_blender
from ..output import add_force, check_free, say

FOLDER_HELP = "folder with a materials.json and the scattering files that it names"


def add_picture_options(parser) -> None:
    """Let a command say which pictures may be rendered, and where a picture of them all goes."""
    command.add_picture_options(parser)
    parser.add_argument(
        "--sheet", type=Path, metavar="OUT.png", help="a picture of all pictures with their names"
    )
    add_force(parser)


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    parser = tasks.add_parser(
        "library", help="make a Blender asset library of a folder of materials, with pictures"
    )
    parser.add_argument("folder", type=Path, metavar="FOLDER", help=FOLDER_HELP)
    add_picture_options(parser)
    parser.set_defaults(run=run)


def run(options) -> int:
    """Render pictures and write the assets; 1 if something of the folder was left out."""
    check_free(options, options.sheet)
    library = read_library(options.folder)
    start_blender()
    from ..asset_library.material_assets import build_material_assets
    from ..asset_library.material_thumbnails import write_material_thumbnail

    problems = command.render(
        library.entries,
        options,
        write_material_thumbnail,
        lambda entry: entry.file or library.folder,
    )
    code = command.tell(build_material_assets(library), problems)
    if options.sheet is not None:
        from ..asset_library.contact_sheet import write_sheet

        say(f"{write_sheet(options.sheet, library.entries)}")
    return code
