"""Measured materials of Blender as surfaces of the engine."""

from ...engine.errors import LumenrayError, SceneError
from ...engine.scattering.data.record import SIDES, ScatteringFile
from ...engine.scattering.data.surface import ROUNDING, excess_of
from ...engine.scene.material import Measured
from ...engine.scene.scattering import Scatter
from ..file_assets.kind import NotReadyError
from ..foundation.report import ConversionReport
from .files import scattering_files

LARGE_ERROR = 0.1
"""Stated error of a table from which the user is warned."""


def convert_measured(
    settings, report: ConversionReport, datablock: str, remedy: str, is_patient: bool = True
) -> Measured | None:
    """Convert the measured model of a material.

    Parameters
    ----------
    settings : LumenrayMeasuredSettings
    report, datablock : ConversionReport, str    Where departures go.
    remedy : str    What is used where the file cannot be, for the report.
    is_patient : bool    Whether to wait for a file that is being read.

    Returns
    -------
    Measured or None    None when its file cannot be read, or is not read yet.
    """
    try:
        reading = scattering_files.obtain(settings, is_patient)
        sides = find_sides(reading.file, settings)
    except NotReadyError as error:
        report.info(datablock, str(error), f"{remedy} until it is read")
        return None
    except LumenrayError as error:
        report.miss(datablock, str(error), remedy)
        return None
    for remark in reading.file.remarks:
        report.info(scattering_files.name_of(settings), str(remark), "the file is read so")
    surface = Measured(**sides, rotation=settings.rotation)
    _remark(surface, report, datablock)
    return surface


def find_sides(file: ScatteringFile, settings) -> dict[str, Scatter | None]:
    """Return what the sides of a surface do, by the names of `SIDES`; sides that do the same share one object.

    Raises
    ------
    SceneError    The file tells of no side.
    """
    told = {name: file.sides.get(name) for name in SIDES}
    if not any(each is not None for each in told.values()):
        raise SceneError(f"{file.path} holds no scattering of any side")
    if settings.is_turned:
        told = {_opposite(name): each for name, each in told.items()}
    if settings.back == "SAME":
        told = {
            name: told[_opposite(name)] if each is None else each for name, each in told.items()
        }
    return told


def _opposite(name: str) -> str:
    """Name of the same on the other side."""
    side, kind = name.split("_")
    return f"{'back' if side == 'front' else 'front'}_{kind}"


def _remark(surface: Measured, report: ConversionReport, datablock: str) -> None:
    """Note what is to be known of a surface."""
    for side in ("front", "back"):
        parts = (getattr(surface, f"{side}_reflection"), getattr(surface, f"{side}_transmission"))
        excess = excess_of(*parts)
        if excess > 1.0 + ROUNDING:
            report.warn(
                datablock,
                f"its {side} sends away up to {100.0 * excess:.1f} % of the light that comes",
                "it is scaled down to 100 % where it is more",
            )
    error = max(getattr(getattr(surface, name), "error", 0.0) for name in SIDES)
    if error > LARGE_ERROR:
        report.warn(
            datablock,
            f"its data could be brought onto another grid to {100.0 * error:.0f} % only",
            "they are used as they came out",
        )
    if surface.has_grain:
        report.info(
            datablock,
            "its scattering has a direction, which follows the UV map",
            "meshes without a UV map take the world's X for it",
        )
