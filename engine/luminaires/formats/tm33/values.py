"""Elements of TM-33 documents as texts and numbers."""

from ....errors import FileFormatError
from ....reading.remarks import Remark
from ....reading.safe_xml import XmlElement
from ....reading.text import parse_number


def text_of(element, *names: str) -> str:
    """Text of the first child that has one of the names (or paths) and a text; empty if there is none."""
    for name in names:
        found = element.find(name) if element is not None else None
        if found is not None and found.text and found.text.strip():
            return " ".join(found.text.split())
    return ""


def key_of(text: str) -> str:
    """A keyword in small letters without the blanks and underscores that differ between editions."""
    return "".join(text.split()).replace("_", "").casefold()


def number_in(path, element: XmlElement, what: str) -> float:
    """Return the number in an element.

    Raises
    ------
    FileFormatError    There is none; with the line.
    """
    value = parse_number((element.text or "").strip())
    if value is None:
        raise FileFormatError(
            path, f"expected {what}, a number, found '{_short(element.text)}'", element.line
        )
    return value


def attribute(path, element: XmlElement, *names: str) -> float:
    """Return the number in the first of several attributes that is there.

    Raises
    ------
    FileFormatError    None is there, or it holds no number; with the line.
    """
    for name in names:
        text = element.get(name)
        if text is None:
            continue
        value = parse_number(text.strip())
        if value is None:
            raise FileFormatError(
                path,
                f"expected a number as {name} of {element.tag}, found '{_short(text)}'",
                element.line,
            )
        return value
    raise FileFormatError(path, f"{element.tag} has no attribute {names[0]}", element.line)


def optional_number(element, name: str, remarks, least: float = 0.0) -> float | None:
    """Return the number in a child that only informs; None, with a remark, if it holds none or is less than allowed."""
    found = element.find(name) if element is not None else None
    if found is None or not (found.text or "").strip():
        return None
    value = parse_number(found.text.strip())
    if value is None or value < least:
        text = f"'{_short(found.text)}' as {found.tag}, expected a number from {least:g}; not used"
        remarks.append(Remark(text, found.line))
        return None
    return value


def _short(text) -> str:
    text = " ".join((text or "").split())
    return text if len(text) <= 40 else text[:40] + "..."
