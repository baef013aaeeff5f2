"""The command ``lumenray sky info``: where the sun stands and what it gives, and what a weather file holds."""

from ...engine.errors import SceneError
from ..options import real, whole
from ..output import percent, rounded, say, say_json, sheet
from .place import add_place, find_moment, find_place, find_record

TURBIDITY = 3.0
"""Luminous turbidity of a clear day. [-]"""


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    info = tasks.add_parser(
        "info", help="where the sun stands, what sun and sky give, what a weather file holds"
    )
    add_place(info)
    info.add_argument(
        "--turbidity",
        type=real(1.0, 20.0),
        default=TURBIDITY,
        metavar="T",
        help=f"luminous turbidity of a cloudless day (default: {TURBIDITY:g})",
    )
    info.add_argument(
        "--year",
        type=whole(1900, 2100),
        metavar="Y",
        help="in which the weather is taken to be (default: that of --time, else its own)",
    )
    info.add_argument("--json", action="store_true", help="JSON instead of text")
    info.set_defaults(run=run)


def run(options) -> int:
    """Tell about a place, a time and a weather file; return the exit code."""
    row = rounded(describe(options))
    if options.json:
        say_json(row)
    else:
        say(tell(row))
    return 0


def describe(options) -> dict:
    """Row for JSON: numbers with their unit in the key, None where there is none."""
    from ...engine.sky.weather_file import read_weather

    weather = None if options.weather is None else read_weather(options.weather)
    place = find_place(options, weather)
    if place is None:
        raise SceneError("expected a place: --place, --latitude with --longitude, or --weather")
    if weather is None and options.time is None:
        raise SceneError("expected --time, such as 2026-06-21T12:00")
    row = {
        "place": {
            "name": place.name,
            "latitude_deg": place.latitude,
            "longitude_deg": place.longitude,
            "elevation_m": place.elevation,
            "zone": place.zone,
        }
    }
    moment = find_moment(options, place)
    if moment is not None:
        row |= _describe_moment(moment, place, options.turbidity)
    if weather is not None:
        year = options.year or (None if moment is None else moment.clock.year)
        row |= _describe_weather(weather, year, moment, options.weather)
    return row


def _describe_moment(moment, place, turbidity: float) -> dict:
    import numpy as np

    from ...engine.sky.availability import CONDITIONS, usual_illuminance
    from ...engine.sky.place import to_local
    from ...engine.sky.solar_position import Air, find_day, find_sun, refraction
    from ...engine.sky.sunlight import direct_illuminance

    sun = find_sun(moment.seconds, place)
    elevation = float(sun.elevation)
    pressure = pressure_at(place.elevation)
    lift = float(refraction(elevation, Air(pressure)))
    day = find_day(moment.clock.year, moment.clock.month, moment.clock.day, place)
    shown = {
        name: None
        if seconds is None
        else to_local(seconds, place.zone).isoformat(timespec="seconds")
        for name, seconds in (("sunrise", day.rise), ("noon", day.noon), ("sunset", day.set))
    }
    direct = direct_illuminance(elevation, turbidity, float(sun.distance), pressure)
    return {
        "time": {
            "clock": moment.clock.isoformat(),
            "utc": to_local(moment.seconds, "UTC").isoformat(),
            "note": moment.note,
        },
        "sun": {
            "elevation_deg": elevation,
            "elevation_with_refraction_deg": elevation + lift,
            "azimuth_deg": float(sun.azimuth),
            "declination_deg": float(sun.declination),
            "equation_of_time_min": float(sun.equation_of_time),
            "solar_time_h": float(sun.solar_time),
            "distance_au": float(sun.distance),
        },
        "day": {**shown, "is_polar_day": day.is_polar_day, "is_polar_night": day.is_polar_night},
        "cloudless": {
            "turbidity": turbidity,
            "direct_normal_lx": direct,
            "direct_horizontal_lx": direct * max(np.sin(np.radians(elevation)), 0.0),
        },
        "usual_diffuse_horizontal_lx": {
            name: usual_illuminance(name, elevation) for name in CONDITIONS
        },
    }


def pressure_at(elevation: float) -> float:
    """Return the pressure of the standard atmosphere. [m -> Pa]"""
    return 101_325.0 * (1.0 - 2.25577e-5 * elevation) ** 5.25588


CLASSES = ("overcast", *["intermediate"] * 6, "clear")
"""Words for the classes of the all-weather sky."""


def _describe_weather(weather, year, moment, path) -> dict:
    import numpy as np

    from ...engine.daylight.sunlight import SUNSHINE
    from ...engine.sky.hour import find_daylight_hours
    from ...engine.sky.perez import find_class
    from ...engine.sky.weather import find_hours, find_middles

    if year is None and not weather.year.all():
        has_leap_day = ((weather.month == 2) & (weather.day == 29)).any()
        year = 2000 if has_leap_day else 2001
    hours = find_hours(weather, year)
    daylight = find_daylight_hours(weather, hours)
    beam = np.sin(np.radians(np.maximum(hours.sun.elevation, 0.0)))
    sums = {
        "direct_normal_kwh_m2": hours.direct_normal * 1e-3,
        "diffuse_horizontal_kwh_m2": hours.diffuse_horizontal * 1e-3,
        "global_horizontal_kwh_m2": (hours.diffuse_horizontal + hours.direct_normal * beam) * 1e-3,
        "diffuse_horizontal_klx_h": daylight.diffuse_horizontal * 1e-3,
        "global_horizontal_klx_h": (daylight.diffuse_horizontal + daylight.direct_normal * beam)
        * 1e-3,
    }
    known = np.isfinite(daylight.diffuse_horizontal) & np.isfinite(daylight.direct_normal)
    row = {
        "file": str(path),
        "records": len(weather),
        "missing_records": int(np.count_nonzero(~known)),
        "interval_h": weather.interval,
        "years": sorted({int(y) for y in weather.year if y}) or None,
        "taken_as_year": year,
        "sums": {name: float(np.nansum(each)) * weather.interval for name, each in sums.items()},
        "sunshine_h": float(np.count_nonzero(hours.direct_normal > SUNSHINE)) * weather.interval,
        "en17037": _describe_standard(weather, daylight),
        "remarks": [str(remark) for remark in (*weather.remarks, *hours.remarks)],
    }
    made = {"weather": row}
    if moment is not None:
        index = find_record(weather, find_middles(weather, year), moment.seconds)
        if index is None:
            raise SceneError(f"the weather file has no record of {moment.clock:%H:%M on %Y-%m-%d}")
        made["hour"] = {
            "line": int(weather.line[index]),
            "direct_normal_w_m2": float(hours.direct_normal[index]),
            "diffuse_horizontal_w_m2": float(hours.diffuse_horizontal[index]),
            "direct_normal_lx": float(daylight.direct_normal[index]),
            "diffuse_horizontal_lx": float(daylight.diffuse_horizontal[index]),
            "sky_class": int(find_class(daylight.clearness[index])) + 1 if known[index] else None,
            "clearness": float(daylight.clearness[index]),
            "brightness": float(daylight.brightness[index]),
            "sun_elevation_deg": float(hours.sun.elevation[index]),
            "sun_azimuth_deg": float(hours.sun.azimuth[index]),
        }
    return made


def _describe_standard(weather, daylight) -> dict | None:
    """Median sky and target daylight factors of EN 17037; None for less than a whole year."""
    import numpy as np

    from ...engine.daylight import en17037

    diffuse = daylight.diffuse_horizontal
    if len(weather) < round(8760 / weather.interval) or not np.isfinite(diffuse).all():
        return None
    median = en17037.median_illuminance(diffuse)
    factors = en17037.target_factors(median)
    return {
        "median_diffuse_lx": median,
        "target_factors": {
            level.name: {"target": float(target), "least": float(least)}
            for level, (target, least) in zip(en17037.LEVELS, factors, strict=True)
        },
    }


# ---- text ----


def tell(row: dict) -> str:
    """Text for people about a row of `describe`."""
    place = row["place"]
    title = place["name"] or "place"
    return sheet(title, [*_lines(row)])


def _lines(row):
    place = row["place"]
    north, east = (
        ("N" if place["latitude_deg"] >= 0 else "S"),
        ("E" if place["longitude_deg"] >= 0 else "W"),
    )
    yield (
        "place",
        f"{abs(place['latitude_deg']):g}° {north}, {abs(place['longitude_deg']):g}° {east}, {place['elevation_m']:g} m, "
        f"{place['zone']}",
    )
    if "sun" in row:
        yield from _sun_lines(row)
    if "hour" in row:
        yield from _hour_lines(row["hour"])
    if "weather" in row:
        yield from _weather_lines(row["weather"])


def _sun_lines(row):
    sun, day = row["sun"], row["day"]
    yield "time", [_clock(row["time"]["clock"]), row["time"]["note"]]
    yield (
        "sun",
        f"{sun['elevation_deg']:.3f}° high ({sun['elevation_with_refraction_deg']:.3f}° with refraction), azimuth "
        f"{sun['azimuth_deg']:.3f}° from north over east",
    )
    yield (
        "solar time",
        f"{_hours(sun['solar_time_h'])}, equation of time {sun['equation_of_time_min']:+.2f} min",
    )
    words = ["the sun does not set"] if day["is_polar_day"] else []
    words += ["the sun does not rise"] if day["is_polar_night"] else []
    words += [f"{key} {day[key][11:19]}" for key in ("sunrise", "noon", "sunset") if day[key]]
    yield "day", ", ".join(words)
    direct = row["cloudless"]
    yield (
        "cloudless sun",
        f"{_lux(direct['direct_normal_lx'])} normal, {_lux(direct['direct_horizontal_lx'])} horizontal, turbidity "
        f"{direct['turbidity']:g}",
    )
    usual = row["usual_diffuse_horizontal_lx"]
    yield "usual skies", ", ".join(f"{name} {_lux(value)}" for name, value in usual.items())


def _hour_lines(hour):
    yield (
        "weather's hour",
        f"line {hour['line']}: sun {_number(hour['direct_normal_w_m2'])} W/m² normal, sky "
        f"{_number(hour['diffuse_horizontal_w_m2'])} W/m²",
    )
    if hour["sky_class"] is None:
        yield "", "its illuminances are not known"
        return
    yield (
        "illuminance",
        f"sun {_lux(hour['direct_normal_lx'])} normal, sky {_lux(hour['diffuse_horizontal_lx'])} horizontal",
    )
    yield (
        "sky",
        f"{CLASSES[hour['sky_class'] - 1]}, class {hour['sky_class']} of 8 (clearness {hour['clearness']:.3f}, brightness "
        f"{hour['brightness']:.3f})",
    )


def _weather_lines(weather):
    years = weather["years"]
    span = (
        "no years of its own"
        if not years
        else f"of {years[0]}" + (f" to {years[-1]}" if len(years) > 1 else "")
    )
    missing = f", {weather['missing_records']} without values" if weather["missing_records"] else ""
    yield (
        "weather file",
        f"{weather['records']} records of {weather['interval_h']:g} h, {span}{missing}",
    )
    sums = weather["sums"]
    yield (
        "sums",
        [
            f"sun {sums['direct_normal_kwh_m2']:.1f} kWh/m² normal, sky {sums['diffuse_horizontal_kwh_m2']:.1f} kWh/m², "
            f"both {sums['global_horizontal_kwh_m2']:.1f} kWh/m² horizontal",
            f"sky {sums['diffuse_horizontal_klx_h']:.0f} klx h, both {sums['global_horizontal_klx_h']:.0f} klx h "
            f"horizontal; sunshine {weather['sunshine_h']:.0f} h",
        ],
    )
    standard = weather["en17037"]
    if standard is not None:
        factors = "; ".join(
            f"{name} {percent(each['target'], '.2f')} and {percent(each['least'], '.2f')}"
            for name, each in standard["target_factors"].items()
        )
        yield (
            "EN 17037",
            [f"median sky {_lux(standard['median_diffuse_lx'])}", f"daylight factors {factors}"],
        )
    yield "warnings", weather["remarks"]


def _clock(text: str) -> str:
    return f"{text[:10]} {text[11:16]} (UTC{text[-6:]})"


def _hours(hours: float) -> str:
    seconds = round(hours * 3600.0) % 86400
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}"


def _number(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.4g}"


def _lux(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.0f} lx"
