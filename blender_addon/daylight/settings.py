"""What the user sets of a place, of the time there and of the sun that follows them; each a group of a world."""

import math

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ...engine.sky.limits import FIRST_YEAR, HIGHEST, LAST_YEAR, LOWEST
from . import following
from .following import follow_edit
from .places import fill_in_city, search_cities, search_zones

AMOUNTS = [
    (
        "TURBIDITY",
        "Clear Air",
        "What the air leaves of it at this height of the sun, by the turbidity of the air",
        0,
    ),
    (
        "GIVEN",
        "Facing the Sun",
        "An illuminance that you state of a plane that faces the sun, while it is above the horizon",
        1,
    ),
    (
        "WEATHER",
        "Weather File",
        "What the weather file of the sky states for this hour; the world's sky has to be one of a weather file",
        2,
    ),
    (
        "HORIZONTAL",
        "Horizontal",
        "An illuminance that you state of a horizontal plane by the sun alone, while it is above the horizon",
        3,
    ),
]


def _switch_note(self, context):
    if not self.use_note:
        following.take_notes_away(self.id_data)
    follow_edit(self, context)


def _fill_in(self, context):
    fill_in_city(self)
    follow_edit(self, context)


def _is_sun(self, thing) -> bool:
    return following.is_sun(thing)


class LumenrayPlaceSettings(PropertyGroup):
    """Where on the Earth a scene lies, and how it is turned."""

    city: StringProperty(
        name="City",
        description=(
            "City that the scene lies in; type the beginning of its name and choose it: coordinates, height and time "
            "zone are filled in. Own cities come from a list in the extension's preferences"
        ),
        default="Berlin, Germany",
        maxlen=255,
        search=search_cities,
        update=_fill_in,
    )
    latitude: FloatProperty(
        name="Latitude",
        description="Positive north of the equator. Default 52.52°: Berlin, until a city is chosen",
        default=math.radians(52.52),
        min=math.radians(-90.0),
        max=math.radians(90.0),
        precision=5,
        subtype="ANGLE",
        update=follow_edit,
    )
    longitude: FloatProperty(
        name="Longitude",
        description="Positive east of Greenwich. Default 13.4°: Berlin, until a city is chosen",
        default=math.radians(13.4),
        min=math.radians(-180.0),
        max=math.radians(180.0),
        precision=5,
        subtype="ANGLE",
        update=follow_edit,
    )
    zone: StringProperty(
        name="Time Zone",
        description=(
            "Name in the time zone data of the IANA, such as Europe/Berlin, which knows daylight saving time; or a fixed "
            "offset such as UTC+1"
        ),
        default="Europe/Berlin",
        maxlen=63,
        search=search_zones,
        update=follow_edit,
    )
    elevation: FloatProperty(
        name="Height",
        description=(
            "Above the sea, in metres: thinner air lets more sunlight through. Default 30: Berlin, until a city is chosen"
        ),
        default=30.0,
        min=LOWEST,
        max=HIGHEST,
        precision=0,
        step=1000,
        update=follow_edit,
    )
    north: FloatProperty(
        name="North Offset",
        description=(
            "Compass direction in which the scene's +Y axis points: at 90° it points east. The sun by place and time, "
            "weather skies and measured skies turn by it. Default 0°: north is along +Y"
        ),
        default=0.0,
        min=math.radians(-360.0),
        max=math.radians(360.0),
        precision=4,
        subtype="ANGLE",
        update=follow_edit,
    )


class LumenrayTimeSettings(PropertyGroup):
    """What the place's clocks show, and whether they go on with the scene's frames."""

    year: IntProperty(
        name="Year",
        description="Calendar year; the sun stands nearly the same in all. Default 2026: any will do",
        default=2026,
        min=FIRST_YEAR,
        max=LAST_YEAR,
        update=follow_edit,
    )
    month: IntProperty(
        name="Month",
        description=(
            "Month of the year, by its number. Default 3: with the 21st, when day and night are equally long"
        ),
        default=3,
        min=1,
        max=12,
        update=follow_edit,
    )
    day: IntProperty(
        name="Day",
        description=(
            "Day of the month, by its number; one that the month lacks is its last. Default 21: in March day and night "
            "are equally long"
        ),
        default=21,
        min=1,
        max=31,
        update=follow_edit,
    )
    hour: FloatProperty(
        name="Clock",
        description=(
            "What clocks show at the place, in hours, 12.5 being half past twelve; daylight saving time is known from the "
            "time zone. Default 12: about noon"
        ),
        default=12.0,
        min=0.0,
        max=24.0,
        precision=2,
        step=25,
        update=follow_edit,
    )
    is_second: BoolProperty(
        name="Second Time",
        description=(
            "Where clocks are put back they show an hour twice: take the second one. Default off: the first one is taken"
        ),
        default=False,
        update=follow_edit,
    )
    use_refraction: BoolProperty(
        name="Refraction",
        description=(
            "Put the sun where it is seen: the air bends its light and lifts it by 0.5° at the horizon, 0.1° at 10° and "
            "less above, for standard air of the place's height. Default on: light comes from where the sun is seen"
        ),
        default=True,
        update=follow_edit,
    )
    follows_frames: BoolProperty(
        name="Follow Frames",
        description=(
            "Let time go on with the scene's frames from the clock time above, for a study of the sun as an animation. "
            "Default off: one moment for all frames"
        ),
        default=False,
        update=follow_edit,
    )
    first_frame: IntProperty(
        name="First Frame",
        description="Number of the frame at which the clock shows the time above. Default 1: where scenes begin",
        default=1,
        update=follow_edit,
    )
    minutes_per_frame: FloatProperty(
        name="Minutes per Frame",
        description=(
            "By how many minutes time goes on from one frame to the next, in minutes. Default 10: a day of 24 hours has "
            "144 frames"
        ),
        default=10.0,
        min=-1440.0,
        max=1440.0,
        soft_min=0.0,
        soft_max=60.0,
        precision=1,
        step=100,
        update=follow_edit,
    )
    use_note: BoolProperty(
        name="Date in Pictures",
        description=(
            "Write place, date, clock and the sun's elevation into rendered pictures, as the note of Blender's own stamp "
            "(Output > Metadata > Burn Into Image). Default off: pictures stay clean"
        ),
        default=False,
        update=_switch_note,
    )


class LumenraySunSettings(PropertyGroup):
    """Sun light that follows place and time, and how much it gives."""

    lamp: PointerProperty(
        name="Sun Light",
        description=(
            "Sun light that is turned to where the sun stands and given its light, in Lumenray, Cycles and EEVEE alike; "
            "its own rotation, strength and colour are overwritten. Taken out of here it stays as it is"
        ),
        type=bpy.types.Object,
        poll=_is_sun,
        update=follow_edit,
    )
    amount: EnumProperty(
        name="Sunlight",
        description="How much light the sun gives. Default Clear Air: it needs no data",
        items=AMOUNTS,
        default="TURBIDITY",
        update=follow_edit,
    )
    turbidity: FloatProperty(
        name="Turbidity",
        description=(
            "Luminous turbidity of the air, a factor: how many clean atmospheres weaken sunlight as the real one does, "
            "2 very clear, 3 clear, 5 hazy. It gives the colour of sunlight too. Default 3: a clear day in Europe"
        ),
        default=3.0,
        min=1.0,
        max=20.0,
        soft_max=8.0,
        precision=1,
        update=follow_edit,
    )
    illuminance: FloatProperty(
        name="Direct Illuminance",
        description=(
            "By the sun alone on a plane that faces it, in lx. Default 80000: a high sun on a clear day"
        ),
        default=80000.0,
        min=0.0,
        max=150000.0,
        precision=0,
        step=100000,
        update=follow_edit,
    )
    horizontal_illuminance: FloatProperty(
        name="Direct Horizontal Illuminance",
        description=(
            "By the sun alone on an unobstructed horizontal plane, in lx. Default 50000: about noon on a clear day in spring"
        ),
        default=50000.0,
        min=0.0,
        max=150000.0,
        precision=0,
        step=100000,
        update=follow_edit,
    )


class LumenrayArcSettings(PropertyGroup):
    """Way of the sun over the day, as it is drawn in the 3D views."""

    is_shown: BoolProperty(
        name="Sun Arc",
        description=(
            "Draw the sun's way over the day in the 3D views, with hours and north; the sun on it can be dragged. Default "
            "off: views stay clean"
        ),
        default=False,
        update=following.redraw_arc,
    )
    radius: FloatProperty(
        name="Radius",
        description="Of the arc about the origin of the scene. Default 10: about a house",
        default=10.0,
        min=0.01,
        soft_max=1000.0,
        subtype="DISTANCE",
        unit="LENGTH",
        update=following.redraw_arc,
    )


CLASSES = (
    LumenrayPlaceSettings,
    LumenrayTimeSettings,
    LumenraySunSettings,
    LumenrayArcSettings,
)
