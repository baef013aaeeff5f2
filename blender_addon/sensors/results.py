"""What sensors told, kept with them, and whether the scene is still the one that they were measured in.

What Blender reports as changed since makes readings out of date; they stay, and are drawn grey. Only measuring again makes
them current: undo brings flags back as well.
"""

import uuid
from collections.abc import Iterator
from dataclasses import dataclass, field

import bpy
from bpy.app.handlers import persistent

from ...imports import loaded_when_used
from ..bake.results import MOST_NAMES, Watch
from ..foundation.handlers import leave, listen
from ..foundation.identity import identity_of
from ..foundation.redraw import redraw
from .settings import is_sensor

with loaded_when_used():
    from . import job as sensor_job
    from . import places
    from . import readings as sensor_readings


@dataclass
class _Tracker:
    """What is known of changes in the open file.

    ``watch``: what has changed since it was asked last; None while no sensor has readings. ``outdated``: by the serial of a
    measurement of this session: undo may take the flag in the file back, but not what it undoes. ``listeners``: called with
    no arguments when readings have become out of date.
    """

    watch: Watch | None = None
    outdated: dict[str, str] = field(default_factory=dict)
    listeners: list = field(default_factory=list)


_tracker = _Tracker()


def store(job: "sensor_job.SensorJob", changed=()) -> list:
    """Keep the readings of a finished job with their empties, and return these.

    Parameters
    ----------
    job : SensorJob
    changed : iterable of str    Names of what has changed while it ran.
    """
    kept = [
        thing for thing in bpy.data.objects if is_sensor(thing) and identity_of(thing) in job.answer
    ]
    words = _say(changed)
    for empty in kept:
        settings = empty.lumenray.sensor
        settings.kept = sensor_readings.write_readings(job.answer[identity_of(empty)])
        settings.serial, settings.changed = uuid.uuid4().hex, words
        if words:
            _tracker.outdated[settings.serial] = words
    _listen_if_needed()
    redraw("VIEW_3D", "PROPERTIES")
    return kept


def is_outdated(empty) -> bool:
    """Whether the scene or the empty has changed since its sensors were measured."""
    return bool(why_outdated(empty))


def why_outdated(empty) -> str:
    """Say what has changed since the sensors of an empty were measured; empty: nothing, or there are no readings."""
    readings = sensor_readings.readings_of(empty)
    if readings is None:
        return ""
    if empty.lumenray.sensor.changed:
        return empty.lumenray.sensor.changed
    return "" if readings.signature == str(places.signature_of(empty)) else empty.name


def with_readings() -> Iterator:
    """Give the empties of the file that have readings."""
    for thing in bpy.data.objects:
        if is_sensor(thing) and thing.lumenray.sensor.kept:
            yield thing


def hear(listener) -> None:
    """Have a function called when readings have become out of date."""
    if listener not in _tracker.listeners:
        _tracker.listeners.append(listener)


def hear_no_more(listener) -> None:
    """Undo `hear`."""
    if listener in _tracker.listeners:
        _tracker.listeners.remove(listener)


def _say(names) -> str:
    names = list(names)
    return ", ".join(names[:MOST_NAMES] + (["…"] if len(names) > MOST_NAMES else []))


def _listen_if_needed() -> None:
    """Take note of changes while there is something that they make out of date."""
    if next(with_readings(), None) is None:
        if _tracker.watch is not None:
            _tracker.watch.end()
        _tracker.watch = None
    elif _tracker.watch is None:
        _tracker.watch = Watch()


@persistent
def _after_update(_scene, depsgraph):
    if _tracker.watch is None or depsgraph.mode == "RENDER":
        return
    names = list(_tracker.watch.names)
    _tracker.watch.names.clear()
    is_moved = any(
        isinstance(update.id, bpy.types.Object) and is_sensor(update.id.original)
        for update in depsgraph.updates
    )
    if not names and not is_moved:
        return
    words = _say(names)
    for empty in with_readings() if names else ():
        settings = empty.lumenray.sensor
        if not settings.changed:
            settings.changed = words
            _tracker.outdated[settings.serial] = words
    for listener in _tracker.listeners:
        listener()


@persistent
def _after_undo(*_):
    for empty in with_readings():
        settings = empty.lumenray.sensor
        if settings.serial in _tracker.outdated and not settings.changed:
            settings.changed = _tracker.outdated[settings.serial]
    _listen_if_needed()


@persistent
def _after_load(*_):
    _tracker.outdated.clear()
    _listen_if_needed()


_HANDLERS = {
    "depsgraph_update_post": _after_update,
    "frame_change_post": _after_update,
    "undo_post": _after_undo,
    "redo_post": _after_undo,
    "load_post": _after_load,
}


def attach():
    """Listen to Blender."""
    listen(_HANDLERS)


def detach():
    """Listen no longer."""
    leave(_HANDLERS)
    if _tracker.watch is not None:
        _tracker.watch.end()
    _tracker.watch = None
