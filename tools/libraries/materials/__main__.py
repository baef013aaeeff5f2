"""Command ``python -m lumenray.tools.libraries.materials files|assets``: scattering files, or pictures and assets."""

import sys

from ....command_line.brdf import library as material_library
from ....libraries.materials import LIBRARY
from .. import command
from .tables import write


def main() -> int:
    """Run the command."""
    parser, files = command.parser_of(__doc__, LIBRARY, material_library)
    files.add_argument(
        "--only", metavar="A,B", default="", help="files of these materials by name only"
    )
    files.set_defaults(run=_write)
    return command.run(parser)


def _write(options) -> int:
    write(options.output, {name for name in options.only.split(",") if name})
    return 0


if __name__ == "__main__":
    sys.exit(main())
