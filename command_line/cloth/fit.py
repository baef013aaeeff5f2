"""The command ``lumenray cloth fit``: a screen by what its data sheet states."""

import json

from ..options import share, whole
from ..output import add_output, check_free, percent, say, table


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    fit = tasks.add_parser(
        "fit", help="find a screen by openness, transmittance and reflectance of a data sheet"
    )
    for name in ("openness", "transmittance", "reflectance"):
        fit.add_argument(
            f"--{name}",
            type=share(0.0),
            required=True,
            metavar="SHARE",
            help="visible, of light along the normal"
            if name != "openness"
            else "share of openings",
        )
    fit.add_argument("--name", default="Screen of a data sheet", help="of the cloth")
    fit.add_argument(
        "--seed", type=whole(0), default=0, metavar="N", help="of the rays (default: 0)"
    )
    add_output(fit, "OUT.json", "composition to write, for 'cloth compute'")
    fit.set_defaults(run=run)


def run(options) -> int:
    """Find a screen; return the exit code."""
    from ...engine.reading.whole_file import write_whole
    from ...engine.transport import backend

    check_free(options, options.output)
    backend.start(spectral=False)
    # Its arrays are of the variant that has been started.
    from ...engine.cloth.sheet_fit import fit_sheet

    stated = [getattr(options, name) for name in ("openness", "transmittance", "reflectance")]
    made = fit_sheet(*stated, options.name, seed=options.seed)
    with write_whole(options.output) as file:
        file.write((json.dumps(made.content, indent=2) + "\n").encode())
    rows = [("light along the normal", "stated", "found", "standard error")]
    rows += [
        ("openness", percent(stated[0]), percent(made.openness), ""),
        (
            "transmittance",
            percent(stated[1]),
            percent(made.transmittance),
            percent(made.error, ".1g"),
        ),
        ("reflectance", percent(stated[2]), percent(made.reflectance), percent(made.error, ".1g")),
    ]
    say(table(rows))
    say(
        "assumed: a plain weave of grey yarns, both alike; colours and the cut-off angle are not stated by these"
    )
    say(f"written to {options.output}")
    return 0
