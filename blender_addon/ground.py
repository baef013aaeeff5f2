"""Settings of what lies behind a scene: the ground of the surroundings, and the photo that covers a part of them."""

import math

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    PointerProperty,
)
from bpy.types import PropertyGroup

from .foundation.settings import tag_owner


class LumenrayGroundSettings(PropertyGroup):
    """Ground and photo of a world."""

    use_ground: BoolProperty(
        name="Ground",
        description=(
            "Lay the lower half of the surroundings on a level plane: reflections show it as near as it is, and it "
            "catches shadows. Default off: all of the surroundings is at infinity, as in Cycles"
        ),
        default=False,
        update=tag_owner,
    )
    level: FloatProperty(
        name="Height",
        description=(
            "Height of the plane in the scene, along Z. Default 0: where things stand in Blender"
        ),
        default=0.0,
        soft_min=-10.0,
        soft_max=10.0,
        subtype="DISTANCE",
        unit="LENGTH",
        update=tag_owner,
    )
    camera_height: FloatProperty(
        name="Eye Height",
        description=(
            "How high above the ground the camera stood that the surroundings were taken with. Default 1.5: on a tripod"
        ),
        default=1.5,
        min=0.01,
        max=1e4,
        soft_max=10.0,
        subtype="DISTANCE",
        unit="LENGTH",
        update=tag_owner,
    )
    centre: FloatVectorProperty(
        name="Eye",
        description=(
            "Where in the scene, along X and Y, the camera of the surroundings stood; pictures from there show the ground "
            "as it was taken"
        ),
        size=2,
        default=(0.0, 0.0),
        subtype="TRANSLATION",
        unit="LENGTH",
        update=tag_owner,
    )
    radius: FloatProperty(
        name="Radius",
        description=(
            "How far the ground reaches about the camera of the surroundings; from half of that on it passes into what is "
            "at infinity. Default 30: beyond, a step to the side hardly shows"
        ),
        default=30.0,
        min=0.1,
        max=1e5,
        subtype="DISTANCE",
        unit="LENGTH",
        update=tag_owner,
    )
    photo: EnumProperty(
        name="Photo",
        description="Photo that covers a part of the surroundings. Default None: they are as they are",
        items=[
            ("NONE", "None", "The surroundings are seen as they are", 0),
            (
                "CAMERA",
                "Of the Camera",
                "Background image of the scene's camera, which stands as that of the photo did: behind all, in reflections, "
                "and on the ground if there is one",
                1,
            ),
            (
                "PLATE",
                "Back Plate",
                "Sharper picture from the place of the surroundings, which the camera alone sees in their place",
                2,
            ),
        ],
        default="NONE",
        update=tag_owner,
    )
    plate: PointerProperty(
        name="Back Plate",
        description="Photo that was taken level from the place of the surroundings",
        type=bpy.types.Image,
        update=tag_owner,
    )
    plate_azimuth: FloatProperty(
        name="Azimuth",
        description=(
            "Where the middle of the photo lies, as on a compass: 0° is north, along +Y; 90° is east, along +X. Default 0°: "
            "to the north"
        ),
        default=0.0,
        min=math.radians(-360.0),
        max=math.radians(360.0),
        subtype="ANGLE",
        update=tag_owner,
    )
    plate_angle: FloatProperty(
        name="Field of View",
        description="Angle from the left to the right border of the photo. Default 60°: a common lens",
        default=math.radians(60.0),
        min=math.radians(1.0),
        max=math.radians(170.0),
        subtype="ANGLE",
        update=tag_owner,
    )
    photo_luminance: FloatProperty(
        name="White of the Photo",
        description=(
            "Luminance that white in the photo stands for, in cd/m². Default 0: that of the film, so that the photo shows "
            "as it is"
        ),
        default=0.0,
        min=0.0,
        max=1e6,
        update=tag_owner,
    )


CLASSES = (LumenrayGroundSettings,)
