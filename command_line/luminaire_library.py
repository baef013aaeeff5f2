"""The command that makes a Blender asset library of a folder of photometric files or of materials.

It needs Blender's Python module. `material_library` has what differs for materials.
"""

import argparse
import sys
from pathlib import Path

from ..engine.errors import LumenrayError
from ..libraries.luminaires import Library, Problem, read_library

FOLDER_HELP = "folder of IES, EULUMDAT and TM-33 files; folders in it are categories"


def add_options(parser, folder: Path | None = None, folder_help: str = FOLDER_HELP) -> None:
    """Describe the command to argparse; ``folder`` is what it works on if none is given."""
    parser.add_argument(
        "folder",
        type=Path,
        metavar="FOLDER",
        nargs="?" if folder is not None else None,
        default=folder,
        help=folder_help,
    )
    parser.add_argument(
        "--pictures",
        choices=("missing", "all", "none"),
        default="missing",
        help="which pictures to render first (default: those that are not there)",
    )
    parser.add_argument(
        "--only", metavar="A,B", default="", help="render pictures of these by name only"
    )


def main(program: str, folder: Path, arguments=None) -> int:
    """Run the command alone, on a folder if none is given; 1 with a line on standard error on any failure."""
    parser = argparse.ArgumentParser(prog=program, description=__doc__)
    add_options(parser, folder)
    try:
        return run(parser.parse_args(arguments))
    except LumenrayError as error:
        sys.stderr.write(f"{error}\n")
        return 1


def run(options) -> int:
    """Render pictures and write the assets; 1 if something of the folder was left out.

    Raises
    ------
    LumenrayError    Nothing can be written, or there is nothing to write.
    """
    library = read_library(options.folder)
    problems = _render(library, options)
    try:
        from ..blender_addon import registry
        from ..blender_addon.asset_library.build import build_assets
    except ImportError as error:
        raise LumenrayError(
            f"Blender's Python module cannot be loaded ({error}); run 'make setup'"
        ) from None
    registry.register()
    built = build_assets(library)
    return tell(built, problems)


def tell(built, problems: list[Problem]) -> int:
    """Tell what was written, and what was left out; 1 if something was."""
    say(f"{built.path}: {len(built.names)} assets, {built.path.stat().st_size / 1e6:.1f} MB")
    # A refused file has no picture either, and is told once.
    told = {problem.path for problem in built.problems}
    left_out = [*built.problems, *(problem for problem in problems if problem.path not in told)]
    for problem in left_out:
        sys.stderr.write(f"{problem}\n")
    return int(bool(left_out))


def _render(library: Library, options) -> list[Problem]:
    """Render pictures; a model whose file is refused has none."""
    problems = []
    for model in chosen(library.models, options):
        from ..blender_addon.asset_library.thumbnails import write_thumbnail

        try:
            say(f"{write_thumbnail(model)}")
        except LumenrayError as error:
            problems.append(Problem(model.file, str(error)))
    return problems


def chosen(models, options) -> list:
    """Models whose pictures the options ask for; anything with a ``name`` and the path of a ``thumbnail``."""
    if options.pictures == "none":
        return []
    only = {name.strip() for name in options.only.split(",") if name.strip()}
    return [
        model
        for model in models
        if not (options.pictures == "missing" and model.thumbnail.is_file())
        and (not only or model.name in only)
    ]


def say(text: str) -> None:
    """Write a line to standard output at once."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()
