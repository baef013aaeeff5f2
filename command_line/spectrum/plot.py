"""The command ``lumenray spectrum plot``: a spectrum drawn."""

from ..luminaire.plot import LARGEST_PICTURE, SMALLEST_PICTURE
from ..options import size
from ..output import add_picture, check_free, save_picture, say
from .info import add_column


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    plot = tasks.add_parser("plot", help="draw a spectrum")
    plot.add_argument("files", nargs=1, metavar="FILE", help="file of a spectrum")
    add_picture(plot)
    plot.add_argument(
        "--size",
        type=size(SMALLEST_PICTURE, LARGEST_PICTURE),
        default=(640, 480),
        metavar="WxH",
        help="default: 640x480",
    )
    add_column(plot)
    plot.set_defaults(run=run)


def run(options) -> int:
    """Draw a file; return the exit code."""
    from ...engine.analysis.spectrum_picture import draw_spectrum
    from ...engine.formats.spd import read_spectrum

    check_free(options, options.output)
    file = read_spectrum(options.files[0], options.column)
    for remark in file.remarks:
        say(f"{file.path}: {remark}")
    picture = draw_spectrum(file, options.size, options.dark)
    save_picture(picture, options.output)
    return 0
