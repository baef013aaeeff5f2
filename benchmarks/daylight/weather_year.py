"""A year of weather that is made up: written as EPW and as WEA, so that both programs read what no station has measured.

Days are clear, broken or overcast by a Markov chain that keeps its state from day to day as weather does, and is brighter
in summer. Each hour has a cloud cover about that of its day. A cloudless sky follows the model of the European solar
radiation atlas from the height of the sun, the air mass and the turbidity; clouds weaken the global irradiance by the
formula of Kasten and Czeplak, and the sun shines through the part of the sky that they leave.

The dew point is always that at which the air holds 2 cm of water, the amount that Radiance takes everywhere: luminous
efficacies depend on it, and shall not differ for that reason.

References
----------
C. Rigollier, O. Bauer, L. Wald: On the clear sky model of the ESRA with respect to the Heliosat method, Solar Energy 68(1),
2000, 33-48, doi:10.1016/S0038-092X(99)00055-9
F. Kasten, G. Czeplak: Solar and terrestrial radiation dependent on the amount and type of cloud, Solar Energy 24(2), 1980,
177-189, doi:10.1016/0038-092X(80)90391-6
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...engine.sky.perez import SOLAR_CONSTANT, air_mass
from ...engine.sky.place import Place
from ...engine.sky.solar_position import find_sun
from ...engine.sky.weather import Weather, zone_offset
from ...engine.sky.weather_file import read_weather

PLACE = Place(38.7, -9.1, "UTC", 70.0, name="Made up, PRT")

YEAR = 2005

SEED = 28

PARTS = 6
"""Of an hour, in which the sun is looked at."""

STATES = ((0.06, 0.08), (0.50, 0.28), (0.95, 0.06))
"""Mean cloud cover of clear, broken and overcast days, and by how much hours differ from it. [-]"""

STAY = 0.55
"""How likely a day is as the day before; else it is drawn anew. [-]"""

SUMMER, WINTER = (0.60, 0.30, 0.10), (0.25, 0.35, 0.40)
"""Shares of the three kinds of day in June and in December. [-]"""

PERSISTENCE = 0.7
"""Correlation of an hour's cloud cover with that of the hour before. [-]"""

TURBIDITY = (2.6, 3.6)
"""Of Linke, in December and in June. [-]"""

DEW_POINT = 11.0
"""At which the air holds 2.00 cm of water. [degree Celsius]"""

HEADING = (
    "LOCATION,{city},-,{country},made up,0,{latitude},{longitude},{zone},{elevation}",
    "DESIGN CONDITIONS,0",
    "TYPICAL/EXTREME PERIODS,0",
    "GROUND TEMPERATURES,0",
    "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0",
    "COMMENTS 1,made up by a Markov chain of clear broken and overcast days; not measured",
    "COMMENTS 2,",
    "DATA PERIODS,1,1,Data,Saturday,1/1,12/31",
)
"""Of the EPW."""


@dataclass(frozen=True, eq=False)
class Year:
    """Hours of a year. Arrays of 8760 values.

    Parameters
    ----------
    place : Place
    month, day, hour : int array    ``hour``: the one that ends then, 1 to 24, in standard time.
    direct_normal, diffuse_horizontal, global_horizontal : array    Means of the hour, whole numbers. [W/m2]
    cover : array    Of the sky by clouds. [-]
    temperature : array    [degree Celsius]
    """

    place: Place
    month: np.ndarray
    day: np.ndarray
    hour: np.ndarray
    direct_normal: np.ndarray
    diffuse_horizontal: np.ndarray
    global_horizontal: np.ndarray
    cover: np.ndarray
    temperature: np.ndarray


def make_year(seed: int = SEED, place: Place = PLACE) -> Year:
    """Return a year of weather that might have been at a place; the same for the same seed.

    Parameters
    ----------
    seed : int
    place : Place    Its zone is a fixed offset.
    """
    dates = np.arange(np.datetime64(f"{YEAR}-01-01"), np.datetime64(f"{YEAR + 1}-01-01"))
    month = dates.astype("datetime64[M]").astype(int) % 12 + 1
    day = (dates - dates.astype("datetime64[M]")).astype(int) + 1
    # 1 at the northern solstice of June, 0 at that of December; turned round in the south.
    season = 0.5 - 0.5 * np.cos(2.0 * np.pi * (np.arange(365) + 10.0) / 365.0)
    season = season if place.latitude >= 0.0 else 1.0 - season
    rng = np.random.default_rng(seed)
    cover = _cover(season, rng)
    start = dates.astype("datetime64[h]").astype(np.int64)[:, None] + np.arange(24)
    middles = start[..., None] + (np.arange(PARTS) + 0.5) / PARTS - zone_offset(place)
    sun = find_sun(3600.0 * middles, place)
    turbidity = TURBIDITY[0] + (TURBIDITY[1] - TURBIDITY[0]) * season
    normal, diffuse = clear_sky(sun.elevation, sun.distance, turbidity[:, None, None])
    height = np.sin(np.radians(np.maximum(sun.elevation, 0.0)))
    horizontal = normal * height + diffuse
    # Clouds weaken the whole; what of it is the sun's comes through the gaps.
    whole = (horizontal * (1.0 - 0.75 * cover[..., None] ** 3.4)).mean(axis=-1)
    straight = normal.mean(axis=-1) * (1.0 - cover)
    sky = whole - ((normal * height).mean(axis=-1) * (1.0 - cover))
    # Warmest in the afternoon.
    warmth = (
        20.0 + 10.0 * (season[:, None] - 0.5) - 3.0 * np.cos((np.arange(24) - 3.0) * np.pi / 12)
    )
    return Year(
        place,
        np.repeat(month, 24),
        np.repeat(day, 24),
        np.tile(np.arange(1, 25), 365),
        *(np.rint(x).ravel() for x in (straight, sky, whole)),
        cover.ravel(),
        warmth.ravel(),
    )


def _cover(season: np.ndarray, rng) -> np.ndarray:
    """Cloud cover by day and hour. (365, 24) [-]"""
    kind, cover, drift = 0, np.zeros((len(season), 24)), 0.0
    fresh = np.sqrt(1.0 - PERSISTENCE**2)
    for k, share in enumerate(season):
        if k == 0 or rng.random() > STAY:
            shares = share * np.array(SUMMER) + (1.0 - share) * np.array(WINTER)
            kind = int(rng.choice(3, p=shares))
        mean, spread = STATES[kind]
        for hour in range(24):
            drift = PERSISTENCE * drift + fresh * rng.standard_normal()
            cover[k, hour] = mean + spread * drift
    return np.clip(cover, 0.0, 1.0)


def clear_sky(elevation, distance, turbidity) -> tuple[np.ndarray, np.ndarray]:
    """Irradiances under a cloudless sky.

    Parameters
    ----------
    elevation : array    Of the sun. [degree]
    distance : array    Of the sun. [astronomical unit]
    turbidity : array    Of Linke, at an air mass of 2. [-]

    Returns
    -------
    (array, array)    By the sun of a plane that faces it, and of a horizontal plane by the sky; 0 while it is down. [W/m2]
    """
    is_up = elevation > 0.0
    outside = np.where(is_up, SOLAR_CONSTANT / distance**2, 0.0)
    mass, sine = air_mass(elevation), np.sin(np.radians(np.maximum(elevation, 0.0)))
    thin = 1.0 / np.polynomial.polynomial.polyval(
        np.minimum(mass, 20.0), (6.6296, 1.7513, -0.1202, 0.0065, -0.00013)
    )
    depth = np.where(mass <= 20.0, thin, 1.0 / (10.4 + 0.718 * mass))
    normal = outside * np.exp(-0.8662 * turbidity * mass * depth)
    polyval = np.polynomial.polynomial.polyval
    up = polyval(turbidity, (-1.5843e-2, 3.0543e-2, 3.797e-4))
    a0 = polyval(turbidity, (2.6463e-1, -6.1581e-2, 3.1408e-3))
    a0 = np.where(a0 * up < 2e-3, 2e-3 / up, a0)
    a1 = polyval(turbidity, (2.0402, 1.8945e-2, -1.1161e-2))
    a2 = polyval(turbidity, (-1.3025, 3.9231e-2, 8.5079e-3))
    return normal, outside * up * np.maximum(a0 + a1 * sine + a2 * sine**2, 0.0)


def write_epw(year: Year, path: Path) -> Weather:
    """Write a year as EPW, and return it as it is read."""
    place = year.place
    city, _, country = place.name.partition(", ")
    head = {
        "city": city,
        "country": country or "-",
        "latitude": place.latitude,
        "longitude": place.longitude,
        "zone": zone_offset(place),
        "elevation": place.elevation,
    }
    lines = [line.format(**head) for line in HEADING]
    for k in range(len(year.hour)):
        cover = round(10.0 * year.cover[k])
        lines.append(
            f"{YEAR},{year.month[k]},{year.day[k]},{year.hour[k]},0,?9?9E0,{year.temperature[k]:.1f},{DEW_POINT:.1f},999,"
            f"100500,9999,9999,9999,{year.global_horizontal[k]:.0f},{year.direct_normal[k]:.0f},"
            f"{year.diffuse_horizontal[k]:.0f},999999,999999,999999,9999,999,999,{cover},{cover},9999,99999,9,999999999,"
            "999,.999,999,99,999,999,99"
        )
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return read_weather(path)


def write_wea(weather: Weather, path: Path) -> None:
    """Write the irradiances of hours as WEA, which Radiance reads. Missing ones are written as 0."""
    place = weather.place
    meridian = -15.0 * zone_offset(place)
    lines = [
        f"place {place.name.replace(' ', '_') or 'unnamed'}",
        f"latitude {place.latitude:g}",
        f"longitude {-place.longitude:g}",
        f"time_zone {meridian:g}",
        f"site_elevation {place.elevation:g}",
        "weather_data_file_units 1",
    ]
    columns = [
        np.nan_to_num(weather.values[name]) for name in ("direct_normal", "diffuse_horizontal")
    ]
    lines += [
        f"{month} {day} {hour:.3f} {direct:g} {diffuse:g}"
        for month, day, hour, direct, diffuse in zip(
            weather.month, weather.day, weather.hour, *columns, strict=True
        )
    ]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
