"""Pieces that several property groups share: telling the dependency graph, and the choice of a spectrum."""

import math

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty, StringProperty

from ...libraries import spectra
from .redraw import redraw

PATH_OPTIONS = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set()
"""Options of paths that may start with ``//``; older versions of Blender ask no leave for it."""


def tag_owner(self, context):
    """Tell the dependency graph: properties of add-ons do not do it by themselves (Blender #138071)."""
    self.id_data.update_tag()


def redraw_views(self, context):
    """Draw the 3D views again: what they show depends on the property, the scene does not."""
    redraw("VIEW_3D")


def identity_property():
    """Property of the identity; `identity` alone writes it."""
    return StringProperty(name="Identity", options={"HIDDEN"})


def light_group_property(of: str):
    """Property that names the light group that a light belongs to."""
    return StringProperty(
        name="Light Group",
        description=(
            f"Light group that {of} belongs to, a layer of lux maps and of the light mix; empty: Blender's own light "
            "group; all without a group share one"
        ),
        maxlen=63,
        update=tag_owner,
    )


def percentage(name: str, title: str, description: str, soft_max: float = 10.0):
    """Property that shows a share, which scripts and files have, in per cent; ``soft_max``: end of its slider."""

    def read(self):
        return 100.0 * getattr(self, name)

    def write(self, value):
        setattr(self, name, 0.01 * value)

    return FloatProperty(
        name=title,
        description=description,
        min=0.01,
        max=100.0,
        soft_max=soft_max,
        precision=2,
        subtype="PERCENTAGE",
        get=read,
        set=write,
        options={"SKIP_SAVE"},
    )


def enum_from_names(names) -> list[tuple[str, str, str, int]]:
    """Return items of an enumeration whose identifiers are what people read."""
    return [(name, name, "", index) for index, name in enumerate(names)]


SPECTRA = [
    ("RGB", "Colour", "The colour of the light itself; it never changes the amount of light", 0),
    ("ILLUMINANT", "CIE Illuminant", "A standard illuminant by name", 1),
    ("BLACKBODY", "Blackbody", "Planck radiator of a colour temperature (incandescent)", 2),
    ("DAYLIGHT", "Daylight", "CIE daylight phase of a colour temperature", 3),
    ("FILE", "File", "Spectral power from a text file (wavelength in nm, value) or .spdx", 4),
    ("SUNLIGHT", "Sunlight", "Of the sun behind air of a turbidity, by the sun's elevation", 5),
]


class SpectrumSettings:
    """Mix-in of the properties that choose the spectrum of something luminous."""

    spectrum: EnumProperty(
        name="Spectrum",
        description="How the light is distributed over the wavelengths. Default Colour: as Blender shows the light",
        items=SPECTRA,
        default="RGB",
        update=tag_owner,
    )
    illuminant: EnumProperty(
        name="Illuminant",
        description="CIE standard illuminant by its name. Default D65: average daylight, the white of screens",
        items=enum_from_names(spectra.illuminant_names()),
        default="D65",
        update=tag_owner,
    )
    colour_temperature: FloatProperty(
        name="Colour Temperature",
        description=(
            "Of the radiator or the daylight, in kelvins; daylight is defined from 4000 K to 25000 K. Default 4000: "
            "neutral white, usual in offices"
        ),
        default=4000.0,
        min=500.0,
        max=40000.0,
        soft_min=1800.0,
        soft_max=12000.0,
        precision=0,
        update=tag_owner,
    )
    turbidity: FloatProperty(
        name="Turbidity",
        description=(
            "Luminous turbidity of the air before the sun, a factor: 2 very clear, 5 hazy. Default 3: a clear day in Europe"
        ),
        default=3.0,
        min=1.0,
        max=20.0,
        soft_max=8.0,
        precision=1,
        update=tag_owner,
    )
    sun_elevation: FloatProperty(
        name="Sun's Elevation",
        description=(
            "Height of the sun above the horizon for the spectrum of its light. Default 45°: half way up, as on a summer "
            "morning"
        ),
        default=math.radians(45.0),
        min=0.0,
        max=math.radians(90.0),
        subtype="ANGLE",
        update=tag_owner,
    )
    spectrum_file: StringProperty(
        name="Spectrum File",
        description="Text or CSV with wavelength [nm] and relative power, CGATS or .sp of instruments, or IES TM-27 .spdx",
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=tag_owner,
    )
    spectrum_column: IntProperty(
        name="Column",
        description=(
            "Number of the column or sample of the file that counts; 0 takes the first, with a warning if there are "
            "others. Default 0: most files have one"
        ),
        default=0,
        min=0,
        max=200_000,
        update=tag_owner,
    )
