"""Where the sun stands, at random places and times, against two independent algorithms.

One is the shorter theory of Meeus, which is exact to 0.01 degrees and leaves out the parallax of a place on the Earth
(0.0024 degrees at most). The other is Michalsky's, which the Astronomical Almanac states to be exact to 0.01 degrees from
1950 to 2050; Radiance's `gensky` has it where it is told a year, and it is asked for it.

References
----------
J. Meeus: Astronomical algorithms, 2nd edition, 1998, chapter 25
J. J. Michalsky: The Astronomical Almanac's algorithm for approximate solar position (1950-2050), Solar Energy 40(3), 1988,
227-235, doi:10.1016/0038-092X(88)90045-X
"""

import tempfile
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from ...engine.sky.place import Place
from ...engine.sky.solar_position import find_sun
from ..common.radiance import is_installed, run_program

COUNT = 1000
"""Places and times."""

SEED = 28

FIRST, LAST = datetime(1950, 1, 1, tzinfo=UTC), datetime(2050, 1, 1, tzinfo=UTC)

MEEUS, MICHALSKY = "Meeus", "Michalsky (gensky)"

HIGHEST = 86.9
"""Where the sun is higher `gensky` moves it down, to 87 degrees. [degree]"""


def measure_sun(count: int = COUNT, say=lambda text: None) -> dict:
    """Compare positions.

    Parameters
    ----------
    count : int    How many places and times.
    say : callable    Told what was found.

    Returns
    -------
    dict    ``count``, and by algorithm in ``others`` the ``max`` and ``rms`` of the angle between the two directions to
        the sun [degree], with the ``worst`` place and time, and the ``count`` that were compared. Michalsky's is missing
        where Radiance is not installed.
    """
    times, latitudes, longitudes = random_places(count)
    ours = np.array(
        [
            find_sun(time, Place(latitude, longitude)).directions()
            for time, latitude, longitude in zip(times, latitudes, longitudes, strict=True)
        ]
    )
    others = {MEEUS: meeus_direction(times, latitudes, longitudes)}
    if is_installed():
        others[MICHALSKY] = gensky_directions(times, latitudes, longitudes)
    made = {}
    for name, directions in others.items():
        chord = np.linalg.norm(ours - directions, axis=1)
        if name == MICHALSKY:
            chord[others[MEEUS][:, 2] > np.sin(np.radians(HIGHEST))] = np.nan
        angle = np.degrees(2.0 * np.arcsin(np.clip(0.5 * chord, 0.0, 1.0)))
        worst = int(np.nanargmax(angle))
        made[name] = {
            "max": float(np.nanmax(angle)),
            "rms": float(np.sqrt(np.nanmean(angle**2))),
            "count": int(np.isfinite(angle).sum()),
            "worst": f"{_moment(times[worst]):%Y-%m-%d %H:%M} UTC at {latitudes[worst]:.1f}, {longitudes[worst]:.1f}",
        }
        say(f"sun: {name}: at most {made[name]['max']:.4f} degrees off")
    return {"count": count, "others": made}


def random_places(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times [s since 1970], latitudes and longitudes [degree], evenly over the Earth's surface."""
    rng = np.random.default_rng(SEED)
    # To the minute, which every program can be told exactly.
    first, last = (round(end.timestamp() / 60.0) for end in (FIRST, LAST))
    times = 60.0 * rng.integers(first, last, count)
    latitudes = np.degrees(np.arcsin(rng.uniform(-1.0, 1.0, count)))
    return times, np.round(latitudes, 3), np.round(rng.uniform(-180.0, 180.0, count), 3)


def meeus_direction(seconds, latitude, longitude) -> np.ndarray:
    """Return east, north and up of the direction to the sun by the lower accuracy of chapter 25.

    Parameters
    ----------
    seconds : array    Universal time since 1970. [s]
    latitude, longitude : array    [degree]

    Returns
    -------
    (..., 3) array
    """
    day = np.asarray(seconds) / 86400.0 + 2440587.5 - 2451545.0
    # A minute between the time of dynamics and that by the Earth's rotation, as it is about 1995.
    t = (day + 60.0 / 86400.0) / 36525.0
    mean = 280.46646 + 36000.76983 * t + 0.0003032 * t**2
    anomaly = np.radians(357.52911 + 35999.05029 * t - 0.0001537 * t**2)
    centre = (
        (1.914602 - 0.004817 * t) * np.sin(anomaly)
        + (0.019993 - 0.000101 * t) * np.sin(2.0 * anomaly)
        + 0.000289 * np.sin(3.0 * anomaly)
    )
    node = np.radians(125.04 - 1934.136 * t)
    longitude_of_sun = np.radians(mean + centre - 0.00569 - 0.00478 * np.sin(node))
    tilt = np.radians(23.439291 - 0.0130042 * t + 0.00256 * np.cos(node))
    ascension = np.arctan2(np.cos(tilt) * np.sin(longitude_of_sun), np.cos(longitude_of_sun))
    declination = np.arcsin(np.sin(tilt) * np.sin(longitude_of_sun))
    sidereal = 280.46061837 + 360.98564736629 * day - 0.00478 * np.sin(node) * np.cos(tilt)
    hour = np.radians(sidereal + longitude) - ascension
    phi = np.radians(latitude)
    return np.stack(
        [
            -np.cos(declination) * np.sin(hour),
            np.sin(declination) * np.cos(phi) - np.cos(declination) * np.sin(phi) * np.cos(hour),
            np.sin(declination) * np.sin(phi) + np.cos(declination) * np.cos(phi) * np.cos(hour),
        ],
        axis=-1,
    )


def gensky_directions(seconds, latitudes, longitudes) -> np.ndarray:
    """Return the same by Radiance's `gensky`. (n, 3)

    Raises
    ------
    LumenrayError    It refuses.
    """
    made = []
    with tempfile.TemporaryDirectory() as folder:
        for time, latitude, longitude in zip(seconds, latitudes, longitudes, strict=True):
            clock = _moment(time)
            text = run_program(
                Path(folder), "gensky", str(clock.month), str(clock.day), f"{clock:%H:%M}",
                "-y", str(clock.year), "-a", f"{latitude:.3f}", "-o", f"{-longitude:.3f}", "-m", "0", "+s",
            )  # fmt: skip
            # The last three numbers of the sky's function.
            made.append([float(word) for word in text.split()[-3:]])
    made = np.array(made)
    return made / np.linalg.norm(made, axis=1, keepdims=True)


def _moment(seconds: float) -> datetime:
    return datetime(1970, 1, 1, tzinfo=UTC) + timedelta(seconds=float(seconds))
