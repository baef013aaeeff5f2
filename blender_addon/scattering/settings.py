"""What the user sets about a measured material: its file, and how the sample lies on the surface."""

from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ...libraries import spectra
from ..file_assets.settings import EmbeddableSettings, unload
from ..foundation.settings import PATH_OPTIONS, enum_from_names, tag_owner

BACKS = [
    ("SAME", "As the Front", "Of what the file tells of one side only, the other side does the same", 0),
    ("NONE", "Black", "What the file does not tell of a side is absorbed there", 1),
]  # fmt: skip


def _swatch(self):
    from .readout import swatch

    return swatch(self)


class LumenrayMeasuredSettings(EmbeddableSettings, PropertyGroup):
    """Scattering file of a material; it counts where the material's model is measured."""

    filepath: StringProperty(
        name="File",
        description=(
            "Scattering file: BRDF or BTDF of an instrument or a program, told apart by content. 'library:' and a name is "
            "one of ours. While the file is embedded: where it was read from; another path takes the embedded one's place"
        ),
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=unload,
    )
    back: EnumProperty(
        name="Back",
        description=(
            "What a side does that the file does not tell of. Default As the Front: most samples are alike on both "
            "sides"
        ),
        items=BACKS,
        default="SAME",
        update=tag_owner,
    )
    is_turned: BoolProperty(
        name="Turn Over",
        description=(
            "The front of the file's sample is the back of the surface, where normals do not point. Default off: "
            "the front is where they point"
        ),
        default=False,
        update=tag_owner,
    )
    rotation: FloatProperty(
        name="Rotation",
        description=(
            "Turn of the sample about the normal, from the surface's U to its V; it counts where the scattering has "
            "a direction, such as that of brushed metal or a weave. Default 0°: as the file has it"
        ),
        default=0.0,
        subtype="ANGLE",
        update=tag_owner,
    )
    tolerance: FloatProperty(
        name="Tolerance",
        description=(
            "Error that is allowed where the file's data have to be brought onto another grid, root mean square, as "
            "a share; a smaller one takes more time and memory. Default 0.02: less than instruments differ by"
        ),
        default=0.02,
        min=0.005,
        max=0.1,
        precision=3,
        update=tag_owner,
    )
    illuminant: EnumProperty(
        name="Illuminant",
        description=(
            "Light under which the panel tells the colour; it does not count for the picture. Default D65: average "
            "daylight, the white of screens"
        ),
        items=enum_from_names(spectra.illuminant_names()),
        default="D65",
    )
    swatch: FloatVectorProperty(
        name="Colour",
        description="Of all light that is reflected, or else transmitted, near the normal under the illuminant",
        subtype="COLOR",
        size=3,
        min=0.0,
        max=1.0,
        get=_swatch,
    )
    has_look: BoolProperty(
        name="Look Shown",
        description="Whether the material shows the look that was fitted to the file",
        options={"HIDDEN"},
    )
    is_look_wanted: BoolProperty(
        name="Look Wanted",
        description="Whether the look comes back when the file counts again",
        options={"HIDDEN"},
    )
    own_colour: FloatVectorProperty(
        name="Own Colour",
        description="Viewport colour of the material without its look",
        subtype="COLOR",
        size=4,
        min=0.0,
        default=(0.8, 0.8, 0.8, 1.0),
        options={"HIDDEN"},
    )
    own_metallic: FloatProperty(
        name="Own Metallic",
        description="Viewport metallic of the material without its look",
        options={"HIDDEN"},
    )
    own_roughness: FloatProperty(
        name="Own Roughness",
        description="Viewport roughness of the material without its look",
        options={"HIDDEN"},
    )
    own_use_nodes: BoolProperty(
        name="Own Nodes",
        description="Whether the material without its look is made of nodes",
        options={"HIDDEN"},
    )


def active_material(context):
    """Return the material that a panel or an operator is about, None if there is none."""
    material = getattr(context, "material", None)
    if material is None:
        thing = getattr(context, "object", None)
        material = getattr(thing, "active_material", None)
    return None if material is None or material.grease_pencil else material
