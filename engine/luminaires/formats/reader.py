"""One door to all formats of luminaires: what a file is, is told by its content."""

import re
from pathlib import Path

from ...errors import FileFormatError
from ...reading.content import read_bytes
from ...reading.remarks import Remark
from ...reading.text import decode, find_encoding
from ...reading.whole_file import write_whole
from .eulumdat.reader import looks_like_eulumdat, parse_eulumdat
from .eulumdat.writer import write_eulumdat
from .lm63.reader import parse_lm63
from .lm63.writer import write_lm63
from .record import LuminaireFile
from .tm33.reader import parse_tm33

KINDS = "IES LM-63 (.ies), EULUMDAT (.ldt) or TM-33 (.xml)"
"""What can be read, for messages."""

_TILT = re.compile(r"^[ \t]*TILT[ \t]*=", re.IGNORECASE | re.MULTILINE)
_IES = re.compile(r"\s*IES(?:NA)?(?:[0-9: \t\r\n]|$)", re.IGNORECASE)
_CIE_102 = re.compile(r"\s*(?:CIEF|CENF)[ \t]*=", re.IGNORECASE)
_TM14 = re.compile(r"\s*(?:CIBSE|TM[ -]?14)\b", re.IGNORECASE)
_WEB_PAGE = re.compile(r"<(?:!doctype\s+html|html|head|body)\b", re.IGNORECASE)

_ARCHIVE = b"PK\x03\x04"

_HEAD = 65536
"""How much of a file is looked at. [byte]"""


def read_luminaire(path) -> LuminaireFile:
    """Read a file of any of the formats; a TILT file of LM-63 may lie beside it.

    Raises
    ------
    FileFormatError    It is of no such format or cannot be read safely; says what was found and what to do.
    """
    path = Path(path)
    return parse_luminaire(read_bytes(path), path, path.parent)


def parse_luminaire(data: bytes, path, folder=None) -> LuminaireFile:
    """Read the content of a file of any of the formats.

    Parameters
    ----------
    data : bytes
    path : str or Path    For messages; its ending decides nothing but how a file of no known format is refused.
    folder : Path or None    Where a TILT file of LM-63 may lie.

    Raises
    ------
    FileFormatError    As of `read_luminaire`.
    """
    text = decode(path, data)
    is_utf16 = find_encoding(data).startswith("utf-16")
    if not is_utf16:
        _refuse_binary(path, data)
    start = text.lstrip()[:_HEAD]
    if _WEB_PAGE.match(start):
        raise FileFormatError(path, f"is a web page, expected {KINDS}; download the file itself")
    if start.startswith("<"):
        return parse_tm33(data if is_utf16 else data.lstrip(b" \t\r\n"), path)
    if _TILT.search(text) or _IES.match(text):
        return parse_lm63(data, path, folder)
    if _CIE_102.match(text):
        raise FileFormatError(
            path, f"is a CIE 102 or EN 13032 file, which is not read; ask the maker for {KINDS}"
        )
    if _TM14.match(text):
        raise FileFormatError(
            path, f"is a CIBSE TM14 file, which is not read; ask the maker for {KINDS}"
        )
    if looks_like_eulumdat(text):
        return parse_eulumdat(data, path)
    parse = {".ldt": parse_eulumdat, ".ies": parse_lm63}.get(Path(path).suffix.lower())
    if parse is not None:
        # Broken at its head; the format's own reader says where.
        return parse(data, path)
    raise FileFormatError(path, f"is no luminaire, expected {KINDS}")


def _refuse_binary(path, data: bytes) -> None:
    if data.startswith(_ARCHIVE):
        if b"product.xml" in data or Path(path).suffix.lower() == ".gldf":
            raise FileFormatError(
                path,
                "is a GLDF container; unpack it like a zip archive and open the .ldt or .ies in it",
            )
        raise FileFormatError(path, f"is a zip archive; unpack it and open the {KINDS} in it")
    head = data[:_HEAD]
    control = sum(head.count(bytes([code])) for code in (*range(9), *range(14, 26), *range(28, 32)))
    if control > 0.02 * len(head) + 8:
        raise FileFormatError(path, f"is a binary file, expected {KINDS}")


def write_luminaire(file: LuminaireFile, path) -> list[Remark]:
    """Write a luminaire as ``.ies`` (LM-63) or ``.ldt`` (EULUMDAT); an existing file is replaced only by a complete one.

    Returns
    -------
    list of Remark    What the format could not keep.

    Raises
    ------
    FileFormatError    Another ending, or the file cannot be written.
    LumenrayError    The luminaire cannot be put into the format.
    """
    path = Path(path)
    remarks: list[Remark] = []
    match path.suffix.lower():
        case ".ldt":
            data, remarks = write_eulumdat(file)
        case ".ies":
            data = write_lm63(file)
        case ending:
            raise FileFormatError(
                path, f"cannot be written: '{ending}' is no format, expected .ies or .ldt"
            )
    with write_whole(path) as stream:
        stream.write(data)
    return remarks
