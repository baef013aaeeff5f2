"""Write a library's assets with the oldest Blender at hand: ``--python assets.py -- FOLDER luminaires|materials``.

Blender opens files of older versions, not of newer ones, so what ships is written here and not by the bpy wheel. The
pictures are those that ``python -m lumenray.libraries.luminaires`` and ``python -m lumenray.libraries.materials assets``
rendered.
"""

import importlib
import sys
from pathlib import Path

PACKAGE = "bl_ext.user_default.lumenray"
"""Name of the installed extension."""

folder, name = sys.argv[sys.argv.index("--") + 1 :]
library = importlib.import_module(f"{PACKAGE}.libraries.{name}")
rooms = f"{PACKAGE}.blender_addon.asset_library"
if name == "luminaires":
    build = importlib.import_module(f"{rooms}.build").build_assets
    content = library.read_library(library.FOLDER)
else:
    build = importlib.import_module(f"{rooms}.material_assets").build_material_assets
    content = library.read_library(library.LIBRARY)
made = build(content, Path(folder))
for problem in made.problems:
    print(f"left out: {problem}", file=sys.stderr)
print(f"{len(made.names)} assets in {made.path}")
sys.exit(1 if made.problems else 0)
