"""The command ``lumenray paint plot``: the colours of a paint by angle."""

from ..options import whole
from ..output import add_picture, check_free, save_picture
from .file import add_file, open_paint

LARGEST_PICTURE = 4096


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    plot = tasks.add_parser("plot", help="draw the colours of a paint by angle")
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
    """Draw a paint; return the exit code."""
    from ...engine.analysis.paint_picture import draw_paint
    from ...engine.paint.solution import solve

    check_free(options, options.output)
    picture = draw_paint(
        solve(open_paint(options)), (options.size, options.size * 3 // 4), options.dark
    )
    save_picture(picture, options.output)
    return 0
