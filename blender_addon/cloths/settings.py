"""What the user sets of a cloth; all else that a description states is kept beside it as JSON text."""

import math

from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..compositions.settings import content_property, quality_property, swatch_property
from ..foundation.settings import tag_owner


def _length(title: str, words: str, default: float, least: float = 0.005):
    return FloatProperty(
        name=title,
        description=words,
        default=default,
        min=least,
        max=20.0,
        soft_max=2.0,
        precision=3,
        step=1,
        update=tag_owner,
    )


class LumenrayClothYarn(PropertyGroup):
    """A yarn of a cloth."""

    content: content_property()
    width_mm: _length(
        "Width [mm]",
        "Axis of its section along the cloth, in millimetres. Default 0.2: a yarn of shirts",
        0.2,
    )
    height_mm: _length(
        "Height [mm]",
        "Axis of its section across the cloth, in millimetres. Default 0.2: as wide, a round yarn",
        0.2,
    )
    index: FloatProperty(
        name="Refractive Index",
        description="Refractive index of its matter. Default 1.557: cellulose, which cotton is",
        default=1.557,
        min=1.0,
        max=3.0,
        precision=3,
        update=tag_owner,
    )
    roughness: FloatProperty(
        name="Gloss Width",
        description="Number alpha of its surface (GGX), 0 where it is smooth. Default 0.3: spun yarn",
        default=0.3,
        min=0.0,
        max=1.0,
        precision=3,
        subtype="FACTOR",
        update=tag_owner,
    )
    scattering: FloatProperty(
        name="Scatterers",
        description=(
            "Share of the yarn's volume that is spheres which scatter, the first kind of its description: voids, titanium "
            "white. Default 0.02: washed cotton"
        ),
        default=0.02,
        min=0.0,
        max=0.5,
        soft_max=0.1,
        precision=4,
        step=0.1,
        update=tag_owner,
    )
    dye: FloatProperty(
        name="Dye",
        description=(
            "Factor on the absorption of its matter at all wavelengths, as of more dye. Default 1: as it was described"
        ),
        default=1.0,
        min=0.0,
        max=100.0,
        soft_max=4.0,
        precision=2,
        update=tag_owner,
    )


def _reflected(self):
    from .readout import reflected

    return reflected(self)


def _passed(self):
    from .readout import passed

    return passed(self)


class LumenrayClothSettings(PropertyGroup):
    """Composition of a cloth; it counts where the material's model is one."""

    name: StringProperty(name="Name", description="Name of the cloth, for people", update=tag_owner)
    content: content_property()
    quality: quality_property(
        "A tenth of the rays: grainy over directions, right in its totals",
        "The rays that the errors are stated for; takes ten times as long",
    )
    weave: EnumProperty(
        name="Weave",
        description="How warp and weft cross. Default Plain: over one, under one",
        items=[
            ("PLAIN", "Plain", "Over one, under one", 0),
            ("TWILL", "Twill", "Diagonals: the warp over some picks, under some", 1),
            ("SATIN", "Satin", "The warp up but at one pick in each repeat", 2),
            (
                "OWN",
                "As Described",
                "Crossing by crossing, from the rows or the bitmap of a file",
                3,
            ),
        ],
        default="PLAIN",
        update=tag_owner,
    )
    twill_over: IntProperty(
        name="Over",
        description="Number of picks that the warp is over. Default 2: as denim has it",
        default=2,
        min=1,
        max=15,
        update=tag_owner,
    )
    twill_under: IntProperty(
        name="Under",
        description="Number of picks that the warp is under. Default 1: as denim has it",
        default=1,
        min=1,
        max=15,
        update=tag_owner,
    )
    satin_ends: IntProperty(
        name="Ends",
        description="Number of ends, and of picks, of a repeat. Default 5: the smallest satin",
        default=5,
        min=5,
        max=32,
        update=tag_owner,
    )
    satin_step: IntProperty(
        name="Step",
        description="Number of picks by which the crossing moves from end to end. Default 2: fits five ends",
        default=2,
        min=2,
        max=30,
        update=tag_owner,
    )
    warp_pitch_mm: _length(
        "Warp Pitch [mm]",
        "From one end of the warp to the next, in millimetres. Default 0.25: cloth of shirts",
        0.25,
        0.01,
    )
    weft_pitch_mm: _length(
        "Weft Pitch [mm]",
        "From one pick of the weft to the next, in millimetres. Default 0.25: cloth of shirts",
        0.25,
        0.01,
    )
    is_weft_as_warp: BoolProperty(
        name="Weft as Warp",
        description="Whether both are of one yarn. Default on: most cloths are",
        default=True,
        update=tag_owner,
    )
    warp: PointerProperty(type=LumenrayClothYarn)
    weft: PointerProperty(type=LumenrayClothYarn)
    pile_yarn: PointerProperty(type=LumenrayClothYarn)
    pile_height_mm: _length(
        "Pile Height [mm]",
        "Above the middle of the ground, in millimetres. Default 1: as of velour",
        1.0,
        0.05,
    )
    density_per_mm2: FloatProperty(
        name="Pile Density [1/mm²]",
        description="Number of ends of the pile in a square millimetre. Default 30: as of velour",
        default=30.0,
        min=0.01,
        max=2000.0,
        soft_max=100.0,
        precision=2,
        update=tag_owner,
    )
    lean: FloatProperty(
        name="Lean",
        description="Of the pile from the normal, along the warp. Default 0°: it stands upright",
        default=0.0,
        min=0.0,
        max=math.radians(60.0),
        subtype="ANGLE",
        update=tag_owner,
    )
    turn: FloatProperty(
        name="Drape Turn",
        description=(
            "By how much the cloth is turned on its surface, from U to V of the UV map, along which the warp runs. "
            "Default 0°: curtains hang by their warp"
        ),
        default=0.0,
        min=-math.pi,
        max=math.pi,
        subtype="ANGLE",
        update=tag_owner,
    )
    reflected: swatch_property(
        "Reflected", "Colour of light along the normal that comes back, under daylight", _reflected
    )
    passed: swatch_property(
        "Passed",
        "Colour of light along the normal that passes through yarns, under daylight",
        _passed,
    )


CLASSES = (LumenrayClothYarn, LumenrayClothSettings)
