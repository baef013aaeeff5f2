"""The command ``lumenray environment repair``: a picture whose sun gives the light that it has in such weather."""

import argparse
from datetime import date
from pathlib import Path

from ...engine.errors import SceneError
from ..options import real
from ..output import add_output, check_free, say
from ..sky.place import find_place
from .picture import add_map, find_coefficients, find_per_unit, read_pixel, sun_chooser


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    repair = tasks.add_parser("repair", help="write the picture with its sun mended")
    add_map(repair)
    add_output(repair, "OUT.exr", "mended picture to write")
    repair.add_argument(
        "--ratio",
        type=real(),
        metavar="R",
        help="horizontal illuminance of the sun over that of all else (default: 4, unless --sky is given)",
    )
    model = repair.add_argument_group("by the CIE's clear sky at a place and a date")
    model.add_argument(
        "--sky",
        type=read_pixel,
        metavar="X,Y",
        help="pixel of clear sky, by which the model is scaled",
    )
    model.add_argument("--place", metavar="CITY", help="city of the library, such as 'Berlin'")
    model.add_argument(
        "--cities",
        action="append",
        default=[],
        type=Path,
        metavar="LIST.csv",
        help="more cities for --place",
    )
    model.add_argument("--latitude", type=real(-90.0, 90.0), metavar="DEG", help="positive north")
    model.add_argument("--longitude", type=real(-180.0, 180.0), metavar="DEG", help="positive east")
    model.add_argument("--zone", metavar="ZONE", help="time zone, such as Europe/Berlin or UTC+1")
    model.add_argument(
        "--elevation", type=real(-500.0, 9000.0), metavar="M", help="above the sea in metres"
    )
    model.add_argument("--date", type=read_date, metavar="DATE", help="such as 2026-05-20")
    model.add_argument(
        "--half",
        choices=("morning", "afternoon"),
        default="morning",
        help="of the day; the sun stands as high twice (default: morning)",
    )
    model.add_argument(
        "--turbidity",
        type=real(1.0, 20.0),
        default=3.0,
        metavar="T",
        help="luminous turbidity (default: 3)",
    )
    repair.set_defaults(run=run)


def read_date(text: str) -> date:
    """Read a date."""
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"expected a date such as 2026-05-20, found '{text}'"
        ) from None


def run(options) -> int:
    """Mend a picture's sun; return the exit code."""
    import numpy as np

    from ...engine.environment.extraction import clip_sources, scale_sources
    from ...engine.environment.map_file import read_map, write_map
    from ...engine.environment.scale import UPWARDS
    from ...engine.environment.sources import find_sources
    from ...engine.scene.texture import ImageTexture
    from ...engine.sky.picture import find_illuminance

    check_free(options, options.output)
    _check(options)
    image, _ = read_map(options.file)
    coefficients = find_coefficients(options)
    search = find_sources(image, coefficients)
    sun = sun_chooser(options)(search, UPWARDS)
    if sun is None:
        raise SceneError(
            f"{options.file} shows no source that is likely the sun; --sun brightest takes the brightest one"
        )
    clipped = clip_sources(image, coefficients)
    if options.sky is None:
        factor, told = _by_sky(options, sun, search, clipped)
    else:
        factor, told = _by_model(options, sun, clipped)
    factors = [factor if source is sun else 1.0 for source in search.sources]
    pixels = scale_sources(image, search, factors)
    pixels.flags.writeable = False
    mended = ImageTexture(pixels)
    per_unit = find_per_unit(options, mended)
    before, after = (
        per_unit * find_illuminance(each, np.eye(3), np.array(UPWARDS)) for each in (image, mended)
    )
    for sentence in (*_tell_doubts(options, image, per_unit), *told):
        say(sentence)
    own = per_unit * sun.on(UPWARDS)
    say(f"sun, horizontal: {own:.5g} lx before, {own * factor:.5g} lx after")
    say(f"horizontal: {before:.5g} lx before, {after:.5g} lx after")
    say(f"written to {write_map(options.output, pixels)}")
    return 0


def _tell_doubts(options, image, per_unit: float) -> list[str]:
    """Sentences about whether it is a sun that is mended."""
    from ...engine.environment.analysis import analyse

    doubts = analyse(image, per_unit, find_coefficients(options), sun_chooser(options)).doubts
    return [f"lamp or sun? {', and '.join(doubts)}"] if doubts else []


def _check(options) -> None:
    """Refuse options that do not go together."""
    if options.sky is None:
        given = [
            name
            for name in ("place", "latitude", "longitude", "date")
            if getattr(options, name) is not None
        ]
        if given:
            raise SceneError(
                f"--{given[0]} needs --sky, a pixel of clear sky by which the model is scaled"
            )
        return
    if options.ratio is not None:
        raise SceneError("expected one of --ratio and --sky")
    if options.date is None:
        raise SceneError("--sky needs a place and --date")


def _by_sky(options, sun, search, clipped):
    """Factor of the sun's light, and nothing to say."""
    import numpy as np

    from ...engine.environment.repair import RATIO, sun_factor
    from ...engine.environment.scale import UPWARDS
    from ...engine.sky.picture import find_illuminance

    rest = find_illuminance(clipped, np.eye(3), np.array(UPWARDS))
    rest += sum(source.on(UPWARDS) for source in search.sources if source is not sun)
    ratio = RATIO if options.ratio is None else options.ratio
    return sun_factor(sun, rest, ratio), ()


def _by_model(options, sun, clipped):
    """Factor of the sun's light, and when the picture was taken."""
    import numpy as np

    from ...engine.environment.cells import direction_at
    from ...engine.environment.repair import (
        choose_time,
        find_north,
        find_times,
        find_tolerance,
        rebuild_sun,
        tell_times,
    )
    from ...engine.sky.solar_position import find_sun

    place = find_place(options)
    if place is None:
        raise SceneError("expected a place: --place, or --latitude with --longitude")
    height, width = clipped.pixels.shape[:2]
    x, y = options.sky
    if not (0.0 <= x < width and 0.0 <= y < height):
        raise SceneError(f"the pixel {x:g},{y:g} is not in the picture of {width} x {height}")
    elevation = float(np.degrees(np.arcsin(np.clip(sun.core[2], -1.0, 1.0))))
    day, tolerance = options.date, find_tolerance(height)
    times = find_times(elevation, place, day.year, day.month, day.day, tolerance=tolerance)
    chosen = choose_time(times, options.half == "morning")
    distance = float(find_sun(chosen.seconds, place).distance)
    towards = direction_at((x + 0.5) / width, 1.0 - (y + 0.5) / height)
    made = rebuild_sun(
        clipped,
        sun.core,
        towards,
        options.turbidity,
        distance,
        place.elevation,
        tolerance=tolerance,
    )
    told = (
        f"{place.name or 'place'}, {chosen.clock:%Y-%m-%d %H:%M} ({chosen.clock.tzname()}): the sun is "
        f"{elevation:.2f}° high",
        tell_times(chosen, tolerance),
        f"the picture's +Y lies {find_north(sun.core, chosen.azimuth) % 360.0:.1f}° from north over east",
        f"the model's sun gives {made.model:.5g} lx facing it, and a value of 1 is {made.scale:.4g} cd/m² by the model; "
        f"half a pixel of its height changes its light by {100.0 * made.spread:.1f} %",
    )
    return made.illuminance / sun.illuminance, told
