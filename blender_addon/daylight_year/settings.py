"""What the user sets about the daylight of a year: a group of a scene."""

from bpy.props import FloatProperty, IntProperty, PointerProperty, StringProperty
from bpy.types import Collection, Object, PropertyGroup

from ..foundation.settings import PATH_OPTIONS


def _is_mesh(self, thing) -> bool:
    return thing.type == "MESH"


class LumenrayYearSettings(PropertyGroup):
    """A year of daylight over a floor."""

    weather_file: StringProperty(
        name="Weather File",
        description=(
            "EPW or WEA file with the hours of a year at the place; empty: that of the world's sky, if it has one"
        ),
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
    )
    floor: PointerProperty(
        name="Floor",
        description="Mesh above which sensors stand in a grid and look up; what of it is level counts",
        type=Object,
        poll=_is_mesh,
    )
    spacing: FloatProperty(
        name="Spacing",
        description=(
            "Distance between sensors, in metres. Default 0.5: what LM-83 and EN 17037 ask for in rooms of usual size"
        ),
        default=0.5,
        min=0.01,
        soft_min=0.1,
        soft_max=2.0,
        max=100.0,
    )
    height: FloatProperty(
        name="Height",
        description="Of the sensors above the floor, in metres. Default 0.8: about that of a desk",
        default=0.8,
        min=0.0,
        max=100.0,
        soft_max=2.0,
    )
    blinds: PointerProperty(
        name="Blinds",
        description=(
            "Collection whose meshes are the closed blinds; each collection in it is a group of windows of its own. A "
            "group is closed in the hours in which the sun through it would light more than 2 % of the sensors with more "
            "than 1000 lx (LM-83); empty: there are none"
        ),
        type=Collection,
    )
    target: FloatProperty(
        name="Target",
        description="Illuminance in lx that a place needs, for the daylight autonomy. Default 300: the target of LM-83",
        default=300.0,
        min=1.0,
        max=100000.0,
        precision=0,
        step=5000,
    )
    samples: IntProperty(
        name="Samples",
        description="Number of paths of every sensor. Default 4096: errors of sensors of about 1 % in rooms with windows",
        default=4096,
        min=64,
        max=1 << 24,
    )


CLASSES = (LumenrayYearSettings,)
"""For registration."""
