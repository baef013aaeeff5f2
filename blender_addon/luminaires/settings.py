"""What the user sets about a luminaire: its photometric file, how it is read, and how much light it gives."""

from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..file_assets.settings import EmbeddableSettings, settings_of_light, switch, unload
from ..foundation.settings import PATH_OPTIONS, SpectrumSettings, tag_owner

EMISSIONS = [
    ("OPENING", "Opening", "From the luminous opening that the file states", 0),
    ("LIGHT", "Light's Size", "From the light's own radius or size; an empty is a point", 1),
    ("POINT", "Point", "From one point: exact far away, without soft shadows", 2),
]

AMOUNTS = [
    ("FILE", "File", "The flux that the file's intensities sum up to", 0),
    ("LUMENS", "Lumens", "State the flux; the file gives the shape of the light only", 1),
]

SPECTRUM_SOURCES = [
    ("FILE", "File", "Spectrum, colour temperature or lamp that the file states", 0),
    ("LIGHT", "Own", "The spectrum or colour that is chosen here", 1),
]


def _unload(self, context):
    """Nothing is known of the file at another path."""
    self.digest = ""
    unload(self, context)


class LuminaireSettings(EmbeddableSettings):
    """Mix-in of what lights and empties have in common."""

    use_file: BoolProperty(
        name="Photometric File",
        description=(
            "Shine as an IES, EULUMDAT or TM-33 file says, in place of Blender's own beam and watts. Switches a ray "
            "set off. Default off: there is no file at first"
        ),
        default=False,
        update=switch,
    )
    filepath: StringProperty(
        name="File",
        description=(
            "Photometric file (.ies, .ldt, .xml). While the file is embedded: where it was read from; "
            "another path takes the embedded one's place"
        ),
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=_unload,
    )
    digest: StringProperty(
        name="Content Hash",
        description="SHA-256 of the file's bytes when it was loaded, to tell when a linked file has changed",
        options={"HIDDEN"},
    )
    emission: EnumProperty(
        name="Shines From",
        description=(
            "What emits the light; seen from afar all of them give the file's distribution. Default Opening: near "
            "by it is right too"
        ),
        items=EMISSIONS,
        default="OPENING",
        update=tag_owner,
    )
    rotation: FloatProperty(
        name="Turn C0",
        description=(
            "Direction of the C0 plane, turned about the beam from the local X axis, counter-clockwise seen from "
            "behind the beam. The opening stays: IES files usually put C0 along the luminaire, EULUMDAT files "
            "across it. Default 0°: as the file has it"
        ),
        default=0.0,
        subtype="ANGLE",
        update=tag_owner,
    )
    mirror: BoolProperty(
        name="C Clockwise",
        description=(
            "Count the C planes of a type C file the other way, as some laboratories do. Default off: as the "
            "standards count them"
        ),
        default=False,
        update=tag_owner,
    )
    flip_h: BoolProperty(
        name="Flip H",
        description=(
            "Take the horizontal angles of a type B file in opposite order, left for right. Default off: as the "
            "standards count them"
        ),
        default=False,
        update=tag_owner,
    )
    amount: EnumProperty(
        name="Flux From",
        description="What states the amount of light before dimming. Default File: that is what was measured",
        items=AMOUNTS,
        default="FILE",
        update=tag_owner,
    )
    luminous_flux: FloatProperty(
        name="Luminous Flux",
        description=(
            "Flux that leaves the luminaire, before dimming and the other factors, in lumens. Default 1000: "
            "about what a lamp of 75 W with a filament gave"
        ),
        default=1000.0,
        min=0.0,
        max=1e9,
        soft_max=100000.0,
        update=tag_owner,
    )
    dimming: FloatProperty(
        name="Dimming",
        description="Share of the full flux that the luminaire is set to, 0 to 1. Default 1: it is not dimmed",
        default=1.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    maintenance_factor: FloatProperty(
        name="Maintenance Factor",
        description=(
            "Share of the flux that is left by ageing and dirt before the next service (CIE 97), 0 to 1. Default 1: "
            "a new, clean installation; plans usually take 0.8"
        ),
        default=1.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    lamp_factor: FloatProperty(
        name="Lamp Factor",
        description=(
            "Flux of the lamps in use over that of the lamps that the file was measured with, as a factor. Default "
            "1: the same lamps"
        ),
        default=1.0,
        min=0.0,
        max=1000.0,
        soft_max=2.0,
        update=tag_owner,
    )
    spectrum_source: EnumProperty(
        name="Spectrum From",
        description=(
            "What states how the light is distributed over the wavelengths. Default File: the maker knows it best"
        ),
        items=SPECTRUM_SOURCES,
        default="FILE",
        update=tag_owner,
    )
    show_solid: BoolProperty(
        name="Show Solid",
        description=(
            "Draw the file's intensity distribution as a solid in the 3D view. Default on: it shows where the light "
            "goes"
        ),
        default=True,
        update=tag_owner,
    )


class LumenrayLuminaireSettings(LuminaireSettings, PropertyGroup):
    """Photometric file of a point, spot or area light; ``light.lumenray`` chooses its own spectrum."""


class LumenrayEmptySettings(LuminaireSettings, SpectrumSettings, PropertyGroup):
    """The luminaire that an empty is; it has no light's data, so its own spectrum is chosen here."""

    blocks_light: BoolProperty(
        name="Housing Blocks Light",
        description=(
            "Let the housing that the file states stop and reflect light of others, and be seen. The luminaire's own light "
            "is what its file says: the housing stands out of its way. Default off: as planning programs have it"
        ),
        default=False,
        update=tag_owner,
    )

    color: FloatVectorProperty(
        name="Colour",
        description=(
            "Linear colour of the light; it never changes the amount of light. Default white: it tints nothing"
        ),
        subtype="COLOR",
        size=3,
        default=(1.0, 1.0, 1.0),
        min=0.0,
        max=1.0,
        update=tag_owner,
    )


def settings_of(thing):
    """Return the luminaire settings of an object, the evaluated ones of an evaluated object.

    Parameters
    ----------
    thing : bpy.types.Object or None

    Returns
    -------
    LuminaireSettings or None    None where no photometric file can be: it takes a point, spot or area light, or an empty.
    """
    if thing is None:
        return None
    if thing.type == "EMPTY":
        return thing.lumenray.luminaire
    return settings_of_light(thing.data, "luminaire") if thing.type == "LIGHT" else None


def active_settings(context):
    """Return the luminaire settings of the light or empty that a panel or an operator is about, None if there is none."""
    light = getattr(context, "light", None)
    if light is not None:
        return settings_of_light(light, "luminaire")
    return settings_of(getattr(context, "object", None))


def is_luminaire(thing) -> bool:
    """Whether an object shines as a photometric file says."""
    settings = settings_of(thing)
    return settings is not None and settings.use_file
