"""The command ``lumenray brdf plot``: cuts in the plane of incidence, or totals by angle."""

import argparse
import math
from pathlib import Path

from ...engine.errors import FileFormatError
from ..options import real, whole
from ..output import add_picture, check_free, save_picture
from .file import add_tolerance, open_scattering

LARGEST_PICTURE = 4096


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    plot = tasks.add_parser("plot", help="draw cuts in the plane of incidence, or totals by angle")
    plot.add_argument("file", type=Path, metavar="FILE", help="scattering file")
    add_picture(plot)
    plot.add_argument(
        "--totals", action="store_true", help="reflectance and transmittance by angle"
    )
    plot.add_argument(
        "--side", choices=("front", "back"), default="front", help="that light comes to"
    )
    plot.add_argument(
        "--incidences",
        type=_angles,
        default=(0.0, 15.0, 30.0, 45.0, 60.0, 75.0),
        metavar="DEG,DEG",
        help="of the cuts (default: 0,15,30,45,60,75)",
    )
    plot.add_argument(
        "--rotation",
        type=real(-360.0, 360.0),
        default=0.0,
        metavar="DEG",
        help="azimuth of incidence",
    )
    plot.add_argument(
        "--size",
        type=whole(240, LARGEST_PICTURE),
        default=800,
        metavar="N",
        help="width (default: 800)",
    )
    add_tolerance(plot)
    plot.set_defaults(run=run)


def _angles(text: str) -> tuple[float, ...]:
    try:
        angles = tuple(float(part) for part in text.split(","))
    except ValueError:
        angles = ()
    if not 1 <= len(angles) <= 12 or not all(0.0 <= angle < 90.0 for angle in angles):
        raise argparse.ArgumentTypeError(
            f"expected up to twelve angles from 0 to below 90, such as 0,30,60, found '{text}'"
        )
    return angles


def run(options) -> int:
    """Draw a file; return the exit code."""
    from ...engine.analysis.scattering_picture import draw_albedo_chart, draw_polar_cuts

    check_free(options, options.output)
    file = open_scattering(options, options.file)
    size = (options.size, options.size * 3 // 4)
    if options.totals:
        picture = draw_albedo_chart(file, size=size, dark=options.dark)
    else:
        if not any(side.startswith(options.side) for side in file.sides):
            raise FileFormatError(
                options.file, f"has no data for light that comes to the {options.side}"
            )
        picture = draw_polar_cuts(
            file,
            options.incidences,
            options.side,
            size=size,
            dark=options.dark,
            rotation=math.radians(options.rotation),
        )
    save_picture(picture, options.output)
    return 0
