"""Texts in the letters that the pen has: Latin ones without accents."""

import unicodedata

LETTERS = str.maketrans("øØłŁđĐðı", "oOlLdDdi")
"""Letters that Unicode does not take for accented ones."""

PAIRS = str.maketrans({"ß": "ss", "æ": "ae", "Æ": "Ae", "œ": "oe", "Œ": "Oe", "þ": "th", "Þ": "Th"})
"""Letters that two stand for."""

SIGNS = str.maketrans(
    "\u2010\u2011\u2012\u2013\u2014\u2212\u2018\u2019\u02bb\u201c\u201d\u00b2\u00b3\u00d7\u00b5\u03bc",
    "------'''\"\"23xuu",
)
"""Dashes, quotation marks, small digits, the sign of multiplication, and both signs of millionths."""

OWN = "°"
"""What the pen has besides."""


def plain_letters(text: str) -> str:
    """Return a text as the pen can write it, with question marks for what no letter stands for."""
    if text.isascii():
        return text
    for table in (LETTERS, PAIRS, SIGNS):
        text = text.translate(table)
    kept = (sign for sign in unicodedata.normalize("NFD", text) if not unicodedata.combining(sign))
    return "".join(sign if sign.isascii() or sign in OWN else "?" for sign in kept)
