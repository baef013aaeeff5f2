"""What a world's sky, place, time and sun amount to, as short text for panels."""

import numpy as np

from ...engine.errors import LumenrayError
from ...engine.photometry.colour import REC709_LUMINANCE
from ...engine.scene.light import ImageWorld
from ...engine.sky.picture import find_illuminance
from ...engine.sky.place import to_local
from ...engine.sky.skies import ground_luminance, zenith_luminance
from ..foundation.report import ConversionReport, Severity
from ..readout import Description, format_amount
from ..sun_direction import UPWARDS, angles, onto_horizon, towards_lamp
from ..sync.skies import SkyTime, convert_sky
from ..sync.world import follows_sun_lamp
from .following import lamp_of, rotation_of
from .moment import Moment, find_day_of, find_moment, frame_of
from .places import is_at_city, known_cities
from .sunlight import find_sunlight

TURNED = 1e-3
"""Difference of angles from which on a Sun light does not stand where it should. [rad]"""


def describe_sky(world, lamp, scene) -> Description:
    """Say what a world's sky amounts to, and the sun's place if a Sun light (or None) states it."""
    report, lines, sun = ConversionReport(), [], None
    if lamp is not None and follows_sun_lamp(world):
        sun = towards_lamp(lamp.matrix_world)
    if sun is not None:
        elevation, azimuth = angles(onto_horizon(sun))
        lines = [
            ("Sun Light", lamp.name),
            ("Elevation", f"{np.degrees(elevation):.1f}°"),
            ("Azimuth", f"{np.degrees(azimuth):.1f}°"),
        ]
    sky = convert_sky(world, "", report, sun, SkyTime(scene, frame_of(scene)))
    problem = "; ".join(
        f"{row.message}: {row.remedy}" for row, _ in report.rows if row.severity != Severity.INFO
    )
    if sky is None:
        return Description(tuple(lines), problem or "an illuminance of 0 gives no light")
    horizontal, zenith, ground = _amounts(sky)
    lines += [
        ("Horizontal, sky", format_amount(horizontal, "lx")),
        ("Zenith luminance", format_amount(zenith, "cd/m²")),
        ("Ground luminance", format_amount(ground, "cd/m²")),
    ]
    return Description(tuple(lines), problem)


def _amounts(sky) -> tuple[float, float, float]:
    """Horizontal illuminance [lx], and luminances of zenith and ground [cd/m2]."""
    if not isinstance(sky, ImageWorld):
        return sky.illuminance, zenith_luminance(sky), ground_luminance(sky)
    factor, pixels = sky.luminance_per_unit, sky.image.pixels
    zenith, ground = (float(row.mean(axis=0) @ REC709_LUMINANCE) for row in pixels[[-1, 0]])
    horizontal = find_illuminance(sky.image, np.eye(3), UPWARDS)
    return factor * horizontal, factor * zenith, factor * ground


def describe_place(world) -> str:
    """Say what is odd about a world's place, empty if nothing is."""
    _, problems = known_cities()
    if problems:
        return f"{problems[0].path.name} {problems[0].message}: left out of the cities"
    settings = world.lumenray.place
    if settings.city and not is_at_city(settings):
        return (
            f"these are not the coordinates and the zone of '{settings.city}' in the list of cities"
        )
    return ""


def describe_moment(world, scene) -> Description:
    """Say what the clock shows at the scene's frame, where the sun stands then, and what is special about the day."""
    try:
        moment = find_moment(world, frame_of(scene))
        day = find_day_of(moment)
    except LumenrayError as error:
        return Description(problem=str(error))
    offset = moment.clock.strftime("%z")
    lines = [
        ("Date", f"{moment.clock.year:04d}-{moment.clock:%m-%d}"),
        ("Clock", f"{moment.clock:%H:%M}"),
        ("Zone", f"UTC{offset[:3]}:{offset[3:5]}"),
        ("Sun's elevation", f"{moment.elevation:.2f}°"),
        ("Sun's azimuth", f"{moment.azimuth:.2f}°"),
    ]
    named = (("Sunrise", day.rise), ("Solar noon", day.noon), ("Sunset", day.set))
    lines += [
        (name, f"{to_local(seconds, moment.place.zone):%H:%M}")
        for name, seconds in named
        if seconds is not None
    ]
    notes = [moment.note] if moment.note else []
    if day.is_polar_day:
        notes.append("polar day: the sun does not set on this day")
    elif day.is_polar_night:
        notes.append("polar night: the sun does not rise on this day")
    elif moment.elevation <= 0.0:
        notes.append("the sun is below the horizon")
    return Description(tuple(lines), "; ".join(notes))


def describe_sun(world, scene) -> Description:
    """Say what the Sun light that follows a world gives at the scene's frame, or why none follows."""
    lamp = lamp_of(scene, world)
    if lamp is None:
        is_lost = world.lumenray.sun.lamp is not None
        return Description(problem="the Sun light is not in this scene" if is_lost else "")
    try:
        moment = find_moment(world, frame_of(scene))
        sunlight = find_sunlight(world, moment)
    except LumenrayError as error:
        return Description(problem=f"{error}: the sun gives no light")
    horizontal = sunlight.illuminance * np.sin(np.radians(max(moment.elevation, 0.0)))
    lines = (
        ("Facing the sun", format_amount(sunlight.illuminance, "lx")),
        ("Horizontal, sun", format_amount(float(horizontal), "lx")),
    )
    return Description(lines, _fault_of(lamp, moment))


def _fault_of(lamp, moment: Moment) -> str:
    """What keeps a Sun light from being the sun of a moment, empty if nothing does."""
    if lamp.parent is not None:
        return f"'{lamp.name}' has a parent, which may turn it away from the sun"
    if not np.allclose(lamp.rotation_euler, rotation_of(moment), rtol=0.0, atol=TURNED):
        return f"'{lamp.name}' is turned by something else, and does not stand where the sun stands"
    return ""
