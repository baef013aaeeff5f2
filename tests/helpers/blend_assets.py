"""Files of Blender assets, and what their catalogues say."""

import re

import bpy

from lumenray.command_line.asset_library import build


def catalogues(folder):
    """Paths of the catalogues by their identity."""
    rows = {}
    for line in (folder / build.CATALOGUES).read_text(encoding="utf-8").splitlines():
        found = re.fullmatch(r"([0-9a-f-]{36}):([^:]+):([^:]+)", line)
        if found:
            rows[found[1]] = found[2]
    return rows


def opened_assets(path):
    """Assets of a file by their name."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    things = [*bpy.data.objects, *bpy.data.collections, *bpy.data.materials]
    return {thing.name: thing for thing in things if thing.asset_data is not None}
