"""Write what ships with the oldest Blender at hand: ``--python library.py -- FOLDER luminaires|materials|scenes``.

Blender opens files of older versions, not of newer ones, so what ships is written here and not by the bpy wheel. The
pictures of assets are those that ``python -m lumenray.libraries.luminaires`` and ``python -m lumenray.libraries.materials
assets`` rendered.
"""

import importlib
import sys
from pathlib import Path

PACKAGE = "bl_ext.user_default.lumenray"
"""Name of the installed extension."""


def write_assets(name, folder):
    """Write the assets of a library and return what was left out."""
    library = importlib.import_module(f"{PACKAGE}.libraries.{name}")
    rooms = f"{PACKAGE}.blender_addon.asset_library"
    if name == "luminaires":
        build = importlib.import_module(f"{rooms}.build").build_assets
        content = library.read_library(library.FOLDER)
    else:
        build = importlib.import_module(f"{rooms}.material_assets").build_material_assets
        content = library.read_library(library.LIBRARY)
    made = build(content, folder)
    print(f"{len(made.names)} assets in {made.path}")
    return made.problems


folder, name = sys.argv[sys.argv.index("--") + 1 :]
if name == "scenes":
    problems = []
    for path in importlib.import_module(f"{PACKAGE}.libraries.scenes.build").save_scenes(
        Path(folder)
    ):
        print(f"{path}  {path.stat().st_size / 1e6:.1f} MB")
else:
    problems = write_assets(name, Path(folder))
for problem in problems:
    print(f"left out: {problem}", file=sys.stderr)
sys.exit(1 if problems else 0)
