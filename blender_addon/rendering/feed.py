"""From a Blender scene to an engine's session: what changed is walked, sent and told."""

import time
from dataclasses import dataclass
from weakref import WeakSet

import bpy
from bpy.app.handlers import persistent

from ...engine.scene.scene import Attachment, SceneDelta
from ...engine.scene.sensor import SensorSet
from ..foundation.report import ConversionReport
from ..sync.scene_sync import SceneSync
from ..sync.step import PART_BYTES, SyncStats


@dataclass(frozen=True)
class Edit:
    """What one update did.

    Parameters
    ----------
    stats : SyncStats    Of the walk.
    transfer_seconds : float    Handing over to the engine.
    revision : int    Of the engine's scene from then on; frames with it show the edit.
    """

    stats: SyncStats
    transfer_seconds: float
    revision: int


_additions: dict[str, Attachment | SensorSet] = {}
_feeds: WeakSet = WeakSet()


def add_to_engine(addition: Attachment | SensorSet) -> None:
    """Give the engine something that Blender's scene does not hold: data on an item, by its engine id, or sensors.

    It stays until the file is closed, whatever is edited and however often the engine is started again. Engine ids are
    those of `identity.engine_id`.
    """
    _additions[f"{type(addition).__name__} {addition.id}"] = addition
    for feed in tuple(_feeds):
        feed.add(addition)


@persistent
def _forget(*_):
    _additions.clear()


def attach():
    """Forget additions with the file that they belong to."""
    if _forget not in bpy.app.handlers.load_pre:
        bpy.app.handlers.load_pre.append(_forget)


def detach():
    """Listen no longer."""
    if _forget in bpy.app.handlers.load_pre:
        bpy.app.handlers.load_pre.remove(_forget)
    _additions.clear()


class SceneFeed:
    """Keeps the scene of an engine's session equal to a Blender scene.

    Parameters
    ----------
    session : Session or RemoteSession    With an empty scene.
    final : bool    Whether objects that are hidden in renders are left out.
    """

    def __init__(self, session, final: bool = False):
        self.session = session
        self.sync = SceneSync(final)
        self.report = ConversionReport()
        self.last: Edit | None = None
        _feeds.add(self)
        for addition in _additions.values():
            self.add(addition)

    def add(self, addition: Attachment | SensorSet) -> None:
        """Send something that is not in Blender's scene; a session that is lost gets it when it is made anew."""
        if isinstance(addition, SensorSet):
            delta = SceneDelta(changed=(addition,))
        else:
            delta = SceneDelta(attached=(addition,))
        if not getattr(self.session, "is_lost", False):
            self.session.apply(delta)

    def update(self, depsgraph, visible=None) -> Edit | None:
        """Send what changed since the last time; None when nothing did.

        Raises
        ------
        EngineLost    The session's process is gone; a new feed has to be made.
        """
        step = self.sync.walk(depsgraph, visible)
        self.report = step.report
        if not step.delta:
            return None
        start = time.perf_counter()
        for part in step.parts(PART_BYTES):
            self.session.apply(part)
        seconds = time.perf_counter() - start
        self.last = Edit(step.stats, seconds, self.session.revision)
        return self.last
