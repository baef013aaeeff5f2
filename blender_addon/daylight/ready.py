"""What panels show of daylight is found out before they are drawn, after every edit of a world and after loading.

Where a panel takes long to be drawn and a preview starts meanwhile, Blender 4.3 takes scripts for drawing ever after, and
lets them change nothing more.
"""

import bpy
from bpy.app.handlers import persistent

from ...imports import loaded_when_used
from ..foundation.handlers import leave, listen

with loaded_when_used():
    from . import readout


def prepare(scene) -> None:
    """Find out what panels show of a scene's world; what takes long is kept where it is found."""
    world = scene.world
    if world is None:
        return
    readout.describe_place(world)
    readout.describe_moment(world, scene)
    if world.lumenray.source == "CIE":
        readout.describe_sky(world, None, scene)


@persistent
def _after_update(scene, depsgraph) -> None:
    if any(isinstance(update.id, bpy.types.World) for update in depsgraph.updates):
        prepare(scene)


@persistent
def _after_load(*_) -> None:
    for scene in bpy.data.scenes:
        prepare(scene)


_HANDLERS = {"depsgraph_update_post": _after_update, "load_post": _after_load}


def attach():
    """Prepare from now on, where there are panels."""
    if not bpy.app.background:
        listen(_HANDLERS)


def detach():
    """Prepare no more."""
    leave(_HANDLERS)
