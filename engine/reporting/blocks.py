"""Pieces of a document: what is written, without how it looks in a kind of file."""

from dataclasses import dataclass, field

from PIL import Image

from ..analysis.sheet import Sheet
from ..judgement.verdict import State


@dataclass(frozen=True)
class Heading:
    """A title of level 1 (a chapter, which begins a page), 2 or 3."""

    level: int
    text: str


@dataclass(frozen=True)
class Text:
    """A paragraph; ``is_note``: in small letters."""

    text: str
    is_note: bool = False


@dataclass(frozen=True)
class Points:
    """Sentences one below the other."""

    lines: tuple[str, ...]


@dataclass(frozen=True)
class Facts:
    """Labels and values."""

    lines: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Cell:
    """A text of a table; ``state``: the verdict that it tells."""

    text: str
    state: State | None = None


@dataclass(frozen=True)
class Table:
    """Rows of cells below a head.

    Parameters
    ----------
    head : tuple of str
    rows : tuple of tuple of (str or Cell)
    widths : tuple of float    Shares of the width, by column.
    texts : int    How many columns at the left are texts; of the others those without a `Cell` are numbers, at the right.
    is_small : bool    Whether it has many numbers.
    """

    head: tuple[str, ...]
    rows: tuple[tuple[str | Cell, ...], ...]
    widths: tuple[float, ...]
    texts: int = 1
    is_small: bool = False

    @property
    def numbers(self) -> tuple[bool, ...]:
        """Whether each column holds numbers."""
        columns = zip(*self.rows, strict=True) if self.rows else ((),) * len(self.head)
        return tuple(
            k >= self.texts and not any(isinstance(cell, Cell) for cell in column)
            for k, column in enumerate(columns)
        )


@dataclass(frozen=True, eq=False)
class Figure:
    """A picture with what it shows; ``width``: share of that of the page."""

    picture: Image.Image | Sheet
    caption: str
    width: float = 1.0


@dataclass(frozen=True, eq=False)
class Beside:
    """Blocks on the left and on the right; ``share``: of the width, that the left ones have."""

    left: tuple
    right: tuple
    share: float = 0.5


@dataclass(frozen=True, eq=False)
class Document:
    """Blocks of a document with its cover.

    Parameters
    ----------
    title, kind : str    What it is of, and what it is.
    facts : tuple of (str, str)    Of the cover.
    footer : str    Of every page.
    blocks : list
    """

    title: str
    kind: str
    facts: tuple[tuple[str, str], ...]
    footer: str
    blocks: list = field(default_factory=list)
