"""The command ``lumenray daylight``: the daylight of a year at sensors, and what standards make of it."""

from dataclasses import replace
from datetime import date
from pathlib import Path

import numpy as np

from ...blender_addon import assumptions
from ...blender_addon.daylight_year.job import SUN_ANGLE, YearJob
from ...engine.errors import SceneError
from ..blend_file import open_blend
from ..cluster_options import add_cluster, open_engine
from ..modelling import overrule
from ..options import add_rule, add_scene, real, rule_of, seed_of, share, transport_of, whole
from ..output import add_output, check_free, say, sheet
from ..progress import Bar
from .answers import MAPS, MATRIX, write
from .map_files import first_map
from .places import find_maps, find_places
from .states import RULES, find_blinds, find_rules, keep_states, read_rule

SAMPLES = 8192
"""Paths of a sensor where nothing is asked for."""

ROWS, FINE_ROWS, FINE_ERROR = 15, 30, 0.005
"""Rows of the sky, and those where a smaller error is asked for."""

SUNLIGHT_STEP = 300.0
"""Between moments of the day whose sunlight is judged. [s]"""

TABLES = ("sensors.csv", "hours.csv", "summary.json")
PICTURES = ("hours.png", "autonomy.png", "factor.png", "sunlight.png")


def add_command(commands) -> None:
    """Describe the command to argparse."""
    daylight = commands.add_parser(
        "daylight",
        help="daylight of a whole year at sensors: daylight factors, autonomy, LM-83, EN 17037",
        epilog=f"{RULES}\n\n{assumptions.CODES}",
    )
    add_scene(daylight)
    daylight.add_argument(
        "--weather", required=True, type=Path, metavar="W.epw", help="weather file, EPW or WEA"
    )
    _add_places(daylight.add_argument_group("sensors (one of --sensors and --floor)"))
    _add_maps(daylight.add_argument_group("maps"))
    _add_building(daylight.add_argument_group("building and year"))
    _add_question(daylight.add_argument_group("what is asked"))
    words = "folder for tables (CSV, JSON) and pictures"
    add_output(daylight, "DIR", words)
    daylight.add_argument(
        "--hourly", action="store_true", help=f"also write {MATRIX}: every sensor at every hour"
    )
    daylight.add_argument(
        "--resume",
        action="store_true",
        help="use what an earlier run in DIR has traced of the same scene, weather and settings",
    )
    add_rule(daylight, "sensor")
    daylight.add_argument(
        "--rows",
        type=whole(6, 45),
        metavar="N",
        help="rows of the sky from the horizon to the zenith (default: 15, of 600 nodes; 30, of 2300 nodes, where an error "
        "below 0.5%% is asked for)",
    )
    assumptions.add_option(daylight)
    add_cluster(daylight)
    daylight.set_defaults(run=run)


def _add_places(group) -> None:
    chosen = group.add_mutually_exclusive_group(required=True)
    chosen.add_argument("--sensors", type=Path, metavar="IN.csv", help="x,y,z,nx,ny,nz in metres")
    chosen.add_argument(
        "--floor",
        metavar="OBJECTS",
        help="a grid above these objects, by name, with commas between",
    )
    group.add_argument(
        "--spacing", type=real(), default=0.5, metavar="M", help="of the grid (default: 0.5)"
    )
    group.add_argument(
        "--height", type=real(0.0), default=0.8, metavar="M", help="above the floor (default: 0.8)"
    )
    group.add_argument(
        "--margin",
        type=real(0.0),
        default=0.0,
        metavar="M",
        help="left free along the sides (default: 0)",
    )


def _add_maps(group) -> None:
    group.add_argument(
        "--maps",
        metavar="OBJECTS",
        help=f"also write maps of all figures on these objects, by name, with commas between, into {MAPS}/",
    )
    group.add_argument(
        "--lumels-per-m",
        type=real(),
        default=2.0,
        metavar="N",
        help="of the maps; every lumel is a sensor (default: 2)",
    )


def _add_building(group) -> None:
    group.add_argument(
        "--year",
        type=whole(1900, 2100),
        metavar="N",
        help="that the records are taken in (default: each in its own; needed where a file has none)",
    )
    group.add_argument(
        "--north",
        type=real(-360.0, 360.0),
        default=0.0,
        metavar="DEG",
        help="compass direction of the scene's +Y axis (default: 0, north)",
    )
    group.add_argument(
        "--ground",
        type=share(0.0),
        default=0.2,
        metavar="R",
        help="reflectance of the ground around (default: 20%%)",
    )
    group.add_argument(
        "--blinds",
        action="append",
        default=[],
        metavar="COLLECTION",
        help="its objects are the closed blinds of a group of windows; may be given again",
    )
    group.add_argument(
        "--blinds-when",
        action="append",
        default=[],
        type=read_rule,
        metavar="RULE",
        help="when they are closed, see below (default: by LM-83's rule)",
    )
    group.add_argument("--roof", action="store_true", help="EN 17037: daylight comes from above")


def _add_question(group) -> None:
    group.add_argument(
        "--zone",
        metavar="ZONE",
        help="of the clocks, such as Europe/Berlin (default: the file's, without daylight saving time)",
    )
    group.add_argument(
        "--hours",
        type=_hours,
        default=(8.0, 18.0),
        metavar="A-B",
        help="when people are there (default: 8-18)",
    )
    group.add_argument(
        "--workdays", action="store_true", help="from Monday to Friday alone (default: every day)"
    )
    group.add_argument(
        "--target",
        type=real(),
        default=300.0,
        metavar="LX",
        help="of daylight autonomy (default: 300)",
    )
    group.add_argument(
        "--sun-day",
        type=_day,
        default=(3, 21),
        metavar="MM-DD",
        help="whose sunlight EN 17037 judges (default: 03-21)",
    )
    group.add_argument(
        "--least-sun",
        type=real(0.0, 45.0),
        metavar="DEG",
        help="least elevation of the sun that counts on it (default: 10, and told)",
    )


def _hours(text: str) -> tuple[float, float]:
    start, _, end = text.partition("-")
    return real(0.0, 24.0)(start), real(0.0, 24.0)(end)


def _day(text: str) -> tuple[int, int]:
    month, _, day = text.partition("-")
    return whole(1, 12)(month), whole(1, 31)(day)


def run(options) -> int:
    """Judge the daylight of a year; return the exit code."""
    from ...blender_addon.sync.scene import convert_scene
    from ...blender_addon.sync.walk import NO_LIGHT
    from ...engine.accuracy.stopping import StopRule
    from ...engine.daylight.coefficients import DaylightOrder
    from ...engine.daylight.words import describe
    from ...engine.daylight.year import make_year
    from ...engine.scene.scene import Scene
    from ...engine.sky.weather_file import read_weather

    names = [*TABLES, *PICTURES, *([MATRIX] if options.hourly else [])]
    if not options.resume:
        maps = [first_map(options.output / MAPS)] if options.maps is not None else []
        check_free(options, *(options.output / name for name in names), *maps)
    weather = read_weather(options.weather)
    rows = options.rows or (FINE_ROWS if (options.error or 1.0) < FINE_ERROR else ROWS)
    year = make_year(weather, options.north, options.ground, rows, options.year)
    if not len(year.lit):
        raise SceneError(f"{options.weather}: no hour has any daylight")
    question, notes = _ask(options, weather)
    depsgraph = open_blend(options.file)
    overrule(depsgraph.scene, options)
    converted = convert_scene(depsgraph)
    settings, report = depsgraph.scene.lumenray, converted.report
    # Sky and sun are those of the weather.
    report.forget(NO_LIGHT)
    assumptions.refuse_missing(report, options.accept_missing)
    assumptions.refuse_media(report)
    scene = Scene()
    scene.apply(converted.delta)
    order = DaylightOrder(
        np.concatenate([year.suns, question.day.sun.directions(options.north)]),
        SUN_ANGLE,
        rule_of(options, lambda: StopRule(samples=SAMPLES)),
        rows,
        seed=seed_of(options, settings),
    )
    job = YearJob(
        scene,
        find_blinds(options, converted.objects),
        find_places(options, scene, converted.objects),
        year,
        question,
        order,
        transport_of(options, settings),
        *find_maps(options, converted.objects),
    )
    with open_engine(options) as session, Bar("daylight") as bar:
        job.run(session, bar, keep_states(options, job))
    light, figures, maps = job.answer.light, job.answer.figures, job.answer.maps
    notes = (*notes, *job.answer.notes)
    write(options, job.answer, job.places, question, assumptions.lines_of(report, notes))
    traced = light.opened.coefficients
    shortfall = order.rule.shortfall(traced.error_of_even_world())
    assumptions.tell(report, notes, shortfall)
    say(sheet(str(options.file), describe(light, figures, question)))
    say(f"{light.sensors} sensors, {traced.samples} paths each, written to {options.output}")
    if maps is not None:
        lumels = sum(each.lumels for each in maps.objects)
        say(
            f"maps of {len(maps.objects)} objects with {lumels} lumels, written to {options.output / MAPS}"
        )
    return assumptions.exit_code(report, options.accept_missing, shortfall)


def _ask(options, weather):
    """What is asked of the year, and what is assumed for it."""
    from ...engine.daylight.en17037 import check_date
    from ...engine.daylight.occupancy import EVERY_DAY, WORKDAYS, Schedule, occupied_hours
    from ...engine.daylight.study import Question
    from ...engine.daylight.sunlight import make_day

    notes = []
    place = weather.place if options.zone is None else replace(weather.place, zone=options.zone)
    if options.zone is None:
        notes.append(
            f"hours are those of {place.zone}, without daylight saving time; --zone tells the clocks that people live by"
        )
    least = options.least_sun
    if least is None:
        least = 10.0
        notes.append(
            "the sun of the day counts from 10 degrees on, as --least-sun does not tell EN 17037's number for the place"
        )
    try:
        day = date(2001, *options.sun_day)
    except ValueError:
        raise SceneError(
            f"there is no day {options.sun_day[0]:02d}-{options.sun_day[1]:02d}"
        ) from None
    check_date(day)
    schedule = Schedule(*options.hours, WORKDAYS if options.workdays else EVERY_DAY)
    # A schedule that is none is refused before anything is computed.
    occupied_hours([0.0], place.zone, schedule)
    return Question(
        options.zone,
        schedule,
        options.target,
        is_from_above=options.roof,
        ground_reflectance=options.ground,
        day=make_day(day, place, least, SUNLIGHT_STEP),
        blinds=find_rules(options),
    ), notes
