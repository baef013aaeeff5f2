"""Write what ships with the oldest Blender at hand: ``--python library.py -- FOLDER luminaires|materials|scenes``.

Blender opens files of older versions, not of newer ones, so what ships is written here and not by the bpy wheel. The
pictures of assets are those that ``python -m lumenray.tools.libraries.luminaires assets`` and ``python -m
lumenray.tools.libraries.materials assets`` rendered.
"""

import importlib
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from checkout import PACKAGE, command, tool


def write_assets(name, folder):
    """Write the assets of a library and return what was left out."""
    library = importlib.import_module(f"{PACKAGE}.libraries.{name}")
    if name == "luminaires":
        build = command("asset_library.build").build_assets
        content = library.read_library(library.FOLDER)
    else:
        build = command("asset_library.material_assets").build_material_assets
        content = library.read_library(library.LIBRARY)
    made = build(content, folder)
    print(f"{len(made.names)} assets in {made.path}")
    return made.problems


folder, name = sys.argv[sys.argv.index("--") + 1 :]
if name == "scenes":
    problems = []
    for path in tool("libraries.scenes.build").save_scenes(Path(folder)):
        print(f"{path}  {path.stat().st_size / 1e6:.1f} MB")
else:
    problems = write_assets(name, Path(folder))
for problem in problems:
    print(f"left out: {problem}", file=sys.stderr)
sys.exit(1 if problems else 0)
