"""The command ``lumenray mix``: lux maps with the light groups of a bake at other levels, without computing."""

import argparse
import math
from pathlib import Path

from ..engine.errors import FileFormatError
from .options import level
from .output import add_output, check_free, name_cell, say, table


def add_command(commands) -> None:
    """Describe the command to argparse."""
    parser = commands.add_parser(
        "mix", help="lux maps with the light groups of a bake dimmed or switched, without computing"
    )
    parser.add_argument("folder", type=Path, metavar="DIR", help="of a bake with --layers")
    parser.add_argument(
        "--mix",
        type=level,
        action="append",
        required=True,
        metavar="NAME=FACTOR",
        help="factor on the flux of a light group, such as Ceiling=0.5 or Ceiling=off; may be repeated",
    )
    add_output(parser, "OUT", "folder to write the pages and mix.json into")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Add up the layers of a bake; return the exit code."""
    from ..engine.baking.mixed_maps import NOTE, mix_maps
    from ..engine.light_mix import Level, LightMix

    if options.output.is_file():
        raise FileFormatError(options.output, "is a file, expected a folder to write into")
    if options.output.resolve() == options.folder.resolve():
        raise FileFormatError(options.output, "is the bake itself, expected another folder")
    check_free(options, *options.output.glob("illuminance*.exr"), options.output / "mix.json")
    levels = LightMix(
        tuple(Level(name, factor, is_on=factor > 0.0) for name, factor in options.mix)
    )
    made, _ = mix_maps(options.folder, levels, options.output)
    rows = [("object", "mean", "error at most", "minimum", "maximum", "U0", "mean of the bake")]
    for each in made:
        error = "-" if math.isnan(each.mean_error) else f"{each.mean_error:.2g} lx"
        values = (f"{value:.4g} lx" for value in (each.least, each.largest))
        rows.append(
            (
                name_cell(each.name),
                f"{each.mean:.4g} lx",
                error,
                *values,
                f"{each.uniformity:.3f}",
                f"{each.before:.4g} lx",
            )
        )
    say(table(rows))
    say(NOTE)
    say(f"written to {options.output}")
    return 0
