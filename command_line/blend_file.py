"""A .blend file, opened without a window and quietly."""

import os
import sys
from pathlib import Path

from ..blender_addon import assumptions
from ..engine.errors import LumenrayError
from .modelling import overrule


class quiet:
    """Keeps what Blender prints on its own off the terminal."""

    def __enter__(self):
        sys.stdout.flush()
        self._kept = os.dup(1)
        self._null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(self._null, 1)

    def __exit__(self, *_):
        os.dup2(self._kept, 1)
        os.close(self._kept)
        os.close(self._null)


def start_blender():
    """Load Blender's Python module and register the extension in it; return the module.

    Raises
    ------
    LumenrayError    It cannot be loaded.
    """
    try:
        import bpy
    except ImportError as error:
        raise LumenrayError(
            f"Blender's Python module cannot be loaded ({error}); run 'make setup'"
        ) from None
    from ..blender_addon import registry

    registry.register()
    return bpy


def open_blend(path: Path):
    """Open a .blend file and return its evaluated dependency graph.

    Raises
    ------
    LumenrayError    Blender is not there, or cannot open it.
    """
    bpy = start_blender()
    if not path.is_file():
        raise LumenrayError(f"{path}: no such file")
    try:
        with quiet():
            bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False, use_scripts=False)
    except RuntimeError as error:
        raise LumenrayError(f"{path}: Blender cannot open it ({str(error).strip()})") from None
    return bpy.context.evaluated_depsgraph_get()


def save_copy(path: Path) -> None:
    """Save what is open to another place; the open file stays what it is.

    Raises
    ------
    LumenrayError    Blender cannot write it.
    """
    import bpy

    try:
        with quiet():
            bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()), compress=True, copy=True)
    except RuntimeError as error:
        raise LumenrayError(f"{path}: cannot be saved ({str(error).strip()})") from None


def read_scene(options):
    """Open the .blend file of a command and convert its scene.

    Returns
    -------
    (LumenraySceneSettings, ConversionReport, SceneDelta)

    Raises
    ------
    LumenrayError    Blender cannot open it, or it lacks files and ``options.accept_missing`` is off.
    """
    from ..blender_addon.sync.scene import convert_scene

    depsgraph = open_blend(options.file)
    overrule(depsgraph.scene, options)
    converted = convert_scene(depsgraph)
    assumptions.refuse_missing(converted.report, options.accept_missing)
    return depsgraph.scene.lumenray, converted.report, converted.delta


def open_session(options):
    """Open the .blend file of a command and give its scene to an engine.

    Returns
    -------
    (LumenraySceneSettings, ConversionReport, Session)

    Raises
    ------
    LumenrayError    As of `read_scene`.
    """
    from ..engine.session import Session

    settings, report, delta = read_scene(options)
    session = Session()
    session.apply(delta)
    return settings, report, session
