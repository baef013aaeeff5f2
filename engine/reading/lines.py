"""Lines of text files of any size, one after the other."""

import io
from collections.abc import Iterator

from ..errors import FileFormatError
from .content import open_file, size_of
from .text import LOOKED_AT, MARK, find_encoding


def read_lines(path, longest: int) -> Iterator[tuple[int, str]]:
    """Yield the lines of a file with their numbers from 1, ends included.

    Their beginning tells the encoding; what is no text of it is replaced. No more is read than the file held when it was
    opened, should it grow.

    Parameters
    ----------
    path : str or Path
    longest : int    Characters that a line may have.

    Raises
    ------
    FileFormatError    As of `content.open_file`, or a line is longer.
    """
    with open_file(path) as opened:
        held = io.BufferedReader(_Beginning(opened, size_of(opened)), 1 << 20)
        head = held.peek()[:LOOKED_AT]
        encoding = find_encoding(head, len(head) == size_of(opened))
        # Line ends of all systems count, and stay.
        text = io.TextIOWrapper(held, encoding=encoding, errors="replace", newline="")
        number = 0
        while line := text.readline(longest + 1):
            number += 1
            if len(line) > longest:
                raise FileFormatError(path, f"has more than {longest} characters", number)
            yield number, line.removeprefix(MARK) if number == 1 else line


class _Beginning(io.RawIOBase):
    """The first so many bytes of a file."""

    def __init__(self, file, size: int):
        self._file = file
        self._left = size

    def readable(self) -> bool:
        return True

    def readinto(self, buffer) -> int:
        data = self._file.read(min(len(buffer), self._left))
        buffer[: len(data)] = data
        self._left -= len(data)
        return len(data)
