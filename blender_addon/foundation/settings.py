"""Pieces that several property groups share: telling the dependency graph, and the choice of a spectrum."""

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty, StringProperty

from ...libraries import spectra

PATH_OPTIONS = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set()
"""Options of paths that may start with ``//``; older versions of Blender ask no leave for it."""


def tag_owner(self, context):
    """Tell the dependency graph: properties of add-ons do not do it by themselves (Blender #138071)."""
    self.id_data.update_tag()


def enum_from_names(names) -> list[tuple[str, str, str, int]]:
    """Return items of an enumeration whose identifiers are what people read."""
    return [(name, name, "", index) for index, name in enumerate(names)]


SPECTRA = [
    ("RGB", "Colour", "The colour of the light itself; it never changes the amount of light", 0),
    ("ILLUMINANT", "CIE Illuminant", "A standard illuminant by name", 1),
    ("BLACKBODY", "Blackbody", "Planck radiator of a colour temperature (incandescent)", 2),
    ("DAYLIGHT", "Daylight", "CIE daylight phase of a colour temperature", 3),
    ("FILE", "File", "Spectral power from a text file (wavelength in nm, value) or .spdx", 4),
]


class SpectrumSettings:
    """Mix-in of the properties that choose the spectrum of something luminous."""

    spectrum: EnumProperty(
        name="Spectrum",
        description="How the light is distributed over the wavelengths",
        items=SPECTRA,
        default="RGB",
        update=tag_owner,
    )
    illuminant: EnumProperty(
        name="Illuminant",
        description="CIE standard illuminant",
        items=enum_from_names(spectra.illuminant_names()),
        default="D65",
        update=tag_owner,
    )
    colour_temperature: FloatProperty(
        name="Colour Temperature",
        description="In kelvins; daylight is defined from 4000 K to 25000 K",
        default=4000.0,
        min=500.0,
        max=40000.0,
        soft_min=1800.0,
        soft_max=12000.0,
        precision=0,
        update=tag_owner,
    )
    spectrum_file: StringProperty(
        name="Spectrum File",
        description="Text or CSV with wavelength [nm] and relative power, or an IES TM-27 .spdx file",
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=tag_owner,
    )
    spectrum_column: IntProperty(
        name="Column",
        description="Which column of values of the file counts; 0 takes the first, with a warning if there are others",
        default=0,
        min=0,
        max=1000,
        update=tag_owner,
    )
