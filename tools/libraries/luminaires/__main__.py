"""Command ``python -m lumenray.tools.libraries.luminaires files|assets``: photometric files, or pictures and assets."""

import sys

from ....command_line.luminaire import library as luminaire_library
from ....libraries.luminaires import FOLDER
from .. import command
from .recipes import write


def main() -> int:
    """Run the command."""
    parser, files = command.parser_of(__doc__, FOLDER, luminaire_library)
    files.set_defaults(run=_write)
    return command.run(parser)


def _write(options) -> int:
    for path in write(options.output):
        print(f"{path}  {path.stat().st_size / 1e3:.1f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
