"""Pigment layers of Blender as surfaces of the engine."""

from dataclasses import replace

from ...engine.scene.material import Measured
from ..compositions.convert import obtain_table
from ..foundation.report import ConversionReport
from .tables import ink_tables


def convert_ink(
    settings, report: ConversionReport, datablock: str, remedy: str, is_patient: bool = True
) -> Measured | None:
    """Convert the composition of a material; parameters as of `compositions.convert.obtain_table`.

    Returns
    -------
    Measured or None    None when it cannot be computed, or is not yet.
    """
    printed = obtain_table(ink_tables, settings, report, datablock, remedy, is_patient)
    if printed is None:
        return None
    # Both sides are one table, which did not come through the border between processes as one.
    return replace(printed.surface, back_reflection=printed.surface.front_reflection)
