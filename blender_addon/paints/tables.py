"""Tables of paints, computed once for each composition in the engine's process while Blender goes on."""

from ...imports import loaded_when_used
from ..compositions.tables import CompositionTables
from ..surface_models import PAINT, is_modelled

with loaded_when_used():
    from . import description

REST = 0.4
"""How long sliders must have been still before a table is computed, which spheres need not wait for. [s]"""


def is_paint(material) -> bool:
    """Whether a material is a paint by its composition."""
    return is_modelled(material, PAINT)


class PaintTables(CompositionTables):
    """What paints scatter; a reading is a `PaintedSurface`."""

    def describe(self, settings) -> dict:
        return description.describe(settings)

    def compute(self, text, qualities, job):
        return compute(text, job)


def compute(text: str, job):
    """Compute what a description in JSON scatters, a `PaintedSurface`; raises as `CompositionTables.compute_with`."""
    return paint_tables.compute_with(
        lambda session, report: session.compute_paint(text, report), job
    )


paint_tables = PaintTables(PAINT, "paint", REST)
