"""The sky in the place of a world's nodes, whatever states it, as the surroundings of the engine's scene."""

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from ...engine.errors import FileFormatError, LumenrayError, SceneError
from ...engine.photometry.colour import REC709_LUMINANCE
from ...engine.photometry.light_colour import light_colour
from ...engine.scene.light import CieSky, CloudySky, ImageWorld, PerezSky
from ...engine.scene.spectrum import Daylight
from ...engine.sky.cie import sun_direction
from ...engine.sky.measured import (
    SkyGrid,
    make_grid_world,
    make_patch_world,
    parse_measured_sky,
    read_measured_sky,
)
from ...engine.sky.picture import find_illuminance
from ...engine.sky.skies import check_sky, with_zenith_luminance
from ...engine.sky.weather_mean import WeatherMean, make_mean_world
from ..daylight.following import lamp_of
from ..daylight.moment import Moment, find_moment
from ..daylight.sunlight import find_sunlight
from ..daylight.weather import has_band, path_of, weather_mean, weather_moment, weather_of
from ..foundation.report import ConversionReport
from ..sky import depends_on_sun, needs_moment, states_level, takes_lamp
from ..sun_direction import UPWARDS, onto_horizon
from .sky_spectra import find_spectrum, own_illuminance, refuse_picture

FAR = 1.0
"""Difference of latitude or longitude from which on a weather file is one of another place. [degree]"""

ASIDE = np.cos(np.radians(0.1))
"""Cosine of the angle from which on a Sun light does not stand where the sun stands; a sun has a radius of 0.27 degrees."""

KEPT = 8
"""Pictures of skies that are kept."""

WHITE = 0.02
"""Difference of the channels up to which a sky's colour is white."""

LEFT_OUT = "the sky is left out"


@dataclass(frozen=True)
class SkyTime:
    """When and where a sky is converted: the scene, for the Sun light that follows the world, and its frame."""

    scene: object
    frame: float


def convert_sky(
    world,
    world_id: str,
    report: ConversionReport,
    sun_lamp: np.ndarray | None,
    when: SkyTime | None = None,
):
    """Convert the sky that a world has.

    Parameters
    ----------
    world : bpy.types.World
    world_id : str    Stable key of the result.
    report : ConversionReport
    sun_lamp : (3,) array or None    Unit vector to where the scene's Sun light shines from; see `takes_lamp`.
    when : SkyTime or None    None: at the start of its time, without a Sun light that follows it.

    Returns
    -------
    CieSky, CloudySky, PerezSky, ImageWorld or None    None where it gives no light, or cannot be known.
    """
    try:
        made = _convert(world, report, sun_lamp, when)
    except LumenrayError as error:
        report.fault(world.name, error, LEFT_OUT)
        return None
    return None if made is None else replace(made, id=world_id)


def tell_sun(world, when: SkyTime, stands: np.ndarray, report: ConversionReport) -> None:
    """Say what is wrong with the Sun light that follows a world.

    Parameters
    ----------
    world : bpy.types.World
    when : SkyTime
    stands : (3,) array    Unit vector to where it shines from.
    report : ConversionReport
    """
    try:
        moment = find_moment(world, when.frame)
        find_sunlight(world, moment)
    except LumenrayError as error:
        report.fault(world.name, error, "its sun gives no light")
        return
    if stands @ moment.towards_sun < ASIDE:
        report.warn(
            world.name,
            "the Sun light of its place and time is turned by something else, such as a parent or an animation",
            "it shines from where it is turned to, not from where the sun stands",
        )


def _convert(world, report, sun_lamp, when):
    settings = world.lumenray.sky
    moment = None
    if needs_moment(settings):
        moment = find_moment(world, _frame(world, when))
        if moment.note:
            report.info(world.name, moment.note, "check the clock where it matters")
    if settings.kind == "WEATHER":
        return _of_weather(world, moment, report, when)
    if settings.kind == "MEASURED":
        return _of_picture(_measured(settings), world, moment, when)
    sun = _sun_of(world, moment, sun_lamp, report)
    common = {
        "towards_sun": sun,
        "illuminance": 1.0,
        "ground_reflectance": settings.ground_reflectance,
        "spectrum": find_spectrum(settings, sun),
    }
    if settings.kind == "CLOUDINESS":
        sky = CloudySky(settings.cloudiness, **common)
    else:
        sky = CieSky(int(settings.type), **common)
    return _levelled(sky, world, moment, when)


def _frame(world, when) -> float:
    return world.lumenray.time.first_frame if when is None else when.frame


def _sun_of(world, moment, sun_lamp, report) -> np.ndarray:
    """Where the sky's sun stands."""
    settings = world.lumenray.sky
    if not depends_on_sun(settings):
        # The same for every sun, so that moving one does not send the sky anew.
        return UPWARDS
    if settings.use_place:
        _tell_night(world, moment, report)
        return onto_horizon(moment.towards_sun)
    if takes_lamp(settings) and sun_lamp is not None:
        if sun_lamp[2] < 0.0:
            report.warn(
                world.name,
                "the Sun light shines from below the horizon, where no sky is defined",
                "the sky is that of a sun on the horizon",
            )
        return onto_horizon(sun_lamp)
    return sun_direction(settings.elevation, settings.azimuth)


def _tell_night(world, moment: Moment, report) -> None:
    if moment.elevation < 0.0:
        report.warn(
            world.name,
            f"the sun is {-moment.elevation:.1f} degrees below the horizon at its place and time, where no sky is defined",
            "the sky is that of a sun on the horizon, as bright as it is stated",
        )


def _levelled(sky, world, moment, when):
    """Give a sky by formula the level that is stated; None where it gives no light."""
    settings = world.lumenray.sky
    if settings.level == "ZENITH":
        if settings.zenith_luminance <= 0.0:
            return None
        sky = with_zenith_luminance(sky, settings.zenith_luminance)
    elif settings.level == "MODEL":
        sky = replace(sky, illuminance=own_illuminance(settings, sky.towards_sun))
    else:
        sky = replace(sky, illuminance=_horizontal(world, moment, when))
    if sky.illuminance <= 0.0:
        return None
    check_sky(sky)
    return sky


def _horizontal(world, moment, when) -> float:
    """Horizontal illuminance by the sky alone that is stated. [lx]"""
    settings = world.lumenray.sky
    if settings.level == "MODEL":
        raise SceneError("a sky that is a picture has no level of a clear sky's own; state it")
    if settings.level != "TOTAL":
        return settings.illuminance
    by_sun = 0.0
    if when is not None and lamp_of(when.scene, _original(world)) is not None:
        height = np.sin(np.radians(max(moment.elevation, 0.0)))
        by_sun = find_sunlight(world, moment).illuminance * height
    if by_sun > settings.total_illuminance:
        raise SceneError(
            f"the sun alone gives {by_sun:.0f} lx on a horizontal plane, more than the {settings.total_illuminance:.0f} lx "
            "that sky and sun are to give together"
        )
    return settings.total_illuminance - by_sun


def _original(world):
    return getattr(world, "original", None) or world


# ---- weather ----


def _of_weather(world, moment: Moment, report, when):
    settings = world.lumenray.sky
    weather = weather_of(world)
    _tell_weather(world, weather, moment, report)
    if has_band(settings):
        return _of_hours(world, moment, report, when)
    stated = weather_moment(world, moment)
    if stated.note:
        report.info(world.name, stated.note, "it is taken so")
    if stated.mean is not None:
        report.info(
            world.name,
            f"the sky is the {stated.label}",
            "the sun stands where it stands at the moment",
        )
        picture = _of_grid(stated.mean, settings.ground_reflectance)
        return _of_picture(picture, world, moment, when)
    if stated.diffuse_horizontal <= 0.0:
        raise SceneError(f"the weather file's sky gives no light at {stated.label}")
    report.info(
        world.name,
        f"the weather is that of the record of {stated.label}, of whatever year the file has it",
        "the sun stands where it stands at the moment, not in the middle of the record's hour",
    )
    _tell_night(world, moment, report)
    sky = PerezSky(
        stated.clearness,
        stated.brightness,
        onto_horizon(moment.towards_sun),
        stated.diffuse_horizontal,
        settings.ground_reflectance,
        find_spectrum(settings, onto_horizon(moment.towards_sun), stated.clearness),
    )
    if states_level(settings):
        return _levelled(sky, world, moment, when)
    check_sky(sky)
    return sky


def _of_hours(world, moment: Moment, report, when):
    """The mean of chosen hours of a weather file, with the sun in it or without."""
    settings = world.lumenray.sky
    mean = weather_mean(world, moment)
    if mean.note:
        report.info(world.name, mean.note, "it is taken so")
    held = "the sun is a band of light in it" if settings.use_mean_sun else "the sun is left out"
    report.info(world.name, f"the sky is the mean of {mean.hours:g} hours: {mean.label}", held)
    if states_level(settings) and settings.use_mean_sun:
        report.info(
            world.name,
            "the level that is stated is that of the mean sky with the sun in it",
            "switch the sun of the sky off for that of the sky alone",
        )
    lamp = None if when is None else lamp_of(when.scene, _original(world))
    if lamp is not None and find_sunlight(world, moment).illuminance > 0.0:
        report.warn(
            world.name,
            "the Sun light of its place and time shines besides the mean of hours, which has no one place of the sun",
            "both are lit; let its illuminance be that of the weather file, which is in the sky then",
        )
    picture = _of_mean(mean, settings.ground_reflectance, settings.use_mean_sun)
    return _of_picture(picture, world, moment, when)


def _tell_weather(world, weather, moment: Moment, report) -> None:
    for remark in weather.remarks:
        report.info(world.name, f"weather file: {remark}", "it is read so")
    there, here = weather.place, moment.place
    turn = abs(there.longitude - here.longitude)
    if max(abs(there.latitude - here.latitude), min(turn, 360.0 - turn)) > FAR:
        report.warn(
            world.name,
            f"the weather file is of {there.name or 'a place'} at {there.latitude:.2f}, {there.longitude:.2f} degrees, "
            f"the world's place lies at {here.latitude:.2f}, {here.longitude:.2f}",
            "the sun is that of the world's place, clouds and brightness are the file's",
        )


# ---- skies that are pictures ----


def _measured(settings) -> ImageWorld:
    """Picture of a measured sky, made once as long as its table stays the same."""
    reflectance = settings.ground_reflectance
    if settings.measured_text is not None:
        text = settings.measured_text
        return _of_text(text.name, text.as_string(), reflectance)
    path = path_of(settings, "measured_file", "table of a measured sky")
    try:
        stat = path.stat()
    except OSError as error:
        raise FileFormatError(path, f"cannot be read: {error.strerror}") from None
    return _of_file(path, stat.st_mtime_ns, stat.st_size, reflectance)


@lru_cache(maxsize=KEPT)
def _of_text(name: str, content: str, reflectance: float) -> ImageWorld:
    return _of_table(parse_measured_sky(name, content.encode()), reflectance)


@lru_cache(maxsize=KEPT)
def _of_file(path: Path, changed: int, size: int, reflectance: float) -> ImageWorld:
    return _of_table(read_measured_sky(path), reflectance)


def _of_table(table, reflectance: float) -> ImageWorld:
    make = make_patch_world if isinstance(table, np.ndarray) else make_grid_world
    return make(table, reflectance)


@lru_cache(maxsize=KEPT)
def _of_grid(grid: SkyGrid, reflectance: float) -> ImageWorld:
    return make_grid_world(grid, reflectance)


@lru_cache(maxsize=KEPT)
def _of_mean(mean: WeatherMean, reflectance: float, has_sun: bool) -> ImageWorld:
    return make_mean_world(mean, reflectance, has_sun=has_sun)


def _of_picture(made: ImageWorld, world, moment, when):
    """Turn, colour and level a sky that is a picture by compass directions."""
    settings = world.lumenray.sky
    refuse_picture(settings)
    illuminance = find_illuminance(made.image, made.rotation, UPWARDS)
    if not illuminance > 0.0:
        raise SceneError("its table gives no light")
    factor = 1.0
    if states_level(settings):
        if settings.level == "ZENITH":
            zenith = float(made.image.pixels[-1].mean(axis=0) @ REC709_LUMINANCE)
            if not zenith > 0.0:
                raise SceneError(
                    "the sky is dark at its zenith, so that no luminance there tells its light"
                )
            factor = settings.zenith_luminance / zenith
        else:
            factor = _horizontal(world, moment, when) / illuminance
    if factor <= 0.0:
        return None
    made = _coloured(made, settings.colour_temperature)
    return replace(made, luminance_per_unit=factor, rotation=_turned(world.lumenray.place.north))


@lru_cache(maxsize=KEPT)
def _coloured(made: ImageWorld, temperature: float) -> ImageWorld:
    """Give a picture in grey the colour of daylight, and let its luminances be."""
    colour = light_colour(Daylight(temperature))
    if colour.min() > 1.0 - WHITE:
        return made
    colour = (colour / (REC709_LUMINANCE @ colour)).astype(np.float32)
    pixels = made.image.pixels * colour
    pixels.flags.writeable = False
    return replace(made, image=replace(made.image, pixels=pixels))


def _turned(north: float) -> np.ndarray:
    """Matrix from the scene's directions to those of the compass, +y north. (3, 3)"""
    cosine, sine = np.cos(north), np.sin(north)
    return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
