"""From a Blender scene to an engine's session: what changed is walked, sent and told."""

import time
from dataclasses import dataclass

from ...imports import loaded_when_used
from ..foundation.report import ConversionReport
from .animation import FrameTimes

with loaded_when_used():
    from ..sync import scene_sync
    from ..sync import step as sync_step


@dataclass(frozen=True)
class Edit:
    """What one update did.

    Parameters
    ----------
    stats : SyncStats    Of the walk.
    transfer_seconds : float    Handing over to the engine.
    revision : int    Of the engine's scene from then on; frames with it show the edit.
    """

    stats: "sync_step.SyncStats"
    transfer_seconds: float
    revision: int


class SceneFeed:
    """Keeps the scene of an engine's session equal to a Blender scene.

    Parameters
    ----------
    session : Session or RemoteSession    With an empty scene.
    final : bool    Whether objects that are hidden in renders are left out.
    texels : int or None    As of `SceneSync`.

    Attributes
    ----------
    frames : FrameTimes    Of the animation whose frames it is for.
    """

    def __init__(self, session, final: bool = False, texels: int | None = None):
        self.session = session
        self.sync = scene_sync.SceneSync(final, texels)
        self.report = ConversionReport()
        self.frames = FrameTimes()
        self.last: Edit | None = None

    def update(self, depsgraph, visible=None, is_moment: bool = False) -> Edit | None:
        """Send what changed since the last time; None when nothing did.

        ``is_moment``: as of `SceneSync.walk`.

        Raises
        ------
        EngineLost    The session's process is gone; a new feed has to be made.
        """
        if is_moment:
            # The graph is that of the frame, at another time.
            self.sync.tag(depsgraph.updates)
        step = self.sync.walk(depsgraph, visible, is_moment)
        self.report = step.report
        if not step.delta:
            return None
        start = time.perf_counter()
        for part in step.parts(sync_step.PART_BYTES):
            self.session.apply(part)
        seconds = time.perf_counter() - start
        self.last = Edit(step.stats, seconds, self.session.revision)
        return self.last
