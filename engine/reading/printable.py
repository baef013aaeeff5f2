"""Text from files as it may be shown: without what a terminal or a panel would take for a command."""

import unicodedata

REPLACEMENT = "\N{REPLACEMENT CHARACTER}"
"""Stands for a character that is not shown."""

_KEPT = "\n\t"

_REORDERING = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
"""Marks that turn the order of the characters around them, so that a text reads as another one."""


def printable(text: str) -> str:
    """Return the text with a replacement character for every control character but line feeds and tabs.

    Among them are the escapes that clear a terminal, rename its window or colour what follows (ECMA-48), and marks that
    reorder text; half characters, which no encoding can write, go as well.
    """
    if text.isprintable():
        return text
    return "".join(map(_shown, text))


def _shown(character: str) -> str:
    if character in _KEPT:
        return character
    is_odd = character in _REORDERING or unicodedata.category(character) in {"Cc", "Cs"}
    return REPLACEMENT if is_odd else character
