"""XML from outside: hostile and broken documents are refused, elements know their lines."""

import re

import pytest

from lumenray.engine.errors import FileFormatError
from lumenray.engine.reading import safe_xml
from lumenray.engine.reading.safe_xml import MAXIMUM_DEPTH, parse_xml


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (b"", 1, "not well-formed XML"),
        (b"<a>\n<b></a>", 2, "mismatched tag"),
        (b"<a>\n&nbsp;</a>", 2, "undefined entity"),
        (b'<!DOCTYPE a [\n<!ENTITY b "c">]><a>&b;</a>', 1, "DOCTYPE"),
        (b'<?xml version="1.0"?>\n<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>', 2, "DOCTYPE"),
        (b"<a>" * (MAXIMUM_DEPTH + 1), 1, "nested deeper"),
        (b"<a>" + b"<b/>\n" * 1000, 1000, "more than 1000 XML elements"),
        (b"<a " + b" ".join(b'b%d=""' % i for i in range(99)) + b"/>", 1, "attributes"),
        (b'<?xml version="1.0" encoding="klingon"?><a/>', 1, "unknown encoding"),
    ],
)
def test_hostile_and_broken_xml_is_refused_with_its_line(text, line, words, monkeypatch):
    monkeypatch.setattr(safe_xml, "MAXIMUM_ELEMENTS", 1000)
    with pytest.raises(FileFormatError, match=re.escape(words)) as caught:
        parse_xml(text, "a.xml")
    assert caught.value.line == line


def test_elements_know_their_lines_texts_and_attributes_without_namespaces():
    text = '<x:a xmlns:x="u" xmlns="v">\n one<!-- no -->two\n<b x:c="d">é</b>tail</x:a>'
    for encoding in ("utf-8", "utf-16"):
        root = parse_xml(text.encode(encoding), "a.xml")
        (child,) = root
        assert (root.tag, root.line, root.text.split()) == ("a", 1, ["onetwo"])
        assert (child.tag, child.line, child.get("c"), child.text) == ("b", 3, "d", "é")
        assert child.tail == "tail"
