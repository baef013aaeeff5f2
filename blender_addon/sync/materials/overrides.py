"""Surfaces from the measurable parameters that a user states in place of a node tree."""

import numpy as np

from ....engine.errors import LumenrayError
from ....engine.formats.data_sheet import read_data_sheet
from ....engine.scene.material import (
    Black,
    Cauchy,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Emission,
    IorTable,
    RefractiveIndex,
    Surface,
    ThinGlass,
)
from ....engine.scene.spectrum import Constant, Rgb, Spectrum, Tabulated
from ...foundation.report import ConversionReport
from ...scattering.convert import convert_measured
from ...scattering.source import MEASURED
from ..spectra import convert_spectrum, read_file

HELIUM_D = 587.56
"""Wavelength at which a dispersive index is taken where only one number fits. [nm]"""

MISSING_REFLECTANCE = 0.5
"""Diffuse reflectance in place of a scattering file that cannot be used. [-]"""


def convert_override(
    settings, report: ConversionReport, datablock: str, is_patient: bool = True
) -> tuple[Surface, Emission | None]:
    """Return the surface and the emission that a material's settings state.

    Parameters
    ----------
    settings : LumenrayMaterialSettings    With `use_override` on.
    report, datablock : ConversionReport, str    Where departures go.
    is_patient : bool    Whether to wait for a scattering file that is being read.
    """
    if settings.model == "EMITTER":
        try:
            spectrum = convert_spectrum(settings, settings.reflectance_color, report, datablock)
        except LumenrayError as error:
            report.fault(datablock, error, "the material does not shine")
            return Black(), None
        emission = Emission(spectrum, settings.luminance, None, settings.two_sided)
        return Black(), emission if settings.luminance > 0 else None
    if settings.model == MEASURED:
        return _measured(settings, report, datablock, is_patient), None
    return _SURFACES[settings.model](settings, report, datablock), None


def _reflectance(settings, report, datablock) -> Spectrum:
    if settings.reflectance_source == "COLOR":
        red, green, blue = settings.reflectance_color
        return Constant(red) if red == green == blue else Rgb(red, green, blue)
    if settings.reflectance_source == "FILE":
        remedy = f"reflectance {settings.reflectance:.3g} is used"
        table = read_file(settings, "reflectance_file", report, datablock, remedy)
        if table is not None and table.values.min() >= 0 and table.values.max() <= 1:
            return table
        if table is not None:
            problem = f"{table.name} holds reflectances outside 0..1, perhaps per cent"
            report.miss(datablock, problem, remedy)
    return Constant(settings.reflectance)


def _diffuse(settings, report, datablock):
    reflectance = _reflectance(settings, report, datablock)
    transmittance = settings.transmittance
    left = max(1.0 - _largest(reflectance), 0.0)
    if transmittance > left + 1e-6:
        report.warn(
            datablock,
            f"Reflectance plus transmittance {transmittance:.3g} exceeds 1",
            f"the transmittance is reduced to {left:.3g}",
        )
        transmittance = left
    return Diffuse(reflectance, Constant(transmittance) if transmittance > 0 else None)


def _largest(spectrum):
    if isinstance(spectrum, Tabulated):
        return float(spectrum.values.max())
    if isinstance(spectrum, Rgb):
        return max(spectrum.red, spectrum.green, spectrum.blue)
    return spectrum.value


def _coated(settings, report, datablock):
    ior = _single_index(_refractive_index(settings, report, datablock))
    return Coated(_reflectance(settings, report, datablock), ior, settings.roughness)


def _conductor(settings, report, datablock):
    return Conductor(settings.metal, settings.roughness)


def _dielectric(settings, report, datablock):
    return Dielectric(_refractive_index(settings, report, datablock), settings.roughness)


def _pane(settings, report, datablock):
    if settings.pane_source == "FILE":
        remedy = "clear glass by its refractive index is used"
        table = read_file(
            settings, "pane_file", report, datablock, remedy, read_data_sheet, "data sheet"
        )
        if table is not None:
            return table
    ior = _single_index(_refractive_index(settings, report, datablock))
    return ThinGlass(ior, Constant(settings.transmittance))


def _measured(settings, report, datablock, is_patient):
    remedy = f"diffuse grey {MISSING_REFLECTANCE} is used"
    surface = convert_measured(settings.measured, report, datablock, remedy, is_patient)
    return Diffuse(Constant(MISSING_REFLECTANCE)) if surface is None else surface


def _refractive_index(settings, report, datablock) -> RefractiveIndex:
    if settings.ior_source == "CAUCHY":
        return Cauchy(settings.ior, settings.cauchy_b)
    if settings.ior_source == "FILE":
        remedy = f"refractive index {settings.ior:.4g} is used"
        table = read_file(settings, "ior_file", report, datablock, remedy)
        if table is not None and table.values.min() >= 1:
            return IorTable(table.wavelengths, table.values)
        if table is not None:
            report.miss(datablock, f"{table.name} holds refractive indices below 1", remedy)
    return Cauchy(settings.ior, 0.0)


def _single_index(index: RefractiveIndex) -> float:
    if isinstance(index, IorTable):
        return float(np.interp(HELIUM_D, index.wavelengths, index.values))
    return index.a + index.b / (HELIUM_D / 1000) ** 2


_SURFACES = {
    "DIFFUSE": _diffuse,
    "COATED": _coated,
    "CONDUCTOR": _conductor,
    "DIELECTRIC": _dielectric,
    "THIN_GLASS": _pane,
}
