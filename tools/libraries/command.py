"""What the commands of the libraries of assets share: one task computes files, the other makes pictures and assets."""

import argparse
import sys
from pathlib import Path

from ...engine.errors import LumenrayError


def parser_of(description: str, folder: Path, library_command):
    """Return a parser with both tasks, and that of the first one for options of its own.

    Parameters
    ----------
    description : str
    folder : Path    Of the library.
    library_command : module    Of `command_line`, which makes assets of a folder.
    """
    program = f"python -m lumenray.tools.libraries.{folder.name}"
    parser = argparse.ArgumentParser(prog=program, description=description)
    tasks = parser.add_subparsers(required=True, metavar="TASK")
    files = tasks.add_parser("files", help="compute the files and their catalogue")
    files.add_argument("-o", "--output", type=Path, default=folder, help="folder for the files")
    assets = tasks.add_parser("assets", help="render pictures and write the Blender assets")
    library_command.add_picture_options(assets)
    assets.set_defaults(run=library_command.run, folder=folder)
    return parser, files


def run(parser) -> int:
    """Run the task that the command line asks for; 1 with a line on standard error on any failure."""
    options = parser.parse_args()
    try:
        return options.run(options)
    except LumenrayError as error:
        print(error, file=sys.stderr)
        return 1
