"""Pigment layers of Blender as surfaces of the engine."""

from dataclasses import replace

from ...engine.errors import LumenrayError
from ...engine.scene.material import Measured
from ..file_assets.kind import NotReadyError
from ..foundation.report import ConversionReport
from .tables import ink_tables


def convert_ink(
    settings, report: ConversionReport, datablock: str, remedy: str, is_patient: bool = True
) -> Measured | None:
    """Convert the composition of a material.

    Parameters
    ----------
    settings : LumenrayInkSettings
    report, datablock : ConversionReport, str    Where departures go.
    remedy : str    What is used where it cannot be computed, for the report.
    is_patient : bool    Whether to wait for a layer that is being computed.

    Returns
    -------
    Measured or None    None when it cannot be computed, or is not yet.
    """
    try:
        printed = ink_tables.obtain(settings, is_patient)
    except NotReadyError as error:
        report.info(datablock, str(error), f"{remedy} until it is computed")
        return None
    except LumenrayError as error:
        report.miss(datablock, str(error), remedy)
        return None
    for note in printed.notes:
        report.info(datablock, note, "it is used so")
    # Both sides are one table, which did not come through the border between processes as one.
    surface = printed.surface
    return replace(surface, back_reflection=surface.front_reflection)
