"""Ray files of Blender's lights as lights of the engine."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...engine.errors import LumenrayError
from ...engine.scene.light import Luminaire, Output, Quantity
from ...engine.scene.ray_emission import RayEmission
from ...engine.scene.spectrum import Spectrum, Tabulated
from ..file_assets.kind import NotReadyError
from ..foundation.pose import pose_of
from ..foundation.report import ConversionReport
from .files import ray_files

LEFT_OUT = "the light is left out"

JOINS = "the light joins when they are ready"
"""What is done about a light whose rays are being prepared."""


def convert_rays(
    source,
    settings,
    light_id: str,
    name: str,
    matrix,
    scale: float,
    report: ConversionReport,
    own_spectrum: Callable[[], Spectrum],
    is_patient: bool = True,
) -> Luminaire | None:
    """Convert a light that shines as a ray file says.

    Parameters
    ----------
    source : bpy.types.Object    Evaluated.
    settings : LumenrayRaysetSettings    Evaluated.
    light_id, name : str
    matrix : (4, 4) array    World matrix, in Blender units.
    scale : float    Metres per Blender unit.
    report : ConversionReport
    own_spectrum : callable    Returns the spectrum that is chosen in Blender.
    is_patient : bool    Whether to wait for a file that is being prepared.

    Returns
    -------
    Luminaire or None    None when it emits nothing, its file cannot be read, or is not ready yet.
    """
    try:
        made = ray_files.obtain(settings, is_patient)
        pose = pose_of(matrix, scale)
    except NotReadyError as error:
        report.info(name, str(error), JOINS)
        return None
    except LumenrayError as error:
        report.fault(name, error, LEFT_OUT)
        return None
    for remark in made.remarks:
        report.info(ray_files.name_of(settings), str(remark), "the file is read so")
    flux = luminous_flux(settings, made)
    if flux is None:
        report.error(name, "the ray file states no lumens", f"{LEFT_OUT}; state the flux")
        return None
    if flux <= 0.0:
        return None
    if pose.is_scaled or pose.is_sheared:
        report.warn(name, "the object is scaled", "the rays keep the size that their file states")
    if pose.is_mirrored:
        report.warn(name, "the object is mirrored", "the rays are not")
    frame = pose.frame.copy()
    frame[:3, 3] += frame[:3, :3] @ made.centre
    if settings.spectrum_source == "FILE" and made.spectrum is not None:
        spectrum = Tabulated(
            *(np.asarray(each, np.float64) for each in made.spectrum), ray_files.name_of(settings)
        )
        emission = made.emission
    else:
        try:
            spectrum = own_spectrum()
        except LumenrayError as error:
            report.error(name, str(error), LEFT_OUT)
            return None
        emission = made.emission
        if settings.spectrum_source == "LIGHT" and emission.wavelength is not None:
            emission = replace(emission, wavelength=None)
    if not is_patient:
        emission = without_rays(emission)
    return Luminaire(
        id=light_id,
        name=name,
        output=Output(Quantity.LUMINOUS_FLUX, flux, spectrum),
        frame=frame,
        distribution=made.distribution,
        visible_to_camera=source.visible_camera,
        rays=emission,
    )


def without_rays(emission: RayEmission) -> RayEmission:
    """Return an emission for the live view, which sees a point: what a moved light sends to the engine stays small."""
    return replace(
        emission,
        position=emission.position[:0],
        direction=emission.direction[:0],
        factor=emission.factor[:0],
        threshold=emission.threshold[:0],
        other=emission.other[:0],
        wavelength=None,
    )


def luminous_flux(settings, made) -> float | None:
    """Flux with every factor, None where neither the file nor the settings tell it. [lm]"""
    stated = settings.luminous_flux if settings.amount == "LUMENS" else made.luminous_flux
    return None if stated is None else stated * settings.dimming
