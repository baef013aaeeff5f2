"""What the user sets of a picture of the surroundings as light; a group of a world."""

import math

from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ..foundation.settings import tag_owner

SUNS = [
    (
        "AUTO",
        "Likely One",
        "The brightest source, if it is small, above the horizon and gives twice the light of any other",
        0,
    ),
    (
        "BRIGHTEST",
        "Brightest Source",
        "The source that gives most light, whatever it looks like",
        1,
    ),
    (
        "NONE",
        "None",
        "All sources are lamps: none is mended, and each is as wide as in the picture",
        2,
    ),
]

REPAIRS = [
    ("NONE", "None", "The sun gives what the picture says", 0),
    (
        "RATIO",
        "Sky Ratio",
        "The sun gives a multiple of the horizontal illuminance by all the rest of the picture",
        1,
    ),
    (
        "MODEL",
        "Sky Model",
        "The sun of the CIE's clear sky for its height, with that sky as bright as the picture at a place that you pick; "
        "for pictures in which buildings or trees hide the sky",
        2,
    ),
]

HALVES = [
    ("MORNING", "Morning", "The sun rises", 0),
    ("AFTERNOON", "Afternoon", "The sun sinks", 1),
]


class LumenrayEnvironmentSettings(PropertyGroup):
    """How the light of a picture is taken; ignored where the world's nodes show none."""

    use_sources: BoolProperty(
        name="Bright Sources as Lights",
        description=(
            "Take the sun and other small bright sources out of the picture and let lights with the same illuminance "
            "shine in their place: clear shadows and less noise. Default off: your worlds light as before"
        ),
        default=False,
        update=tag_owner,
    )
    source_factor: FloatProperty(
        name="Source Luminance",
        description=(
            "What is so many times as bright as the mean of the picture makes a source, a factor. Default 20: more "
            "than any sky has beside its sun"
        ),
        default=20.0,
        min=1.01,
        max=1e6,
        soft_max=1000.0,
        precision=1,
        update=tag_owner,
    )
    edge_factor: FloatProperty(
        name="Edge Luminance",
        description=(
            "What is so many times as bright as the mean, a factor, belongs to a source beside it. Default 10: half "
            "of what makes one"
        ),
        default=10.0,
        min=1.01,
        max=1e6,
        soft_max=1000.0,
        precision=1,
        update=tag_owner,
    )
    radius: FloatProperty(
        name="Largest Radius",
        description=(
            "Of a bright area; what goes on beyond it, such as a window, stays in the picture. Default 3°: a sun and "
            "the glare of the lens about it"
        ),
        default=math.radians(3.0),
        min=math.radians(0.1),
        max=math.radians(45.0),
        subtype="ANGLE",
        update=tag_owner,
    )
    use_lower: BoolProperty(
        name="Lower Half Too",
        description=(
            "Look for sources below the horizon as well. Default off: reflections on the ground are no lamps"
        ),
        default=False,
        update=tag_owner,
    )
    sun: EnumProperty(
        name="Sun",
        description=(
            "Which of the sources is the sun, which is as wide as the true one and can be mended. Default Likely One: most "
            "pictures with a sun show it so"
        ),
        items=SUNS,
        default="AUTO",
        update=tag_owner,
    )
    repair: EnumProperty(
        name="Mend Sun",
        description=(
            "Cameras clip the sun: give it the light that it has in such weather. Default None: a lamp would be "
            "mended as well"
        ),
        items=REPAIRS,
        default="NONE",
        update=tag_owner,
    )
    sun_ratio: FloatProperty(
        name="Sun to Sky",
        description=(
            "Horizontal illuminance of the sun over that of the rest of the picture, a factor. Default 4: clear weather"
        ),
        default=4.0,
        min=0.0,
        max=100.0,
        soft_max=10.0,
        precision=2,
        update=tag_owner,
    )
    sky_point: FloatVectorProperty(
        name="Place of the Sky",
        description=(
            "Where the picture shows clear sky, from its left and its lower edge, 0 to 1; away from the sun and from "
            "clouds. It is picked in an Image Editor"
        ),
        size=2,
        default=(0.0, 0.0),
        min=0.0,
        max=1.0,
        precision=4,
        update=tag_owner,
    )
    half: EnumProperty(
        name="Half of the Day",
        description=(
            "The sun stands as high twice a day: in which half the picture was taken. Default Morning: the picture "
            "cannot tell"
        ),
        items=HALVES,
        default="MORNING",
    )
    meter_elevation: FloatProperty(
        name="Meter's Elevation",
        description=(
            "Where the plane faces whose illuminance is stated, above the horizon. Default 90°: straight up, a "
            "horizontal plane"
        ),
        default=math.radians(90.0),
        min=math.radians(-90.0),
        max=math.radians(90.0),
        subtype="ANGLE",
        update=tag_owner,
    )
    meter_azimuth: FloatProperty(
        name="Meter's Azimuth",
        description=(
            "Where the plane faces whose illuminance is stated, from +Y over +X as on a compass. Default 0°: along "
            "+Y; it does not count for a horizontal plane"
        ),
        default=0.0,
        min=math.radians(-360.0),
        max=math.radians(360.0),
        subtype="ANGLE",
        update=tag_owner,
    )
    found: StringProperty(name="Found", options={"HIDDEN"})


CLASSES = (LumenrayEnvironmentSettings,)
