"""Lux maps of the last bake with its light groups as the sliders of its look have them, as files."""

from pathlib import Path

from ...engine.baking.mixed_maps import groups_of
from ...engine.errors import SceneError
from ...engine.formats.names import file_stem
from ...engine.light_mix import Level, LightMix
from ..foundation import engine_process
from .images import OTHERS

FOLDER = "mix"
"""Folder of the mix in that of the bake."""


def write_mix(scene):
    """Write the mix of a scene's last bake; return the figures of its objects and the folder.

    Raises
    ------
    SceneError    Nothing was baked with layers that are still there.
    LumenrayError    The engine is lost, or as of `engine.baking.mixed_maps.mix_maps`.
    """
    folder = Path(scene.lumenray.baked.folder)
    if not scene.lumenray.baked.folder or not folder.is_dir():
        raise SceneError("the files of the last bake are gone; bake again with layers")
    levels = levels_of(scene.lumenray.look, groups_of(folder))
    session = engine_process.open_session("mix")
    try:
        made = session.mix_maps(str(folder), levels, str(folder / FOLDER))
    finally:
        session.close()
    return made, folder / FOLDER


def levels_of(look, groups) -> LightMix:
    """Levels of the groups of a bake; what the look shows together as others goes by their slider."""
    own = {file_stem(row.name): row.strength for row in look.layers}
    others = own.pop(file_stem(OTHERS), 1.0) if OTHERS in look.layers else 1.0
    factors = {name: own.get(name, others) for name in groups}
    return LightMix(tuple(Level(name, factor) for name, factor in factors.items()))
