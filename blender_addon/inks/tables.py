"""Tables of pigment layers, computed once for each composition in the engine's processes while Blender goes on."""

import os

from ...imports import loaded_when_used
from ..compositions.tables import CompositionTables
from ..surface_models import INK, is_modelled

with loaded_when_used():
    from . import description

REST = 1.0
"""How long sliders must have been still before a layer is computed. [s]"""


def is_ink(material) -> bool:
    """Whether a material is a pigment layer by its composition."""
    return is_modelled(material, INK)


class InkTables(CompositionTables):
    """What pigment layers scatter; a reading is a `PrintedSurface`."""

    def describe(self, settings) -> dict:
        return description.describe(settings)

    def qualities(self, settings) -> tuple[str, ...]:
        return (settings.quality,)

    def compute(self, text, qualities, job):
        return compute(text, "DRAFT" in qualities, job)


def compute(text: str, is_draft: bool, job):
    """Compute what a description in JSON scatters, a `PrintedSurface`; raises as `CompositionTables.compute_with`.

    Parameters
    ----------
    job : file_assets.shelf.Job    Stopped, it ends; what was solved is kept.
    """
    processes = max((os.cpu_count() or 2) - 1, 1)
    return ink_tables.compute_with(
        lambda session, report: session.compute_ink(text, is_draft, processes, report), job
    )


ink_tables = InkTables(INK, "pigment layer", REST)
