"""Write the library's assets with the oldest Blender at hand: ``--python assets.py -- FOLDER``.

Blender opens files of older versions, not of newer ones, so what ships is written here and not by the bpy wheel. The
pictures are those that ``python -m lumenray.libraries.luminaires`` rendered.
"""

import importlib
import sys
from pathlib import Path

PACKAGE = "bl_ext.user_default.lumenray"
"""Name of the installed extension."""

library = importlib.import_module(f"{PACKAGE}.libraries.luminaires")
build = importlib.import_module(f"{PACKAGE}.blender_addon.asset_library.build")
made = build.build_assets(
    library.read_library(library.FOLDER), Path(sys.argv[sys.argv.index("--") + 1])
)
for problem in made.problems:
    print(f"left out: {problem}", file=sys.stderr)
print(f"{len(made.names)} assets in {made.path}")
sys.exit(1 if made.problems else 0)
