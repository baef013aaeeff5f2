"""Daylight by a sky of the CIE: what the user sets about it, and where its sun stands."""

import math

import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty
from bpy.types import PropertyGroup

from .foundation.settings import tag_owner

SOURCES = [
    ("NODES", "World Nodes", "Light comes from the background that the world's nodes state", 0),
    (
        "CIE",
        "CIE Sky",
        "Light comes from a sky of the CIE over an evenly bright ground; the world's nodes do not count",
        1,
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

UPWARDS = np.array([0.0, 0.0, 1.0])


class LumenraySkySettings(PropertyGroup):
    """A sky of the CIE; ignored unless the world's ``source`` is ``CIE``."""

    type: EnumProperty(
        name="Type",
        description=(
            "How the luminance is distributed over the sky, by CIE S 011 (ISO 15469). Default 16: Overcast, "
            "Traditional: the sky of the daylight factor"
        ),
        items=TYPES,
        default="16",
        update=tag_owner,
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
        update=tag_owner,
    )
    use_sun_lamp: BoolProperty(
        name="Scene's Sun",
        description=(
            "Let the sky's sun stand where the scene's Sun light shines from: the first one by name if there are "
            "several. Hidden ones and those inside instances do not count; one of strength 0 does. The two angles "
            "hold if there is none. Default on: sky and sun agree"
        ),
        default=True,
        update=tag_owner,
    )
    elevation: FloatProperty(
        name="Elevation",
        description="Height of the sun above the horizon. Default 45°: half way up, as on a summer morning",
        default=math.radians(45.0),
        min=0.0,
        max=math.radians(90.0),
        subtype="ANGLE",
        update=tag_owner,
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
        update=tag_owner,
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
        update=tag_owner,
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
        update=tag_owner,
    )


def depends_on_sun(settings: LumenraySkySettings) -> bool:
    """Tell whether it counts where the sun stands."""
    return int(settings.type) not in EVEN_AROUND


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


def towards_lamp(matrix) -> np.ndarray | None:
    """Return the unit vector to where a light with this world matrix shines from, None if it is squeezed flat. (3,)"""
    axis = np.array(matrix, dtype=np.float64)[:3, 2]
    length = np.linalg.norm(axis)
    return axis / length if length > 0.0 else None


def onto_horizon(towards_sun: np.ndarray) -> np.ndarray:
    """Lift a direction that points below the horizon up to it; straight below is north. (3,)"""
    if towards_sun[2] >= 0.0:
        return towards_sun
    length = np.hypot(towards_sun[0], towards_sun[1])
    if length < 1e-6:
        return np.array([0.0, 1.0, 0.0])
    return np.array([towards_sun[0] / length, towards_sun[1] / length, 0.0])


def angles(towards_sun: np.ndarray) -> tuple[float, float]:
    """Elevation, and azimuth from +y (north) towards +x (east), 0 to 2 pi, of a unit vector. [rad]"""
    x, y, z = (float(value) for value in towards_sun)
    return math.asin(min(max(z, -1.0), 1.0)), math.atan2(x, y) % (2.0 * math.pi)
