"""Rooms of the checkout in a real Blender, beside the installed extension, which comes without them."""

import importlib.util
import sys
from pathlib import Path

PACKAGE = "bl_ext.user_default.lumenray"
"""Name of the installed extension."""

ROOT = Path(__file__).resolve().parents[2]


def tool(name):
    """Return a module by its name in ``tools``; what it imports of the product is the extension's."""
    return _module("tools", name)


def command(name):
    """Return a module by its name in ``command_line``; what it imports of the product is the extension's."""
    return _module("command_line", name)


def _module(room, name):
    package = f"{PACKAGE}.{room}"
    if package not in sys.modules:
        folder = ROOT / room
        spec = importlib.util.spec_from_file_location(
            package, folder / "__init__.py", submodule_search_locations=[str(folder)]
        )
        sys.modules[package] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[package])
    return importlib.import_module(f"{package}.{name}")
