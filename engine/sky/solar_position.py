"""Where the sun stands: the solar position algorithm of NREL, for many times at once.

Years 1900 to 2100, to 0.0003 degrees where the time by the Earth's rotation is known. The time of dynamics differs from it
by the polynomials of Espenak and Meeus. They agree with what was observed until 2020 within 2.5 s; by the end of the century
they may be off by a minute, in which the sun moves 0.0007 degrees among the stars.

References
----------
I. Reda, A. Andreas: Solar position algorithm for solar radiation applications, NREL/TP-560-34302, revised 2008,
doi:10.2172/15003974
F. Espenak, J. Meeus: Five millennium canon of solar eclipses, NASA/TP-2006-214141, polynomial expressions for Delta T
"""

from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np

from ..errors import SceneError
from .earth_orbit import DISTANCE, LATITUDE, LONGITUDE, NUTATION
from .limits import FIRST_YEAR, LAST_YEAR
from .place import Place, check_place, from_local

RADIUS = 0.26667
"""Of the sun as seen from the Earth. [degree]"""

REFRACTION_AT_HORIZON = 0.5667
"""By which the air lifts the sun at the horizon, as almanacs have it. [degree]"""

HORIZON = -(RADIUS + REFRACTION_AT_HORIZON)
"""Elevation without refraction at which the upper edge of the sun touches the horizon. [degree]"""

DAY = 86400.0
"""[s]"""

_EPOCH_DAY = 2440587.5
"""Julian day of 1970-01-01 0:00."""

_FLATTENING = 0.99664719
"""Polar over equatorial radius of the Earth. [-]"""

_EARTH_RADIUS = 6378140.0
"""Equatorial. [m]"""

_AT_ONCE = 1024
"""Times whose terms are summed together, so that years need little memory."""


@dataclass(frozen=True)
class Air:
    """Air that bends the sun's light.

    Parameters
    ----------
    pressure : float    At the place, not at the sea. [Pa]
    temperature : float    [degree Celsius]
    """

    pressure: float = 101_325.0
    temperature: float = 15.0


@dataclass(frozen=True)
class SunPositions:
    """Where the sun's middle stands, seen from a place. Arrays of the times' shape.

    Parameters
    ----------
    elevation : array    Above the horizon, lifted by refraction if that was asked for. [degree]
    azimuth : array    From north over east, 0 to 360. [degree]
    distance : array    Between Earth and sun. [astronomical unit]
    declination : array    Seen from the middle of the Earth. [degree]
    equation_of_time : array    True less mean solar time. [min]
    solar_time : array    True solar time, 0 to 24; the sun passes the meridian at 12. [h]
    """

    elevation: np.ndarray
    azimuth: np.ndarray
    distance: np.ndarray
    declination: np.ndarray
    equation_of_time: np.ndarray
    solar_time: np.ndarray

    def directions(self, north: float = 0.0) -> np.ndarray:
        """Return unit vectors to the sun in the scene's axes, +z up.

        Parameters
        ----------
        north : float    Compass direction of the scene's +y axis, as in `Place`. [degree]

        Returns
        -------
        (..., 3) array
        """
        height, turn = np.radians(self.elevation), np.radians(self.azimuth - north)
        plan = np.cos(height)
        return np.stack([plan * np.sin(turn), plan * np.cos(turn), np.sin(height)], axis=-1)


def find_sun(times, place: Place, air: Air | None = None) -> SunPositions:
    """Return where the sun stands.

    Parameters
    ----------
    times : array    Universal time since 1970, as `place.from_local` gives it. [s]
    place : Place
    air : Air or None    Whose refraction lifts the sun where it is not below the horizon; None: where it is without air.

    Returns
    -------
    SunPositions

    Raises
    ------
    SceneError    The place is none, a time is beyond 1900 to 2100, or the air is none.
    """
    check_place(place)
    times = np.asarray(times, dtype=np.float64)
    _check_times(times)
    flat = times.ravel()
    parts = [_find(flat[i : i + _AT_ONCE], place) for i in range(0, max(len(flat), 1), _AT_ONCE)]
    columns = [np.concatenate(column).reshape(times.shape) for column in zip(*parts, strict=True)]
    if air is not None:
        columns[0] = columns[0] + refraction(columns[0], air)
    return SunPositions(*columns)


def _check_times(times: np.ndarray) -> None:
    # A day more on both sides, as local years begin earlier and end later.
    low, high = (
        (datetime(year, 1, 1) - datetime(1970, 1, 1)).total_seconds() + more * DAY
        for year, more in ((FIRST_YEAR, -1), (LAST_YEAR + 1, 1))
    )
    if not (np.isfinite(times).all() and (times >= low).all() and (times <= high).all()):
        raise SceneError(f"a time is beyond the years {FIRST_YEAR} to {LAST_YEAR}")


def delta_t(years) -> np.ndarray:
    """Return the time of dynamics less that by the Earth's rotation. [decimal year -> s], 1900 to 2150"""
    y = np.asarray(years, dtype=np.float64)
    pieces = (
        (1920.0, 1900.0, (-2.79, 1.494119, -0.0598939, 0.0061966, -0.000197)),
        (1941.0, 1920.0, (21.20, 0.84493, -0.076100, 0.0020936)),
        (1961.0, 1950.0, (29.07, 0.407, -1.0 / 233.0, 1.0 / 2547.0)),
        (1986.0, 1975.0, (45.45, 1.067, -1.0 / 260.0, -1.0 / 718.0)),
        (2005.0, 2000.0, (63.86, 0.3345, -0.060374, 0.0017275, 0.000651814, 0.00002373599)),
        (2050.0, 2000.0, (62.92, 0.32217, 0.005589)),
    )
    polyval = np.polynomial.polynomial.polyval
    value = -20.0 + 32.0 * ((y - 1820.0) / 100.0) ** 2 - 0.5628 * (2150.0 - y)
    for end, start, terms in reversed(pieces):
        value = np.where(y < end, polyval(y - start, terms), value)
    return value


def refraction(elevation, air: Air) -> np.ndarray:
    """Return by how much the air lifts the sun.

    Parameters
    ----------
    elevation : array    Without refraction. [degree]
    air : Air

    Returns
    -------
    array    [degree], 0 where the sun's upper edge is below the horizon all the same.

    Raises
    ------
    SceneError    The air is none.
    """
    if not (0.0 <= air.pressure <= 120_000.0 and -100.0 <= air.temperature <= 100.0):
        raise SceneError(
            f"the air has {air.pressure} Pa and {air.temperature} degrees Celsius, expected 0 to 120000 Pa and "
            "-100 to 100 degrees"
        )
    elevation = np.asarray(elevation, dtype=np.float64)
    is_up = elevation >= HORIZON
    height = np.where(is_up, elevation, 0.0)
    angle = np.radians(height + 10.3 / (height + 5.11))
    lift = 1.02 / (60.0 * np.tan(angle))
    # The formula falls below 0 by a hair at the zenith.
    lift = np.maximum(lift, 0.0) * (air.pressure / 101_000.0) * 283.0 / (273.0 + air.temperature)
    return np.where(is_up, lift, 0.0)


# ---- the algorithm; names as in the report ----


def _sum_series(series, millennium: np.ndarray) -> np.ndarray:
    value = np.zeros_like(millennium)
    for terms in reversed(series):
        amplitude, phase, frequency = np.array(terms).T
        value = value * millennium + amplitude @ np.cos(
            phase[:, None] + frequency[:, None] * millennium
        )
    return value * 1e-8


def _nutation(century: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """In longitude and in obliquity. [degree]"""
    polyval = np.polynomial.polynomial.polyval
    arguments = np.array(
        [
            polyval(century, terms)
            for terms in (
                (297.85036, 445267.111480, -0.0019142, 1.0 / 189474.0),
                (357.52772, 35999.050340, -0.0001603, -1.0 / 300000.0),
                (134.96298, 477198.867398, 0.0086972, 1.0 / 56250.0),
                (93.27191, 483202.017538, -0.0036825, 1.0 / 327270.0),
                (125.04452, -1934.136261, 0.0020708, 1.0 / 450000.0),
            )
        ]
    )
    table = np.array(NUTATION)
    angle = np.radians(table[:, :5] @ arguments)
    a, b, c, d = table[:, 5:].T[:, :, None]
    longitude = ((a + b * century) * np.sin(angle)).sum(axis=0)
    obliquity = ((c + d * century) * np.cos(angle)).sum(axis=0)
    return longitude / 36e6, obliquity / 36e6


def _find(times: np.ndarray, place: Place) -> tuple[np.ndarray, ...]:
    day = times / DAY + _EPOCH_DAY
    century = (day - 2451545.0) / 36525.0
    ephemeris = century + delta_t(2000.0 + 100.0 * century) / (DAY * 36525.0)
    millennium = ephemeris / 10.0
    distance = _sum_series(DISTANCE, millennium)
    beta = -_sum_series(LATITUDE, millennium)
    psi, obliquity = _nutation(ephemeris)
    mean_obliquity = np.polynomial.polynomial.polyval(
        millennium / 10.0,
        (84381.448, -4680.93, -1.55, 1999.25, -51.38, -249.67, -39.05, 7.12, 27.87, 5.79, 2.45),
    )
    epsilon = np.radians(mean_obliquity / 3600.0 + obliquity)
    aberration = -20.4898 / (3600.0 * distance)
    longitude = _sum_series(LONGITUDE, millennium) + np.pi + np.radians(psi + aberration)
    # Right ascension and declination, seen from the middle of the Earth.
    alpha = np.arctan2(
        np.sin(longitude) * np.cos(epsilon) - np.tan(beta) * np.sin(epsilon), np.cos(longitude)
    )
    delta = np.arcsin(
        np.sin(beta) * np.cos(epsilon) + np.cos(beta) * np.sin(epsilon) * np.sin(longitude)
    )
    # Days and their parts apart, as their product with the rate would lose digits.
    whole = np.floor(times / DAY)
    turned = 360.98564736629 * (times - whole * DAY) / DAY
    turned += 0.98564736629 * (whole + _EPOCH_DAY - 2451545.0) + 180.0
    sidereal = 280.46061837 + turned + 0.000387933 * century**2 - century**3 / 38710000.0
    sidereal += psi * np.cos(epsilon)
    hour = np.radians(sidereal + place.longitude) - alpha
    elevation, azimuth, topocentric = _seen_from(place, hour, delta, distance)
    mean = np.radians(
        np.polynomial.polynomial.polyval(
            millennium,
            (280.4664567, 360007.6982779, 0.03032028, 1 / 49931, -1 / 15300, -1 / 2000000),
        )
    )
    equation = np.degrees(mean - alpha + np.radians(psi) * np.cos(epsilon)) - 0.0057183
    equation = ((equation + 180.0) % 360.0 - 180.0) * 4.0
    solar_time = (np.degrees(topocentric) / 15.0 + 12.0) % 24.0
    return elevation, azimuth, distance, np.degrees(delta), equation, solar_time


def _seen_from(place: Place, hour, delta, distance) -> tuple[np.ndarray, ...]:
    """Elevation and azimuth [degree] and hour angle [rad] with the parallax of a place on the Earth's surface."""
    phi = np.radians(place.latitude)
    parallax = np.sin(np.radians(8.794 / (3600.0 * distance)))
    u = np.arctan(_FLATTENING * np.tan(phi))
    height = place.elevation / _EARTH_RADIUS
    x = np.cos(u) + height * np.cos(phi)
    y = _FLATTENING * np.sin(u) + height * np.sin(phi)
    shift = np.arctan2(-x * parallax * np.sin(hour), np.cos(delta) - x * parallax * np.cos(hour))
    declination = np.arctan2(
        (np.sin(delta) - y * parallax) * np.cos(shift),
        np.cos(delta) - x * parallax * np.cos(hour),
    )
    hour = hour - shift
    # East, north and up of the direction to the sun.
    east = -np.cos(declination) * np.sin(hour)
    north = np.sin(declination) * np.cos(phi) - np.cos(declination) * np.sin(phi) * np.cos(hour)
    up = np.sin(declination) * np.sin(phi) + np.cos(declination) * np.cos(phi) * np.cos(hour)
    elevation = np.degrees(np.arctan2(up, np.hypot(east, north)))
    return elevation, np.degrees(np.arctan2(east, north)) % 360.0, hour


# ---- the day ----


@dataclass(frozen=True)
class SunDay:
    """The sun on one day of a place's clocks.

    Parameters
    ----------
    rise, set : float or None    When its upper edge crosses the even horizon, lifted by the refraction of almanacs; None: it
        does not on this day. Universal time since 1970. [s]
    noon : float or None    When it passes the meridian. [s]
    is_polar_day : bool    It is up all day.
    is_polar_night : bool    It is down all day.
    """

    rise: float | None
    set: float | None
    noon: float | None
    is_polar_day: bool
    is_polar_night: bool


def find_day(year: int, month: int, day: int, place: Place) -> SunDay:
    """Return the sun's rise, noon and set on one day.

    Raises
    ------
    SceneError    The place or the date is none, or the year is beyond 1900 to 2100.
    """
    check_place(place)
    try:
        date = datetime(year, month, day)
    except ValueError:
        raise SceneError(f"there is no day {year}-{month}-{day}") from None
    start = from_local(date, place.zone).seconds
    if year == LAST_YEAR and (month, day) == (12, 31):
        end = start + DAY
    else:
        end = from_local(date + timedelta(days=1), place.zone).seconds
    times = np.linspace(start, end, 145)
    noon = _first(times, lambda t: np.sin((find_sun(t, place).solar_time - 12.0) * np.pi / 12.0))
    midnight = _first(
        times, lambda t: -np.sin((find_sun(t, place).solar_time - 12.0) * np.pi / 12.0)
    )
    # The shortest days and nights lie between two of the times, about noon and midnight.
    times = np.unique([*times, *(t for t in (noon, midnight) if t is not None)])
    above = find_sun(times, place).elevation - HORIZON
    rise = _first(times, lambda t: find_sun(t, place).elevation - HORIZON)
    down = _first(times, lambda t: HORIZON - find_sun(t, place).elevation)
    return SunDay(rise, down, noon, bool((above > 0.0).all()), bool((above <= 0.0).all()))


def _first(times: np.ndarray, value) -> float | None:
    """First time at which a function rises through 0, to a millisecond; None: it does not."""
    values = value(times)
    places = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    if not len(places):
        return None
    low, high = times[places[0]], times[places[0] + 1]
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if value(middle) < 0.0 else (low, middle)
    return float(high)
