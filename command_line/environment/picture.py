"""Which picture, how bright it is and what makes a bright source: options of the commands, and what they come to."""

import argparse
from functools import partial
from pathlib import Path

from ...engine.errors import SceneError
from ..options import real


def add_map(parser) -> None:
    """Let a command be about a picture, its scale and its sources."""
    parser.add_argument(
        "file", type=Path, metavar="MAP", help="equirectangular picture, .hdr or .exr"
    )
    scale = parser.add_argument_group("scale (default: Radiance's 179 lm/W)")
    level = scale.add_mutually_exclusive_group()
    level.add_argument(
        "--white", type=real(), metavar="CD", help="luminance of a pixel of 1, in cd/m2"
    )
    level.add_argument(
        "--lux", type=real(), metavar="LX", help="illuminance that was measured where it was taken"
    )
    scale.add_argument(
        "--facing",
        type=read_angles,
        metavar="EL,AZ",
        help="where the meter faced, in degrees (default: 90,0, straight up)",
    )
    scale.add_argument(
        "--factor", type=real(), default=1.0, metavar="F", help="multiplies all of it (default: 1)"
    )
    sources = parser.add_argument_group("bright sources")
    sources.add_argument(
        "--source",
        type=real(1.0),
        metavar="F",
        help="luminance over the mean that makes one (default: 20)",
    )
    sources.add_argument(
        "--edge", type=real(1.0), metavar="F", help="that belongs to one (default: 10)"
    )
    sources.add_argument(
        "--radius",
        type=real(0.01, 45.0),
        metavar="DEG",
        help="largest radius in degrees (default: 3)",
    )
    sources.add_argument("--lower", action="store_true", help="look below the horizon too")
    sources.add_argument(
        "--sun",
        choices=("auto", "brightest", "none"),
        default="auto",
        help="which source is the sun (default: auto, a small one that gives far most light)",
    )


def read_angles(text: str) -> tuple[float, float]:
    """Read two angles. [degree]"""
    return _read_pair(text, "an elevation and an azimuth in degrees such as 45,120")


def read_pixel(text: str) -> tuple[float, float]:
    """Read a place in a picture. [pixel]"""
    return _read_pair(text, "a pixel from the left and from the top such as 812,140")


def _read_pair(text: str, expected: str) -> tuple[float, float]:
    try:
        first, second = (float(each) for each in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected {expected}, found '{text}'") from None
    return first, second


def find_coefficients(options):
    """Return what makes a bright source, as asked for."""
    import numpy as np

    from ...engine.environment.sources import EDGE, RADIUS, SOURCE, Coefficients

    source = SOURCE if options.source is None else options.source
    edge = min(EDGE, source) if options.edge is None else options.edge
    radius = RADIUS if options.radius is None else float(np.radians(options.radius))
    return Coefficients(source, radius, edge, not options.lower)


def find_per_unit(options, image, lights=()) -> float:
    """Return the luminance of a value of 1 as asked for; ``lights``: as of `find_scale`. [cd/m2]"""
    import numpy as np

    from ...engine.environment.scale import UPWARDS, Scale, find_scale
    from ...engine.photometry.units import RADIANCE_EFFICACY
    from ...engine.sky.cie import sun_direction

    if options.facing is not None and options.lux is None:
        raise SceneError("--facing needs --lux: it says where the meter faced")
    facing = UPWARDS
    if options.facing is not None:
        facing = tuple(float(each) for each in sun_direction(*np.radians(options.facing)))
    white = RADIANCE_EFFICACY if options.white is None else options.white
    return find_scale(Scale(white, options.lux, facing, options.factor), image, lights)


def sun_chooser(options):
    """Return a function from a `Search` and the upward direction to the sun that was asked for."""
    from ...engine.environment.repair import find_sun_of

    if options.sun == "auto":
        return find_sun_of
    return partial(_choose, options.sun == "brightest")


def _choose(is_brightest: bool, search, up):
    if is_brightest and search.sources and search.sources[0].on(up) > 0.0:
        return search.sources[0]
    return None
