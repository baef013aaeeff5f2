"""Effect paints of Blender as surfaces of the engine."""

from dataclasses import replace

from ...engine.errors import LumenrayError
from ...engine.scene.material import Measured
from ..file_assets.kind import NotReadyError
from ..foundation.report import ConversionReport
from .tables import paint_tables


def convert_paint(
    settings, report: ConversionReport, datablock: str, remedy: str, is_patient: bool = True
) -> Measured | None:
    """Convert the composition of a material.

    Parameters
    ----------
    settings : LumenrayPaintSettings
    report, datablock : ConversionReport, str    Where departures go.
    remedy : str    What is used where it cannot be computed, for the report.
    is_patient : bool    Whether to wait for a paint that is being computed.

    Returns
    -------
    Measured or None    None when it cannot be computed, or is not yet.
    """
    try:
        painted = paint_tables.obtain(settings, is_patient)
    except NotReadyError as error:
        report.info(datablock, str(error), f"{remedy} until it is computed")
        return None
    except LumenrayError as error:
        report.miss(datablock, str(error), remedy)
        return None
    for note in painted.notes:
        report.info(datablock, note, "it is used so")
    surface = painted.surface
    # Both sides are one table, which did not come through the border between processes as one.
    surface = replace(surface, back_reflection=surface.front_reflection)
    return surface if settings.use_sparkle else replace(surface, sparkles=())
