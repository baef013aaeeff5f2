"""Effect paints of Blender as surfaces of the engine."""

from dataclasses import replace

from ...engine.scene.material import Measured
from ..compositions.convert import obtain_table
from ..foundation.report import ConversionReport
from .tables import paint_tables


def convert_paint(
    settings, report: ConversionReport, datablock: str, remedy: str, is_patient: bool = True
) -> Measured | None:
    """Convert the composition of a material; parameters as of `compositions.convert.obtain_table`.

    Returns
    -------
    Measured or None    None when it cannot be computed, or is not yet.
    """
    painted = obtain_table(paint_tables, settings, report, datablock, remedy, is_patient)
    if painted is None:
        return None
    surface = painted.surface
    # Both sides are one table, which did not come through the border between processes as one.
    surface = replace(surface, back_reflection=surface.front_reflection)
    return surface if settings.use_sparkle else replace(surface, sparkles=())
