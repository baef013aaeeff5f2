"""What commands write: lines, sheets, tables and JSON on the terminal, complaints beside it, and pictures."""

import json
import math
import sys
from pathlib import Path

from ..engine.errors import FileFormatError
from ..engine.reading.printable import printable

LABEL = 20
"""Room for the labels of a sheet. [character]"""


def say(text: str, stream=None) -> None:
    """Write to the terminal, with question marks for what it cannot show, and no commands to it from a file."""
    stream = sys.stdout if stream is None else stream
    encoding = stream.encoding or "utf-8"
    stream.write(printable(text).encode(encoding, "replace").decode(encoding) + "\n")
    stream.flush()


def complain(text) -> None:
    """Write one line on standard error."""
    say("lumenray: " + " ".join(str(text).splitlines()), sys.stderr)


def say_json(value) -> None:
    """Write JSON that any program reads."""
    say(json.dumps(value, indent=2, allow_nan=False))


def rounded(value):
    """Return a value for JSON: numbers to seven digits, None for what is no number, lists for arrays and tuples."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [rounded(item) for item in value]
    if isinstance(value, float):
        return float(f"{value:.7g}") if math.isfinite(value) else None
    return value


def percent(share: float, form: str = ".3g") -> str:
    """Return a share in per cent, with the sign: the form of every share in a text."""
    return f"{100.0 * share:{form}} %"


def sheet(title: str, entries) -> str:
    """Return a title with labelled lines below it.

    Parameters
    ----------
    title : str
    entries : iterable of (str, str or iterable of str or None)    Label, and one or several lines; empty ones are left out.
    """
    lines = [title]
    for label, texts in entries:
        shown = [texts] if isinstance(texts, str) else texts or []
        for i, text in enumerate(filter(None, shown)):
            lines.append(f"  {'' if i else label:<{LABEL}}{text}")
    return "\n".join(lines)


def remarks(row: dict) -> list:
    """Return the entries of a sheet that tell of ``metadata`` and ``warnings``."""
    told = [
        f"{key}: {' / '.join(text.splitlines())}" for key, text in row.get("metadata", {}).items()
    ]
    return [("metadata", told), ("warnings", row["warnings"])]


def table(rows) -> str:
    """Return rows of texts, the heading first, as lines: the first column left, the others right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(
        "  ".join(
            f"{cell:{'>' if i else '<'}{width}}"
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    )


def name_cell(name: str) -> str:
    """Return a name of a scene as it may stand in a line of a table."""
    return " ".join(printable(name).expandtabs(1).splitlines())


def add_force(parser) -> None:
    """Let a command replace files."""
    parser.add_argument("--force", action="store_true", help="replace files that are there")


def check_free(options, *paths: Path | None, remedy: str = "--force replaces it") -> None:
    """Refuse to write over a file, unless ``options.force`` is on; None stands for a file that is not written.

    Raises
    ------
    FileFormatError    One of them is there, is a folder, or would lie in what is none.
    """
    for path in filter(None, paths):
        above = next(parent for parent in path.absolute().parents if parent.exists())
        if not above.is_dir():
            raise FileFormatError(path, f"cannot be written ({above} is no folder)")
        if path.is_dir():
            raise FileFormatError(path, "is a folder, expected the name of a file to write")
        if not options.force and (path.exists() or path.is_symlink()):
            raise FileFormatError(path, f"is there already; {remedy}")


def add_output(parser, metavar: str, words: str) -> None:
    """Let a command be told where to write."""
    parser.add_argument("-o", "--output", required=True, type=Path, metavar=metavar, help=words)
    add_force(parser)


def add_picture(parser) -> None:
    """Let a command draw."""
    add_output(parser, "OUT.png", "picture to write")
    parser.add_argument("--dark", action="store_true", help="light lines on a dark ground")


def add_conversion(parser, source: str, target: str) -> None:
    """Let a command write a file of another one; ``source`` says what that is, ``target`` what is written."""
    parser.add_argument("file", type=Path, metavar="IN", help=source)
    parser.add_argument("output", type=Path, metavar="OUT", help=target)
    add_force(parser)


def save_picture(picture, path: Path) -> None:
    """Write a picture of Pillow and tell of it.

    Raises
    ------
    FileFormatError    It cannot be written.
    """
    from ..engine.analysis import canvas

    say(f"written to {canvas.save_picture(picture, path)}")
