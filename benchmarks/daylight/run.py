"""Natural light beside other programs: parts that can be run alone, and what they come to."""

import tempfile
from pathlib import Path

from ...engine.reading.whole_file import write_whole
from ...engine.sky.weather import Weather
from ...engine.sky.weather_file import read_weather
from ..common.machine import OtherLoad, describe_machine
from ..common.output import read_numbers, write_numbers
from ..common.parts import choose_parts
from .document import check_bars, describe
from .ours import Lumenray, YearEngine
from .room import make_room
from .scale import measure_scale
from .skies import largest_difference, measure_skies
from .speed import measure_speed, speedup
from .sun import measure_sun
from .weather_year import make_year, write_epw
from .year import measure_year

PARTS = ("sun", "skies", "year", "speed", "scale")

__all__ = ["PARTS", "check_bars", "read_results", "run", "write_results"]


def run(
    parts=None,
    weather: Path | None = None,
    engine: YearEngine | None = None,
    say=lambda text: None,
    keep=None,
    earlier: dict | None = None,
) -> dict:
    """Measure.

    Parameters
    ----------
    parts : iterable of str or None    Which of `PARTS`; None: all, or those that the earlier results lack.
    weather : Path or None    A weather file for skies, year, speed and scale; None: built-in hours, and a made-up year.
    engine : YearEngine or None    None: ours.
    say : callable    Told of every step.
    keep : callable or None    Given all results so far after every part, and within long ones.
    earlier : dict or None    Results that are gone on with; named parts are measured again, but for the runs of a part
        ``speed`` that broke off.

    Returns
    -------
    dict    Plain data, for JSON: ``machine``, ``weather``, ``parts``, ``other_load`` by part, and the figures that demands
        are made on: ``sun_max_error_deg``, ``gendaylit_max_percent``, ``hour_bias_percent``, ``metric_coverage``,
        ``speedup_two_phase`` and ``year_over_hour``, None where they were not measured.

    Raises
    ------
    LumenrayError    There is no such part, the weather cannot be read, or Radiance is needed and not installed.
    """
    result = {"parts": {}, "other_load": {}, "unfinished": {}, **(earlier or {})}
    result |= {"machine": describe_machine(), "weather": weather.name if weather else "made up"}
    wanted = choose_parts(parts, PARTS, result["parts"])
    engine = engine or Lumenray()
    with tempfile.TemporaryDirectory() as folder:
        given = read_weather(weather) if weather else None
        year = given or write_epw(make_year(), Path(folder) / "year.epw")
        for name in PARTS:
            if name not in wanted:
                continue
            load = OtherLoad()

            def keep_part(made: dict, name=name) -> None:
                result["unfinished"][name] = made
                if keep is not None:
                    keep(_sum_up(result))

            made = _measure(
                name, given, year, engine, say, keep_part, result["unfinished"].get(name)
            )
            result["parts"][name], result["other_load"][name] = made, load.share()
            result["unfinished"].pop(name, None)
            if keep is not None:
                keep(_sum_up(result))
    return _sum_up(result)


def _measure(name, given: Weather | None, year: Weather, engine, say, keep, unfinished) -> dict:
    match name:
        case "sun":
            return measure_sun(say=say)
        case "skies":
            return measure_skies(given, say)
        case "year":
            return measure_year(engine, make_room(), year, say)
        case "speed":
            return measure_speed(engine, make_room(), year, say, keep, unfinished)
    return measure_scale(engine, year, say)


def _sum_up(result: dict) -> dict:
    """Return results with the figures that demands are made on."""
    parts = result["parts"]
    sun, skies, year, speed = (parts.get(name) for name in PARTS[:4])
    race = speed and speedup(speed)
    return {
        **result,
        "sun_max_error_deg": sun and max(row["max"] for row in sun["others"].values()),
        "gendaylit_max_percent": skies and 100.0 * largest_difference(skies),
        "hour_bias_percent": year and 100.0 * abs(year["agreement"]["bias"]),
        "metric_coverage": year and year["coverage"]["cover"][-1],
        "speedup_two_phase": race[0] if race else None,
        "year_over_hour": year and year["cost"]["ratio"],
    }


def read_results(path: Path) -> dict:
    """Read the numbers of an earlier run; as `read_numbers`."""
    return read_numbers(path, {"parts", "sun_max_error_deg", "speedup_two_phase"})


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document to a folder, and all numbers to a JSON file if one is named."""
    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    with write_whole(folder / "daylight.md", "utf-8") as file:
        file.write(describe(result))
