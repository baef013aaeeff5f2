"""The command that makes a Blender asset library of a folder of materials; it needs Blender's Python module."""

import argparse
from pathlib import Path

from ..engine.errors import LumenrayError
from ..libraries.materials import LIBRARY, Library, Problem, read_library
from .luminaire_library import add_options as add_common_options
from .luminaire_library import chosen, say, tell

FOLDER_HELP = "folder with a materials.json and the scattering files that it names"


def add_options(parser, folder: Path | None = None) -> None:
    """Describe the command to argparse; ``folder`` is what it works on if none is given."""
    add_common_options(parser, folder, FOLDER_HELP)
    parser.add_argument(
        "--sheet", type=Path, metavar="OUT.png", help="a picture of all pictures with their names"
    )


def add_to(commands, name: str = "assets", folder: Path | None = LIBRARY) -> None:
    """Add the command below argparse's sub-parsers ``commands``; it works on a folder if none is given."""
    parser = commands.add_parser(
        name, help="make a Blender asset library of a folder of materials, with pictures"
    )
    add_options(parser, folder)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Render pictures and write the assets; 1 if something of the folder was left out.

    Raises
    ------
    LumenrayError    Nothing can be written, or there is nothing to write.
    """
    library = read_library(options.folder)
    problems = _render(library, options)
    if options.sheet is not None:
        from ..blender_addon.asset_library.contact_sheet import write_sheet

        say(f"{write_sheet(options.sheet, library.entries)}")
    try:
        from ..blender_addon import registry
        from ..blender_addon.asset_library.material_assets import build_material_assets
    except ImportError as error:
        raise LumenrayError(
            f"Blender's Python module cannot be loaded ({error}); run 'make setup'"
        ) from None
    registry.register()
    return tell(build_material_assets(library), problems)


def _render(library: Library, options) -> list[Problem]:
    """Render pictures; a material whose file is refused has none."""
    problems = []
    for entry in chosen(library.entries, options):
        from ..blender_addon.asset_library.material_thumbnails import write_material_thumbnail

        try:
            say(f"{write_material_thumbnail(entry)}")
        except LumenrayError as error:
            problems.append(Problem(entry.file or library.folder, str(error)))
    return problems
