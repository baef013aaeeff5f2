"""What the user sets of a dense pigment layer; all else that a description states is kept beside it as JSON text."""

from bpy.props import (
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..foundation.settings import tag_owner


def _content():
    """What a description states beside what panels edit, as JSON text."""
    return StringProperty(description="What else the description states", options={"HIDDEN"})


class LumenrayInkPigment(PropertyGroup):
    """A pigment of a layer."""

    content: _content()
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


def _swatch():
    def colour(self):
        from .readout import swatch

        return swatch(self)

    return FloatVectorProperty(
        name="Colour",
        description="Colour at 45:0 in daylight, as far as a screen shows it",
        subtype="COLOR",
        size=3,
        min=0.0,
        max=1.0,
        get=colour,
    )


class LumenrayInkSettings(PropertyGroup):
    """Composition of a pigment layer; it counts where the material's model is one."""

    name: StringProperty(name="Name", description="Name of the layer, for people", update=tag_owner)
    content: _content()
    quality: EnumProperty(
        name="Quality",
        description="How finely waves are solved. Default Draft: for a look, in seconds to minutes",
        items=[
            ("DRAFT", "Draft", "A coarse grid, half the bands, few angles and realisations"),
            ("FINAL", "Final", "As the description says; takes many times as long"),
        ],
        default="DRAFT",
        update=tag_owner,
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
    swatch: _swatch()


CLASSES = (LumenrayInkPigment, LumenrayInkSettings)
