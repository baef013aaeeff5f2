"""The command ``lumenray luminaire plot``: the polar diagram of a photometric file."""

from pathlib import Path

from ..options import size
from ..output import add_picture, check_free, save_picture

SMALLEST_PICTURE, LARGEST_PICTURE = 96, 4096
"""Sides of a diagram. [pixel]"""


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    plot = tasks.add_parser("plot", help="draw the polar diagram")
    plot.add_argument("file", type=Path, metavar="FILE", help="photometric file")
    add_picture(plot)
    plot.add_argument(
        "--kind",
        choices=("auto", "polar", "cartesian"),
        default="auto",
        help="kind of diagram (default: cartesian for narrow beams, else polar)",
    )
    plot.add_argument("--per-klm", action="store_true", help="in cd for 1000 lm instead of cd")
    plot.add_argument(
        "--size",
        type=size(SMALLEST_PICTURE, LARGEST_PICTURE),
        default=(512, 512),
        metavar="WxH",
        help="default: 512x512",
    )
    plot.set_defaults(run=run)


def run(options) -> int:
    """Draw a file; return the exit code."""
    from ...engine.analysis.polar_diagram import draw_polar_diagram
    from ...engine.luminaires.formats.reader import read_luminaire

    check_free(options, options.output)
    file = read_luminaire(options.file)
    picture = draw_polar_diagram(file, options.size, options.dark, options.kind, options.per_klm)
    save_picture(picture, options.output)
    return 0
