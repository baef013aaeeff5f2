"""Luminaires of Blender as luminaires of the engine: placement, orientation, opening, amount and spectrum."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...engine.errors import LumenrayError
from ...engine.luminaires.amount import Amount, tilt_factor
from ...engine.luminaires.distribution import mirrored, turned
from ...engine.luminaires.formats.record import RADIANT, LuminaireFile
from ...engine.luminaires.openings import SMALLEST
from ...engine.photometry.spectra import efficacy_of_all
from ...engine.scene.distribution import IntensityDistribution, Opening
from ...engine.scene.light import Luminaire, Output, Quantity
from ...engine.scene.spectrum import Illuminant, Spectrum
from ..foundation.pose import Pose, pose_of
from ..foundation.report import ConversionReport
from .files import Reading, photometric_files
from .housing import make_housing

LEFT_OUT = "the light is left out"
"""What is done about a luminaire that cannot be taken over: none at all is better than a wrong one."""

NOTHING_VISIBLE = "it lights nothing visible"
"""What is done about watts without a spectrum."""

_OTHER_WAY = np.diag([1.0, 1.0, -1.0])


def convert_luminaire(
    source,
    settings,
    light_id: str,
    name: str,
    matrix,
    scale: float,
    report: ConversionReport,
    own_spectrum: Callable[[], Spectrum],
) -> Luminaire | None:
    """Convert a light or an empty that shines as a photometric file says.

    Parameters
    ----------
    source : bpy.types.Object    Evaluated.
    settings : LuminaireSettings    Evaluated, of the object or its light.
    light_id, name : str
    matrix : (4, 4) array    World matrix, in Blender units.
    scale : float    Metres per Blender unit.
    report : ConversionReport
    own_spectrum : callable    Returns the spectrum that is chosen in Blender.

    Returns
    -------
    Luminaire or None    None when it emits nothing, or its file cannot be read.
    """
    try:
        reading = photometric_files.obtain(settings)
        pose = pose_of(matrix, scale)
        spectrum = _find_spectrum(source, settings, reading, own_spectrum)
        amount = find_amount(settings, reading, pose.frame, spectrum)
    except LumenrayError as error:
        report.fault(name, error, LEFT_OUT)
        return None
    _remark(settings, reading, name, report)
    if reading.file.quantity == RADIANT and not _can_be_seen(
        reading, spectrum, amount, name, report
    ):
        return None
    if amount.luminous_flux <= 0.0:
        return None
    opening = find_opening(source, settings, reading.file, pose)
    if settings.emission == "OPENING" and opening.shape != "point" and pose.is_scaled:
        report.warn(
            name, "the object is scaled", "the luminous opening keeps the size that its file states"
        )
    if pose.is_sheared:
        report.warn(name, "the object is sheared", "its axes are taken as perpendicular")
    return Luminaire(
        id=light_id,
        name=name,
        output=Output(Quantity.LUMINOUS_FLUX, amount.luminous_flux, spectrum or Illuminant("D65")),
        frame=pose.frame,
        distribution=reflected(orient(settings, reading.file), pose),
        opening=opening,
        visible_to_camera=source.visible_camera,
    )


def find_housing(source, settings, scale: float):
    """Return the housing of a luminaire as an obstacle for others' light, and its rigid frame. (Geometry, (4, 4) array [m])

    Parameters
    ----------
    source : bpy.types.Object    The luminaire, evaluated.
    settings : LuminaireSettings
    scale : float    Metres per Blender unit.

    Raises
    ------
    LumenrayError    The file cannot be read, or the housing cannot stand anywhere.
    """
    file = photometric_files.obtain(settings).file
    pose = pose_of(source.matrix_world, scale)
    distribution = reflected(orient(settings, file), pose)
    return make_housing(file, distribution, find_opening(source, settings, file, pose)), pose.frame


def orient(settings, file: LuminaireFile) -> IntensityDistribution:
    """Return a file's distribution in the object's own axes, turned and mirrored as the settings say."""
    distribution = file.distribution
    if settings.flip_h and file.photometric_type == "B":
        distribution = replace(distribution, frame=distribution.frame @ _OTHER_WAY)
    if settings.mirror and file.photometric_type == "C":
        distribution = mirrored(distribution)
    return turned(distribution, settings.rotation) if settings.rotation else distribution


def reflected(distribution: IntensityDistribution, pose: Pose) -> IntensityDistribution:
    """Return a distribution of an object's axes in those of its rigid frame: a mirrored object mirrors its light."""
    return mirrored(distribution) if pose.is_mirrored else distribution


def states_spectrum(source, settings) -> bool:
    """Whether a luminaire has a spectrum of its own in Blender rather than a mere colour."""
    owner = settings if source is None or source.type == "EMPTY" else source.data.lumenray
    return owner.spectrum != "RGB" and getattr(owner, "use_physical", True)


def _find_spectrum(source, settings, reading, own_spectrum) -> Spectrum | None:
    """The spectrum by the choice in the settings; None of radiant files if it is not known."""
    if settings.spectrum_source == "FILE":
        return reading.lamp_spectrum.spectrum
    if reading.file.quantity == RADIANT and not states_spectrum(source, settings):
        return None
    return own_spectrum()


def _can_be_seen(reading, spectrum, amount: Amount, name, report) -> bool:
    """Whether anything of a radiant luminaire's light is visible; notes what had to be assumed, or that it is not."""
    if amount.luminous_flux > 0.0:
        if spectrum is None:
            report.warn(name, "the lumens are stated, but no spectrum is known", "CIE D65 is used")
        return True
    if spectrum is None:
        # That ultraviolet cannot be seen is right; of anything else light is missing.
        note = report.warn if reading.lamp_spectrum.is_ultraviolet else report.error
        note(name, f"its {reading.flux:.4g} W have no spectrum", NOTHING_VISIBLE)
    elif amount.file_flux <= 0.0 < reading.flux:
        report.warn(
            name, f"none of its {reading.flux:.4g} W is visible by its spectrum", NOTHING_VISIBLE
        )
    return False


def find_amount(settings, reading: Reading, matrix, spectrum: Spectrum | None = None) -> Amount:
    """Return how much light a luminaire gives, with every factor.

    Parameters
    ----------
    settings : LuminaireSettings
    reading : Reading
    matrix : (4, 4) array    Of the object in the world, for its tilt.
    spectrum : Spectrum or None    That makes lumens of the watts of a radiant file; without one there are none.

    Raises
    ------
    SceneError    A number is out of its range.
    """
    return Amount(
        file_flux=_lumens_of(reading, spectrum),
        stated_flux=settings.luminous_flux if settings.amount == "LUMENS" else None,
        lamp_factor=settings.lamp_factor,
        tilt_factor=tilt_factor(reading.file.tilt, tilt_of(matrix)),
        dimming=settings.dimming,
        maintenance_factor=settings.maintenance_factor,
    )


def _lumens_of(reading: Reading, spectrum: Spectrum | None) -> float:
    if reading.file.quantity != RADIANT:
        return reading.flux
    return 0.0 if spectrum is None else reading.flux * efficacy_of_all(spectrum)


def tilt_of(matrix) -> float:
    """Angle between the luminaire's -z and straight down. [degree]"""
    axis = np.array(matrix, dtype=np.float64)[:3, 2]
    return float(np.degrees(np.arctan2(np.hypot(axis[0], axis[1]), axis[2])))


def find_opening(source, settings, file: LuminaireFile, pose: Pose) -> Opening:
    """Return what emits the light, by the choice in the settings."""
    if settings.emission == "OPENING":
        return file.opening
    if settings.emission == "POINT" or source.type != "LIGHT":
        return Opening()
    return own_opening(source.data, pose)


def own_opening(data, pose: Pose) -> Opening:
    """Return the size of a point, spot or area light of Blender as an opening.

    Parameters
    ----------
    data : bpy.types.Light
    pose : Pose    Its scale counts, as it does for Blender.
    """
    x, y, z = pose.lengths
    if data.type != "AREA":
        diameter = 2.0 * data.shadow_soft_size * float(np.cbrt(x * y * z))
        if diameter < SMALLEST:
            return Opening()
        return Opening("ellipsoid", (diameter, diameter, diameter))
    is_oblong = data.shape in {"RECTANGLE", "ELLIPSE"}
    size = (data.size * x, (data.size_y if is_oblong else data.size) * y, 0.0)
    if min(size[:2]) < SMALLEST:
        return Opening()
    return Opening("ellipse" if data.shape in {"DISK", "ELLIPSE"} else "rectangle", size)


def _remark(settings, reading, name, report) -> None:
    """Note what is to be known of the file; under its own name, so that lights that share it share the rows."""
    for remark in reading.file.remarks:
        report.info(photometric_files.name_of(settings), str(remark), "the file is read so")
    if photometric_files.has_changed(settings, reading):
        what = "embedded photometric file" if settings.text is not None else "photometric file"
        report.warn(
            name,
            f"the {what} '{photometric_files.name_of(settings)}' was edited since it was loaded",
            "what it says now is used",
        )
