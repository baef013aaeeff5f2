"""What the user can set of a material."""

from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..libraries import spectra
from .cloths.settings import LumenrayClothSettings
from .foundation.settings import (
    PATH_OPTIONS,
    SpectrumSettings,
    enum_from_names,
    identity_property,
    light_group_property,
    tag_owner,
)
from .inks.settings import LumenrayInkSettings
from .paints.settings import LumenrayPaintSettings
from .scattering.settings import LumenrayMeasuredSettings
from .surface_models import model_items


def _follow_override(self, context):
    """Show the look of a measured material, or what the material was before; new compositions begin with a preset."""
    from .cloths import presets as cloth_presets
    from .inks import presets as ink_presets
    from .paints import presets as paint_presets
    from .scattering.look_nodes import follow_override

    for presets in (paint_presets, ink_presets, cloth_presets):
        presets.begin(self.id_data)
    follow_override(self.id_data)
    tag_owner(self, context)


class LumenrayMaterialSettings(SpectrumSettings, PropertyGroup):
    """Physical override of a material; the node tree is used while `use_override` is off."""

    uid: identity_property()
    use_override: BoolProperty(
        name="Physical Override",
        description=(
            "Use these measurable parameters in place of the node tree. Default off: your materials stay as they "
            "are"
        ),
        default=False,
        update=_follow_override,
    )
    model: EnumProperty(
        name="Model",
        description="Kind of surface, by what can be measured of it. Default Diffuse: one number tells all of it",
        items=model_items(),
        default="DIFFUSE",
        update=_follow_override,
    )
    reflectance_source: EnumProperty(
        name="Reflectance From",
        description="Where the reflectance comes from. Default Value: data sheets of paints state one number",
        items=[
            ("VALUE", "Value", "The same at all wavelengths", 0),
            ("COLOR", "Colour", "Upsampled from a linear colour", 1),
            ("FILE", "File", "Spectral reflectance from a file", 2),
        ],
        default="VALUE",
        update=tag_owner,
    )
    reflectance: FloatProperty(
        name="Reflectance",
        description=(
            "Diffuse reflectance from 0 to 1: the share of the light that comes back, in all directions. Default "
            "0.5: the least of the 0.5 to 0.8 that EN 12464-1 of 2011 recommends for walls"
        ),
        default=0.5,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    reflectance_color: FloatVectorProperty(
        name="Colour",
        description=(
            "Diffuse reflectance as a linear colour, each part a share from 0 to 1. Default grey: 0.5 at all "
            "wavelengths"
        ),
        subtype="COLOR",
        size=3,
        default=(0.5, 0.5, 0.5),
        min=0.0,
        max=1.0,
        update=tag_owner,
    )
    reflectance_file: StringProperty(
        name="Reflectance File",
        description="Text or CSV with wavelength [nm] and reflectance 0..1, CGATS of instruments, or .spdx",
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=tag_owner,
    )
    transmittance: FloatProperty(
        name="Transmittance",
        description=(
            "Diffuse transmittance from 0 to 1 of a matt sheet, of a fabric without its straight light; internal "
            "transmittance of a pane. Default 0: most surfaces let nothing through"
        ),
        default=0.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    openness: FloatProperty(
        name="Openness",
        description=(
            "Openness factor of a fabric: share of light along the normal that passes straight, 0 to 1. Default "
            "0.05: in the middle of the 0.01 to 0.1 that roller blinds are sold with"
        ),
        default=0.05,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    pane_source: EnumProperty(
        name="Pane From",
        description="How the pane is stated. Default Glass: it needs no data sheet",
        items=[
            ("GLASS", "Glass", "Refractive index and internal transmittance of clear glass", 0),
            ("FILE", "Data Sheet", "Table of transmittance and reflectance by angle", 1),
        ],
        default="GLASS",
        update=tag_owner,
    )
    pane_file: StringProperty(
        name="Data Sheet",
        description="Text or CSV with angle to the normal [degree], transmittance 0..1 and reflectance 0..1",
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=tag_owner,
    )
    roughness: FloatProperty(
        name="Roughness",
        description=(
            "From 0 to 1, where 0 is a mirror; the microfacet width is its square, as in Blender. Default 0.2: "
            "satin, between polished and matt"
        ),
        default=0.2,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    ior_source: EnumProperty(
        name="Refractive Index From",
        description="How the refractive index is stated. Default Value: enough where no light is split into colours",
        items=[
            ("CONSTANT", "Value", "The same at all wavelengths", 0),
            ("CAUCHY", "Cauchy", "n = A + B / wavelength², wavelength in micrometres", 1),
            ("FILE", "File", "Table of wavelength [nm] and index", 2),
        ],
        default="CONSTANT",
        update=tag_owner,
    )
    ior: FloatProperty(
        name="Refractive Index",
        description="Refractive index at all wavelengths, or Cauchy's A. Default 1.5: window glass and acrylic",
        default=1.5,
        min=1.0,
        max=4.0,
        precision=4,
        update=tag_owner,
    )
    cauchy_b: FloatProperty(
        name="Cauchy B",
        description="Dispersion in µm²; dense flint has 0.0134. Default 0.0042: crown glass",
        default=0.0042,
        min=0.0,
        max=0.1,
        precision=5,
        update=tag_owner,
    )
    ior_file: StringProperty(
        name="Index File",
        description="Text or CSV with wavelength [nm] and refractive index",
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=tag_owner,
    )
    metal: EnumProperty(
        name="Metal",
        description="Complex refractive index of a metal by its symbol. Default Ag: silver, what mirrors are made of",
        items=enum_from_names(spectra.conductor_names()),
        update=tag_owner,
    )
    luminance: FloatProperty(
        name="Luminance",
        description=(
            "Luminance of the emitting surface in cd/m². Default 1000: between a screen, some 300, and an opal "
            "ceiling panel, some 3700"
        ),
        default=1000.0,
        min=0.0,
        max=1e10,
        soft_max=50000.0,
        update=tag_owner,
    )
    two_sided: BoolProperty(
        name="Both Sides Emit",
        description=(
            "Both sides of the surface emit; else only the one that the normal points to. Default on: no side is "
            "dark by a flipped normal"
        ),
        default=True,
        update=tag_owner,
    )
    measured: PointerProperty(type=LumenrayMeasuredSettings)
    paint: PointerProperty(type=LumenrayPaintSettings)
    ink: PointerProperty(type=LumenrayInkSettings)
    cloth: PointerProperty(type=LumenrayClothSettings)
    light_group: light_group_property("what glows with this material")
