"""Measures sensors again by itself, where a scene asks for it: in the background, once it is left alone."""

import logging
import time
from dataclasses import dataclass

import bpy

from ...engine.errors import LumenrayError
from ...imports import loaded_when_used
from ..foundation import engine_process
from . import results, running
from .settings import find_sensors

with loaded_when_used():
    from . import asked, readings

QUIET = 1.0
"""How long a scene has to stay as it is, so that dragging stays fluent. [s]"""

INTERVAL = 0.3
"""How often is looked whether a measurement has ended. [s]"""

log = logging.getLogger(__name__)


@dataclass
class _State:
    changed: float = 0.0
    measuring: running.Measuring | None = None


_state = _State()


def note_change() -> None:
    """Have the sensors of the open scene measured again soon, if it asks for that."""
    if bpy.app.background or not bpy.context.scene.lumenray.sensors.refresh:
        return
    _state.changed = time.monotonic()
    if _state.measuring is not None:
        # What it finds would be out of date.
        _state.measuring.job.cancel()
    if not bpy.app.timers.is_registered(_work):
        bpy.app.timers.register(_work, first_interval=QUIET)


def _work() -> float | None:
    """Begin a measurement once the scene is quiet, and keep what it has found; return when to look again. [s]"""
    if _state.measuring is not None:
        if _state.measuring.background.is_alive:
            return INTERVAL
        measuring, _state.measuring = _state.measuring, None
        if measuring.end(bpy.context) is None:
            measuring.store()
            return None
    left = _state.changed + QUIET - time.monotonic()
    if left > 0.0 or running.is_running():
        return max(left, INTERVAL)
    begin(bpy.context)
    return INTERVAL if _state.measuring is not None else None


def begin(context) -> None:
    """Measure the sensors that have been measured before and are out of date, in the background."""
    empties = [
        e
        for e in find_sensors(context.scene)
        if readings.readings_of(e) is not None and results.is_outdated(e)
    ]
    if not empties:
        return
    try:
        job, _ = asked.prepare(context.evaluated_depsgraph_get(), empties)
        session = engine_process.open_session("sensors", context.scene)
        _state.measuring = running.Measuring(job, session)
    except LumenrayError as error:
        # The readings stay grey; the button says what is wrong.
        log.info("sensors are not measured again: %s", error)


def attach():
    """Follow changes of scenes."""
    results.hear(note_change)


def detach():
    """Follow no more."""
    results.hear_no_more(note_change)
    if bpy.app.timers.is_registered(_work):
        bpy.app.timers.unregister(_work)
    _state.measuring = None
