"""Files that a command is told of by their names, by folders or by patterns, and what it tells of each."""

import fnmatch
import glob
import os
from pathlib import Path

from ..engine.errors import FileFormatError, LumenrayError
from .output import complain, rounded, say, say_json

MOST_ENTRIES = 200_000
"""Files and folders in a folder beyond which it is refused. [-]"""


def add_files(parser, what: str, example: str) -> None:
    """Let a command take several files, and write JSON."""
    parser.add_argument(
        "files",
        nargs="+",
        metavar="FILE",
        help=f"{what}, a folder of them, or a pattern such as '{example}'",
    )
    parser.add_argument("--json", action="store_true", help="a JSON list instead of text")


def tell_each(options, endings, describe, tell, is_good=lambda row: True) -> int:
    """Tell of every file; what is wrong with one is a line on standard error, and the others go on.

    Parameters
    ----------
    options : argparse.Namespace    With what `add_files` adds.
    endings : tuple of str    Of the names that are taken from a folder.
    describe : callable    From the name of a file to a row for JSON.
    tell : callable    From such a row, with numbers as in JSON, to text.
    is_good : callable    Whether a row speaks for its file.

    Returns
    -------
    int    Exit code: 1 if a file was refused, or is not good.
    """
    rows = []
    for name, error in find_files(options.files, endings):
        try:
            if error is not None:
                raise error
            row = {"file": name, **rounded(describe(name))}
        except LumenrayError as refusal:
            row = {"file": name, "error": str(refusal)}
            complain(refusal)
        else:
            if not options.json:
                say(tell(row) + "\n")
        rows.append(row)
    if options.json:
        say_json(rows)
    return int(any("error" in row or not is_good(row) for row in rows))


def find_files(names, endings):
    """Yield the files of names, folders and patterns, in order of their names, and what is wrong where none can be found.

    Links to folders in folders are not followed, hidden files and folders are left out. A name that is neither a folder nor
    a pattern of anything is yielded, so that its absence is told.

    Parameters
    ----------
    names : iterable of str
    endings : tuple of str    Of the names that are taken from folders, in small letters.

    Yields
    ------
    (str, FileFormatError or None)
    """
    for name in names:
        is_pattern = glob.has_magic(name) and not os.path.lexists(name)
        for path in _matching(name) if is_pattern else [name]:
            if isinstance(path, FileFormatError):
                yield path.path, path
            elif path and Path(path).is_dir():
                yield from _inside(path, endings)
            else:
                yield path, None


def _inside(folder: str, endings):
    """Yield the files of a folder as `find_files` does."""
    is_empty = True
    for path in _ordered(folder):
        if isinstance(path, FileFormatError):
            yield path.path, path
        elif path.lower().endswith(endings):
            yield path, None
        else:
            continue
        is_empty = False
    if is_empty:
        expected = ", ".join(endings)
        yield (
            folder,
            FileFormatError(folder, f"no such file in it, expected names ending {expected}"),
        )


def _matching(pattern: str) -> list:
    """Files and folders that a pattern stands for; itself if there is none."""
    parts = Path(pattern).parts
    if "**" not in parts:
        return sorted(glob.glob(pattern)) or [pattern]
    start = next(i for i, part in enumerate(parts) if glob.has_magic(part))
    found = [
        path if isinstance(path, FileFormatError) else str(Path(path))
        for path in _ordered(str(Path(*parts[:start])))
        if isinstance(path, FileFormatError) or _fits(Path(path).parts[start:], parts[start:])
    ]
    return found or [pattern]


def _fits(parts, pattern) -> bool:
    """Whether the parts of a path are what those of a pattern stand for; ``**`` stands for any number."""
    if not pattern:
        return not parts
    if pattern[0] == "**":
        return any(_fits(parts[i:], pattern[1:]) for i in range(len(parts) + 1))
    return bool(parts) and fnmatch.fnmatch(parts[0], pattern[0]) and _fits(parts[1:], pattern[1:])


def _ordered(folder: str) -> list:
    """Paths of the files in a folder and those below it, and an error for each that cannot be read."""
    files, errors, waiting, seen = [], [], [folder], 0
    while waiting:
        place = waiting.pop()
        try:
            with os.scandir(place) as entries:
                for entry in entries:
                    seen += 1
                    if seen > MOST_ENTRIES:
                        return [_too_many(folder)]
                    if entry.name.startswith("."):
                        continue
                    if entry.is_dir(follow_symlinks=False):
                        waiting.append(entry.path)
                    elif Path(entry.path).is_file():
                        files.append(entry.path)
        except OSError as error:
            errors.append(FileFormatError(place, f"cannot be read ({error.strerror})"))
    return sorted(files) + errors


def _too_many(folder: str) -> FileFormatError:
    return FileFormatError(
        folder, f"holds more than {MOST_ENTRIES} files and folders; name folders in it one by one"
    )
