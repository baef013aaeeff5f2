"""What readers of weather files share: what is refused, and what is remarked on."""

from dataclasses import replace

import numpy as np

from ..errors import FileFormatError
from ..reading.remarks import Remark
from .weather import UNITS, Weather, note, zone_offset

MOST_RECORDS = 12 * 8784
"""Of a file: a year by five minutes."""

STRONGEST = 2000.0
"""No irradiance is larger; a larger one has another unit. [W/m2]"""

SUN_AT_PERIHELION = 1414.0
"""Irradiance by the sun outside the atmosphere at most. [W/m2]"""

FARTHEST_MERIDIAN = 30.0
"""Between a zone's meridian and the place, where nothing is said of it. [degree]"""


def check_weather(path, weather: Weather) -> Weather:
    """Refuse records whose numbers mean nothing, and remark on what is odd.

    Raises
    ------
    FileFormatError    There is no record, or an irradiance or an illuminance is negative or absurd; names the line.
    """
    if not len(weather):
        raise FileFormatError(path, "has no records")
    values = weather.values
    for name, numbers in values.items():
        if UNITS[name] in {"W/m2", "lx", "cd/m2"}:
            most = STRONGEST if UNITS[name] == "W/m2" else STRONGEST * 500.0
            wrong = np.flatnonzero((numbers < 0.0) | (numbers > most))
            if len(wrong):
                i = wrong[0]
                raise FileFormatError(
                    path,
                    f"has {numbers[i]:g} {UNITS[name]} as {name.replace('_', ' ')}, expected 0 to {most:g}",
                    int(weather.line[i]),
                )
    _refuse_twice(path, weather)
    remarks = list(weather.remarks)
    offset = zone_offset(weather.place)
    apart = (offset * 15.0 - weather.place.longitude + 180.0) % 360.0 - 180.0
    if abs(apart) > FARTHEST_MERIDIAN:
        remarks.append(
            Remark(
                f"the time zone's meridian is {abs(apart):.0f} degrees from the longitude {weather.place.longitude:g}; "
                "one of them may have the wrong sign"
            )
        )
    for name in ("direct_normal", "diffuse_horizontal", "direct_horizontal"):
        missing = np.isnan(values[name]) if name in values else np.zeros(len(weather), bool)
        note(remarks, weather, missing, f"no {name.replace('_', ' ')} irradiance")
    if "direct_normal" in values:
        note(
            remarks,
            weather,
            values["direct_normal"] > SUN_AT_PERIHELION,
            f"more direct normal irradiance than the sun gives outside the atmosphere, {SUN_AT_PERIHELION:g} W/m2",
        )
    if "global_horizontal" in values and "diffuse_horizontal" in values:
        excess = values["diffuse_horizontal"] > 1.2 * values["global_horizontal"] + 5.0
        note(remarks, weather, excess, "more diffuse than global horizontal irradiance")
    whole = round(8760 / weather.interval)
    if len(weather) < whole:
        remarks.append(Remark(f"has {len(weather)} of a year's {whole} records"))
    return replace(weather, remarks=tuple(remarks))


def _refuse_twice(path, weather: Weather) -> None:
    """Refuse a moment that comes twice."""
    moments = np.stack(
        [weather.month, weather.day, np.round(weather.hour * 3600.0).astype(np.int64)], axis=-1
    )
    _, first, inverse = np.unique(moments, axis=0, return_index=True, return_inverse=True)
    again = np.flatnonzero(first[inverse.ravel()] != np.arange(len(weather)))
    if len(again):
        i = again[0]
        raise FileFormatError(
            path,
            f"states {weather.day[i]}/{weather.month[i]} (day/month) {weather.hour[i]:g} h a second time, first in line "
            f"{weather.line[first[inverse.ravel()[i]]]}",
            int(weather.line[i]),
        )


def check_date(path, month, day, line: int) -> None:
    """Refuse a date that no year has.

    Raises
    ------
    FileFormatError    Names the line.
    """
    days = (31, 29, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31)
    if month is None or day is None or not 1 <= month <= 12 or not 1 <= day <= days[int(month) - 1]:
        raise FileFormatError(path, f"has month {month} and day {day}, which no year has", line)


def cleaned_title(text: str) -> str:
    """Return a name of a place as one line without padding."""
    return " ".join(text.replace("_", " ").split())[:120]
