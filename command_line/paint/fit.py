"""The command ``lumenray paint fit``: numbers of a composition from what a paint reflects."""

import argparse
import json
from pathlib import Path

from ..options import real, whole
from ..output import add_force, check_free, rounded, say, say_json, table
from .file import add_file, open_paint, path_of


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    fit = tasks.add_parser("fit", help="find numbers of a composition from colours or a BRDF")
    add_file(fit)
    source = fit.add_mutually_exclusive_group(required=True)
    source.add_argument(
        "--lab",
        type=Path,
        metavar="FILE.csv",
        help="colours: lines of aspecular angle in degrees, L*, a*, b* (D65, 10 degrees, light from 45 degrees)",
    )
    source.add_argument("--brdf", type=Path, metavar="FILE", help="file of a measured material")
    fit.add_argument(
        "--error",
        type=real(),
        metavar="E",
        help="standard error of each reading: of colours in their unit (default: 0.3), of a BRDF relative (default: 0.05)",
    )
    fit.add_argument(
        "--look-for",
        type=_parameter,
        action="append",
        metavar="PLACE:LOW:HIGH",
        help="a number to find and its bounds (may be repeated; default: amounts, tilts and cores)",
    )
    fit.add_argument(
        "--seed", type=whole(0), default=0, metavar="N", help="of the starts (default: 0)"
    )
    fit.add_argument(
        "-o", "--output", type=Path, required=True, metavar="OUT.json", help="composition to write"
    )
    add_force(fit)
    fit.add_argument("--json", action="store_true", help="numbers as JSON")
    fit.set_defaults(run=run)


def _parameter(text: str):
    from ...engine.paint.fitting import Parameter

    place, *bounds = text.split(":")
    try:
        low, high = (float(bound) for bound in bounds)
    except ValueError:
        low = high = 0.0
    if not 0.0 < low < high < 1e6:
        raise argparse.ArgumentTypeError(
            f"expected a place with bounds above 0, such as layers/0/thickness_um:5:50, found '{text}'"
        )
    return Parameter(place.strip("/"), low, high)


def run(options) -> int:
    """Fit a paint; return the exit code."""
    from ...engine.paint.fitting import fit_paint
    from ...engine.paint.measured import read_brdf, read_lab_file
    from ...engine.paint.reader import known_constituents
    from ...engine.reading.whole_file import write_whole

    check_free(options, options.output)
    start = open_paint(options)
    if options.lab is not None:
        readings = read_lab_file(options.lab, options.error or 0.3)
    else:
        readings = read_brdf(options.brdf, options.error or 0.05)
    found = fit_paint(
        start.content,
        readings,
        options.look_for,
        known_constituents(options.constituents),
        options.seed,
        path=path_of(options.file),
    )
    with write_whole(options.output) as stream:
        stream.write(json.dumps(rounded(found.content), indent=2).encode() + b"\n")
    places = [each.place for each in found.parameters]
    if options.json:
        say_json(
            rounded(
                {
                    "residual": found.residual,
                    "readings": found.readings,
                    "paints_solved": found.calls,
                    "values": dict(zip(places, found.values, strict=True)),
                    "standard_errors": dict(zip(places, found.errors, strict=True)),
                    "correlations": found.correlations,
                    "at_bounds": found.at_bounds,
                    "seed": options.seed,
                }
            )
        )
        return 0
    rows = [("number", "value", "standard error")]
    rows += [
        (place, f"{value:.5g}", f"{error:.2g}")
        for place, value, error in zip(places, found.values, found.errors, strict=True)
    ]
    say(table(rows))
    for i, first in enumerate(places):
        for k in range(i):
            if abs(found.correlations[i, k]) > 0.8:
                say(
                    f"{first} and {places[k]} go together: correlation {found.correlations[i, k]:+.2f}"
                )
    for place in found.at_bounds:
        say(f"{place} ended at a bound")
    say(
        f"left over: {found.residual:.2g} standard errors of the readings (root mean square of {found.readings}); "
        f"{found.calls} paints solved"
    )
    say(f"written to {options.output}")
    return 0
