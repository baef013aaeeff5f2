"""Pictures of a daylight year: the hours as a heat map, and plans of the figures of sensors."""

from dataclasses import replace

import numpy as np
from PIL import Image

from .heat_map import draw_heat_map
from .light import Light
from .plan import draw_plan
from .study import Figures


def draw_all(light: Light, figures: Figures, places, zone: str) -> dict[str, Image.Image]:
    """Return pictures by the names of their files.

    Parameters
    ----------
    light : Light
    figures : Figures
    places : (n, 3) array    Of the sensors. [m]
    zone : str    Of the clocks.
    """
    year = light.year
    hourly = np.zeros(year.count)
    hourly[year.lit] = figures.hourly.value
    place = replace(year.weather.place, zone=zone)
    made = {
        "hours.png": draw_heat_map(
            hourly,
            year.middles,
            place,
            "Mean illuminance over the sensors",
            interval=min(year.weather.interval, 1.0),
        )
    }
    for name, key, title, unit, factor in (
        ("autonomy.png", "daylight_autonomy", "Daylight autonomy", "%", 100.0),
        ("factor.png", "daylight_factor", "Daylight factor", "%", 100.0),
        ("sunlight.png", "sunlit_h", "Hours with more than 1000 lx by the sun alone", "h", 1.0),
    ):
        values = factor * figures.sensors[key].value
        made[name] = draw_plan(places, values, title, unit=unit)
    return made
