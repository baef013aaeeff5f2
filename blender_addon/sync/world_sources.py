"""The bright sources of a world's picture as lights of their own, and its sun mended."""

import calendar
import math
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from ...engine.environment.cells import direction_at
from ...engine.environment.extraction import clip_sources
from ...engine.environment.repair import find_sun_of, find_tolerance, rebuild_sun, sun_factor
from ...engine.environment.sources import Coefficients, Search, Source, find_sources
from ...engine.errors import SceneError
from ...engine.scene.texture import ImageTexture
from ...engine.sky.picture import find_illuminance
from ...engine.sky.place import from_local
from ...engine.sky.solar_position import RADIUS, find_sun
from ...engine.sky.sunlight import LUMINOUS_SOLAR_CONSTANT
from ..daylight.moment import read_place
from ..sun_direction import UPWARDS
from .world_suns import Disk

SUN_ANGLE = math.radians(2.0 * RADIUS)
"""Diameter of the sun. [rad]"""


UNSURE = 0.02
"""Part of a sun's light by which half a pixel of its height changes it, above which that is told. [-]"""

TOO_BRIGHT = 1.05
"""Part of what the sun gives outside the atmosphere above which a sun is told; it is nearer in January. [-]"""


@dataclass(frozen=True, eq=False)
class Taken:
    """A picture without its bright sources.

    Parameters
    ----------
    image : ImageTexture
    disks : tuple of Disk    For a value of 1 in the picture; the sun first.
    sun : Source or None    As it is in the picture.
    """

    image: ImageTexture
    disks: tuple[Disk, ...] = ()
    sun: Source | None = None


def read_coefficients(settings) -> Coefficients:
    """Return what makes a bright source by a world's settings."""
    source = round(settings.source_factor, 4)
    edge = min(round(settings.edge_factor, 4), source)
    return Coefficients(source, round(settings.radius, 6), edge, not settings.use_lower)


def choose_sun(settings, search: Search, up) -> Source | None:
    """Return the source that is the sun by a world's settings. ``up``: upwards in the picture's directions."""
    if settings.sun == "AUTO":
        return find_sun_of(search, up)
    is_any = settings.sun == "BRIGHTEST" and search.sources
    return search.sources[0] if is_any and search.sources[0].on(up) > 0.0 else None


def take_sources(world, image: ImageTexture, rotation: np.ndarray, report) -> Taken:
    """Take the bright sources out of a world's picture.

    Parameters
    ----------
    world : bpy.types.World
    image : ImageTexture    Equirectangular.
    rotation : (3, 3) array    As of `ImageWorld`.
    report : ConversionReport
    """
    settings = world.lumenray.environment
    coefficients = read_coefficients(settings)
    try:
        search = find_sources(image, coefficients)
    except SceneError as error:
        report.fault(world.name, error, "its picture lights as it is")
        return Taken(image)
    if not search.sources:
        report.info(world.name, "its picture holds no bright source", "it lights as it is")
        return Taken(image)
    clipped, up = clip_sources(image, coefficients), rotation @ UPWARDS
    sun = choose_sun(settings, search, up)
    others = [source for source in search.sources if source is not sun]
    disks = [_disk(source, rotation) for source in others]
    if sun is None:
        if settings.repair != "NONE":
            report.warn(
                world.name, "its picture shows no sun to mend", "its lights give what it says"
            )
        return Taken(clipped, tuple(disks))
    try:
        towards, mended = _mend(world, sun, others, clipped, rotation, report)
    except SceneError as error:
        report.fault(world.name, error, "the sun gives what the picture says")
        towards, mended = sun.towards, sun.irradiance
    disk = Disk(mended, rotation.T @ towards, SUN_ANGLE, 0.0)
    return Taken(clipped, (disk, *disks), sun)


def tell_brightness(world, suns, report) -> None:
    """Say where the sun of a world's picture gives more than the true one can. ``suns``: its lights."""
    most = max((sun.output.value for sun in suns), default=0.0)
    if world.lumenray.environment.use_sources and most > TOO_BRIGHT * LUMINOUS_SOLAR_CONSTANT:
        report.warn(
            world.name,
            f"a bright source of its picture gives {most:.3g} lx to a plane that faces it, more than the sun outside the "
            "atmosphere",
            "it is taken so; check the unit of the background, and what mends the sun",
        )


def _disk(source: Source, rotation) -> Disk:
    return Disk(
        source.irradiance, rotation.T @ source.towards, source.angle, 0.0, 0.0, is_sun=False
    )


def _mend(world, sun: Source, others, clipped: ImageTexture, rotation, report):
    """Return the picture's direction to the sun, and its components on a plane facing it, as the settings say. (3,) each"""
    settings, up = world.lumenray.environment, rotation @ UPWARDS
    if settings.repair == "RATIO":
        rest = find_illuminance(clipped, rotation, UPWARDS)
        rest += sum(source.on(up) for source in others)
        # Its light is no longer that of its glare.
        factor = sun_factor(sun, rest, settings.sun_ratio, up) * (sun.towards @ up)
        return sun.core, sun.irradiance * (factor / (sun.core @ up))
    if settings.repair == "MODEL":
        u, v = settings.sky_point
        if u == v == 0.0:
            raise SceneError("no place of the sky is picked by which the sun is to be mended")
        made = rebuild_sun(
            clipped,
            rotation.T @ sun.core,
            rotation.T @ direction_at(u, v),
            world.lumenray.sun.turbidity,
            _distance(world),
            world.lumenray.place.elevation,
            rotation=rotation,
            tolerance=find_tolerance(clipped.pixels.shape[0]),
        )
        if made.spread > UNSURE:
            report.info(
                world.name,
                f"half a pixel of the height of its picture's sun changes its light by {100.0 * made.spread:.0f} %",
                "a larger picture says more of so low a sun",
            )
        return sun.core, sun.irradiance * (made.illuminance / sun.illuminance)
    return sun.towards, sun.irradiance


def _distance(world) -> float:
    """Distance of the sun at noon of the world's date. [astronomical unit]"""
    place, time = read_place(world), world.lumenray.time
    day = min(time.day, calendar.monthrange(time.year, time.month)[1])
    noon = from_local(datetime(time.year, time.month, day, 12), place.zone)
    return float(find_sun(noon.seconds, place).distance)
