"""What the user can set of a light."""

from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    PointerProperty,
)
from bpy.types import PropertyGroup

from .foundation.settings import (
    SpectrumSettings,
    identity_property,
    light_group_property,
    tag_owner,
)
from .luminaires.settings import LumenrayLuminaireSettings
from .raysets.settings import LumenrayRaysetSettings

QUANTITIES = [
    ("LUMINOUS_FLUX", "Luminous Flux [lm]", "Total light emitted, in lumens", 0),
    ("LUMINOUS_INTENSITY", "Luminous Intensity [cd]", "On the axis of the light, in candelas", 1),
    (
        "ILLUMINANCE",
        "Illuminance [lx]",
        "At 1 m on the axis; for a sun on a plane that faces it",
        2,
    ),
    ("LUMINANCE", "Luminance [cd/m²]", "Of the luminous surface of an area light", 3),
    (
        "RADIANT_FLUX",
        "Radiant Flux [W]",
        "Optical watts between 360 and 830 nm, not electrical watts; for a sun W/m²",
        4,
    ),
]


def _switch_physical(self, context):
    """Let physical parameters start with what the light gives, not with a number of their own."""
    from . import light_amount

    settle = light_amount.start if self.use_physical else light_amount.forget
    settle(self.id_data, context.scene)
    tag_owner(self, context)


class LumenrayLightSettings(SpectrumSettings, PropertyGroup):
    """Physical parameters of a light; ignored while `use_physical` is off."""

    uid: identity_property()
    use_physical: BoolProperty(
        name="Physical Parameters",
        description=(
            "State this light in photometric units instead of Blender's watts; it starts with what the light gives "
            "now. Default off: your scenes keep their light"
        ),
        default=False,
        update=_switch_physical,
    )
    quantity: EnumProperty(
        name="Quantity",
        description=(
            "What the value means, and with it the unit. Default Luminous Flux [lm]: data sheets of lamps state it"
        ),
        items=QUANTITIES,
        default="LUMINOUS_FLUX",
        update=tag_owner,
    )
    value: FloatProperty(
        name="Value",
        description=(
            "Amount of light in the unit of the quantity. Default 1000: in lumens about what a lamp of 75 W with a "
            "filament gave"
        ),
        default=1000.0,
        min=0.0,
        max=1e12,
        soft_max=100000.0,
        update=tag_owner,
    )
    tube_length: FloatProperty(
        name="Tube Length",
        description=(
            "Length of a straight tube along the light's X axis, with dark ends; at 0 it is a ball, which is what "
            "Blender's own renders show in any case. Default 0: few lamps are tubes"
        ),
        default=0.0,
        min=0.0,
        soft_max=10.0,
        subtype="DISTANCE",
        unit="LENGTH",
        update=tag_owner,
    )
    limb_darkening: BoolProperty(
        name="Limb Darkening",
        description=(
            "Make the sun's disk darker towards its edge, by the true sun's 60 %, with the same light in all. Default "
            "off: as Blender's own renders have it"
        ),
        default=False,
        update=tag_owner,
    )
    luminaire: PointerProperty(type=LumenrayLuminaireSettings)
    rayset: PointerProperty(type=LumenrayRaysetSettings)
    light_group: light_group_property("this light")
