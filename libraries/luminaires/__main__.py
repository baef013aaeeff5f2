"""Command ``python -m lumenray.libraries.luminaires [FOLDER]``: pictures and Blender assets of a library (ours)."""

import sys

from ...command_line.luminaire_library import main
from . import FOLDER

if __name__ == "__main__":
    sys.exit(main("lumenray.libraries.luminaires", FOLDER))
