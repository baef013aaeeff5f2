"""How much light the sun of a world gives at a moment."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...engine.errors import SceneError
from ...engine.photometry.light_colour import light_colour
from ...engine.sky.air import standard_air
from ...engine.sky.sunlight import (
    LUMINOUS_SOLAR_CONSTANT,
    direct_illuminance,
    sunlight_spectrum,
)
from .moment import Moment
from .weather import has_band, weather_moment


@dataclass(frozen=True, eq=False)
class Sunlight:
    """Light of the sun.

    Parameters
    ----------
    illuminance : float    Of a plane that faces it; 0 while it is not above the horizon. [lx]
    colour : (3,) array    Linear Rec. 709, the largest component is 1.
    """

    illuminance: float
    colour: np.ndarray


def find_sunlight(world, moment: Moment) -> Sunlight:
    """Return the light of a world's sun.

    Raises
    ------
    LumenrayError    The weather file that states it cannot be used.
    """
    settings = world.lumenray.sun
    colour = _colour(max(round(moment.elevation, 2), 0.0), settings.turbidity)
    return Sunlight(_illuminance(world, settings, moment), colour)


def _illuminance(world, settings, moment: Moment) -> float:
    if moment.elevation <= 0.0:
        return 0.0
    if settings.amount == "GIVEN":
        return settings.illuminance
    if settings.amount == "HORIZONTAL":
        facing = settings.horizontal_illuminance / np.sin(np.radians(moment.elevation))
        if facing > LUMINOUS_SOLAR_CONSTANT:
            raise SceneError(
                f"a sun {moment.elevation:.1f} degrees high cannot give {settings.horizontal_illuminance:.0f} lx on a "
                "horizontal plane: it would be brighter than outside the atmosphere"
            )
        return float(facing)
    if settings.amount == "WEATHER":
        if world.lumenray.source != "CIE" or world.lumenray.sky.kind != "WEATHER":
            raise SceneError(
                "the sunlight is that of a weather file, but the world's sky is of none"
            )
        if has_band(world.lumenray.sky):
            # It is in the sky, or not wanted.
            return 0.0
        return weather_moment(world, moment).direct_normal
    pressure = standard_air(moment.place.elevation).pressure
    return direct_illuminance(moment.elevation, settings.turbidity, moment.distance, pressure)


@lru_cache(maxsize=256)
def _colour(elevation: float, turbidity: float) -> np.ndarray:
    return light_colour(sunlight_spectrum(elevation, turbidity))
