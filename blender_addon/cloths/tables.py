"""Tables of cloths, computed once for each composition in the engine's process while Blender goes on."""

from ...imports import loaded_when_used
from ..compositions.tables import CompositionTables
from ..surface_models import CLOTH, is_modelled

with loaded_when_used():
    from . import description

REST = 1.0
"""How long sliders must have been still before a cloth is computed. [s]"""


def is_cloth(material) -> bool:
    """Whether a material is a cloth by its composition."""
    return is_modelled(material, CLOTH)


class ClothTables(CompositionTables):
    """What cloths scatter; a reading is a `WovenSurface`."""

    def describe(self, settings) -> dict:
        return description.describe(settings)

    def qualities(self, settings) -> tuple[str, ...]:
        return (settings.quality,)

    def compute(self, text, qualities, job):
        return compute(text, "DRAFT" in qualities, job)


def compute(text: str, is_draft: bool, job):
    """Compute what a description in JSON scatters, a `WovenSurface`; raises as `CompositionTables.compute_with`."""
    return cloth_tables.compute_with(
        lambda session, report: session.compute_cloth(text, is_draft, report), job
    )


cloth_tables = ClothTables(CLOTH, "cloth", REST)
