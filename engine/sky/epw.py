"""Weather in EPW, the text of EnergyPlus: eight lines of heading, then a record for every hour of a year.

Records are in standard time, whatever the heading says of daylight saving, and hour h is the one that ends then: it stands
for h - 1 to h, hour 24 for the last before midnight. With several records an hour they part it evenly, in their order; the
column of minutes is not trusted, as programs fill it in several ways. Codes for missing values depend on the column. Years
may differ from month to month, as a typical year is put together of months of several.

References
----------
EnergyPlus auxiliary programs, EnergyPlus weather file (EPW) data dictionary
"""

import csv

import numpy as np

from ..errors import FileFormatError
from ..reading.remarks import Remark
from ..reading.text import decode, decode_text, parse_number, parse_whole
from .limits import HIGHEST, LOWEST
from .place import Place, name_offset
from .weather import Weather
from .weather_checks import MOST_RECORDS, check_date, check_weather, cleaned_title

HEADING = (
    "LOCATION",
    "DESIGN CONDITIONS",
    "TYPICAL/EXTREME PERIODS",
    "GROUND TEMPERATURES",
    "HOLIDAYS/DAYLIGHT SAVINGS",
    "COMMENTS 1",
    "COMMENTS 2",
    "DATA PERIODS",
)
"""What its first lines begin with."""

COLUMNS = {
    "temperature": (6, 99.9),
    "dew_point": (7, 99.9),
    "pressure": (9, 999_999.0),
    "global_horizontal": (13, 9999.0),
    "direct_normal": (14, 9999.0),
    "diffuse_horizontal": (15, 9999.0),
    "global_illuminance": (16, 999_900.0),
    "direct_normal_illuminance": (17, 999_900.0),
    "diffuse_horizontal_illuminance": (18, 999_900.0),
    "zenith_luminance": (19, 9999.0),
    "precipitable_water": (28, 999.0),
    "albedo": (32, 999.0),
}
"""Column, from 0, and the number from which on a value is missing."""

LEAST_COLUMNS = 30
"""Those that there have to be: old files end before the albedo."""

MOST_FIELDS = 64
"""More columns are not looked at."""

MOST_PER_HOUR = 12

LONGEST_LINE = 1 << 16
"""[character]"""


def is_own(data: bytes) -> bool:
    """Whether a text begins as EPW does."""
    return decode_head(data).upper().startswith("LOCATION,")


def decode_head(data: bytes) -> str:
    """Beginning of a text, in capitals and small letters as they are."""
    return decode_text(data, 256).lstrip()


def parse(path, data: bytes) -> Weather:
    """Read EPW.

    Raises
    ------
    FileFormatError    Something is wrong; names the line.
    """
    lines = decode(path, data).split("\n")
    place, per_hour = _heading(path, lines)
    dates, numbers, places = [], [], []
    for number, line in enumerate(lines[len(HEADING) :], start=len(HEADING) + 1):
        if not line.strip():
            continue
        if len(dates) == MOST_RECORDS:
            raise FileFormatError(path, f"has more than {MOST_RECORDS} records", number)
        fields = _fields(path, line, number)
        if len(fields) < LEAST_COLUMNS:
            raise FileFormatError(
                path, f"has {len(fields)} columns, expected 35 of a record", number
            )
        dates.append(_date(path, fields, number))
        numbers.append(_values(path, fields, number))
        places.append(number)
    year, month, day, hour = np.array(dates, dtype=np.int64).reshape(-1, 4).T
    middle = hour - 1.0 + (_count(path, dates, places, per_hour) + 0.5) / per_hour
    table = np.array(numbers, dtype=np.float64).reshape(-1, len(COLUMNS)).T
    values = {
        name: column
        for name, column in zip(COLUMNS, table, strict=True)
        if not np.isnan(column).all()
    }
    remarks = []
    absent = [name for name in ("direct_normal", "diffuse_horizontal") if name not in values]
    if dates and absent:
        what = " and ".join(name.replace("_", " ") for name in absent)
        remarks.append(Remark(f"no record has {what} irradiance"))
    weather = Weather(
        place,
        year,
        month,
        day,
        middle,
        1.0 / per_hour,
        values,
        np.array(places, dtype=np.int64),
        tuple(remarks),
    )
    return check_weather(path, weather)


def _fields(path, line: str, number: int) -> list[str]:
    if len(line) > LONGEST_LINE:
        raise FileFormatError(path, f"has more than {LONGEST_LINE} characters", number)
    try:
        return [field.strip() for field in next(csv.reader([line]), [])[:MOST_FIELDS]]
    except csv.Error as error:
        raise FileFormatError(path, f"cannot be parted into columns ({error})", number) from None


def _heading(path, lines: list[str]) -> tuple[Place, int]:
    for number, word in enumerate(HEADING, start=1):
        line = lines[number - 1] if number <= len(lines) else ""
        if not line.lstrip().upper().startswith(word):
            raise FileFormatError(
                path, f"begins with '{line.strip()[:40]}', expected {word}", number
            )
    fields = _fields(path, lines[0].lstrip(), 1)
    if len(fields) < 10:
        raise FileFormatError(
            path, f"has {len(fields)} fields of the location, expected at least 10", 1
        )
    name = cleaned_title(", ".join(field for field in fields[1:4] if field not in {"", "-"}))
    latitude, longitude, offset, elevation = (
        _bounded(path, fields[6 + i], what, low, high)
        for i, (what, low, high) in enumerate(
            [
                ("latitude", -90.0, 90.0),
                ("longitude", -180.0, 180.0),
                ("time zone", -12.0, 14.0),
                ("elevation", LOWEST, HIGHEST),
            ]
        )
    )
    fields = _fields(path, lines[7].lstrip(), 8)
    per_hour = parse_whole(fields[2]) if len(fields) > 2 else None
    if per_hour is None or not 1 <= per_hour <= MOST_PER_HOUR or 60 % per_hour:
        found = fields[2][:40] if len(fields) > 2 else ""
        raise FileFormatError(
            path,
            f"has '{found}' as records per hour, expected 1, 2, 3, 4, 5, 6, 10 or 12",
            8,
        )
    return Place(latitude, longitude, name_offset(offset), elevation, name=name), per_hour


def _bounded(path, text: str, what: str, low: float, high: float) -> float:
    value = parse_number(text)
    if value is None or not low <= value <= high:
        raise FileFormatError(path, f"has '{text[:40]}' as {what}, expected {low:g} to {high:g}", 1)
    return value


def _date(path, fields: list[str], line: int) -> tuple[int, int, int, int]:
    year, month, day, hour = (parse_whole(field) for field in fields[:4])
    if year is None or not 1 <= year <= 9999:
        raise FileFormatError(path, f"has '{fields[0][:40]}' as year", line)
    check_date(path, month, day, line)
    if hour is None or not 1 <= hour <= 24:
        raise FileFormatError(path, f"has '{fields[3][:40]}' as hour, expected 1 to 24", line)
    return year, month, day, hour


def _values(path, fields: list[str], line: int) -> list[float]:
    values = []
    for name, (column, missing) in COLUMNS.items():
        text = fields[column] if column < len(fields) else ""
        value = parse_number(text) if text else np.nan
        if value is None:
            raise FileFormatError(
                path, f"has '{text[:40]}' as {name.replace('_', ' ')}, expected a number", line
            )
        values.append(np.nan if value >= missing else value)
    return values


def _count(path, dates: list, lines: list[int], per_hour: int) -> np.ndarray:
    """Which record of its hour each is, from 0."""
    found, at = np.zeros(len(dates), dtype=np.int64), -1
    for i, date in enumerate(dates):
        at = at + 1 if i and date == dates[i - 1] else 0
        found[i] = at
        is_last = i + 1 == len(dates) or dates[i + 1] != date
        if at >= per_hour or (is_last and at + 1 != per_hour):
            raise FileFormatError(
                path,
                f"is record {at + 1} of hour {date[3]}, which has {per_hour} by DATA PERIODS",
                lines[i],
            )
    return found
