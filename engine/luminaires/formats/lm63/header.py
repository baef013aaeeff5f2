"""Head of an LM-63 file: its edition, the keywords and the TILT line."""

import re
from dataclasses import dataclass, field

from ....errors import FileFormatError
from ....reading.remarks import Remark

FIRST_LINES = {
    "IESNA91": 1991,
    "IESNA:LM-63-1995": 1995,
    "IESNA:LM-63-2002": 2002,
    "IES:LM-63-2019": 2019,
}
"""First line of each edition; that of 1986 has none."""

REQUIRED = ("TEST", "TESTLAB", "ISSUEDATE", "MANUFAC")
"""Keywords that each file must have since 2002."""

KEYWORDS = {
    *REQUIRED,
    *("LUMCAT", "LUMINAIRE", "LAMPCAT", "LAMP", "BALLAST", "BALLASTCAT", "TESTDATE", "MAINTCAT"),
    *("DISTRIBUTION", "FLASHAREA", "COLORCONSTANT", "LAMPPOSITION", "NEARFIELD", "FILEGENINFO"),
    *("SEARCH", "OTHER", "LUMINOUSGEOMETRY", "BLOCK", "ENDBLOCK"),
}
"""Keywords of the standard; other ones begin with an underscore."""

LABEL = "label"
"""Key under which lines without a keyword are kept."""

GENERATION_TYPE = "file generation type"
"""Key of the metadata for what LM-63-2019 tells by the number behind the ballast factor."""

TILT_LINE = re.compile(r"\s*TILT\s*=(.*)", re.IGNORECASE)
"""The line that ends the head."""

_VERSION = re.compile(
    r"\s*IES(?:NA)?[\s:]*(?:LM[\s-]?63[\s-]?)?(?:(?:19)?(86|91|95)|(?:20)?(02|19))(?!\d)",
    re.IGNORECASE,
)

_KEYWORD = re.compile(r"\s*\[([^\]]*)\](.*)")


@dataclass
class Header:
    """What stands before the numbers.

    Parameters
    ----------
    year : int    Of the edition.
    tilt : str    ``NONE``, ``INCLUDE`` or the name of a file.
    tilt_line : int    Where it stands, from 1.
    metadata : dict of str to str    As of `LuminaireFile`.
    """

    year: int
    tilt: str
    tilt_line: int
    metadata: dict[str, str] = field(default_factory=dict)


def read_header(path, lines: list[str], remarks: list[Remark]) -> Header:
    """Read the lines up to the TILT line.

    Parameters
    ----------
    path : str or Path    For messages.
    lines : list of str    Of the whole file.
    remarks : list of Remark    Departures are added.

    Raises
    ------
    FileFormatError    There is no TILT line, so this is no LM-63 file.
    """
    found = ((row, TILT_LINE.match(line)) for row, line in enumerate(lines))
    end, tilt = next(((row, match) for row, match in found if match), (None, None))
    if tilt is None:
        raise FileFormatError(path, "is not an IES LM-63 file: it has no line TILT=…", len(lines))
    year, first = _edition(lines[:end], remarks)
    header = Header(year, _tilt(path, lines[end], tilt[1].strip(), end + 1, remarks), end + 1)
    strange = _read_keywords(header, lines[first:end], first + 1, remarks)
    if year >= 2002:
        present = {key.upper() for key in header.metadata}
        missing = [f"[{key}]" for key in REQUIRED if key not in present]
        if missing:
            remarks.append(Remark(f"lacks the required keywords {', '.join(missing)}"))
        if strange:
            names = ", ".join(f"[{key[:40]}]" for key in list(strange)[:8])
            line = next(iter(strange.values()))
            text = f"keywords that LM-63 does not know are kept: {names}"
            remarks.append(Remark(text, line))
    _remark_on_form(lines, end, year, remarks)
    _remark_on_content(header, remarks)
    return header


def _tilt(path, line, value, number, remarks) -> str:
    """What the TILT line means."""
    if not value:
        raise FileFormatError(path, "TILT= is empty, expected NONE, INCLUDE or a file name", number)
    word = value.split()[0].upper()
    meaning = word if word in {"NONE", "INCLUDE"} else value.strip("\"'")
    if line.rstrip() != f"TILT={meaning}":
        text = f"found '{line.strip()[:40]}', read as TILT={meaning[:40]}"
        remarks.append(Remark(text, number))
    return meaning


def _edition(lines, remarks) -> tuple[int, int]:
    """Year of the edition, and how many lines tell it."""
    row = next((row for row, line in enumerate(lines) if line.strip()), None)
    if row is None:
        return 1986, 0
    text = lines[row].strip()
    has_keywords = any(_KEYWORD.match(line) for line in lines)
    match = _VERSION.match(text)
    if match:
        two_digits = int(match[1] or match[2])
        year = two_digits + (1900 if match[1] else 2000)
        if FIRST_LINES.get(text) != year or row:
            official = next((line for line, of in FIRST_LINES.items() if of == year), "none")
            text = f"the first line is '{text[:40]}' instead of {official}, read as LM-63-{year}"
            remarks.append(Remark(text, row + 1))
        return year, row + 1
    if text.upper().startswith("IES") and (has_keywords or "LM-63" in text.upper()):
        text = f"the first line '{text[:40]}' names no known edition, read as LM-63-2002"
        remarks.append(Remark(text, row + 1))
        return 2002, row + 1
    if has_keywords:
        remarks.append(Remark("the line of the edition is missing, read as LM-63-2002", 1))
        return 2002, 0
    return 1986, 0


def _read_keywords(header, lines, first_line, remarks) -> dict[str, int]:
    """Fill in the metadata; return the line of each keyword that is neither the standard's nor a user's."""
    metadata, strange = {}, {}
    key, stray = None, None
    for number, line in enumerate(lines, first_line):
        if not line.strip():
            continue
        match = _KEYWORD.match(line)
        name = match[1].strip() if match else None
        text = (match[2] if match else line).strip()
        if name is None:
            stray = stray or number
            name = LABEL
        elif name.upper() != "MORE":
            key = name
            if key.upper() not in KEYWORDS and not key.startswith("_"):
                strange.setdefault(key, number)
        elif key is None:
            stray = stray or number
            name = LABEL
        else:
            name = key
        metadata.setdefault(name, []).append(text)
    if stray and header.year > 1986:
        remarks.append(Remark("lines that belong to no keyword are kept as labels", stray))
    header.metadata = {name: "\n".join(texts) for name, texts in metadata.items()}
    return strange


def _remark_on_form(lines, end, year, remarks):
    """Remark on lines that are too long and on text that is not ASCII."""
    before, after = (80, 132) if year < 2002 else (255, 255)
    too_long = [
        row
        for row, line in enumerate(lines)
        if len(line.rstrip()) > (before if row <= end else after)
    ]
    if too_long:
        row = too_long[0]
        others = f" (and {len(too_long) - 1} lines more)" if too_long[1:] else ""
        text = f"a line of {len(lines[row].rstrip())} characters{others}, longer than LM-63-{year} allows"
        remarks.append(Remark(text, row + 1))
    row = next((row for row, line in enumerate(lines) if not line.isascii()), None)
    if row is not None:
        remarks.append(Remark("characters that are not ASCII, read as UTF-8 or Latin-1", row + 1))


def _remark_on_content(header, remarks):
    metadata = header.metadata
    if any(key.upper() == "NEARFIELD" for key in metadata):
        remarks.append(Remark("near-field photometry, used as if it were far-field"))
