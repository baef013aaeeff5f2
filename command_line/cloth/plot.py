"""The command ``lumenray cloth plot``: what a cloth scatters in the plane of incidence."""

from ..options import whole
from ..output import add_picture, check_free, save_picture
from .file import add_file, compute_cloth

LARGEST_PICTURE = 4096


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    plot = tasks.add_parser("plot", help="draw what a cloth reflects and lets through by angle")
    add_file(plot)
    add_picture(plot)
    plot.add_argument(
        "--size",
        type=whole(240, LARGEST_PICTURE),
        default=800,
        metavar="N",
        help="width (default: 800)",
    )
    plot.set_defaults(run=run)


def run(options) -> int:
    """Draw a cloth; return the exit code."""
    from ...engine.analysis.scattering_picture import draw_polar_cuts

    check_free(options, options.output)
    woven = compute_cloth(options)
    picture = draw_polar_cuts(
        woven.file(),
        size=(options.size, options.size * 3 // 4),
        dark=options.dark,
        title=woven.cloth.name,
    )
    save_picture(picture, options.output)
    return 0
