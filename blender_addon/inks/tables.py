"""Tables of pigment layers, computed once for each composition in the engine's processes while Blender goes on."""

import os

import bpy

from ...engine.errors import Cancelled
from ...imports import loaded_when_used
from ..file_assets.kind import FileKind
from ..foundation import engine_process
from ..surface_models import INK

with loaded_when_used():
    from . import description

KEPT = 32
"""Layers that are kept, of 8 MB each or so."""

REST = 1.0
"""How long sliders must have been still before a layer is computed. [s]"""

STOPPED = "the pigment layer was not computed: stopped"


def is_ink(material) -> bool:
    """Whether a material is a pigment layer by its composition."""
    settings = material.lumenray
    return settings.use_override and settings.model == INK


class InkTables(FileKind):
    """What compositions scatter; a reading is a `PrintedSurface`."""

    noun = "pigment layer"
    under_way = "its pigment layer is being computed ({share:.0f} %)"
    stopped = "its pigment layer was not computed: stopped"
    fault = "its pigment layer cannot be computed ({cause}); please send its description to the developers"
    is_stopped_unwanted = True

    def source(self, settings) -> tuple:
        content, quality = description.describe(settings), settings.quality

        def prepare():
            text = description.to_text(content)
            return lambda job: compute(text, quality == "DRAFT", job)

        return (description.digest_of(content, quality),), prepare

    def users(self):
        return (material for material in bpy.data.materials if is_ink(material))

    def absolute_path(self, settings) -> str:
        return ""

    def place_of(self, settings) -> str:
        return ""

    def name_of(self, settings) -> str:
        return settings.name or "pigment layer"


def compute(text: str, is_draft: bool, job):
    """Compute what a description scatters, in the engine's processes.

    Parameters
    ----------
    text : str    JSON.
    is_draft : bool
    job : file_assets.shelf.Job    Told how far it is; its ``stop`` ends the work, of which what was solved is kept.

    Returns
    -------
    engine.ink.surface.PrintedSurface

    Raises
    ------
    Cancelled    It was stopped.
    LumenrayError    It cannot be computed.
    """
    if not bpy.app.background and job.stop.wait(REST):
        raise Cancelled(STOPPED)
    session = engine_process.open_session("ink")

    def report(progress):
        job.tell(progress.done)
        if job.stop.is_set():
            session.cancel()

    try:
        if job.stop.is_set():
            raise Cancelled(STOPPED)
        processes = max((os.cpu_count() or 2) - 1, 1)
        return session.compute_ink(text, is_draft, processes, report)
    finally:
        session.close()


ink_tables = InkTables(KEPT, "lumenray-ink")
