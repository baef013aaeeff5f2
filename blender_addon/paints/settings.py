"""What the user sets of an effect paint: its layers with binder, flakes and pigments, and what they lie on.

Settings hold what panels edit; all else that a description states is kept beside it as JSON text and not lost.
"""

import math

from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..compositions.settings import content_property, swatch_property
from ..foundation.settings import tag_owner
from .angles import STRIP

AMOUNTS = [
    ("binder_mass_ratio", "To Binder by Mass", "Mass of it over that of the binder", 0),
    ("mass_fraction", "Share of Mass", "Of the dry layer", 1),
    ("volume_fraction", "Share of Volume", "Of the dry layer", 2),
    ("area_per_volume_per_um", "Area by Volume", "One face of the flakes by volume of the layer, in 1/µm", 3),
]  # fmt: skip


def _amount_kind(default: str, items):
    title = next(title for name, title, *_ in items if name == default)
    return EnumProperty(
        name="Amount As",
        description=f"What is stated of how much there is in the dry layer. Default {title}: as recipes state it",
        items=items,
        default=default,
        update=tag_owner,
    )


def _amount(default: float, most: float):
    return FloatProperty(
        name="Amount",
        description=(
            f"How much there is in the dry layer, as a share, of areas in 1/µm. Default {default:g}: as in many paints"
        ),
        default=default,
        min=0.0,
        max=most,
        soft_max=1.0,
        precision=4,
        step=0.5,
        update=tag_owner,
    )


class LumenrayPaintFlakes(PropertyGroup):
    """Flakes of one kind in a layer."""

    content: content_property()
    amount_kind: _amount_kind("binder_mass_ratio", AMOUNTS)
    amount: _amount(0.1, 10.0)
    tilt: FloatProperty(
        name="Tilt",
        description=(
            "How far the flakes' normals spread about that of the surface, as the description measures it, else the "
            "standard deviation of their slopes per axis. Default 5°: well laid flakes"
        ),
        default=math.radians(5.0),
        min=math.radians(0.5),
        max=math.radians(40.0),
        subtype="ANGLE",
        update=tag_owner,
    )
    median_um: FloatProperty(
        name="Diameter [µm]",
        description=(
            "Median diameter by number, in micrometres; 0: not stated, and no sparkle is seen. Default 10: a fine grade"
        ),
        default=10.0,
        min=0.0,
        max=2000.0,
        soft_max=100.0,
        precision=2,
        update=tag_owner,
    )
    log_spread: FloatProperty(
        name="Spread of Diameters",
        description=(
            "Standard deviation of the natural logarithm of the diameters, a number. Default 0.4: ground and sieved flakes"
        ),
        default=0.4,
        min=0.0,
        max=1.5,
        precision=3,
        update=tag_owner,
    )
    core_nm: FloatProperty(
        name="Core [nm]",
        description="Thickness of the core of flakes that interfere, in nm. Default 400: as of silica flakes",
        default=400.0,
        min=1.0,
        max=20000.0,
        soft_max=1000.0,
        precision=1,
        update=tag_owner,
    )
    coating_nm: FloatProperty(
        name="Coating [nm]",
        description="Thickness of the innermost coating, on both faces, in nm. Default 100: it reflects blue and yellow",
        default=100.0,
        min=0.1,
        max=5000.0,
        soft_max=500.0,
        precision=1,
        update=tag_owner,
    )


class LumenrayPaintPigment(PropertyGroup):
    """A pigment in a layer."""

    content: content_property()
    amount_kind: _amount_kind("volume_fraction", AMOUNTS[:3])
    amount: _amount(0.01, 10.0)
    strength: FloatProperty(
        name="Strength",
        description="Factor on the extinction that is stated of the pigment. Default 1: as stated",
        default=1.0,
        min=0.0,
        max=1000.0,
        soft_max=4.0,
        precision=3,
        update=tag_owner,
    )


class LumenrayPaintLayer(PropertyGroup):
    """A layer of a paint."""

    name: StringProperty(name="Name", description="Name of the layer, for people", update=tag_owner)
    content: content_property()
    thickness_um: FloatProperty(
        name="Thickness [µm]",
        description="Of the dry layer, in micrometres. Default 15: a base coat",
        default=15.0,
        min=0.1,
        max=10000.0,
        soft_max=100.0,
        precision=1,
        update=tag_owner,
    )
    binder_index: FloatProperty(
        name="Binder's Index",
        description="Refractive index of the binder. Default 1.5: acrylic and polyurethane",
        default=1.5,
        min=1.0,
        max=2.5,
        precision=3,
        update=tag_owner,
    )
    dye: FloatProperty(
        name="Dye",
        description="Factor on what the binder absorbs as the description states it. Default 1: as stated",
        default=1.0,
        min=0.0,
        max=1000.0,
        soft_max=4.0,
        precision=3,
        update=tag_owner,
    )
    flakes: CollectionProperty(type=LumenrayPaintFlakes)
    pigments: CollectionProperty(type=LumenrayPaintPigment)


def _swatch(number: int):
    def colour(self):
        from .readout import swatch

        return swatch(self, number)

    return swatch_property(
        f"{STRIP[number]}°",
        f"Colour {STRIP[number]}° from the mirror direction, in light at 45° of daylight, as far as a screen shows it",
        colour,
    )


class LumenrayPaintSettings(PropertyGroup):
    """Composition of a paint; it counts where the material's model is a paint."""

    name: StringProperty(name="Name", description="Name of the paint, for people", update=tag_owner)
    content: content_property()
    layers: CollectionProperty(type=LumenrayPaintLayer)
    layer_index: IntProperty(
        name="Active Layer", description="Layer whose parts are shown below the list", default=0
    )
    substrate: FloatProperty(
        name="Substrate",
        description=(
            "Reflectance of the matt surface below the layers, from inside of them, 0 to 1. Default 0.1: a dark primer"
        ),
        default=0.1,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=tag_owner,
    )
    orange_peel: FloatProperty(
        name="Orange Peel",
        description="Standard deviation of the surface's slope per axis by long waves. Default 0°: a smooth surface",
        default=0.0,
        min=0.0,
        max=math.radians(20.0),
        soft_max=math.radians(2.0),
        subtype="ANGLE",
        update=tag_owner,
    )
    use_sparkle: BoolProperty(
        name="Sparkle",
        description=(
            "Whether the camera sees flakes one by one where it is near; lux maps and what is seen in mirrors have their "
            "mean. Default on: as eyes see it"
        ),
        default=True,
        update=tag_owner,
    )
    strip_1: _swatch(0)
    strip_2: _swatch(1)
    strip_3: _swatch(2)
    strip_4: _swatch(3)
    strip_5: _swatch(4)


CLASSES = (
    LumenrayPaintFlakes,
    LumenrayPaintPigment,
    LumenrayPaintLayer,
    LumenrayPaintSettings,
)
