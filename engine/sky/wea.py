"""Weather in WEA, the text of Daysim and Radiance: six lines of heading, then month, day, hour, direct and diffuse.

Longitude and time zone (as its meridian) are positive to the west, the hour is the middle of the interval in standard time,
with a fraction. Units: 1 is irradiance, normal to the sun and diffuse horizontal; 2 is irradiance, both horizontal; 3 is
illuminance, normal to the sun and diffuse horizontal. There are no years.

References
----------
Radiance, gendaymtx(1)
"""

import numpy as np

from ..errors import FileFormatError
from ..reading.text import decode, parse_number, parse_whole
from .epw import decode_head
from .limits import HIGHEST, LOWEST
from .place import Place, name_offset
from .weather import Weather
from .weather_checks import MOST_RECORDS, check_date, check_weather, cleaned_title

HEADING = {
    "latitude": (-90.0, 90.0),
    "longitude": (-180.0, 180.0),
    "time_zone": (-210.0, 180.0),
    "site_elevation": (LOWEST, HIGHEST),
    "weather_data_file_units": (1.0, 3.0),
}
"""What the heading states after the place's name, with its bounds."""

NAMES = {
    1: ("direct_normal", "diffuse_horizontal"),
    2: ("direct_horizontal", "diffuse_horizontal"),
    3: ("direct_normal_illuminance", "diffuse_horizontal_illuminance"),
}
"""What the last two columns are, by unit."""

LONGEST_LINE = 4096
"""[character]"""

FINEST = 1.0 / 12.0
"""Shortest interval. [h]"""


def is_own(data: bytes) -> bool:
    """Whether a text begins as WEA does."""
    head = decode_head(data)
    return head[:5].lower() == "place" and (len(head) == 5 or head[5].isspace())


def parse(path, data: bytes) -> Weather:
    """Read WEA.

    Raises
    ------
    FileFormatError    Something is wrong; names the line.
    """
    lines = decode(path, data).split("\n")
    for number, line in enumerate(lines, start=1):
        if len(line) > LONGEST_LINE:
            raise FileFormatError(path, f"has more than {LONGEST_LINE} characters", number)
    rows = ((number, line.split(None, 5)) for number, line in enumerate(lines, start=1))
    rows = [(number, words) for number, words in rows if words]
    heading = _heading(path, rows[: 1 + len(HEADING)])
    rows = rows[1 + len(HEADING) :]
    if len(rows) > MOST_RECORDS:
        raise FileFormatError(path, f"has more than {MOST_RECORDS} records", rows[MOST_RECORDS][0])
    unit = round(heading["weather_data_file_units"])
    dates, numbers = [], []
    for number, words in rows:
        month, day, hour, values = _row(path, words, number)
        dates.append((month, day))
        numbers.append((hour, *values))
    month, day = np.array(dates, dtype=np.int64).reshape(-1, 2).T
    hour, direct, diffuse = np.array(numbers, dtype=np.float64).reshape(-1, 3).T
    place = Place(
        heading["latitude"],
        -heading["longitude"],
        name_offset(-heading["time_zone"] / 15.0),
        heading["site_elevation"],
        name=cleaned_title(" ".join(_name(lines))),
    )
    weather = Weather(
        place,
        np.zeros(len(rows), dtype=np.int64),
        month,
        day,
        hour,
        _interval(month, day, hour),
        dict(zip(NAMES[unit], (direct, diffuse), strict=True)),
        np.array([number for number, _ in rows], dtype=np.int64),
    )
    return check_weather(path, weather)


def _name(lines: list[str]) -> list[str]:
    return next(line for line in lines if line.strip()).split()[1:]


def _heading(path, rows) -> dict[str, float]:
    heading = {}
    for i, (name, (low, high)) in enumerate(HEADING.items(), start=1):
        number, words = rows[i] if i < len(rows) else (rows[-1][0], [""])
        if i >= len(rows) or words[0].lower() != name:
            raise FileFormatError(path, f"begins with '{words[0][:40]}', expected {name}", number)
        value = parse_number(words[1]) if len(words) > 1 else None
        is_whole = name != "weather_data_file_units" or value in {1.0, 2.0, 3.0}
        if value is None or not low <= value <= high or not is_whole:
            found = words[1][:40] if len(words) > 1 else ""
            kind = "1, 2 or 3" if name == "weather_data_file_units" else f"{low:g} to {high:g}"
            raise FileFormatError(path, f"has '{found}' as {name}, expected {kind}", number)
        heading[name] = value
    return heading


def _row(path, words: list[str], line: int) -> tuple:
    if len(words) < 5:
        raise FileFormatError(
            path, f"has {len(words)} numbers, expected month, day, hour, direct and diffuse", line
        )
    month, day = parse_whole(words[0]), parse_whole(words[1])
    check_date(path, month, day, line)
    hour = parse_number(words[2])
    if hour is None or not 0.0 <= hour <= 24.0:
        raise FileFormatError(path, f"has '{words[2][:40]}' as hour, expected 0 to 24", line)
    values = [parse_number(word) for word in words[3:5]]
    if None in values:
        wrong = words[3 + values.index(None)]
        raise FileFormatError(path, f"has '{wrong[:40]}' where a number was expected", line)
    return month, day, hour, values


def _interval(month, day, hour) -> float:
    """Shortest step within a day, an hour at most. [h]"""
    step = np.diff(hour)[(np.diff(month) == 0) & (np.diff(day) == 0)]
    step = step[step >= FINEST - 1e-6]
    return float(min(step.min(initial=1.0), 1.0))
