"""What the user sets of a dense pigment layer; all else that a description states is kept beside it as JSON text."""

from bpy.props import (
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..compositions.settings import content_property, quality_property, swatch_property
from ..foundation.settings import tag_owner


class LumenrayInkPigment(PropertyGroup):
    """A pigment of a layer."""

    content: content_property()
    volume_fraction: FloatProperty(
        name="Volume",
        description="Share of the layer's volume, 0 to 0.6. Default 0.3: as printed",
        default=0.3,
        min=0.0,
        max=0.6,
        subtype="FACTOR",
        precision=3,
        update=tag_owner,
    )
    median_um: FloatProperty(
        name="Diameter [µm]",
        description=(
            "Median diameter by number of balls of the particles' volume, in micrometres; 0: dissolved. Default 0.2: a "
            "medium grade"
        ),
        default=0.2,
        min=0.0,
        max=5.0,
        soft_max=0.5,
        precision=3,
        step=1,
        update=tag_owner,
    )
    log_spread: FloatProperty(
        name="Spread of Diameters",
        description="Standard deviation of the natural logarithm of the diameters, a number. Default 0.15: a sieved grade",
        default=0.15,
        min=0.0,
        max=0.6,
        precision=3,
        update=tag_owner,
    )
    shape: EnumProperty(
        name="Shape",
        description="Of the particles. Default Balls: most pigments are nearly round",
        items=[
            ("sphere", "Balls", "Spheres"),
            ("rice", "Grains", "Like rice, three times as long as thick, thinner to the ends"),
            ("cylinder", "Rods", "Three times as long as thick"),
        ],
        default="sphere",
        update=tag_owner,
    )


def _colour(self):
    from .readout import swatch

    return swatch(self)


class LumenrayInkSettings(PropertyGroup):
    """Composition of a pigment layer; it counts where the material's model is one."""

    name: StringProperty(name="Name", description="Name of the layer, for people", update=tag_owner)
    content: content_property()
    quality: quality_property(
        "A coarse grid, half the bands, few angles and realisations",
        "As the description says; takes many times as long",
    )
    thickness_um: FloatProperty(
        name="Thickness [µm]",
        description="Mean of the dry layer, in micrometres. Default 1: offset printing",
        default=1.0,
        min=0.05,
        max=20.0,
        soft_max=3.0,
        precision=2,
        update=tag_owner,
    )
    binder_index: FloatProperty(
        name="Binder's Index",
        description="Refractive index of the binder. Default 1.558: a printing ink's",
        default=1.558,
        min=1.0,
        max=2.5,
        precision=3,
        update=tag_owner,
    )
    substrate: FloatProperty(
        name="Substrate",
        description="Reflectance of the matt surface below the layer, 0 to 1. Default 0.9: white paper",
        default=0.9,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    pigments: CollectionProperty(type=LumenrayInkPigment)
    swatch: swatch_property(
        "Colour", "Colour at 45:0 in daylight, as far as a screen shows it", _colour
    )


CLASSES = (LumenrayInkPigment, LumenrayInkSettings)
