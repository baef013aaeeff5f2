"""Text data-blocks that hold files: bytes as base64 below a line with their SHA-256, which is checked at each reading."""

import base64
import binascii
import re

import bpy

from ...engine.errors import FileFormatError
from .places import digest_of

LINE = 76
"""Characters in a line."""

HEAD = "# Lumenray packed {noun}, from {origin}, SHA-256 {digest}"
"""First line: what kind of file it is, the format that it was made of, and its hash."""


def new_text(name: str, content: str):
    """Return a new text data-block, which goes when nothing uses it."""
    text = bpy.data.texts.new(name)
    text.use_fake_user = False
    text.from_string(content)
    return text


def head_of(text) -> str:
    """First line of a text data-block."""
    return text.lines[0].body if len(text.lines) else ""


def stated_digest(head: str, noun: str) -> str:
    """Return the hash that a first line states, empty if it is none."""
    found = _match(head, noun)
    return found[2] if found else ""


def wrap(data: bytes, noun: str, origin: str) -> str:
    """Return a content as text; ``origin``: the format that it was made of."""
    coded = base64.b64encode(data).decode("ascii")
    lines = [coded[k : k + LINE] for k in range(0, len(coded), LINE)]
    words = " ".join(origin.split())[:200]
    return "\n".join([HEAD.format(noun=noun, origin=words, digest=digest_of(data)), *lines])


def unwrap(text: str, noun: str, name: str) -> tuple[bytes, str]:
    """Return the content of a text, and the format that it was made of; ``name`` is for messages.

    Raises
    ------
    FileFormatError    It is none, or not what was wrapped.
    """
    head, *lines = text.split("\n")
    found = _match(head, noun)
    if found is None:
        raise FileFormatError(
            name, f"is no embedded {noun}, expected a first line that says so; open the file anew", 1
        )  # fmt: skip
    try:
        data = base64.b64decode("".join(lines), validate=True)
    except (binascii.Error, ValueError) as error:
        raise FileFormatError(
            name, f"is no base64 text below its first line ({error}); open the file anew"
        ) from None
    digest = digest_of(data)
    if digest != found[2]:
        raise FileFormatError(
            name,
            f"was changed since it was embedded: its SHA-256 is {digest[:12]}…, expected {found[2][:12]}…; open the file "
            "anew",
        )
    return data, found[1]


def _match(head: str, noun: str) -> re.Match | None:
    return re.fullmatch(HEAD.format(noun=noun, origin="(.{0,200})", digest="([0-9a-f]{64})"), head)
