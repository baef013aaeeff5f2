"""The command ``lumenray validate``: the validation suite on this machine, and its report."""

import sys
from pathlib import Path

from ..engine.errors import LumenrayError
from .options import share, whole, words
from .output import add_force, check_free, say

EPILOG = """examples:
  lumenray validate
  lumenray validate --family daylight --error 0.3%
  lumenray validate --family C05,C10 --peers -o out/areas

Exit code 1 says that a scored group breaks a pass rule, or that the same seed gives other numbers.
"""

REPORT_FOLDER = Path("docs/validation")
"""Where the report of the whole suite belongs."""


def add_command(commands) -> None:
    """Describe the command; ``commands`` are argparse's sub-parsers."""
    validate = commands.add_parser(
        "validate",
        help="compare with independent reference values and write the report",
        epilog=EPILOG,
    )
    validate.add_argument(
        "--family",
        type=words,
        default=(),
        metavar="F",
        help="only these: direct, photometry, glass, interreflection, daylight, specular, stability, "
        "spectral, glare, or cases such as C05; several with commas (default: all)",
    )
    validate.add_argument(
        "--error",
        type=share(),
        metavar="E",
        help="relative standard error of every value (default: what the tolerances need)",
    )
    validate.add_argument(
        "--peers", action="store_true", help="ask Radiance and Cycles too, where they can answer"
    )
    validate.add_argument("--quick", action="store_true", help="only the quick subset")
    validate.add_argument("--seed", type=whole(0), default=1, metavar="N", help="default: 1")
    validate.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help=f"folder for the report and validation.json (default: {REPORT_FOLDER}, "
        "for a part of the suite out/validation)",
    )
    add_force(validate)
    validate.set_defaults(run=run)


def run(options) -> int:
    """Run the suite, write the report and tell the counts; 1 if a scored group or a seed check fails."""
    try:
        from ..validation import outcome, report, runner
        from ..validation.cells import OUTCOME
    except ImportError:
        raise LumenrayError(
            "this installation has no validation suite; it comes with Lumenray's source code"
        ) from None
    check_free(options, options.output and options.output / OUTCOME)
    wanted = options.family
    try:
        cases = runner.choose_cases(wanted, options.quick)
    except KeyError as error:
        raise LumenrayError(
            f"the suite has no family or case {error.args[0]}; "
            f"families are {', '.join(runner.families())}"
        ) from None
    made = runner.run(
        cases,
        is_quick=options.quick,
        peers=runner.peer_makers() if options.peers else (),
        seed=options.seed,
        error=options.error,
        say=lambda line: say(line, sys.stderr),
    )
    is_part = options.quick or wanted
    folder = options.output or (Path("out/validation") if is_part else REPORT_FOLDER)
    outcome.write_outcome(outcome.compose_outcome(made), folder / OUTCOME)
    report.write_report(made, folder)
    say(f"{outcome.tell(made)}\nwritten to {folder}")
    return int(bool(made.failed) or not all(check.passes for check in made.determinism))
