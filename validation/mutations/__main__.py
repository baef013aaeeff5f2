"""Mutation check: faults of physics are put into the engine one at a time, and the quick subset has to find each.

Run it with ``python -m lumenray.validation.mutations``; exit code 1 says that a fault was not found.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from .catalogue import MUTATIONS
from .table import PROGRAM, compose_table
from .trials import BrokenOffError, run

FOLDER = Path("docs/validation")
"""Where the table belongs."""

FILE = "mutations.md"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the check as a command."""
    names = [mutation.name for mutation in MUTATIONS]
    parser = argparse.ArgumentParser(prog=PROGRAM, description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--only", action="append", default=[], metavar="NAME", choices=names, help=", ".join(names)
    )
    parser.add_argument(
        "--all", action="store_true", help="run all groups, not only until one fails"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help=f"folder for the table (default: {FOLDER}, with --only none)",
    )
    options = parser.parse_args(arguments)
    chosen = [m for m in MUTATIONS if not options.only or m.name in options.only]
    try:
        outcomes = run(chosen, options.all, _say)
    except BrokenOffError as error:
        _say(f"mutations: {error}")
        return 1
    folder = options.output or (None if options.only else FOLDER)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / FILE
        path.write_text(compose_table(outcomes, options.all), encoding="utf-8")
        _say(f"written to {path}")
    survivors = [outcome.mutation.name for outcome in outcomes if not outcome.is_caught]
    _say(f"{len(outcomes) - len(survivors)} of {len(outcomes)} faults are caught")
    return int(bool(survivors))


def _say(line: str) -> None:
    sys.stderr.write(line + "\n")
    sys.stderr.flush()


if __name__ == "__main__":
    sys.exit(main())
