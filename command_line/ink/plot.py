"""The command ``lumenray ink plot``: the spectrum and the colour of a pigment layer."""

from ..options import whole
from ..output import add_picture, check_free, save_picture
from .job import add_job, solve

LARGEST_PICTURE = 4096


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    plot = tasks.add_parser("plot", help="draw the spectrum and colour of a pigment layer")
    add_job(plot)
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
    """Draw a pigment layer; return the exit code."""
    from ...engine.analysis.ink_picture import draw_ink

    check_free(options, options.output)
    size = options.size, options.size * 3 // 4
    save_picture(draw_ink(solve(options), size, options.dark), options.output)
    return 0
