"""The command ``lumenray rayset plot``: starting points, luminances and intensities of a ray file."""

from pathlib import Path

from ..options import whole
from ..output import add_picture, check_free, save_picture
from ..progress import Bar
from .file import add_assumptions, open_rayset, reduce_pieces, survey_light

LARGEST_PICTURE = 2048
"""Longest side of a panel. [pixel]"""


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    plot = tasks.add_parser("plot", help="draw starting points, luminances and intensities")
    plot.add_argument("file", type=Path, metavar="FILE", help="ray file")
    add_picture(plot)
    plot.add_argument(
        "--size",
        type=whole(64, LARGEST_PICTURE),
        default=512,
        metavar="N",
        help="side of a panel (default: 512)",
    )
    add_assumptions(plot)
    plot.set_defaults(run=run)


def run(options) -> int:
    """Draw a file; return the exit code."""
    from ...engine.analysis.rayset_picture import draw_rayset
    from ...engine.raysets.reduction import to_luminaire, view_rays

    check_free(options, options.output)
    file = open_rayset(options, options.file)
    with Bar(str(options.file)) as bar:
        survey, light = survey_light(file, bar)
        pieces = list(light.pieces())
    reduced = reduce_pieces([(direction, flux) for _, direction, flux in pieces])
    low, high = survey.bounds
    extent = max(float((high - low).max()), 1e-6)
    image = view_rays(pieces, (0.0, 0.0, 1.0), 0.5 * (low + high), 1.2 * extent)
    sides = tuple(float(side) for side in high - low)
    position, direction, _ = pieces[0]
    title = f"{options.file.name}: {survey.rays:,} rays".replace(",", " ")
    if survey.luminous_flux is not None:
        title += f", {survey.luminous_flux:.4g} lm"
    picture = draw_rayset(
        position,
        direction,
        image,
        to_luminaire(reduced, sides, {}),
        title,
        options.size,
        options.dark,
    )
    save_picture(picture, options.output)
    return 0
