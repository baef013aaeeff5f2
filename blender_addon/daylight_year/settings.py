"""What the user sets about the daylight of a year: a group of a scene."""

import math

from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import Collection, Object, PropertyGroup

from ..foundation.settings import PATH_OPTIONS

RULES = [
    (
        "STANDARD",
        "LM-83",
        "Closed in the hours in which the sun through the group would light more than 2 % of the sensors with more than "
        "1000 lx",
        0,
    ),
    (
        "TIMES",
        "Schedule",
        "Closed in chosen hours of chosen months, by the clocks of the place",
        1,
    ),
    (
        "TABLE",
        "Table",
        "Closed as a file says: 0 or 1 for every record of the weather file",
        2,
    ),
    (
        "SUN",
        "Sun",
        "Closed while the sun's irradiance of a plane that faces it is above a bound",
        3,
    ),
    (
        "HORIZONTAL",
        "Horizontal",
        "Closed while the irradiance of a horizontal plane in the open, by sun and sky, is above a bound",
        4,
    ),
    (
        "FACADE",
        "Facade",
        "Closed while the irradiance of a vertical plane in the open, by sun, sky and ground, is above a bound",
        5,
    ),
    (
        "SENSORS",
        "Sensors",
        "Closed while the mean illuminance of the sensors, all blinds open, is above a bound",
        6,
    ),
]
"""What closes blinds."""

IRRADIANCES = {"SUN", "HORIZONTAL", "FACADE"}
"""Rules with a bound in W/m2."""


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
            "Collection whose meshes are the closed blinds; each collection in it is a group of windows of its own. "
            "Empty: there are none"
        ),
        type=Collection,
    )
    blinds_rule: EnumProperty(
        name="Closed By",
        description=(
            "When the blinds of a group of windows are closed. Default LM-83: what its spatial daylight autonomy (sDA) asks "
            "for, which keeps these blinds under every other rule"
        ),
        items=RULES,
        default="STANDARD",
    )
    blinds_first_month: IntProperty(
        name="First Month",
        description="Number of the month from whose first day on blinds are closed. Default 4: the sun gets high",
        default=4,
        min=1,
        max=12,
    )
    blinds_last_month: IntProperty(
        name="Last Month",
        description=(
            "Number of the month up to whose last day blinds are closed; one before the first: over the turn of the year. "
            "Default 9: the sun gets low"
        ),
        default=9,
        min=1,
        max=12,
    )
    blinds_start: FloatProperty(
        name="Start",
        description="Time of the day, in hours by the clocks, from which on blinds are closed. Default 9: people are there",
        default=9.0,
        min=0.0,
        max=24.0,
        precision=1,
        step=50,
    )
    blinds_end: FloatProperty(
        name="End",
        description=(
            "Time of the day, in hours by the clocks, until which blinds are closed; before the start: over midnight. "
            "Default 17: people leave"
        ),
        default=17.0,
        min=0.0,
        max=24.0,
        precision=1,
        step=50,
    )
    blinds_workdays: BoolProperty(
        name="Workdays Alone",
        description="Close blinds from Monday to Friday only. Default off: every day",
        default=False,
    )
    blinds_file: StringProperty(
        name="States",
        description=(
            "Text file with a line for every record of the weather file, 8760 for a year by the hour: 0 is open, 1 closed; "
            "a column for each group of windows, or one for all"
        ),
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
    )
    blinds_irradiance: FloatProperty(
        name="Closed Above",
        description=(
            "Irradiance above which blinds are closed, in W/m². Default 200: a bound that is often used for the sun on a "
            "window"
        ),
        default=200.0,
        min=0.0,
        max=1500.0,
        precision=0,
        step=1000,
    )
    blinds_illuminance: FloatProperty(
        name="Closed Above",
        description=(
            "Mean illuminance of the sensors above which blinds are closed, in lx. Default 3000: the end of useful daylight"
        ),
        default=3000.0,
        min=0.0,
        max=200000.0,
        precision=0,
        step=10000,
    )
    blinds_azimuth: FloatProperty(
        name="Facade Faces",
        description="Compass direction that the facade faces: 0° is north, 90° east. Default 180°: south, sunny at noon",
        default=math.radians(180.0),
        min=math.radians(-360.0),
        max=math.radians(360.0),
        subtype="ANGLE",
    )
    maps: PointerProperty(
        name="Maps On",
        description=(
            "Collection whose meshes get maps of all figures, besides those of the floor's sensors: a UV map and images of "
            "the daylight autonomy, useful and mean illuminance and others. Empty: none"
        ),
        type=Collection,
    )
    map_density: FloatProperty(
        name="Lumels per m",
        description=(
            "Lumels of the maps per metre on the surface; every lumel is a sensor of its own. Default 2: as dense as the "
            "usual sensors"
        ),
        default=2.0,
        min=0.01,
        max=100.0,
        soft_max=10.0,
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
