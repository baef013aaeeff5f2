"""The command ``lumenray sky plot``: the luminances of a sky in false colours, with the ways of the sun."""

from pathlib import Path

from ...engine.errors import SceneError
from ..luminaire.plot import LARGEST_PICTURE, SMALLEST_PICTURE
from ..options import real, size, stretch, whole
from ..output import add_picture, check_free, save_picture, say
from .place import add_place, find_moment, find_place, find_record

YEAR = 2001
"""In which the sun goes where no time is told."""


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    plot = tasks.add_parser("plot", help="draw a sky's luminances and the ways of the sun")
    add_place(plot)
    kind = plot.add_argument_group(
        "sky (default: that of the weather file's hour)"
    ).add_mutually_exclusive_group()
    kind.add_argument(
        "--cie", type=whole(1, 16), metavar="N", help="type of the CIE, 1 to 15, or 16 for overcast"
    )
    kind.add_argument(
        "--cloudiness", type=real(0.0, 1.0), metavar="K", help="between clear, 0, and overcast, 1"
    )
    kind.add_argument(
        "--measured",
        type=Path,
        metavar="FILE",
        help="luminances of 145 patches, or of elevations and azimuths, in cd/m2",
    )
    kind.add_argument(
        "--mean",
        type=stretch,
        metavar="HOURS",
        help="mean of the weather file over hours of its standard time, with the sun's ways: months=4-9,hours=9-17",
    )
    plot.add_argument(
        "--illuminance",
        type=real(),
        metavar="LX",
        help="horizontal, by the sky alone, of --cie and --cloudiness (default: usual for the sun's height)",
    )
    add_picture(plot)
    plot.add_argument(
        "--size",
        type=size(SMALLEST_PICTURE, LARGEST_PICTURE),
        default=(640, 640),
        metavar="WxH",
        help="default: 640x640",
    )
    plot.set_defaults(run=run)


def run(options) -> int:
    """Draw a sky; return the exit code."""
    from ...engine.analysis.sky_picture import ShownSun, draw_sky
    from ...engine.sky.solar_position import find_sun
    from ...engine.sky.weather_file import read_weather

    check_free(options, options.output)
    weather = None if options.weather is None else read_weather(options.weather)
    is_chosen = any(
        each is not None
        for each in (options.cie, options.cloudiness, options.measured, options.mean)
    )
    if options.mean is not None and weather is None:
        raise SceneError("expected --weather, whose hours the mean is of")
    if weather is None and not is_chosen:
        raise SceneError("expected a sky: --cie, --cloudiness, --measured or --weather with --time")
    place = find_place(options, weather)
    if place is None and (options.time is not None or options.measured is None):
        raise SceneError("expected a place: --place, --latitude with --longitude, or --weather")
    moment = None if place is None else find_moment(options, place)
    if moment is None and options.measured is None and options.mean is None:
        raise SceneError("expected --time, such as 2026-06-21T12:00")
    sun = None
    if moment is not None:
        if moment.note:
            say(moment.note)
        found = find_sun(moment.seconds, place)
        sun = ShownSun(float(found.elevation), float(found.azimuth))
    if options.mean is not None:
        luminances, words = _mean(weather, options.mean, moment)
    elif options.measured is not None:
        luminances, words = _measured(options.measured)
    elif is_chosen:
        luminances, words = _by_formula(options, sun)
    else:
        luminances, words, sun = _of_weather(weather, moment)
    title = options.measured.name if place is None else _title(place, moment)
    year = YEAR if moment is None else moment.clock.year
    picture = draw_sky(
        luminances, title, words, sun, place, year, size=options.size, dark=options.dark
    )
    save_picture(picture, options.output)
    return 0


def _title(place, moment) -> str:
    name = place.name or f"{place.latitude:g}, {place.longitude:g}"
    return (
        name
        if moment is None
        else f"{name}, {moment.clock:%Y-%m-%d %H:%M} ({moment.clock.tzname()})"
    )


def _measured(path):
    from ...engine.sky.measured import SkyGrid, find_luminances, read_measured_sky

    measured = read_measured_sky(path)
    words = "measured on a grid" if isinstance(measured, SkyGrid) else "measured, 145 patches"
    return (lambda directions: find_luminances(measured, directions)), words


def _mean(weather, hours: dict, moment):
    from ...engine.sky.clock_range import ClockRange
    from ...engine.sky.measured import look_up
    from ...engine.sky.weather_mean import find_weather_mean, make_mean_world

    year = YEAR if moment is None else moment.clock.year
    mean = find_weather_mean(weather, year, ClockRange(**hours))
    if mean.note:
        say(mean.note)
    world = make_mean_world(mean)
    words = (
        f"mean of {mean.hours:g} hours ({mean.label}): sky {mean.diffuse_horizontal:.0f} lx, sun "
        f"{mean.direct_horizontal:.0f} lx horizontal"
    )
    return (lambda directions: look_up(world, directions)), words


def _by_formula(options, sun):
    import numpy as np

    from ...engine.scene.light import CieSky, CloudySky
    from ...engine.sky.availability import condition_of_type, usual_illuminance
    from ...engine.sky.cie import sun_direction

    height = max(sun.elevation, 0.0)
    towards = sun_direction(np.radians(height), np.radians(sun.azimuth))
    if options.cie is not None:
        usual = usual_illuminance(condition_of_type(options.cie), sun.elevation)
        illuminance = options.illuminance or usual
        sky = CieSky(options.cie, towards, illuminance)
        words = f"CIE type {options.cie}"
    else:
        clear, overcast = (usual_illuminance(each, sun.elevation) for each in ("clear", "overcast"))
        usual = (1.0 - options.cloudiness) * clear + options.cloudiness * overcast
        illuminance = options.illuminance or usual
        sky = CloudySky(options.cloudiness, towards, illuminance)
        words = f"cloudiness {options.cloudiness:g}"
    if not illuminance > 0.0:
        raise SceneError(
            f"the sun is {-sun.elevation:.1f} degrees below the horizon, so the sky is dark unless --illuminance is given"
        )
    return _formula(sky), f"{words}, {illuminance:.0f} lx horizontal"


def _of_weather(weather, moment):
    import numpy as np

    from ...engine.analysis.sky_picture import ShownSun
    from ...engine.sky.hour import find_daylight_hours, make_hour
    from ...engine.sky.weather import find_hours, find_middles

    year = moment.clock.year
    index = find_record(weather, find_middles(weather, year), moment.seconds)
    if index is None:
        raise SceneError(f"the weather file has no record of {moment.clock:%H:%M on %Y-%m-%d}")
    hours = find_hours(weather, year)
    daylight = find_daylight_hours(weather, hours)
    sky, _ = make_hour(hours, daylight, index)
    if sky is None:
        illuminance = daylight.diffuse_horizontal[index]
        why = "is not known" if np.isnan(illuminance) else "is 0"
        raise SceneError(
            f"the sky's light in line {int(weather.line[index])} of the weather file {why}"
        )
    sun = ShownSun(float(hours.sun.elevation[index]), float(hours.sun.azimuth[index]))
    words = (
        f"weather file, line {int(weather.line[index])}: sky {sky.illuminance:.0f} lx horizontal, sun "
        f"{daylight.direct_normal[index]:.0f} lx normal"
    )
    return _formula(sky), words, sun


def _formula(sky):
    from ...engine.sky.skies import check_sky, find_luminances

    check_sky(sky)
    return lambda directions: find_luminances(sky, directions)
