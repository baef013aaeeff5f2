"""What an edit of a world's daylight entails: lights and notes follow, and panels find ready what they show."""

import bpy
from bpy.app.handlers import persistent

from ..foundation.handlers import leave, listen
from . import following


def follow_edit(self, context) -> None:
    """Tell the dependency graph of an edit of a world's settings, and let all that depends on them follow."""
    world = self.id_data
    world.update_tag()
    following.follow_world(world)
    prepare_panels(world)


def prepare_panels(world) -> None:
    """Find out what panels will show of a world, and keep it.

    Where a panel takes long to be drawn and a preview starts meanwhile, Blender 4.3 takes scripts for drawing ever after,
    and lets them change nothing more.
    """
    if bpy.app.background:
        return
    # The readout stands above the settings, which call this.
    from .readout import describe_moment, describe_place, describe_sky

    for scene in bpy.data.scenes:
        if scene.world == world:
            describe_place(world)
            describe_moment(world, scene)
            if world.lumenray.source == "CIE":
                describe_sky(world, None, scene)


@persistent
def _after_load(*_) -> None:
    for world in bpy.data.worlds:
        prepare_panels(world)


_HANDLERS = {"load_post": _after_load}


def attach():
    """Prepare what is opened from now on."""
    listen(_HANDLERS)


def detach():
    """Prepare nothing more."""
    leave(_HANDLERS)
