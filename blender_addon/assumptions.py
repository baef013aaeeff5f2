"""What a run without a window took for granted: refused, told beside the numbers, or turned into an exit code."""

import sys

from ..engine.errors import SceneError
from ..engine.formats.report import find_remarks
from ..engine.reading.printable import printable
from .foundation.report import ConversionReport, Severity

UNREACHED = 3
"""Exit code where samples or time ended, or a bake was stopped, before what was wanted was reached."""

ASSUMED = 4
"""Exit code where something of the scene was left out, so that the numbers are those of another scene."""

CODES = f"""exit codes:
  0  done, as it was asked for
  1  failed, refused or cancelled; one line on standard error says why, and no results are written
  2  the command line is not understood
  {UNREACHED}  the results are written, but time or samples ended before the wanted error was reached, more samples do
     not lower it, or Ctrl-C stopped a bake before its end
  {ASSUMED}  the results are written, but the conversion report holds errors: something of the scene was left out; this
     code stands where {UNREACHED} would hold as well
"""

SHOWN = 8
"""Most rows of the conversion report below an error that are told on a terminal."""


def add_option(parser) -> None:
    """Let a command go on where files are missing."""
    parser.add_argument(
        "--accept-missing",
        action="store_true",
        help="go on without environment pictures, luminaire, ray, spectrum or material files that cannot be used; what is "
        "assumed instead is told beside the numbers (default: refuse)",
    )


def refuse_missing(report: ConversionReport, is_accepted: bool) -> None:
    """Refuse a scene that lacks files, unless that is accepted.

    Raises
    ------
    SceneError    Names the first of them.
    """
    missing = [row for row, _ in report.rows if row.is_missing]
    if not missing or is_accepted:
        return
    others = f" (and {len(missing) - 1} more)" if len(missing) > 1 else ""
    raise SceneError(
        f"{missing[0].text()}{others}; correct the scene, or go on like that with --accept-missing"
    )


def refuse_media(report: ConversionReport) -> None:
    """Refuse to compute illuminance in a scene with a volume that scatters light, or might.

    Raises
    ------
    SceneError    Names the first of them.
    """
    media = [row for row, _ in report.rows if row.is_medium]
    if media:
        raise SceneError(
            f"{media[0].text()}; illuminance cannot be computed beside such a volume: take it away or hide it"
        )


def lines_of(report: ConversionReport, notes=(), shortfall: str = "") -> list[str]:
    """Say in lines all that a reader of the numbers has to know, the worst first; notes that change little are left out."""
    return find_remarks(report.to_dicts(), notes, shortfall)


def tell(report: ConversionReport, notes=(), shortfall: str = "", stream=None) -> None:
    """Print what was assumed, on standard error if no other stream is given: all errors, and some of the rest."""
    stream = sys.stderr if stream is None else stream
    if shortfall:
        stream.write(f"goal: {printable(shortfall)}\n")
    for note in notes:
        stream.write(f"note: {printable(note)}\n")
    # Bakes note it in their report as well.
    rows = [(row, count) for row, count in report.by_weight if row.message != shortfall]
    if not rows:
        return
    errors = sum(row.severity is Severity.ERROR for row, _ in rows)
    shown = rows[: errors + SHOWN]
    rest = len(rows) - len(shown)
    stream.write(f"{len(rows)} things were not taken over as they are (all in the report):\n")
    for row, count in shown:
        stream.write(f"  {row.text()}{f' ({count} times)' if count > 1 else ''}\n")
    if rest:
        stream.write(f"  and {rest} more\n")
    stream.flush()


def exit_code(report: ConversionReport, is_accepted: bool, shortfall: str = "") -> int:
    """Return the exit code of a run whose results are written. Missing files count as agreed to where they are accepted."""
    errors = [row for row, _ in report.rows if row.severity is Severity.ERROR]
    if any(not (row.is_missing and is_accepted) for row in errors):
        return ASSUMED
    return UNREACHED if shortfall else 0
