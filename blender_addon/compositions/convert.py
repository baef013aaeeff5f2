"""Compositions of Blender as surfaces of the engine."""

from ...engine.errors import LumenrayError
from ..file_assets.kind import NotReadyError
from ..foundation.report import ConversionReport
from .tables import CompositionTables


def obtain_table(
    tables: CompositionTables,
    settings,
    report: ConversionReport,
    datablock: str,
    remedy: str,
    is_patient: bool = True,
):
    """Return what the composition of a material scatters.

    Parameters
    ----------
    settings : bpy.types.PropertyGroup    Of its composition.
    report, datablock : ConversionReport, str    Where departures go.
    remedy : str    What is used where it cannot be computed, for the report.
    is_patient : bool    Whether to wait for one that is being computed.

    Returns
    -------
    object or None    A reading of ``tables``; None when it cannot be computed, or is not yet.
    """
    try:
        made = tables.obtain(settings, is_patient)
    except NotReadyError as error:
        report.info(datablock, str(error), f"{remedy} until it is computed")
        return None
    except LumenrayError as error:
        report.miss(datablock, str(error), remedy)
        return None
    for note in made.notes:
        report.info(datablock, note, "it is used so")
    return made
