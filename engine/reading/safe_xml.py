"""XML from strangers: without document types or entities, bounded, and with line numbers for messages."""

from xml.etree import ElementTree
from xml.parsers import expat

from ..errors import FileFormatError
from .content import MAXIMUM_SIZE

MAXIMUM_DEPTH = 64
"""Deepest nesting of elements."""

MAXIMUM_ELEMENTS = 1_000_000
"""Most elements."""

MAXIMUM_ATTRIBUTES = 64
"""Most attributes of an element."""


class XmlElement(ElementTree.Element):
    """An element whose tag and attributes carry no namespace; ``line`` is where it begins, from 1."""

    line = 0


def parse_xml(data: bytes, path) -> XmlElement:
    """Parse a document and return its root.

    Parameters
    ----------
    data : bytes    In UTF-8, UTF-16, Latin-1 or what its declaration says.
    path : str or Path    For messages.

    Returns
    -------
    XmlElement    Namespaces are left out of all names; comments and processing instructions too.

    Raises
    ------
    FileFormatError    It is not well-formed, declares a document type (so that no entity can grow or fetch anything), or is
        larger or deeper than any sensible file; with the line.
    """
    if len(data) > MAXIMUM_SIZE:
        raise FileFormatError(
            path, f"has {len(data) >> 20} MiB, expected at most {MAXIMUM_SIZE >> 20} MiB"
        )
    builder = _Builder(path)
    try:
        builder.parser.Parse(data, True)
    except expat.ExpatError as error:
        text = expat.ErrorString(error.code)
        raise FileFormatError(path, f"is not well-formed XML ({text})", error.lineno) from None
    except (LookupError, ValueError) as error:
        # An encoding that Python lacks or that is not of single bytes.
        raise FileFormatError(path, f"is XML in an unknown encoding ({error})", 1) from None
    return builder.root


class _Builder:
    """Makes the tree from what the parser reports."""

    def __init__(self, path):
        self.root = None
        self.parser = expat.ParserCreate(namespace_separator="}")
        self.parser.buffer_text = True
        self.parser.StartDoctypeDeclHandler = self._doctype
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._text
        self._path = path
        self._open: list[XmlElement] = []
        self._last: XmlElement | None = None
        self._pieces: list[str] = []
        self._count = 0

    def _fail(self, message):
        raise FileFormatError(self._path, message, self.parser.CurrentLineNumber)

    def _doctype(self, *_):
        self._fail("declares a document type (DOCTYPE), which is refused; delete the declaration")

    def _start(self, name, attributes):
        self._count += 1
        if len(self._open) >= MAXIMUM_DEPTH:
            self._fail(f"XML elements nested deeper than {MAXIMUM_DEPTH}")
        if self._count > MAXIMUM_ELEMENTS:
            self._fail(f"more than {MAXIMUM_ELEMENTS} XML elements")
        if len(attributes) > MAXIMUM_ATTRIBUTES:
            self._fail(f"an XML element with more than {MAXIMUM_ATTRIBUTES} attributes")
        element = XmlElement(
            name.rpartition("}")[2],
            {key.rpartition("}")[2]: value for key, value in attributes.items()},
        )
        element.line = self.parser.CurrentLineNumber
        self._flush()
        if self._open:
            self._open[-1].append(element)
        else:
            self.root = element
        self._open.append(element)
        self._last = None

    def _end(self, _):
        self._flush()
        self._last = self._open.pop()

    def _text(self, text):
        self._pieces.append(text)

    def _flush(self):
        """Give the text so far to the element that has just begun, or as its tail to the one that has just ended."""
        if not self._pieces:
            return
        text = "".join(self._pieces)
        self._pieces.clear()
        if self._last is not None:
            self._last.tail = text
        elif self._open:
            self._open[-1].text = text
