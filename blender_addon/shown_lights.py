"""Keeps the list of lights that the sidebar shows: found on demand, or by itself where that is quick; never while drawing.

Kept in ``window_manager.lumenray_lights``, on Blender's main thread. It belongs to the session, not to the file.
"""

import time
from dataclasses import dataclass

import bpy
from bpy.app.handlers import persistent
from bpy.props import CollectionProperty, IntProperty, PointerProperty, StringProperty
from bpy.types import PropertyGroup

from ..imports import loaded_when_used
from . import readout
from .foundation.handlers import leave, listen
from .foundation.redraw import redraw
from .foundation.selection import select_only
from .foundation.units import metres_per_unit
from .sync.tags import Tags

with loaded_when_used():
    from . import light_list

QUICK = 0.05
"""A list that takes longer to find is found only when it is asked for. [s]"""

QUIET = 0.3
"""How long a scene has to stay as it is before its list is found by itself, so that dragging stays fluent. [s]"""


@dataclass
class _State:
    """What was found, and whether the scene has changed since.

    Parameters
    ----------
    held : LightList or None    None: nothing was looked for.
    signature : tuple    Of the scene as it was, see `_signature`.
    is_current : bool
    changed : float    When it changed last. [s]
    places : dict of int to int    Row by the session uid of its object.
    asked : tuple    Session uid of the scene, and name of its view layer, whose list is to be found by itself.
    """

    held: "light_list.LightList | None" = None
    signature: tuple = ()
    is_current: bool = False
    changed: float = 0.0
    places: dict[int, int] | None = None
    asked: tuple = ()


_state = _State()


def held() -> "light_list.LightList | None":
    """Return the list that was found last; None: none was."""
    return _state.held


def is_of(scene, view_layer) -> bool:
    """Whether there is a list, and it is that of a scene in a view layer."""
    return _state.signature[:2] == (scene.session_uid, view_layer.name)


def is_current(scene, view_layer) -> bool:
    """Whether the list is that of a scene as it is."""
    return _state.is_current and is_of(scene, view_layer)


def refresh(scene, view_layer) -> "light_list.LightList":
    """Find the list of a scene anew and show it."""
    view_layer.update()
    depsgraph = view_layer.depsgraph
    lights = light_list.find_lights(depsgraph)
    _state.held, _state.is_current = lights, True
    _state.signature = _signature(scene, view_layer, depsgraph)
    _state.places = {row.uid: k for k, row in reversed([*enumerate(lights.rows)])}
    rows = bpy.context.window_manager.lumenray_lights.rows
    rows.clear()
    for row in lights.rows:
        item = rows.add()
        item.name, item.icon, item.uid = light_list.name_row(row), row.icon, str(row.uid)
        item.amount = readout.format_amount(row.amount, row.unit)
    redraw("VIEW_3D")
    return lights


def follow(scene, view_layer) -> None:
    """Have the list found soon if it is not current and that is quick; cheap enough for every redraw."""
    if bpy.app.background or is_current(scene, view_layer) or not _is_quick(scene, view_layer):
        return
    # A timer knows of no window, and so of no view layer but the scene's first.
    _state.asked = (scene.session_uid, view_layer.name)
    if not bpy.app.timers.is_registered(_find_soon):
        bpy.app.timers.register(_find_soon, first_interval=QUIET)


def _is_quick(scene, view_layer) -> bool:
    """Whether a list may be found unasked: of a scene that was not looked at yet, or took little time.

    Two windows with two scenes would else take the list from each other without end.
    """
    if _state.held is None:
        return True
    return is_of(scene, view_layer) and _state.held.seconds <= QUICK


def _find_soon():
    """Find the list once the scene has been left alone for a while."""
    left = _state.changed + QUIET - time.monotonic()
    if left > 0.0:
        return left
    uid, name = _state.asked
    scene = next((each for each in bpy.data.scenes if each.session_uid == uid), None)
    view_layer = None if scene is None else scene.view_layers.get(name)
    if view_layer is not None:
        refresh(scene, view_layer)
    return None


def _signature(scene, view_layer, depsgraph) -> tuple:
    """What of a scene counts for its lights and is seen in no update of its objects."""
    return (
        scene.session_uid,
        view_layer.name,
        metres_per_unit(scene),
        scene.lumenray.efficacy,
        len(depsgraph.object_instances),
    )


def _note_change() -> None:
    was_current, _state.is_current = _state.is_current, False
    _state.changed = time.monotonic()
    if was_current:
        redraw("VIEW_3D")


def _forget() -> None:
    _state.held, _state.signature, _state.is_current, _state.places = None, (), False, None


@persistent
def _tag(scene, depsgraph):
    # A render has a graph of its own, on a thread of its own.
    if _state.held is None or depsgraph.mode == "RENDER":
        return
    tags = Tags()
    tags.add(depsgraph.updates)
    # A selection is told as a change of the scene, and changes no light.
    is_changed = tags.objects or tags.geometry or tags.shading
    if is_changed or _signature(scene, depsgraph.view_layer, depsgraph) != _state.signature:
        _note_change()


@persistent
def _undone(*_):
    _note_change()


@persistent
def _loaded(*_):
    _forget()
    for window_manager in bpy.data.window_managers:
        window_manager.property_unset("lumenray_lights")


def _active_row(_) -> int:
    active = bpy.context.view_layer.objects.active
    return -1 if active is None else (_state.places or {}).get(active.session_uid, -1)


def _select_row(group, index: int) -> None:
    """Select the object of a row alone and make it active; elsewhere than in object mode that would leave the mode."""
    if bpy.context.mode != "OBJECT":
        return
    objects = bpy.context.view_layer.objects
    wanted = int(group.rows[index].uid)
    source = next((each for each in objects if each.session_uid == wanted), None)
    if source is None:
        _note_change()
        return
    select_only(bpy.context.view_layer, [source])


class LumenrayLightRow(PropertyGroup):
    """A row of the list; its name is what Blender's filter looks for."""

    name: StringProperty(name="Object", description="Object that gives light")
    icon: StringProperty(name="Icon", description="Icon of the kind of light")
    amount: StringProperty(name="Amount", description="What it gives, as text")
    uid: StringProperty(
        name="Object's Identity", description="Number of the object in this session"
    )


class LumenrayLightList(PropertyGroup):
    """The rows; the active one is that of the active object."""

    rows: CollectionProperty(type=LumenrayLightRow)
    row_index: IntProperty(
        name="Active Row",
        description="Row of the active object; choosing one selects its object",
        get=_active_row,
        set=_select_row,
    )


CLASSES = (LumenrayLightRow, LumenrayLightList)

_HANDLERS = {
    "depsgraph_update_post": _tag,
    "frame_change_post": _tag,
    "undo_post": _undone,
    "redo_post": _undone,
    "load_post": _loaded,
}


def attach():
    """Attach the list to Blender's window manager and listen to Blender; the classes must be registered."""
    bpy.types.WindowManager.lumenray_lights = PointerProperty(
        type=LumenrayLightList, options={"HIDDEN", "SKIP_SAVE"}
    )
    listen(_HANDLERS)


def detach():
    """Undo `attach`, and forget the list."""
    leave(_HANDLERS)
    if bpy.app.timers.is_registered(_find_soon):
        bpy.app.timers.unregister(_find_soon)
    _forget()
    del bpy.types.WindowManager.lumenray_lights
