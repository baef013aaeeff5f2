"""Daylight by a sky: what the user sets about it, and where its sun stands."""

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

from .daylight.following import follow_edit
from .foundation.settings import PATH_OPTIONS

SOURCES = [
    ("NODES", "World Nodes", "Light comes from the background that the world's nodes state", 0),
    (
        "CIE",
        "Sky",
        "Light comes from a sky over an evenly bright ground; the world's nodes do not count",
        1,
    ),
]

KINDS = [
    ("CIE", "CIE Type", "One of the sixteen skies of the CIE, by its number", 0),
    (
        "CLOUDINESS",
        "Cloudiness",
        "Between the clear and the overcast sky of the CIE, by the part of the light that clouds give",
        1,
    ),
    (
        "WEATHER",
        "Weather File",
        "The sky of an hour of a weather file (EPW or WEA), by the all-weather model of Perez",
        2,
    ),
    (
        "MEASURED",
        "Measured",
        "Luminances that were measured: of 145 patches of the sky, or of a grid of directions",
        3,
    ),
]

LEVELS = [
    (
        "ILLUMINANCE",
        "Horizontal, Sky",
        "State the illuminance of an unobstructed horizontal plane by the sky alone",
        0,
    ),
    ("ZENITH", "Zenith Luminance", "State the luminance of the sky at the zenith", 1),
    (
        "TOTAL",
        "Horizontal, Sky and Sun",
        "State the illuminance of an unobstructed horizontal plane by the sky and the sun of place and time together; "
        "the sky gives what the sun leaves of it",
        2,
    ),
    (
        "MODEL",
        "Clear Sky's Own",
        "The illuminance that the spectral sky itself has, by turbidity, ground and height of the sun; its spectrum has to "
        "be that of a clear sky",
        3,
    ),
]

SPECTRA = [
    (
        "TEMPERATURE",
        "Daylight",
        "Average daylight of a colour temperature, the same for every sky",
        0,
    ),
    (
        "CLEAR",
        "Clear Sky",
        "Light of a cloudless sky by the turbidity of the air, the ground and the height of the sun (Hosek and Wilkie, as "
        "Mitsuba's spectral sky), for skies without clouds and a sun above the horizon alone",
        1,
    ),
]

MEANS = [
    ("HOUR", "Hour", "The record of the file that holds the moment of place and time", 0),
    (
        "MONTH",
        "Mean of the Month",
        "The mean sky, and the mean sunlight, of this hour over all days of the month",
        1,
    ),
    (
        "RANGE",
        "Mean of Hours",
        "The mean sky of chosen hours of chosen months, with the sun in it as a band of light along its ways",
        2,
    ),
]

TYPES = [
    (
        "1",
        "1: Overcast",
        "Three times as bright at the zenith as at the horizon, the same all around: the standard overcast sky",
        1,
    ),
    ("2", "2: Overcast, Sun Side Brighter", "As 1, and a little brighter towards the sun", 2),
    (
        "3",
        "3: Overcast, Less Steep",
        "One and a half times as bright at the zenith as at the horizon, the same all around",
        3,
    ),
    ("4", "4: As 3, Sun Side Brighter", "As 3, and a little brighter towards the sun", 4),
    ("5", "5: Uniform", "The same luminance in every direction", 5),
    ("6", "6: Cloudy, Even", "Partly cloudy, even in height, a little brighter towards the sun", 6),
    ("7", "7: Cloudy, Bright Sun Side", "Partly cloudy, even in height, bright around the sun", 7),
    ("8", "8: Cloudy, Corona", "Partly cloudy, even in height, with a corona around the sun", 8),
    ("9", "9: Cloudy, Sun Hidden", "Partly cloudy, bright horizon, the sun behind a cloud", 9),
    ("10", "10: Cloudy, Sun Dimmed", "Partly cloudy, bright horizon, bright around the sun", 10),
    (
        "11",
        "11: White-blue, Corona",
        "White-blue, bright horizon, with a corona around the sun",
        11,
    ),
    ("12", "12: Clear", "The standard clear sky, for clean air", 12),
    ("13", "13: Clear, Polluted Air", "The standard clear sky, for polluted air", 13),
    ("14", "14: Cloudless, Turbid", "Without clouds but hazy, with a broad corona", 14),
    ("15", "15: White-blue, Turbid", "White-blue and hazy, with a broad corona", 15),
    (
        "16",
        "16: Overcast, Traditional",
        "Three times as bright at the zenith as at the horizon, straight with the sine of the height "
        "(Moon and Spencer): the sky of the daylight factor",
        16,
    ),
]
"""The standard general skies by their numbers in CIE S 011, and the traditional overcast sky."""

EVEN_AROUND = {1, 3, 5, 16}
"""Types that are the same all around, so that it does not count where the sun stands."""


class LumenraySkySettings(PropertyGroup):
    """A sky; ignored unless the world's ``source`` is ``CIE``."""

    kind: EnumProperty(
        name="Kind of Sky",
        description="What tells how the sky's light is distributed. Default CIE Type: it needs no data",
        items=KINDS,
        default="CIE",
        update=follow_edit,
    )
    type: EnumProperty(
        name="Type",
        description=(
            "How the luminance is distributed over the sky, by CIE S 011 (ISO 15469). Default 16: Overcast, "
            "Traditional: the sky of the daylight factor"
        ),
        items=TYPES,
        default="16",
        update=follow_edit,
    )
    cloudiness: FloatProperty(
        name="Cloudiness",
        description=(
            "Part of the horizontal illuminance that the overcast sky gives, the clear sky giving the rest, 0 to 1. "
            "Default 0.5: half cloudy"
        ),
        default=0.5,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=follow_edit,
    )
    weather_file: StringProperty(
        name="Weather File",
        description="Weather of a year: EPW of EnergyPlus, or WEA of Daysim and Radiance",
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=follow_edit,
    )
    weather_mean: EnumProperty(
        name="Hours",
        description=(
            "Which hours of the weather file the sky is made of. Default Hour: the weather of one moment"
        ),
        items=MEANS,
        default="HOUR",
        update=follow_edit,
    )
    mean_first_month: IntProperty(
        name="First Month",
        description=(
            "Number of the month from whose first day on hours count. Default 1: the whole year, with the last month"
        ),
        default=1,
        min=1,
        max=12,
        update=follow_edit,
    )
    mean_last_month: IntProperty(
        name="Last Month",
        description=(
            "Number of the month up to whose last day hours count; one before the first: over the turn of the year. "
            "Default 12: the whole year, with the first month"
        ),
        default=12,
        min=1,
        max=12,
        update=follow_edit,
    )
    mean_start: FloatProperty(
        name="Start",
        description=(
            "Time of the day from which on records count, in hours of the weather file's standard time. Default 8: people "
            "are at work"
        ),
        default=8.0,
        min=0.0,
        max=24.0,
        precision=1,
        step=100,
        update=follow_edit,
    )
    mean_end: FloatProperty(
        name="End",
        description=(
            "Time of the day until which records count, in hours of the weather file's standard time; before the start: "
            "over midnight. Default 18: people leave"
        ),
        default=18.0,
        min=0.0,
        max=24.0,
        precision=1,
        step=100,
        update=follow_edit,
    )
    use_mean_sun: BoolProperty(
        name="Sun in the Sky",
        description=(
            "Let the mean sky hold the sunlight of its hours, along the ways of the sun; a Sun light has but one place. "
            "Default on: all daylight of these hours"
        ),
        default=True,
        update=follow_edit,
    )
    measured_file: StringProperty(
        name="Measured Sky",
        description=(
            "Table of luminances in cd/m²: 145 numbers, one a line, of the patches of Tregenza from the horizon up; or "
            "elevation, azimuth and luminance in each line, for any grid"
        ),
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=follow_edit,
    )
    measured_text: PointerProperty(
        name="Measured Sky",
        description="Text data-block that holds the table, in place of a file",
        type=bpy.types.Text,
        update=follow_edit,
    )
    use_file_level: BoolProperty(
        name="Level of the File",
        description=(
            "Let the sky be as bright as the weather file or the measured table says. Default on: the file knows it"
        ),
        default=True,
        update=follow_edit,
    )
    level: EnumProperty(
        name="Level",
        description=(
            "How it is stated how bright the sky is. Default Horizontal, Sky: meters measure it"
        ),
        items=LEVELS,
        default="ILLUMINANCE",
        update=follow_edit,
    )
    zenith_luminance: FloatProperty(
        name="Zenith Luminance",
        description="Of the sky at the zenith, in cd/m². Default 4000: an overcast day",
        default=4000.0,
        min=0.0,
        max=1e6,
        soft_max=50000.0,
        step=10000,
        precision=0,
        update=follow_edit,
    )
    total_illuminance: FloatProperty(
        name="Total Horizontal Illuminance",
        description=(
            "By sky and sun together, on an unobstructed horizontal plane, in lx. Default 60000: a clear day in spring"
        ),
        default=60000.0,
        min=0.0,
        max=1e6,
        soft_max=150000.0,
        step=10000,
        precision=0,
        update=follow_edit,
    )
    use_place: BoolProperty(
        name="Place and Time",
        description=(
            "Let the sky's sun stand where it stands at the world's place and time, before all Sun lights and angles. "
            "Default off: Sun light or angles hold, as in older files"
        ),
        default=False,
        update=follow_edit,
    )
    illuminance: FloatProperty(
        name="Horizontal Illuminance",
        description=(
            "By the sky alone, without the sun, on an unobstructed horizontal plane, in lx. Default 10000: an "
            "overcast day"
        ),
        default=10000.0,
        min=0.0,
        max=1e6,
        soft_max=100000.0,
        step=10000,
        precision=0,
        update=follow_edit,
    )
    use_sun_lamp: BoolProperty(
        name="Scene's Sun",
        description=(
            "Let the sky's sun stand where the scene's Sun light shines from: the first one by name if there are "
            "several. Hidden ones and those inside instances do not count; one of strength 0 does. The two angles "
            "hold if there is none. Default on: sky and sun agree"
        ),
        default=True,
        update=follow_edit,
    )
    elevation: FloatProperty(
        name="Elevation",
        description="Height of the sun above the horizon. Default 45°: half way up, as on a summer morning",
        default=math.radians(45.0),
        min=0.0,
        max=math.radians(90.0),
        subtype="ANGLE",
        update=follow_edit,
    )
    azimuth: FloatProperty(
        name="Azimuth",
        description=(
            "Where the sun stands, as on a compass: 0° is north, along +Y; 90° is east, along +X. Default 180°: "
            "south, where it is at noon"
        ),
        default=math.radians(180.0),
        min=math.radians(-360.0),
        max=math.radians(360.0),
        subtype="ANGLE",
        update=follow_edit,
    )
    ground_reflectance: FloatProperty(
        name="Ground Reflectance",
        description=(
            "Every direction below the horizon is as bright as a matt ground of this reflectance under the sky, 0 "
            "to 1. Default 0.2: grass and earth"
        ),
        default=0.2,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=follow_edit,
    )
    spectrum: EnumProperty(
        name="Spectrum",
        description=(
            "What spectrum sky and ground have; it never changes the illuminance that is stated. Default Daylight: "
            "it is defined for every sky"
        ),
        items=SPECTRA,
        default="TEMPERATURE",
        update=follow_edit,
    )
    turbidity: FloatProperty(
        name="Turbidity",
        description=(
            "Turbidity of the air by Hosek and Wilkie, a factor of 1 to 10: 2 is clean and cold, 6 warm and moist, 10 hazy. "
            "Default 3: a clear day"
        ),
        default=3.0,
        min=1.0,
        max=10.0,
        update=follow_edit,
    )
    colour_temperature: FloatProperty(
        name="Colour Temperature",
        description=(
            "Of the daylight that sky and ground give, in kelvins; it never changes the illuminance. Default 6500: "
            "that of D65, average daylight"
        ),
        default=6500.0,
        min=4000.0,
        max=25000.0,
        soft_max=12000.0,
        step=10000,
        precision=0,
        update=follow_edit,
    )


def depends_on_sun(settings: LumenraySkySettings) -> bool:
    """Tell whether it counts where the sun stands."""
    if settings.kind == "CIE":
        return int(settings.type) not in EVEN_AROUND
    if settings.kind == "CLOUDINESS":
        return settings.cloudiness < 1.0
    return settings.kind == "WEATHER" and settings.weather_mean == "HOUR"


def states_level(settings: LumenraySkySettings) -> bool:
    """Tell whether the settings say how bright the sky is, and not a file."""
    return settings.kind not in {"WEATHER", "MEASURED"} or not settings.use_file_level


def takes_lamp(settings: LumenraySkySettings) -> bool:
    """Tell whether a Sun light may say where the sky's sun stands."""
    is_by_place = settings.use_place or settings.kind == "WEATHER"
    return depends_on_sun(settings) and settings.use_sun_lamp and not is_by_place


def needs_moment(settings: LumenraySkySettings) -> bool:
    """Tell whether the sky depends on place and time."""
    if settings.kind == "WEATHER":
        return True
    if settings.level == "TOTAL" and states_level(settings):
        return True
    return settings.use_place and depends_on_sun(settings)


def find_sun_lamp(scene, view_layer):
    """Return the visible Sun light object that a sky takes its sun from, None without one."""
    lamps = [
        item
        for item in scene.objects
        if item.type == "LIGHT"
        and item.data.type == "SUN"
        and item.visible_get(view_layer=view_layer)
    ]
    return min(lamps, key=lambda item: item.name_full, default=None)
