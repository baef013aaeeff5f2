"""What a reader has to tell people of a file that it could read all the same."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Remark:
    """A departure from the standard and what was assumed, or something that the user should know.

    Parameters
    ----------
    text : str    One sentence for people.
    line : int    Of the file, from 1; 0: of the file as a whole.
    """

    text: str
    line: int = 0

    def __str__(self) -> str:
        return f"line {self.line}: {self.text}" if self.line else self.text
