"""Weather files, written by the rules of their formats and not by the readers."""

import functools
import math
from datetime import datetime, timedelta

EPW_HEADING = (
    "LOCATION,{city},-,DEU,test,0,{latitude},{longitude},{zone},{elevation}",
    "DESIGN CONDITIONS,0",
    "TYPICAL/EXTREME PERIODS,0",
    "GROUND TEMPERATURES,0",
    "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0",
    "COMMENTS 1,",
    "COMMENTS 2,",
    "DATA PERIODS,1,{per_hour},Data,Sunday,1/1,12/31",
)


def epw_record(year, month, day, hour, minute=0, **values):
    """A record; ``values`` by the columns' short names, all others as missing."""
    columns = {
        "temperature": "99.9",
        "dew": "99.9",
        "humidity": "999",
        "pressure": "999999",
        "extra_horizontal": "9999",
        "extra_normal": "9999",
        "infrared": "9999",
        "ghi": "9999",
        "dni": "9999",
        "dhi": "9999",
        "global_lux": "999999",
        "direct_lux": "999999",
        "diffuse_lux": "999999",
        "zenith": "9999",
        "wind_direction": "999",
        "wind_speed": "999",
        "cover": "99",
        "opaque": "99",
        "visibility": "9999",
        "ceiling": "99999",
        "observation": "9",
        "codes": "999999999",
        "water": "999",
        "aerosol": ".999",
        "snow": "999",
        "days": "99",
        "albedo": "999",
        "rain": "999",
        "quantity": "99",
    }
    assert set(values) <= set(columns)
    columns |= {name: str(value) for name, value in values.items()}
    return ",".join([*map(str, (year, month, day, hour, minute)), "?9?9E0", *columns.values()])


def epw(records, per_hour=1, **place):
    place = {
        "city": "Test",
        "latitude": 49.5,
        "longitude": 8.5,
        "zone": 1.0,
        "elevation": 100,
    } | place
    heading = [line.format(per_hour=per_hour, **place) for line in EPW_HEADING]
    return "\n".join([*heading, *records]) + "\n"


def epw_year(year=2005, has_leap_day=False, **values):
    """Records of every hour."""
    records, day = [], datetime(2004, 1, 1)
    while day.year == 2004:
        if has_leap_day or (day.month, day.day) != (2, 29):
            records += [
                epw_record(year, day.month, day.day, hour, **values) for hour in range(1, 25)
            ]
        day += timedelta(days=1)
    return records


def wea(
    records, unit=1, latitude=49.5, longitude=-8.5, time_zone=-15, elevation=100, place="Test_City"
):
    """``records``: of month, day, hour, direct and diffuse each."""
    heading = [
        f"place {place}",
        f"latitude {latitude}",
        f"longitude {longitude}",
        f"time_zone {time_zone}",
        f"site_elevation {elevation}",
        f"weather_data_file_units {unit}",
    ]
    return "\n".join([*heading, *(" ".join(map(str, record)) for record in records)]) + "\n"


@functools.cache
def sunny_year(is_clear=lambda day: day % 20 < 10, latitude=49.5, longitude=8.5, zone=1.0):
    """An EPW file's text: clear and overcast days by rules of thumb, the sun by school formulas."""
    records = []
    for day in range(365):
        date = datetime(2005, 1, 1) + timedelta(days=day)
        declination = -math.radians(23.44) * math.cos(2.0 * math.pi * (day + 10.5) / 365.0)
        for hour in range(1, 25):
            turn = math.radians(15.0 * (hour - 12.5 + longitude / 15.0 - zone))
            sine = math.sin(math.radians(latitude)) * math.sin(declination) + math.cos(
                math.radians(latitude)
            ) * math.cos(declination) * math.cos(turn)
            clear = is_clear(day) and sine > 0.05
            direct = round(1100.0 * 0.75 ** (1.0 / sine)) if clear else 0
            diffuse = 0 if sine <= 0.01 else round((90.0 if clear else 250.0) * sine**0.8)
            records.append(
                epw_record(2005, date.month, date.day, hour, dni=direct, dhi=diffuse, dew=8.0)
            )
    return epw(records, latitude=latitude, longitude=longitude, zone=zone)
