"""The command ``lumenray luminaire library``: a Blender asset library of a folder of photometric files.

It needs Blender's Python module.
"""

from pathlib import Path

from ...libraries.luminaires import read_library
from ..asset_library.command import add_picture_options, render, tell
from ..blend_file import start_blender

FOLDER_HELP = "folder of IES, EULUMDAT and TM-33 files; folders in it are categories"


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    parser = tasks.add_parser(
        "library", help="make a Blender asset library of a folder of photometric files"
    )
    parser.add_argument("folder", type=Path, metavar="FOLDER", help=FOLDER_HELP)
    add_picture_options(parser)
    parser.set_defaults(run=run)


def run(options) -> int:
    """Render pictures and write the assets; 1 if something of the folder was left out."""
    library = read_library(options.folder)
    start_blender()
    from ..asset_library.build import build_assets
    from ..asset_library.thumbnails import write_thumbnail

    problems = render(library.models, options, write_thumbnail, lambda model: model.file)
    return tell(build_assets(library), problems)
