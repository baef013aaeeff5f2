"""Surfaces from the measurable parameters that a user states in place of a node tree."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ....engine.errors import LumenrayError
from ....engine.scene.colour import largest_of
from ....engine.scene.material import (
    Black,
    Cauchy,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Emission,
    Fabric,
    IorTable,
    RefractiveIndex,
    Surface,
    TabulatedPane,
    ThinGlass,
)
from ....engine.scene.spectrum import Constant, Rgb, Spectrum
from ....imports import loaded_when_used
from ...cloths.convert import convert_cloth
from ...foundation.report import ConversionReport
from ...inks.convert import convert_ink
from ...paints.convert import convert_paint
from ...scattering.convert import convert_measured
from ...scattering.files import MEASURED
from ...surface_models import CLOTH, INK, PAINT
from ..spectra import convert_spectrum, read_file

with loaded_when_used():
    from ....engine.formats import data_sheet

HELIUM_D = 587.56
"""Wavelength at which a dispersive index is taken where only one number fits. [nm]"""

MISSING_REFLECTANCE = 0.5
"""Diffuse reflectance in place of a scattering file, a paint, a print or a cloth that cannot be used. [-]"""


@dataclass(frozen=True)
class Statement:
    """What a user states of a surface.

    Parameters
    ----------
    settings : LumenrayMaterialSettings    With `use_override` on.
    report, datablock : ConversionReport, str    Where departures go.
    is_patient : bool    Whether to wait for a scattering file that is being read.
    """

    settings: object
    report: ConversionReport
    datablock: str
    is_patient: bool = True

    def read(self, name: str, remedy: str, *reader):
        """Read the file that a property names, as `read_file`."""
        return read_file(self.settings, name, self.report, self.datablock, remedy, *reader)


def convert_override(
    settings, report: ConversionReport, datablock: str, is_patient: bool = True
) -> tuple[Surface, Emission | None]:
    """Return the surface and the emission that a material's settings state; parameters as of `Statement`."""
    stated, emit = Statement(settings, report, datablock, is_patient), EMITTING.get(settings.model)
    return MAKERS[settings.model](stated), None if emit is None else emit(stated)


def _reflectance(stated: Statement) -> Spectrum:
    settings = stated.settings
    if settings.reflectance_source == "COLOR":
        red, green, blue = settings.reflectance_color
        return Constant(red) if red == green == blue else Rgb(red, green, blue)
    if settings.reflectance_source == "FILE":
        remedy = f"reflectance {settings.reflectance:.3g} is used"
        table = stated.read("reflectance_file", remedy)
        if table is not None and table.values.min() >= 0 and table.values.max() <= 1:
            return table
        if table is not None:
            problem = f"{table.name} holds reflectances outside 0..1, perhaps per cent"
            stated.report.miss(stated.datablock, problem, remedy)
    return Constant(settings.reflectance)


def _what_is_left(stated: Statement, name: str, taken: float, takers: str) -> float:
    """Return a share of the settings, reduced to what others leave of all light."""
    share, left = getattr(stated.settings, name), max(1.0 - taken, 0.0)
    if share <= left + 1e-6:
        return min(share, left)
    stated.report.warn(
        stated.datablock,
        f"{takers} plus {name} {share:.3g} exceeds 1",
        f"the {name} is reduced to {left:.3g}",
    )
    return left


def _diffuse(stated: Statement) -> Diffuse:
    reflectance = _reflectance(stated)
    transmittance = _what_is_left(stated, "transmittance", largest_of(reflectance), "Reflectance")
    return Diffuse(reflectance, Constant(transmittance) if transmittance > 0 else None)


def _fabric(stated: Statement) -> Fabric:
    reflectance = _reflectance(stated)
    taken = largest_of(reflectance)
    openness = _what_is_left(stated, "openness", taken, "Reflectance")
    transmittance = _what_is_left(
        stated, "transmittance", taken + openness, "Reflectance and openness"
    )
    return Fabric(openness, reflectance, Constant(transmittance))


def _coated(stated: Statement) -> Coated:
    ior = _single_index(_refractive_index(stated))
    return Coated(_reflectance(stated), ior, stated.settings.roughness)


def _conductor(stated: Statement) -> Conductor:
    return Conductor(stated.settings.metal, stated.settings.roughness)


def _dielectric(stated: Statement) -> Dielectric:
    return Dielectric(_refractive_index(stated), stated.settings.roughness)


def _pane(stated: Statement) -> ThinGlass | TabulatedPane:
    if stated.settings.pane_source == "FILE":
        remedy = "clear glass by its refractive index is used"
        pane = stated.read("pane_file", remedy, data_sheet.read_data_sheet, "data sheet")
        if pane is not None:
            return pane
    ior = _single_index(_refractive_index(stated))
    return ThinGlass(ior, Constant(stated.settings.transmittance))


def _known_by(group: str, convert: Callable) -> Callable[[Statement], Surface]:
    """What makes a surface whose tables are read or computed, by the settings of the name ``group``."""

    def make(stated: Statement) -> Surface:
        remedy = f"diffuse grey {MISSING_REFLECTANCE} is used"
        own = getattr(stated.settings, group)
        surface = convert(own, stated.report, stated.datablock, remedy, stated.is_patient)
        return Diffuse(Constant(MISSING_REFLECTANCE)) if surface is None else surface

    return make


def _black(_stated: Statement) -> Black:
    return Black()


def _glow(stated: Statement) -> Emission | None:
    settings = stated.settings
    try:
        spectrum = convert_spectrum(
            settings, settings.reflectance_color, stated.report, stated.datablock
        )
    except LumenrayError as error:
        stated.report.fault(stated.datablock, error, "the material does not shine")
        return None
    if settings.luminance <= 0:
        return None
    return Emission(spectrum, settings.luminance, None, settings.two_sided)


def _refractive_index(stated: Statement) -> RefractiveIndex:
    settings = stated.settings
    if settings.ior_source == "CAUCHY":
        return Cauchy(settings.ior, settings.cauchy_b)
    if settings.ior_source == "FILE":
        remedy = f"refractive index {settings.ior:.4g} is used"
        table = stated.read("ior_file", remedy)
        if table is not None and table.values.min() >= 1:
            return IorTable(table.wavelengths, table.values)
        if table is not None:
            problem = f"{table.name} holds refractive indices below 1"
            stated.report.miss(stated.datablock, problem, remedy)
    return Cauchy(settings.ior, 0.0)


def _single_index(index: RefractiveIndex) -> float:
    if isinstance(index, IorTable):
        return float(np.interp(HELIUM_D, index.wavelengths, index.values))
    return index.a + index.b / (HELIUM_D / 1000) ** 2


MAKERS = {
    "DIFFUSE": _diffuse,
    "COATED": _coated,
    "CONDUCTOR": _conductor,
    "DIELECTRIC": _dielectric,
    "THIN_GLASS": _pane,
    "EMITTER": _black,
    MEASURED: _known_by("measured", convert_measured),
    "FABRIC": _fabric,
    PAINT: _known_by("paint", convert_paint),
    INK: _known_by("ink", convert_ink),
    CLOTH: _known_by("cloth", convert_cloth),
}
"""From a `Statement` to the `Surface`, by the names of `surface_models.MODELS`."""

EMITTING = {"EMITTER": _glow}
"""From a `Statement` to the `Emission` or None, for those of them that may shine."""
