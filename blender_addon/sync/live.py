"""The syncs that are kept current, and the handlers that tell them what Blender reports."""

from weakref import WeakSet

from bpy.app.handlers import persistent

from ..foundation.handlers import leave, listen

_live = WeakSet()


def keep(sync) -> None:
    """Tell a `SceneSync` about changes for as long as it lives."""
    _live.add(sync)


@persistent
def _tag(_scene, depsgraph):
    # Scenes share their data, so each change concerns every sync; what one does not show it passes over.
    is_render = depsgraph.mode == "RENDER"
    for sync in tuple(_live):
        # The graph of a render is new and calls everything changed; a viewport need not care.
        if sync.final or not is_render:
            sync.tag(depsgraph.updates)


@persistent
def _undone(*_):
    for sync in tuple(_live):
        sync.tag_scene()


@persistent
def _loaded(*_):
    for sync in tuple(_live):
        sync.start_over()


_HANDLERS = {
    "depsgraph_update_post": _tag,
    "frame_change_post": _tag,
    "undo_post": _undone,
    "redo_post": _undone,
    "load_post": _loaded,
}


def attach():
    """Listen to Blender."""
    listen(_HANDLERS)


def detach():
    """Listen no longer."""
    leave(_HANDLERS)
