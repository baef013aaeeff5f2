"""Tables of paints, computed once for each composition in the engine's process while Blender goes on."""

import bpy

from ...engine.errors import Cancelled
from ...imports import loaded_when_used
from ..file_assets.kind import FileKind
from ..foundation import engine_process
from ..surface_models import PAINT

with loaded_when_used():
    from . import description

KEPT = 32
"""Paints that are kept, of 8 MB each or so."""

REST = 0.4
"""How long sliders must have been still before a table is computed, which spheres need not wait for. [s]"""


def is_paint(material) -> bool:
    """Whether a material is a paint by its composition."""
    settings = material.lumenray
    return settings.use_override and settings.model == PAINT


class PaintTables(FileKind):
    """What compositions scatter; a reading is a `PaintedSurface`."""

    noun = "paint"
    under_way = "its paint is being computed ({share:.0f} %)"
    stopped = "its paint was not computed: stopped"
    fault = "its paint cannot be computed ({cause}); please send its description to the developers"
    is_stopped_unwanted = True

    def source(self, settings) -> tuple:
        content = description.describe(settings)

        def prepare():
            text = description.to_text(content)
            return lambda job: compute(text, job)

        return (description.digest_of(content),), prepare

    def users(self):
        return (material for material in bpy.data.materials if is_paint(material))

    def absolute_path(self, settings) -> str:
        return ""

    def place_of(self, settings) -> str:
        return ""

    def name_of(self, settings) -> str:
        return settings.name or "paint"


def compute(text: str, job):
    """Compute what a description scatters, in the engine's process.

    Parameters
    ----------
    text : str    JSON.
    job : file_assets.shelf.Job    Told how far it is; its ``stop`` ends the work.

    Returns
    -------
    engine.paint.surface.PaintedSurface

    Raises
    ------
    Cancelled    It was stopped.
    LumenrayError    It cannot be computed.
    """
    if not bpy.app.background and job.stop.wait(REST):
        raise Cancelled("the paint was not computed: stopped")
    session = engine_process.open_session("paint")

    def report(progress):
        job.tell(progress.done)
        if job.stop.is_set():
            session.cancel()

    try:
        if job.stop.is_set():
            raise Cancelled("the paint was not computed: stopped")
        return session.compute_paint(text, report)
    finally:
        session.close()


paint_tables = PaintTables(KEPT, "lumenray-paint")
